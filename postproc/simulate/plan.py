"""A path in time: as fast as feeds and limits allow, slowing down in time for what comes
(look-ahead).

Along each piece the speed rises, holds and falls: at constant acceleration (trapezoid), or, where a
jerk is limited, with the acceleration rising and falling at constant jerk and zero at both ends
(seven phases; the jerk is that of the path's speed: where the curvature steps, so does the
acceleration across). On curves half of an axis' acceleration is left to the speed and 0.866 of it
to the bend (their squares add up to 1). Where two pieces meet at a corner that is not cut, the
velocity may step by as much as an axis can do in one `cycle` of the control; rapids and stops come
to rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from postproc.simulate.limits import Limits
from postproc.simulate.path import Path

# with half of the acceleration left to the speed: 0.5**2 + 0.866**2 = 1
BEND = math.sqrt(3.0) / 2.0
SPIRAL = 1.09  # r times the curvature of r = r0 + k phi is at most this
EVEN = 1e-9  # difference of two directions that is none
HALVINGS = 60


@dataclass(frozen=True)
class Bounds:
    """(P,) highest speed mm/s, acceleration mm/s2 and jerk mm/s3 along each piece."""

    speed: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray


@dataclass(frozen=True)
class Plan:
    """Seven phases of every piece. duration (7, P) s; s, v, a (7, P): way gone, speed and
    acceleration where each begins; j (7, P) jerk. start (P + 1,) s: when each piece begins, and the
    end."""

    duration: np.ndarray
    s: np.ndarray
    v: np.ndarray
    a: np.ndarray
    j: np.ndarray
    start: np.ndarray

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """(K,) piece, way gone in it, speed and acceleration at these times."""
        #    a ^  ._.               phases 0 1 2   up: ramp, flat, ramp
        #      | /   \              phase  3       hold (or the rest of a dwell)
        #      +------'---.  ,-> t  phases 4 5 6   down: ramp, flat, ramp
        #                  \_/
        piece = np.clip(np.searchsorted(self.start, time, side="right") - 1, 0, len(self.start) - 2)
        left = time - self.start[piece]
        begin = np.cumsum(self.duration[:, piece], axis=0) - self.duration[:, piece]
        phase = np.maximum((left[None] >= begin).sum(axis=0) - 1, 0)
        column = np.arange(len(time))
        tau = np.clip(left - begin[phase, column], 0.0, self.duration[phase, piece])
        s, v, a, j = (x[phase, piece] for x in (self.s, self.v, self.a, self.j))
        return (
            piece,
            s + tau * (v + tau * (a / 2 + tau * j / 6)),
            np.maximum(v + tau * (a + tau * j / 2), 0.0),
            a + tau * j,
        )


def of(path: Path, limits: Limits, cycle: float) -> Plan:
    """When the path is where. cycle: s, of the control, for corners that are not cut; 0: it stops
    in them."""
    bounds = _bounds(path, limits)
    joint = _joints(path, limits, bounds, cycle)
    entry = _look_ahead(path.length.tolist(), joint, bounds, limits.smooth)
    v0, v1 = entry[:-1], entry[1:]
    phases = (
        _smooth(v0, v1, path.length, bounds)
        if limits.smooth
        else _trapezoid(v0, v1, path.length, bounds)
    )
    wait = path.steps.wait[path.step]
    # a dwell is a piece of no length that holds for its time at speed zero
    phases[0][3] = np.where(np.isnan(wait), phases[0][3], wait)
    duration, s, v, a, j = phases
    return Plan(duration, s, v, a, j, np.concatenate([[0.0], np.cumsum(duration.sum(axis=0))]))


def _bounds(path: Path, limits: Limits) -> Bounds:
    """What each piece may do along its path: the least that the limits of the axes allow, each by
    its share of the way, on arcs also by the speed across the bend."""
    steps, size = path.steps, np.where(path.length > 0, path.length, 1.0)
    share = np.abs(path.end - path.begin) / size

    def least(limit: np.ndarray, part: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore", invalid="ignore"):
            each = np.where(part > 0, limit[:, None] / part, np.inf)
        return np.min(each, axis=0)

    speed, acceleration, jerk = (
        least(x, share) for x in (limits.velocity, limits.acceleration, limits.jerk)
    )
    of = np.flatnonzero(path.curve >= 0)
    if len(of):
        c = path.curves.pick(path.curve[of])
        inner, outer = np.minimum(c.r0, c.r1), np.maximum(c.r0, c.r1)
        spiral = c.r0 != c.r1
        plane = np.hypot(c.e1, c.e2)
        turn = np.abs(c.sweep)
        # share of the speed in the plane
        flat = np.where(spiral, 1.0, outer * turn / np.hypot(outer * turn, c.rise))
        rise = np.abs(c.axial) / np.hypot(inner * turn, np.sqrt((c.axial**2).sum(axis=0)))
        # v**2 / r across the bend must stay below 0.866 of an axis' acceleration. A spiral r = r0 +
        # k phi is bent most where k is r / sqrt(2): 2 / 1.5**1.5 = 1.09 times 1 / r.
        bend = (
            BEND
            * least(limits.acceleration, plane)
            * np.maximum(inner, 1e-9)
            / np.where(spiral, SPIRAL, 1.0)
        )
        speed[of] = np.minimum.reduce(
            [
                least(limits.velocity, plane * flat),
                least(limits.velocity, rise),
                np.sqrt(bend) / flat,
            ]
        )
        acceleration[of] = np.minimum(
            least(limits.acceleration / 2, plane * flat), least(limits.acceleration, rise)
        )
        jerk[of] = np.minimum(least(limits.jerk, plane * flat), least(limits.jerk, rise))
    # G93 gives the time of the block
    whole = np.bincount(path.step, path.length, len(steps))[path.step]
    feed = np.where(steps.inverse[path.step], steps.feed[path.step] * whole, steps.feed[path.step])
    speed = np.where(np.isnan(feed), speed, np.minimum(speed, feed))
    fast = ~np.isfinite(speed) | ~np.isfinite(acceleration)
    if (fast & ~path.rests).any():  # only axes that are no slides move: they bound nothing
        acceleration = np.where(np.isfinite(acceleration), acceleration, 1e6)
        speed = np.where(np.isfinite(speed), speed, 1e3)
    return Bounds(np.where(path.rests, 0.0, speed), acceleration, jerk)


def _joints(path: Path, limits: Limits, bounds: Bounds, cycle: float) -> np.ndarray:
    """(P + 1,) mm/s: highest speed at which a piece may begin, and the last end."""
    first, last = path.tangents()
    step = np.abs(first[:, 1:] - last[:, :-1])
    speed = np.minimum(bounds.speed[:-1], bounds.speed[1:])
    size = np.minimum(path.length[:-1], path.length[1:])
    with np.errstate(divide="ignore", invalid="ignore"):
        each = np.where(step > EVEN, limits.acceleration[:, None] / step, np.inf)
    soft = np.min(each, axis=0)
    # A corner between tangents that differ by `step` asks an axis for v * step in no time. Spread
    # over one cycle of the control, and a quarter of the shorter piece at the most, it is what the
    # axis can accelerate.
    bound = np.where(np.isfinite(soft), soft, 0.0)
    cap = np.where(
        np.isfinite(soft), np.minimum(bound * cycle, np.sqrt(0.25 * bound * size)), speed
    )
    steps, of = path.steps, path.step
    rapid, other = steps.rapid[of], of[1:] != of[:-1]
    stop = other & (
        rapid[:-1] | rapid[1:] | steps.stop[of[:-1]] | (path.turns[:-1] != path.turns[1:])
    )
    # A corner that was cut is the way from one step to the next: its arc belongs to the first, and
    # so to its stop.
    stop |= path.rests[:-1] | path.rests[1:]
    return np.concatenate([[0.0], np.where(stop, 0.0, np.minimum(cap, speed)), [0.0]])


def _look_ahead(length: list[float], joint: np.ndarray, bounds: Bounds, smooth: bool) -> np.ndarray:
    """(P + 1,) mm/s at the joints: backwards what can still be braked for, forwards what can be
    reached."""
    v, acceleration = joint.tolist(), bounds.acceleration.tolist()
    jerk = bounds.jerk.tolist()
    reach = _reach if smooth else (lambda v0, way, a, j: math.sqrt(v0 * v0 + 2.0 * a * way))
    #    v ^    .--.        First from the end, what can be braked from, then from the beginning,
    #      |   /    \  .    what can be reached: each joint is then as fast as all pieces before
    #      |  /      \/     and behind it allow.
    for k in range(len(length) - 1, -1, -1):
        if v[k] > v[k + 1]:
            v[k] = min(v[k], reach(v[k + 1], length[k], acceleration[k], jerk[k]))
    for k in range(len(length)):
        if v[k + 1] > v[k]:
            v[k + 1] = min(v[k + 1], reach(v[k], length[k], acceleration[k], jerk[k]))
    return np.array(v)


def _reach(v0: float, way: float, a: float, j: float) -> float:
    """mm/s that can be reached from v0 within a way, the acceleration zero at both ends."""
    if math.isinf(j):
        return math.sqrt(v0 * v0 + 2.0 * a * way)
    # The acceleration reaches a when the speed changes by a^2/j or more; below: (2 v0 + w^2) w =
    # way sqrt(j), w^2 the change: a cubic in w with one real root, by sinh since 2 v0 is above 0
    # (w = 2 p sinh(x) makes w^3 + 3 p^2 w of it, which is 2 p^3 sinh(3 x)).
    full = a * a / j
    if (v0 + full / 2.0) * 2.0 * a / j > way:
        if v0 <= 0.0:
            return (way * math.sqrt(j)) ** (2.0 / 3.0)
        p = math.sqrt(2.0 * v0 / 3.0)
        w = 2.0 * p * math.sinh(math.asinh(way * math.sqrt(j) / (2.0 * p**3)) / 3.0)
        return v0 + w * w
    # the acceleration reaches a: v**2 + full v = v0**2 - full v0 + 2 a way, solved for v
    return (-full + math.sqrt(full * full - 4.0 * (v0 * full - v0 * v0 - 2.0 * a * way))) / 2.0


def _trapezoid(
    v0: np.ndarray, v1: np.ndarray, length: np.ndarray, bounds: Bounds
) -> list[np.ndarray]:
    """Phases of pieces at limited acceleration alone."""
    # Up from v0 and down to v1 without a hold takes (2 top^2 - v0^2 - v1^2) / 2a of the length.
    a = np.where(np.isfinite(bounds.acceleration), bounds.acceleration, 1.0)
    top = np.minimum(bounds.speed, np.sqrt(np.maximum(a * length + (v0**2 + v1**2) / 2, 0.0)))
    top = np.maximum(top, np.maximum(v0, v1))
    up, down = (top - v0) / a, (top - v1) / a
    left = np.maximum(length - up * (v0 + top) / 2 - down * (v1 + top) / 2, 0.0)
    hold = np.where(top > 0, left / np.where(top > 0, top, 1.0), 0.0)
    zero = np.zeros_like(a)
    duration = np.stack([zero, up, zero, hold, zero, down, zero])
    return _phases(
        duration, v0, np.stack([zero, a, zero, zero, zero, -a, zero]), np.zeros_like(duration)
    )


def _way(v0: np.ndarray, v1: np.ndarray, a: np.ndarray, j: np.ndarray) -> np.ndarray:
    """mm gone while the speed changes from v0 to v1."""
    change = np.abs(v1 - v0)
    time = np.where(change < a * a / j, 2.0 * np.sqrt(change / j), change / a + a / j)
    return (v0 + v1) / 2 * time


def _smooth(v0: np.ndarray, v1: np.ndarray, length: np.ndarray, bounds: Bounds) -> list[np.ndarray]:
    """Phases of pieces at limited jerk too."""
    a = np.where(np.isfinite(bounds.acceleration), bounds.acceleration, 1.0)
    j = np.where(np.isfinite(bounds.jerk), bounds.jerk, a * 1e9)
    # the top lies between the faster end and the wanted speed; 60 halvings are below a float's
    # digits
    low = np.maximum(v0, v1)
    high = np.maximum(bounds.speed, low)
    fits = _way(v0, high, a, j) + _way(v1, high, a, j) <= length
    low = np.where(fits, high, low)
    # Where the wanted speed is not reached, the highest that is: the way grows with it.
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        good = _way(v0, middle, a, j) + _way(v1, middle, a, j) <= length
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    top, zero = low, np.zeros_like(a)
    duration, begins, jerks = [], [], []
    for change, sign in ((top - v0, 1.0), (top - v1, -1.0)):
        full = change >= a * a / j
        ramp = np.where(full, a / j, np.sqrt(np.maximum(change, 0.0) / j))
        flat = np.where(full, np.maximum(change / a - a / j, 0.0), 0.0)
        duration += [ramp, flat, ramp]
        begins += [zero, sign * ramp * j, sign * ramp * j]
        jerks += [sign * j, zero, -sign * j]
    left = np.maximum(length - _way(v0, top, a, j) - _way(v1, top, a, j), 0.0)
    hold = np.where(top > 0, left / np.where(top > 0, top, 1.0), 0.0)
    duration[3:3], begins[3:3], jerks[3:3] = [hold], [zero], [zero]
    return _phases(np.stack(duration), v0, np.stack(begins), np.stack(jerks))


def _phases(duration: np.ndarray, v0: np.ndarray, a: np.ndarray, j: np.ndarray) -> list[np.ndarray]:
    """duration, s, v, a, j (7, P) from durations, first speeds, accelerations and jerks."""
    # speed gained in each phase; summed up less its own it is the speed at which each begins
    gain = duration * (a + duration * j / 2)
    v = v0 + np.cumsum(gain, axis=0) - gain
    way = duration * (v + duration * (a / 2 + duration * j / 6))
    return [duration, np.cumsum(way, axis=0) - way, v, a, j]
