"""Readings that do not belong: against the other runs at the same target, and against the
neighbours in position.

Nothing is removed here. With few runs a standard deviation of one cell says little, so the scale is
never smaller than what is usual over the whole recording.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.calibrate.assign import Series
from postproc.calibrate.statistics import Cells, chi_squared, step_of

RUNS, NEIGHBOURS = 5.0, 6.0  # how many standard deviations
WINDOW = 3  # targets on either side that say what is smooth
MAD = 1.4826  # median absolute deviation to standard deviation, normal law
NO_POWER = 3.0  # leverage beyond which a target at the end says nothing about itself


@dataclass(frozen=True)
class Outlier:
    """row: of the series; value: the reading, mm or rad; off: how far from where it should be;
    times: in standard deviations; against: "runs" or "neighbours"."""

    component: str
    file: str
    row: int
    line: int
    position: float
    approach: int
    value: float
    off: float
    times: float
    against: str


def find(series: Series, cells: Cells) -> list[Outlier]:
    """All outliers of one series, in the order of its file. A reading is named once."""
    found = {o.row: o for o in _against_neighbours(series, cells)}
    # by its other runs where there are some: they know the place itself, neighbours only the curve
    found |= {o.row: o for o in _against_runs(series, cells)}
    return [found[row] for row in sorted(found)]


def _outlier(series: Series, row: int, off: float, scale: float, against: str) -> Outlier:
    return Outlier(
        series.component, series.file, row, int(series.lines[row]), float(series.position[row]),
        int(series.approach[row]), float(series.reading[row]), float(off), float(abs(off) / scale),
        against,
    )  # fmt: skip


def _floor(series: Series) -> float:
    """mm or rad: the least scatter that readings of this resolution have, of a stated instrument a
    tenth of its own."""
    return max(step_of(series.reading) / np.sqrt(12.0), 0.1 * (series.u or 0.0), 1e-9)


def _against_runs(series: Series, cells: Cells) -> list[Outlier]:
    """Three runs or more: each reading against the median of the others at its target."""
    many = np.isfinite(cells.s) & (cells.n >= 3)
    if not many.any():
        return []
    dof = cells.n[many] - 1.0
    # s**2 * dof / median of chi-squared: each cell's variance as its median would have it, so that
    # few runs do not make the scale too small; over all cells the median, so that outliers do not
    # make it large.
    typical = np.sqrt(np.median(cells.s[many] ** 2 * dof / chi_squared(dof, 0.5)))
    typical = max(float(typical), _floor(series))
    result = []
    for cell in np.unique(cells.index[cells.index >= 0]):
        rows = np.flatnonzero(cells.index == cell)
        if len(rows) < 3:
            continue
        for row in rows:
            others = series.reading[rows[rows != row]]
            middle = float(np.median(others))
            spread = MAD * float(np.median(np.abs(others - middle)))
            # a reading against the median of n others: variance 1 + pi / (2 n)
            scale = max(typical, spread) * np.sqrt(1.0 + np.pi / 2 / len(others))
            off = float(series.reading[row]) - middle
            if abs(off) > RUNS * scale:
                result.append(_outlier(series, int(row), off, scale, "runs"))
    return result


def _shown_by(other: np.ndarray, off: np.ndarray) -> np.ndarray:
    """Whether the other direction shows half of it at least."""
    return np.asarray((other * off > 0) & (np.abs(other) > np.abs(off) / 2))


def _against_neighbours(series: Series, cells: Cells) -> list[Outlier]:
    """A target's mean against a parabola through its neighbours of the same direction, where the
    other direction shows nothing of the kind: what both directions show, the machine does."""
    ways = slice(0, 2 if cells.two_way else 1)
    off, spread, local = np.stack([_residuals(cells.nodes, m) for m in cells.mean[ways]], axis=1)
    known = np.isfinite(spread)
    if not known.any():
        return []
    usual = MAD * float(np.nanmedian(np.abs(off[known] / spread[known])))
    runs, s = cells.n[ways], cells.s[ways]
    noise = _floor(series) + np.where(runs > 1, s / np.sqrt(np.maximum(runs, 1)), 0.0)
    scale = spread * np.maximum(np.maximum(usual, local), noise)
    odd = known & (np.abs(off) > NEIGHBOURS * scale)
    if cells.two_way:
        # rows exchanged: what the other direction has at the same target
        odd &= ~_shown_by(off[::-1], off)
    result = []
    for way, k in np.argwhere(odd):
        # the second direction's cells lie behind those of the first, way is 0 where one is all
        mine = np.flatnonzero(cells.index == k + len(cells.nodes) * way)
        at = (off[way, k], scale[way, k], "neighbours")
        result += [_outlier(series, int(row), *at) for row in mine]
    return result


def _residuals(nodes: np.ndarray, mean: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(K,) each: how far a mean lies from the parabola through up to three neighbours on each side;
    that difference's standard deviation in units of one mean's (NaN where it can not be judged);
    standard deviation of the neighbours about their own parabola."""
    off, spread, local = np.zeros(len(nodes)), np.full(len(nodes), np.nan), np.zeros(len(nodes))
    there = np.flatnonzero(np.isfinite(mean))
    for i, k in enumerate(there):
        #     o  o  o  x  o  o  o     three on each side; at an end six on the one side
        first = min(max(0, i - WINDOW), max(0, len(there) - 2 * WINDOW - 1))
        near = np.delete(there[first : first + 2 * WINDOW + 1], i - first)
        if len(near) < 5:
            continue
        reach = float(np.abs(nodes[near] - nodes[k]).max())
        terms = np.vander((nodes[near] - nodes[k]) / reach, 3)
        solve = np.linalg.pinv(terms)
        at = solve[2]  # the parabola's value at the target itself
        off[k] = mean[k] - at @ mean[near]
        leverage = float(at @ at)
        # beyond the end the parabola predicts nothing: any reading would lie within its own
        # uncertainty
        if leverage > NO_POWER:
            continue
        left = mean[near] - terms @ (solve @ mean[near])
        local[k] = np.sqrt(left @ left / (len(near) - 3))
        spread[k] = np.sqrt(1.0 + leverage)
    return off, spread, local
