"""The options of every command that reads a program for a machine."""

from __future__ import annotations

import argparse

from postproc.commands import option_text, values

MACHINE = "a machine by name (gcomp machines) or by the path of its folder"
OPTIONS = """
[how it is corrected]
--tolerance LENGTH  how far the path may stay off: 0.5um, 0.001mm (default: one least increment,
    0.5um at least)
--hole-tolerance LENGTH  how far the axis of a hole or tap may bend while its cycle stays (default:
    5um; --tolerance at least; with --expand 0 writes every drilling cycle out)
--hysteresis LENGTH  how far a slide's wanted place may turn back before its lost motion is taken
    up (default: the machine's, or 1um)
--orientation  correct the rotary words too, for the tool's lean, in programs of the tool tip
    (G43.4, TRAORI, M128)
--reversal (mean|step|ramp|off)  what to do where an axis turns back (default: the machine's, or
    step)
--ramp LENGTH  travel over which --reversal ramp takes up the difference
--outside (error|clamp)  points outside the error tables: refuse, or hold the end value
--temperature Z=24.1,work=21  temperatures of scales or screws, and of the work, degrees Celsius,
    for machines that state how they grow
--only EXX,EZZ  correct for these components, squareness (C0Y) and effects (backlash:X) of the map
    alone
--cut-rapids  cut G0 at the map's nodes too
[how warm it is while it runs]
--temperatures LOG.csv  a log of thermometers: each block meets the temperature of its moment, by
    the program's own clock
--log-begin TIME  when in the log the program begins: its seconds, or a date and time (default: its
    first row)
--pace FACTOR  by which factor the machine takes longer than feeds, rapids and dwells say (default:
    1)
--hold-temperature  hold the log's last row for what is executed behind it, instead of refusing it
[how the program is read]
--dialect NAME  the control's language, if not the machine's own; auto: by what the program looks
    like
--offset G54=X1,Z2 ...  where a work or tool offset's zero lies, mm, radius, machine coordinates
--offsets FILE ...  work and tool offsets from a file of the control: LinuxCNC var file or tool
    table, Fanuc G10 dump, Siemens, GRBL $#, or a CSV table
--offsets-unit (mm|inch)  the unit of --offsets, where the file does not say
--offsets-x (radius|diameter)  what X of --offsets is, where the file does not say
--integers (units|least-increments)  what a coordinate without a decimal point counts, if not as
    usual on the control
--scaling (plane|space)  what cycle 11 of a Heidenhain scales: X and Y, or Z too (MP 7410)
--expand  write loops, subprograms, variables, cycles and turned coordinates out as plain blocks,
    and correct those; without either, gcomp FILE does so where nothing else corrects the program,
    and says so
--library DIR ...  a folder with subprograms for --expand
--max-steps MAX_STEPS  lines that --expand executes at most
--max-depth MAX_DEPTH  calls that --expand nests at most
--start X0,Z0  where the machine stands before the program, mm, radius, machine coordinates; on
    printers and routers behind G28 too, if machine.toml states no home; T2: the tool in the
    spindle (T0: none)
--block-delete (on|off)  whether blocks that begin with / are skipped at the machine (default: off)
--arc-centre (incremental|absolute)  what I J K mean when no G90.1 or G91.1 says so
"""


def arguments(parser: argparse.ArgumentParser, several: bool = False) -> None:
    """The options that say for which machine, how, and in which language: shared by all that read
    programs. several: whether they may be read for more than one machine."""
    option_text.add(
        parser, f"--machine NAME{' ...' * several}  {MACHINE}{OPTIONS}", tolerance=values.tolerance,
        hole_tolerance=values.hole_tolerance, hysteresis=values.tolerance, ramp=values.length,
        temperature=(values.temperatures, {}), only=(_names, ()), pace=(values.factor, 1.0),
        offset=values.offset, expand={"action": argparse.BooleanOptionalAction, "default": None},
        max_steps=(int, 10_000_000), max_depth=(int, 50), start=(values.place, {}),
        arc_centre="incremental",
    )  # fmt: skip


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())
