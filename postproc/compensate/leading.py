"""Where axes are led beyond the place at which a stroke begins, and back to it from there.

An axis that is to bear at the begin of a stroke otherwise than the stroke leads it, since another
one turns there and its straightness moves this one back, is led over its play first, and back:

    command    begin - play    begin                the slide goes with it to `begin - play`, and
       <------------*============>                  stands there while the command goes back

Where forward lies beyond reverse the direction of the last command says the side, and a take-up has
it contrary to the side: there an axis is led beyond and back that hardly moves along the stroke.
One that moves says its side by itself; what it was moved back by is the way along which it waits.
"""

from __future__ import annotations

import numpy as np

from postproc.compensate.approach import hold_last, last_way
from postproc.compensate.columns import Columns
from postproc.compensate.increments import increments, rounded
from postproc.compensate.inverse import command
from postproc.errors import Notice
from postproc.flags import any_of
from postproc.units import TICKS_PER_MM, UM, in_mm

NEAR = 1e-3  # of a stroke, along which its direction is looked at


def direction(b: Columns, stroke: np.ndarray) -> np.ndarray:
    """(A, K) mm along each axis for a mm of the way of the slides, where strokes begin."""
    t0 = b.t0[stroke]
    near = b.nominal(b.motion[stroke], t0 + (b.t1[stroke] - t0) * NEAR)
    way = near - b.begin_nominal.take(stroke, axis=1)
    length = np.sqrt((way[b.c.slides] ** 2).sum(axis=0))
    direction: np.ndarray = way / np.where(length > 0, length, 1.0)
    return direction


def lead_beyond(b: Columns) -> None:
    """`beyond` (A, S) ticks: where axes are led before a stroke is begun, `begin` where not, and
    `begin` of those that are not moved back to it; `way` (A,): of the last command, for the next
    batch."""
    rows = b.c.followed
    b.beyond, b.way = b.begin, b.carry.way.copy()
    if not len(rows):
        return
    before, wanted, end = (x.take(rows, axis=0) for x in (b.before, b.begin, b.end))
    sides, twice = _sides(b), b.twice.take(rows, axis=0) & b.cutting & b.known_before
    if not (np.count_nonzero(sides) or np.count_nonzero(twice)):
        b.way[rows] = last_way(wanted - before, _along(b, wanted, end), b.way[rows])
        return
    alone = twice & (b.against.take(rows, axis=0) == 0)
    begin, b.beyond = wanted, b.begin.copy()
    while True:  # where one is not moved back, the command says another side to the next
        first, then = np.sign(begin - before), _along(b, begin, end)
        course = np.stack((first, sides, then), 2).reshape(len(rows), -1)
        asks = alone | (sides != 0) & (hold_last(course, course != 0, b.way[rows])[:, ::3] != sides)
        at, out = (asks | twice).any(axis=0).nonzero()[0], asks.copy()
        out[:, at], aside = _led(b, at, asks[:, at], twice[:, at])
        waits = twice & ~out & ~b.turned.take(rows, axis=0)
        settled = np.where(waits, before, wanted)
        if (settled == begin).all():
            break
        begin = settled
    b.begin[rows] = begin
    b.beyond[rows] = begin
    b.beyond[:, at] = np.where(out[:, at].any(axis=0), aside, b.beyond[:, at])
    back = np.where(out, b.weight_begin.take(rows, axis=0), 0).astype(np.int64)
    course = np.stack((first, back, then), 2).reshape(len(rows), -1)
    b.way[rows] = hold_last(course, course != 0, b.way[rows])[:, -1]


def tell(b: Columns) -> None:
    """Notice: how far a slide goes beyond where it turns, where forward lies beyond reverse.
    Dead travel is taken up without the slide, this is not."""
    rows = b.c.followed[b.c.overshoots[b.c.followed]]
    if not (len(rows) and any_of(b.turning)):
        return
    side = b.weight_begin.take(rows, axis=0)
    before, *on_the_way = (x.take(rows, axis=0) for x in (b.before, b.begin, b.beyond))
    past = np.maximum(*((before - place) * side for place in on_the_way)) * b.turning
    row, stroke = np.unravel_index(np.argmax(past), past.shape)
    most = float(past[row, stroke]) / TICKS_PER_MM
    if most > 2 * b.c.hysteresis:
        letter = b.machine.letters[rows[row]]
        b.notices.append(
            Notice(
                "beyond",
                f"{letter} goes up to {most / UM:.1f} um beyond its place where it turns, since its"
                " forward lies beyond its reverse: what is cut there bears a mark (--reversal off"
                " spreads the reversal over the block instead)",
                int(b.motion[stroke]),
                size=most,
            )
        )


def waiting(b: Columns, stroke: np.ndarray) -> np.ndarray:
    """(A, K) share of strokes along which an axis waits that begins ahead of its place, since it is
    not moved back; 0: it does not."""
    share = np.zeros((len(b.travel), len(stroke)))
    rows = b.c.followed
    if not (len(rows) and any_of(b.turning[stroke])):
        return share
    begin, wanted, travel, side = (
        x.take(stroke, axis=1).take(rows, axis=0)
        for x in (b.begin, b.wanted, b.travel, b.weight_begin)
    )
    ahead = np.where(b.turning[stroke], (begin - wanted) * side, 0.0)
    waits = (ahead > b.c.chord * TICKS_PER_MM) & (np.sign(travel) == side)
    share[rows] = np.where(waits, ahead / np.maximum(np.abs(travel), 1), 0.0)
    return share


def _along(b: Columns, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(R, S) sign of the last command along strokes from begin to end (R, S): an arc turns where
    its circle does, also where its ends say nothing of it."""
    then: np.ndarray = np.sign(end - begin)
    if len(b.m.arcs):
        travel = np.sign(b.travel.take(b.c.followed, axis=0))
        then = np.where((b.arc_of[b.motion] >= 0) & (travel != 0), travel, then)
    return then


def _sides(b: Columns) -> np.ndarray:
    """(R, S) the side of the followed axes that the last command before a stroke must have, 0:
    any."""
    rows = b.c.followed
    sides = np.zeros((len(rows), len(b.motion)), np.int64)
    if not any_of(b.c.overshoots[rows]):
        return sides
    hardly = np.abs((b.end - b.begin).take(rows, axis=0)) <= b.c.band.take(rows)[:, None]
    hardly |= b.travel.take(rows, axis=0) == 0
    # one that would wait all along, since its end does not lie as far on as it stands
    ahead = (b.end - b.before).take(rows, axis=0) * b.weight_begin.take(rows, axis=0)
    hardly |= (b.twice & ~b.turned).take(rows, axis=0) & (ahead < 0)
    hardly &= b.cutting & b.known_before
    at = hardly.any(axis=0).nonzero()[0]
    if len(at):
        play = b.machine.lost_motion(in_mm(b.begin.take(at, axis=1)), rows)
        beyond = hardly.take(at, axis=1) & (play < -b.c.chord)
        sides[:, at] = np.where(beyond, b.weight_begin[rows[:, None], at], 0)
    return sides


def _led(
    b: Columns, at: np.ndarray, asks: np.ndarray, twice: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(R, K) which axes are led before strokes `at` (K,), and (A, K) ticks where all axes go
    meanwhile. asks (R, K): those that are led wherever their travel allows; twice (R, K): those
    that are only where they would be farther off without than all are while it bears on the other
    side."""
    rows = b.c.followed
    begin, against = b.begin.take(at, axis=1), b.against.take(at, axis=1)
    led = begin.copy()
    over = _over(b, at, begin, asks)
    led[rows] -= (b.weight_begin.take(at, axis=1)[rows] * over).astype(np.int64)
    low, high = (x[b.c.at.searchsorted(rows)] for x in b.c.travel)
    may = (in_mm(led[rows]) >= low) & (in_mm(led[rows]) <= high)
    felt = np.abs(against[rows]) > b.c.chord * TICKS_PER_MM
    asks, every = asks & may, (asks | twice & felt) & may
    whole, most = _aside(b, at, every, led)
    if not any_of(every != asks):
        return every, whole
    part, least = _aside(b, at, asks, led)
    off, way = np.zeros(begin.shape), direction(b, at)
    off[rows] = in_mm(np.where(every & ~asks, against[rows], 0))
    off -= way * (way * off).sum(axis=0)
    left = np.sqrt((off**2).sum(axis=0))
    spared = np.maximum(least, left) <= most + b.c.chord
    return np.where(spared, asks, every), np.where(spared, part, whole)


def _aside(
    b: Columns, at: np.ndarray, out: np.ndarray, led: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(A, K) ticks where all axes go while some, out (R, K), are led to `led` (A, K): as far
    towards the nominal place, reached on those sides, as lies on their way; and (K,) mm, how far
    beside it they are there."""
    rows = b.c.followed
    before, begin, side = (x.take(at, axis=1) for x in (b.before, b.begin, b.weight_begin))
    side[rows] = np.where(out, -side[rows], side[rows])
    exact = command(b.machine, b.begin_nominal.take(at, axis=1), side, b.motion[at])
    place = rounded(exact, *increments(b, at))
    aside = np.clip(place, np.minimum(before, begin), np.maximum(before, begin))
    aside = np.where(b.correctable.take(at, axis=1), aside, begin)
    aside[b.fixed] = begin[b.fixed]
    aside[rows] = np.where(out, led[rows], aside[rows])
    off = np.sqrt((in_mm(aside - place)[b.rows] ** 2).sum(axis=0))
    return aside, np.where(out.any(axis=0), off, 0.0)


def _over(b: Columns, at: np.ndarray, begin: np.ndarray, asks: np.ndarray) -> np.ndarray:
    """(R, K) ticks by which axes are led beyond their places `begin` (A, K): their play. One with
    too little to tell a side by is led by twice the hysteresis and an increment more where it asks
    (R, K) for it; else the way to its place is all."""
    rows = b.c.followed
    step = b.of(b.m.grid).take(at, axis=1).take(rows, axis=0)
    steps = np.rint(b.machine.lost_motion(in_mm(begin), rows) * TICKS_PER_MM / step)
    least = np.ceil(2 * b.c.hysteresis * TICKS_PER_MM / step) + 1
    over = np.where(steps < least, np.where(asks, least, 0), steps)
    ticks: np.ndarray = over.astype(np.int64) * step
    return ticks
