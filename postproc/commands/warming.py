"""--temperatures: a log of thermometers beside a program, and what the machine makes of it."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np

from postproc import ports
from postproc.errors import Notice, UsageError
from postproc.heat import clock, log
from postproc.heat.follow import Heat, steps
from postproc.machine import growth
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.nc.dialects import Dialect

LARGEST = 200_000_000  # bytes of a log
SAYS_HOW = (
    "heat = { scale_um_m_K = 11.5, work_um_m_K = 11.5 } in its [axes] section, with sensors = [...] where columns have names of their "
    "own; or an [[effect]] spindle_growth or screw_heat"
)
GAP = 600.0  # s between two rows: a screw's temperature changes by half within ten minutes at work


def of(
    options: argparse.Namespace, machine: Machine, dialect: Dialect, notices: list[Notice]
) -> tuple[Machine, Heat]:
    """The machine that grows, and what it meets along a program. Raises UsageError, and LogError with file and line."""
    if options.temperature:
        raise UsageError(
            "--temperature and --temperatures both say how warm it is", "leave one out"
        )
    if machine.chain.rotary:
        raise UsageError(
            f"--temperatures: heat over time is followed on machines with linear axes, and {machine.name} turns {', '.join(machine.chain.rotary)}",
            "--temperature Z=24.1 takes one temperature for the whole program",
        )
    name = options.temperatures
    read = log.read(name, ports.read_whole(Path(name), LARGEST))
    live = getattr(options, "live_temperatures", False)
    found, lacking, out = growth.drivers(machine, read.columns, spindles=True)
    if lacking:
        raise UsageError(
            f"{machine.name} asks for {', '.join(sorted(set(lacking)))}, and {name} has no such column", f"its columns: {', '.join(read.columns)}"
        )  # fmt: skip
    if not any(d.column for d in found):
        raise UsageError(
            f"--temperatures {name}: nothing in {machine.name} grows by one of its columns ({', '.join(read.columns)})",
            SAYS_HOW,
        )
    log.check(read, [d.column for d in found if d.column])
    begin = (
        float(read.time[-1 if live else 0])
        if options.log_begin is None
        else read.moment(options.log_begin)
    )
    if not read.time[0] <= begin <= read.time[-1]:
        raise UsageError(
            f"--log-begin {options.log_begin}: the log {name} goes from {read.time[0]:g} s to {read.time[-1]:g} s",
            "a time within it",
        )
    tolerance = options.tolerance or max(
        max(a.least_increment for a in machine.axes.values()), 0.0005
    )
    if live:
        read = log.Newest(read, _fresh(name, read))
    heat = Heat(
        found,
        read,
        begin,
        options.pace,
        _rates(options, machine, dialect),
        steps(found, tolerance),
        live or options.hold_temperature,
    )
    notices += _notices(machine, heat, out)
    return growth.following(machine, found), heat


def _fresh(name: str, first: log.Log) -> Callable[[], log.Log]:
    """The log as it is now, read again where it has grown."""
    held = [first, -1]

    def fresh() -> log.Log:
        size = Path(name).stat().st_size
        if size != held[1]:
            data = ports.read_whole(Path(name), LARGEST)
            held[:] = [
                log.read(name, data[: data.rfind(b"\n") + 1]),
                size,
            ]  # the last row may be half written
        assert isinstance(held[0], log.Log)
        return held[0]

    return fresh


def _rates(options: argparse.Namespace, machine: Machine, dialect: Dialect) -> clock.Rates:
    fastest = np.array([axis.velocity or clock.VELOCITY for axis in machine.axes.values()])
    slides = tuple(i for i, x in enumerate(machine.letters) if x in XYZ)
    return clock.Rates(fastest, slides, dialect, options.block_delete == "on")


def _notices(machine: Machine, heat: Heat, out: list[str]) -> list[Notice]:
    """What was taken for granted."""
    by = "; ".join(
        dict.fromkeys(
            f"{d.name} by {d.column or 'the turns that the program names'}" for d in heat.drivers
        )
    )
    found = [Notice("heat by", f"heat over time: {by}")]
    if out:
        found.append(Notice("heat left", f"heat over time: {'; '.join(out)}"))
    if any(np.isnan(d.zero) or not d.column for d in heat.drivers):
        found.append(Notice("heat zero", "heat over time: what an effect moves counts from the program's beginning, as if the zero was touched then"))  # fmt: skip
    slow = [x for x, axis in machine.axes.items() if x in XYZ and not axis.velocity]
    if slow:
        found.append(Notice("heat rapids", f"heat over time: rapids of {', '.join(slow)} are taken as {clock.VELOCITY * 60:g} mm/min (max_velocity is not stated)"))  # fmt: skip
    if heat.log.widest > GAP:
        found.append(Notice("heat gap", f"{heat.log.name}: up to {heat.log.widest:.0f} s lie between two rows; straight lines are taken between them"))  # fmt: skip
    return found
