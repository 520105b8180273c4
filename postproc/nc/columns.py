"""Columns over blocks: values that hold until the next one is given. A value that never changes may
stay a number."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from postproc.flags import any_of
from postproc.nc.state import NONE

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def at(column: Any, index: np.ndarray) -> Any:
    """A column at some blocks; a single number stays one."""
    if not isinstance(column, np.ndarray):
        return column
    # of one place: it holds throughout, as in a batch of one block
    return column.ravel()[0] if column.size == 1 else column[index]


def spread(column: np.ndarray | int, n: int) -> np.ndarray:
    """(n,) a column, or a single number n times."""
    if isinstance(column, np.ndarray) and column.size == n:
        return column
    result = np.empty(n, np.int64)
    result.fill(column)
    return result


def one_of(column: np.ndarray, few: Iterable[int]) -> np.ndarray:
    """(n,) bool: where a column has one of a few numbers; for one block ten times as fast as
    `np.isin`."""
    found = np.zeros(len(column), bool)
    for number in few:
        found |= column == number
    return found


def changes(column: ArrayLike) -> np.ndarray:
    """Indices at which a column takes another value, the first one among them."""
    flat = np.asarray(column).ravel()
    return (
        np.concatenate([[0], (flat[1:] != flat[:-1]).nonzero()[0] + 1])
        if len(flat)
        else np.zeros(0, np.int64)
    )


def begins(column: np.ndarray) -> np.ndarray:
    """(n,) bool: where a column takes another value, and at its first place."""
    result = np.empty(len(column), bool)
    result[:1] = True
    np.not_equal(column[1:], column[:-1], out=result[1:])
    return result


def hold_index(named: np.ndarray) -> np.ndarray:
    """(B,) index of the last named block up to each block, -1 before the first."""
    #   named  . x . . x .   ->   -1 1 1 1 4 4
    index = np.arange(len(named))
    index[~named] = -1
    return np.maximum.accumulate(index)


def hold_last(column: np.ndarray, carry: int) -> np.ndarray:
    """Fill the gaps (-1) of a column with the last value given before them, or with `carry`."""
    last = hold_index(column != NONE)
    return np.where(last >= 0, column[np.maximum(last, 0)], carry)


def hold_last_float(column: np.ndarray, carry: float) -> np.ndarray:
    """The same with nan for the gaps."""
    last = hold_index(~np.isnan(column))
    return np.where(last >= 0, column[np.maximum(last, 0)], carry)


def named_since(named: np.ndarray, at: np.ndarray, carry: bool) -> tuple[np.ndarray, bool]:
    """(N,) bool: whether a block that names something, of `named` (B,), stands between the one
    before of the blocks `at` (N,), or the begin, and each, neither of the two counted; and whether
    one does behind the last. carry: whether one does before the first block."""
    since = np.zeros(len(at), bool)
    if not any_of(named):
        since[:1] = carry
        return since, carry and not len(at)
    if not len(at):
        return since, True
    # How many are named up to each block: one stands between two of `at` where the count before
    # the second is above the count at the first.
    count = named.cumsum()
    before = (count - named)[at]
    since[0] = before[0] > 0 or carry
    np.greater(before[1:], count[at[:-1]], out=since[1:])
    return since, bool(count[-1] > count[at[-1]])


def cells(table: np.ndarray, row: int | np.ndarray, column: np.ndarray) -> np.ndarray:
    """(K,) table[row, column] of an (A, N) table, three times as fast."""
    cells: np.ndarray = table.take(row * table.shape[1] + column)
    return cells
