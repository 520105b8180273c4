"""A reading that slipped, where nothing was measured often enough to ask the other runs.

Along one passage in one direction a isolated wrong reading departs from the cubic through its two
neighbours on either side, and its neighbours depart from theirs by a known share of it with the
other sign. What bends is no slip: there the neighbours go on departing when that share is taken
off.
"""

from __future__ import annotations

import numpy as np

# times the usual departure: of 18 normal readings without a slip 4 in 1000 have one as large
SLIP = 5.0
DROPPED = 6.0  # times its noise: where an outlier is left out
BESIDE = 2  # neighbours on either side that predict a reading
AROUND = 6  # neighbours on either side that say how well such predictions do here
MAD = 1.4826


def departures(
    place: np.ndarray, value: np.ndarray, sigma: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) how many times what is usual around it each value departs from its neighbours, so scaled
    that a slip (SLIP) is what is left out (DROPPED), and (N,) by how much; 0 at the ends. place
    (N,) in any order, without repeats; sigma (N,) noise of a single value, in the unit of value."""
    n = len(place)
    result, size = np.zeros(n), np.zeros(n)
    if n < 2 * BESIDE + 4:
        return result, size
    order = np.argsort(place)
    p, y = place[order], value[order]
    share = _shares(p)
    off = share @ y
    noise = sigma[order] * np.linalg.norm(share, axis=1)
    for k in range(BESIDE, n - BESIDE):
        near = np.arange(max(BESIDE, k - AROUND), min(n - BESIDE, k + AROUND + 1))
        # A slip at k has the pattern of that column. A bend at k, |p - p_k|, has one, too: what
        # leaves less of the departures around is what happened.
        slip, left = _without(share[near, k], off[near])
        _, bent = _without((share @ np.abs(p - p[k]))[near], off[near])
        if np.linalg.norm(bent) <= np.linalg.norm(left):  # the way bends here
            continue
        rest = left[near != k]
        # what bends here bends the next ones
        close = np.abs(rest[np.abs(near[near != k] - k) <= BESIDE])
        usual = max(float(MAD * np.median(np.abs(rest))), float(close.max()), float(noise[k]))
        result[order[k]], size[order[k]] = DROPPED / SLIP * slip / usual, slip
    return result, size


def at_ends(
    place: np.ndarray, value: np.ndarray, other: np.ndarray, sigma: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) how many times its noise each reading at the ends of a passage, where `departures` can
    not judge, is off both from another run at its place and from the readings beside it, and (N,)
    by how much; 0 elsewhere. other (N,): what other runs read at these places, nan where there were
    none."""
    result, size = np.zeros(len(place)), np.zeros(len(place))
    order = np.argsort(place)
    y, gap, noise = value[order], (value - other)[order], sigma[order]
    ends = [*range(min(BESIDE, len(y))), *range(max(BESIDE, len(y) - BESIDE), len(y))]
    for k in ends:
        near = np.array([j for j in range(max(0, k - 3), min(len(y), k + 4)) if j != k], int)
        if np.isnan(gap[k]) or np.isnan(gap[near]).all():
            continue
        runs, beside = gap[k] - np.nanmedian(gap[near]), y[k] - np.median(y[near])
        if runs * beside > 0:
            size[order[k]] = min(abs(runs), abs(beside))
            result[order[k]] = size[order[k]] / (np.sqrt(2.0) * noise[k])
    return result, size


def _without(pattern: np.ndarray, off: np.ndarray) -> tuple[float, np.ndarray]:
    """How much of a pattern there is in departures, and what they are without it."""
    size = float(pattern @ off / (pattern @ pattern))
    return size, off - size * pattern


def _shares(p: np.ndarray) -> np.ndarray:
    """(N, N) that takes values to their departures from the cubic through their neighbours; rows of
    zeros at the ends."""
    n = len(p)
    share = np.zeros((n, n))
    for k in range(BESIDE, n - BESIDE):
        near = [j for j in range(k - BESIDE, k + BESIDE + 1) if j != k]
        # Lagrange's weights of the other three; of targets at even distances the rows times 6 are
        #
        #     1  -4  6  -4  1
        #
        # so that a slip of 1 departs by 1, and its neighbours by -2/3 and 1/6.
        for j in near:
            others = [i for i in near if i != j]
            share[k, j] = -np.prod([(p[k] - p[i]) / (p[j] - p[i]) for i in others])
        share[k, k] = 1.0
    return share
