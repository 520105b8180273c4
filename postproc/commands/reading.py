"""What every command that reads programs must be told: which machine, in which language, and where
the zeros lie."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from postproc import intake, ports
from postproc.errors import GcompError, Notice, ProgramError, UsageError
from postproc.machine import part
from postproc.units import UM

if TYPE_CHECKING:
    from postproc.control_tables import ErrorTable
    from postproc.filter import Filter
    from postproc.machine.model import Machine
    from postproc.machine.stated import ControlTable
    from postproc.machine.tables import AxisTable
    from postproc.nc.dialects import Dialect
    from postproc.recordings import Source

AUTO = "auto"


def machine_of(options: argparse.Namespace) -> Machine:
    """The machine that --machine names. Raises UsageError with the names that there are."""
    from postproc.machine import places

    if not options.machine:
        names = ", ".join(places.shown()) or "none found"
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
            raise UsageError(
                f"--only {name}: the map of {machine.name} has no {name}",
                f"it has {', '.join(there) or 'nothing'}",
            )
    return part.only(machine, only)


def left_by_only(options: argparse.Namespace) -> str:
    """What --only leaves of the map, in words; empty without it."""
    if not options.only:
        return ""
    whole = argparse.Namespace(**(vars(options) | {"only": ()}))
    machine, chosen = machine_of(whole), machine_of(options)
    left = [name for name in part.names(machine) if name not in part.names(chosen)]
    return (
        f"only {', '.join(options.only)} of the map is corrected (--only);"
        f" {', '.join(left) or 'nothing'} stays, up to"
        f" {part.largest_left(machine, chosen) / UM:.1f} um on its nodes"
    )


def with_control_tables(machine: Machine) -> Machine:
    """The machine as it moves with the control's own tables as they are at work: what a table does
    that was off while the map was measured is taken out of it, and what one did that is off now is
    put back."""
    changed = [
        (table, table.file)
        for table in machine.control_tables
        if table.active != table.measured and table.file is not None
    ]
    if not changed:
        return machine
    from postproc.machine.stated import EffectTerm

    terms = []
    for table, file in changed:
        # A table takes its deviation out. At work now and off while the map was measured: less of
        # it is left. The other way round: as much is there again.
        sign, state = (-1.0, "on") if table.active else (1.0, "off")
        added = tuple(
            _added(found, sign)
            for found in _of_control(table, file)
            if found.moving in machine.axes and found.along in machine.axes
        )
        terms.append(EffectTerm(f"{table.control} table {state}", "", {}, None, added))
    return replace(machine, effects=machine.effects + tuple(terms))


def _of_control(table: ControlTable, file: Path) -> list[ErrorTable]:
    """What a control's own table takes out."""
    from postproc import control_tables

    extra = dict(table.more) | ({"axis": table.axis} if table.axis else {})
    if table.settings is not None:
        extra |= {"settings": _source(table.settings).text, "settings_name": str(table.settings)}
    source = _source(file)
    return control_tables.load(table.control).read(
        source, control_tables.ExportOptions(extra=extra)
    )


def _added(found: ErrorTable, sign: float) -> AxisTable:
    """A control's table times `sign`, as a table of the map."""
    from postproc.machine.tables import COMPONENTS, AxisTable

    # One point holds everywhere, as two do that say the same.
    nodes = found.nodes if len(found.nodes) > 1 else found.nodes[0] + np.array([0.0, 1.0])
    # (direction, EX EY EZ EA EB EC, node), mm
    both = np.zeros((2, 6, len(nodes)))
    both[:, COMPONENTS.index(f"E{found.along}")] = sign * np.stack([found.forward, found.reverse])
    return AxisTable(found.moving, nodes, both[0], both[1])


def _source(path: Path) -> Source:
    from postproc.recordings import Source

    return Source(str(path), ports.read_whole(path, intake.CONTROL_TABLE))


def warmed(machine: Machine, temperatures: dict[str, float]) -> Machine:
    """The machine at other temperatures. Raises UsageError where it does not say how it grows."""
    grows = [x for x, axis in machine.axes.items() if axis.expansion is not None]
    for name in temperatures:
        if not grows or (name != "work" and name not in grows):
            raise UsageError(
                f"--temperature names {name}, and {machine.name} does not say how"
                f" {'anything' if not grows else name} grows",
                "heat = { scale_um_m_K = 11.5, scale_C = 20.0, work_um_m_K = 11.5, work_C = 20.0,"
                " fixed_mm = 0.0 } in its [axes] section",
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
            if axis not in machine.axes and axis not in ("T" if name == "--start" else "RQ"):
                raise UsageError(
                    f"{name} names {axis}, which is no axis of {machine.name}",
                    f"its axes are {' '.join(machine.letters)}",
                )
    setup = setup_of(
        machine, offsets, options.start, options.block_delete == "on", options.arc_centre,
        (options.integers or "").replace("-", " "), options.scaling or "",
    )  # fmt: skip
    how = Options(
        options.tolerance, options.outside, options.reversal, options.ramp, options.cut_rapids,
        hole_tolerance=options.hole_tolerance, hysteresis=options.hysteresis,
        orientation=options.orientation,
    )  # fmt: skip
    followed = None
    _with_temperatures(options)
    if getattr(options, "temperatures", None):
        from postproc.commands import warming

        machine, followed = warming.of(options, machine, dialect, notices)
    filter_ = Filter(machine, dialect, setup, how, heat=followed)
    filter_.notices += notices
    return filter_


def _with_temperatures(options: argparse.Namespace) -> None:
    """Raises UsageError for what says how a log is read where none is."""
    if getattr(options, "temperatures", None):
        return
    given = {
        "--log-begin": getattr(options, "log_begin", None) is not None,
        "--pace": getattr(options, "pace", 1.0) != 1.0,
        "--hold-temperature": getattr(options, "hold_temperature", False),
    }
    for name in (name for name, is_given in given.items() if is_given):
        raise UsageError(
            f"{name} says how --temperatures is read, and there is none",
            "--temperatures LOG.csv beside it",
        )


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
    if getattr(options, "unbuffered", False):
        raise UsageError(
            "--dialect auto looks at the program before it is read: not with --unbuffered"
        )
    return dialects.load(_recognised(machine, head, notices))


def _recognised(machine: Machine, head: bytes, notices: list[Notice]) -> str:
    """The dialect that a program's beginning shows, with a notice that says why. Raises
    UsageError."""
    from postproc.nc import dialects
    from postproc.nc.recognise import recognise

    found = recognise(head)
    if not found:
        raise UsageError(
            "the program does not show which control it is for",
            f"say --dialect {' or '.join(dialects.names())}",
        )
    name, evidence = found[0]
    others = [n for n, e in found[1:] if len(e) == len(evidence)]
    # of dialects that as much speaks for, the machine's own
    if machine.control in (name, *others):
        name = machine.control
    why = "; ".join(evidence[:3]) or "nothing speaks against it"
    also = f" (it could be {', '.join(others[:3])} too)" if others else ""
    notices.append(Notice("dialect", f"read as {name}: {why}{also}"))
    return name


def _from_files(
    options: argparse.Namespace, machine: Machine, notices: list[Notice]
) -> dict[str, dict[str, float]]:
    """Offsets of all --offsets files, the last one wins."""
    result: dict[str, dict[str, float]] = {}
    if not options.offsets:
        return result
    from postproc import offsets

    for path in options.offsets:
        inch = None if options.offsets_unit is None else options.offsets_unit == "inch"
        diameter = None if options.offsets_x is None else options.offsets_x == "diameter"
        text = ports.read_whole(Path(path), intake.OFFSETS)
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
    """The error; where the text requires another control, and read as that one's it comes farther,
    with this as its advice. A control that comes farther because it passes an M code that this one
    refuses, for want of knowing it, is no advice.

    tried: what is wrong with the program when it is read in the dialect of a name, None:
    nothing."""
    from postproc.nc import dialects
    from postproc.nc.recognise import better, only_passed

    here = error.place
    if not head or here is None:
        return error
    found = better(head, dialect.name)
    if found is None or only_passed(head, dialect, dialects.load(found[0])):
        return error
    name, reason = found
    try:
        other = tried(name)
    except GcompError:
        return error  # offsets or axes that it has not: nothing is shown by that
    if other is None:
        error.advice = f"--dialect {name} corrects the whole program ({reason})"
    elif (there := other.place) and there.file == here.file and there.line > here.line:
        error.advice = f"--dialect {name} follows it to line {there.line} ({reason})"
    return error


def stated(name: str) -> dict[str, Any]:
    """What machine.toml says of the machine called `name`, or of that path, as it is written; it
    has been read and found good."""
    from postproc.machine import places

    text = ports.read_whole(places.folder_of(name) / "machine.toml", intake.MACHINE)
    return intake.toml(text.decode("utf-8-sig"))
