"""When each block is executed: the program's own clock, from its feeds, its rapids and its dwells.

Whole microseconds, so that any cut of the input gives the same times. What a control adds is not known here: acceleration, tool
changes, stops that a person ends, overrides. Pace stands for it: by which factor the machine takes longer than the words say.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from postproc.motions import FOREIGN, HOLE, RAPID, THREAD, Motions
from postproc.nc import pace
from postproc.nc.dialects import Dialect
from postproc.nc.lexer import Words
from postproc.units import TICKS_PER_MM

VELOCITY = 10_000.0 / 60.0  # mm/s and degrees/s of a rapid, where the machine states none
SMALLEST = (
    1.0  # mm: radius below which G96 does not turn a spindle any faster (its limit is not read)
)
MICRO = 1e6


@dataclass(frozen=True)
class Ticking:
    """What one batch hands the next. now: microseconds since the program began; spoken: of the spindle; without: motions that had
    no feed and took no time."""

    now: int = 0
    spoken: pace.Spoken = field(default_factory=pace.Spoken)
    without: int = 0


@dataclass(frozen=True)
class Rates:
    """How a machine and its control count time. velocity (A,): mm/s and degrees/s of each axis at rapid; slides: rows of the linear
    axes, along which a feed counts; drops: whether blocks with / are skipped; dialect: of the program."""

    velocity: np.ndarray
    slides: tuple[int, ...]
    dialect: Dialect
    drops: bool = False


@dataclass(frozen=True)
class Times:
    """Of each motion (N,): begin and end, microseconds since the program began; rpm, the spindle's turns per minute."""

    begin: np.ndarray
    end: np.ndarray
    rpm: np.ndarray

    @property
    def middle(self) -> np.ndarray:
        """(N,) s."""
        return (self.begin + self.end) / (2 * MICRO)


def run(words: Words, motions: Motions, rates: Rates, before: Ticking) -> tuple[Times, Ticking]:
    """The times of a batch."""
    spindle, spoken = pace.spindle(words, rates.dialect, before.spoken)
    n = len(motions)
    rpm = _turns(motions, spindle) if n else np.zeros(0)
    took, without = _durations(motions, spindle, rpm, rates)
    micros = np.rint(took * MICRO).astype(np.int64)
    rests = _rests(words, rates)
    waits = np.zeros(n, np.int64)
    last = 0
    for block, rest in rests:  # behind the motions of its own block
        k = int(np.searchsorted(motions.block, block, "right"))
        if k < n:
            waits[k] += rest
        else:
            last += rest
    end = before.now + np.cumsum(micros + waits)
    now = (int(end[-1]) if n else before.now) + last
    return Times(end - micros, end, rpm), Ticking(now, spoken, before.without + without)


def _rests(words: Words, rates: Rates) -> list[tuple[int, int]]:
    """Block and microseconds of every dwell; one whose time is not known rests 0."""
    live = pace.live(words, rates.dialect)
    found = []
    for block in pace.dwells(words):
        if block <= live and not (rates.drops and words.skip[block]):
            seconds = pace.seconds(words, block, rates.dialect)
            if 0 < seconds <= pace.LONGEST:
                found.append((block, round(seconds * MICRO)))
    return found


def _turns(motions: Motions, spindle: pace.Spindle) -> np.ndarray:
    """(N,) turns per minute; under G96 by the radius in the middle of the motion."""
    number, on = spindle.number[motions.block], spindle.on[motions.block]
    radius = np.abs(motions.start[0] + motions.target[0]) / (
        2 * TICKS_PER_MM
    )  # X, or the first axis that there is
    by_surface = number * 1000.0 / (2 * np.pi * np.maximum(radius, SMALLEST))
    found: np.ndarray = np.where(
        on, np.where(spindle.surface[motions.block], by_surface, number), 0.0
    )
    return found


def _durations(
    motions: Motions, spindle: pace.Spindle, rpm: np.ndarray, rates: Rates
) -> tuple[np.ndarray, int]:
    """(N,) s, and how many motions have no feed that says how long they take."""
    known = motions.start_known & motions.target_known
    way = np.where(known, np.abs(motions.target - motions.start), 0) / TICKS_PER_MM
    rapid = (way / rates.velocity[:, None]).max(axis=0, initial=0.0)
    length = np.sqrt((way[list(rates.slides)] ** 2).sum(axis=0))
    length = np.where(length > 0, length, way.max(axis=0, initial=0.0))
    arcs = motions.arcs
    turned = np.abs(arcs.sweep) * arcs.radius
    across = np.sqrt(np.maximum(length[arcs.motion] ** 2 - _plane(way, arcs) ** 2, 0.0))
    length[arcs.motion] = np.hypot(turned, across)
    unit = (
        np.where((motions.scale > TICKS_PER_MM).any(axis=0), 25.4, 1.0)
        if len(motions)
        else np.zeros(0)
    )
    feed = motions.feed * unit / 60.0
    if len(motions):
        by_turn = spindle.mode[motions.block] == pace.PER_TURN
        feed = np.where(by_turn, feed * rpm, feed)
    feed = np.where(
        motions.code == THREAD, np.where(motions.lead > 0, motions.lead, np.nan) * rpm / 60.0, feed
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        took = np.where(motions.inverse, 60.0 / motions.feed, length / feed)
    took[motions.holes.motion] += rapid[motions.holes.motion] + _down(motions, feed, rates.velocity)
    at_feed = bool(rates.dialect.carried) & np.isfinite(took)  # printers run G0 with F
    took = np.where((motions.code == RAPID) & ~at_feed, rapid, took)
    moves = (way.max(axis=0, initial=0.0) > 0) | (motions.code == HOLE)
    bad = ~np.isfinite(took) & moves & (motions.code != FOREIGN)
    return np.where(np.isfinite(took) & (motions.code != FOREIGN), took, 0.0), int(bad.sum())


def _plane(way: np.ndarray, arcs) -> np.ndarray:
    """(n,) mm of an arc's chord in its plane."""
    k = arcs.motion
    found: np.ndarray = np.hypot(way[arcs.first, k], way[arcs.second, k])
    return found


def _down(motions: Motions, feed: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """(n,) s of each hole: once down at its feed and back up as a rapid; pecks are not known here."""
    holes = motions.holes
    deep = np.abs(holes.level - holes.bottom) / TICKS_PER_MM
    with np.errstate(divide="ignore", invalid="ignore"):
        down = deep / feed[holes.motion]
    found: np.ndarray = down + deep / velocity[holes.axis]
    return found
