"""Means of the runs at every target and direction, their scatter, and what the few runs cost in
certainty.

A cell is one target approached in one direction. Row 0 of every (2, K) array is approached in +,
row 1 in -.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from postproc.iso.positioning import targets_of
from postproc.iso.sampling import bartlett

LEVEL = 0.95  # of the tests

# 95.45 %, of a normal distribution within k = 2 (JCGM 100, table G.2)
SHARE = math.erf(math.sqrt(2.0))


def t_factor(dof: np.ndarray | float) -> np.ndarray:
    """Coverage factor for 95.45 % at `dof` degrees of freedom: 2 for many, 2.87 for five runs."""
    from scipy.stats import t

    return t.isf((1 - SHARE) / 2, np.maximum(dof, 1.0))


def chi_squared(dof: np.ndarray | float, share: float = LEVEL) -> np.ndarray:
    """Value of chi-squared below which a share of the chances lies."""
    from scipy.stats import chi2

    return chi2.ppf(share, dof)


@dataclass(frozen=True)
class Cells:
    """nodes (K,); mean, s, n (2, K): of the runs, NaN where there is none (s: where there are fewer
    than two); index (N,): of each reading, which cell (0..K-1 approached in +, K..2K-1 in -, -1 in
    none). one_way: the only direction measured, +1 or -1, 0 where both were or where it is not
    known."""

    nodes: np.ndarray
    mean: np.ndarray
    s: np.ndarray
    n: np.ndarray
    index: np.ndarray
    two_way: bool
    one_way: int

    @cached_property
    def scatter(self) -> Scatter:
        """Of one reading, by cell."""
        return _scatter(self.s, self.n)


@dataclass(frozen=True)
class Scatter:
    """s (2, K): standard deviation of one reading in each cell; dof (2, K); pooled: whether all
    cells share one."""

    s: np.ndarray
    dof: np.ndarray
    pooled: bool

    @property
    def known(self) -> bool:
        """Whether any cell had two runs."""
        return bool(np.isfinite(self.s).any())


def nodes_of(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) targets, ascending, and (N,) the target of each reading."""
    target, index = targets_of(position)
    return np.round(target, 6), index


def cells_of(position: np.ndarray, approach: np.ndarray, reading: np.ndarray) -> Cells:
    """Means over runs. Where only one direction was measured, or none is known, both rows hold the
    same.

    Where both are there, readings whose direction is not known are in no cell.
    """
    nodes, at = nodes_of(position)
    k = len(nodes)
    ways = sorted({int(a) for a in approach} - {0})
    two_way = len(ways) == 2
    # measured one way, a reading without a direction counts too: there is but one column to put it
    # in
    index = np.where(approach > 0, at, np.where(approach < 0, at + k, -1)) if two_way else at
    mean, s, n = _moments(index, reading, 2 * k if two_way else k)
    if not two_way:
        mean, s, n = (np.tile(a, 2) for a in (mean, s, n))
    return Cells(
        nodes, mean.reshape(2, k), s.reshape(2, k), n.reshape(2, k), index, two_way,
        0 if two_way or not ways else ways[0],
    )  # fmt: skip


def _moments(
    index: np.ndarray, reading: np.ndarray, cells: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean, standard deviation and number of each cell."""
    used = index >= 0
    index, reading = index[used], reading[used]
    n = np.bincount(index, minlength=cells)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(index, reading, cells) / n
        square = np.bincount(index, (reading - mean[index]) ** 2, cells)
        s = np.sqrt(square / (n - 1))
    s[n < 2] = np.nan
    return mean, s, n


def _scatter(s: np.ndarray, n: np.ndarray) -> Scatter:
    """One standard deviation for all cells where their differences are what chance makes
    (Bartlett's test, 95 %), else each cell its own; a cell of one reading takes the common one."""
    dof = np.where(np.isfinite(s), n - 1.0, 0.0)
    total = float(dof.sum())
    if total == 0:
        return Scatter(np.full(s.shape, np.nan), np.ones(s.shape), False)
    common = float(np.nansum(dof * np.nan_to_num(s) ** 2) / total)
    # a cell of one reading says nothing of its scatter, and takes what the others say
    few = dof == 0
    variance = np.where(few, common, np.nan_to_num(s) ** 2)
    pooled = True
    has = ~few
    if common > 0 and has.sum() > 1:
        statistic = bartlett(variance[has], dof[has], common)
        pooled = bool(statistic < chi_squared(int(has.sum()) - 1))
    if pooled:
        return Scatter(np.full(s.shape, np.sqrt(common)), np.full(s.shape, total), True)
    return Scatter(np.sqrt(variance), np.where(few, total, dof), False)


def step_of(reading: np.ndarray) -> float:
    """The smallest difference between two readings: the step of their last decimal, 0 where there
    is but one value."""
    different = np.diff(np.unique(reading))
    different = different[different > 1e-12]
    return float(different.min()) if len(different) else 0.0
