"""Positioning accuracy and repeatability of an axis, ISO 230-2 (2006 and 2014), with its own
letters.

x_ij: deviation at target i in run j; means per target and direction of approach; B reversal, E
systematic deviation, M mean two-way deviation, s estimated standard deviation, R repeatability, A
accuracy (k = 2). Row 0 of every (2, m) array is approached in +, row 1 in -.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

SAME = 0.01  # mm or degrees: targets nearer to each other are one target
LONG = 2000.0  # mm: beyond it one run each way is made, and nothing that rests on s is defined

MEANS = {
    "E": "two-way systematic deviation",
    "E+": "systematic deviation, approached in +",
    "E-": "systematic deviation, approached in -",
    "M": "range of the mean two-way deviation",
    "B": "reversal, largest",
    "Bm": "reversal, mean",
    "R": "two-way repeatability",
    "R+": "repeatability, approached in +",
    "R-": "repeatability, approached in -",
    "A": "two-way accuracy",
    "A+": "accuracy, approached in +",
    "A-": "accuracy, approached in -",
}


@dataclass(frozen=True)
class Positioning:
    """target (m,) mm or degrees; n (2, m) runs; mean, s (2, m) mm or rad, NaN where not defined;
    long: whether the axis is longer than 2 m, where only means are defined. position, reading, way,
    run (N,): the readings themselves."""

    target: np.ndarray
    n: np.ndarray
    mean: np.ndarray
    s: np.ndarray
    long: bool
    position: np.ndarray
    reading: np.ndarray
    way: np.ndarray
    run: np.ndarray

    @cached_property
    def two_way(self) -> bool:
        """Whether both directions were approached, at any targets."""
        return bool(np.isfinite(self.mean).any(axis=1).all())

    @cached_property
    def both(self) -> np.ndarray:
        """(m,) whether a target was approached in both directions."""
        return np.isfinite(self.mean).all(axis=0)

    @cached_property
    def reversal(self) -> np.ndarray:
        """(m,) B_i: mean approached in + less mean approached in -."""
        return self.mean[0] - self.mean[1]

    @cached_property
    def middle(self) -> np.ndarray:
        """(m,) mean two-way deviation."""
        return self.mean.mean(axis=0)

    @cached_property
    def repeatability(self) -> np.ndarray:
        """(3, m) R_i approached in +, in -, two-way."""
        # Two-way: the span from the lower edge of the lower cloud to the upper edge of the other,
        # 2 s + |B| + 2 s, unless one cloud alone is wider (ISO 230-2).
        #
        #      |<-- 4 s+ -->|
        #      |.....o......|                 o  mean of the runs in +, and in -
        #            |<-- B -->|
        #                |.....o......|
        #                |<-- 4 s- -->|
        #      |<------- R_i -------->|
        one = 4 * self.s
        two = 2 * self.s[0] + 2 * self.s[1] + np.abs(self.reversal)
        return np.vstack([one, np.maximum(two, one.max(axis=0))])

    @cached_property
    def has_s(self) -> np.ndarray:
        """(2,) whether s is defined at every target of a direction."""
        there = np.isfinite(self.mean)
        return there.any(axis=1) & (~there | np.isfinite(self.s)).all(axis=1)

    @cached_property
    def values(self) -> dict[str, float | None]:
        """The parameters by their letters, mm or rad; + and - are the arrows of the standard. None:
        not defined."""
        out: dict[str, float | None] = dict.fromkeys(MEANS)
        for row, sign in enumerate("+-"):
            if np.isfinite(self.mean[row]).any():
                out[f"E{sign}"] = _range(self.mean[row])
                if self.has_s[row]:
                    out[f"R{sign}"] = float(np.nanmax(self.repeatability[row]))
                    out[f"A{sign}"] = _range(
                        self.mean[row] + 2 * self.s[row], self.mean[row] - 2 * self.s[row]
                    )
        if self.two_way:
            out["E"] = _range(self.mean)
            if self.both.any():
                out["B"] = float(np.nanmax(np.abs(self.reversal)))
                out["Bm"] = float(np.nanmean(self.reversal))
                out["M"] = _range(self.middle)
            if self.has_s.all():
                out["A"] = _range(self.mean + 2 * self.s, self.mean - 2 * self.s)
                if self.both.any():
                    # Where a target has one direction only, its own R still counts for the largest.
                    out["R"] = float(np.nanmax(self.repeatability))
        return out

    @property
    def runs(self) -> int:
        """Least number of runs at any target and direction that was measured."""
        return int(self.n[self.n > 0].min())

    @property
    def length(self) -> float:
        """mm or degrees from the first target to the last."""
        return float(self.target[-1] - self.target[0])


def _range(upper: np.ndarray, lower: np.ndarray | None = None) -> float:
    return float(np.nanmax(upper) - np.nanmin(upper if lower is None else lower))


def targets_of(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(m,) targets, ascending, and (N,) the target of every reading."""
    order = np.argsort(position, kind="stable")
    index = np.empty(len(position), np.int64)
    # Sorted positions with a gap above SAME between them are two targets: recorded places of one
    # target differ by what the axis' own display does. A target's place is their mean.
    index[order] = np.cumsum(np.diff(position[order], prepend=-np.inf) > SAME) - 1
    return np.bincount(index, position) / np.bincount(index), index


def evaluate(
    position: np.ndarray,
    approach: np.ndarray,
    reading: np.ndarray,
    run: np.ndarray | None = None,
    rotary: bool = False,
) -> Positioning:
    """position (N,) mm or degrees, approach (N,) +1 or -1, reading (N,) mm or rad, run (N,) for
    figures only.

    Readings whose direction of approach is 0 are left out. Raises ValueError where no reading has a
    direction.
    """
    used = approach != 0
    if not used.any():
        raise ValueError("no direction of approach")
    position, approach, reading = position[used], approach[used], reading[used]
    run = np.ones(len(position)) if run is None else run[used]
    target, index = targets_of(position)
    m = len(target)
    # one number for target and direction: 0 .. m - 1 approached in +, m .. 2 m - 1 in -
    cell = index + np.where(approach > 0, 0, m)
    n = np.bincount(cell, minlength=2 * m)
    zero = float(reading.mean())  # squares of what is left lose no digits
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(cell, reading - zero, 2 * m) / n
        s = np.sqrt(np.bincount(cell, (reading - zero - mean[cell]) ** 2, 2 * m) / (n - 1))
    long = not rotary and float(np.ptp(target)) > LONG
    # one run has no scatter, which is not the same as a scatter of zero
    s[(n < 2) | long] = np.nan
    mean[n == 0] = np.nan
    return Positioning(
        target, n.reshape(2, m), mean.reshape(2, m) + zero, s.reshape(2, m), long, position,
        reading, approach, run,
    )  # fmt: skip


def spacing(target: np.ndarray) -> float | None:
    """mm between targets where they are equidistant (to 1 % of the spacing), else None."""
    if len(target) < 3:
        return None
    step = np.diff(target)
    return float(step.mean()) if np.ptp(step) <= 0.02 * step.mean() else None


def aliases(target: np.ndarray, lead: float) -> list[tuple[int, str]]:
    """What the targets make of an error that repeats `k` times per lead, k = 1 .. 4: (k, what it
    looks like).

    A period that fits a whole number of times between the targets looks constant; what a spacing
    can not follow looks like a longer wave (sampling theorem). ISO 230-2 asks for targets that are
    not at equal parts of the period.
    """
    out = []
    step = spacing(target)
    for k in range(1, 5):
        # Each target as the hand of a clock at its phase of the period: hands that all point one
        # way have a mean of length 1, hands all round the clock one near 0.
        alike = abs(np.exp(2j * np.pi * k * target / lead).mean())
        if alike > 0.99:
            out.append((k, "invisible: all targets lie at the same phase"))
            continue
        if step is None:
            continue
        turns = step * k / lead
        part = abs(turns - round(turns))
        # Phase runs on by `part` of a turn from target to target: less than half a turn over all of
        # them is no wave any more, half a turn from one to the next a zigzag, and above half a turn
        # per target the shorter way round is what is seen: a wave that is not there (sampling
        # theorem).
        if part * len(target) < 0.5:
            out.append((k, "nearly invisible: it looks like a slow drift along the axis"))
        elif abs(part - 0.5) < 0.02:
            out.append((k, "a zigzag from target to target, its size depends on the phase"))
        elif turns > 0.5:
            out.append((k, f"looks like a wave of {step / part:.4g} mm"))
    return out
