"""The options of every command that reads a program for a machine."""

from __future__ import annotations

import argparse

from postproc.commands import values


def arguments(parser: argparse.ArgumentParser, several: bool = False) -> None:
    """The options that say for which machine, how, and in which language: shared by all that read
    programs. several: whether they may be read for more than one machine."""
    machine = "a machine by name (gcomp machines) or by the path of its folder"
    if several:
        values.repeated(parser, "--machine", metavar="NAME", help=machine)
    else:
        parser.add_argument("--machine", metavar="NAME", help=machine)
    how = parser.add_argument_group("how it is corrected")
    how.add_argument(
        "--tolerance",
        metavar="LENGTH",
        type=values.tolerance,
        help=(
            "how far the path may stay off: 0.5um, 0.001mm (default: one least increment, 0.5um at"
            " least)"
        ),
    )
    how.add_argument(
        "--hole-tolerance",
        metavar="LENGTH",
        type=values.hole_tolerance,
        help=(
            "how far the axis of a hole or tap may bend while its cycle stays (default: 5um;"
            " --tolerance at least; with --expand 0 writes every drilling cycle out)"
        ),
    )
    how.add_argument(
        "--hysteresis",
        metavar="LENGTH",
        type=values.tolerance,
        help=(
            "how far a slide's wanted place may turn back before its lost motion is taken up "
            "(default: the machine's, or 1um)"
        ),
    )
    how.add_argument(
        "--orientation",
        action="store_true",
        help=(
            "correct the rotary words too, for the tool's lean, in programs of the tool tip (G43.4,"
            " TRAORI, M128)"
        ),
    )
    how.add_argument(
        "--reversal",
        choices=("mean", "step", "ramp", "off"),
        help="what to do where an axis turns back (default: the machine's, or step)",
    )
    how.add_argument(
        "--ramp",
        metavar="LENGTH",
        type=values.length,
        help="travel over which --reversal ramp takes up the difference",
    )
    how.add_argument(
        "--outside",
        choices=("error", "clamp"),
        help="points outside the error tables: refuse, or hold the end value",
    )
    how.add_argument(
        "--temperature",
        metavar="Z=24.1,work=21",
        type=values.temperatures,
        default={},
        help=(
            "temperatures of scales or screws, and of the work, degrees Celsius, for machines that"
            " state how they grow"
        ),
    )
    how.add_argument(
        "--only",
        metavar="EXX,EZZ",
        type=_names,
        default=(),
        help=(
            "correct for these components, squareness (C0Y) and effects (backlash:X) of the map"
            " alone"
        ),
    )
    how.add_argument("--cut-rapids", action="store_true", help="cut G0 at the map's nodes too")
    heat = parser.add_argument_group("how warm it is while it runs")
    heat.add_argument(
        "--temperatures",
        metavar="LOG.csv",
        help=(
            "a log of thermometers: each block meets the temperature of its moment, by the"
            " program's own clock"
        ),
    )
    heat.add_argument(
        "--log-begin",
        metavar="TIME",
        help=(
            "when in the log the program begins: its seconds, or a date and time (default: its"
            " first row)"
        ),
    )
    heat.add_argument(
        "--pace",
        metavar="FACTOR",
        type=values.factor,
        default=1.0,
        help=(
            "by which factor the machine takes longer than feeds, rapids and dwells say"
            " (default: 1)"
        ),
    )
    heat.add_argument(
        "--hold-temperature",
        action="store_true",
        help="hold the log's last row for what is executed behind it, instead of refusing it",
    )
    program = parser.add_argument_group("how the program is read")
    program.add_argument(
        "--dialect",
        metavar="NAME",
        help=(
            "the control's language, if not the machine's own; auto: by what the program looks like"
        ),
    )
    values.repeated(
        program,
        "--offset",
        metavar="G54=X1,Z2",
        type=values.offset,
        help="where a work or tool offset's zero lies, mm, radius, machine coordinates",
    )
    values.repeated(
        program,
        "--offsets",
        metavar="FILE",
        help=(
            "work and tool offsets from a file of the control: LinuxCNC var file or tool table,"
            " Fanuc G10 dump, Siemens, GRBL $#, or a CSV table"
        ),
    )
    program.add_argument(
        "--offsets-unit",
        choices=("mm", "inch"),
        help="the unit of --offsets, where the file does not say",
    )
    program.add_argument(
        "--offsets-x",
        choices=("radius", "diameter"),
        help="what X of --offsets is, where the file does not say",
    )
    program.add_argument(
        "--integers", choices=("units", "least-increments"),
        help="what a coordinate without a decimal point counts, if not as usual on the control",
    )  # fmt: skip
    program.add_argument(
        "--expand",
        action=argparse.BooleanOptionalAction,
        default=None,
        help=(
            "write loops, subprograms, variables, cycles and turned coordinates out as plain"
            " blocks, and correct those; without either, gcomp FILE does so where nothing else"
            " corrects the program, and says so"
        ),
    )
    values.repeated(
        program,
        "--library",
        metavar="DIR",
        help="a folder with subprograms for --expand",
    )
    program.add_argument(
        "--max-steps", type=int, default=10_000_000, help="lines that --expand executes at most"
    )
    program.add_argument(
        "--max-depth", type=int, default=50, help="calls that --expand nests at most"
    )
    program.add_argument(
        "--start",
        metavar="X0,Z0",
        type=values.place,
        default={},
        help=(
            "where the machine stands before the program, mm, radius, machine coordinates; on"
            " printers and routers behind G28 too, if machine.toml states no home"
        ),
    )
    program.add_argument(
        "--block-delete",
        choices=("on", "off"),
        help="whether blocks that begin with / are skipped at the machine (default: off)",
    )
    program.add_argument(
        "--arc-centre",
        choices=("incremental", "absolute"),
        default="incremental",
        help="what I J K mean when no G90.1 or G91.1 says so",
    )


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())
