"""A machine with a part of its map: some components, squareness and effects, the others as if the
machine had not got them.

What a control takes out by itself, or what somebody wants to see alone: `--only EXX,EZZ`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from postproc.machine import tables
from postproc.machine.axis import Axis
from postproc.machine.chain import LINEAR
from postproc.machine.model import Machine
from postproc.machine.stated import EffectTerm
from postproc.machine.tables import COMPONENTS, AxisUncertainty

ALONG = (
    "backlash",
    "backlash_position",
    "windup",
    "scale",
    "pitch_shape",
    "cyclic",
    "heat",
)  # what an axis does along itself
PLACES = 9  # of an axis, at which two maps are compared


def names(machine: Machine) -> list[str]:
    """What the map holds: EXX, C0Y, backlash:X, heat:Z."""
    found = []
    for x, axis in machine.axes.items():
        rows = {row for table in axis.tables for row in table.rows}
        found += [f"{COMPONENTS[row]}{x}" for row in sorted(rows)]
        found += [f"heat:{x}"] if axis.expansion is not None else []
    effects = [f"{t.name}:{t.axis}" for t in machine.effects if t.module is not None]
    return [*found, *machine.angles, *effects]


def only(machine: Machine, wanted: Iterable[str]) -> Machine:
    """The machine with these names of its map alone, and with the control's own tables, which work
    whatever is wanted.

    A positioning stands for all that acts along its axis: EXX brings backlash:X and heat:X along.
    """
    chosen = set(wanted)
    # a control that holds EXX of an axis holds its backlash and growth as well, as a user of --only
    # means it
    chosen |= {f"{kind}:{x}" for x in machine.axes if f"E{x}{x}" in chosen for kind in ALONG}
    axes = {x: _axis(x, axis, chosen) for x, axis in machine.axes.items()}
    square = {x: np.where(_of_square(x, chosen), lean, 0.0) for x, lean in machine.square.items()}
    digest = hashlib.sha256(f"{machine.digest} {sorted(chosen)}".encode()).hexdigest()[:8]
    return replace(
        machine,
        axes=axes,
        square=square,
        digest=digest,
        effects=tuple(t for t in machine.effects if _kept(t, chosen)),
        # what is not corrected has no part in the uncertainty of the correction
        square_u={name: u for name, u in machine.square_u.items() if name in chosen},
    )


def largest_left(machine: Machine, part: Machine) -> float:
    """mm: by how much the whole map goes beyond its part, at most, at places of all axes' tables
    and travels."""
    places = []
    for x in machine.letters:
        table = machine.tables.get(x)
        nodes = (
            np.array(machine.axes[x].travel if x in LINEAR else (0.0,))
            if table is None
            else table.nodes
        )
        # a grid of all axes: at most 9 places each, 729 of three
        places.append(nodes[np.unique(np.linspace(0, len(nodes) - 1, PLACES).astype(int))])
    grid = np.stack([g.ravel() for g in np.meshgrid(*places, indexing="ij")])
    # all axes approached in -, then all in +: what reverses shows at one of them
    sides = [np.full_like(grid, s) for s in (-1.0, 1.0)]
    return max(
        float(np.linalg.norm(machine.deviation(grid, s) - part.deviation(grid, s), axis=0).max())
        for s in sides
    )


def _of_square(letter: str, chosen: set[str]) -> np.ndarray:
    """(3,) whether each of the three leans of an axis is chosen."""
    return np.array([f"{turn}0{letter}" in chosen for turn in "ABC"])


def _axis(letter: str, axis: Axis, chosen: set[str]) -> Axis:
    rows = [row for row in range(6) if f"{COMPONENTS[row]}{letter}" in chosen]
    stated_rows = axis.table.stated if axis.table is not None else ()
    # What was left out on purpose was measured all the same: without this `machines show` would ask
    # for it again (lacks.py).
    gone = [f"{COMPONENTS[row]}{letter}" for row in sorted({*stated_rows} - {*rows})]
    return replace(
        axis,
        table=None if axis.table is None else tables.only(axis.table, rows),
        grids=tuple(tables.only(g, rows) for g in axis.grids),
        expansion=axis.expansion if f"heat:{letter}" in chosen else None,
        uncertainty=_uncertainty(axis, rows),
        left_out=(*axis.left_out, *gone),
    )


def _uncertainty(axis: Axis, rows: list[int]) -> AxisUncertainty | None:
    u = axis.uncertainty
    if u is None:
        return None
    stated = tuple(row for row in u.stated if row in rows)
    return replace(u, table=tables.only(u.table, rows), stated=stated)


def _kept(term: EffectTerm, chosen: set[str]) -> bool:
    return term.module is None or f"{term.name}:{term.axis}" in chosen or term.name in chosen
