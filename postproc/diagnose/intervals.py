"""How sure a named parameter is: 95 % intervals that carry the noise, the map's own error, the
other members, values of a shape between those of the grid, and the choice among shapes that explain
nearly as well.

Shapes are averaged by their likelihood (Hoeting et al. 1999).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from postproc.diagnose.block import Block
from postproc.diagnose.library import FOUND, read
from postproc.diagnose.sets import Found, Sets
from postproc.diagnose.shapes import continuous

TWO_SIDED = 1.96
OF_SIZE, RESOLVED = 0.03, 0.05  # of a size; of a period over the span
UNKNOWN = 1.0  # of its value: how well a value of a shape is known beforehand
STEP = 1e-3  # of a shape's value
LIKELY = 1e-3  # of the likeliest shape's weight: less counts for nothing

Ends = dict[str, tuple[float, float]]


def of(sets: Sets, state: Found, k: int, scores: np.ndarray) -> tuple[dict[str, float], Ends]:
    """Named parameters of a member and their intervals. scores (B,): of all blocks given the other
    members."""
    block = sets.blocks[k]
    named, sd = _spread(sets, state, k)
    parts = [(1.0, named, sd)]
    if block.name not in FOUND and block.module.PER != "all":
        parts += _others(sets, state, k, scores, sd)
    return named, {name: _ends([(w, v[name], s[name]) for w, v, s in parts]) for name in named}


def _spread(sets: Sets, state: Found, k: int) -> tuple[dict[str, float], dict[str, float]]:
    """Named parameters and the standard deviation of each."""
    block, value = sets.blocks[k], sets.value(state.fit, k)
    free = list(continuous(block))
    # A value of the shape that is not exact shows, to first order, as its slope times the error:
    # one column more beside those of the block, and the intervals of both carry each other.
    slopes = [_slope(sets, block, value, name) for name in free]
    columns = np.concatenate([block.columns, *(s[:, None] for s in slopes)], axis=1)
    power, _ = sets.evidence.beside(state.fit, columns, but=k)
    first = sets.evidence.first[k]
    prior = np.concatenate(
        [
            state.fit.scale[k] * sets.evidence.slab[first : first + len(value)],
            [UNKNOWN * dict(block.shape)[name] for name in free],
        ]
    )
    covariance = np.linalg.inv(power + np.diag(1 / prior**2))
    named = block.module.parameters(value, dict(block.shape))
    by = _derivatives(block, value, free, np.sqrt(np.diag(covariance)))
    sd = {name: math.sqrt(max(float(d @ covariance @ d), 0.0)) for name, d in by.items()}
    fitted = {name for name, d in by.items() if d[: len(value)].any()}
    return named, {
        name: math.hypot(s, _of_form(sets, block, name, named[name], name in fitted))
        for name, s in sd.items()
    }


def _of_form(sets: Sets, block: Block, name: str, value: float, fitted: bool) -> float:
    """Standard deviation of a parameter for want of the exact form: a size to a few percent, a
    period to some of what the readings resolve, a moment to the readings beside it."""
    rows = sets.rows
    shown = np.any(block.columns != 0, axis=1)
    if name in ("t_s", "second_s", "third_s"):
        t = np.unique(rows.state.time)
        k = int(np.clip(np.searchsorted(t, value), 1, len(t) - 1))
        return float(t[k] - t[k - 1]) / 2
    shape = dict(block.shape)
    if name == "period_mm" and shape.get("scatter"):
        return value * shape["scatter"] / math.sqrt(len(rows.slips[block.axis].ways))
    if name == "period_mm":
        return (
            RESOLVED * value**2 / max(float(np.ptp(rows.state.position[block.axis][shown])), 1e-9)
        )
    if name == "frequency_hz":
        passages = rows.state.passage[shown]
        return RESOLVED / max(
            float(np.ptp(rows.state.time[shown][passages == p])) for p in np.unique(passages)
        )
    return OF_SIZE * abs(value) if fitted else 0.0


def _slope(sets: Sets, block: Block, value: np.ndarray, name: str) -> np.ndarray:
    """(N,) by how much the block's part changes with a value of its shape."""
    shape = dict(block.shape)
    step = STEP * shape[name]
    if block.name in FOUND:  # so that the wave keeps its phase within the readings
        place = (
            sets.rows.state.time if name == "frequency_hz" else sets.rows.state.position[block.axis]
        )
        # by at most a hundredth of a period over all readings
        step = min(
            step,
            0.01
            * shape[name] ** (2 if name == "period_mm" else 0)
            / max(float(np.ptp(place)), 1e-9),
        )
    high, low = (
        read(sets.rows, block.module, block.axis, {**shape, name: shape[name] + way * step})
        for way in (1, -1)
    )
    if high.shape[1] != len(value):
        return np.zeros(len(sets.evidence.y))
    slope: np.ndarray = (high - low) @ value / (2 * step)
    return slope


def _derivatives(
    block: Block, value: np.ndarray, free: list[str], sd: np.ndarray
) -> dict[str, np.ndarray]:
    """Of each named parameter by the coefficients and by the free values of the shape."""
    shape = dict(block.shape)
    named = block.module.parameters(value, shape)
    result = {name: np.zeros(len(value) + len(free)) for name in named}
    for i in range(len(value) + len(free)):
        step = 1e-4 * max(float(sd[i]), 1e-9)
        moved, there = value.copy(), dict(shape)
        if i < len(value):
            moved[i] += step
        else:
            there[free[i - len(value)]] += step
        for name, v in block.module.parameters(moved, there).items():
            result[name][i] = (v - named[name]) / step
    return result


# Whole: one shape from its weight to its spread, each needing the last.
def _others(
    sets: Sets, state: Found, k: int, scores: np.ndarray, sd: dict[str, float]
) -> list[tuple[float, dict[str, float], dict[str, float]]]:  # fmt: skip
    """Weight, parameters and their standard deviations of other shapes of the same effect and
    axis."""
    block, own, result = sets.blocks[k], float(scores[k]), []
    chosen_now = block.module.parameters(sets.value(state.fit, k), dict(block.shape))
    for number, (other, score) in enumerate(zip(sets.blocks, scores, strict=True)):
        if other.key != block.key or number == k or not np.isfinite(score + own):
            continue
        # scores are twice a logarithm; a shape that is likelier than the chosen one counts as much
        # as it
        weight = math.exp(min((float(score) - own) / 2, 0.0))
        if weight < LIKELY:
            continue
        power, along = sets.evidence.beside(state.fit, other.columns, but=k)
        first = sets.evidence.first[number]
        slab = state.fit.scale[k] * sets.evidence.slab[first : first + len(along)]
        covariance = np.linalg.inv(power + np.diag(1 / slab**2))
        value = covariance @ along
        named = other.module.parameters(value, dict(other.shape))
        if any(
            named[name] * chosen_now[name] < 0 for name in named if name not in dict(other.shape)
        ):
            continue  # of another sign it is another story
        by = _derivatives(other, value, [], np.sqrt(np.diag(covariance)))
        spread = {name: math.sqrt(max(float(d @ covariance @ d), 0.0)) for name, d in by.items()}
        shown, mine = ({name for name, v in each.items() if v > 0} for each in (spread, sd))
        if shown - mine and mine - shown:
            continue  # of another form: its coefficients are of something else
        # What the shape states is a choice, no size: its interval is that of the chosen one.
        fixed = {
            name: (named[name], max(spread[name], sd[name]))
            for name in named
            if name not in dict(other.shape)
        }
        chosen = block.module.parameters(np.zeros(block.width), dict(block.shape))
        values = {name: fixed[name][0] if name in fixed else chosen[name] for name in named}
        result.append(
            (
                weight,
                values,
                {name: fixed[name][1] if name in fixed else sd[name] for name in named},
            )
        )
    return result


def _ends(parts: list[tuple[float, float, float]]) -> tuple[float, float]:
    """The interval that holds 95 % of a mixture of normal distributions (weight, mean, standard
    deviation), half of the rest on either side."""
    total = sum(w for w, _, _ in parts)
    # ends between which bisection looks for the quantiles of the mixture
    low, high = min(m - 5 * s for _, m, s in parts), max(m + 5 * s for _, m, s in parts)
    if len(parts) == 1 or high <= low:
        _, mean, sd = parts[0]
        return mean - TWO_SIDED * sd, mean + TWO_SIDED * sd

    def below(x: float) -> float:
        return sum(w * _normal(x - m, s) for w, m, s in parts) / total

    return _where(below, 0.025, low, high), _where(below, 0.975, low, high)


def _normal(x: float, sd: float) -> float:
    return 0.5 * (1 + math.erf(x / (sd * math.sqrt(2.0)))) if sd > 0 else float(x >= 0)


def _where(of: Callable[[float], float], share: float, low: float, high: float) -> float:
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if of(middle) < share else (low, middle)
    return (low + high) / 2
