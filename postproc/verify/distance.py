"""How far a point is from the path of a motion: from a line, an arc, a spiral or a helix."""

from __future__ import annotations

import numpy as np

from postproc.compensate.arcs import points
from postproc.machine.model import Machine
from postproc.motions import CLOCKWISE, COUNTER, RAPID, Motions
from postproc.units import TICKS_PER_MM

# shares of a motion at which it is looked at, in golden section: never in step with the nodes
PLACES = (np.arange(1, 129) * 0.6180339887498949) % 1.0


def all_known(machine: Machine, axes: np.ndarray) -> np.ndarray:
    """(N,) bool: whether all axes that carry the tool or the part are known, of (A, N)."""
    return np.all(axes[list(machine.chained)], axis=0)


def points_of(motions: Motions, curved: np.ndarray, row: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(A, K) mm: points of motions at t."""
    start, target = motions.start / TICKS_PER_MM, motions.target / TICKS_PER_MM
    result = start[:, row] + (target - start)[:, row] * t
    # by itself: start + way * 1 may miss the last digit of the target
    result = np.where(t == 1.0, target[:, row], result)
    on = curved[row] >= 0
    if on.any():
        of = motions.arcs.motion
        result[:, on] = points(motions.arcs, start[:, of], target[:, of], curved[row[on]], t[on])
    return result


def to_path(
    machine: Machine, nominal: Motions, owner: np.ndarray, t: np.ndarray, actual: np.ndarray
) -> np.ndarray:
    """(K,) mm from actual points to their nominal path, in the corrected axes of a machine as its
    motions see it."""
    rows = list(machine.corrected)
    start = (nominal.start / TICKS_PER_MM)[:, owner]
    target = (nominal.target / TICKS_PER_MM)[:, owner]
    point = actual[rows]
    way = (target - start)[rows]
    rapid = (nominal.code[owner] == RAPID) | ~all_known(machine, nominal.start_known)[owner]
    #                 o actual
    #                 |          the distance is square to the way; beyond its ends, and of a rapid,
    #   start --------+--> target   whose path the control chooses, it is that to the end
    #          along
    square = (way**2).sum(axis=0)
    along = np.where(
        square > 0,
        ((point - start[rows]) * way).sum(axis=0) / np.where(square > 0, square, 1.0),
        1.0,
    )
    turning = list(machine.turning)
    # while the part or the tool turns, being ahead on the path is as wrong as being beside it
    if turning:
        along = np.where((target - start)[turning].any(axis=0), t, along)
    along = np.where(rapid | (t == 1.0), 1.0, np.clip(along, 0.0, 1.0))
    distance = np.sqrt(((point - start[rows] - way * along) ** 2).sum(axis=0))
    at_target = np.sqrt(((point - target[rows]) ** 2).sum(axis=0))
    distance = np.where(along == 1.0, at_target, distance)
    curved = np.isin(nominal.code[owner], (CLOCKWISE, COUNTER)) & (t < 1.0) & ~rapid
    if curved.any():
        arc_of = np.full(len(nominal), -1)
        arc_of[nominal.arcs.motion] = np.arange(len(nominal.arcs))
        k = np.flatnonzero(curved)
        distance[k] = _from_arc(
            machine, nominal, arc_of[owner[k]], t[k], actual[:, k], start[:, k], target[:, k]
        )
    return distance


def _from_arc(
    machine: Machine,
    nominal: Motions,
    arc: np.ndarray,
    t: np.ndarray,
    actual: np.ndarray,
    start: np.ndarray,
    target: np.ndarray,
) -> np.ndarray:
    """(K,) mm from points to a circle, spiral or helix: across in the plane, and along the
    other axes."""
    arcs, column = nominal.arcs, np.arange(len(arc))
    first, second = arcs.first[arc], arcs.second[arc]
    arm = np.stack([actual[first, column], actual[second, column]]) - arcs.centre[:, arc]
    angle = np.arctan2(arm[1], arm[0])
    expected = arcs.angle[arc] + arcs.sweep[arc] * t
    # the place of the circle nearest to the point, on the turn that t says
    t = t + np.angle(np.exp(1j * (angle - expected))) / arcs.sweep[arc]
    t = np.clip(t, 0.0, 1.0)
    radius = arcs.radius[arc] + (arcs.radius_end - arcs.radius)[arc] * t
    # From the nominal point at t: outwards, and what is left of the way ahead and along once
    # the helix' own direction is taken out.
    outwards = (np.hypot(*arm) - radius) ** 2
    # what is left along the circle where t was held at an end of the arc
    turn = radius * np.angle(np.exp(1j * (angle - arcs.angle[arc] - arcs.sweep[arc] * t)))
    pace = radius * arcs.sweep[arc]
    square, along, length = turn**2, turn * pace, pace**2
    for row in machine.corrected:
        way = np.where((first != row) & (second != row), (target - start)[row], 0.0)
        off = np.where((first != row) & (second != row), actual[row] - start[row] - way * t, 0.0)
        square, along, length = square + off**2, along + off * way, length + way**2
    # pace and way: the helix' direction by t. What of the rest lies along it is no distance from
    # the path, only a later place on it: by Pythagoras it is taken off.
    square = outwards + np.maximum(square - along**2 / np.maximum(length, 1e-30), 0.0)
    return np.sqrt(square)
