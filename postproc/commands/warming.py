"""--temperatures: a log of thermometers beside a program, and what the machine makes of it."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from postproc import intake, ports
from postproc.errors import Notice, Place, UsageError
from postproc.heat import clock, log
from postproc.heat.follow import Heat, steps
from postproc.machine import growth
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.nc.dialects import Dialect

SAYS_HOW = (
    "heat = { scale_um_m_K = 11.5, work_um_m_K = 11.5 } in its [axes] section, with sensors = [...]"
    " where columns have names of their own; or an [[effect]] spindle_growth or screw_heat"
)
# s between two readings: a screw's temperature changes by half within ten minutes at work
GAP = 600.0
WRITTEN, LOOKS = 0.5, 10  # s in which a log is written anew, and how often it is looked at
SILENT = "--live-temperatures needs a logger that writes this file as long as the job runs"


def of(
    options: argparse.Namespace, machine: Machine, dialect: Dialect, notices: list[Notice]
) -> tuple[Machine, Heat]:
    """The machine that grows, and what it meets along a program. Raises UsageError, and LogError
    with file and line."""
    if options.temperature:
        raise UsageError(
            "--temperature and --temperatures both say how warm it is", "leave one out"
        )
    name = options.temperatures
    read = log.read(name, ports.read_whole(Path(name), intake.LOG))
    live = getattr(options, "live_temperatures", False)
    found, lacking, out = growth.drivers(machine, read.columns, spindles=True)
    used = list(dict.fromkeys(d.column for d in found if d.column))
    if lacking:
        raise UsageError(
            f"{machine.name} asks for {', '.join(sorted(set(lacking)))}, and {name} has no such"
            " column",
            f"its columns: {', '.join(read.columns)}",
        )
    if not used:
        raise UsageError(
            f"--temperatures {name}: nothing in {machine.name} grows by one of its columns"
            f" ({', '.join(read.columns)})",
            SAYS_HOW,
        )
    log.check(read, used)
    begin = _begin(read, options.log_begin, live)
    _require_recorded(read, used, begin)
    tolerance = options.tolerance or max(
        max(a.least_increment for a in machine.axes.values()), 0.0005
    )
    if live:
        read = log.Newest(read, _fresh(name, read, used))
    heat = Heat(
        found, read, begin, options.pace, _rates(machine, dialect),
        steps(found, tolerance), live or options.hold_temperature,
    )  # fmt: skip
    notices += _notices(machine, heat, out)
    return growth.following(machine, found), heat


def _begin(read: log.Log, said: str | None, live: bool) -> float:
    """s of the log at which the program begins: as is said, else its first moment, of one that goes
    on its newest."""
    begin = float(read.time[-1 if live else 0]) if said is None else read.moment(said)
    if not read.time[0] <= begin <= read.time[-1]:
        raise UsageError(
            f"--log-begin {said}: the log {read.name} goes from {read.time[0]:g} s to"
            f" {read.time[-1]:g} s",
            "a time within it",
        )
    return begin


def _require_recorded(read: log.Log, used: list[str], begin: float) -> None:
    """Raises UsageError where a column has no reading yet when the program begins."""
    for column in used:
        first = float(read.recorded(column)[0])
        if begin < first:
            raise UsageError(
                f"{column} of {read.name} begins {first - begin:g} s after the program does",
                f"--log-begin {first:g}, if the program began then, or a log with a reading before",
            )


def _fresh(name: str, first: log.Log, used: list[str]) -> Callable[[], log.Log]:
    """The log as it is now, read again where it was written, and looked at each time. Raises
    LogError: a job must not go on with what was not measured."""
    held, stamp, since, text = first, None, time.monotonic(), b""

    def fresh() -> log.Log:
        nonlocal held, stamp, since, text
        now = time.monotonic()
        try:
            stat = Path(name).stat()
            written = (stat.st_size, stat.st_mtime_ns)
            if written == stamp:
                if now - since > GAP:
                    raise log.LogError(
                        f"{name} was not written for {now - since:.0f} s", SILENT, Place(name, 1)
                    )
                return held
            text = _lines_of(name, text)
        except (OSError, UsageError) as error:
            why = error.strerror if isinstance(error, OSError) else error.message
            raise log.LogError(f"{name} can not be read any more: {why}", SILENT) from None
        read = log.read(name, text)
        log.follow(read, held, now - since, used)
        for column in used:
            silent = float(read.time[-1] - read.recorded(column)[-1])
            if silent > GAP:
                raise log.LogError(
                    f"{column} holds no number for {silent:.0f} s", SILENT, read.place(-1)
                )
        held, stamp, since = read, written, now
        return held

    return fresh


def _lines_of(name: str, before: bytes) -> bytes:
    """Whole lines of a file: the last one may be half written. Where only the beginning of what
    stood there is left of it, it is being written anew, and is looked at again: some loggers write
    all of it each time."""
    for _ in range(LOOKS):
        data = ports.read_whole(Path(name), intake.LOG)
        text = data[: data.rfind(b"\n") + 1]
        if len(text) >= len(before) or not before.startswith(text):
            break
        time.sleep(WRITTEN / LOOKS)
    return text


def _rates(machine: Machine, dialect: Dialect) -> clock.Rates:
    fastest = np.array([axis.velocity or clock.VELOCITY for axis in machine.axes.values()])
    slides = tuple(i for i, x in enumerate(machine.letters) if x in XYZ)
    return clock.Rates(fastest, slides, dialect)


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
        found.append(
            Notice(
                "heat zero",
                "heat over time: what an effect moves counts from the program's beginning, as if"
                " the zero was touched then",
            )
        )
    return [*found, *_rapids(machine), *_gaps(heat)]


def _rapids(machine: Machine) -> Iterator[Notice]:
    """A notice of the axes whose rapids have no stated velocity."""
    if slow := [x for x, axis in machine.axes.items() if x in XYZ and not axis.velocity]:
        yield Notice(
            "heat rapids",
            f"heat over time: rapids of {', '.join(slow)} are taken as {clock.VELOCITY * 60:g}"
            " mm/min (max_velocity is not stated)",
        )


def _gaps(heat: Heat) -> Iterator[Notice]:
    """A notice for each column whose readings lie far apart."""
    for column in dict.fromkeys(d.column for d in heat.drivers if d.column):
        widest = heat.log.widest(column)
        if widest > GAP:
            yield Notice(
                f"heat gap {column}",
                f"{heat.log.name}: up to {widest:.0f} s lie between two"
                f" readings of {column}; straight lines are taken between them",
            )
