"""The deviation in parts: what every component, angle and effect does to it by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from postproc.machine.axis import Axis
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS, GridTable, only


def contributions(
    machine: Machine, position: np.ndarray, approach: np.ndarray
) -> list[tuple[str, np.ndarray]]:
    """Name and (A, N) mm of every part of the deviation by itself: components, squareness,
    effects."""
    without = machine.bare
    bare = without.axes
    parts: list[tuple[str, Machine]] = []
    for x, axis in machine.axes.items():
        heated = x in machine.expansions
        for name, errors in (*_tables(x, axis), *_frame(x, axis, heated)):
            parts.append((name, replace(without, axes={**bare, x: replace(bare[x], **errors)})))
    for x, lean in machine.square.items():
        for i, angle in _each(lean):
            parts.append((f"{ROTARY[i]}0{x}", replace(without, square={x: angle})))
    parts += [(term.name, replace(without, effects=(term,))) for term in machine.effects]
    # Parts add up to the whole to first order, since the deviation is linear in every error
    # (chain.py); each is a machine of its own, so an arm, a tool and a pose count as they do in the
    # whole.
    return [(name, part.deviation(position, approach)) for name, part in parts]


def _tables(letter: str, axis: Axis) -> Iterator[tuple[str, dict[str, Any]]]:
    """Name and errors of every component of an axis."""
    for table in axis.tables:
        for i in table.rows:
            if isinstance(table, GridTable):
                yield f"{COMPONENTS[i]}{letter} by {table.other}", {"grids": (only(table, [i]),)}
            else:
                yield f"{COMPONENTS[i]}{letter}", {"table": only(table, [i])}


def _frame(letter: str, axis: Axis, heated: bool) -> Iterator[tuple[str, dict[str, Any]]]:
    """Name and errors of an axis' expansion, and of each part of its location."""
    if heated:
        yield f"heat {letter}", {"expansion": axis.expansion}
    for i, part in _each(axis.location):
        yield f"{(XYZ + ROTARY)[i]}0{letter}", {"location": part}


def _each(values: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """Index of each value that is not zero, and the values with the others zero."""
    for i in map(int, np.flatnonzero(values)):
        yield i, np.where(np.arange(len(values)) == i, values, 0.0)
