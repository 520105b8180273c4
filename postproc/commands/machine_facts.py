"""What a machine's folder states, for other programs, and what its tables come to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from postproc.machine.axis import Axis
from postproc.machine.chain import LINEAR, ROTARY
from postproc.machine.lacks import lacks
from postproc.machine.model import Machine
from postproc.machine.plausibility import implausible
from postproc.machine.tables import COMPONENTS
from postproc.machine.uncertainty import MapUncertainty, micrometres, unstated
from postproc.units import UM, URAD

FORMAT = "gcomp-machines/1"
PLACES = 200_000  # at which the whole map is looked at, in all axes together: 50 MB, 0.3 s


def document(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Of one machine or many."""
    return {"format": FORMAT, "machines": list(rows)}


def of(machine: Machine) -> dict[str, Any]:
    """One machine with its numbers."""
    found = MapUncertainty(machine)
    return {
        "name": machine.name,
        "title": machine.title,
        "control": machine.control,
        "map": machine.digest,
        "source": machine.source or None,
        "chain": machine.chain.links,
        "diameter": list(machine.diameter),
        "axes": {x: _axis(axis) for x, axis in machine.axes.items()},
        "squareness_urad": {name: value / URAD for name, value in machine.angles.items()},
        "squareness_U_urad": {name: float(u / URAD) for name, u in machine.square_u.items()},
        "effects": [
            {"effect": t.name, "axis": t.axis or None, "parameters": dict(t.parameters)}
            for t in machine.effects
        ],
        "offsets_mm": {name: dict(zero) for name, zero in machine.offsets.items()},
        "largest_deviation_um": 0.0 if machine.is_zero else largest(machine) / UM,
        "U_um": largest_u(machine) / UM if found.parts else None,
        "in_doubt": list(implausible(machine)),
        "not_in_map": list(lacks(machine)),
    }


def _axis(axis: Axis) -> dict[str, Any]:
    table = axis.table
    components = {}
    for row in [] if table is None else table.rows:
        assert table is not None
        unit, scale = ("um", UM) if row < 3 else ("urad", URAD)
        both = np.stack([table.forward[row], table.reverse[row]]) / scale
        components[f"{COMPONENTS[row]}{axis.letter}"] = {
            "least": float(both.min()),
            "largest": float(both.max()),
            "reversal": float(np.abs(both[0] - both[1]).max()),
            "unit": unit,
        }
    return {
        "unit": "mm" if axis.letter in LINEAR else "deg",
        "travel": [float(v) for v in axis.travel],
        "least_increment": float(axis.least_increment),
        "nodes": 0 if table is None else len(table.nodes),
        "components": components,
    }


def largest_u(machine: Machine) -> float:
    """mm: how well the map is known on its nodes, at worst (95 %)."""
    found, grid = MapUncertainty(machine), _grid(machine)
    return max(float(found.length(grid, np.full_like(grid, s)).max()) for s in (-1.0, 1.0))


def known(machine: Machine) -> str:
    """How well the whole map is known, and of what nothing is stated."""
    found = MapUncertainty(machine)
    if not found.parts:
        return "the map's own uncertainty is not stated"
    worst = largest_u(machine)
    return (
        f"the map itself is known to +- {micrometres(worst)} um (95 %) on its"
        f" nodes{unstated(found.missing)}"
    )


def largest(machine: Machine) -> float:
    """mm: largest deviation vector over the grid of all nodes and ends, both ways."""
    grid = _grid(machine)
    return max(
        float(np.linalg.norm(machine.deviation(grid, np.full_like(grid, s)), axis=0).max())
        for s in (-1.0, 1.0)
    )


def _grid(machine: Machine) -> np.ndarray:
    """(A, N) mm: all nodes, or some of them."""
    nodes = [_some(machine, x) for x in machine.letters]
    return np.stack([g.ravel() for g in np.meshgrid(*nodes, indexing="ij")])


def _some(machine: Machine, letter: str) -> np.ndarray:
    """Nodes of an axis: all of them, but where several axes make that too many, some spread over
    turn or travel. Of a slide without a table the ends of its reach, where what leans is
    farthest off."""
    if letter not in machine.tables and letter in LINEAR:
        return np.array(machine.reached[letter])
    nodes = machine.tables[letter].nodes if letter in machine.tables else np.zeros(1)
    if letter in ROTARY and nodes[-1] - nodes[0] > 360.0:
        nodes = np.arange(0.0, 360.0, 45.0)
    most = int(PLACES ** (1.0 / len(machine.letters)))
    return nodes if len(nodes) <= most else nodes[np.linspace(0, len(nodes) - 1, most).astype(int)]
