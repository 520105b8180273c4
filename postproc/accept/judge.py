"""The parameters of ISO 230-2 before and after, how much less they are, what the map had to do with
it, what is left."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from postproc.accept import AcceptError, Change, Outcome, signs
from postproc.iso import Options, Parameter, Result, targets
from postproc.iso.assign import Motion
from postproc.iso.positioning import Positioning
from postproc.iso.sampling import about, noise_of
from postproc.iso.straightness import Straightness
from postproc.iso.uncertainty import combined
from postproc.machine import overshoot
from postproc.machine.chain import ROTARY
from postproc.machine.model import Machine

SHOWN = ("A", "E", "R", "B", "straightness")
LARGEST = "largest"
FEW = 1e-9  # mm or rad: nothing was there before


def outcome(before: Motion, after: Motion, machine: Machine | None, options: Options) -> Outcome:
    """All of one pair of motions."""
    results = [targets.result_of(m, options) for m in (before, after)]
    whole = [_test(r) for r in results]
    # each on the targets of the other: what only one of them has can not be compared
    second = _on(whole[1], whole[0])
    tests = [_on(whole[0], second), second]
    if not len(second.target):
        raise AcceptError(
            f"{after.recording.file} and {before.recording.file} share no target",
            "measure at the same targets",
        )
    line = before.test == "straightness"
    angle = before.test == "angle"
    found = () if angle else tuple(signs.ratios(tests[0], tests[1], line))
    means, scatter = _left(tests[1], line)
    notices = _notices(before, tests)
    if {len(t.target) for t in whole} != {len(second.target)}:
        notices.append(f"only the {len(second.target)} targets of both measurements are compared")
    return Outcome(
        targets.subject(before), results[0].unit, before, after,
        tuple(_changes(results, tests, line)), found,
        None if machine is None or angle else _acted(before, tests, machine, line), means, scatter,
        _repeat(second), tuple(notices), _curves(tests),
    )  # fmt: skip


def _test(result: Result) -> Positioning:
    return result.detail.test if isinstance(result.detail, Straightness) else result.detail


def _on(test: Positioning, other: Positioning) -> Positioning:
    """A test on the targets that both have, in the other's order."""
    # 0.02 mm: targets of a corrected program come back on the nominal ones by `_nominal`, and a
    # display rounds. Each target once, whatever the order of the file.
    near = np.abs(test.target[:, None] - other.target[None, :]).argmin(axis=0)
    near = np.unique(near[np.abs(test.target[near] - other.target) < 0.02])
    return replace(
        test, target=test.target[near], n=test.n[:, near], mean=test.mean[:, near],
        s=test.s[:, near],
    )  # fmt: skip


def _about(test: Positioning, line: bool) -> np.ndarray:
    """(2, m) means about the zero (or the line) of the mean of both directions."""
    middle = np.nanmean(test.mean, axis=0)
    there = np.isfinite(middle)
    if line and there.sum() > 2:
        return test.mean - np.polyval(np.polyfit(test.target[there], middle[there], 1), test.target)
    return test.mean - np.nanmean(middle)


def _left(test: Positioning, line: bool) -> tuple[float, float | None]:
    noise = noise_of(test.s, test.n)
    rms = float(np.sqrt(np.nanmean(_about(test, line) ** 2)))
    return rms, None if noise is None else float(np.sqrt(np.nanmean(noise.u**2)))


def _repeat(test: Positioning) -> float | None:
    """4 s of the worst target: of one direction, so that no reversal is in it."""
    found = [test.values[name] for name in ("R+", "R-")]
    return max((v for v in found if v is not None), default=None)


def _changes(results: list[Result], tests: list[Positioning], line: bool) -> list[Change]:
    both = [
        {p.name: p for p in r.parameters} | {LARGEST: _largest(r, t, line)}
        for r, t in zip(results, tests, strict=True)
    ]
    before, after = both
    names = [n for n in (*SHOWN, LARGEST) if n in before.keys() & after.keys()]
    return [_change(before[n], after[n]) for n in _judged(names, before, line)]


def _judged(names: list[str], before: dict[str, Parameter], line: bool) -> list[str]:
    """The parameters that set-up does not decide where a line is taken off, and those of one
    direction where there are none of both."""
    if line:
        return [n for n in names if n not in ("A", "E")]
    if "A" in before and before["A"].value is not None:
        return names
    return [n for n in ("A+", "A-", "E+", "E-") if before[n].value is not None] + names


def _largest(result: Result, test: Positioning, line: bool) -> Parameter:
    """The largest deviation from the zero (or line) of the mean, which no set-up decides."""
    noise = noise_of(test.s, test.n)
    values = _about(test, line)

    def largest(means: np.ndarray) -> np.ndarray:
        return np.nanmax(
            np.abs(means - np.nanmean(means, axis=(-2, -1), keepdims=True)), axis=(-2, -1)
        )

    # drawn again as the largest of ISO 230-2's means is (iso/sampling.py)
    runs = None if noise is None or not noise.s else about(values, noise, largest)
    terms = tuple(
        replace(t, of=frozenset([LARGEST])) for t in result.terms if t.of & {"E", "E+", "E-"}
    )
    what = (
        "largest deviation from the line of the mean"
        if line
        else "largest deviation from their mean"
    )
    return combined(Parameter(LARGEST, float(np.nanmax(np.abs(values))), what), terms, runs)


def _change(before: Parameter, after: Parameter) -> Change:
    """1 - after / before, and its U of first order in both."""
    b, a = before.value, after.value
    if b is None or a is None or b < FEW:
        return Change(before, after, None, None)
    if before.U is None or after.U is None:
        return Change(before, after, 1 - a / b, None)
    # f = 1 - a / b: df/da = -1 / b, df/db = a / b**2; before and after are independent measurements
    # (JCGM 100, 5.1.2).
    return Change(before, after, 1 - a / b, math.hypot(after.U / b, a * before.U / b**2))


def _acted(motion: Motion, tests: list[Positioning], machine: Machine, line: bool) -> float | None:
    """How much of what the map states was taken out: least squares of before - after against the
    map."""
    stated = _stated(motion, tests[0].target, machine)
    if stated is None:
        return None
    wanted = np.isfinite(tests[0].mean) & np.isfinite(tests[1].mean)
    maps = replace(tests[0], mean=np.where(wanted, stated, np.nan))
    gone = replace(tests[0], mean=np.where(wanted, tests[0].mean - tests[1].mean, np.nan))
    # least squares of d = k p: k = 1 where all was taken out that the map says, -1 where it was
    # added
    p, d = (np.nan_to_num(_about(t, line)).ravel() for t in (maps, gone))
    return float(d @ p / (p @ p)) if p @ p > len(p) * signs.LEAST**2 else None


def _stated_turn(axis: str, target: np.ndarray, machine: Machine) -> np.ndarray | None:
    """(2, m) rad that the table of a rotary axis states of its own angle."""
    table = machine.tables.get(axis)
    if table is None:
        return None
    row = 3 + ROTARY.index(axis)
    ways = (table.forward[row], table.reverse[row])
    return np.stack([np.interp(target, table.nodes, w) for w in ways])


def _stated(motion: Motion, target: np.ndarray, machine: Machine) -> np.ndarray | None:
    """(2, m) mm or rad that the map states along a motion, approached in + and in -."""
    if not set(motion.axes) <= machine.axes.keys():
        return None
    if motion.test == "rotary":
        return _stated_turn(motion.axes, target, machine)
    position, approach = _commands(motion, target, machine)
    along = motion.unit if motion.test == "diagonal" else {motion.subject[1]: 1.0}
    rows = [(machine.letters.index(x), c) for x, c in along.items() if x in machine.letters]
    # all axes of the motion reached in +, then all in -: a diagonal's two directions
    off = [machine.deviation(position, sign * approach) for sign in (1.0, -1.0)]
    return np.stack([sum((c * o[row] for row, c in rows), np.zeros(target.shape)) for o in off])


def _commands(
    motion: Motion, target: np.ndarray, machine: Machine
) -> tuple[np.ndarray, np.ndarray]:
    """(A, m) mm: where the axes stand at targets along a motion, and (A, m) their approach in +."""
    position, approach = np.zeros((2, len(machine.letters), len(target)))
    # Positions of a diagonal count from its first target (iso/assign.py): the others follow from
    # where the axes stood there and their shares of the way.
    way, lowest = target - motion.position.min(), motion.position.argmin()
    for row, x in enumerate(machine.letters):
        position[row] = motion.at.get(x, 0.0)
        if x in motion.axes:
            position[row] = float(motion.recording.position(x)[lowest]) + way * motion.unit[x]
            approach[row] = np.sign(motion.unit[x])
    return position, approach


def _notices(before: Motion, tests: list[Positioning]) -> list[str]:
    """What is odd about the pair."""
    said = []
    if before.test == "angle":
        said.append("an angle is not changed by moving slides: no sign is judged by it")
    if before.test in ("positioning", "rotary"):
        text = overshoot.sentence(before.subject, -tests[0].reversal)
        said += [f"{before.recording.file}: {text}"] if text else []
    return said


def _curves(tests: list[Positioning]) -> dict[str, list[float | None]]:
    """Targets and means about their zero, mm or rad, for a figure."""
    out: dict[str, list[float | None]] = {"target": [float(x) for x in tests[0].target]}
    for name, test in zip(("before", "after"), tests, strict=True):
        middle = np.nanmean(test.mean)
        for row, sign in enumerate("+-"):
            out[f"{name} {sign}"] = [
                float(v) if math.isfinite(v) else None for v in test.mean[row] - middle
            ]
    return out
