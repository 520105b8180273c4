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
    """(n,) median of y from each reading on less that of those before it, beyond what y rises or
    falls by on both sides of it: a slope is no jump, however steep (minmod of the differences one
    window before and one behind)."""
    before = median_filter(y, WINDOW, origin=WINDOW // 2 - 1, mode="nearest")  # of k-7 to k
    rise = np.zeros(len(y) + 2 * WINDOW)
    rise[WINDOW + 1 : -2 * WINDOW] = before[WINDOW:-1] - before[: -WINDOW - 1]
    jump, earlier, later = rise[WINDOW:-WINDOW], rise[: -2 * WINDOW], rise[2 * WINDOW :]
    slope = np.where(np.abs(earlier) < np.abs(later), earlier, later) * (earlier * later > 0)
    size = np.maximum(np.abs(jump) - np.maximum(np.sign(jump) * slope, 0), 0)
    return np.asarray(np.sign(jump) * size)


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
    steps[clear] = difference(y)[clear]
    return np.asarray(y - np.cumsum(steps))
