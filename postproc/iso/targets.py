"""Results of recordings of targets: positioning, rotary axes, angles, straightness, squareness,
diagonals."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from postproc.errors import Place
from postproc.iso import (
    IsoError,
    Options,
    Parameter,
    Result,
    Term,
    diagonals,
    positioning,
    straightness,
)
from postproc.iso.assign import LINEAR, Motion
from postproc.iso.lines import Line
from postproc.iso.positioning import Positioning
from postproc.iso.sampling import noise_of
from postproc.iso.straightness import NAMES, Straightness
from postproc.iso.uncertainty import combined, missing, positioning_parameters, terms_of
from postproc.units import UM, URAD

STANDARD = {
    "positioning": "ISO 230-2",
    "rotary": "ISO 230-2",
    "angle": "ISO 230-1",
    "straightness": "ISO 230-1",
    "diagonal": "ISO 230-6",
}


def result_of(motion: Motion, options: Options) -> Result:
    """The result of one motion."""
    test = positioning.evaluate(
        motion.position, motion.approach, motion.reading, motion.run,
        motion.test in ("rotary", "angle"),
    )  # fmt: skip
    angle = motion.recording.quantity == "angle"
    lengths = motion.test in ("positioning", "diagonal")
    # Straightness is a range across the motion: lengths, and with them temperature and the cosine
    # of the beam, have no part in it (length None); an angle likewise.
    names = frozenset(n for n, v in test.values.items() if v is not None) | frozenset(NAMES)
    length = test.length if lengths else None
    terms = terms_of(options.budget, motion.recording.u, length, names, test.runs < 2, angle)
    parameters = positioning_parameters(test, terms)
    notices = [*motion.recording.notices, *motion.notices, *_conditions(motion, test, options)]
    detail: Positioning | Straightness = test
    if motion.test == "straightness":
        detail = _line(motion, test, options)
        parameters = (*_straight(detail, terms), *parameters)
        notices.append(
            "E, M and B are of the readings as recorded, with the tilt of the reference in E and M"
        )
    if absent := missing(options.budget, motion.recording.u is not None, lengths, angle):
        notices.append(absent)
    if test.runs < 2 and not test.long:
        notices.append("one run: s, R and A are not defined, and U holds no scatter")
    noise = noise_of(test.s, test.n)
    return Result(
        motion.test, STANDARD[motion.test], subject(motion), motion.why, "urad" if angle else "um",
        (motion.recording.file,), parameters, terms, tuple(notices),
        _noise(motion, noise.s if noise else 0.0), _columns(test, angle, detail), detail,
    )  # fmt: skip


def _line(motion: Motion, test: Positioning, options: Options) -> Straightness:
    """Raises IsoError where no line can be laid through the means."""
    line = straightness.evaluate(options.line, test)
    if not any(line.lines.values()):
        raise IsoError(
            "no direction of approach has two targets: there is no line to lay through one",
            "a straightness needs two targets at least, approached in one direction",
            Place(motion.recording.file, int(motion.recording.lines[0])),
        )
    return line


def subject(motion: Motion) -> str:
    """EXX, or PPP of XYZ, and where the other axes stood."""
    name = f"{motion.subject} of {motion.axes}" if motion.test == "diagonal" else motion.subject
    return name + "".join(f", {x} {v:g}" for x, v in motion.at.items())


def _straight(lines: Straightness, terms: tuple[Term, ...]) -> tuple[Parameter, ...]:
    out = []
    for name in NAMES:
        runs = straightness.from_runs(lines.kind, lines.test, name)
        words = {"straightness": "straightness error, two-way mean"}.get(
            name, f"straightness error, approached in {name[-1]}"
        )
        parameter = Parameter(name, lines.errors[name], f"{words} ({lines.kind} line)")
        out.append(combined(parameter, terms, runs[0] if runs else None))
    return tuple(out)


def _conditions(motion: Motion, test: Positioning, options: Options) -> Iterator[str]:
    """What departs from the conditions of ISO 230-2, and what it means."""
    if not test.two_way:
        yield (
            f"approached in {'+' if np.isfinite(test.mean[0]).any() else '-'} only: reversal and"
            " all two-way parameters are not defined"
        )
    elif not test.both.all():
        one_way = ", ".join(f"{x:g}" for x in test.target[~test.both][:5])
        yield (
            f"approached in one direction only at {one_way}: B and M are taken over the"
            f" {int(test.both.sum())} other targets"
        )
    if test.long:
        yield (
            f"{test.length:g} mm is longer than 2 m: the standard asks for one run each way and"
            " defines E, M and B; s, R and A are not defined"
        )
    elif 2 <= test.runs < 5:
        yield (
            f"n = {test.runs} runs each way, the standard asks for 5: s, R and A are indicative"
            " only"
        )
    if test.n[test.n > 0].min() != test.n.max():
        yield f"the targets have between {test.runs} and {test.n.max()} runs"
    if test.runs < 2 <= test.n.max() and not test.long:
        yield "R and A are not defined: at some target s is not"
    yield from _targets(motion, test, options)


def _targets(motion: Motion, test: Positioning, options: Options) -> list[str]:
    """Number and places of the targets, and what a screw's lead makes of them."""
    if motion.test in ("angle", "straightness"):
        return []
    out = []
    least = _least(motion, test)
    if len(test.target) < least:
        out.append(
            f"{len(test.target)} targets on {test.length:g}"
            f" {'degrees' if motion.test == 'rotary' else 'mm'}: the standard asks for {least}"
        )
    if motion.test != "positioning":
        return out
    #    targets, a pitch apart      o       o       o
    #    error of that period      /\/   /\/   /\/       the same phase at each: a constant
    # Hence targets at unequal parts of the pitch (ISO 230-2), and a word where they are not.
    step = positioning.spacing(test.target)
    if (lead := options.leads.get(motion.axes, options.leads.get(""))) is not None:
        found = positioning.aliases(test.target, lead)
        out += [
            f"error with the period {lead / k:g} mm ({_part(k)} of {lead:g} mm): {words}"
            for k, words in found
        ]
        if not found:
            out.append(
                f"errors with the lead of {lead:g} mm or its parts to 1/4 fall on these targets at"
                " different phases: they look like scatter from target to target"
            )
    elif step is not None:
        out.append(
            f"targets are equidistant, {step:g} mm apart: errors with a period of {step:g},"
            f" {step / 2:g}, {step / 3:g}, {step / 4:g} ... mm are invisible; --lead says what this"
            " screw hides"
        )
    return out


def _part(k: int) -> str:
    return "the lead" if k == 1 else f"1/{k} of the lead"


def _least(motion: Motion, test: Positioning) -> int:
    """Targets that ISO 230-2 asks for."""
    if motion.test == "rotary":
        return 3 if test.length <= 90 else 5 if test.length <= 180 else 8
    if test.long:
        # beyond 2 m a target each 250 mm, below it five a metre, five at least (ISO 230-2)
        return math.floor(test.length / 250) + 1
    return max(5, math.ceil(5 * test.length / 1000 - 1e-9))


def _noise(motion: Motion, s: float) -> float:
    """mm or rad that the digits follow: the scatter of the runs, else what is stated of a reading,
    else its last digit."""
    if s > 0:
        return s
    if motion.recording.u:
        return motion.recording.u
    # Without runs and without a stated u the digits end where the instrument's own end. Below 1e-9
    # mm two readings differ by the rounding of their units alone.
    different = np.diff(np.unique(motion.reading))
    different = different[different > 1e-9]
    return float(different.min()) if len(different) else UM


def _columns(test: Positioning, angle: bool, detail: Any) -> dict[str, list[Any]]:
    """The table per target."""
    unit, name = (URAD, "urad") if angle else (UM, "um")

    def cells(values: np.ndarray) -> list[float | None]:
        return [float(v) if math.isfinite(v) else None for v in values / unit]

    out: dict[str, list[Any]] = {"target": [float(x) for x in test.target]}
    for row, sign in enumerate("+-"):
        out[f"n {sign}"] = [int(n) for n in test.n[row]]
        out[f"mean {sign} {name}"] = cells(test.mean[row])
        out[f"s {sign} {name}"] = cells(test.s[row])
    out[f"B {name}"] = cells(test.reversal)
    out[f"R {name}"] = cells(test.repeatability[2])
    if isinstance(detail, Straightness) and detail.off is not None:
        out[f"from line {name}"] = cells(detail.off[1])
    return out


def diagonals_of(found: list[tuple[Motion, Result]]) -> list[Result]:
    """E_d and B_d of every volume and face that diagonals were measured in."""
    out = []
    by_axes: dict[str, list[tuple[Motion, Result]]] = {}
    for motion, result in found:
        by_axes.setdefault(motion.axes, []).append((motion, result))
    for axes, members in by_axes.items():
        tests: dict[str, Positioning] = {}
        for motion, result in members:
            name = motion.subject
            # the same diagonal measured twice stays two: the largest of them all is asked for
            while name in tests:
                name += f" ({motion.recording.file})"
            tests[name] = result.detail
        results = dict(zip(tests, (r for _, r in members), strict=True))
        out.append(Result(
            "diagonals", "ISO 230-6", f"{axes} diagonals", f"{len(members)} diagonals of {axes}",
            "um", tuple(m.recording.file for m, _ in members), tuple(_of_diagonals(tests, results)),
            (), (diagonals.LIMIT, *_absent(axes, {m.subject for m, _ in members})),
            max(r.noise for _, r in members), _by_diagonal(tests), tests,
        ))  # fmt: skip
    return out


def _absent(axes: str, measured: set[str]) -> list[str]:
    """A notice of the diagonals that were not measured."""
    wanted = diagonals.every(axes)
    absent = [d for d in wanted if d not in measured]
    if not absent:
        return []
    return [
        f"{len(wanted) - len(absent)} of {len(wanted)} diagonals measured,"
        f" {', '.join(absent)} not: the largest may be among them"
    ]


def _of_diagonals(tests: dict[str, Positioning], results: dict[str, Result]) -> Iterator[Parameter]:
    """The largest E and B of all diagonals, and on which it is."""
    values, which = diagonals.largest(tests)
    for name, letter, words in (
        ("Ed", "E", "diagonal systematic deviation, largest E"),
        ("Bd", "B", "diagonal reversal, largest B"),
    ):
        source = results[which[name]][letter] if name in which else None
        u, runs = (source.U, source.runs) if source else (None, None)
        yield Parameter(name, values[name], words, which.get(name, ""), u, runs)


def _by_diagonal(tests: dict[str, Positioning]) -> dict[str, list[Any]]:
    """The values of each diagonal, by column, um."""
    columns: dict[str, list[Any]] = {"diagonal": list(tests)}
    for letter in ("E", "E+", "E-", "M", "B", "Bm", "A", "R"):
        values = [t.values[letter] for t in tests.values()]
        columns[f"{letter} um"] = [None if v is None else v / UM for v in values]
    return columns


def squareness_of(found: list[tuple[Motion, Result]], options: Options) -> list[Result]:
    """The squareness of every pair of axes of which each was read along the other."""
    # EYX and EXY: two straightnesses against one square tell the angle between its axes; a rotary
    # motion, or one that is read along another axis, has no partner.
    linear = [(m, r) for m, r in found if m.axes in LINEAR and m.across in LINEAR]
    return [
        _square_of((one, two), (first, second), options)
        for (one, first), (two, second) in itertools.combinations(linear, 2)
        if one.axes == two.across
        and two.axes == one.across
        and None not in (_best(first), _best(second))
    ]


def _best(result: Result) -> Line | None:
    """The line of a straightness that counts."""
    lines: Straightness = result.detail
    return lines.lines[lines.best]


def _of_square(name: str, stated: float | None, results: tuple[Result, Result]) -> Iterator[Term]:
    """Terms of U: of the square, stated in rad, and of the readings of both lines."""
    of = frozenset([name])
    if stated is not None:
        yield Term("square", stated, of, "stated, of the square itself")
    for result in results:
        for device in [t for t in result.terms if t.name == "device"][:1]:
            # The two ends of the line, each read with u, over the length between them: the slope of
            # an end-point line. A line through more targets is known better, so this is on the safe
            # side.
            u = device.u / result.detail.test.length
            yield Term(f"device, {result.subject}", u, of, "of the ends of the line")


def _scatter(results: tuple[Result, Result]) -> float | None:
    """rad: u of both slopes together, of the scatter of their runs; None where one is not known."""
    lines = [r.detail for r in results]
    runs = [straightness.from_runs(x.kind, x.test, x.best) for x in lines]
    known = [r[1] for r in runs if r and r[1] is not None]
    return math.hypot(*known) if len(known) == 2 else None


def _square_of(
    motions: tuple[Motion, Motion], results: tuple[Result, Result], options: Options
) -> Result:
    """The squareness of two axes."""
    slopes = [line.slope for r in results if (line := _best(r)) is not None]
    name, value = straightness.squareness(motions[0].axes, motions[1].axes, *slopes)
    stated = options.budget.square
    terms = tuple(_of_square(name, stated, results))
    words = "squareness, as a rotation about the third axis (ISO 841 signs)"
    notices = [
        "holds only if both runs were read against one and the same square or optical square"
    ]
    if stated is None:
        notices.append("not in U, since not stated: the square's own error")
    notices.append(
        f"the angle between the {options.line} lines is 90 degrees {-sum(slopes) / URAD:+.1f} urad"
    )
    return Result(
        "squareness",
        "ISO 230-1",
        name,
        f"{results[0].subject} and {results[1].subject} are straightnesses of two axes, each read"
        " along the other",
        "urad",
        (motions[0].recording.file, motions[1].recording.file),
        (combined(Parameter(name, value, words), terms, _scatter(results)),),
        terms,
        tuple(notices),
        max(r.noise / r.detail.test.length for r in results),
        {"run": [r.subject for r in results], "slope urad": [s / URAD for s in slopes]},
    )
