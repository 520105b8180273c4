"""What has happened to each axis before: from which side it comes, how far and how long ago it
turned back, how warm it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.simulate.path import Path
from postproc.simulate.plan import Plan

FAR = 1e6  # mm and s: the axis has not turned back yet
MOVES = 1e-9  # mm: a piece in which an axis goes less does not move it
SLIDES = "XYZ"


@dataclass(frozen=True)
class Heat:
    """Temperatures, degrees Celsius: the air at the start and its change K/h; a screw warms by
    `gain` K at a steady 1 m/min and takes tau s for it (63 %); the bed follows the air within
    bed_tau s."""

    air: float = 20.0
    drift: float = 0.0
    gain: float = 0.8
    tau: float = 1800.0
    bed_tau: float = 7200.0


@dataclass(frozen=True)
class Turns:
    """(A, P) at the beginning of each piece: approach -1, 0, +1 while it runs; distance mm gone
    since the axis turned back; since s, when it did."""

    approach: np.ndarray
    distance: np.ndarray
    since: np.ndarray


def turns(path: Path, plan: Plan, play: float) -> Turns:
    """Follow every axis. play: mm, an axis that goes back by less has not turned."""
    way = path.end - path.begin
    shape = way.shape
    approach, distance, since = np.zeros(shape), np.full(shape, FAR), np.full(shape, -FAR)
    for axis in range(shape[0]):
        d = np.where(np.abs(way[axis]) > MOVES, way[axis], 0.0)
        moving = np.flatnonzero(d)
        if not len(moving):
            continue
        sign = np.sign(d[moving])
        run = np.cumsum(np.concatenate([[0], sign[1:] != sign[:-1]]))
        total = np.bincount(run, np.abs(d[moving]))
        # A way back that is shorter than the play, all its pieces together, turns nothing: the axis
        # keeps its side, and its distance goes on.
        whole = total[run] >= play
        if not whole.any():
            continue
        given = np.full(shape[1], -1)
        given[moving[whole]] = moving[whole]
        last = np.maximum.accumulate(given)
        # the way of the last piece that moved it for good holds until the next such
        now = np.where(last >= 0, np.sign(d)[np.maximum(last, 0)], 0.0)
        before = np.concatenate([[0.0], now[:-1]])
        turn = np.where((now != before) & (before != 0), np.arange(shape[1]), -1)
        turned = np.maximum.accumulate(turn)
        # way in both directions together: what it has gone since a turn is a difference of two of
        # these
        gone = np.concatenate([[0.0], np.cumsum(np.abs(d))])
        at = np.maximum(turned, 0)
        approach[axis] = now
        distance[axis] = np.where(turned >= 0, gone[:-1] - gone[at], FAR)
        since[axis] = np.where(turned >= 0, plan.start[at], -FAR)
    return Turns(approach, distance, since)


@dataclass(frozen=True)
class Warmth:
    """Temperatures over time. excess (A, P + 1) K: of each screw over what the air alone would
    give, where each piece begins;
    speed (A, P) mm/s: mean speed of each axis in it."""

    heat: Heat
    letters: tuple[str, ...]
    start: np.ndarray
    excess: np.ndarray
    speed: np.ndarray

    def air(self, time: np.ndarray) -> np.ndarray:
        """(K,) degrees Celsius."""
        return self.heat.air + self.heat.drift / 3600.0 * time

    def following(self, time: np.ndarray, tau: float) -> np.ndarray:
        """(K,) degrees Celsius of what follows the air within tau s, and had its temperature at the
        start."""
        rate = self.heat.drift / 3600.0
        # first order behind a ramp: it follows it tau late, once the beginning has faded
        return self.heat.air + rate * (time - tau * (1.0 - np.exp(-time / tau)))

    def screw(self, letter: str, time: np.ndarray, piece: np.ndarray) -> np.ndarray:
        """(K,) degrees Celsius."""
        row, tau = self.letters.index(letter), self.heat.tau
        # K at a steady speed: gain per m/min, and 0.06 m/min are 1 mm/s
        level = self.heat.gain * self.speed[row, piece] * 0.06
        fade = np.exp(-np.maximum(time - self.start[piece], 0.0) / tau)
        return self.following(time, tau) + level + (self.excess[row, piece] - level) * fade


def warmth(path: Path, plan: Plan, heat: Heat) -> Warmth:
    """The heat of travel of every screw: first order, heated with its speed (piece by piece its
    mean) and cooled by the air."""
    duration = np.diff(plan.start)
    way = np.abs(path.end - path.begin)
    speed = np.divide(way, duration, out=np.zeros_like(way), where=duration > 0)
    fade = np.exp(-duration / heat.tau)
    excess = np.zeros((len(way), len(duration) + 1))
    for axis, letter in enumerate(path.letters):
        if letter not in SLIDES:
            continue
        level = (heat.gain * speed[axis] * 0.06 * (1.0 - fade)).tolist()
        # piece by piece: level is what the screw tends to, (1 - fade) of it comes in one
        now, track = 0.0, [0.0]
        for keep, more in zip(fade.tolist(), level, strict=True):
            now = now * keep + more
            track.append(now)
        excess[axis] = track
    return Warmth(heat, path.letters, plan.start, excess, speed)
