"""Results of recordings of circular tests: which runs are circles, what was taken off, and ISO
230-4's parameters."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from postproc.errors import Place
from postproc.iso import IsoError, Options, Parameter, Result, Term, circles
from postproc.iso.assign import LINEAR
from postproc.iso.causes import causes
from postproc.iso.chance import student
from postproc.iso.circles import Pair, Trace
from postproc.iso.uncertainty import combined, missing, terms_of
from postproc.recordings import Recording
from postproc.units import UM

# mm that a commanded position may lie beside the circle; further out it belongs to the run-in
OFF = 0.1
WIDE = 5.0  # degrees between samples that are worth a word


def traces(recording: Recording) -> tuple[str, list[Trace], list[str]]:
    """The two axes, the circles, and notices. Raises IsoError with the line where the positions are
    no circle."""
    # in the order X Y Z, so that xy means the same in every file
    axes = "".join(sorted(recording.head["centre"]))
    if len(axes) != 2 or any(x not in LINEAR for x in axes):
        raise IsoError(
            f"the centre names {', '.join(axes)}",
            "a circular test has two linear axes",
            Place(recording.file, 1),
        )
    nominal = float(recording.head["radius_mm"])
    arm = np.stack([recording.position(x) - recording.head["centre"][x] for x in axes])
    beside = np.abs(np.hypot(*arm) - nominal) > OFF
    notices: list[str] = []
    # The commanded place decides, not the reading: a reading of 0.1 mm is what the test is about, a
    # command beside the circle is the run-in. More than half beside it: the head is another test's.
    if beside.mean() > 0.5:
        raise IsoError(
            f"the commanded positions are {np.hypot(*arm[:, beside])[0]:.3f} mm from the centre,"
            f" the radius is {nominal:g} mm",
            "are centre and radius_mm those of this circle?",
            Place(recording.file, int(recording.lines[np.flatnonzero(beside)[0]])),
        )
    if beside.any():
        notices.append(f"{int(beside.sum())} samples beside the commanded circle are left out")
    found = _circles(recording, np.arctan2(arm[1], arm[0]), beside, notices)
    if not found:
        raise IsoError(
            "no run has 12 samples on the circle",
            "",
            Place(recording.file, int(recording.lines[0])),
        )
    return axes, found, notices + _said(found)


def _circles(
    recording: Recording, angle: np.ndarray, beside: np.ndarray, notices: list[str]
) -> list[Trace]:
    """The runs. angle: (N,) rad, beside: (N,) whether a sample is off the circle. Raises IsoError
    where a run turns against its sense."""
    nominal = float(recording.head["radius_mm"])
    run = recording.columns.get("run", np.ones(len(recording)))
    sense = recording.columns["sense"]
    ways: dict[float, int] = {}
    found = []
    for number, side in sorted({(float(r), float(s)) for r, s in zip(run, sense, strict=True)}):
        rows = np.flatnonzero((run == number) & (sense == side) & ~beside)
        if len(rows) < 12:
            notices.append(f"run {number:g} has {len(rows)} samples only and is left out")
            continue
        # in order of time, as `circles.trace` unwraps the angle; a file may be sorted otherwise
        rows = rows[np.argsort(recording.columns["t_s"][rows], kind="stable")]
        one = circles.trace(int(number), angle[rows], recording.reading[rows], nominal)
        if ways.setdefault(side, one.way) != one.way:
            raise IsoError(
                f"run {number:g} has sense {side:+g} but turns the other way than the runs"
                " before it",
                "sense is +1 for all runs one way and -1 for all the other",
                Place(recording.file, int(recording.lines[rows[0]])),
            )
        found.append(one)
    if len(ways) == 2 and len(set(ways.values())) == 1:
        raise IsoError(
            "both senses turn the same way",
            "sense is +1 counter-clockwise, -1 clockwise",
            Place(recording.file, int(recording.lines[0])),
        )
    return found


def _extent(arc: Trace) -> float:
    """rad, from before the first sample to behind the last."""
    # a sample stands for half a step on either side of it
    return float(np.ptp(arc.angle) + np.median(np.diff(arc.angle)))


def _said(found: list[Trace]) -> list[str]:
    notices = []
    if cut := [math.degrees(t.cut) for t in found if t.cut > math.radians(0.5)]:
        notices.append(
            f"overshoot taken off: {min(cut):.0f} to {max(cut):.0f} degrees a run, the middle turn"
            " is kept"
        )
    if arcs := [t for t in found if not t.full]:
        runs = ", ".join(str(t.run) for t in arcs)
        least = math.degrees(min(map(_extent, arcs)))
        notices.append(
            f"run {runs}: an arc of {least:.0f} degrees is no full"
            " circle: G, G(b), D and F about the centre are not defined"
        )
    wide = math.degrees(max(t.gap for t in found))
    if wide > WIDE:
        notices.append(
            f"samples are up to {wide:.1f} degrees apart: what lies between them is not seen"
        )
    return notices


def result_of(recording: Recording, options: Options) -> Result:
    """The circular test of one file."""
    axes, found, notices = traces(recording)
    a, b = tuple(axes.lower())
    forth, back = ([t for t in found if t.way * sense > 0] for sense in (1, -1))
    senses = {f"{a}{b}": forth, f"{b}{a}": back}
    # run by run: where one sense has more runs the rest of them has no partner
    pairs = list(map(Pair, forth, back))
    if not pairs:
        notices.append("one sense only: G(b), H and D are not defined")
    elif len(forth) != len(back):
        notices.append(
            f"{len(forth)} runs {a}{b}, {len(back)} runs {b}{a}: pairs are made in the order of the"
            " runs"
        )
    parameters = _circular(senses) + _two_way(pairs) + _radial(senses)
    terms = _terms(recording, options, parameters)
    notices.append(
        "F holds the bar's own zero and the set-up of the centre; G, G(b), H and D do not hold the"
        " centre, D holds the zero"
    )
    if len(pairs) < 2:
        notices.append("one run of a sense: U holds no scatter of runs")
    if absent := missing(options.budget, recording.u is not None, False):
        notices.append(absent)
    feed = recording.head.get("feed_mm_min")
    said = f", feed {feed:g} mm/min" if feed else ""
    why = (
        f"a circular test of {axes}: {a}{b} turns from +{axes[0]} to +{axes[1]}, {len(forth)} runs,"
        f" {b}{a} back, {len(back)} runs"
    )
    return Result(
        "circle", "ISO 230-4", f"{axes}, radius {recording.head['radius_mm']:g} mm{said}", why,
        "um", (recording.file,), tuple(combined(p, terms, p.runs) for p in parameters), terms,
        (*recording.notices, *notices), _noise(recording), _columns(axes, found), found,
        causes(axes, found, feed),
    )  # fmt: skip


def _circular(senses: dict[str, list[Trace]]) -> list[Parameter]:
    """Circular deviation G of each sense, of full circles."""
    result = []
    for label, some in senses.items():
        full = [t for t in some if t.full]
        words = f"circular deviation {label}"
        zones = [t.least_squares.zone for t in full]
        result.append(_over_runs(f"G{label}", f"{words}, least-squares circle", zones))
        zones = [t.minimum_zone.zone for t in full]
        result.append(_over_runs(f"G{label} mz", f"{words}, minimum zone", zones))
    return result


def _two_way(pairs: list[Pair]) -> list[Parameter]:
    """Two-way circular deviation G(b), hysteresis H and mean radial deviation D."""
    whole = [p for p in pairs if p.forth.full and p.back.full]
    widest = max(pairs, key=lambda p: p.hysteresis[0], default=None)
    at = f"at {math.degrees(widest.hysteresis[1]):.0f} degrees" if widest else ""
    words = "two-way circular deviation"
    return [
        _over_runs("G(b)", f"{words}, least-squares circle", [p.least_squares.zone for p in whole]),
        _over_runs("G(b) mz", f"{words}, minimum zone", [p.minimum_zone.zone for p in whole]),
        _over_runs("H", "circular hysteresis", [p.hysteresis[0] for p in pairs], at),
        _over_runs("D", "mean two-way radial deviation", [p.mean_deviation for p in whole]),
    ]


def _radial(senses: dict[str, list[Trace]]) -> list[Parameter]:
    """Radial deviation F of each sense: largest and least, from the nominal circle, and of full
    circles about their centre."""
    result = []
    for label, some in senses.items():
        for i, edge in enumerate(("max", "min")):
            name, words = f"F{label} {edge}", f"radial deviation {label}, {edge}"
            values = [t.about_nominal[i] for t in some]
            result.append(_over_runs(name, f"{words}, set-up included", values))
            values = [t.about_centre[i] for t in some if t.full]
            result.append(_over_runs(f"{name} c", f"{words}, about the centre", values))
    return result


def _terms(recording: Recording, options: Options, parameters: list[Parameter]) -> tuple[Term, ...]:
    names = frozenset(p.name for p in parameters if p.value is not None)
    lengths = frozenset(n for n in names if n[0] in "FD")
    terms = list(terms_of(options.budget, recording.u, None, names, True))
    device = options.budget.device if options.budget.device is not None else recording.u
    if device is not None:
        # F and D are one reading against the bar's zero, the others differences of two readings.
        # terms_of has put it first, with the root of 2 of a difference in it
        terms[0] = Term("device", terms[0].u, names - lengths, terms[0].said)
        terms.insert(1, Term("device, one reading", device, lengths, terms[0].said.split(",")[0]))
    # temperature and expansion act over the radius; a cosine error does not: the bar lies along its
    # radius
    scale = terms_of(options.budget, None, float(recording.head["radius_mm"]), lengths, True)
    return tuple(terms + [t for t in scale if t.name in ("temperature", "expansion")])


def _over_runs(name: str, words: str, values: list[float], at: str = "") -> Parameter:
    """The mean over runs or pairs, and what their scatter makes of it: t s / sqrt(n)."""
    if not values:
        return Parameter(name, None, words)
    n = len(values)
    # the mean over n runs: s / sqrt(n), widened by Student's t since s is known from n runs alone
    runs = student(n - 1) * float(np.std(values, ddof=1)) / math.sqrt(n) if n > 1 else None
    return Parameter(name, float(np.mean(values)), words, at, None, runs)


def _noise(recording: Recording) -> float:
    """mm that the digits follow: differences of neighbours in time."""
    if recording.u:
        return recording.u
    return max(float(np.median(np.abs(np.diff(recording.reading)))), UM / 10)


def _columns(axes: str, found: list[Trace]) -> dict[str, list[Any]]:
    a, b = tuple(axes.lower())

    def of_full(length: Callable[[Trace], float]) -> list[float | None]:
        return [length(t) / UM if t.full else None for t in found]

    return {
        "run": [t.run for t in found],
        "sense": [f"{a}{b}" if t.way > 0 else f"{b}{a}" for t in found],
        "samples": [len(t.angle) for t in found],
        "G um": of_full(lambda t: t.least_squares.zone),
        "G mz um": of_full(lambda t: t.minimum_zone.zone),
        f"centre {axes[0]} um": of_full(lambda t: float(t.least_squares.centre[0])),
        f"centre {axes[1]} um": of_full(lambda t: float(t.least_squares.centre[1])),
        "radius - nominal um": of_full(lambda t: t.least_squares.radius - t.nominal),
        "F max um": [t.about_nominal[0] / UM for t in found],
        "F min um": [t.about_nominal[1] / UM for t in found],
    }
