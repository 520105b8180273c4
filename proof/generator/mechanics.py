"""Pieces of machine dynamics: friction with memory, servo loops as linear filters, slip in
steps."""

from __future__ import annotations

import numpy as np
from scipy.signal import bilinear, lfilter, lfilter_zi


def play(way: np.ndarray, gap: float) -> np.ndarray:
    """The table behind a screw with dead travel `gap` (mm): (N,) what it lags or leads, -gap/2 to
    gap/2, at each point."""
    found, state = [], way[0] - gap / 2
    for low, high in zip((way - gap / 2).tolist(), (way + gap / 2).tolist(), strict=True):
        state = low if state < low else state  # a fifth of the time that min and max take
        state = high if state > high else state
        found.append(state)
    return np.array(found) - way


def iwan(way: np.ndarray, yields: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Iwan's parallel sliders: (N,) force of springs that slip at `yields` (mm), each with its
    share of the whole; -1 to 1. Between two turns every spring stretches until it slips, so a whole
    stretch is one clip."""
    step = np.sign(np.diff(way, prepend=way[0]))
    moved = np.flatnonzero(step)
    turns = moved[1:][step[moved[1:]] != step[moved[:-1]]] - 1
    ends = np.unique(np.r_[turns, len(way) - 1])
    found = np.empty(len(way))
    state, begun = np.array(yields), 0
    for end in ends:
        stretch = state + (way[begun : end + 1, None] - way[begun])
        stretch = np.clip(stretch, -yields, yields)
        found[begun : end + 1] = (stretch / yields) @ shares
        state, begun = stretch[-1], end
    return found


def lugre(
    dt: float,
    v: np.ndarray,
    forward: float,
    reverse: float,
    peak: float,
    stribeck: float,
    bristle: float,
) -> np.ndarray:
    """LuGre's friction force (N,) for speeds v (mm/s): Coulomb level `forward` or `reverse` by
    direction, times `peak` near rest; stribeck mm/s; bristle mm. The bristle's equation is linear
    between samples and is solved exactly there."""
    level = np.where(v >= 0, forward, reverse) * (1 + (peak - 1) * np.exp(-((v / stribeck) ** 2)))
    rate = np.abs(v) / bristle
    keep = np.exp(-rate * dt)
    goal = np.sign(v) * level * (1 - keep)
    found = np.empty(len(v))
    z = 0.0
    for k, (a, b) in enumerate(zip(keep.tolist(), goal.tolist(), strict=True)):
        z = a * z + b
        found[k] = z
    return found


def second_order(dt: float, u: np.ndarray, omega: float, zeta: float) -> np.ndarray:
    """u behind a mass on a spring: omega rad/s, damping zeta."""
    b, a = bilinear([omega**2], [1, 2 * zeta * omega, omega**2], 1 / dt)
    return _filtered(b, a, u)


def loop_response(
    dt: float, force: np.ndarray, integral: float | None, mechanical: float
) -> np.ndarray:
    """Following error of a position loop under a force, in units of force / stiffness: a lag of
    `mechanical` s twice and, where the loop has an integral of `integral` s, back to zero."""
    b, a = bilinear([1.0], [mechanical**2, 2 * mechanical, 1.0], 1 / dt)
    out = _filtered(b, a, force)
    if integral is not None:
        b, a = bilinear([integral, 0.0], [integral, 1.0], 1 / dt)
        out = _filtered(b, a, out)
    return -out


def _filtered(b: np.ndarray, a: np.ndarray, u: np.ndarray) -> np.ndarray:
    return lfilter(b, a, u, zi=lfilter_zi(b, a) * u[0])[0]


def slip_steps(
    way: np.ndarray,
    v: np.ndarray,
    hold: float,
    slide: float,
    fastest: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Saw-tooth of a slide that sticks until the drive is `hold` mm ahead, then jumps to 2 slide -
    hold; above `fastest` mm/s it follows evenly. (N,) mm beyond the even lag; each hold differs by
    a tenth."""
    lag = 0.0
    limit = hold
    found = np.zeros(len(way))
    even = slide
    last = way[0]
    for k, (x, speed) in enumerate(zip(way.tolist(), v.tolist(), strict=True)):
        lag -= x - last
        last = x
        size = abs(speed)
        if size > fastest:
            lag = -even if speed > 0 else even
            continue
        if abs(lag) > limit:
            sign = 1.0 if lag > 0 else -1.0
            lag = sign * (2 * slide - limit)
            limit = hold * float(1 + 0.1 * rng.standard_normal())
        if size > 0:
            fade = 1.0 - (size / fastest) ** 2
            found[k] = fade * (lag + (even if speed > 0 else -even))
        elif k:
            found[k] = found[k - 1]
    return found


def speed_of(time: np.ndarray, position: np.ndarray) -> np.ndarray:
    return np.gradient(position, time)
