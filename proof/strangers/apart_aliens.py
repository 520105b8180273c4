"""Physics without a name in the contract, apart family.  Do not read while working on the judged
tool.

Sources: Mayr et al. 2012 and Weck and Brecher 2006 (columns that lean as they warm up; plates that
warp), Schwenke et al. 2008 (machines that are not rigid bodies), Slocum 1992 (carriages that crab
on a worn way; pads and seals), Koren 1980 (cross-coupled control), Altintas et al. 2011 (CIRP
Annals 60/2: stiffness and so the loop goes with the place), Erkorkmaz and Altintas 2001 (one axis
disturbs another), ISO/TR 16015 (lengths measured while the temperature varies), buses that are
congested by bursts (IEEE 1588).

Each says why no name of the contract stands for it.
"""

from __future__ import annotations

import numpy as np

from .base import AX, Array, Part, Rec, Rng, Shape, pick, stream
from .forms_time import sensed
from .registry import FORMS, Form, along, both, moving
from .world import World


def alien(f: Form) -> Form:
    """Decorator that files an alien of the apart family under a number."""
    k = 1 + sum(n.startswith("alien:apart-") for n in FORMS)
    FORMS[f"alien:apart-{k}"] = [(f"apart-{k}", "apart", f)]
    return f


def together(w: World, ax: int) -> list[Rec]:
    """Outside files in which an axis and another one move."""
    return [q for q in w.recs if q.outside and ax in q.moving and len(q.moving) > 1]


def centred(q: Rec, ax: int) -> Array:
    """Place of an axis as -1..1 of what it does in the file, 0 where it stands."""
    x = q.pos[:, ax]
    return 2 * (x - x.min()) / np.ptp(x) - 1 if np.ptp(x) > 1e-6 else np.zeros(len(x))


def neighbour(q: Rec, ax: int) -> int | None:
    """The first other axis that moves in a file."""
    return next((a for a in q.moving if a != ax), None)


@alien
def warm_column(w: World, r: Rng, ax: int) -> Shape | None:
    """A column that leans to and fro as one side of it warms and cools: an angle between two axes
    that is another one each time.  `squareness` stays, `structure_drift` is alike everywhere."""
    seen = [q for q in together(w, ax) if q.kind in ("ballbar", "trace")]
    if len(seen) < 3:
        return None
    hour = {q.name: v for q, v in zip(seen, _even_out(r.normal(size=len(seen))), strict=True)}

    def field(q: Rec, a: float) -> Part:
        to = neighbour(q, ax)
        if q.name not in hour or to is None:
            return Part()
        return Part(tool=along(q, to, a * hour[q.name] * centred(q, ax)))

    return Shape(field, "")


def _even_out(x: Array) -> Array:
    """Mean 0, largest 1."""
    x = x - x.mean()
    return x / max(float(np.abs(x).max()), 1e-9)


@alien
def warped_plate(w: World, r: Rng, ax: int) -> Shape | None:
    """A table that is warped: an error that is a wave in one axis times a wave in another.  Names
    of the contract are sums of what single axes do, or a rotation of one of them."""
    seen, d = [q for q in together(w, ax) if q.kind in ("trace", "targets")], sensed(w, r)
    if not seen or any(q not in seen for q in w.recs if q.outside):
        return None
    n, ph = r.uniform(0.8, 1.3, 2), r.uniform(-0.4, 0.4, 2)

    def f(q: Rec) -> Array:
        to = neighbour(q, ax)
        if to is None:
            return np.zeros(len(q.t))
        u, v = centred(q, ax), centred(q, to)
        return np.sin(np.pi * n[0] * u + ph[0]) * np.sin(np.pi * n[1] * v + ph[1])

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def crabbing(w: World, r: Rng, ax: int) -> Shape | None:
    """A carriage that crabs on a worn way: pushed aside one way going out and the other way coming
    back, by a wave over its place.  `bow` knows no direction, `backlash` that of its own axis."""
    seen = [q for q in w.recs if q.kind == "targets" and ax in q.moving and len(q.moving) == 1]
    seen = [q for q in seen if q.meta["quantity"] == "straightness" and len(q.t) > 15]
    if not any(len(set(q.sgn[:, ax])) > 1 for q in seen):
        return None
    d, n, ph = sensed(w, r), r.uniform(0.9, 1.4), r.uniform(-0.4, 0.4)
    d[ax] = 0.0

    def f(q: Rec) -> Array:
        return q.sgn[:, ax] * np.sin(np.pi * n * centred(q, ax) + ph)

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def cross_coupled(w: World, r: Rng, ax: int) -> Shape | None:
    """A control that couples two axes the wrong way: one follows the speed of the other one.
    `servo_lag` and `servo_mismatch` go with an axis's own speed, `squareness` with place."""
    to = next((a for q in w.recs for a in q.moving if a != ax and ax in q.moving), None)
    if to is None or not any(q.kind in ("trace", "ballbar") for q in w.recs):
        return None

    def field(q: Rec, a: float) -> Part:
        v = along(q, to, a * q.vel[:, ax])
        return Part(tool=v, scale=v)

    return Shape(field, "")


@alien
def pushed_by_the_neighbour(w: World, r: Rng, ax: int) -> Shape | None:
    """An axis that is pushed to one side while another one is in motion, whichever way that goes,
    and comes back as it stops.  Friction of the contract turns round with the direction."""
    to = next((a for q in w.recs for a in q.moving if a != ax and ax in q.moving), None)
    seen = [q for q in w.recs if q.kind == "trace" and to in q.moving]
    if to is None or not any(0.15 < np.mean(moving(q, to) != 0) < 0.85 for q in seen):
        return None

    def f(q: Rec) -> Array:
        return np.abs(moving(q, to)) * (q.kind == "trace")

    return both(ax, f)


@alien
def swinging_room(w: World, r: Rng, ax: int) -> Shape | None:
    """A CMM whose room warms and cools by turns while the parts are measured: lengths swell and
    shrink in the order in which they were read.  `scale` is alike for all, `tool_size` and
    `tool_wear` go with the radius."""
    parts = [q for q in w.recs if q.kind == "features"]
    if not parts:
        return None
    n, ph = r.uniform(1.5, 5), r.uniform(0, 6.28)

    def f(q: Rec) -> Array:
        size = np.array([i[3] for i in q.meta["info"]])
        order = np.arange(len(size)) / len(size)
        return size / size.max() * np.sin(2 * np.pi * n * order + ph)

    if any(_told_by_names(q, f(q)) for q in parts):
        return None
    return Shape(lambda q, a: Part(reading=a * f(q)) if q.kind == "features" else Part(), "")


def _told_by_names(q: Rec, y: Array) -> bool:
    """Whether lengths along each axis, the radius and its wear tell most of a pattern."""
    info, rad = q.meta["info"], q.meta["radial"]
    size, axis = np.array([i[3] for i in info]), np.array([i[2] for i in info])
    lengths = [size * (axis == a) for a in np.unique(axis)]
    known = np.c_[rad, rad * q.meta["part"], np.stack(lengths, 1)]
    rest = y - known @ np.linalg.lstsq(known, y, rcond=None)[0]
    return bool(rest.var() < 0.5 * y.var())


@alien
def congested_bus(w: World, r: Rng, ax: int) -> Shape | None:
    """A bus that is congested by bursts: readings are late for a second or so, and in time again.
    `delay` is always there, `clock_skew` grows."""
    if not any(q.kind == "trace" for q in w.recs):
        return None
    key, share = int(r.integers(2**62)), r.uniform(0.2, 0.4)

    def field(q: Rec, a: float) -> Part:
        if q.kind != "trace":
            return Part()
        g, span = stream(key, q.name), max(float(np.ptp(q.t)), 1e-9)
        n = int(np.clip(span / 2.5, 4, 20))
        start = (np.arange(n) + g.uniform(0, 1 - share, n)) / n * span
        u = (q.t - q.t[0])[:, None] - start
        late = ((u >= 0) & (u < share * span / n)) @ g.uniform(0.6, 1.4, n)
        return Part(reading=-a * q.vel * late[:, None])

    return Shape(field, "")


@alien
def gain_by_place(w: World, r: Rng, ax: int) -> Shape | None:
    """A drive that is soft at one end of the way and stiff at the other, its gain set for the
    middle: it lags at one end and leads at the other.  `servo_lag` is alike at all places."""
    seen = [q for q in w.recs if q.kind == "trace" and ax in q.moving]
    if not seen:
        return None
    sign = pick(r, [-1.0, 1.0])

    def f(q: Rec) -> Array:
        return sign * q.vel[:, ax] * centred(q, ax) * (q.kind == "trace")

    return both(ax, f, axis=AX[ax])
