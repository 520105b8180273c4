"""Where the slides of a machine with lost motion stand while a program runs: the judge of what
compensation makes of it.

The nut of a slide moves with play B about the commanded position c: the slide stays where it is as
long as it lies within c - B/2 .. c + B/2, and is taken along at the ends (the play operator). Every
commanded motion counts, take-ups and corrections included, in the order of execution. The share (c
- slide) / (B/2), from -1 to +1, says how much of a table's difference between its directions acts.
The side is the direction of the last commanded motion; a slide that goes back by no more than the
hysteresis keeps it. Where an axis has no play of its own the share is the side. Where forward lies
beyond reverse the control takes up more than there is, with the first increment of the command, so
there the last command says the side, however short. Follows the written program, leg by leg, and
shares no code with what decided the take-ups.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from postproc.compensate.arcs import points, turning_points
from postproc.machine import poses
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.motions import Motions
from postproc.units import TICKS_PER_MM

LEAST = 1e-7  # mm: a smaller play is none


@dataclass(frozen=True)
class Legs:
    """L stretches of motions along which no axis turns back: motion (L,), until t (L,) of it;
    begin, end (A, L) mm, nan where it is not known. anew (A, L): something else (G28) has taken the
    slide to where the leg begins, and on which side it bears there is not known; curved (L,): of an
    arc."""

    motion: np.ndarray
    until: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    anew: np.ndarray
    curved: np.ndarray


@dataclass(frozen=True)
class Led:
    """One batch as the slides lived it. Before each leg, (A, L): side, the farthest command `far`
    mm in that direction, slide mm, where it stood, and `last`, the direction of the last command,
    however short."""

    slides: Slides
    legs: Legs
    side: np.ndarray
    far: np.ndarray
    slide: np.ndarray
    last: np.ndarray

    def leg(self, motion: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(K,) the leg that t of a motion lies in; an end belongs to the leg that it ends."""
        # motion + t is one ascending number; 1e-9, or t = 0 would be the end of the motion before
        leg = np.searchsorted(self.legs.motion + self.legs.until, motion + np.maximum(t, 1e-9))
        return np.minimum(leg, len(self.legs.motion) - 1)

    def way(self, leg: np.ndarray) -> np.ndarray:
        """(A, K) direction in which each axis moves along legs: -1, 0, +1."""
        way = np.sign(self.legs.end - self.legs.begin)[:, leg]
        return np.where(np.isnan(way), 0.0, way)

    def at(
        self,
        motion: np.ndarray,
        t: np.ndarray,
        command: np.ndarray,
        sense: np.ndarray,
        rapid: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """(A, K) side and (A, K) share at commands (A, K) mm, t of motions (K,). sense (A, K): the
        direction of the nominal motion there, which says the side of an axis whose command goes
        that way where no take-up leads it far enough to tell; of one whose lost motion builds up
        over some travel the share says it; rapid (K,): there an axis that rests keeps the side that
        it had, for nothing is cut."""
        leg, half, beyond = self.leg(motion, t), self.half(command), self.slides.beyond(command)
        own = self.way(leg)
        way = np.where(own != 0, own, self.last[:, leg])
        # where an arc begins and ends it turns a little beside the nominal one
        curved = self.legs.curved[leg]
        beyond &= ~rapid & ~(curved & (sense[self.slides.rows] != 0))
        agrees = (own * sense > 0) | ((curved | rapid) & (sense != 0))
        side, share = np.zeros(command.shape), np.zeros(command.shape)
        for k, row in enumerate(self.slides.rows):
            before, off = self.side[row, leg], command[row] - self.far[row, leg]
            # behind the farthest place of its side by more than the hysteresis: it has turned
            turned = np.abs(off) > self.slides.band[row]
            turned &= (off * before < 0) | (before == 0)
            below_hysteresis = 2 * half[k] <= self.slides.hysteresis
            rests = np.where(turned & ~(rapid & below_hysteresis), np.sign(off), before)
            side[row] = np.where(below_hysteresis & agrees[row], sense[row], rests)
            side[row] = np.where(beyond[k], way[row], side[row])
            low, high = command[row] - half[k], command[row] + half[k]
            slide = np.minimum(np.maximum(self.slide[row, leg], low), high)
            # +1: the nut bears forward, the slide lags by half the play behind c
            part = (command[row] - slide) / np.maximum(half[k], LEAST)
            share[row] = np.where((half[k] > LEAST) & np.isfinite(slide), part, side[row])
            if self.slides.more[k]:  # it is not there at the turn, nor taken up there
                side[row] = share[row]
        return side, share

    def half(self, position: np.ndarray) -> np.ndarray:
        return self.slides.half(position)

    def back(self, owner: np.ndarray, count: int) -> np.ndarray:
        """(A, N) bool: axes that in a motion stand or go behind the farthest place of their side,
        or move and have none: on which side they bear may change there. owner (M,): of the N
        motions (`count`) the one that each of the M followed ones belongs to."""
        legs, of = self.legs, owner[self.legs.motion]
        nearest = np.minimum((legs.begin - self.far) * self.side, (legs.end - self.far) * self.side)
        behind = (nearest < -LEAST) | (self.side == 0) & (legs.begin != legs.end)
        return np.array([np.bincount(of, row, count) > 0 for row in behind])


class Slides:
    """The slides of one machine running one program. Keeps, between batches, where they stand.
    hysteresis: mm; `band` (A,): the same, and one increment, by which words are rounded."""

    def __init__(self, machine: Machine, hysteresis: float):
        self.machine, self.rows = machine, np.flatnonzero(machine.two_way)
        self.hysteresis = hysteresis
        self.more = [machine.pretravel.get(machine.letters[row], 0.0) for row in self.rows]
        self.band = [
            hysteresis + a.least_increment if x in XYZ else 0.0 for x, a in machine.axes.items()
        ]
        self.one = [_Slide(band) for band in self.band]

    def half(self, position: np.ndarray) -> np.ndarray:
        """(R, N) mm: half the play of the two-way axes, and of the way over which it builds up."""
        # below zero the control takes up more than there is: no play, see `beyond`
        play = np.maximum(self.machine.lost_motion(np.nan_to_num(position), self.rows), 0.0)
        return (play + np.array(self.more)[:, None]) / 2

    def beyond(self, position: np.ndarray) -> np.ndarray:
        """(R, N) bool: two-way axes of which forward lies beyond reverse there by more than the
        hysteresis."""
        play = self.machine.lost_motion(np.nan_to_num(position), self.rows)
        beyond: np.ndarray = play < -self.hysteresis
        return beyond

    def has_play(self, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
        """(P,) bool: pieces, from begin to end (A, P) ticks, that move no two-way axis without play
        of its own: where forward lies beyond reverse nothing says on which side a take-up leaves it
        before the motion goes on."""
        moved = (begin != end)[self.rows]
        tells = 2 * self.half(end / TICKS_PER_MM) > self.hysteresis
        return (~moved | tells).all(axis=0)

    def run(self, motions: Motions) -> Led:
        """Follow a batch."""
        legs = _of_slides(self.machine, motions, _legs(motions))
        lived = np.full((4, *legs.end.shape), np.nan)
        half = self.half(legs.end)
        for k, row in enumerate(self.rows):
            columns = (
                x.tolist() for x in (legs.begin[row], legs.end[row], half[k], legs.anew[row])
            )
            if states := [self.one[row].move(*leg) for leg in zip(*columns, strict=True)]:
                lived[:, row] = np.array(states).T
        return Led(self, legs, *lived)


class _Slide:
    """One slide: where it stands, mm, its side, and how far its command has gone in that
    direction."""

    def __init__(self, band: float):
        self.band = band
        self.place = self.far = float("nan")
        self.side = self.last = 0.0

    def move(
        self, begin: float, end: float, half: float, anew: bool
    ) -> tuple[float, float, float, float]:
        """Command from begin to end, mm, with half the play; anew: taken to begin by something
        else. Side, far, place and direction of the last command before it."""
        if begin != begin or end != end:  # from or to an unknown place
            self.place, self.far, self.side, self.last = end, end, 0.0, 0.0
            return 0.0, end, end, 0.0
        if anew or self.place != self.place:
            self.place, self.far, self.side, self.last = begin, begin, 0.0, 0.0
        # before the leg: `at` works out what happens within it from here
        before = self.side, self.far, self.place, self.last
        if begin != end:
            self.last = 1.0 if end > begin else -1.0
        #            end - half                end + half
        #     ---------[===========c============]----------      the play operator: inside a place
        #                  o->                                  stays, outside it is taken along
        # Within a leg the command goes one way, so its end alone decides, with the play that is
        # there.
        self.place = min(max(self.place, end - half), end + half)
        ahead = (end - self.far) * self.side
        if ahead < -self.band or (self.side == 0.0 and abs(end - self.far) > self.band):
            self.side = 1.0 if end > self.far else -1.0
            self.far = end
        elif ahead > 0:
            self.far = end
        return before


def _of_slides(machine: Machine, m: Motions, legs: Legs) -> Legs:
    """The same legs where X Y Z are places of the tool tip: between the slide positions that hold
    it."""
    if not m.space.any():
        return legs
    begin, end = legs.begin.copy(), legs.end.copy()
    both = np.concatenate([m.length, m.space[None]])[:, legs.motion]
    for key in np.unique(both[:, both[-1] > 0], axis=1).T:
        of = np.flatnonzero((both == key[:, None]).all(axis=0))
        length, space = key[:-1] / TICKS_PER_MM, m.spaces[int(key[-1])]
        for places in (begin, end):
            known = of[np.isfinite(places[:, of]).all(axis=0)]
            slides = poses.out_of(machine, space, length, places[:, known])
            # a slide that stays has not moved by the last digit of a sum
            places[:, known] = np.round(slides, 9)
    return replace(legs, begin=begin, end=end)


def _legs(m: Motions) -> Legs:
    """Motions; arcs cut where an axis of their plane turns back; holes down and up."""
    start = np.where(m.start_known, m.start / TICKS_PER_MM, np.nan)
    target = np.where(m.target_known, m.target / TICKS_PER_MM, np.nan)
    motions, untils, stops = [np.arange(len(m))], [np.ones(len(m))], [target]
    arcs = m.arcs
    if len(arcs):
        of = arcs.motion
        begins, ends = m.start[:, of] / TICKS_PER_MM, m.target[:, of] / TICKS_PER_MM
        arc, t = turning_points(arcs, begins, ends)
        motions.append(of[arc])
        untils.append(t)
        stops.append(points(arcs, begins, ends, arc, t))
    holes = m.holes
    if len(holes):
        # t of a hole: a third each for the way to R, down, and back up
        for share, place in ((1 / 3, holes.level), (2 / 3, holes.bottom)):
            motions.append(holes.motion)
            untils.append(np.full(len(holes), share))
            there = target[:, holes.motion].copy()
            there[holes.axis, np.arange(len(holes))] = place / TICKS_PER_MM
            stops.append(there)
    motion, until = np.concatenate(motions), np.concatenate(untils)
    order = np.lexsort((until, motion))
    motion, until, ends = motion[order], until[order], np.concatenate(stops, axis=1)[:, order]
    begin = np.concatenate([np.full((len(ends), 1), np.nan), ends[:, :-1]], axis=1)
    first = np.concatenate([[True], motion[1:] != motion[:-1]])
    # a leg begins where the one before ended, the first of a motion where that begins
    begin[:, first] = start[:, motion[first]]
    curved = np.isin(motion, arcs.motion)
    return Legs(motion, until, begin, ends, m.sent[:, motion] & first, curved)
