"""Where the nodes of each component stand: a component is known where readings see it, so its nodes
are their places and no others.

A laser along X beside step diagonals sees EXX at twenty places; EYX is seen by the diagonals alone,
at seven, and has these seven.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.volumetric.rows import SAME, Rows, angle_columns, nominal_tip
from postproc.volumetric.step_diagonals import on_the_beam
from postproc.volumetric.unknowns import Group, Unknowns, components

MOST = 15  # places that are nodes as they are; beyond, EVEN nodes from the first to the last
EVEN = 11
# mm by mm or rad: what acts less on a reading than this is not seen by it
SEEN = 1e-6
ENDS = 0.02  # of what an axis was moved: so much nearer its ends, the ends themselves are nodes


def of_axes(
    rows: Sequence[Rows], machine: Machine, number: int | None = None
) -> dict[str, np.ndarray]:
    """Slide to (K,) mm of its nodes, of those that moved: the places at which it was read, or
    `number` even ones."""
    found = {}
    for x in (x for x in XYZ if x in machine.chain.axes):
        at = _places(rows, machine, x, [np.ones(r.q.shape[1], bool) for r in rows])
        # an axis that rests all through: its errors are constants of the set-ups
        if np.ptp(at) < SAME:
            continue
        found[x] = _thinned(at, number)
    return found


def of_components(
    rows: Sequence[Rows], machine: Machine, axes: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Component (EYX) to (K,) mm of its nodes, where they are others than those of its axis: the
    places of the readings that see it. Both ends of its axis are nodes, so a component that was
    seen on a part of it alone is not held on beyond."""
    ends = {x: at[[0, -1]] for x, at in axes.items()}
    # each component as a constant: a reading that it does not move at all does not see it
    one = Unknowns(tuple(_constant(machine, ends)), machine, machine)
    sees = [_seen(r, one) for r in rows]
    found = {}
    for k, group in enumerate(one.groups):
        low, high = ends[group.letter]
        at = _places(rows, machine, group.letter, [s[k] for s in sees])
        inside = at[(at > low + ENDS * (high - low)) & (at < high - ENDS * (high - low))]
        if not len(at):
            continue
        #    axis    |------------------------|
        #    seen        o    o     o    o            Nodes are these places and both ends: from its
        #    nodes   x   x    x     x    x    x       last place on a component goes to a value of
        #                                             its own, which the prior holds near zero.
        mine = _thinned(np.concatenate([[low], inside, [high]]), None)
        if len(mine) < len(axes[group.letter]):
            found[group.name] = mine
    return found


def _constant(machine: Machine, ends: dict[str, np.ndarray]) -> list[Group]:
    """Each component as one number, the same all along its axis."""
    return [
        Group(g.name, g.letter, g.row, ends[g.letter], np.ones((2, 1)), g.prior)
        for g in components(machine, {x: np.append(at, at.mean()) for x, at in ends.items()})
        if len(g.nodes)
    ]


def _seen(r: Rows, unknowns: Unknowns) -> np.ndarray:
    """(P, N): whether each place of a set-up shows each number."""

    def effect(tool: np.ndarray) -> np.ndarray:
        return unknowns.columns(r.q, r.approach, tool)

    columns = on_the_beam(effect, r.tool, r.aside) if r.kind == "stair" else effect(r.tool)
    off = np.zeros((3, r.q.shape[1]))
    nominal = nominal_tip(unknowns.bare, r.q, r.tool)
    by, _ = r.slopes(columns, off, r.start, nominal, angle_columns(unknowns, r))
    # of a cloud X of all places stands first, then Y, then Z
    # a place shows a number if any of its three coordinates does
    each: np.ndarray = np.abs(by).reshape(-1, r.q.shape[1], unknowns.number).max(axis=0).T
    return each > SEEN


def _places(
    rows: Sequence[Rows], machine: Machine, letter: str, which: Sequence[np.ndarray]
) -> np.ndarray:
    i = machine.letters.index(letter)
    return np.unique(
        np.round(np.concatenate([r.q[i][w] for r, w in zip(rows, which, strict=True)]), 3)
    )


def _thinned(at: np.ndarray, number: int | None) -> np.ndarray:
    if number is None and len(at) <= MOST:
        return at
    return np.round(np.linspace(at[0], at[-1], number or EVEN), 6)
