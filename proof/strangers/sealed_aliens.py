"""Physics without a name in the contract, sealed family.  Do not read while working on the judged
tool.

Sources: Johnson 1985 (Contact mechanics: wheels that creep as they roll), Slocum 1992 (couplings
and turrets that seat anew), Timoshenko 1961 (Theory of elastic stability: snap-through), Armstrong
and Amin 1996 (PID control in the presence of static friction: hunting at rest; Automatica 32),
Terzaghi 1943 (soil that settles under a load, slowly), Den Hartog 1956 (shafts that whirl).
"""

from __future__ import annotations

import numpy as np

from .base import Array, Part, Rec, Rng, Shape, logu, pick
from .forms_time import sensed
from .fresh_aliens import other, seen_across
from .registry import FORMS, Form, tool_only, unit_place
from .world import World, lowpass


def alien(f: Form) -> Form:
    """Decorator that files an alien of the sealed family under a number."""
    k = 1 + sum(n.startswith("alien:sealed-") for n in FORMS)
    FORMS[f"alien:sealed-{k}"] = [(f"sealed-{k}", "sealed", f)]
    return f


def way_gone(q: Rec, ax: int) -> Array:
    """Way an axis has gone since the start of the file, mm, at each row."""
    return np.cumsum(np.abs(np.diff(q.via[:, ax], prepend=q.via[0, ax])))[q.row_at]


@alien
def creeping_roller(w: World, r: Rng, ax: int) -> Shape:
    """A support roller out of round: periodic in the way gone to and fro, not in the place."""
    p = logu(r, 0.03, 0.2) * np.ptp(w.machine.travel[ax])
    p, ph, k = p * np.pi / 3, r.uniform(0, 6.28), r.uniform(0, 0.4)
    d = sensed(w, r)

    def f(q: Rec) -> Array:
        th = 2 * np.pi * way_gone(q, ax) / p
        return np.sin(th + ph) + k * np.sin(2 * th)

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def indexed_seats(w: World, r: Rng, ax: int) -> Shape:
    """A turret or pallet that is indexed every few stops: its 3 to 7 stations come back in turn,
    each with a seat of its own."""
    seats, every = r.normal(size=int(r.integers(3, 8))), int(r.integers(2, 9))
    d = sensed(w, r)

    def f(q: Rec) -> Array:
        if q.kind == "targets":
            count = np.arange(len(q.t))
        else:
            count = np.floor((q.t - q.t[0]) / max(float(np.ptp(q.t)), 1e-9) * 40).astype(int)
        return seats[count // every % len(seats)]

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def snapping_plate(w: World, r: Rng, ax: int) -> Shape:
    """A plate under stress snaps through when the air gets warm enough and back only when it is
    colder by far; it bulges in its middle and dips beside it."""
    lo, hi = np.quantile(w.air, np.sort(r.uniform([0.1, 0.55], [0.45, 0.9])))
    up, state = bool(w.air[0] > (lo + hi) / 2), np.empty(len(w.air))
    for i, x in enumerate(w.air.tolist()):
        up = x > lo if up else x > hi
        state[i] = up
    c, wide, d = r.uniform(0.3, 0.7), r.uniform(0.1, 0.25), sensed(w, r)

    def f(q: Rec) -> Array:
        u = (unit_place(w, ax, q) - c) / wide
        return w.step(state, q.t) * (1 - u**2) * np.exp(-0.5 * u**2)

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def hunting(w: World, r: Rng, ax: int) -> Shape:
    """Integral action against stiction: an axis at rest hunts to and fro in squares of unlike
    length, the slower the farther out it stands; in motion there is nothing."""
    span = max(float(np.ptp(pick(r, w.recs).t)), 1.0)
    p, duty, k = span / r.uniform(6, 40), r.uniform(0.3, 0.7), r.uniform(0.3, 1.5)

    def f(q: Rec) -> Array:
        rest = np.abs(q.vel[:, ax]) < 1e-3
        u = ((q.t - q.t[0]) / p / (1 + k * unit_place(w, ax, q))) % 1.0
        return rest * np.where(u < duty, 1 - duty, -duty)

    return tool_only(ax, f)


@alien
def settling_floor(w: World, r: Rng, ax: int) -> Shape:
    """The floor gives way under the heavy slide, minutes late, and the tool leans by a lever on
    another axis."""
    to, d = other(w, r, ax), seen_across(w, r, ax)
    tau = max(float(np.ptp(pick(r, w.recs).t)), 1.0) * r.uniform(0.05, 0.4)
    lever = r.uniform(0.2, 0.8)

    def f(q: Rec) -> Array:
        lo, hi = w.machine.travel[ax]
        g = np.linspace(q.via_t[0], q.via_t[-1] + 1e-6, 4000)
        load = np.interp(g, q.via_t, (q.via[:, ax] - lo) / (hi - lo))
        late = np.interp(q.t, g, lowpass(load, g[1] - g[0], tau))
        return (late - late.mean()) * (lever + unit_place(w, to, q))

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def whirling_screw(w: World, r: Rng, ax: int) -> Shape:
    """A screw that whirls near one speed only, and most where its free length is longest."""
    share, wide, flip = r.uniform(0.3, 0.9), r.uniform(0.05, 0.2), r.random() < 0.5

    def f(q: Rec) -> Array:
        v = np.abs(q.vel[:, ax])
        if not v.max() > 1e-3:
            return np.zeros(len(v))
        s = unit_place(w, ax, q)
        near = 1 / (1 + ((v / v.max() - share) / wide) ** 2)
        return near * (v > 1e-3) * (1 - s if flip else s) ** 2

    return tool_only(ax, f)
