"""Physics that no name of the contract stands for.  All outside instruments see it (tool)."""

from __future__ import annotations

import numpy as np

from .base import Array, Part, Rec, Rng, Shape, logu, pick
from .forms_time import sensed
from .registry import FORMS, Form, along, tool_only, unit_place
from .world import World

ALIENS: dict[str, tuple[str, Form]] = {}


def alien(name: str, family: str = "open"):
    """Decorator that files an alien."""

    def add(f: Form) -> Form:
        ALIENS[name] = (family, f)
        return f

    return add


def moment(w: World, r: Rng) -> tuple[Rec, float, float]:
    """A file, a time within it and its length, s."""
    q = pick(r, [x for x in w.recs if x.outside] or w.recs)
    span = max(float(np.ptp(q.t)), 1.0)
    return q, float(q.t[0] + span * r.uniform(0.25, 0.75)), span


def in_time(w: World, r: Rng, f) -> Shape:
    """Field uniform over place with time course f(t), along a sensed direction."""
    d = sensed(w, r)
    return Shape(lambda q, a: Part(tool=a * f(q.t)[:, None] * d), "")


@alien("cover_catch")
def cover(w: World, r: Rng, ax: int) -> Shape:
    """A way cover catches beyond one place from one time to another (drags, one direction)."""
    _, t0, span = moment(w, r)
    c, d = r.uniform(0.3, 0.7), span * r.uniform(0.2, 0.5)

    def f(q: Rec) -> Array:
        on = (q.t > t0 - d / 2) & (q.t < t0 + d / 2)
        return -1.0 * on * (q.sgn[:, ax] > 0) * np.clip((unit_place(w, ax, q) - c) / 0.08, 0, 1)

    return tool_only(ax, f)


@alien("hydraulic_sawtooth")
def hydraulic(w: World, r: Rng, ax: int) -> Shape:
    """Accumulator pressure: slow loss, sudden refill (relaxation oscillation in time)."""
    _, _, span = moment(w, r)
    p, ph = span * r.uniform(0.07, 0.4), r.uniform(0, 1)
    return in_time(w, r, lambda t: (t / p + ph) % 1.0)


@alien("gib_rock")
def gib(w: World, r: Rng, ax: int) -> Shape:
    """The slide tips within its gib after each start and comes back slowly, growing with speed."""
    tau = logu(r, 3, 60)

    def f(q: Rec) -> Array:
        sp = np.clip(q.feed / max(w.machine.vmax, 1), 0.05, 1) ** 0.5
        k = np.cumsum(np.abs(np.diff(q.sgn[:, ax], prepend=0)) > 0)
        return sp * np.exp(-q.revt[:, ax] / tau) * (1 + 0.5 * (k % 2))

    to = pick(r, [a for a in w.machine.axes if a != ax])
    return Shape(lambda q, a: Part(tool=a * (along(q, ax, f(q)) + along(q, to, 0.7 * f(q)))), "")


@alien("speed_times_place")
def speed_place(w: World, r: Rng, ax: int) -> Shape:
    """Error as feed x place: lubricant film that thickens with speed at one end only."""

    def f(q: Rec) -> Array:
        sp = q.vel[:, ax] / 20 if q.kind in ("trace", "ballbar") else q.feed / 3000
        return np.abs(sp) * (unit_place(w, ax, q) - 0.3) ** 2

    return tool_only(ax, f)


@alien("crane")
def crane(w: World, r: Rng, ax: int) -> Shape:
    """The foundation tilts while a crane passes: a bump in time times a lever over place."""
    _, t0, span = moment(w, r)
    d = span * r.uniform(0.03, 0.1)
    to = sensed(w, r)

    def f(q: Rec) -> Array:
        return np.exp(-0.5 * ((q.t - t0) / d) ** 2) * (0.3 + unit_place(w, ax, q))

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * to), "")


@alien("cable_chain")
def chain(w: World, r: Rng, ax: int) -> Shape:
    """Drag of a cable chain: depends on place, direction and their product, with a fold."""
    c = r.uniform(0.35, 0.65)

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return np.abs(s - c) ** 1.5 * (q.sgn[:, ax] > 0) - 0.5 * (s > c) * (q.sgn[:, ax] < 0)

    return tool_only(ax, f)


@alien("coolant_level")
def coolant(w: World, r: Rng, ax: int) -> Shape:
    """The tank in the bed empties and is filled: weight moves, steps and slopes in time."""
    _, t0, span = moment(w, r)
    return in_time(w, r, lambda t: np.where(t < t0, -(t - t0) / span, 0.9 - 0.8 * (t - t0) / span))


@alien("sun_patch")
def sun(w: World, r: Rng, ax: int) -> Shape:
    """A patch of sun bends the bed: warm for a while, curvature over place."""
    _, t0, span = moment(w, r)
    d, to = span * r.uniform(0.1, 0.25), sensed(w, r)

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return np.exp(-0.5 * ((q.t - t0) / d) ** 2) * (4 * s * (1 - s) + s - 0.3)

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * to), "")


@alien("gear_beat")
def gear(w: World, r: Rng, ax: int) -> Shape:
    """Two gears mesh with nearly equal periods that no lead explains: a beat over place."""
    p = np.ptp(w.machine.travel[ax]) / r.uniform(5, 14)
    k = r.uniform(1.05, 1.2)

    def f(q: Rec) -> Array:
        x = q.pos[:, ax]
        return 0.5 * (np.sin(2 * np.pi * x / p) + np.sin(2 * np.pi * k * x / p + 1.0))

    return tool_only(ax, f)


@alien("clamp_slip")
def clamp(w: World, r: Rng, ax: int) -> Shape:
    """Fixture clamp slips by a little at every strong move since the start, then saturates."""
    d, n = sensed(w, r), r.uniform(20, 200)

    def f(q: Rec) -> Array:
        cum = np.cumsum(np.linalg.norm(np.diff(q.via, axis=0, prepend=q.via[:1]), axis=1))
        s = cum[q.row_at] / max(float(cum[-1]), 1e-9)
        return np.tanh(3 * s) + 0.3 * np.sin(n / 20 * s)

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien("floor_joint", "held")
def joint(w: World, r: Rng, ax: int) -> Shape:
    """The bed rests on two slabs: passing the joint tips it, and it stays tipped on return."""
    c, wide = r.uniform(0.4, 0.6), r.uniform(0.1, 0.25)
    to = sensed(w, r)

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q) + wide / 2 * -q.sgn[:, ax]
        return 1 / (1 + np.exp(-(s - c) / 0.01))

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * to), "")


@alien("oil_film", "held")
def film(w: World, r: Rng, ax: int) -> Shape:
    """The slide sinks while it rests and floats when it moves (squeeze film)."""
    tau = logu(r, 2, 40)
    d = sensed(w, r)

    def f(q: Rec) -> Array:
        gap = np.diff(q.t, prepend=q.t[0])
        y, s = np.empty(len(gap)), 0.0
        move = np.linalg.norm(np.diff(q.pos, axis=0, prepend=q.pos[:1]), axis=1)
        for i in range(len(gap)):
            s = s * np.exp(-gap[i] / tau) + min(move[i] / 50, 1.0) * (1 - s)
            y[i] = s
        return y

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien("door_interlock", "held")
def interlock(w: World, r: Rng, ax: int) -> Shape:
    """A door hangs on the column: three openings shift it by unequal amounts and back."""
    _, _, span = moment(w, r)
    q = pick(r, w.recs)
    at = np.sort(q.t[0] + span * r.uniform(0.05, 0.9, 3))
    size, d = r.uniform(0.4, 1, 3), span * r.uniform(0.05, 0.12)
    return in_time(
        w, r, lambda t: sum(a * ((t > x) & (t < x + d)) for a, x in zip(size, at, strict=False))
    )


@alien("air_bearing_hammer", "held")
def hammer(w: World, r: Rng, ax: int) -> Shape:
    """Air hammer sets in beyond one place: mean shift that flutters with a drifting rhythm."""
    c, p = r.uniform(0.4, 0.7), logu(r, 3, 40)

    def f(q: Rec) -> Array:
        on = unit_place(w, ax, q) > c
        t = q.t - q.t[0]
        return on * (0.6 + 0.4 * np.sign(np.sin(2 * np.pi * t / p * (1 + 0.2 * t / (t[-1] + 1)))))

    return tool_only(ax, f)


@alien("magnet_cogging_load", "held")
def cogging(w: World, r: Rng, ax: int) -> Shape:
    """Linear-motor cogging whose size follows the coil temperature and the other axis's place."""
    p, other = r.uniform(17, 61), pick(r, [a for a in w.machine.axes if a != ax])

    def f(q: Rec) -> Array:
        k = 0.4 + w.at(w.screw[ax], q.t) / max(float(w.screw[ax].max()), 1e-9)
        k = k * (0.5 + unit_place(w, other, q))
        return k * np.sin(2 * np.pi * q.pos[:, ax] / p) ** 3

    return tool_only(ax, f)


@alien("memory_of_rest", "held")
def memory(w: World, r: Rng, ax: int) -> Shape:
    """After-effect: the place visited long before pulls back (viscoelastic bellows)."""
    tau = logu(r, 20, 400)

    def f(q: Rec) -> Array:
        x, dt = q.via[:, ax], np.diff(q.via_t, prepend=q.via_t[0])
        y, s = np.empty(len(x)), x[0]
        for i in range(len(x)):
            s = x[i] + (s - x[i]) * np.exp(-dt[i] / tau)
            y[i] = s
        return (y - x)[q.row_at] / 100

    return tool_only(ax, f)


@alien("spring_counterweight", "held")
def counter(w: World, r: Rng, ax: int) -> Shape:
    """A counterweight chain: pendulum that each start excites, minutes to die, over place."""
    hz, tau = logu(r, 0.05, 0.4), logu(r, 20, 120)

    def f(q: Rec) -> Array:
        t = q.revt[:, ax]
        return np.cos(2 * np.pi * hz * t) * np.exp(-t / tau) * (0.3 + unit_place(w, ax, q))

    return tool_only(ax, f)


for _name, (_fam, _f) in ALIENS.items():
    FORMS.setdefault("alien:" + _name, []).append((_name, _fam, _f))
