r"""The measured errors of one moving axis: six components over its position, by direction of
approach.

Linear between nodes, as every documented control interpolates its own table; held beyond the ends
(whether a position may lie there is not decided here).

    forward    o---------o             value = mean + approach * half
    mean      /     *     \              mean  = base + rise * share
    reverse  o             o- - -        half  = (forward - reverse) / 2, interpolated likewise
             |-------|-----|             approach: +1 bears forward, -1 reverse, 0 not known
          interval 0 share
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from postproc import kernel
from postproc.machine.cells import Cells, Value
from postproc.records import columns

MANY = 64  # places for which a search takes longer than a few more steps
PORTION = 16_384  # places looked up at once: the columns of more leave the processor's cache
# those by which the machine is off along X, Y or Z: the shift, and both rotations about the others
ALONG = ((0, 4, 5), (1, 3, 5), (2, 3, 4))
COMPONENTS = ("EX", "EY", "EZ", "EA", "EB", "EC")  # direction; the moving axis is appended: EXZ

Bins = tuple[list[int], np.ndarray, np.ndarray, dict[int, int]]


class BothWays:
    """What tables of one position and of two have in common: forward, reverse (6, K ...)."""

    forward: np.ndarray
    reverse: np.ndarray

    @cached_property
    def mean(self) -> np.ndarray:
        """(6, K ...) mean of both directions."""
        mean: np.ndarray = (self.forward + self.reverse) / 2
        return mean

    @cached_property
    def half(self) -> np.ndarray:
        """(6, K ...) half of forward minus reverse."""
        half: np.ndarray = (self.forward - self.reverse) / 2
        return half

    @cached_property
    def two_way(self) -> bool:
        """Whether any component depends on the direction of approach."""
        return bool(np.any(self.half))

    @cached_property
    def is_zero(self) -> bool:
        """Whether every component is zero at every node."""
        return not self.rows

    @cached_property
    def rows(self) -> list[int]:
        """Components that are not zero everywhere."""
        return [i for i in range(6) if np.any(self.forward[i]) or np.any(self.reverse[i])]

    @cached_property
    def sizes(self) -> np.ndarray:
        """(6,) largest size of each component."""
        both = np.abs(np.stack([self.forward, self.reverse], axis=1))
        sizes: np.ndarray = both.reshape(6, -1).max(axis=1)
        return sizes


@columns
class AxisTable(BothWays):
    """nodes (K,) mm, ascending. forward, reverse (6, K): deviations in the order of COMPONENTS, mm
    and rad, for targets approached in + and in -; equal where a component was measured one way.
    stated: the components that the table has a column of, as rows of COMPONENTS; the others are
    zero for want of one."""

    letter: str
    nodes: np.ndarray
    forward: np.ndarray
    reverse: np.ndarray
    stated: tuple[int, ...] = ()

    @cached_property
    def slopes(self) -> np.ndarray:
        """(6, 2, K - 1) slopes between nodes, forward and reverse; mm/mm and rad/mm."""
        return np.stack([np.diff(self.forward), np.diff(self.reverse)], axis=1) / np.diff(
            self.nodes
        )

    def slope_range(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(6, N) how much the slope of each component differs, and (6, N) its largest size, between
        low and high (N,) mm."""
        first, last = self.place(low)[0], self.place(high)[0]
        least, most = self.slopes[:, :, first].copy(), self.slopes[:, :, first].copy()
        # As many rounds as the widest box spans intervals, for all boxes at once; a box that spans
        # fewer looks at its last interval again, which changes nothing.
        for k in range(1, int((last - first).max(initial=0)) + 1):
            slope = self.slopes[:, :, np.minimum(first + k, last)]
            np.minimum(least, slope, out=least)
            np.maximum(most, slope, out=most)
        held = (low < self.nodes[0]) | (high > self.nodes[-1])  # flat beyond the ends
        least[..., held], most[..., held] = (
            np.minimum(least[..., held], 0.0),
            np.maximum(most[..., held], 0.0),
        )
        return (most - least).max(axis=1), np.maximum(np.abs(least), np.abs(most)).max(axis=1)

    @cached_property
    def steepest(self) -> np.ndarray:
        """(6,) largest size of each component's slopes."""
        steepest: np.ndarray = np.abs(self.slopes).max(axis=(1, 2))
        return steepest

    @cached_property
    def step(self) -> float:
        """Node spacing in mm where it is even, else 0."""
        gaps = np.diff(self.nodes)
        return float(gaps[0]) if np.allclose(gaps, gaps[0], rtol=0, atol=1e-9) else 0.0

    @cached_property
    def _bins(self) -> Bins:
        """Of all live components."""
        return self._of(self.rows)

    @cached_property
    def _bins_along(self) -> list[Bins]:
        """Of those by which the machine is off along X, Y or Z."""
        return [self._of([i for i in self.rows if i in those]) for those in ALONG]

    def _of(self, rows: list[int]) -> Bins:
        """The components; value and rise (C + H, K - 1) at each interval's lower node of the mean
        of each, and behind them of the half of those that were measured both ways; and component to
        the row of its half."""
        both = [i for i in rows if np.any(self.half[i])]
        value = np.concatenate([self.mean[rows], self.half[both]], dtype=np.float64)
        # Rows of value:  0 .. C-1  the means of the live components, in the order of `rows`
        #                  C ..     the halves of those measured both ways
        # With approach -1, 0 or +1 mean + approach * half is the reverse, the mean or the forward
        # curve.
        half = {i: len(rows) + k for k, i in enumerate(both)}
        return rows, value[:, :-1].copy(), np.diff(value).copy(), half

    def place(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) index of the node below each position, mm, and (N,) the share of the interval above
        it, 0 to 1.

        Beyond the ends the first or last interval's, with share 0 or 1.
        """
        if self.step:
            first, per, zero, top, last = self._even
            place = np.minimum(np.maximum((position - first) * per, zero), top)
            interval = np.minimum(place.astype(np.int64), last)
            return interval, place - interval
        low, high, inner, width = self._uneven
        inside = np.minimum(np.maximum(position, low), high)
        if len(position) < MANY or not self._nearly:
            # Nodes but for the first and the last: what lies before all of them is in the first
            # interval.
            interval = inner.searchsorted(inside, side="right")
            return interval, (inside - self.nodes[interval]) / width[interval]
        # The same by multiplication, which may take a place at a node for one beside it.
        interval = ((inside - low) * self._nearly).astype(np.int64)
        share = inside - self.nodes.take(interval)
        wide = width.take(interval)
        if share.min() < 0.0 or ((share >= wide) & (inside < high)).any():
            interval = inner.searchsorted(inside, side="right")
            return interval, (inside - self.nodes[interval]) / width[interval]
        share /= wide
        return interval, share

    def interval(self, position: np.ndarray) -> np.ndarray:
        """(N,) index of the node below each position, as of `place`, without the share."""
        if self.step or (len(position) >= MANY and self._nearly):
            return self.place(position)[0]
        inner: np.ndarray = self._uneven[2]
        return inner.searchsorted(position, side="right")

    @cached_property
    def _nearly(self) -> float:
        """Intervals per mm where all are of one width but for a shorter last one, else 0."""
        gaps = np.diff(self.nodes)
        even = np.allclose(gaps[:-1], gaps[0], rtol=0, atol=1e-9) and gaps[-1] < gaps[0]
        return float(1.0 / gaps[0]) if even else 0.0

    @cached_property
    def _even(self) -> tuple[np.ndarray, ...]:
        """The first node mm, intervals per mm, 0, how many there are, and the last one's index. As
        arrays without axes: with a number a call takes half as long again, with an array of one
        three times as long, which counts where N is 1; and so does a result in place there."""
        last = len(self.nodes) - 2
        numbers = (self.nodes[0], 1.0 / self.step, 0.0, last + 1.0, last)
        return tuple(np.array(number) for number in numbers)

    @cached_property
    def _uneven(self) -> tuple[np.ndarray, ...]:
        """Both ends, as arrays without axes, the nodes between, and the intervals' widths, mm."""
        n = self.nodes
        return np.array(n[0]), np.array(n[-1]), n[1:-1].copy(), np.diff(n)

    def evaluate(self, position: Value, approach: Value, along: int | None = None) -> list[Any]:
        """Six (N,) columns, None for a component that is zero everywhere, or that does not count
        along the direction `along`, 0 to 2 for X Y Z; six numbers of one place that is a number.

        position (N,) mm; approach (N,) from -1 (reached in -) over 0 (mean) to +1.
        """
        result: list[Any] = [None] * 6
        rows, base, rise, half = self._bins if along is None else self._bins_along[along]
        if not rows:
            return result
        value: Any
        if not isinstance(position, np.ndarray):
            cells = self._cells if along is None else self._cells_along[along]
            value = cells.values(position)
        else:
            value = self._looked_up(position, base, rise)
        # `value` has more rows than `rows`: the halves behind the means are left for the loop below
        for i, column in zip(rows, value, strict=False):
            result[i] = column
        for i, k in half.items():
            result[i] = result[i] + approach * value[k]
        return result

    def _looked_up(self, position: np.ndarray, base: np.ndarray, rise: np.ndarray) -> np.ndarray:
        """(C, N) columns of the bins at places (N,)."""
        library = kernel.library() if len(position) >= MANY and self._per else None
        if library is None:
            interval, share = self.place(position)
            value: np.ndarray = rise.take(interval, axis=1)
            value *= share
            value += base.take(interval, axis=1)
            return value
        position = np.ascontiguousarray(position, np.float64)  # C takes any number for one of these
        value = np.empty((len(base), len(position)))
        nodes, width = self._intervals
        library.look(
            *(ctypes.c_int64(len(position)), ctypes.c_void_p(position.ctypes.data)),
            *(ctypes.c_int64(len(width)), ctypes.c_void_p(nodes.ctypes.data)),
            *(ctypes.c_void_p(width.ctypes.data), ctypes.c_double(self._per)),
            *(ctypes.c_int64(self.step != 0), ctypes.c_int64(len(base))),
            *(ctypes.c_void_p(column.ctypes.data) for column in (base, rise, value)),
        )
        return value

    @cached_property
    def _per(self) -> float:
        """Intervals per mm, of all but perhaps the last, 0 where they differ."""
        return 1.0 / self.step if self.step else self._nearly

    @cached_property
    def _intervals(self) -> tuple[np.ndarray, np.ndarray]:
        """The nodes and the intervals' widths, mm, each in one piece."""
        nodes = np.ascontiguousarray(self.nodes, np.float64)
        return nodes, np.diff(nodes)

    @cached_property
    def _cells(self) -> Cells:
        """The bins in numbers."""
        return Cells(self.nodes, self.step, *self._bins[1:3])

    @cached_property
    def _cells_along(self) -> list[Cells]:
        """Those along X, Y and Z in numbers."""
        return [Cells(self.nodes, self.step, *bins[1:3]) for bins in self._bins_along]

    def half_of(self, row: int, position: Value) -> Value:
        """(N,) half of forward minus reverse of one component, mm or rad, or one number; of one
        that was measured both ways."""
        _, base, rise, half = self._bins
        if not isinstance(position, np.ndarray):
            return self._cells.values(position)[half[row]]
        interval, share = self.place(position)
        value: np.ndarray = base[half[row]][interval] + rise[half[row]][interval] * share
        return value


@columns
class AxisUncertainty:
    """How well an axis' table is known. table: expanded uncertainties U (95 %, k = 2) in the place
    of deviations, never negative; stated: the components, as rows of COMPONENTS, of which anything
    is said: 0 is a statement too."""

    table: AxisTable
    stated: tuple[int, ...]


@columns
class GridTable(BothWays):
    """What of an axis' errors depends on where a second axis stands; added to its table. Linear in
    either position between nodes (bilinear in both), held beyond.

    nodes (K,), others (L,) mm or degrees, ascending; forward, reverse (6, K, L) mm and rad, in the
    order of COMPONENTS, by the direction in which `letter` was approached.
    """

    letter: str
    other: str
    nodes: np.ndarray
    others: np.ndarray
    forward: np.ndarray
    reverse: np.ndarray

    @cached_property
    def slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """(6,) steepest change of each component along either axis."""
        both = np.stack([self.forward, self.reverse])
        along = np.abs(np.diff(both, axis=2)) / np.diff(self.nodes)[:, None]
        across = np.abs(np.diff(both, axis=3)) / np.diff(self.others)
        return along.max(axis=(0, 2, 3)), across.max(axis=(0, 2, 3))

    @cached_property
    def twist(self) -> np.ndarray:
        """(6,) largest mixed second derivative of each component."""
        both = np.diff(np.diff(np.stack([self.forward, self.reverse]), axis=2), axis=3)
        # Within a cell d2f / dp dq is constant: (f11 - f10 - f01 + f00) / area. It is all that
        # bends there, and only along a path that moves both axes.
        area = np.diff(self.nodes)[:, None] * np.diff(self.others)
        steepest: np.ndarray = (np.abs(both) / area).max(axis=(0, 2, 3))
        return steepest

    def evaluate(
        self, position: np.ndarray, other: np.ndarray, approach: np.ndarray
    ) -> list[np.ndarray | None]:
        """Six (N,) columns, None for a component that is zero everywhere."""
        result: list[np.ndarray | None] = [None] * 6
        i, u = _interval(self.nodes, position)
        j, v = _interval(self.others, other)
        for row in self.rows:
            result[row] = _bilinear(self.mean[row], i, j, u, v)
            if np.any(self.half[row]):
                result[row] += approach * _bilinear(self.half[row], i, j, u, v)
        return result

    def half_of(self, row: int, position: np.ndarray, other: np.ndarray) -> np.ndarray | float:
        """(N,) half of forward minus reverse of one component, mm or rad; 0 where it was measured
        one way."""
        if not np.any(self.half[row]):
            return 0.0
        i, u = _interval(self.nodes, position)
        j, v = _interval(self.others, other)
        return _bilinear(self.half[row], i, j, u, v)


Table = TypeVar("Table", AxisTable, GridTable)


def only(table: Table, rows: Sequence[int]) -> Table:
    """The table with these components, the others zero."""
    forward, reverse = np.zeros_like(table.forward), np.zeros_like(table.reverse)
    forward[rows], reverse[rows] = table.forward[rows], table.reverse[rows]
    return replace(table, forward=forward, reverse=reverse)


def _interval(nodes: np.ndarray, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N,) index of the node below and (N,) share of the interval above it; held beyond the
    ends."""
    inside = np.clip(position, nodes[0], nodes[-1])
    at = np.clip(np.searchsorted(nodes, inside, side="right") - 1, 0, len(nodes) - 2)
    return at, (inside - nodes[at]) / (nodes[at + 1] - nodes[at])


def _bilinear(
    value: np.ndarray, i: np.ndarray, j: np.ndarray, u: np.ndarray, v: np.ndarray
) -> np.ndarray:
    #   j + 1  o-----------x---o   high
    #          |           .   |          x: at u along `letter`, then v of the way between both
    #   j      o-----------x---o   low
    #          i           u  i+1
    low = value[i, j] + (value[i + 1, j] - value[i, j]) * u
    high = value[i, j + 1] + (value[i + 1, j + 1] - value[i, j + 1]) * u
    between: np.ndarray = low + (high - low) * v
    return between
