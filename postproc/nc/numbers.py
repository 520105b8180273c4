"""Whole numbers to decimal text, a column at a time."""

from __future__ import annotations

import numpy as np

MOST_DECIMALS = 9
INSERT_WORD = 100  # rank of words put in behind a block's last one
POWERS = 10 ** np.arange(19)

_FOUR = (np.arange(10000)[:, None] // POWERS[3::-1] % 10 + ord("0")).astype(np.uint8)


def decimal_cells(value: np.ndarray, decimals: int, room: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """(T, W) uint8 cells holding value / 10**decimals, right-aligned, and (T,) where each text
    begins in its cell.

    value (T,) int64. Always with a decimal point, never with a plus sign; minus zero does not
    occur. `room`: columns kept free at the left.
    """
    size = np.abs(value)
    most = max(len(str(size.max(initial=0))), decimals + 1)
    groups = -(-most // 4)
    digit = np.empty((len(value), 4 * groups), np.uint8)
    rest = size
    for g in range(groups - 1, -1, -1):
        high = rest // 10000
        digit[:, 4 * g : 4 * g + 4] = _FOUR[rest - high * 10000]
        rest = high
    width = room + 2 + 4 * groups
    begin = np.empty(len(value), np.int64)
    begin.fill(width - 2 - decimals)
    for k in range(decimals + 1, most):
        begin -= size >= 10**k
    cell = np.zeros((len(value), width), np.uint8)
    whole = 4 * groups - decimals
    cell[:, width - decimals :] = digit[:, whole:]
    cell[:, width - decimals - 1] = ord(".")
    cell[:, width - decimals - 1 - whole : width - decimals - 1] = digit[:, :whole]
    negative = (value < 0).nonzero()[0]
    if len(negative):
        begin[negative] -= 1
        cell[negative, begin[negative]] = ord("-")
    return cell, begin


def counts(
    ticks: np.ndarray, scale: np.ndarray, decimals: np.ndarray, unit: np.ndarray | None = None
) -> np.ndarray:
    """(K,) whole numbers of 10**-decimals units, nearest, half to even."""
    unit = scale if unit is None else unit
    if len(ticks) and not (
        np.count_nonzero(unit != unit[0]) or np.count_nonzero(decimals != decimals[0])
    ):
        per = unit[0] // POWERS[decimals[0]]  # dividing by one number is several times faster
    else:
        per = unit // POWERS[decimals]
    low = ticks // per
    rest = 2 * (ticks - low * per)
    return low + (rest + (low & 1) > per)  # an odd number turns a half up
