"""A table with fewer nodes, for controls that hold few. No control."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.control_tables import ErrorTable
from postproc.control_tables import _common as common
from postproc.units import UM


def thinned(table: ErrorTable, most: int) -> tuple[ErrorTable, float]:
    """At most `most` of the table's nodes, and the largest deviation in mm that straight lines
    between them miss."""
    if len(table.nodes) <= most:
        return table, 0.0
    values = np.stack([table.forward, table.reverse])
    low, high = 0.0, float(np.ptp(values, axis=1).max()) + UM
    # Bisection over the bound: wider bounds need no more nodes, and 40 halvings of a map's range
    # are far below a picometre.
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (
            (low, middle) if len(_chords(table.nodes, values, middle)) <= most else (middle, high)
        )
    keep = _chords(table.nodes, values, high)
    result = replace(
        table, nodes=table.nodes[keep], forward=table.forward[keep], reverse=table.reverse[keep]
    )
    return result, common.left(table, result)


def _chords(nodes: np.ndarray, values: np.ndarray, bound: float) -> list[int]:
    """Indices of nodes between which straight lines miss no node by more than `bound`, each as far
    as it goes."""
    keep, first, last = [0], 0, len(nodes) - 1
    while first < last:
        reach = first + 1
        # slopes that pass every node between within the bound
        #              .
        #     first *:.....  i      a chord may end at i where its slope is one of those that pass
        #              '            each node before i within the bound: a cone that only narrows
        steep, flat = np.full(len(values), np.inf), np.full(len(values), -np.inf)
        for i in range(first + 1, last + 1):
            run = nodes[i] - nodes[first]
            slope = (values[:, i] - values[:, first]) / run
            if np.all(slope <= steep) and np.all(slope >= flat):
                reach = i
            steep = np.minimum(steep, slope + bound / run)
            flat = np.maximum(flat, slope - bound / run)
            if np.any(flat > steep):
                break
        keep.append(reach)
        first = reach
    return keep
