"""Inside cutter radius compensation: where the tool's centre stands, and how little a block may
turn by its correction.

The control shifts every block sideways by the radius and joins the shifted blocks: outside corners
by an arc around the corner, inside corners where the shifted blocks meet, which lies `radius /
tan(half the angle)` before the corner (LinuxCNC, src/emc/rs274ngc/interp_convert.cc,
convert_straight_comp2 and convert_arc_comp2). So

- a block that rests in the plane must not move there at all: a motion of 1 um has a direction of
  its own, and the tool swings by its radius; and one that moves may turn but little, by SLANT at
  most. What can not be followed is held.
- a piece that is shorter than the way from the corner to where the shifted blocks meet would be run
  backwards, or end the program: a cut keeps clear of the corner behind it, which is known, and
  MARGIN radii from the one ahead. Where the radius is not stated nothing is cut.
- the map holds for the centre. Its place beside a block follows from the block alone, so that no
  look ahead is needed. At a corner the place of the block before it is taken: the centre swings on
  from there by two radii at most.
"""

from __future__ import annotations

import numpy as np

from postproc.compensate.columns import Columns
from postproc.compensate.inverse import command
from postproc.errors import Notice
from postproc.motions import ENTRY, FREE, OFFSET
from postproc.units import TICKS_PER_MM, UM

# rad: two neighbours then stay below the 0.05 rad from which LinuxCNC takes a bend for a corner
SLANT = 0.02
# LinuxCNC: TOLERANCE_CONCAVE_CORNER. Straight blocks meet 1 / tan(half the angle) radii before
# their corner, a line and an
# arc at most twice that: four radii hold for corners down to 28 degrees, with an arc down to 53.
MARGIN = 4.0
BACK = 0.1  # rad
# mm/mm: by how much the ends of an arc may move apart where the tool may hardly be smaller than it
BEND = 1e-4
FREELY = np.iinfo(np.int64).max


def reads_beside(b: Columns) -> bool:
    """Whether any block has a centre that is known to lie beside it."""
    return bool((np.isfinite(b.m.radius) & (b.m.radius != 0)).any())


def centre(b: Columns, stroke: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(A, K) mm from the contour at t of strokes to the point that the slides carry; 0 where it is
    not known."""
    m, motion = b.m, b.motion[stroke]
    result = np.zeros((len(b.machine.axes), len(stroke)))
    which = np.flatnonzero(
        (m.cutter[motion] != FREE)
        & np.isfinite(m.radius[motion])
        & (m.plane[:, motion] >= 0).all(axis=0)
    )
    if not len(which):
        return result
    motion, t = motion[which], t[which]
    beside = m.radius[motion] * normal(b, stroke[which], t) + m.nose[:, motion]
    beside *= np.where(m.cutter[motion] == ENTRY, t, 1.0)  # it is approached along the block
    result[m.plane[0, motion], which], result[m.plane[1, motion], which] = beside
    return result


def commands(
    b: Columns, stroke: np.ndarray, t: np.ndarray, nominal: np.ndarray, weight: np.ndarray
) -> np.ndarray:
    """(A, K) mm: commands at t along strokes, the map read where the tool's centre is."""
    if not b.reads_beside:
        return command(b.machine, nominal, weight, b.motion[stroke])
    beside = centre(b, stroke, t)
    commands: np.ndarray = command(b.machine, nominal + beside, weight, b.motion[stroke]) - beside
    return commands


def normal(b: Columns, stroke: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(2, K) unit vectors to the left of the path in its plane; 0 where a stroke rests in it."""
    m, motion = b.m, b.motion[stroke]
    column = np.arange(len(stroke))
    first, second = (b.travel[row, stroke] / TICKS_PER_MM for row in m.plane[:, motion])
    length = np.hypot(first, second)
    left = np.stack([-second, first]) / np.where(length > 0, length, 1.0)
    arc = b.arc_of[motion]
    on = column[arc >= 0]
    if len(on):
        arcs, arc = m.arcs, arc[on]
        # Left of a counter-clockwise arc is its centre, left of a clockwise one away from it.
        angle = arcs.angle[arc] + arcs.sweep[arc] * t[on]
        left[:, on] = -np.sign(arcs.sweep[arc]) * np.stack([np.cos(angle), np.sin(angle)])
    return left


def approach_on_arcs(
    b: Columns, stroke: np.ndarray, t: np.ndarray, weight: np.ndarray
) -> np.ndarray:
    """(A, K) weight of approach where arcs are not cut at the places at which an axis turns back:
    by the tangent."""
    arc = b.arc_of[b.motion[stroke]]
    on = np.flatnonzero((arc >= 0) & (b.m.cutter[b.motion[stroke]] != FREE))
    if len(on) and b.c.follows and not b.tip:
        arcs, arc = b.m.arcs, arc[on]
        angle, sense = arcs.angle[arc] + arcs.sweep[arc] * t[on], np.sign(arcs.sweep[arc])
        weight = weight.copy()
        for row, way in ((arcs.first[arc], -np.sin(angle)), (arcs.second[arc], np.cos(angle))):
            weight[row, on] = np.where(
                b.machine.two_way[row], np.sign(way) * sense, weight[row, on]
            )
    return weight


def last_way(b: Columns, travel: np.ndarray) -> np.ndarray:
    """(A, S) travel whose sign is that of the last part of arcs that are not cut where an axis
    turns back."""
    arc = b.arc_of[b.motion]
    on = np.flatnonzero((arc >= 0) & (b.m.cutter[b.motion] != FREE))
    if len(on):
        arcs, arc, travel = b.m.arcs, arc[on], travel.copy()
        angle = arcs.angle[arc] + arcs.sweep[arc] * (1 - 1e-4)
        sense = np.sign(arcs.sweep[arc]).astype(np.int64)
        travel[arcs.first[arc], on] = sense * np.sign(-np.sin(angle)).astype(np.int64)
        travel[arcs.second[arc], on] = sense * np.sign(np.cos(angle)).astype(np.int64)
    return travel


def leash(b: Columns) -> np.ndarray | None:
    """(A, S) ticks by which the correction of an axis may change along a stroke, in whole
    increments; None: freely."""
    m, motion = b.m, b.motion
    inside = np.flatnonzero((m.cutter[motion] != FREE) & (m.plane[:, motion] >= 0).all(axis=0))
    if not len(inside):
        return None
    of = motion[inside]
    way = np.hypot(*(b.travel[row, inside].astype(float) for row in m.plane[:, of]))
    arc = b.arc_of[of]
    on = np.flatnonzero(arc >= 0)
    if len(on):
        way[on] = np.abs(m.arcs.sweep[arc[on]]) * m.arcs.radius[arc[on]] * TICKS_PER_MM
    freely = SLANT * way
    if len(on):
        freely[on] = np.minimum(freely[on], _room(b, arc[on], way[on]))
    result = np.full(b.travel.shape, FREELY)
    for row in m.plane[:, of]:
        step = m.grid[row, of]
        result[row, inside] = np.floor(freely / step).astype(np.int64) * step
    return result


def leaves_at_rest(b: Columns) -> np.ndarray:
    """(S,) bool: strokes that lead out and rest in the plane, where nothing is corrected then."""
    m, rests = b.m, np.ones(len(b.motion), bool)
    for row in m.plane:
        rests &= b.travel[row[b.motion], np.arange(len(rests))] == 0
    leaves: np.ndarray = ((m.cutter == ENTRY) & (m.radius == 0) & (m.plane >= 0).all(axis=0))[
        b.motion
    ]
    return leaves & rests


def _room(b: Columns, arc: np.ndarray, way: np.ndarray) -> np.ndarray:
    """(K,) ticks by which the ends of arcs may move apart, so that a tool on their inside that fits
    still fits."""
    arcs, radius = b.m.arcs, b.m.radius[b.m.arcs.motion[arc]]
    wide = (np.minimum(arcs.radius, arcs.radius_end)[arc] - np.abs(radius)) / 2 * TICKS_PER_MM
    wide = np.where(radius * arcs.sweep[arc] > 0, np.maximum(wide, 0.0), np.inf)
    return np.where(np.isfinite(radius), wide, BEND * way)


def heading(b: Columns) -> tuple[float, float]:
    """The unit tangent in the plane in which the last motion inside ended."""
    if not b.inside:
        return (0.0, 0.0)
    along, moves = _headings(b, np.ones(len(b.motion)))
    last = b.motion[-1]
    if b.m.cutter[last] == FREE:
        return (0.0, 0.0)
    at = np.flatnonzero(moves)
    first, second = along[:, at[-1]] if len(at) else b.carry.heading
    return float(first), float(second)


def _headings(b: Columns, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(2, S) unit tangents of strokes in the plane at t, and (S,) bool whether they move there
    inside compensation."""
    left = normal(b, np.arange(len(b.motion)), t)
    along = np.stack([left[1], -left[0]])
    return along, (b.m.cutter[b.motion] != FREE) & along.any(axis=0)


def behind(b: Columns, chosen: np.ndarray) -> np.ndarray:
    """(K,) mm from the begin of strokes to where their shifted way begins, behind an inside
    corner."""
    ends, moves = _headings(b, np.ones(len(b.motion)))
    begins = _headings(b, np.zeros(len(b.motion)))[0][:, chosen]
    last = np.maximum.accumulate(np.where(moves, np.arange(len(moves)), -1))
    last = np.concatenate([[-1], last[:-1]])[chosen]
    before = np.where(last >= 0, ends[:, np.maximum(last, 0)], np.array(b.carry.heading)[:, None])
    radius = b.m.radius[b.motion[chosen]]
    #        |   |     An inside corner to the left, the tool on the left: the shifted ways lie r
    #        |   |     beside their blocks and meet at +, as far before the corner o as behind it:
    #     ---+   |     r / tan((pi - turn) / 2) = r tan(turn / 2)
    #     -------o
    across = before[0] * begins[1] - before[1] * begins[0]
    along = (before * begins).sum(axis=0)
    # One that turns right back counts as an inside corner on either side: behind an arc LinuxCNC
    # takes it for one.
    inner = (across * radius > 0) | (along < -np.cos(BACK))
    turn = np.where(inner, np.arctan2(np.abs(across), along), 0.0)
    # A line and an arc meet at most twice as far away as two lines; no block is shorter than the
    # map is steep.
    behind: np.ndarray = np.abs(radius) * np.maximum(2 * np.tan(turn / 2), 1.0)
    return behind


def arcs_inside(b: Columns) -> dict[str, np.ndarray]:
    """What Fitter must know of arcs: which are inside, the shortest piece of one, and the tool that
    must fit."""
    motion = b.m.arcs.motion
    inside, radius = b.m.cutter[motion] != FREE, b.m.radius[motion]
    tool = np.where(
        np.isnan(radius), np.nan, np.where(radius * b.m.arcs.sweep > 0, np.abs(radius), 0.0)
    )
    return {"inside": inside, "shortest": np.where(inside, margin(b, motion), 0.0), "tool": tool}


def margin(b: Columns, motion: np.ndarray) -> np.ndarray:
    """(K,) mm from the ends of motions within which they are not cut; inf where the radius is not
    stated."""
    radius = np.abs(b.m.radius[motion])
    away = np.where(np.isfinite(radius), MARGIN * radius, np.inf)
    return np.where(
        b.m.cutter[motion] == OFFSET, away, np.where(b.m.cutter[motion] == ENTRY, np.inf, 0.0)
    )


def may_cut(b: Columns, chosen: np.ndarray, owner: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(K,) bool: places t of straight strokes `chosen[owner]` at which they may be cut."""
    motion = b.motion[chosen]
    away, behind_ = margin(b, motion), behind(b, chosen)
    way = _way(b, chosen)
    free = b.m.cutter[motion[owner]] == FREE
    result: np.ndarray = free | (
        (t * way[owner] >= behind_[owner]) & ((1 - t) * way[owner] >= away[owner])
    )
    return result


def _way(b: Columns, chosen: np.ndarray) -> np.ndarray:
    """(K,) mm of strokes in the plane."""
    first, second = np.maximum(b.m.plane[:, b.motion[chosen]], 0)
    way: np.ndarray = np.hypot(b.travel[first, chosen], b.travel[second, chosen]) / TICKS_PER_MM
    return way


def edges(b: Columns, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) index into chosen and (K,) t of the places nearest to their ends at which strokes inside
    may be cut."""
    away, behind_, way = margin(b, b.motion[chosen]), behind(b, chosen), _way(b, chosen)
    which = np.flatnonzero((away > 0) & (way > away + behind_))
    return np.concatenate([which, which]), np.concatenate(
        [behind_[which] / way[which], 1 - away[which] / way[which]]
    )


def tell(b: Columns) -> None:
    """Notices: where the map is read, and what is left where the correction is held."""
    inside = ((b.m.cutter != FREE) & b.free).nonzero()[0]
    if not len(inside):
        return
    steep = b.machine.bounds.steepest
    unknown = inside[~np.isfinite(b.m.radius[inside])]
    if len(unknown):
        b.notices.append(
            Notice(
                "cutter",
                "inside G41 G42 the tool's radius is not stated: the map is read at the programmed"
                f" contour, wrong by {steep / UM:.2f} um per mm of radius at most, and blocks are"
                " not cut; give the control's tool table with --offsets",
                int(unknown[0]),
            )
        )
    known = inside[np.isfinite(b.m.radius[inside]) & (b.m.radius[inside] != 0)]
    if len(known):
        widest = int(known[np.argmax(np.abs(b.m.radius[known]))])
        radius = float(np.abs(b.m.radius[widest]))
        b.notices.append(
            Notice(
                "centre",
                f"inside G41 G42 the map is read at the tool's centre, {radius:g} mm beside each"
                " block; at corners, around which it turns, wrong by"
                f" {2 * radius * steep / UM:.2f} um at most",
                widest,
                radius,
            )
        )
    if b.machine.two_way.any():
        most = max(float(b.machine.widest_play.max()), b.machine.lateral)
        b.notices.append(
            Notice(
                "beside",
                "inside G41 G42 nothing is put in: where an axis turns back its reversal of up to"
                f" {most / UM:.1f} um is spread over the block",
                int(inside[0]),
            )
        )


def tell_held(b: Columns, limits: np.ndarray) -> None:
    """Say how much of a correction is not made because the blocks that would need it do not move in
    the plane."""
    m, motion = b.m, b.motion
    inside = np.flatnonzero(
        (m.cutter[motion] != FREE) & (m.plane[:, motion] >= 0).all(axis=0) & b.free[motion] & b.last
    )
    left = np.zeros(len(inside))
    for row in m.plane[:, motion[inside]]:
        off = np.abs(b.exact[row, inside] - b.end[row, inside] / TICKS_PER_MM)
        left = np.maximum(left, np.where(limits[row, inside] < FREELY, off, 0.0))
    over = left > b.c.tolerance
    if over.any():
        k = int(np.argmax(left))
        b.notices.append(
            Notice(
                "held",
                "inside G41 G42 the correction of an axis changes only along blocks that move in"
                f" the plane: up to {left[k] / UM:.2f} um are not made here",
                int(motion[inside[k]]),
            )
        )
