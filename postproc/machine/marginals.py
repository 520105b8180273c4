"""A machine as tables of one axis each: what each axis' own errors do along X, Y and Z while the
other axes stand still.

That is all that a control's own compensation knows. Positioning, straightness, squareness (a line
in the straightness), growth with temperature and effects of an axis are whole in it; what its
rotations do at the end of an arm, and tables over a second axis, are right at one place of the
other axes only, and the notices say by how much elsewhere.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.units import UM

SEEN = 0.05 * UM  # a smaller difference is not worth a node or a notice
# more than a control's table holds: LinuxCNC takes 256, a Fanuc 1,024, Beckhoff 1,500 by default
NODES = 2000
# where a table is compared between its nodes; 0.382 so that no period escapes
SHARES = (0.25, 0.382, 0.5, 0.75)


class Marginal(NamedTuple):
    """One deviation over one axis: moving and along are letters; nodes (K,) mm; forward, reverse
    (K,) mm, for targets approached in + and in -."""

    moving: str
    along: str
    nodes: np.ndarray
    forward: np.ndarray
    reverse: np.ndarray


def pose_of(machine: Machine, moving: str, at: dict[str, float]) -> dict[str, float]:
    """Where the other axes stand: as `at` says, else where `moving` was measured, within their
    travel; rotary axes at 0."""
    result = {}
    for x, axis in machine.axes.items():
        place = float(machine.axes[moving].measured_at[XYZ.index(x)]) if x in XYZ else 0.0
        result[x] = at.get(x, float(np.clip(place, *axis.travel)))
    return result


def _far_away(pose: dict[str, float], by: dict[str, float]) -> dict[str, float]:
    """The axes of a pose elsewhere on which the deviation is another; by: how much, mm, by each."""
    return {o: pose[o] for o in [o for o, off in by.items() if off > SEEN] or list(by)}


def marginals(
    machine: Machine, at: dict[str, float] | None = None
) -> tuple[list[Marginal], list[str]]:
    """The tables that are not zero, and notices in um of what they can not hold.

    at: axis to mm (degrees), where the other axes stand while one moves; an axis that is not named
    stands where the moving one was measured.
    """
    found: list[Marginal] = []
    notices: list[str] = []
    slides = [machine.letters[row] for row in machine.corrected]
    for moving in slides:
        pose = pose_of(machine, moving, at or {})
        own = _alone(machine, moving)
        nodes, missed = _nodes(own, moving, pose)
        # forward, reverse: the axis itself approached in +, then in -
        values = [_along(own, moving, pose, nodes, way) for way in (1.0, -1.0)]
        spread, by = _spread(own, moving, pose, nodes)
        # 1e-9 mm is rounding of the sums: a table of it would be a table of nothing
        for along in slides:
            row = machine.letters.index(along)
            up, down = values[0][row], values[1][row]
            if max(np.abs(up).max(), np.abs(down).max()) > 1e-9:
                found.append(_trimmed(Marginal(moving, along, nodes, up, down)))
            name = f"E{along}{moving}"
            if missed[row] > SEEN:
                notices.append(
                    f"{name} bends more than {NODES} nodes can follow: up to {missed[row] / UM:.2f}"
                    " um between them"
                )
            if spread[row] > SEEN:
                places = _far_away(pose, {o: off[row] for o, off in by.items()})
                notices.append(_elsewhere(name, places, spread[row]))
    notices += _rest(machine, slides)
    return found, notices


def _elsewhere(name: str, stand: dict[str, float], off: float) -> str:
    """What a table is off by where the others do not stand as they did for it; off: mm."""
    return (
        f"{name} is right where {', '.join(f'{o} = {at:g}' for o, at in stand.items())}; elsewhere"
        f" in the travel of {' and '.join(stand)} it is off by up to {off / UM:.2f} um, which a"
        " table of one axis can not hold"
    )


def _trimmed(table: Marginal) -> Marginal:
    """Without the outermost nodes that only hold the value of the next ones."""
    _, _, nodes, up, down = table
    #     o---o---o                  o---o---o    a control holds the first and the last value
    #              '.   .--o--.   .'              beyond its table, as we do: of nodes at the ends
    #             ^ first   '---' ^ last          that have one value only the innermost counts
    steps = np.flatnonzero(np.abs(np.diff(up)) + np.abs(np.diff(down)) >= 1e-12)
    first, last = (steps[0], steps[-1] + 2) if len(steps) else (max(0, len(nodes) - 2), len(nodes))
    return Marginal(table.moving, table.along, nodes[first:last], up[first:last], down[first:last])


def _alone(machine: Machine, moving: str) -> Machine:
    """The machine with no errors but those of one axis."""
    return replace(
        machine,
        axes={x: axis if x == moving else axis.bare for x, axis in machine.axes.items()},
        square={x: lean for x, lean in machine.square.items() if x == moving},
        effects=tuple(term for term in machine.effects if term.axis == moving),
    )


def _along(
    machine: Machine, moving: str, pose: dict[str, float], nodes: np.ndarray, way: float
) -> np.ndarray:
    """(A, K) mm along the nodes of one axis, reached in direction `way`."""
    rows = [nodes if x == moving else np.full(len(nodes), pose[x]) for x in machine.letters]
    # the others' mean: on which side they bear while this one moves a table of one axis can not say
    ways = [np.full(len(nodes), way if x == moving else 0.0) for x in machine.letters]
    return machine.deviation(np.stack(rows), np.stack(ways))


def _nodes(own: Machine, moving: str, pose: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Positions between which straight lines follow the deviation, and (A,) mm of what they still
    miss."""
    low, high = own.axes[moving].travel
    knots = own.knots.get(moving, [])
    nodes = np.unique(np.concatenate(knots)) if knots else np.array([low, high])
    # the travel's ends and all nodes, so far as the nodes reach at least: tables may go beyond the
    # travel
    ends = np.unique(
        np.clip(np.concatenate([[low, high], nodes]), min(low, nodes[0]), max(high, nodes[-1]))
    )
    outside = np.array([ends[0], nodes[0], nodes[-1], ends[-1]])
    # a table that is held beyond its ends needs no node at the end of travel, a line does
    for way in (1.0, -1.0):
        at_ends = _along(own, moving, pose, outside, way)
        if (
            np.abs(at_ends[:, 0] - at_ends[:, 1]).max() > 1e-9
            or np.abs(at_ends[:, 2] - at_ends[:, 3]).max() > 1e-9
        ):
            nodes = ends
            break

    # What a chord misses goes with the square of its length: eight halvings leave 1 / 65536 of it.
    for _ in range(8):
        # halve every interval whose chord misses too much, until none does or the nodes are too
        # many
        by_interval, worst = _missed(own, moving, pose, nodes)
        cut = by_interval > SEEN
        if not cut.any() or len(nodes) + int(cut.sum()) > NODES:
            return nodes, worst
        # Nodes of the machine's own tables stay, since `union1d` only adds: the deviation has its
        # corners there, and between them it is smooth.
        middle = (nodes[:-1] + nodes[1:])[cut] / 2
        nodes = np.union1d(nodes, middle)
    return nodes, _missed(own, moving, pose, nodes)[1]


def _missed(
    own: Machine, moving: str, pose: dict[str, float], nodes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(K - 1,) mm that the chord of each interval misses, and (A,) mm the largest of each axis."""
    gaps = np.diff(nodes)
    total = np.zeros((len(own.letters), len(gaps)))
    for way in (1.0, -1.0):
        value = _along(own, moving, pose, nodes, way)
        for share in SHARES:
            there = _along(own, moving, pose, nodes[:-1] + share * gaps, way)
            total = np.maximum(
                total, np.abs(there - (value[:, :-1] * (1 - share) + value[:, 1:] * share))
            )
    return total.max(axis=0), total.max(axis=1)


def _spread(
    own: Machine, moving: str, pose: dict[str, float], nodes: np.ndarray
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """(A,) mm: how far the deviation is from that at the pose, over the travel of all others, and
    of each other alone."""
    places = _places(own, moving, pose)
    base = [_along(own, moving, pose, nodes, way) for way in (1.0, -1.0)]

    def off(chosen: dict[str, float]) -> np.ndarray:
        stand = {**pose, **chosen}
        both = [
            np.abs(_along(own, moving, stand, nodes, way) - b).max(axis=1)
            for way, b in zip((1.0, -1.0), base, strict=True)
        ]
        largest: np.ndarray = np.maximum(*both)
        return largest

    alone = {x: np.max([off({x: float(p)}) for p in where], axis=0) for x, where in places.items()}
    matter = {x: where for x, where in places.items() if alone[x].max() > 1e-12}
    if not matter:
        return np.zeros(len(own.letters)), {}
    # Arms grow in lines with every other slide, so together they are longest in a corner of the
    # travels; only a table over two axes may have its largest value at a node between.
    corners = [
        off(dict(zip(matter, map(float, p), strict=True)))
        for p in product(*({float(w[0]), float(w[-1])} for w in matter.values()))
    ]
    return np.max([*alone.values(), *corners], axis=0), {x: alone[x] for x in matter}


def _places(own: Machine, moving: str, pose: dict[str, float]) -> dict[str, np.ndarray]:
    """Of each other axis its ends, its place in the pose, and the nodes along it of grids."""
    places = {}
    for x, axis in own.axes.items():
        if x != moving and x in own.chain.axes:
            extra = own.knots.get(x, [])
            inside = np.concatenate([[*axis.travel, pose[x]], *extra])
            places[x] = np.unique(np.clip(inside, *axis.travel))
    return places


def _rest(machine: Machine, slides: list[str]) -> list[str]:
    """A notice where the axes' own parts do not add up to the machine: rotary axes, effects of
    several axes."""
    rows = [machine.axes[x].travel for x in machine.letters]
    if not np.all(np.isfinite([rows[machine.letters.index(x)] for x in machine.chain.axes])):
        return []
    inside = [np.where(np.isfinite(r), r, 0.0) for r in rows]
    # Where effects of several axes are largest no table tells: places all over the volume, drawn
    # with a fixed seed, so that the notice is the same every time.
    shares = np.random.default_rng(1).random((len(rows), 256))
    position = np.stack(
        [low + s * (high - low) for (low, high), s in zip(inside, shares, strict=True)]
    )
    worst = np.zeros(len(rows))
    for way in (1.0, -1.0):
        approach = np.full_like(position, way)
        total = machine.deviation(position, approach)
        for x in slides:
            total = total - _alone(machine, x).deviation(position, approach)
        worst = np.maximum(worst, np.abs(total).max(axis=1))
    return [
        f"up to {worst[machine.letters.index(x)] / UM:.2f} um along {x} belong to no single slide"
        " (rotary axes, effects of several axes) and stay"
        for x in slides
        if worst[machine.letters.index(x)] > SEEN
    ]
