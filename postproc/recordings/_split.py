"""Are the directions of the runs right? The split that they make is compared with all the others
that could be.

A wrong split hides in plausible numbers: the two directions' means come together, and the reversal
goes into the scatter.
"""

from __future__ import annotations

import itertools

import numpy as np

FEWEST_RUNS = 4
EVERY = 12  # up to so many runs all splits are tried; beyond, some hundred drawn with a fixed seed
DRAWN = 400
CLEARLY = 4.0  # another split must leave so many times less of the squares


def better_split(
    run: np.ndarray, target: np.ndarray, value: np.ndarray, sign: np.ndarray
) -> str | None:
    """A sentence where another split of the runs explains the readings far better than their
    directions do, or None.

    run, target, value, sign: (N,). Every run must have one sign. A drift over the runs is fitted
    beside the directions where there are six runs at least, so that it is not taken for one.
    """
    numbers = np.unique(run)
    if len(numbers) < FEWEST_RUNS:
        return None
    table = _table(run, target, value, numbers)
    own = np.array([np.sign(sign[run == r].sum()) for r in numbers], float)
    if table is None or np.any([np.ptp(sign[run == r]) for r in numbers]):
        return None
    others = _splits(len(numbers))
    left = np.array([_left(table, split) for split in others])
    mine = _left(table, own)
    best = int(np.argmin(left))
    # a made-up table of exact numbers leaves 0 by the right split and by others: nothing to say
    floor = 1e-9 * float(np.sum((table - table.mean(axis=0)) ** 2))
    if mine <= max(floor, CLEARLY * left[best]):
        return None
    scale = np.sqrt(np.array([mine, left[best], np.median(left)]) / table.size)
    alike = np.asarray(others[best]) == others[best][0]
    one, two = numbers[alike].astype(int).tolist(), numbers[~alike].astype(int).tolist()
    how = "one direction for all" if np.ptp(own) == 0 else "the directions taken"
    return (
        f"the directions of the runs look wrong: runs {_list(one)} are alike, and so are runs"
        f" {_list(two)}; with {how} {scale[0]:.3g} of scatter is left, with that split"
        f" {scale[1]:.3g}, with a random one {scale[2]:.3g} (--bidirectional, --first, --layout; or"
        " something changed between these runs)"
    )


def _table(run, target, value, numbers) -> np.ndarray | None:
    """(R, K) readings of the targets that every run has; None where these are fewer than three."""
    rows = [
        dict(zip(target[run == r].tolist(), value[run == r].tolist(), strict=True)) for r in numbers
    ]
    common = sorted(set.intersection(*(set(row) for row in rows)))
    if len(common) < 3:
        return None
    return np.array([[row[t] for t in common] for row in rows])


def _splits(n: int) -> np.ndarray:
    """(M, n) of +1 and -1, half and half (one over where n is odd), the first always +1."""
    if n <= EVERY:
        # A split and its opposite are the same: the first run is always in. 12 runs: 462 splits.
        sizes = {n // 2, n - n // 2}
        picks = [c for size in sizes for c in itertools.combinations(range(n), size) if 0 in c]
        result = -np.ones((len(picks), n))
        for row, pick in zip(result, picks, strict=True):
            row[list(pick)] = 1.0
        return result
    # alternating, half by half, and in pairs, as people do it; then some by chance to compare with
    rng = np.random.default_rng(230)
    half = np.where(np.arange(n) < n // 2, 1.0, -1.0)
    parity = np.where(np.arange(n) % 2 == 0, 1.0, -1.0)
    pairs = np.where(np.arange(n) // 2 % 2 == 0, 1.0, -1.0)
    return np.array([parity, half, pairs, *(rng.permutation(half) for _ in range(DRAWN))])


def _left(table: np.ndarray, split: np.ndarray) -> float:
    """Sum of squares that a mean per target, the split and (from six runs on) a drift leave."""
    n = len(table)
    # (R, 2 or 3) times (3, K): each target has its mean, its half reversal and its drift
    design = [np.ones(n), split]
    if n >= 6:
        design.append(np.arange(n) - (n - 1) / 2)
    matrix = np.array(design).T
    return float(np.sum((table - matrix @ np.linalg.lstsq(matrix, table, rcond=None)[0]) ** 2))


def _list(runs: list[int]) -> str:
    return ", ".join(map(str, runs))
