"""From a table of readings to a recording of kind `targets`: in which direction each was taken, in
which order, and where the other axes stood.

What the instrument did not write down is taken and said.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from postproc.errors import UsageError
from postproc.recordings import AXES, Fault, ReadingOptions, Recording, Source
from postproc.recordings import _split as split
from postproc.recordings import _units as units
from postproc.recordings._components import LINEAR, Component
from postproc.recordings._units import LENGTH, Unit

FARTHEST = 1e6  # mm or degrees: no axis reaches that far
LARGEST = 1e9  # um or urad


@dataclass
class Readings:
    """Readings as a file gives them, one a row; equal lengths N.

    run: 1, 2, ...; target: mm, of rotary axes degrees; value: deviation (actual - target) in the
    file's unit; line: where it stands; sign: direction of approach, 0 where the file does not say;
    columns: further columns by their names in the recording; t: s, where the file says.
    """

    run: Sequence[int]
    target: Sequence[float]
    value: Sequence[float]
    line: Sequence[int]
    sign: Sequence[int] = ()
    columns: Mapping[str, Sequence[float]] = field(default_factory=dict)
    t: Sequence[float] | None = None

    @classmethod
    def of(cls, rows: Iterable[tuple[int, float, float, int, int]], **more: Any) -> Readings:
        """From rows of run, target, value, line and sign."""
        columns: list[Any] = list(zip(*rows, strict=True)) or [()] * 5
        return cls(*columns, **more)


def signs(
    run: np.ndarray, sign: np.ndarray, options: ReadingOptions, notices: list[str], first: int = 0
) -> np.ndarray:
    """(N,) -1 or +1. Where the file does not say (0): odd runs one way, even runs back, unless the
    options tell otherwise.

    first: the direction of the first run that the file suggests.
    """
    if np.all(sign != 0):
        if options.first or options.bidirectional is not None:
            notices.append(
                "the file says the directions itself: --first and --bidirectional are not used"
            )
        return sign
    return _taken_signs(run, options, notices, first)


def _taken_signs(
    run: np.ndarray, options: ReadingOptions, notices: list[str], first: int
) -> np.ndarray:
    """(N,) -1 or +1, by the options and by usage."""
    start = options.first or first or 1
    there, back = ("+", "-") if start > 0 else ("-", "+")
    alone = len(np.unique(run)) == 1
    if options.bidirectional is False or (alone and not options.bidirectional):
        if not options.first:
            notices.append(
                f"the direction of approach is not in the file: taken as {there} (--first {back} if"
                f" it was {back})"
            )
        return np.full(len(run), start)
    if options.bidirectional is None or not options.first:
        notices.append(
            f"the direction of the runs is not in the file: odd runs are taken as {there}, even"
            f" runs as {back} (--first {back} to turn them round, --bidirectional no if all went"
            " one way)"
        )
    return np.where(run % 2 == 1, start, -start)


def recording(
    source: Source,
    options: ReadingOptions,
    component: Component,
    unit: Unit,
    readings: Readings,
    head: Mapping[str, Any],
    notices: Sequence[str] = (),
    faults: Sequence[Fault] = (),
    first: int = 0,
) -> Recording:
    """A recording in the order of time: run by run, and in each as the axis went, where the file
    has no times.

    Raises RecordingError for a target that stands twice in a run, a number that no machine has, or
    no readings at all.
    """
    noticed = list(notices)
    if not len(readings.value):
        raise source.fault(max([f.line for f in faults], default=1), "there are no readings")
    run = np.array(readings.run, np.int64)
    target = np.array(readings.target, np.float64)
    raw = np.array(readings.value, np.float64)
    line = np.array(readings.line, np.int64)
    sign = signs(
        run, np.array(readings.sign or np.zeros(len(run)), np.int64), options, noticed, first
    )
    value = raw * unit.factor
    _finite(source, target, value, unit, line)
    _once(source, run, target, sign, line)
    if readings.t is None:
        order = _order(run, target, sign, line)
        t = np.arange(len(run), dtype=np.float64)
        noticed.append(
            "the file has no times: t_s is made up, 1 s from reading to reading, run by run"
        )
    else:
        order = np.argsort(np.array(readings.t), kind="stable")
        t = np.array(readings.t, np.float64)[order]
    columns: dict[str, np.ndarray] = {"run": run[order].astype(np.float64), "t_s": t}
    columns |= _positions(component, options, target[order], readings, order, noticed)
    columns[f"approach_{component.axis}"] = sign[order].astype(np.float64)
    columns[f"reading_{unit.base}"] = value[order]
    columns |= {
        n: np.array(c, np.float64)[order] for n, c in readings.columns.items() if n not in columns
    }
    noticed += _implausible(target, raw, value, run, sign, unit)
    keys: dict[str, Any] = {"machine": options.machine} if options.machine else {}
    keys |= {k: v for k, v in head.items() if v not in ("", None)} | keys
    keys |= {
        "quantity": component.quantity,
        "sensitive": component.sensitive,
        "component": component.name,
    }
    keys |= {"unit_in_file": unit.name, **options.head}
    return Recording(
        "targets", keys, columns, source.name, line[order], tuple(faults), tuple(noticed)
    )


def _order(run: np.ndarray, target: np.ndarray, sign: np.ndarray, line: np.ndarray) -> np.ndarray:
    """(N,) rows in the order of time where no times are known: that of the file, where each row is
    one reading and the rows go as the axis went; else run by run, its first direction first, and in
    each as the axis went."""
    #     run  1  1  1  1  1  1     a run there and back: its first direction first, then the other,
    #     sign +  +  +  -  -  -     targets rising in + and falling in -
    #     x    0  50 99 99 50 0
    passes = np.lexsort((np.arange(len(run)), sign, run))
    same = (np.diff(run[passes]) == 0) & (np.diff(sign[passes]) == 0)
    onward = (np.diff(target[passes]) * sign[passes][1:])[same] > 0
    # Each pass goes as the axis went: the file's own order is that of time, and stays.
    if (np.diff(line) > 0).all() and (np.diff(run) >= 0).all() and onward.all():
        return np.arange(len(run))
    first = {int(r): sign[run == r][0] for r in np.unique(run)}
    second = sign != np.array([first[int(r)] for r in run])
    # the last key counts first
    return np.lexsort((target * sign, second, run))


def _positions(component, options, target, readings, order, noticed) -> dict[str, np.ndarray]:
    """The position of the axis that moved, and of the others where they are known."""
    places = {component.position: target}
    named = {n for n in readings.columns if re.fullmatch(r"[XYZ]_mm|[ABC]_deg", n)}
    for letter, at in options.others.items():
        if letter == component.axis:
            raise UsageError(
                f"--others names {letter}, which is the axis that moved", "name the axes that stood"
            )
        name = f"{letter}_{'mm' if letter in LINEAR else 'deg'}"
        if name in named:
            raise UsageError(
                f"--others says where {letter} stood, and so does the file",
                f"leave {letter} out of --others",
            )
        places[name] = np.full(len(target), float(at))
    for name in named - set(places):
        places[name] = np.array(readings.columns[name], np.float64)[order]
    if len(places) == 1:
        noticed.append(
            "where the other axes stood is not in the file (--others X=0,Y=0): lever arms can not"
            " be taken from it"
        )
    return {n: places[n] for n in sorted(places, key=lambda n: AXES.index(n[0]))}


def _finite(source, target, value, unit, line) -> None:
    for name, column, most, base in (
        ("target", target, FARTHEST, "mm"),
        ("reading", value, LARGEST, unit.base),
    ):
        wrong = np.flatnonzero(~(np.abs(column) <= most))
        if len(wrong):
            i = int(wrong[0])
            raise source.fault(
                int(line[i]), f"the {name} is {column[i]:g} {base}: no machine has that"
            )


def _once(source, run, target, sign, line) -> None:
    seen: dict[tuple[int, float, int], int] = {}
    for key, at in zip(
        zip(run.tolist(), target.tolist(), sign.tolist(), strict=True), line.tolist(), strict=True
    ):
        if key in seen:
            other = f" and in line {seen[key]}" if seen[key] != at else ""
            raise source.fault(
                at,
                f"run {key[0]} has the target {key[1]:g} twice: here{other}",
                "give each reading of a target its own run",
            )
        seen[key] = at


def _follows(target: np.ndarray, raw: np.ndarray) -> Iterator[str]:
    """Readings that follow the targets."""
    if len(raw) <= 2 or np.ptp(target) <= 0:
        return
    # in the file's own unit: positions in the place of deviations have the slope 1 there
    slope = float(np.polyfit(target - target.mean(), raw, 1)[0])
    if abs(abs(slope) - 1) < 0.02:
        yield (
            f"the readings follow the targets one to one (slope {slope:.4f}): these look like"
            " positions, not deviations (by a column mapping they are read so: --column"
            " actual_mm=NAME)"
        )


def _implausible(target, raw, value, run, sign, unit) -> Iterator[str]:
    """What looks like a slip: the unit, positions for deviations, runs of nothing but zeros, the
    direction of runs."""
    odd = units.outside(float(np.ptp(value)), unit.quantity, unit) if len(value) > 1 else None
    if odd:
        yield odd
    if unit.quantity == LENGTH:
        yield from _follows(target, raw)
    zero = [int(r) for r in np.unique(run) if not np.any(raw[run == r])]
    if zero and np.any(raw):
        yield (
            f"all readings of run {', '.join(map(str, zero))} are 0: was it measured?"
            " (--bidirectional no if one way only)"
        )
    if better := split.better_split(run, target, value, sign):
        yield better
