"""Whole numbers to decimal text, a column at a time."""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of

MOST_DECIMALS = 9
INSERT_WORD = 100  # rank of words put in behind a block's last one
POWERS = 10 ** np.arange(19)

# Four characters of text as one integer each: 0000 to 9999, and 000. to 999.
_PLACES = np.indices((10, 10, 10, 10), np.uint8).reshape(4, 10000).T + np.uint8(ord("0"))
_DIGITS = np.ascontiguousarray(_PLACES).view(np.uint32)[:, 0]
_TEXTS = np.full((1000, 4), ord("."), np.uint8)
_TEXTS[:, :3] = _PLACES[:1000, 1:]
_POINTED = _TEXTS.view(np.uint32)[:, 0]


def decimal_cells(
    value: np.ndarray, decimals: int, room: int = 0
) -> tuple[np.ndarray, np.ndarray, int]:
    """(T, W) uint8 cells holding value / 10**decimals, (T,) where each text begins in its cell, and
    where all of them end.

    value (T,) int64. Always with a decimal point, never with a plus sign; minus zero does not
    occur. `room`: columns kept free at the left.
    """
    #   cells of four characters, decimals 3    0    4    8    12      begin  end
    #   12345.678                               ....|0012|345.|6780      6     15
    #   -0.015                                  ....|0000|0-0.|0150      9     15
    # The point lies at one place for all, so that columns of cells are filled without a look at
    # single numbers; zeros before `begin` and behind `end` are not copied.
    size = np.abs(value)
    whole = size // POWERS[decimals]
    part = size - whole * POWERS[decimals]
    most = len(str(whole.max(initial=0)))
    # of the digits before the point three share a cell with it
    left, behind = max(-(-(most - 3) // 4), 0), -(-decimals // 4)
    middle = -(-(room + 1) // 4) + left  # the column with the point
    cell = np.zeros((len(value), middle + 1 + behind), np.uint32)
    high = whole // 1000
    cell[:, middle] = _POINTED.take(whole - high * 1000)
    _fill(cell, range(middle - 1, middle - 1 - left, -1), high)
    _fill(cell, range(middle + behind, middle, -1), part * POWERS[4 * behind - decimals])
    begin = np.empty(len(value), np.int64)
    # at the digit before the point, and one to the left for each further one
    begin.fill(4 * middle + 2)
    for k in range(1, most):
        begin -= whole >= POWERS[k]
    text = cell.view(np.uint8)
    negative = (value < 0).nonzero()[0]
    if len(negative):
        begin[negative] -= 1
        text[negative, begin[negative]] = ord("-")
    return text, begin, 4 * middle + 4 + decimals


def decimal_text(value: int, decimals: int) -> bytes:
    """One of them as decimal_cells writes it, which takes as long for one as for a thousand."""
    digits = b"%0*d" % (decimals + 1, abs(value))
    at = len(digits) - decimals
    return (b"-" if value < 0 else b"") + digits[:at] + b"." + digits[at:]


def _fill(cell: np.ndarray, columns: range, rest: np.ndarray) -> None:
    """Four digits of (T,) numbers to each of the columns, from the right."""
    for column in columns:
        high = rest // 10000
        cell[:, column] = _DIGITS.take(rest - high * 10000)
        rest = high


def steps(unit: np.ndarray, decimals: np.ndarray) -> np.ndarray:
    """Ticks of the last decimal of numbers (K,); () where it is one for all: dividing by one number
    is several times faster."""
    if len(unit) and not (any_of(unit != unit[0]) or any_of(decimals != decimals[0])):
        unit, decimals = unit[0], decimals[0]
    per: np.ndarray = unit // POWERS[decimals]
    return per


def counts(ticks: np.ndarray, unit: np.ndarray, decimals: np.ndarray) -> np.ndarray:
    """(K,) whole numbers of 10**-decimals units, nearest, half to even."""
    per = steps(unit, decimals)
    # `//` goes down below 0 too, so that the rest is never negative
    low = ticks // per
    rest = 2 * (ticks - low * per)
    counts: np.ndarray = low + (rest + (low & 1) > per)  # an odd number turns a half up
    return counts
