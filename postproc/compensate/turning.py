"""Where a two-way axis turns back inside a motion: at the quadrants of an arc, and where
corrections alone turn it.

An axis that rests on the nominal path follows the errors of the others, up and down along a long
cut. Where its wanted place turns back by more than the hysteresis its lost motion has to be taken
up, so the motion is divided there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from postproc.compensate import nodes
from postproc.compensate.arcs import points, turning_points
from postproc.compensate.columns import Columns
from postproc.compensate.inverse import command
from postproc.machine.chain import XYZ
from postproc.machine.polar import PolarMachine
from postproc.machine.tip import TipMachine
from postproc.motions import COUNTER, CUTS, FEED, FREE
from postproc.units import TICKS_PER_MM, in_mm

SAMPLES = (8, 64)  # of an arc, at least and at most
PORTION = 500  # arcs looked at at once: the samples of more leave the processor's cache
LOOKS = 17  # places on a motion of the tip at which its slides are looked at
STEEP = 10  # the map may change by a tenth of an arc's way in its plane
APART = 1e-9  # of a motion: closer places are one


def divided(b: Columns) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(S,) motion, t0 and t1 of the strokes of a batch, which has them whole; the very same columns
    where none is divided."""
    found = _of_slides(b) if isinstance(b.machine, TipMachine) else [_quadrants(b), *_induced(b)]
    if not any(len(owner) for owner, _ in found):
        return b.motion, b.t0, b.t1
    motion = np.concatenate([b.motion, *(owner for owner, _ in found)])
    t0 = np.concatenate([b.t0, *(t for _, t in found)])
    order = np.lexsort((t0, motion))
    motion, t0 = motion[order], t0[order]
    same = np.concatenate([[False], (motion[1:] == motion[:-1]) & (t0[1:] - t0[:-1] < APART)])
    motion, t0 = motion[~same], t0[~same]
    goes_on = np.concatenate([motion[1:] == motion[:-1], [False]])
    return motion, t0, np.where(goes_on, np.concatenate([t0[1:], [1.0]]), 1.0)


def within(
    motion: np.ndarray, t0: np.ndarray, t1: np.ndarray, span: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Those strokes of one motion, and parts of them, that lie within a span of t."""
    t0, t1 = np.maximum(t0, span[0]), np.minimum(t1, span[1])
    inside = t1 - t0 >= min(APART, (span[1] - span[0]) / 2)
    return motion[inside], t0[inside], t1[inside]


def _of_slides(b: Columns) -> list[tuple[np.ndarray, np.ndarray]]:
    """Per two-way slide (K,) motion and t of the places where it turns back by more than the
    hysteresis while the tip goes straight, on a face along an arc too: looked for at LOOKS places,
    and put where a parabola through three of them turns.

          _.-o-._            Of values before, here and behind at even steps, and with bend = 2 here
        .'   |   `o          - before - behind, its top lies (behind - before) / (2 bend) steps
       o     |    |          behind the middle one, and (behind - before)^2 / (8 bend) above it.
    before  here  behind     From below it is the same of the negative values."""
    assert isinstance(b.machine, TipMachine)
    m = b.m
    kinds = (m.code >= FEED) & (m.code <= COUNTER)
    if not isinstance(b.machine, PolarMachine):
        kinds = m.code == FEED
    chosen = (kinds & b.free & b.start_known & (m.cutter == FREE)).nonzero()[0]
    if not len(chosen):
        return []
    t = np.linspace(0.0, 1.0, LOOKS)
    places = b.nominal(np.repeat(chosen, LOOKS), np.tile(t, len(chosen)))
    if isinstance(b.machine, PolarMachine):  # slides that rest follow the errors of X
        owner = np.repeat(chosen, LOOKS)
        places = command(b.machine, places, np.zeros_like(places), owner)
    slides = b.machine.slides(places).reshape(len(places), len(chosen), LOOKS)
    found = []
    for row in np.flatnonzero(b.machine.two_way):
        for side in (slides[row], -slides[row]):
            k = np.argmax(side, axis=1)
            each, inner = np.arange(len(k)), np.clip(k, 1, LOOKS - 2)
            before, here, behind = (side[each, inner + d] for d in (-1, 0, 1))
            bend = np.maximum(2 * here - before - behind, 1e-12)
            at = t[inner] + np.clip((behind - before) / (2 * bend), -1, 1) / (LOOKS - 1)
            top = here + (behind - before) ** 2 / (8 * bend)
            turns = (
                (top - np.maximum(side[:, 0], side[:, -1]) > b.c.hysteresis) & (at > 0) & (at < 1)
            )
            found.append(_on_increments(b, chosen[turns], at[turns]))
    return found


def _quadrants(b: Columns) -> tuple[np.ndarray, np.ndarray]:
    """(K,) motion and t of the places where a two-way axis of an arc's plane turns back."""
    arcs, two_way = b.m.arcs, b.machine.two_way
    if not len(arcs):
        return np.zeros(0, np.int64), np.zeros(0)
    turning = (
        (two_way[arcs.first] | two_way[arcs.second])
        & (b.m.cutter[arcs.motion] == FREE)
        & b.free[arcs.motion]
    )
    if not turning.any():
        return np.zeros(0, np.int64), np.zeros(0)
    arc, t = turning_points(arcs, b.arc_start, b.arc_target)
    arc, t = arc[turning[arc]], t[turning[arc]]
    return arcs.motion[arc], t


def _bends(b: Columns, chosen: np.ndarray, least: float) -> np.ndarray:
    """(K,) bool: arcs, and straight motions whose correction is no straight line but for less than
    `least` mm, which is all that such a one can turn back by."""
    bends: np.ndarray = b.may_bend(chosen, least)
    at = bends.nonzero()[0]
    if len(at):
        begin, end = (in_mm(x.take(chosen.take(at), axis=1)) for x in (b.m.start, b.m.target))
        bends[at] = b.machine.bounds.bow(begin, end) > least
    return bends | (b.arc_of[chosen] >= 0) if len(b.m.arcs) else bends


def _induced(b: Columns) -> list[tuple[np.ndarray, np.ndarray]]:
    """Per axis (K,) motion and t of the places where its wanted place turns back by more than half
    the hysteresis: what it goes to and fro by inside a stroke is not seen."""
    m, rows = b.m, b.c.followed
    if not len(rows):
        return []
    way = in_mm(np.abs(m.target - m.start))
    length = np.sqrt(sum(way[row] * way[row] for row in b.c.slides))
    arcs = m.arcs.motion
    steep = np.zeros(len(arcs), bool)
    if len(arcs):
        # of one that goes far beside its plane the map can turn the axes of the plane too
        straight = length[arcs]
        length[arcs] = np.abs(m.arcs.sweep) * np.maximum(m.arcs.radius, m.arcs.radius_end)
        steep = b.machine.bounds.steepest * straight > length[arcs] / STEEP
        length[arcs[steep]] = np.maximum(length[arcs], straight)[steep]
    # mm that any deviation changes along the motion; one that turns is looked at whatever its
    # length
    most = b.machine.bounds.steepest * length
    for row in b.machine.turning:
        most = np.where(way[row] > 0, np.inf, most)
    slow = np.logical_or.reduce(way.take(rows, axis=0) < most, axis=0)
    slow[arcs] = True
    # what a resting axis is held still by is not seen either
    least = max(b.c.hysteresis / 2, b.c.hold)
    cutting = b.free & b.start_known & CUTS.take(m.code) & (m.cutter == FREE)
    chosen = (cutting & slow & (most > 2 * least)).nonzero()[0]
    chosen = chosen[_bends(b, chosen, least)]
    if not len(chosen):
        return []
    plane = np.zeros(m.start.shape, bool)  # those turn back at quadrants
    for axes in (m.arcs.first, m.arcs.second):
        plane[axes, m.arcs.motion] = ~steep
    sense, found = np.sign(m.target - m.start), []
    for part, places in _looked_at(b, chosen):
        owner, t, place = places(b, part, most, least)
        wanted = [row for row in rows.tolist() if not plane[row, part].all()]
        if not wanted:
            continue
        only = XYZ.index(b.machine.letters[wanted[0]]) if len(wanted) == 1 else None
        deviation = b.machine.deviation(place, sense.take(owner, axis=1), only)
        for row in wanted:
            course = np.where(plane[row, owner], 0.0, place[row] - deviation[row])
            found.append(_on_increments(b, *_turns(owner, t, course, least)))
    return found


Looked = Callable[
    ["Columns", np.ndarray, np.ndarray, float], tuple[np.ndarray, np.ndarray, np.ndarray]
]


def _looked_at(b: Columns, chosen: np.ndarray) -> Iterator[tuple[np.ndarray, Looked]]:
    """The straight motions among those chosen, and the arcs in portions, each with what gives
    their places."""
    straight = b.m.code[chosen] == FEED
    if straight.any():
        yield chosen[straight], _on_straight
    arcs = chosen[~straight]
    for first in range(0, len(arcs), PORTION):
        yield arcs[first : first + PORTION], _on_arcs


def _on_increments(b: Columns, motion: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same places, moved to where the rotary axis that turns most stands on a whole increment
    of its word."""
    rows = np.array(b.machine.turning, np.int64)
    if not len(rows) or not len(motion):
        return motion, t
    way = (b.m.target - b.m.start)[rows].take(motion, axis=1)
    most, k = np.argmax(np.abs(way), axis=0), np.arange(len(motion))
    turn, step = way[most, k], b.m.grid[rows[most], motion]
    turn = np.where(turn == 0, 1, turn)
    t = np.where(way[most, k] != 0, np.rint(turn * t / step) * step / turn, t)
    inside = (t > 0) & (t < 1)
    return motion[inside], t[inside]


def _on_straight(
    b: Columns, chosen: np.ndarray, most: np.ndarray, least: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(K,) motion, (K,) t and (A, K) mm of places along straight motions, in order, between which
    no deviation turns unseen."""
    m = b.m
    start = m.start.take(chosen, axis=1) / TICKS_PER_MM
    target = m.target.take(chosen, axis=1) / TICKS_PER_MM
    of, t, _ = nodes.candidates(b.machine, start, target, b.c.slack)
    zero = np.zeros(len(chosen))
    owner, t = np.concatenate([chosen[of], chosen, chosen]), np.concatenate([t, zero, zero + 1])
    order = np.lexsort((t, owner))
    owner, t = owner[order], t[order]
    begin = m.start.take(owner, axis=1) / TICKS_PER_MM
    end = m.target.take(owner, axis=1) / TICKS_PER_MM
    return owner, t, begin + (end - begin) * t


def _on_arcs(
    b: Columns, chosen: np.ndarray, most: np.ndarray, least: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same along arcs: equal parts."""
    count = np.clip(np.ceil(2 * most[chosen] / least), *SAMPLES).astype(np.int64)
    of, index = nodes.spread(count + 1)
    owner, t = chosen[of], index / count[of]
    return owner, t, points(b.m.arcs, b.arc_start, b.arc_target, b.arc_of[owner], t)


def _turns(
    owner: np.ndarray, t: np.ndarray, wanted: np.ndarray, least: float
) -> tuple[np.ndarray, np.ndarray]:
    """(K,) motion and t where `wanted` (K,) mm, along each motion, turns back by more than
    `least`."""
    ticks = np.rint(wanted * TICKS_PER_MM).astype(np.int64)
    first = np.concatenate([[True], owner[1:] != owner[:-1]])
    which = np.cumsum(first) - 1
    base = ticks - ticks[first][which]
    lift = which * (2 * int(np.abs(base).max(initial=0)) + 1)  # so that motions do not mix
    fall = np.maximum.accumulate(lift + base) - lift - base
    rise = np.maximum.accumulate(lift - base) - lift + base
    begin = first.nonzero()[0]
    both = np.minimum(np.maximum.reduceat(fall, begin), np.maximum.reduceat(rise, begin))
    stop = np.append(begin[1:], len(owner))
    bent = (both > least / 2 * TICKS_PER_MM).nonzero()[0]
    # between two places where it turns at all it goes on
    step = np.sign(base[1:] - base[:-1])
    turns = np.ones(len(base), bool)
    turns[1:-1] = step[1:] * step[:-1] <= 0
    turns[begin] = turns[stop - 1] = True
    at = turns.nonzero()[0]
    first, behind = at.searchsorted(begin[bent]).tolist(), at.searchsorted(stop[bent]).tolist()
    value = base[at]
    pivots = [
        k
        for one, two in zip(first, behind, strict=True)
        for k in _pivots(value[one:two].tolist(), one, least * TICKS_PER_MM)
    ]
    return owner[at[pivots]], t[at[pivots]]


def _pivots(value: list[int], begin: int, least: float) -> list[int]:
    """Indices, from `begin` on, of the highest and lowest places behind which `value` turns back by
    more than `least`; before the first one it has gone half as far."""
    low = high = sense = 0
    pivots: list[int] = []
    for k, here in enumerate(value):
        if here > value[high]:
            high = k
        if here < value[low]:
            low = k
        if sense >= 0 and value[high] - here > least:
            pivots += [high] if sense or value[high] - value[0] > least / 2 else []
            sense, low = -1, k
        elif sense <= 0 and here - value[low] > least:
            pivots += [low] if sense or value[0] - value[low] > least / 2 else []
            sense, high = 1, k
    return [begin + k for k in pivots]
