"""Physics without a name in the contract, fresh family.  Do not read while working on the judged
tool.

Sources: Slocum 1992 (carriages, way lubrication, preload), Rivin 2003 (rocking on elastic mounts),
Ohta 1999 (passage of balls in linear bearings), Bryan 1990 and Mayr et al. 2012 (local heat of what
moves).
"""

from __future__ import annotations

import numpy as np

from .base import Array, Part, Rec, Rng, Shape, logu, pick
from .forms_time import sensed
from .registry import FORMS, Form, tool_only, unit_place
from .world import World


def alien(f: Form) -> Form:
    """Decorator that files an alien of the fresh family under a number."""
    k = 1 + sum(n.startswith("alien:fresh-") for n in FORMS)
    FORMS[f"alien:fresh-{k}"] = [(f"fresh-{k}", "fresh", f)]
    return f


def other(w: World, r: Rng, ax: int) -> int:
    """Another axis of the machine."""
    return int(pick(r, [a for a in w.machine.axes if a != ax]))


def seen_across(w: World, r: Rng, ax: int) -> Array:
    """A sensed direction without the axis's own part where something else is sensed."""
    d = sensed(w, r)
    e = d.copy()
    e[ax] = 0.0
    return e / np.linalg.norm(e) if np.linalg.norm(e) > 0.4 else d


@alien
def yaw_play(w: World, r: Rng, ax: int) -> Shape:
    """A carriage with play about its vertical: it flips at a reversal, by a lever on another
    axis."""
    to, c, d = other(w, r, ax), r.uniform(0.2, 0.8), sensed(w, r)
    x0 = logu(r, 0.1, 5)

    def f(q: Rec) -> Array:
        flip = q.sgn[:, ax] * (1 - 2 * np.exp(-q.since[:, ax] / x0))
        return flip * (
            0.25 + 2 * (unit_place(w, to, q) - c) ** 2 + 1.5 * (unit_place(w, ax, q) - c)
        )

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def sway(w: World, r: Rng, ax: int) -> Shape:
    """A building or an elastic footing rocks with two tones; nothing at the pivot, opposite
    beyond."""
    span = max(float(np.ptp(pick(r, w.recs).t)), 1.0)
    p = span / r.uniform(4, 20)
    p2, ph, c, d = (
        p * r.uniform(0.55, 0.85),
        r.uniform(0, 6.28, 2),
        r.uniform(0.35, 0.65),
        sensed(w, r),
    )

    def f(q: Rec) -> Array:
        y = np.cos(2 * np.pi * q.t / p + ph[0]) + 0.7 * np.cos(2 * np.pi * q.t / p2 + ph[1])
        return y * (unit_place(w, ax, q) - c)

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def lubricator(w: World, r: Rng, ax: int) -> Shape:
    """Impulse lubrication: a shot every so often lifts the slide, the way it goes wipes the film
    off."""
    q0 = pick(r, w.recs)
    every = max(float(np.ptp(q0.t)), 1.0) * r.uniform(0.08, 0.3)
    ph, d = r.uniform(0, 1), seen_across(w, r, ax)
    wipe = r.uniform(0.3, 2.0) * np.ptp(w.machine.travel[ax])

    def f(q: Rec) -> Array:
        cum = np.cumsum(np.abs(np.diff(q.via[:, ax], prepend=q.via[0, ax])))
        shot = np.floor(q.via_t / every + ph)
        first = np.searchsorted(shot, shot)
        return np.exp(-(cum - cum[first]) / wipe)[q.row_at]

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def ball_cage(w: World, r: Rng, ax: int) -> Shape:
    """Balls pass the load zone with a period that is not the lead's; each reversal shifts their
    phase."""
    p, key = w.machine.lead[ax] * r.uniform(1.6, 2.7), int(r.integers(2**62))
    phase = np.random.default_rng(key).uniform(0, 2 * np.pi, 4000)
    size = np.random.default_rng(key + 1).uniform(0.4, 1.0, 4000)

    def f(q: Rec) -> Array:
        turns = np.cumsum(np.abs(np.diff(history_sign(q, ax), prepend=0)) > 0)[q.row_at] % 4000
        return size[turns] * np.sin(2 * np.pi * q.pos[:, ax] / p + phase[turns])

    return tool_only(ax, f)


def history_sign(q: Rec, ax: int) -> Array:
    """Direction of an axis's last move at each point of the path."""
    d = np.sign(np.diff(q.via[:, ax], prepend=q.via[0, ax]))
    at = np.maximum.accumulate(np.where(d != 0, np.arange(len(d)), 0))
    return d[at]


@alien
def wrinkle(w: World, r: Rng, ax: int) -> Shape:
    """A wrinkle in a way strip: the carriage pushes it along a little each time it runs over it."""
    c, wide, push, d = (
        r.uniform(0.25, 0.75),
        r.uniform(0.04, 0.12),
        r.uniform(0.01, 0.06),
        sensed(w, r),
    )

    def f(q: Rec) -> Array:
        lo, hi = w.machine.travel[ax]
        via = (q.via[:, ax] - lo) / (hi - lo)
        at, out = c, np.empty(len(via))
        for i in range(len(via)):
            if i and (via[i] - at) * (via[i - 1] - at) < 0:
                at = float(
                    np.clip(
                        at + push * np.sign(via[i] - via[i - 1]) * (0.6 + 0.4 * (i % 2)), 0.1, 0.9
                    )
                )
            out[i] = np.exp(-0.5 * ((via[i] - at) / wide) ** 2)
        return out[q.row_at]

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def footprint(w: World, r: Rng, ax: int) -> Shape:
    """Where the carriage has stood, the bed is warm and bulges, and forgets it in its own time."""
    wide, d = r.uniform(0.04, 0.15), seen_across(w, r, ax)
    tau_share = r.uniform(0.05, 0.4)
    bins = np.linspace(-0.1, 1.1, 49)

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        gap = np.diff(q.t, prepend=q.t[0])
        tau = max(float(np.ptp(q.t)), 1.0) * tau_share
        spots = np.exp(-0.5 * ((s[:, None] - bins) / wide) ** 2)
        heat, out = np.zeros(len(bins)), np.empty(len(s))
        for i in range(len(s)):
            heat = heat * np.exp(-gap[i] / tau)
            out[i] = np.interp(s[i], bins, heat)
            heat = heat + spots[i] * min(gap[i] / tau, 1.0)
        return out

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")
