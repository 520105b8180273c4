"""Physics without a name in the contract, later family.  Do not read while working on the judged
tool.

Sources: Altintas et al. 2011 (Machine tool feed drives; CIRP Annals 60/2: a screw drive's natural
frequency goes with the free length), Erkorkmaz and Kamalzadeh 2006 (the same, measured), Malkin and
Guo 2008 and Den Hartog 1956 (a wheel that coasts down passes a resonance), Mayr et al. 2012 and
Weck and Brecher 2006 (coolant whose temperature swings flows along a bed), Slocum 1992 (a saddle in
two ways rests on one diagonal of its pads or on the other; carriages that bend under loads), Rivin
1999 (Stiffness and damping: gibs, a headstock that shakes itself askew at one speed), Heidenhain's
notes on tape scales (a tape that slips in its clamps), ISO 10360-5 and Renishaw's notes on styli
(a loose stylus).

Each says why no name of the contract stands for it.
"""

from __future__ import annotations

import numpy as np

from .base import Array, Part, Rec, Rng, Shape, pick, stream
from .forms_time import sensed
from .fresh_aliens import other
from .later_servo import fastest, in_motion
from .registry import FORMS, Form, both, unit_place
from .world import World


def alien(f: Form) -> Form:
    """Decorator that files an alien of the later family under a number."""
    k = 1 + sum(n.startswith("alien:later-") for n in FORMS)
    FORMS[f"alien:later-{k}"] = [(f"later-{k}", "later", f)]
    return f


def within(q: Rec, ax: int) -> Array:
    """Place of an axis as 0..1 of what it does in the file; 0.5 where it stands."""
    x = q.pos[:, ax]
    return (x - x.min()) / np.ptp(x) if np.ptp(x) > 1e-6 else np.full(len(x), 0.5)


@alien
def hums_with_the_place(w: World, r: Rng, ax: int) -> Shape | None:
    """A position loop at its limit: the slide hums, two to four times as fast at one end of its way
    as at the other.  `vibration` has one frequency, `cyclic` does not go on with time."""
    top = fastest(w, 1 / 12)
    if top is None or not any(in_motion(q) and ax in q.moving for q in w.recs):
        return None
    f0, k, flip = min(top, 10.0) * r.uniform(0.5, 1.0), r.uniform(1.0, 2.5), r.random() < 0.5

    def f(q: Rec) -> Array:
        if not in_motion(q) or ax not in q.moving:
            return np.zeros(len(q.t))
        s = within(q, ax)
        hz = f0 * (1 + k * (1 - s if flip else s))
        turns = np.cumsum(hz * np.diff(q.t, prepend=q.t[0]))
        return np.sin(2 * np.pi * turns)

    return both(ax, f)


@alien
def coasting_wheel(w: World, r: Rng, ax: int) -> Shape | None:
    """A grinding wheel out of balance that coasts down through a broad resonance, again and again.
    `vibration` has one frequency; this one sweeps over three octaves."""
    top = fastest(w, 1 / 3)
    if top is None or not any(in_motion(q) and q.outside for q in w.recs):
        return None
    hz, zeta, d, key = min(top, 30.0), r.uniform(0.25, 0.5), sensed(w, r), int(r.integers(2**62))
    peak = hz * r.uniform(0.25, 0.6)

    def f(q: Rec) -> Array:
        g = stream(key, q.name)
        span = max(float(np.ptp(q.t)), 1e-9)
        u = (((q.t - q.t[0]) / span) * g.uniform(1.0, 3.0) + g.uniform(0, 0.5)) % 1.0
        now = hz * 2.0 ** (-3 * u)
        turns = np.cumsum(now * np.diff(q.t, prepend=q.t[0]))
        x = now / peak
        gain = x**2 / np.sqrt((1 - x**2) ** 2 + (2 * zeta * x) ** 2)
        return gain * np.sin(2 * np.pi * turns)

    return Shape(
        lambda q, a: Part(tool=a * f(q)[:, None] * d) if in_motion(q) else Part(), "", most=60.0
    )


def long_tests(w: World, ax: int) -> list[Rec]:
    """Files at rest in which an axis goes to three places or more."""
    return [
        q
        for q in w.recs
        if q.kind == "targets"
        and q.meta["quantity"] != "angle"
        and len(np.unique(np.round(q.pos[:, ax], 2))) > 2
    ]


@alien
def wave_along_the_bed(w: World, r: Rng, ax: int) -> Shape | None:
    """Coolant that is warm and cool by turns flows down a channel of the bed: a wave that travels.
    `structure_drift` is one course for all places, `screw_heat` a growth from one end."""
    mine = long_tests(w, ax)
    if not mine:
        return None
    period = max(float(np.ptp(q.t)) for q in mine) / r.uniform(2.5, 7)
    waves, ph, d = r.uniform(0.8, 1.7) * pick(r, [-1, 1]), r.uniform(0, 6.28), sensed(w, r)

    def f(q: Rec) -> Array:
        return np.cos(2 * np.pi * (q.t / period - waves * unit_place(w, ax, q)) + ph)

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def diagonal_pads(w: World, r: Rng, ax: int) -> Shape | None:
    """A saddle with clearance in two ways leans on one diagonal of its pads if both axes last went
    the same way, on the other if not.  `backlash` of either axis adds up, this multiplies."""
    to, d = other(w, r, ax), sensed(w, r)
    seen = [q for q in w.recs if q.outside and (ax in q.moving or to in q.moving)]
    if not seen or any(ax not in q.moving or to not in q.moving for q in seen):
        return None
    if not any(in_motion(q) for q in seen) or any(q.kind == "features" for q in seen):
        return None
    soon = r.uniform(0.02, 0.6)

    def side(q: Rec, a: int) -> Array:
        return q.sgn[:, a] * (1 - 2 * np.exp(-q.since[:, a] / soon))

    return Shape(lambda q, a: Part(tool=a * (side(q, ax) * side(q, to))[:, None] * d), "")


@alien
def askew_at_one_speed(w: World, r: Rng, ax: int) -> Shape | None:
    """A headstock that shakes itself askew at one speed of the spindle and at no other, slower or
    faster: to one side at one end of the travel, to the other at the other.  `spindle_growth` goes
    up with speed and with minutes, `step_loss` and drift are the same everywhere."""
    ways = [
        (q, v)
        for q in long_tests(w, ax)
        for v in np.unique(w.step(w.rpm, q.t))
        if v > 0 and 0.15 < np.mean(w.step(w.rpm, q.t) == v) < 0.7
    ]
    if not ways:
        return None
    _, bad = pick(r, ways)
    d, c = sensed(w, r), r.uniform(0.4, 0.6)

    def f(q: Rec) -> Array:
        return (w.step(w.rpm, q.t) == bad) * (within(q, ax) - c)

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "")


@alien
def bends_with_the_load(w: World, r: Rng, ax: int) -> Shape | None:
    """A carriage whose angle is of the second order in its place and in its load, against what the
    map was made under: up in the middle and down at the ends, or the other way round, whatever the
    sign of the load.  `force_compliance` gives way to the side of the load; `abbe`, `bow` and `sag`
    know no load."""
    mine = [q for q in long_tests(w, ax) if len(q.t) > 15]
    if not w.load[ax].any() or not mine:
        return None
    d, top = sensed(w, r), float(np.abs(w.load[ax]).max())
    usual = float(np.mean(np.concatenate([(w.force(q, ax) / top) ** 2 for q in mine])))

    def f(q: Rec) -> Array:
        u = 2 * within(q, ax) - 1
        return ((w.force(q, ax) / top) ** 2 - usual) * (3 * u**2 - 1) / 2

    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "", most=60.0)


@alien
def slipping_tape(w: World, r: Rng, ax: int) -> Shape | None:
    """A tape scale between two clamps that slip by turns: the scale's slope about its middle jumps
    up and down 4 to 9 times.  `scale` stays, `screw_heat` and `laser_air` go with heat and weather,
    `step_loss` is the same at all places."""
    mine = long_tests(w, ax)
    if not mine:
        return None
    q0 = max(mine, key=lambda q: float(np.ptp(q.t)))
    n = int(r.integers(4, 10))
    at = q0.t[0] + np.ptp(q0.t) * np.sort(r.uniform(0.05, 0.95, n))
    level = np.cumsum(np.r_[0.0, (-1.0) ** np.arange(n) * r.uniform(0.5, 1.5, n)])
    level = level - level.mean()

    def field(q: Rec, a: float) -> Part:
        out = np.zeros((len(q.t), 3))
        out[:, ax] = a * level[np.searchsorted(at, q.t)] * (unit_place(w, ax, q) - 0.5)
        return Part(tool=out)

    return Shape(field, "", most=200.0)


@alien
def loose_stylus(w: World, r: Rng, ax: int) -> Shape | None:
    """The stylus of the CMM's probe is loose and loosens further: the first touch after another
    axis or kind of feature is off by turns, what is read again less so.  `tool_size` and
    `tool_wear` go with the tool's radius in all features alike, `scale` with the length."""
    parts = [q for q in w.recs if q.kind == "features"]
    if not parts:
        return None
    fade = r.uniform(0.1, 0.5)

    def off(q: Rec) -> Array:
        info = q.meta["info"]
        key, count, out = None, 0, np.empty(len(info))
        for i, (_, kind, axis, _, _, reading, _) in enumerate(info):
            if (kind, axis) != key:
                key, count = (kind, axis), count + 1
            out[i] = (1 if count % 3 == 1 else -1) * fade ** (reading - 1) * (1 + 3 * i / len(info))
        return out

    for q in parts:  # a pattern that the tool's radius tells as well is none
        y, rad = off(q), q.meta["radial"]
        size = np.array([i[3] for i in q.meta["info"]])
        known = np.c_[rad, rad * q.meta["part"], size]
        rest = y - known @ np.linalg.lstsq(known, y, rcond=None)[0]
        if rest.var() < 0.4 * y.var():
            return None
    return Shape(lambda q, a: Part(reading=a * off(q)) if q.kind == "features" else Part(), "")
