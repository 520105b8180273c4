"""A table of errors in numbers: what is asked of it where there is one place alone.

The steps are those of columns (tables.py), so that the same number comes out to the last bit; a
step in numbers takes a tenth of what it takes in a column of one.
"""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

Value = np.ndarray | float  # (N,) of places, or of one place alone
Rates = list[list[tuple[float, float]]]  # of each interval, per row: rise, and value at its begin


class Cells:
    """nodes (K,) mm; step: mm between them where they are even, else 0; base, rise (R, K - 1): the
    value of each row at the lower node of each interval, and by how much it rises to the upper."""

    def __init__(self, nodes: np.ndarray, step: float, base: np.ndarray, rise: np.ndarray):
        self.step = step
        self.nodes, self.inner = nodes.tolist(), nodes[1:-1].tolist()
        self.width, self.per = np.diff(nodes).tolist(), 1.0 / step if step else 0.0
        self.last = len(nodes) - 2
        both = zip(rise.T.tolist(), base.T.tolist(), strict=True)
        self.rates: Rates = [list(zip(*one, strict=True)) for one in both]

    def values(self, position: float) -> list[float]:
        """Of each row at a place, mm."""
        if self.step:
            place = min(max((position - self.nodes[0]) * self.per, 0.0), self.last + 1.0)
            cell = min(int(place), self.last)
            share = place - cell
        else:
            inside = min(max(position, self.nodes[0]), self.nodes[-1])
            cell = bisect_right(self.inner, inside)
            share = (inside - self.nodes[cell]) / self.width[cell]
        return [rise * share + base for rise, base in self.rates[cell]]
