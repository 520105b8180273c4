"""What a drive has to push against, from its recorded force or current: inertia, friction, and what
else the signal asks for.

The response is `force_<axis>_N`, or `<axis>_current_A` where no force was recorded; the motion is
that which the axis really made. Both go through the same low-pass, so that a derivative and the
force are late alike (parallel filtering: Gautier, Khalil, IEEE ICRA 1992). Samples at rest are left
out: there friction is whatever it needs to be. A term is let in if chi squared falls by what the
selection of effects asks for, counted in samples that are not alike, and if either half of the
recording, fitted alone, tells the other half better with it than without.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from postproc.diagnose.drive_terms import Motion, Term, terms
from postproc.recordings import Recording

WIDTH = 0.010  # s: standard deviation of the low-pass; slower logs stay as they are
FEWEST = 60  # samples in motion
REST = 0.004  # of the highest speed
LEAST = 28.0  # fall of chi squared beyond ln(samples) a column, as for effects
GAIN = 0.02  # of the rms: by so much each half must be told better
MOST = 8
# What is an effect of its own: every drive accelerates a mass, and a path errs by that only where
# positions show it.
NAMES = ("viscous_friction", "coulomb_friction", "friction_asymmetry")
DELAY = "force_delay"
FAR = 1e6  # mm


@dataclass(frozen=True)
class Fitted:
    """One term: its parameters and their 95 % intervals by name, what it contributes (rms, in the
    unit of the response), by how much chi squared falls, what the held-out halves are told by
    before and after it came in, and whether a delay between force and motion would say as much: at
    one speed of a circle the jerk goes with the velocity."""

    term: Term
    value: dict[str, float]
    ci95: dict[str, tuple[float, float]]
    rms: float
    delta_chi2: float
    before: float
    after: float
    delayed: bool = False


@dataclass(frozen=True)
class Drive:
    """One axis' force or current. signal: its column; unit; files; fitted: the terms in the order
    in which they came; raw: rms of the response in motion; plain: rms of the halves that took no
    part with inertia, viscous and Coulomb friction alone (those of them that the signal asks for);
    after: with all terms; refused: terms that did not help."""

    axis: str
    signal: str
    unit: str
    files: tuple[str, ...]
    samples: int
    fitted: tuple[Fitted, ...]
    raw: float
    plain: float
    after: float
    refused: tuple[str, ...]


# Whole: three lists under one loop; the branches are their conditions.
def drives(recordings: Sequence[Recording]) -> list[Drive]:
    """The drive of every axis whose force or current was recorded while it moved, all traces
    together."""
    result = []
    letters = sorted({x for r in recordings if r.kind == "trace" for x in r.axes if x in "XYZ"})
    for axis in letters:
        for signal, unit in ((f"force_{axis}_N", "N"), (f"{axis}_current_A", "A")):
            own = [
                r
                for r in recordings
                if r.kind == "trace" and signal in r.columns and axis in r.axes
            ]
            motion = [m for r in own for m in _motions(r, axis, signal)]
            found = _fit(axis, signal, unit, tuple(r.file for r in own), motion) if motion else None
            if found is not None:
                result.append(found)
                break
    return result


def _motions(recording: Recording, axis: str, signal: str) -> list[Motion]:
    """The unbroken passages of a trace, filtered."""
    time = recording.columns["t_s"]
    run = recording.columns.get("run", np.zeros(len(time)))
    response = recording.columns[signal]
    asked = recording.columns.get(f"{axis}_cmd_velocity_mm_s")
    known = np.isfinite(response)  # an empty cell costs its sample, not the whole passage
    cut = np.flatnonzero((np.diff(run) != 0) | (np.diff(time) <= 0) | (np.diff(known) != 0)) + 1
    result: list[Motion] = []
    for part in np.split(np.arange(len(time)), cut):
        if len(part) < 20 or not known[part].all() or np.ptp(response[part]) == 0:
            continue
        step = float(np.median(np.diff(time[part])))
        place = recording.columns.get(f"{axis}_act_mm", recording.position(axis))[part]
        speed = recording.columns.get(f"{axis}_act_velocity_mm_s")
        #     place - d/dt - low-pass - v - d/dt - a - d/dt - jerk
        #                  - narrow low-pass - sign - low-pass - sense
        #     force ------- low-pass - response
        # One low-pass for both sides, so that what it changes it changes in both (parallel
        # filtering).
        exact = _stated(speed, part, np.gradient(place, time[part]))
        wide = max(round(WIDTH / step), 0)
        v = _low(exact, wide)
        v = v if wide else exact
        a = np.gradient(v, time[part])
        kernel = _low(
            np.where(np.abs(exact) > 0, np.sign(_low(exact, max(wide // 3, 0))), 0.0), wide
        )
        # Behind the low-pass neighbours within its width say the same, and its ends are made up.
        every = slice(2 * wide, len(part) - 2 * wide or None, max(wide, 1))
        result.append(
            Motion(
                place[every],
                v[every],
                a[every],
                np.gradient(a, time[part])[every],
                kernel[every],
                _gone(place, np.sign(v))[every],
                _low(response[part], wide)[every],
                time[part][every],
                _low(
                    _stated(asked, part, np.gradient(recording.position(axis)[part], time[part])),
                    wide,
                )[every],
            )
        )
    return result


def _stated(speed: np.ndarray | None, part: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(N,) mm/s: the recorded speed of a passage; where it is not known, that by the places."""
    return places if speed is None else np.where(np.isfinite(speed[part]), speed[part], places)


def _gone(place: np.ndarray, sign: np.ndarray) -> np.ndarray:
    """(N,) mm that the axis has gone since it turned back; far at the beginning, where nobody
    knows."""
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(place)))])
    turn = np.concatenate([[False], sign[1:] * sign[:-1] < 0])
    last = np.maximum.accumulate(np.where(turn, np.arange(len(place)), -1))
    return np.where(last >= 0, way - way[np.maximum(last, 0)], FAR)


def _low(values: np.ndarray, wide: int) -> np.ndarray:
    """Gaussian low-pass of a standard deviation of so many samples; ends repeated."""
    if wide < 1:
        return values
    reach = 4 * wide
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / wide) ** 2)
    return np.convolve(np.pad(values, reach, mode="edge"), kernel / kernel.sum(), mode="valid")


def _fit(
    axis: str, signal: str, unit: str, files: tuple[str, ...], parts: list[Motion]
) -> Drive | None:
    whole = Motion.joined(parts)
    fastest = float(np.abs(whole.velocity).max())
    # At rest friction is whatever it needs to be: neither where the axis hardly moves nor where it
    # is not told to.
    moving = (np.abs(whole.velocity) > REST * fastest) & (np.abs(whole.asked) > REST * fastest)
    if (
        moving.sum() < FEWEST
        or fastest == 0
        or not (np.any(whole.velocity > 0) and np.any(whole.velocity < 0))
    ):
        return None
    whole = whole.pick(moving)
    y = whole.response
    fit = _Fit(y, _halves(whole), [(t, t.columns(whole)) for t in terms(whole, unit)])
    plain = fit.pruned([k for k, (t, _) in enumerate(fit.possible) if t.plain])
    chosen = fit.grown(plain)
    refused = sorted({t.name for t, _ in fit.possible} - {fit.possible[k][0].name for k in chosen})
    return Drive(
        axis,
        signal,
        unit,
        files,
        len(y),
        fit.fitted(chosen),
        float(np.sqrt(np.mean(y**2))),
        _rms(fit.across(plain)),
        _rms(fit.across(chosen)),
        tuple(refused),
    )


def _halves(motion: Motion) -> np.ndarray:
    """(N,) bool: the second half; of several recordings every other one, else by time."""
    passages, many = np.unique(motion.passage, return_counts=True)
    if len(passages) > 1:
        order = passages[np.argsort(many)[::-1]]
        size, second = [0, 0], np.zeros(len(motion.response), bool)
        for p in order:  # the long ones first, each to the half that has less
            own = motion.passage == p
            half = int(size[1] < size[0])
            size[half] += int(own.sum())
            second |= own if half else False
        return second
    return np.arange(len(motion.response)) >= len(motion.response) // 2


def _solve(design: np.ndarray, y: np.ndarray) -> np.ndarray:
    terms: np.ndarray = np.linalg.lstsq(design, y, rcond=None)[0]
    return terms


def _design_matrix(columns: list[np.ndarray], n: int) -> np.ndarray:
    return np.concatenate(columns, axis=1) if columns else np.zeros((n, 0))


def _alike(left: np.ndarray) -> float:
    """By how many samples one counts: neighbours that are alike tell less."""
    total = float(left @ left)
    # n / (1 + 2 sum rho_k): the number of independent samples whose mean is as sure. Up to the
    # first rho below 0.05: over all lags the sum of a series about its mean is -1/2 always.
    rho = (
        [float(left[k:] @ left[:-k]) / total for k in range(1, min(len(left) // 4, 200))]
        if total > 0
        else []
    )
    stop = next((k for k, r in enumerate(rho) if r < 0.05), len(rho))
    return 1.0 + 2.0 * sum(rho[:stop])


def _rms(values: np.ndarray | list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


class _Fit:
    """A response (N,), which samples are the second half, and the terms that there may be with
    their columns."""

    def __init__(self, y: np.ndarray, second: np.ndarray, possible: list[tuple[Term, np.ndarray]]):
        self.y, self.second, self.possible = y, second, possible
        wide = _design_matrix([c for t, c in possible if not t.shape], len(y))
        self.free = len(y) / _alike(
            y - wide @ _solve(wide, y)
        )  # samples that are not alike, once all that is smooth is told

    def _columns(self, chosen: list[int]) -> np.ndarray:
        return _design_matrix([self.possible[k][1] for k in chosen], len(self.y))

    def across(self, chosen: list[int]) -> list[float]:
        """rms of each half as the other half tells it."""
        design = self._columns(chosen)
        return [
            _rms((self.y - design @ _solve(design[fit], self.y[fit]))[~fit])
            for fit in (self.second, ~self.second)
        ]

    def gain(self, rest: list[int], k: int) -> float:
        """By how much chi squared falls when a term joins the rest; 0 where it does not tell both
        halves better, or has a sign that it can not have."""
        term, columns = self.possible[k]
        design = self._columns(rest)
        wider = np.concatenate([design, columns], axis=1)
        left, value = self.y - design @ _solve(design, self.y), _solve(wider, self.y)
        own = self.y - wider @ value
        # n ln(S0 / S1), twice the logarithm of the likelihood ratio where the noise is not known,
        # with the samples that are not alike in the place of n
        fall = self.free * float(np.log(float(left @ left) / max(float(own @ own), 1e-300)))
        if fall < LEAST + columns.shape[1] * np.log(self.free) + 2 * np.log(term.siblings):
            return 0.0
        # a negative mass or friction that drives is another term in disguise
        if term.positive and value[design.shape[1]] < 0:
            return 0.0
        if any(
            a > (1 - GAIN) * b
            for a, b in zip(self.across([*rest, k]), self.across(rest), strict=True)
        ):
            return 0.0
        return fall

    def beside(self, chosen: list[int], k: int) -> float:
        """The gain of a term that leaves the plain ones their own: what does away with dry friction
        only renames it."""
        gain = self.gain(chosen, k)
        plain = [c for c in chosen if self.possible[c][0].plain]
        if gain <= 0 or all(self.gain([*(c for c in chosen if c != p), k], p) > 0 for p in plain):
            return gain
        return 0.0

    def pruned(self, chosen: list[int]) -> list[int]:
        """Without the terms that the signal does not ask for."""
        while chosen:
            gains = [self.gain([c for c in chosen if c != k], k) for k in chosen]
            if min(gains) > 0:
                return chosen
            chosen = [c for i, c in enumerate(chosen) if i != int(np.argmin(gains))]
        return chosen

    def grown(self, chosen: list[int]) -> list[int]:
        """With what else tells the response better, the best first; then once more without what
        that made needless."""
        while len(chosen) < MOST:
            names = {self.possible[k][0].name for k in chosen}
            gains = [
                0.0 if term.name in names else self.beside(chosen, k)
                for k, (term, _) in enumerate(self.possible)
            ]
            if max(gains) <= 0:
                break
            chosen = [*chosen, int(np.argmax(gains))]
        return self.pruned(chosen)

    def fitted(self, chosen: list[int]) -> tuple[Fitted, ...]:
        design = self._columns(chosen)
        value = _solve(design, self.y)
        left = self.y - design @ value
        # As if only `free` samples had been read: (X'X)^-1 S / (free - p).
        spread = float(left @ left) / max(self.free - len(value), 1.0) * self.free / len(self.y)
        covariance = np.linalg.pinv(design.T @ design) * spread * len(self.y) / self.free
        result, at = [], 0
        for i, k in enumerate(chosen):
            term, columns = self.possible[k]
            part = slice(at, at + columns.shape[1])
            at += columns.shape[1]
            named = term.named(value[part])
            error = term.errors(value[part], covariance[part, part])
            ci = {
                n: (v - 1.96 * error.get(n, 0.0), v + 1.96 * error.get(n, 0.0))
                for n, v in named.items()
            }
            before, after = (_rms(self.across(chosen[:stop])) for stop in (i, i + 1))
            rest = [c for c in chosen if c != k]
            rms = _rms(columns @ value[part])
            # Jerk times a delay is a force that is late by it. At one speed of a circle jerk is
            # -omega^2 v, so that viscous friction and a delay are one column.
            late = [
                c for c, (t, _) in enumerate(self.possible) if t.name == DELAY and c not in chosen
            ]
            delayed = bool(late) and self.gain([*rest, *late], k) <= 0
            fall = self.gain(rest, k)
            result.append(Fitted(term, named, ci, rms, fall, before, after, delayed))
        return tuple(result)
