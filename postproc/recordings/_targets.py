"""From a table of readings to a recording of kind `targets`: what was measured, in which direction,
in which unit, when.

What the instrument did not write down is asked for, or taken and said.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from postproc.errors import Place, UsageError
from postproc.recordings import AXES, Fault, ReadingOptions, Recording, RecordingError, Source
from postproc.recordings import _split as split
from postproc.recordings import _units as units
from postproc.recordings._units import ANGLE, LENGTH, Unit

LINEAR, ROTARY = "XYZ", "ABC"
TURNS = dict(zip(ROTARY, LINEAR, strict=True))
COMPONENT = re.compile(r"E([XYZABC])([XYZABC])")
FARTHEST = 1e6  # mm or degrees: no axis reaches that far
LARGEST = 1e9  # um or urad
QUANTITY_OF = {"displacement": LENGTH, "straightness": LENGTH, "angle": ANGLE}


@dataclass(frozen=True)
class Component:
    """What was measured: EXZ is the deviation along X while Z moves; EBZ the rotation about Y.
    Names of ISO 230-1."""

    name: str
    axis: str
    quantity: str
    sensitive: dict[str, float]

    @property
    def position(self) -> str:
        """The column of the axis' position."""
        return f"{self.axis}_{'mm' if self.axis in LINEAR else 'deg'}"


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


def component_of(
    options: ReadingOptions, source: Source, axis: str = "", quantity: str = "", where: int = 1
) -> Component:
    """What was measured, from the options and from what the file says of axis and quantity (as far
    as it does).

    Raises UsageError where options contradict each other or name no component; RecordingError with
    the option that is missing where it stays open.
    """
    axis_told = options.axis.strip().upper()
    if axis_told and (len(axis_told) != 1 or axis_told not in AXES):
        raise UsageError(f"--axis {options.axis} is no axis letter", f"one of {' '.join(AXES)}")
    if options.component:
        component = parsed(options.component)
        if axis_told and axis_told != component.axis:
            raise UsageError(
                f"--axis {axis_told} and --component {component.name} contradict each other",
                f"{component.name} belongs to the axis {component.axis}",
            )
        if quantity and component.quantity != quantity:
            raise UsageError(
                f"{component.name} is {article(component.quantity)}, and {source.name} holds"
                f" {article(quantity)}"
            )
        return component
    axis = axis_told or axis
    place = Place(source.name, where)
    if not axis:
        raise RecordingError(
            "the file does not say which axis moved",
            "say --axis Z, or what was measured, like --component EXZ",
            place,
        )
    if quantity == "displacement" or (quantity == "angle" and axis in ROTARY):
        return parsed(f"E{axis}{axis}")
    if quantity == "straightness":
        may = [f"E{d}{axis}" for d in LINEAR if d != axis]
    elif quantity == "angle":
        may = [f"E{d}{axis}" for d in ROTARY]
    else:
        may = [f"E{d}{axis}" for d in LINEAR + ROTARY]
    what = {
        "straightness": "in which direction the straightness of",
        "angle": "about which axis the rotation of",
    }.get(quantity, "what of")
    raise RecordingError(
        f"the file does not say {what} {axis} was measured",
        f"say --component {' or '.join(may)}",
        place,
    )


def positioning(
    options: ReadingOptions,
    source: Source,
    axis: str,
    said: Unit | None,
    where: int,
    notices: list[str],
) -> Component:
    """What a table measured that names its axis at most: what --component says, or else the
    positioning of the axis.

    said: the unit in the file; angles of a linear axis can not be its positioning. Raises as
    `component_of`.
    """
    if options.component:
        return component_of(options, source, axis, "", where)
    unit = units.named(options.unit) if options.unit else said
    quantity = "angle" if unit is not None and unit.quantity == ANGLE else "displacement"
    component = component_of(options, source, axis, quantity, where)
    notices.append(
        f"taken as {component.name}, the positioning of {component.axis} (--component where it was"
        " straightness or an angle)"
    )
    return component


def parsed(name: str) -> Component:
    """A component by its name in ISO 230-1. Raises UsageError for a name that is none."""
    found = COMPONENT.fullmatch(name.strip().upper())
    if found is None:
        raise UsageError(
            f"{name!r} is no component that is recorded at targets",
            "E, then the direction X Y Z or rotation A B C, then the axis that moves: EZZ,"
            " EXZ, EBZ",
        )
    direction, axis = found[1], found[2]
    if direction in ROTARY:
        return Component(found[0], axis, "angle", {TURNS[direction]: 1.0})
    return Component(
        found[0], axis, "displacement" if direction == axis else "straightness", {direction: 1.0}
    )


def article(quantity: str) -> str:
    """The quantity as a noun."""
    return {
        "displacement": "a displacement",
        "straightness": "a straightness",
        "angle": "an angle",
    }[quantity]


def axis_in(text: str) -> str:
    """The one axis letter that stands alone in a free text ("Z", "X-axis", "Achse Y"), or
    nothing."""
    found = {
        m.upper() for m in re.findall(r"(?<![A-Za-z])([XYZABCxyzabc])(?:[0-9])?(?![A-Za-z])", text)
    }
    return found.pop() if len(found) == 1 else ""


def unit_for(
    options: ReadingOptions,
    source: Source,
    component: Component,
    said: Unit | None = None,
    where: int = 1,
) -> Unit:
    """The unit of the readings: what the file says, or the options do.

    Raises RecordingError where neither does, and UsageError where they differ, or where it is not
    one of this component.
    """
    kind = QUANTITY_OF[component.quantity]
    told = units.named(options.unit) if options.unit else None
    if told and said and told.factor != said.factor:
        raise UsageError(
            f"{source.name} says that its readings are in {said.name}, and --unit says {told.name}",
            "leave --unit out, or mend the file where it is wrong",
        )
    unit = told or said
    if unit is None:
        some = "um, mm" if kind == LENGTH else "urad, mm/m, arcsec"
        raise RecordingError(
            "the file does not say in which unit its readings are",
            f"say it: --unit with one of {some}",
            Place(source.name, where),
        )
    if unit.quantity != kind:
        what = article(component.quantity)
        text = (
            f"{component.name} is {what}, and {unit.name} is a unit of"
            f" {'angles' if unit.quantity == ANGLE else 'lengths'}"
        )
        if told:
            raise UsageError(text, "another --unit, or another --component")
        raise RecordingError(text, "say what was measured: --component", Place(source.name, where))
    return unit


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
    *,
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
    told = list(notices)
    if not len(readings.value):
        raise RecordingError(
            "there are no readings",
            "",
            Place(source.name, max([f.line for f in faults], default=1)),
        )
    run = np.array(readings.run, np.int64)
    target = np.array(readings.target, np.float64)
    raw = np.array(readings.value, np.float64)
    line = np.array(readings.line, np.int64)
    sign = signs(run, np.array(readings.sign or np.zeros(len(run)), np.int64), options, told, first)
    value = raw * unit.factor
    _finite(source, target, value, unit, line)
    _once(source, run, target, sign, line)
    if readings.t is None:
        order = _order(run, target, sign, line)
        t = np.arange(len(run), dtype=np.float64)
        told.append(
            "the file has no times: t_s is made up, 1 s from reading to reading, run by run"
        )
    else:
        order = np.argsort(np.array(readings.t), kind="stable")
        t = np.array(readings.t, np.float64)[order]
    columns: dict[str, np.ndarray] = {"run": run[order].astype(np.float64), "t_s": t}
    columns |= _positions(component, options, target[order], readings, order, told)
    columns[f"approach_{component.axis}"] = sign[order].astype(np.float64)
    columns[f"reading_{unit.base}"] = value[order]
    columns |= {
        n: np.array(c, np.float64)[order] for n, c in readings.columns.items() if n not in columns
    }
    told += _doubts(target, raw, value, run, sign, unit)
    keys: dict[str, Any] = {"machine": options.machine} if options.machine else {}
    keys |= {k: v for k, v in head.items() if v not in ("", None)} | keys
    keys |= {
        "quantity": component.quantity,
        "sensitive": component.sensitive,
        "component": component.name,
    }
    keys |= {"unit_in_file": unit.name, **options.head}
    return Recording("targets", keys, columns, source.name, line[order], tuple(faults), tuple(told))


def _order(run: np.ndarray, target: np.ndarray, sign: np.ndarray, line: np.ndarray) -> np.ndarray:
    """(N,) rows in the order of time where no times are known: that of the file, where each row is
    one reading and the rows go as the axis went; else run by run, its first direction first, and in
    each as the axis went."""
    passes = np.lexsort((np.arange(len(run)), sign, run))
    same = (np.diff(run[passes]) == 0) & (np.diff(sign[passes]) == 0)
    onward = (np.diff(target[passes]) * sign[passes][1:])[same] > 0
    if (np.diff(line) > 0).all() and (np.diff(run) >= 0).all() and onward.all():
        return np.arange(len(run))
    first = {int(r): sign[run == r][0] for r in np.unique(run)}
    second = sign != np.array([first[int(r)] for r in run])
    return np.lexsort((target * sign, second, run))


def _positions(component, options, target, readings, order, told) -> dict[str, np.ndarray]:
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
        told.append(
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
            raise RecordingError(
                f"the {name} is {column[i]:g} {base}: no machine has that",
                "",
                Place(source.name, int(line[i])),
            )


def _once(source, run, target, sign, line) -> None:
    seen: dict[tuple[int, float, int], int] = {}
    for key, at in zip(
        zip(run.tolist(), target.tolist(), sign.tolist(), strict=True), line.tolist(), strict=True
    ):
        if key in seen:
            other = f" and in line {seen[key]}" if seen[key] != at else ""
            raise RecordingError(
                f"run {key[0]} has the target {key[1]:g} twice: here{other}",
                "give each reading of a target its own run",
                Place(source.name, at),
            )
        seen[key] = at


def _doubts(target, raw, value, run, sign, unit) -> list[str]:
    """What looks like a slip: the unit, positions for deviations, runs of nothing but zeros, the
    direction of runs."""
    result = []
    odd = units.outside(float(np.ptp(value)), unit.quantity, unit) if len(value) > 1 else None
    if odd:
        result.append(odd)
    if len(value) > 2 and np.ptp(target) > 0 and unit.quantity == LENGTH:
        slope = float(np.polyfit(target - target.mean(), raw, 1)[0])
        if abs(abs(slope) - 1) < 0.02:
            result.append(
                f"the readings follow the targets one to one (slope {slope:.4f}): these look like"
                " positions, not deviations (by a column mapping they are read so: --column"
                " actual_mm=NAME)"
            )
    zero = [int(r) for r in np.unique(run) if not np.any(raw[run == r])]
    if zero and np.any(raw):
        result.append(
            f"all readings of run {', '.join(map(str, zero))} are 0: was it measured?"
            " (--bidirectional no if one way only)"
        )
    doubt = split.doubt(run, target, value, sign)
    if doubt:
        result.append(doubt)
    return result
