"""When each block is executed: the program's own clock, from its feeds, its rapids and its dwells.

Whole microseconds, so that any cut of the input gives the same times. What a control adds is not
known here: acceleration, tool changes, stops that a person ends, overrides. Pace stands for it: by
which factor the machine takes longer than the words say.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from postproc.motions import FOREIGN, HOLE, RAPID, THREAD, Arcs, Motions
from postproc.nc import pace
from postproc.nc.dialects import Dialect
from postproc.nc.lexer import Words
from postproc.units import TICKS_PER_MM

VELOCITY = 10_000.0 / 60.0  # mm/s and degrees/s of a rapid, where the machine states none
MICRO = 1e6
STOPS = (0, 1, 6, 60)  # M codes that wait for a person, or for a tool changer


@dataclass(frozen=True)
class ClockState:
    """What one batch hands the next. now: microseconds since the program began; spoken: of the
    spindle; without: motions that had no feed and took no time; stops: how often a person, or a
    tool changer, was waited for; radius: mm, where X stands;
    unlimited: blocks under G96 of which no limit is told; untimed: dwells whose time is not
    known."""

    now: int = 0
    spoken: pace.Spoken = field(default_factory=pace.Spoken)
    without: int = 0
    stops: int = 0
    radius: float = 0.0
    unlimited: int = 0
    untimed: int = 0


@dataclass(frozen=True)
class Rates:
    """How a machine and its control count time. velocity (A,): mm/s and degrees/s of each axis at
    rapid; slides: rows of the linear axes, along which a feed counts; dialect: of the program."""

    velocity: np.ndarray
    slides: tuple[int, ...]
    dialect: Dialect


@dataclass(frozen=True)
class Dwells:
    """The R dwells of a batch. before (R,): number of the motion before which it dwells, N behind
    the last; took (R,): microseconds; rpm (R,): of its own block."""

    before: np.ndarray
    took: np.ndarray
    rpm: np.ndarray


@dataclass(frozen=True)
class Times:
    """Of each motion (N,): begin and end, microseconds since the program began; rpm, the spindle's
    turns per minute; dwells: between them."""

    begin: np.ndarray
    end: np.ndarray
    rpm: np.ndarray
    dwells: Dwells

    def steps(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(M,) microseconds, (M,) turns per minute and (M,) bool, whether it is a motion, of all
        that takes time, in order: motions, and dwells between them."""
        at = self.dwells.before
        # `before` counts motions, so that several dwells before one stay in their order
        took = np.insert(self.end - self.begin, at, self.dwells.took)
        rpm = np.insert(self.rpm, at, self.dwells.rpm)
        return took, rpm, np.insert(np.ones(len(self.begin), bool), at, False)


def run(
    words: Words, motions: Motions, rates: Rates, before: ClockState
) -> tuple[Times, ClockState]:
    """The times of a batch."""
    spindle, spoken = pace.spindle(words, rates.dialect, before.spoken)
    n = len(motions)
    rpm = _turns(motions, spindle) if n else np.zeros(0)
    took, without = _durations(motions, spindle, rpm, rates)
    #    now    dwell  motion 0   motion 1  dwell   motion 2
    #     |------|---------|---------|------|---------|   an end: all motions and dwells up to it
    micros = np.rint(took * MICRO).astype(np.int64)
    dwells, untimed = _dwells(words, motions, spindle, rates, before.radius)
    waits = np.bincount(dwells.before, weights=dwells.took, minlength=n + 1).astype(np.int64)
    end = before.now + np.cumsum(micros + waits[:-1])
    now = (int(end[-1]) if n else before.now) + int(waits[-1])
    after = ClockState(
        now,
        spoken,
        before.without + without,
        before.stops + _stops(words, rates),
        float(_radius(motions)[-1]) if n else before.radius,
        before.unlimited + int((spindle.on & spindle.surface & np.isinf(spindle.cap)).sum()),
        before.untimed + untimed,
    )
    return Times(end - micros, end, rpm, dwells), after


def _dwells(
    words: Words, motions: Motions, spindle: pace.Spindle, rates: Rates, radius: float
) -> tuple[Dwells, int]:
    """Every dwell, behind the motions of its own block, and of how many the time is not known:
    these dwell 0. radius: mm, where X stands before the batch."""
    live = pace.live(words, rates.dialect)
    found, untimed = [], 0
    for block in pace.dwells(words):
        if block <= live:
            seconds = pace.seconds(words, block, rates.dialect)
            if 0 < seconds <= pace.LONGEST:
                found.append((block, round(seconds * MICRO)))
            untimed += not 0 <= seconds <= pace.LONGEST
    blocks = np.array([block for block, _ in found], np.int64)
    before = np.searchsorted(motions.block, blocks, "right")
    stands = np.concatenate([[radius], _radius(motions)])[before]
    took = np.array([micros for _, micros in found], np.int64)
    return Dwells(before, took, spindle.turns(blocks, stands)), untimed


def _stops(words: Words, rates: Rates) -> int:
    """How many blocks wait for a person or a tool changer."""
    stop = (words.letter == ord("M")) & np.isin(words.mantissa, STOPS) & (words.decimals == 0)
    blocks = np.unique(words.block[stop])
    return int((blocks <= pace.live(words, rates.dialect)).sum())


def _radius(motions: Motions) -> np.ndarray:
    """(N,) mm, where X stands behind each motion, or the first axis that there is."""
    return np.abs(motions.target[0]) / TICKS_PER_MM


def _turns(motions: Motions, spindle: pace.Spindle) -> np.ndarray:
    """(N,) turns per minute; under G96 by the radius in the middle of the motion."""
    # X, or the first axis that there is
    radius = np.abs(motions.start[0] + motions.target[0]) / (2 * TICKS_PER_MM)
    return spindle.turns(motions.block, radius)


def _durations(
    motions: Motions, spindle: pace.Spindle, rpm: np.ndarray, rates: Rates
) -> tuple[np.ndarray, int]:
    """(N,) s, and how many motions have no feed that says how long they take."""
    # A rapid takes as long as its slowest axis. F counts along the way of the slides, as if rotary
    # axes stood still, and where these move alone in degrees (NIST RS274/NGC 2.1.2.5).
    known = motions.start_known & motions.target_known
    way = np.where(known, np.abs(motions.target - motions.start), 0) / TICKS_PER_MM
    rapid = (way / rates.velocity[:, None]).max(axis=0, initial=0.0)
    length = np.sqrt((way[list(rates.slides)] ** 2).sum(axis=0))
    length = np.where(length > 0, length, way.max(axis=0, initial=0.0))
    arcs = motions.arcs
    turned = np.abs(arcs.sweep) * arcs.radius
    # a helix: what goes along the axis of the arc, out of the whole chord less that in the plane
    across = np.sqrt(np.maximum(length[arcs.motion] ** 2 - _plane(way, arcs) ** 2, 0.0))
    length[arcs.motion] = np.hypot(turned, across)
    feed = motions.feed * pace.unit_of_feed(motions) / 60.0
    if len(motions):
        # G95: mm per turn, times turns per minute
        by_turn = spindle.mode[motions.block] == pace.PER_TURN
        feed = np.where(by_turn, feed * rpm, feed)
    feed = np.where(
        motions.code == THREAD, np.where(motions.lead > 0, motions.lead, np.nan) * rpm / 60.0, feed
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        # G93: F is blocks per minute
        took = np.where(motions.inverse, 60.0 / motions.feed, length / feed)
    # the block's own way is the rapid to the hole; then down and up
    took[motions.holes.motion] = rapid[motions.holes.motion] + _down(motions, feed, rates.velocity)
    at_feed = bool(rates.dialect.carried) & np.isfinite(took)  # printers run G0 with F
    took = np.where((motions.code == RAPID) & ~at_feed, rapid, took)
    moves = (way.max(axis=0, initial=0.0) > 0) | (motions.code == HOLE)
    moves[arcs.motion] = True  # a whole circle ends where it begins
    # a motion without F takes no time by this clock, and is counted: FOREIGN ones no clock knows
    bad = ~np.isfinite(took) & moves & (motions.code != FOREIGN)
    return np.where(np.isfinite(took) & (motions.code != FOREIGN), took, 0.0), int(bad.sum())


def _plane(way: np.ndarray, arcs: Arcs) -> np.ndarray:
    """(n,) mm of an arc's chord in its plane."""
    k = arcs.motion
    return np.hypot(way[arcs.first, k], way[arcs.second, k])


def _down(motions: Motions, feed: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """(n,) s of each hole: once down at its feed and back up as a rapid; pecks are not known
    here."""
    holes = motions.holes
    deep = np.abs(holes.level - holes.bottom) / TICKS_PER_MM
    with np.errstate(divide="ignore", invalid="ignore"):
        down = deep / feed[holes.motion]
    return down + deep / velocity[holes.axis]
