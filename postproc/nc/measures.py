"""By what axis words are measured: ticks of a unit and of a least increment, and its decimals."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from postproc.nc.batch import DIAM90, LINEAR, Batch

Measures = tuple[np.ndarray, np.ndarray, np.ndarray]


def measures(b: Batch) -> Measures:
    """(A, B) or (A, 1) each: ticks of one unit and of one least increment of each axis' word, and
    decimals of that increment. Remembered for modes that hold throughout."""
    units, diameter = b.held("units"), b.held("diameter")
    key = None
    if not b.polar and isinstance(units, int) and isinstance(diameter, int) and diameter != DIAM90:
        key = units, diameter
        if key in b.control.measures:
            return b.control.measures[key]
    found = _columns(b, units)
    if key is not None:
        b.control.measures[key] = found
    return found


def _columns(b: Batch, units: Any) -> Measures:
    """The same for any modes. units: the code in force, (B,) or one number."""
    each = []
    for letter in b.rows:
        half, measured = b.halves(letter), b.measured(letter)
        least = places_of(b.setup.least_increment.get(measured, 1e-4))
        unit, increment = b.unit_scale(letter)
        # where a least increment is 0.001 mm it is 0.0001 inch: one decimal more
        more = (units == 200) if measured in LINEAR else 0
        each.append((unit // half, increment // half, least + more))
    n = max((np.size(value) for row in each for value in row), default=1)
    table = np.empty((3, len(each), n), np.int64)
    for row, values in enumerate(each):
        for k, value in enumerate(values):
            table[k, row] = value
    return table[0], table[1], table[2]


@lru_cache
def places_of(increment: float) -> int:
    """Decimals of a least increment."""
    return int(-round(np.log10(increment)))
