"""The deviation in parts: what every component, angle and effect does to it by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS, GridTable


def contributions(
    machine: Machine, position: np.ndarray, approach: np.ndarray
) -> list[tuple[str, np.ndarray]]:
    """Name and (A, N) mm of every part of the deviation by itself: components, squareness,
    effects."""
    result = []
    bare = {x: axis.bare for x, axis in machine.axes.items()}

    def add(name: str, x: str = "", square=None, effects=(), **errors) -> None:
        axes = {**bare, x: replace(bare[x], **errors)} if x else bare
        part = replace(machine, axes=axes, square=square or {}, effects=effects)
        result.append((name, part.deviation(position, approach)))

    for x, axis in machine.axes.items():
        for table in axis.tables:
            for i in table.rows:
                only = (np.arange(6) == i).reshape((6,) + (1,) * (table.forward.ndim - 1))
                forward, reverse = (
                    np.where(only, table.forward, 0.0),
                    np.where(only, table.reverse, 0.0),
                )
                one = replace(table, forward=forward, reverse=reverse)
                by = f" by {table.other}" if isinstance(table, GridTable) else ""
                add(f"{COMPONENTS[i]}{x}{by}", x, **({"grids": (one,)} if by else {"table": one}))
        if x in machine.expansions:
            add(f"heat {x}", x, expansion=axis.expansion)
        for i in map(int, np.flatnonzero(axis.location)):
            add(
                f"{(XYZ + ROTARY)[i]}0{x}",
                x,
                location=np.where(np.arange(6) == i, axis.location, 0.0),
            )
    for x, lean in machine.square.items():
        for i in map(int, np.flatnonzero(lean)):
            add(f"{ROTARY[i]}0{x}", square={x: np.where(np.arange(3) == i, lean, 0.0)})
    for term in machine.effects:
        add(term.name, effects=(term,))
    return result
