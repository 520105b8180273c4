"""Slips of a creeping slide: when it let go, by the samples of its lag.

A slide that sticks stands while its command goes on, so that it lags by the way of the command;
a slip lets that go in a part of the time (Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica
30, 1994, 1083). No cycle is as long as the one before, for what holds it differs from place to
place and with the time that it stood, so that no wave of one period follows them. Tops and bottoms
of the lag are its turning points beyond a threshold (ASTM E1049, peak-valley counting).
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from postproc.effects.stick_slip import CRITICAL

FEWEST, FEWEST_SAMPLES = 12, 64  # slips of a stroke; samples of one
CLEAR = 4.0  # times the noise of a sample: a sawtooth
HALF = 0.5  # of the usual sawtooth: what counts as another one
# of third differences, the share that no slip is in where cycles have eight samples or more; that
# quantile of a normal distribution
QUIET, OF_NORMAL = 0.25, 0.3186
# of a cycle, that a slip takes at most beyond the sample in which it begins; samples, in so few of
# which an oscillation falls as soon
AT_ONCE, FEW = 0.25, 4
# of the way that it is driven on: what it lags by while it stands; by less where the reading is
# taken behind what gives (a belt, a motor's encoder), or where it creeps on as it is held
STANDS = 0.12, 1.5
# standard deviation of the ways from slip to slip, of their mean, in the usual stroke: less is one
# wave, as is found from a spectrum, and more are turning points of noise (0.6 and more)
UNEVEN = 0.1, 0.3
SPREAD = 4.0  # standard deviations within which the end of a cycle is looked for


#     lag  |     /|    /|      /|         top: it lets go
#          |    / |   / |     / |
#          |   /  |  /  |    /  |  /
#          |  /   | /   |   /   | /       bottom: it sticks again
#          | /    |/    |__/    |/
#          +----------------------------- way that is driven
#           <-way-><-way->               `since` grows from 0 to the way, and falls in a slip
#
class Slips(NamedTuple):
    """since (N,) mm: of each sample the way that was driven since the last slip, falling while it
    slips; as the slide stopped while it rests, NaN where it does not creep so. ways (C,) mm: of
    each cycle, driven on while it sticks; steps (C,) mm from sample to sample there; fastest mm/s,
    at which it slips."""

    since: np.ndarray
    ways: np.ndarray
    steps: np.ndarray
    fastest: float

    @property
    def scatter(self) -> float:
        """Standard deviation of the ways, of their mean."""
        return float(np.std(self.ways) / np.mean(self.ways))

    @property
    def chosen_from(self) -> int:
        """Places of all slips among which these were chosen."""
        room = SPREAD * self.scatter * float(np.mean(self.ways)) / self.steps
        return int(np.prod([max(2, round(float(r))) for r in room], dtype=object))


def of(place: np.ndarray, lag: np.ndarray, velocity: np.ndarray, run: np.ndarray) -> Slips | None:
    """The slips of an axis. place, lag (N,) mm, commanded, and by how much it lags; velocity (N,)
    mm/s; run (N,). None: it does not stick and slip."""
    creeps = (velocity != 0) & (np.abs(velocity) < CRITICAL)
    since, fastest = np.full(len(place), np.nan), 0.0
    ways, steps = [np.zeros(0)], [np.zeros(0)]
    key = np.where(creeps, np.sign(velocity), 2.0 * (velocity != 0))
    edges = np.flatnonzero((np.diff(key) != 0) | (np.diff(run) != 0)) + 1
    strokes = list(pairwise([0, *edges.tolist(), len(place)]))
    long = [(a, b) for a, b in strokes if creeps[a] and b - a >= FEWEST_SAMPLES]
    way = {a: np.abs(place[a:b] - place[a]) for a, b in long}
    teeth = _alike({a: _sawtooth(lag[a:b], way[a]) for a, b in long})
    for a, b in strokes:
        if a and velocity[a] == 0 and run[a] == run[a - 1]:
            since[a:b] = since[a - 1]  # it stays as it stopped
        if a not in teeth:
            continue
        at, height = teeth[a].at, teeth[a].height
        since[a:b] = np.interp(way[a], way[a][at], height)
        ways.append(height[height > 0][1:-1])
        steps.append(np.full(len(ways[-1]), np.median(np.diff(way[a]))))
        fastest = max(fastest, float(np.abs(velocity[a:b]).max()))
    cycles = np.concatenate(ways)
    return Slips(since, cycles, np.concatenate(steps), fastest) if len(cycles) else None


class Sawtooth(NamedTuple):
    """at (T,): numbers of the samples of a stroke at which its lag begins to grow and is let go,
    from the first to the last; height (T,) mm: the way since the last slip there; stands: of the
    way that it is driven on, what it lags by; uneven: standard deviation of the ways from slip to
    slip, of their mean."""

    at: np.ndarray
    height: np.ndarray
    stands: float
    uneven: float


def _alike(found: dict[int, Sawtooth | None]) -> dict[int, Sawtooth]:
    """Of the strokes of an axis those with slips: it stands, or lets go after uneven ways."""
    teeth = {a: one for a, one in found.items() if one}
    usual = np.median([one.uneven for one in teeth.values()] or [0.0])
    least = 0.0 if UNEVEN[0] < usual < UNEVEN[1] else STANDS[0]
    return {a: one for a, one in teeth.items() if one.stands > least}


def _sawtooth(lag: np.ndarray, gone: np.ndarray) -> Sawtooth | None:
    """The sawtooth of a lag (n,) mm; gone (n,) mm: way that was driven. None where it does not
    stand, and is let go at once, again and again."""
    noise = float(np.quantile(np.abs(np.diff(lag, 3)), QUIET)) / OF_NORMAL / np.sqrt(20.0)
    first = _turns(lag, CLEAR * noise)
    if len(first) < 2 * FEWEST:
        return None
    falls = np.abs(np.diff(lag[first]))
    turns = _turns(lag, max(CLEAR * noise, HALF * float(falls @ falls / falls.sum())))
    if len(turns) < 2 * FEWEST:
        return None
    from_top = int(lag[turns[0]] > lag[turns[1]])  # with a top
    inner = turns[from_top : from_top + (len(turns) - from_top) // 2 * 2]
    bottoms, tops = inner[::2], inner[1::2]
    stick, slip = (tops - bottoms)[:-1], bottoms[1:] - tops[:-1]
    way = gone[tops] - gone[bottoms]
    stands = np.median((lag[tops] - lag[bottoms]) / way)
    cycle = np.median(stick + slip)
    at_once = cycle > FEW and np.median(slip) - 1 <= AT_ONCE * cycle
    if not (at_once and 0.0 < stands < STANDS[1]):
        return None
    cycles = np.diff(gone[bottoms])
    height = np.stack([np.zeros(len(way)), way], axis=1).ravel()
    usual = float(np.mean(way))
    end = len(lag) - 1
    last = inner[-1] + int(np.argmin(lag[inner[-1] :]))
    at = [0, *turns[:from_top], *inner, *([last] if last < end else []), end]
    ahead = gone[turns[0] if from_top else 0]
    before = [max(usual - ahead, 0.0), usual] if from_top else [0.0]
    after = [0.0, gone[end] - gone[last]] if last < end else [0.0]
    uneven = float(np.std(cycles) / np.mean(cycles))
    return Sawtooth(np.array(at), np.concatenate([before, height, after]), float(stands), uneven)


def _turns(values: np.ndarray, least: float) -> np.ndarray:
    """Numbers of the turning points between which values (n,) rise and fall by more than
    `least`, without the last one, which may not be one yet."""
    found: list[int] = []
    low = high = 0
    up = down = True  # what it may have been doing
    series = values.tolist()
    for k, v in enumerate(series):
        if v > series[high]:
            high = k
        if v < series[low]:
            low = k
        if up and series[high] - v > least:
            found.append(high)
            up, down, low = False, True, k
        elif down and v - series[low] > least:
            found.append(low)
            up, down, high = True, False, k
    return np.array(found, int)
