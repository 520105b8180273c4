"""How sure a named parameter is: 95 % intervals that carry the noise, the map's own error, what is left and repeats, values of a
shape between those of the grid, and the choice among shapes that explain nearly as well.

What is left may be alike in neighbours, or at the same places again and again, since no form is exactly the library's: the
covariance is also taken from sums of what is left over stretches of time and over places (Liang and Zeger 1986), and the larger counts.
Shapes are averaged by their likelihood (Hoeting et al. 1999).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from postproc.diagnose.fit import Projector, solve
from postproc.diagnose.library import FOUND, Block, read
from postproc.diagnose.rows import Rows
from postproc.diagnose.select import Model, Selector
from postproc.diagnose.waves import continuous

TWO_SIDED = 1.96
STRETCHES, PLACES, FEWEST = 12, 12, 6  # of a signal in time, of an axis' way; clusters from which on they tell a spread
STEP = 1e-3  # of a shape's value
LIKELY = 1e-3  # of the likeliest shape's weight: less counts for nothing

Ends = dict[str, tuple[float, float]]


def of(
    selector: Selector, model: Model, k: int, chosen: list[int], scores: np.ndarray
) -> tuple[dict[str, float], Ends]:
    """Named parameters of the k-th block of the model and their intervals. scores (B,): of all blocks given the other chosen."""
    block = model.blocks[k]
    named, sd = _spread(selector, model, k)
    parts = [(1.0, named, sd)]
    if block.name not in FOUND:
        rest = [c for c in chosen if c != chosen[k]]
        parts += _others(selector, model, block, rest, scores, float(scores[chosen[k]]), sd)
    return named, {name: _ends([(w, v[name], s[name]) for w, v, s in parts]) for name in named}


def _spread(selector: Selector, model: Model, k: int) -> tuple[dict[str, float], dict[str, float]]:
    """Named parameters and the standard deviation of each."""
    block, part = model.blocks[k], model.part(k)
    value = model.coefficients[part]
    p = selector.projector([], model.sigma)
    columns = [b.columns for b in model.blocks]
    free = list(continuous(block))
    slopes = [_slope(selector, block, value, name) for name in free]
    columns += [s[:, None] for s in slopes]
    all_columns = np.concatenate(columns, axis=1)
    _, covariance = solve(p, all_columns, selector.y)
    own = [*range(part.start, part.stop), *range(all_columns.shape[1] - len(free), all_columns.shape[1])]
    named = block.module.parameters(value, dict(block.shape))
    by = _derivatives(block, value, free, np.sqrt(np.diag(covariance)[own]))
    covariances = [(covariance, TWO_SIDED)]
    left = selector.y - model.explained
    left = left - p.nuisance(left)
    score = p(all_columns) * left[:, None]
    for clusters in _clusters(selector.rows, block.axis):
        number = int(clusters.max()) + 1
        if number >= FEWEST:
            sums = np.stack([np.bincount(clusters, column, number) for column in score.T], axis=1)
            robust = covariance @ (sums.T @ sums) @ covariance * (number / (number - 1))
            covariances.append((robust, TWO_SIDED + 2.37 / (number - 1)))  # of Student's t
    sd = {
        name: max(t / TWO_SIDED * math.sqrt(max(float(d @ c[np.ix_(own, own)] @ d), 0.0)) for c, t in covariances)
        for name, d in by.items()
    }
    return named, sd


def _slope(selector: Selector, block: Block, value: np.ndarray, name: str) -> np.ndarray:
    """(N,) by how much the block's part changes with a value of its shape."""
    shape = dict(block.shape)
    step = STEP * shape[name]
    if block.name in FOUND:  # so that the wave keeps its phase within the readings
        place = selector.rows.state.time if name == "frequency_hz" else selector.rows.state.position[block.axis]
        step = min(step, 0.01 * shape[name] ** (2 if name == "period_mm" else 0) / max(float(np.ptp(place)), 1e-9))
    high, low = (
        read(selector.rows, block.module, block.axis, {**shape, name: shape[name] + way * step}) for way in (1, -1)
    )
    if high.shape[1] != len(value):
        return np.zeros(len(selector.y))
    return (high - low) @ value / (2 * step)


def _derivatives(block: Block, value: np.ndarray, free: list[str], sd: np.ndarray) -> dict[str, np.ndarray]:
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
    if block.name in FOUND:  # known to the error of the place's own scale and of the clock, which nobody stated
        for name in free:
            result[name][:] = 0.0
    return result


def _clusters(rows: Rows, axis: str) -> list[np.ndarray]:
    """(N,) numbers: of stretches of each signal in time, and of places along the axes, by side, of each signal."""
    in_time = np.zeros(len(rows), int)
    for s in np.unique(rows.signal):
        which = np.flatnonzero(rows.signal == s)
        order = which[np.lexsort((rows.state.time[which], rows.run[which]))]
        in_time[order] = np.arange(len(order)) * STRETCHES // len(order)
    found = [np.unique(np.stack([rows.signal, in_time]), axis=1, return_inverse=True)[1].ravel()]
    keys = [rows.signal]
    for x in axis:
        if x in rows.state.position:
            u = np.clip((rows.state.share(x) + 1) / 2, 0.0, 1.0 - 1e-9)
            keys += [(u * PLACES).astype(int), np.sign(rows.state.approach[x]).astype(int)]
    if len(keys) > 1:
        found.append(np.unique(np.stack(keys), axis=1, return_inverse=True)[1].ravel())
    return found


def _others(
    selector: Selector,
    model: Model,
    block: Block,
    rest: list[int],
    scores: np.ndarray,
    own: float,
    sd: dict[str, float],
) -> list[tuple[float, dict[str, float], dict[str, float]]]:
    """Weight, parameters and their standard deviations of other shapes of the same effect and axis."""
    result = []
    p: Projector | None = None
    for other, score in zip(selector.blocks, scores, strict=True):
        if other.key != block.key or other.shape == block.shape or not np.isfinite(score + own):
            continue
        weight = math.exp(min((float(score) - own) / 2, 0.0))
        if weight < LIKELY:
            continue
        p = p or selector.projector(rest, model.sigma)
        value, covariance = solve(p, other.columns, selector.y)
        named = other.module.parameters(value, dict(other.shape))
        by = _derivatives(other, value, [], np.sqrt(np.diag(covariance)))
        spread = {name: math.sqrt(max(float(d @ covariance @ d), 0.0)) for name, d in by.items()}
        # What the shape states is a choice, no size: its interval is that of the chosen one.
        fixed = {name: (named[name], max(spread[name], sd[name])) for name in named if name not in dict(other.shape)}
        chosen = block.module.parameters(np.zeros(block.columns.shape[1]), dict(block.shape))
        values = {name: fixed[name][0] if name in fixed else chosen[name] for name in named}
        result.append((weight, values, {name: fixed[name][1] if name in fixed else sd[name] for name in named}))
    return result


def _ends(parts: list[tuple[float, float, float]]) -> tuple[float, float]:
    """The interval that holds 95 % of a mixture of normal distributions (weight, mean, standard deviation), half of the rest on
    either side."""
    total = sum(w for w, _, _ in parts)
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
