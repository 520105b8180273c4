"""Slides at rest: how far heat moves the tool while nothing moves (ISO 230-3).

With the spindle still it is the test of environmental temperature variation error (ETVE); with the
spindle turning, the test of distortion by a rotating spindle, which is told for the first hour and
for the whole period. Two pickups of one direction, so far apart as their heads say (arm_mm), tell a
tilt. Readings stand as they were taken: no trend is taken out, and the range of their own noise is
in the range.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from postproc.errors import Place
from postproc.iso import IsoError, Options, Parameter, Result, Term
from postproc.iso.chance import student
from postproc.recordings import Recording
from postproc.units import UM

SAME = 1e-3  # mm: slides that moved by less are at rest
HOUR = 3600.0
# Parts of the time whose means are compared: as many as the thermometer bears. With 6 there are 5
# changes, and Student's t is 2.9 already.
PARTS = (40, 30, 20, 15, 12, 10, 8, 6)
# Mean square of the changes by that of the thermometer's own error in them, at least: what it errs
# makes a slope too small by one in so many less one, which is in U
ABOVE = 10.0
LEAST = 60.0  # s: a shorter recording at rest is no test of heat
ABOUT = {
    ("Z", "X"): "B", ("Z", "Y"): "A", ("X", "Y"): "C", ("X", "Z"): "B", ("Y", "Z"): "A",
    ("Y", "X"): "C",
}  # fmt: skip


@dataclass(frozen=True)
class Drift:
    """One pickup. letter: direction; time (N,) s; reading (N,) mm; spindle: whether it turned; arm:
    mm along `tool`, nan where the head says none; tool: the axis along which arms are counted."""

    recording: Recording
    letter: str
    time: np.ndarray
    reading: np.ndarray
    spindle: bool
    arm: float
    tool: str


def rests(recording: Recording) -> bool:
    """Whether this is a test of slides at rest: nothing moves, and time goes on."""
    still = all(float(np.ptp(recording.position(x))) <= SAME for x in recording.axes)
    time = recording.columns.get("t_s")
    return (
        still
        and recording.quantity == "displacement"
        and time is not None
        and float(np.ptp(time)) >= LEAST
    )


def result_of(recording: Recording, options: Options) -> tuple[Drift, Result]:
    """Range over the whole test and in its worst hour, what stays at the end, and how it goes with
    temperatures. Raises IsoError."""
    d = _drift(recording)
    hours = (d.time[-1] - d.time[0]) / HOUR
    device = _device(recording, options)
    head = f"d{d.letter}" if d.spindle else f"ETVE_{d.letter}"
    # a range is a difference of two readings: sqrt(2) u, and 2 for 95 %
    parameters = _parameters(d, head, hours, None if device is None else 2 * np.sqrt(2) * device)
    terms: tuple[Term, ...] = ()
    if device is not None:
        said = f"{device / UM:.3g} um a reading, times the root of 2 for a difference"
        terms = (Term("device", device * np.sqrt(2), frozenset(p.name for p in parameters), said),)
    warm, notices = _temperatures(d)
    if not d.spindle and hours < 4:
        notices.append(
            f"{hours:.1f} h: a room has its day, and the test is meant to last 4 h at least, better"
            " 24 h"
        )
    if device is None:
        notices.append("the uncertainty of a reading is not stated (--device): U is not known")
    spindle = "turns" if d.spindle else "is still"
    why = (
        f"no axis moves for {hours:.1f} h, the spindle {spindle}, displacement is read along"
        f" {d.letter}"
    )
    return d, Result(
        "rotating spindle" if d.spindle else "ETVE",
        "ISO 230-3",
        f"{head}",
        why,
        "um",
        (recording.file,),
        (*parameters, *warm),
        terms,
        (*recording.notices, *notices),
        _noise(d.reading),
        detail=d,
    )


def _parameters(d: Drift, head: str, hours: float, U: float | None) -> list[Parameter]:
    """Ranges, and what is left at the end; head: the name of the first."""
    whole, where = _range(d.time, d.reading)
    found = [Parameter(head, whole, f"range over {hours:.1f} h", where, U)]
    if d.spindle:
        early = d.time <= d.time[0] + HOUR
        first, _ = _range(d.time[early], d.reading[early])
        found.append(Parameter(f"{head},60", first, "range in the first 60 min", "", U))
    if hours > 1:
        size, at = _worst_hour(d.time, d.reading)
        found.append(Parameter(f"{head},1h", size, "largest range within any hour", at, U))
    last = float(d.reading[-1] - d.reading[0])
    return [*found, Parameter("end", last, "last reading less the first", "", U)]


def _device(recording: Recording, options: Options) -> float | None:
    """mm: standard uncertainty of a reading, as --device says it, else as its head does."""
    return options.budget.device if options.budget.device is not None else recording.u


def _noise(reading: np.ndarray) -> float:
    """mm, of one reading, by the differences of neighbours; 0 where there are too few."""
    if len(reading) <= 3:
        return 0.0
    # The median size of a normal error is 0.6745 sigma, a difference of two has sqrt(2) sigma.
    # Neighbours, since the drift itself is what the readings do over hours; the median, since a
    # knock is no noise.
    return float(np.median(np.abs(np.diff(reading)))) / (0.6745 * np.sqrt(2))


def tilts_of(found: list[Drift], options: Options) -> list[Result]:
    """The tilt that two pickups of one direction tell, so far apart as their heads say."""
    out = []
    for one, other in itertools.combinations(found, 2):
        #    nose |==o=======o==|      Two pickups along X at two places of Z: their difference by
        #           one     other      the distance is a turn about Y. Its sign is left open, since
        #                              a range has none.
        apart = other.arm - one.arm
        same = (one.letter, one.spindle, one.tool) == (other.letter, other.spindle, other.tool)
        if not same or not abs(apart) > SAME or (one.tool, one.letter) not in ABOUT:
            continue
        low, high = max(one.time[0], other.time[0]), min(one.time[-1], other.time[-1])
        time = one.time[(one.time >= low) & (one.time <= high)]
        if len(time) < 2:
            continue
        # both were not read at the same moments: where they overlap, the other is taken between its
        # readings
        angle = (
            np.interp(time, other.time, other.reading) - np.interp(time, one.time, one.reading)
        ) / apart
        name = f"{'d' if one.spindle else 'ETVE_'}{ABOUT[one.tool, one.letter]}"
        size, at = _range(time, angle)
        U = _of_tilt(one, other, options)
        out.append(Result(
            "tilt at rest", "ISO 230-3", name,
            f"two pickups along {one.letter}, {abs(apart):g} mm apart along {one.tool}", "urad",
            (one.recording.file, other.recording.file),
            (Parameter(name, size, "range of the tilt", at, U),),
        ))  # fmt: skip
    return out


def _of_tilt(one: Drift, other: Drift, options: Options) -> float | None:
    """U (95 %) of the angle that two pickups tell, rad; None where that of one is not known."""
    u = [_device(r, options) for r in (one.recording, other.recording)]
    stated = [v for v in u if v is not None]
    if len(stated) < 2:
        return None
    return 2 * np.sqrt(2) * float(np.linalg.norm(stated)) / abs(other.arm - one.arm)


def _drift(recording: Recording) -> Drift:
    large = {x: v for x, v in recording.sensitive.items() if abs(v) > 0.999}
    if len(large) != 1:
        raise IsoError(
            f"at rest, and read along {recording.sensitive}",
            "a test of drift reads along one axis: sensitive = { Z = 1.0 }",
            Place(recording.file, 1),
        )
    letter, sign = next(iter(large.items()))
    order = np.argsort(recording.columns["t_s"], kind="stable")
    rpm = recording.columns.get("spindle_rpm", np.zeros(0))
    turns = rpm[np.isfinite(rpm)]  # an empty column says nothing of it
    arm = recording.head.get("arm_mm", float("nan"))
    return Drift(
        recording, letter, recording.columns["t_s"][order],
        float(np.sign(sign)) * recording.reading[order], bool((turns != 0).any()),
        float(arm) if isinstance(arm, int | float) else float("nan"),
        str(recording.head.get("arm_along", "Z")),
    )  # fmt: skip


def _range(time: np.ndarray, reading: np.ndarray) -> tuple[float, str]:
    high, low = int(np.argmax(reading)), int(np.argmin(reading))
    return (
        float(np.ptp(reading)),
        f"from {min(time[high], time[low]):.0f} s to {max(time[high], time[low]):.0f} s",
    )


def _worst_hour(time: np.ndarray, reading: np.ndarray) -> tuple[float, str]:
    """mm, and from when: the largest range within any hour that begins at a reading."""
    # The window begins at each reading and never lies between: a range is made by two readings, and
    # the earlier one of the worst pair begins an hour that holds both.
    stop = np.searchsorted(time, time + HOUR, "right")
    ranges = np.array([np.ptp(reading[i:k]) for i, k in enumerate(stop)])
    worst = int(np.argmax(ranges))
    return float(ranges[worst]), f"from {time[worst]:.0f} s"


def _temperatures(d: Drift) -> tuple[list[Parameter], list[str]]:
    """Drift per kelvin of each thermometer that changed, with the U of its line; what makes such a
    number poor, in words."""
    parameters, notices = [], []
    still: dict[str, float] = {}  # name to K
    order = np.argsort(d.recording.columns["t_s"], kind="stable")
    for name, column in d.recording.columns.items():
        if not (name.startswith("T_") and name.endswith("_C")):
            continue
        warm = column[order]
        known = np.isfinite(warm)
        spread = float(np.ptp(warm[known])) if known.sum() > 2 else 0.0
        if spread < 0.1:
            # 0.1 K: below it the line would be laid through the steps of a thermometer
            still[name] = spread
            continue
        found = _per_kelvin(warm[known], d.reading[known])
        if found is None:
            notices.append(
                f"{name} changed by {spread:.2f} K, too little beside its steps and its noise, or"
                " in too few readings: no coefficient per kelvin follows"
            )
            continue
        slope, U, share, parts = found
        said = (
            f"{name} changed by {spread:.1f} K and goes with {100 * share:.0f} % of it, from one of"
            f" {parts} parts of the time to the next"
        )
        parameters.append(Parameter(f"per K of {name}", slope, said, "", U))
    if still:
        most = f"{max(still.values()):.2f} K{' at most' * (len(still) > 1)}"
        notices.append(f"{', '.join(still)} changed by {most}: no coefficient per kelvin follows")
    return parameters, notices


def _per_kelvin(warm: np.ndarray, reading: np.ndarray) -> tuple[float, float, float, int] | None:
    """mm/K, its U (95 %), the share of the changes that goes with the temperature, and the number
    of parts; None where the thermometer's own error is not far below the changes.

    Told by the changes from one part of the time to the next: what drifts for another reason
    wanders, and two wanders that have nothing to do with each other go along a line together; their
    changes do not (Granger and Newbold, J. Econometrics 2 (1974) 111). An error of the thermometer
    makes the slope too small (errors in variables), so parts are as long as it asks for.
    """
    for count in PARTS:
        if count > len(warm):
            continue
        parts = np.array_split(np.arange(len(warm)), count)
        # x, y: steps of temperature and of reading from the mean of one part of the time to that of
        # the next. A mean has less of both noises than one reading, and all of the heat.
        x = np.diff([warm[p].mean() for p in parts])
        y = np.diff([reading[p].mean() for p in parts])
        square, free = float(x @ x), len(x) - 1
        error = 2 * len(x) * _error(warm, len(warm) / count)
        if not square > ABOVE * error:
            continue
        slope = float(x @ y) / square
        left, total = y - slope * x, float(y @ y)
        share = max(0.0, 1 - float(left @ left) / total) if total > 0 else 0.0
        # errors in variables: the slope comes out as (square - error) / square of what it is
        small = abs(slope) * error / (square - error)
        return (
            slope,
            student(free) * float(np.sqrt(left @ left / free / square)) + small,
            share,
            count,
        )
    return None


def _error(warm: np.ndarray, number: float) -> float:
    """K^2: variance of the mean of so many readings of a thermometer: of its steps (the smallest
    one seen; rounding does not become less by reading the same step again), and of its noise by
    what three readings in a row differ from a line."""
    # Rounding to a step spreads evenly over it: step**2 / 12. A second difference a - 2 b + c of
    # three equal variances has 1 + 4 + 1 of them, and no part of a steady rise: hence the 6.
    steps = np.diff(np.unique(np.round(warm, 6)))
    bent = np.diff(warm, 2)
    noise = float(bent @ bent) / (6 * len(bent)) if len(bent) else 0.0
    return (float(steps.min()) ** 2 / 12 if len(steps) else 0.0) + noise / number
