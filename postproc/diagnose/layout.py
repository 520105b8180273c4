"""Where the coefficients that all units share stand in the matrices of a set."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


# Order of the f shared coefficients of a set, in each vector and along both sides of each matrix:
#
#     map, square, jump (columns of Evidence.shared) | block chosen[0] | block chosen[1] | ...
#                                                    |<---- slab, of: (w,), all blocks ---->
#
# A unit holds only those that show in it, in the same order; `at` says where they stand.
@dataclass(frozen=True)
class Layout:
    """Where the shared coefficients of a set stand. slab (w,): usual standard deviation of those of
    its blocks; of (w,): number of the block of each, among the chosen; width (C,): how many are of
    each; at: of each unit, all of them (a slice) or the numbers of those that show in it."""

    chosen: tuple[int, ...]
    slab: np.ndarray
    of: np.ndarray
    width: np.ndarray
    at: list[slice | np.ndarray]


def square(at: slice | np.ndarray) -> tuple[slice | np.ndarray, ...]:
    """The index of the rows and columns of a square matrix."""
    return (at, at) if isinstance(at, slice) else np.ix_(at, at)
