"""Diagonal displacement tests, ISO 230-6: each diagonal evaluated as ISO 230-2 evaluates an axis,
and the largest of each.

A diagonal is named by the signs of its axes in order, oriented so that the last one is P: PPP, NPP,
PNP, NNP in a volume, PP and NP on a face.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np

from postproc.iso.positioning import Positioning

LIMIT = (
    "diagonals alone can not separate scale from squareness: equal diagonals can hide opposite"
    " errors (ISO 230-6 is a quick check)"
)


def orient(direction: Mapping[str, float]) -> tuple[str, dict[str, float]]:
    """Name and unit vector of a diagonal along `direction` (component by axis, none of them 0), the
    last axis made positive."""
    letters = sorted(direction)
    length = float(np.sqrt(sum(direction[x] ** 2 for x in letters)))
    sign = np.sign(direction[letters[-1]])
    unit = {x: float(direction[x] * sign / length) for x in letters}
    return "".join("P" if unit[x] > 0 else "N" for x in letters), unit


def every(axes: str) -> list[str]:
    """Names of the diagonals of a volume (three axes) or a face (two)."""
    return ["".join(signs) + "P" for signs in product("PN", repeat=len(axes) - 1)]


def largest(tests: Mapping[str, Positioning]) -> tuple[dict[str, float | None], dict[str, str]]:
    """E_d and B_d, mm: the largest E and B of the diagonals measured, and which it was. None where
    any of them has none."""
    values: dict[str, float | None] = {}
    which: dict[str, str] = {}
    for name, letter in (("Ed", "E"), ("Bd", "B")):
        found = {d: t.values[letter] for d, t in tests.items()}
        known = {d: v for d, v in found.items() if v is not None}
        values[name] = None
        # one diagonal without a B could be the largest: then there is no largest
        if len(known) == len(found):
            which[name] = max(known, key=lambda d: known[d])
            values[name] = known[which[name]]
    return values, which
