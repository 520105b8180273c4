"""What every command that reads programs must be told: which machine, in which language, and where the zeros lie."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from postproc import ports
from postproc.commands import values
from postproc.errors import GcompError, Notice, ProgramError, UsageError
from postproc.machine import part
from postproc.units import UM

if TYPE_CHECKING:
    from postproc.filter import Filter
    from postproc.machine.model import Machine
    from postproc.nc.dialects import Dialect

AUTO = "auto"
LARGEST_OFFSETS = 10_000_000  # bytes


def arguments(parser: argparse.ArgumentParser, several: bool = False) -> None:
    """The options that say for which machine, how, and in which language: shared by all that read programs. several:
    whether they may be read for more than one machine."""
    machine = "a machine by name (gcomp machines) or by the path of its folder"
    if several:
        parser.add_argument(
            "--machine", metavar="NAME", action="append", default=[], help=f"{machine}; repeatable"
        )
    else:
        parser.add_argument("--machine", metavar="NAME", help=machine)
    how = parser.add_argument_group("how it is corrected")
    how.add_argument(
        "--tolerance",
        metavar="LENGTH",
        type=values.tolerance,
        help="how far the path may stay off: 0.5um, 0.001mm (default: one least increment, 0.5um at least)",
    )
    how.add_argument(
        "--hole-tolerance",
        metavar="LENGTH",
        type=values.hole_tolerance,
        help="how far the axis of a hole or tap may bend while its cycle stays (default: 5um; --tolerance at least; "
        "with --expand 0 writes every drilling cycle out)",
    )
    how.add_argument(
        "--hysteresis",
        metavar="LENGTH",
        type=values.tolerance,
        help="how far a slide's wanted place may turn back before its lost motion is taken up "
        "(default: the machine's, or 1um)",
    )
    how.add_argument(
        "--orientation",
        action="store_true",
        help="correct the rotary words too, for the tool's lean, in programs of the tool tip (G43.4, TRAORI, M128)",
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
        "--temperature", metavar="Z=24.1,work=21", type=values.temperatures, default={},
        help="temperatures of scales or screws, and of the work, degrees Celsius, for machines that state how they grow",
    )  # fmt: skip
    how.add_argument(
        "--only", metavar="EXX,EZZ", type=_names, default=(),
        help="correct for these components, squareness (C0Y) and effects (backlash:X) of the map alone",
    )  # fmt: skip
    how.add_argument("--cut-rapids", action="store_true", help="cut G0 at the map's nodes too")
    heat = parser.add_argument_group("how warm it is while it runs")
    heat.add_argument(
        "--temperatures", metavar="LOG.csv", help="a log of thermometers: each block meets the temperature of its moment, by the program's own clock"
    )  # fmt: skip
    heat.add_argument(
        "--log-begin", metavar="TIME", help="when in the log the program begins: its seconds, or a date and time (default: its first row)"
    )  # fmt: skip
    heat.add_argument(
        "--pace", metavar="FACTOR", type=values.factor, default=1.0,
        help="by which factor the machine takes longer than feeds, rapids and dwells say (default: 1)",
    )  # fmt: skip
    heat.add_argument(
        "--hold-temperature", action="store_true", help="hold the log's last row for what is executed behind it, instead of refusing it"
    )  # fmt: skip
    program = parser.add_argument_group("how the program is read")
    program.add_argument(
        "--dialect",
        metavar="NAME",
        help="the control's language, if not the machine's own; auto: by what the program looks like",
    )
    program.add_argument(
        "--offset",
        metavar="G54=X1,Z2",
        action="append",
        default=[],
        type=values.offset,
        help="where a work or tool offset's zero lies, mm, radius, machine coordinates; repeatable",
    )
    program.add_argument(
        "--offsets", metavar="FILE", action="append", default=[],
        help="work and tool offsets from a file of the control: LinuxCNC var file or tool table, Fanuc G10 dump, Siemens, "
        "GRBL $#, or a CSV table; repeatable",
    )  # fmt: skip
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
        "--expand", action=argparse.BooleanOptionalAction, default=None,
        help="write loops, subprograms, variables, cycles and turned coordinates out as plain blocks, and correct those; "
        "without either, gcomp FILE does so where nothing else corrects the program, and says so",
    )  # fmt: skip
    program.add_argument(
        "--library",
        metavar="DIR",
        action="append",
        default=[],
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
        help="where the machine stands before the program, mm, radius, machine coordinates; on printers and routers "
        "behind G28 too, if machine.toml states no home",
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


def machine_of(options: argparse.Namespace) -> Machine:
    """The machine that --machine names. Raises UsageError with the names that there are."""
    from postproc.machine import places

    if not options.machine:
        names = ", ".join(places.every()) or "none found"
        raise UsageError(
            "--machine is missing: for which machine?",
            f"machines: {names}; or the path of a machine folder",
        )
    machine = warmed(
        with_control_tables(places.load(options.machine)), getattr(options, "temperature", {})
    )
    return _part(machine, options.only) if getattr(options, "only", ()) else machine


def _part(machine: Machine, only: tuple[str, ...]) -> Machine:
    """What --only names of a map. Raises UsageError for a name that it does not hold."""
    there = part.names(machine)
    for name in only:
        if name not in there and name not in {n.partition(":")[0] for n in there if ":" in n}:
            raise UsageError(f"--only {name}: the map of {machine.name} has no {name}", f"it has {', '.join(there) or 'nothing'}")  # fmt: skip
    return part.only(machine, only)


def left_by_only(options: argparse.Namespace) -> str:
    """What --only leaves of the map, in words; empty without it."""
    if not options.only:
        return ""
    whole = argparse.Namespace(**(vars(options) | {"only": ()}))
    machine, chosen = machine_of(whole), machine_of(options)
    left = [name for name in part.names(machine) if name not in part.names(chosen)]
    return (
        f"only {', '.join(options.only)} of the map is corrected (--only); {', '.join(left) or 'nothing'} stays, up to "
        f"{part.largest_left(machine, chosen) / UM:.1f} um on its nodes"
    )


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def with_control_tables(machine: Machine) -> Machine:
    """The machine as it moves with the control's own tables as they are at work: what a table does that was off while the
    map was measured is taken out of it, and what one did that is off now is put back."""
    from postproc import control_tables
    from postproc.machine.model import EffectTerm
    from postproc.machine.tables import COMPONENTS, AxisTable
    from postproc.recordings import Source

    terms = []
    for table in machine.control_tables:
        if table.active == table.measured or table.file is None:
            continue
        extra = dict(table.more) | ({"axis": table.axis} if table.axis else {})
        if table.settings is not None:
            extra |= {
                "settings": table.settings.read_text("utf-8"),
                "settings_name": str(table.settings),
            }
        source = Source(str(table.file), table.file.read_bytes())
        sign = -1.0 if table.active else 1.0
        added = []
        for found in control_tables.load(table.control).read(
            source, control_tables.ExportOptions(extra=extra)
        ):
            if found.moving not in machine.axes or found.along not in machine.axes:
                continue
            # One point holds everywhere, as two do that say the same.
            nodes = found.nodes if len(found.nodes) > 1 else found.nodes[0] + np.array([0.0, 1.0])
            both = np.zeros((2, 6, len(nodes)))
            both[:, COMPONENTS.index(f"E{found.along}")] = sign * np.stack(
                [found.forward, found.reverse]
            )
            added.append(AxisTable(found.moving, nodes, both[0], both[1]))
        terms.append(
            EffectTerm(
                f"{table.control} table {'on' if table.active else 'off'}",
                "",
                {},
                None,
                tuple(added),
            )
        )
    return replace(machine, effects=machine.effects + tuple(terms)) if terms else machine


def warmed(machine: Machine, temperatures: dict[str, float]) -> Machine:
    """The machine at other temperatures. Raises UsageError where it does not say how it grows."""
    grows = [x for x, axis in machine.axes.items() if axis.expansion is not None]
    for name in temperatures:
        if not grows or (name != "work" and name not in grows):
            raise UsageError(
                f"--temperature names {name}, and {machine.name} does not say how {'anything' if not grows else name} grows",
                "heat = { scale_um_m_K = 11.5, scale_C = 20.0, work_um_m_K = 11.5, work_C = 20.0, fixed_mm = 0.0 } in its [axes] section",
            )
    return machine.at_temperatures(temperatures) if temperatures else machine


def filter_of(options: argparse.Namespace, machine: Machine, head: bytes = b"") -> Filter:
    """A filter as the options want it; `head`: how the program begins, for --dialect auto."""
    from postproc.compensate import Options
    from postproc.filter import Filter, setup_of

    notices: list[Notice] = []
    dialect = _dialect(options, machine, head, notices)
    machine = machine.carrying(dialect.carried)
    offsets = _from_files(options, machine, notices)
    offsets.update(dict(options.offset))
    for name, place in [
        *((f"--offset {n}", p) for n, p in options.offset),
        ("--start", options.start),
    ]:
        for axis in place:
            if axis not in machine.axes and not (axis in "RQ" and name != "--start"):
                raise UsageError(
                    f"{name} names {axis}, which is no axis of {machine.name}",
                    f"its axes are {' '.join(machine.letters)}",
                )
    setup = setup_of(
        machine, offsets, options.start, options.block_delete == "on", options.arc_centre,
        (options.integers or "").replace("-", " "),
    )  # fmt: skip
    how = Options(
        options.tolerance, options.outside, options.reversal, options.ramp, options.cut_rapids,
        hole_tolerance=options.hole_tolerance, hysteresis=options.hysteresis, orientation=options.orientation,
    )  # fmt: skip
    followed = None
    if getattr(options, "temperatures", None):
        from postproc.commands import warming

        machine, followed = warming.of(options, machine, dialect, notices)
    filter_ = Filter(machine, dialect, setup, how, heat=followed)
    filter_.notices += notices
    return filter_


def dialect_of(options: argparse.Namespace, machine: Machine, head: bytes) -> Dialect:
    """The dialect in which a program is read. Raises UsageError."""
    return _dialect(options, machine, head, [])


def _dialect(
    options: argparse.Namespace, machine: Machine, head: bytes, notices: list[Notice]
) -> Dialect:
    from postproc.nc import dialects

    if options.dialect != AUTO:
        name = options.dialect or machine.control
        if not options.dialect and name not in dialects.names():
            raise UsageError(
                f"the control of {machine.name} is {name!r}, and there is no dialect of that name",
                f"say --dialect; dialects: {', '.join(dialects.names())}",
            )
        return dialects.load(name)
    if options.unbuffered if hasattr(options, "unbuffered") else False:
        raise UsageError(
            "--dialect auto looks at the program before it is read: not with --unbuffered"
        )
    from postproc.nc.recognise import recognise

    found = recognise(head)
    if not found:
        raise UsageError(
            "the program does not show which control it is for",
            f"say --dialect {' or '.join(dialects.names())}",
        )
    name, evidence = found[0]
    others = [n for n, e in found[1:] if len(e) == len(evidence)]
    if machine.control in (name, *others):
        name = machine.control
    why = "; ".join(evidence[:3]) or "nothing speaks against it"
    also = f" (it could be {', '.join(others[:3])} too)" if others else ""
    notices.append(Notice("dialect", f"read as {name}: {why}{also}"))
    return dialects.load(name)


def _from_files(
    options: argparse.Namespace, machine: Machine, notices: list[Notice]
) -> dict[str, dict[str, float]]:
    """Offsets of all --offsets files, the last one wins."""
    from postproc import offsets

    result: dict[str, dict[str, float]] = {}
    for path in options.offsets:
        inch = None if options.offsets_unit is None else options.offsets_unit == "inch"
        diameter = None if options.offsets_x is None else options.offsets_x == "diameter"
        text = ports.read_whole(Path(path), LARGEST_OFFSETS)
        found = offsets.read(text, path, inch=inch, diameter=diameter).of(machine.letters)
        for name, degrees in found.rotation.items():
            if degrees:
                raise UsageError(
                    f"{path}: {name} is turned by {degrees:g} degrees, and the error map is not",
                    "take the rotation out of the work offset, and turn the program in CAM",
                )
        result.update(found.work)
        result.update(found.tools)
        notices += [
            Notice(f"offsets {path} {i}", f"{path}: {text}") for i, text in enumerate(found.notices)
        ]
    return result


def with_hint(
    error: ProgramError, dialect: Dialect, head: bytes, tried: Callable[[str], ProgramError | None]
) -> ProgramError:
    """The error; where the text requires another control, and read as that one's it comes farther, with this as its advice.

    tried: what is wrong with the program when it is read in the dialect of a name, None: nothing."""
    from postproc.nc.recognise import better

    found = better(head, dialect.name) if head and error.place is not None else None
    if found is None:
        return error
    name, reason = found
    try:
        other = tried(name)
    except GcompError:
        return error  # offsets or axes that it has not: nothing is shown by that
    here = error.place.line if error.place else 0
    if other is None:
        error.advice = f"--dialect {name} corrects the whole program ({reason})"
    elif (
        other.place is not None
        and other.place.file == getattr(error.place, "file", "")
        and other.place.line > here
    ):
        error.advice = f"--dialect {name} follows it to line {other.place.line} ({reason})"
    return error
