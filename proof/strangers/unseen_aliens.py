"""Physics without a name in the contract, unseen family.  Do not read while working on the judged
tool.

Sources: ISO 230-4 and Renishaw's manual of the QC20-W ballbar (balls and cups of the bar), Slocum
1992 (preload of nuts and temperature; ways that float on their oil), Mayr et al. 2012 (columns that
bend by heat), Weck and Brecher 2006 (Werkzeugmaschinen 2 and 5: oil films, dirty scales), Rivin
2003 (Passive vibration isolation: pneumatic mounts with levelling valves).
"""

from __future__ import annotations

import numpy as np

from .base import Array, Part, Rec, Rng, Shape, pick
from .forms_time import sensed
from .fresh_aliens import other, seen_across
from .registry import FORMS, Form, tool_only, unit_place
from .world import World, lowpass


def alien(f: Form) -> Form:
    """Decorator that files an alien of the unseen family under a number."""
    k = 1 + sum(n.startswith("alien:unseen-") for n in FORMS)
    FORMS[f"alien:unseen-{k}"] = [(f"unseen-{k}", "unseen", f)]
    return f


@alien
def lobed_ball(w: World, r: Rng, ax: int) -> Shape | None:
    """A ball out of round on the three points of its cup: three or five lobes in the angle of the
    bar, which no axis knows."""
    if not any(q.kind == "ballbar" for q in w.recs):
        return None
    n, ph = int(pick(r, [3, 3, 5])), r.uniform(0, 6.28)

    def field(q: Rec, a: float) -> Part:
        if q.kind != "ballbar":
            return Part()
        i, j = q.meta["plane"]
        angle = np.arctan2(q.meta["unit"][:, j], q.meta["unit"][:, i])
        return Part(reading=a * np.cos(n * angle + ph))

    return Shape(field, "")


@alien
def warm_reversal(w: World, r: Rng, ax: int) -> Shape:
    """Play that a control compensates as it is half-way through the warm-up: too much of it cold,
    too little warm, as the nut's preload goes."""
    heat = lowpass(w.screw[ax], float(w.grid[1]), r.uniform(0.01, 0.1) * float(w.grid[-1]), 0.0)
    t = np.concatenate([q.t for q in w.recs])
    heat = heat - np.median(w.at(heat, t))
    return tool_only(ax, lambda q: -0.5 * q.sgn[:, ax] * w.at(heat, q.t), most=12.0)


@alien
def bending_column(w: World, r: Rng, ax: int) -> Shape:
    """A column that bends as one side of it follows the hall: across, with the square of the
    height, to one side and the other in the course of the day."""
    d, flip = seen_across(w, r, ax), r.random() < 0.5
    end, dt = float(w.grid[-1]), float(w.grid[1])
    skew = w.air - lowpass(w.air, dt, r.uniform(0.05, 0.5) * end)

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return w.at(skew, q.t) * (1 - s if flip else s) ** 2

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "", most=15.0)


@alien
def floating_way(w: World, r: Rng, ax: int) -> Shape:
    """A plain way that floats on its oil: up and aside with the root of the speed, in both
    directions alike."""
    d = seen_across(w, r, ax)
    top = max(float(np.abs(q.vel[:, ax]).max()) for q in w.recs) or 1.0
    return Shape(lambda q, a: Part(tool=a * np.sqrt(np.abs(q.vel[:, ax]) / top)[:, None] * d), "")


@alien
def dirt_on_the_scale(w: World, r: Rng, ax: int) -> Shape:
    """A drop of oil on a scale: from one moment on a stretch as long as the head reads wrong."""
    live = [q for q in w.recs if ax in q.moving] or w.recs
    q0 = pick(r, live)
    t0 = float(q0.t[0] + np.ptp(q0.t) * r.uniform(0.25, 0.6))
    lo, hi = w.machine.travel[ax]
    c = (float(np.quantile(q0.pos[:, ax], r.uniform(0.2, 0.8))) - lo) / (hi - lo)
    wide = r.uniform(0.03, 0.08)

    def f(q: Rec) -> Array:
        u = (unit_place(w, ax, q) - c) / wide
        return (q.t > t0) * np.exp(-0.5 * u**2)

    return tool_only(ax, f)


@alien
def levelling_valves(w: World, r: Rng, ax: int) -> Shape:
    """A machine on air mounts: a heavy slide that moves tips it, and its valves take seconds to
    bring it back to within their dead band; the tool leans by a lever on another axis."""
    to, d = other(w, r, ax), sensed(w, r)
    band, tau, lever = r.uniform(0.01, 0.06), r.uniform(4, 30), r.uniform(0.3, 0.8)

    def f(q: Rec) -> Array:
        x = q.via[:, ax] / np.ptp(w.machine.travel[ax])
        back = 1 - np.exp(-np.diff(q.via_t, prepend=q.via_t[0]) / tau)
        h, out = 0.0, np.empty(len(x))
        for i, (move, k) in enumerate(zip(np.diff(x, prepend=x[0]), back, strict=True)):
            h += move
            h -= k * (h - min(max(h, -band), band))
            out[i] = h
        return out[q.row_at] * (lever + unit_place(w, to, q))

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")
