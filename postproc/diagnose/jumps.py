"""Abrupt changes of a signal's level, by medians on either side."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

WINDOW = 8  # samples on either side of a change
CLEAR = 6.0  # times what such medians differ by elsewhere
FEW = 3  # in a signal: more are of its noise (a lost step is seldom)


def changes(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (C,) of the first readings behind the largest change of y (n,) within a window, and
    by how much the medians before and behind differ."""
    size = np.abs(difference(y))
    # of medians that are alike the one with the step itself
    sharp = size + 1e-6 * np.abs(np.diff(y, prepend=y[0]))
    at = np.flatnonzero((size > 0) & (sharp == maximum_filter1d(sharp, 2 * WINDOW + 1)))
    return at, size[at]


def difference(y: np.ndarray) -> np.ndarray:
    """(n,) median of y from each reading on less that of those before it."""
    before = median_filter(y, WINDOW, origin=WINDOW // 2 - 1, mode="nearest")  # of k-7 to k
    jump = np.zeros(len(y))
    jump[1:-WINDOW] = before[WINDOW:-1] - before[: -WINDOW - 1]
    return jump


def without(y: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """y (n,) with a few clear jumps taken out, each by the medians on either side: a level that
    jumps is no noise. As it is where there are more of them, or none. kept (n,) bool: where a
    jump is another's."""
    at, size = changes(y)
    if not len(at):
        return y
    clear = at[size > CLEAR * np.median(size)]
    clear = clear[np.diff(clear, prepend=-WINDOW - 1) > WINDOW]  # of two alike the first
    clear = clear[~kept[clear]]
    if not 0 < len(clear) <= FEW:
        return y
    steps = np.zeros(len(y))
    # taken off from each jump on: their running sum
    steps[clear] = difference(y)[clear]
    return np.asarray(y - np.cumsum(steps))
