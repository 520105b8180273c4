"""Friction and lost motion of the distant family. Do not read while working on the judged tool.

Signs and what sees what as in forms_motion. Sources: Slocum 1992 and Weck and Brecher 2006 (play in
nut and thrust bearing; screws between two bearings give way most in the middle), Renishaw's manual
of the QC20-W ballbar (play that is compensated too much; spikes in one sense), Ramberg and Osgood
1943 and Masing 1926 (a hyperbola, doubled after a reversal), Gates' design manual (belts:
hysteresis and creep), Armstrong-Helouvry, Dupont and Canudas de Wit 1994 (break-away, rise of
static friction with dwell time), Al-Bender and Swevers 2008 (Characterization of friction force
dynamics; IEEE Control Systems 28: pre-sliding, spikes that come after a way), Groß, Hamann and
Wiegärtner 2001 (Elektrische Vorschubantriebe: integral action takes over), Bo and Pavelescu 1982
(stick-slip dies out with speed), Polacek and Vavra 1967 (saw and bow of a slide's creep), Lee et
al. 2015 (friction by the load), Moore 1959 (grease that is worked), Merritt 1967 (dampers),
Stribeck 1902 (seals).

Each form says in one line what tells it from its neighbours.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline

from .base import Array, Rec, Rng, Shape, logu, pick
from .forms_motion import dahl
from .registry import both, distant, moving, tool_only, unit_place
from .world import World


@distant("backlash")
def nut_and_bearing(w: World, r: Rng, ax: int) -> Shape:
    """Play in the nut at once, and that of the thrust bearing when the screw has gone 2 to 20 um
    further (Slocum 1992).  Tells: the same size all along, whole after some hundredths."""
    k, s0 = r.uniform(0.7, 0.92), logu(r, 0.002, 0.015)

    def f(q: Rec) -> Array:
        taken = k + (1 - k) * np.clip(q.since[:, ax] / s0 - 0.5, 0, 1)
        return -0.5 * q.sgn[:, ax] * (2 * taken - 1)

    return tool_only(ax, f, params=lambda a: {"size_um": a})


@distant("backlash")
def compensated_too_much(w: World, r: Rng, ax: int) -> Shape:
    """Play that the control takes out by more than there is: the table is ahead after a reversal
    (ballbar manual: negative backlash).  Tells: a step of one size, of the other sign."""
    s0 = logu(r, 0.001, 0.01)
    return tool_only(
        ax,
        lambda q: 0.5 * q.sgn[:, ax] * (1 - 2 * np.exp(-q.since[:, ax] / s0)),
        params=lambda a: {"size_um": -a},
    )


def _play_by_place(w: World, r: Rng, ax: int, g: Callable[[Array], Array]) -> Shape:
    return tool_only(ax, lambda q: -0.5 * q.sgn[:, ax] * g(unit_place(w, ax, q)))


@distant("backlash_position")
def screw_gives_way(w: World, r: Rng, ax: int) -> Shape:
    """Friction of the guides over a screw between two bearings: least at its ends, most in the
    middle, s (1 - s), on a tenth to a third that stays (Weck and Brecher 2006).  Tells: both ways
    differ by an arch, their mean does not."""
    k, c = r.uniform(0.1, 0.35), r.uniform(-0.1, 0.1)
    return _play_by_place(w, r, ax, lambda s: k + (1 - k) * 4 * (s + c) * (1 - s - c))


@distant("backlash_position")
def two_fixtures(w: World, r: Rng, ax: int) -> Shape:
    """A nut and screw worn at two places, where two fixtures stand (Slocum 1992).  Tells: both ways
    part at two places by unlike amounts, and hardly elsewhere."""
    at, wide = np.array([r.uniform(0.15, 0.4), r.uniform(0.6, 0.85)]), r.uniform(0.06, 0.12, 2)
    deep, rest = np.array([1.0, r.uniform(0.4, 0.8)])[r.permutation(2)], r.uniform(0.05, 0.25)
    return _play_by_place(
        w, r, ax, lambda s: rest + np.exp(-0.5 * ((s[:, None] - at) / wide) ** 2) @ deep
    )


@distant("backlash_position")
def tight_spot(w: World, r: Rng, ax: int) -> Shape:
    """A screw that is bent or dented: no play at one place, its full play elsewhere (Slocum 1992).
    Tells: both ways meet at one place only."""
    c, wide, k = r.uniform(0.25, 0.75), r.uniform(0.08, 0.2), r.uniform(0.8, 1.0)
    return _play_by_place(w, r, ax, lambda s: 1 - k * np.exp(-0.5 * ((s - c) / wide) ** 2))


def hyperbola(cmd: Array, s0: float) -> Array:
    """State in -1..1 that follows d / (s0 + d) of the way d (mm) from rest, and its double at half
    the way after each reversal (Masing), never beyond +-1."""
    way = np.diff(cmd, prepend=cmd[0]).tolist()
    z, z0, d, last, new, out = 0.0, 0.0, 0.0, 0.0, True, []
    for h in way:
        if h:
            sign = 1.0 if h > 0 else -1.0
            if sign != last:
                new, z0, d, last = last == 0.0, z, 0.0, sign
            d += abs(h)
            rise = d / (s0 + d) if new else 2 * d / (2 * s0 + d)
            z = max(-1.0, min(1.0, z0 + sign * rise))
        out.append(z)
    return np.array(out)


@distant("windup")
def masing_hyperbola(w: World, r: Rng, ax: int) -> Shape:
    """Joints and balls that yield one after the other, a hyperbola of the way with reach 10 um to
    0.5 mm, doubled after a reversal (Ramberg and Osgood; Masing).  Tells: half of it in the first
    reach behind a reversal, a long tail."""
    s0 = logu(r, 0.01, 0.5)
    return tool_only(ax, lambda q: -hyperbola(q.via[:, ax], s0)[q.row_at])


@distant("windup")
def belt_creeps(w: World, r: Rng, ax: int) -> Shape:
    """A belt or coupling that winds up over 0.05 to 2 mm and gives back a tenth to a quarter within
    seconds (Gates).  Tells: builds up with the way from a reversal; some of it dies with time."""
    s0, k, tau = logu(r, 0.05, 2.0), r.uniform(0.08, 0.25), logu(r, 2, 40)

    def f(q: Rec) -> Array:
        left = 1 - k * -np.expm1(-q.revt[:, ax] / tau)
        return -dahl(q.via[:, ax], s0)[q.row_at] * left

    return tool_only(ax, f)


def seen_fast(w: World) -> float:
    """Shortest time between two samples of any file in motion, s; 0 if there is none."""
    dt = [float(np.median(np.diff(q.t))) for q in w.recs if q.kind in ("trace", "ballbar")]
    return min(dt, default=0.0)


def resolved(w: World, ax: int) -> float:
    """Way (mm) behind a reversal within which some file in motion takes two samples."""
    ways = []
    for q in w.recs:
        if q.kind == "trace" and ax in q.moving:
            return 0.0
        if q.kind == "ballbar" and ax in q.meta["plane"]:
            step = 2 * np.pi * len(np.unique(q.run)) / len(q.t)
            ways.append(q.meta["radius"] * (1 - np.cos(2 * step)))
    return float(min(ways, default=0.0))


@distant("reversal_spike")
def integral_takes_over(w: World, r: Rng, ax: int) -> Shape | None:
    """The slide hangs until the speed loop's integral has built up and lags no more after three to
    eight times as long: the difference of two exponentials of time (Groß et al. 2001).  Tells: zero
    again within a second, in all reversals alike."""
    if not seen_fast(w):
        return None
    t1 = max(logu(r, 0.008, 0.06), 2 * seen_fast(w))
    t2 = t1 * r.uniform(3, 8)

    def f(q: Rec) -> Array:
        if q.kind not in ("trace", "ballbar"):
            return np.zeros(len(q.t))
        t = q.revt[:, ax]
        return -q.sgn[:, ax] * (np.exp(-t / t2) - np.exp(-t / t1))

    return both(ax, f)


@distant("reversal_spike")
def builds_and_breaks(w: World, r: Rng, ax: int) -> Shape | None:
    """Pre-sliding builds up over 20 um to 0.4 mm, then the slide breaks away and the lag is gone
    within half as much: late spikes (Al-Bender and Swevers 2008).  Tells: a
    slope and a cliff by the way from the reversal."""
    if not seen_fast(w):
        return None
    s1 = max(logu(r, 0.02, 0.4), resolved(w, ax))
    s2 = s1 * r.uniform(0.2, 0.6)

    def f(q: Rec) -> Array:
        if q.kind not in ("trace", "ballbar"):
            return np.zeros(len(q.t))
        s = q.since[:, ax]
        return -q.sgn[:, ax] * np.where(s < s1, s / s1, np.exp(-np.maximum(s - s1, 0) / s2))

    return both(ax, f)


@distant("reversal_spike")
def one_side_more(w: World, r: Rng, ax: int) -> Shape | None:
    """Spikes that are full where a weight has to be lifted and a tenth to a half where it helps
    (ballbar manual).  Tells: a spike at one quadrant, little at the one across."""
    if not seen_fast(w):
        return None
    s0, k, up = logu(r, 0.03, 0.8), r.uniform(0.1, 0.5), pick(r, [-1.0, 1.0])
    s0 = max(s0, resolved(w, ax))

    def f(q: Rec) -> Array:
        if q.kind not in ("trace", "ballbar"):
            return np.zeros(len(q.t))
        g = q.sgn[:, ax]
        return -g * np.where(g * up > 0, 1.0, k) * np.exp(-q.since[:, ax] / s0)

    return both(ax, f)


def crawl(w: World, ax: int) -> tuple[float, float, float] | None:
    """Slow and usual speed (mm/s) and sampling time (s) at which files in motion see an axis creep;
    None where none does."""
    files = [q for q in w.recs if q.kind == "trace" and ax in q.moving]
    v = np.concatenate([np.abs(q.vel[:, ax]) for q in files]) if files else np.zeros(0)
    v = v[(v > 0.05) & (v < 10)]
    if len(v) < 400:
        return None
    low, mid = np.quantile(v, [0.25, 0.6])
    return float(low), float(mid), max(1 / q.meta["rate"] for q in files)


def slow(q: Rec, ax: int, top: float) -> Array:
    """1 where the axis creeps below `top` mm/s, 0 where it stands or is fast."""
    v = np.abs(q.vel[:, ax])
    return ((v > 1e-3) & (v < top)) * 1.0


@distant("stick_slip")
def first_slip_is_largest(w: World, r: Rng, ax: int) -> Shape | None:
    """A saw whose first teeth after each rest are up to twice as high, as static friction grows
    with dwell (Armstrong-Helouvry et al. 1994).  Tells: teeth in the way, at a creep alone."""
    at = crawl(w, ax)
    if at is None:
        return None
    seg, top = max(logu(r, 0.05, 0.8), 8 * at[1] * at[2]), at[1] * r.uniform(1.2, 2.5)
    k, n = r.uniform(0.4, 1.0), r.uniform(1.0, 3.0)

    def f(q: Rec) -> Array:
        u = q.since[:, ax] / seg
        return -q.sgn[:, ax] * slow(q, ax, top) * (1 + k * np.exp(-np.floor(u) / n)) * (u % 1.0)

    return both(ax, f)


@distant("stick_slip")
def dies_out_with_speed(w: World, r: Rng, ax: int) -> Shape | None:
    """Sticks for 70 to 90 % of a period and slips back as a half cosine; lower with speed as a line
    to none (Bo and Pavelescu 1982; Polacek and Vavra 1967).  Tells: period in the way, lower the
    faster, none when fast."""
    at = crawl(w, ax)
    if at is None:
        return None
    seg, top = max(logu(r, 0.05, 0.8), 10 * at[1] * at[2]), at[1] * r.uniform(1.5, 3.0)
    stick = r.uniform(0.7, 0.9)

    def f(q: Rec) -> Array:
        u = (q.since[:, ax] / seg) % 1.0
        back = 0.5 * (1 + np.cos(np.pi * np.clip((u - stick) / (1 - stick), 0, 1)))
        saw = np.where(u < stick, u / stick, back)
        fade = np.clip(1 - np.abs(q.vel[:, ax]) / top, 0, 1)
        return -q.sgn[:, ax] * slow(q, ax, top) * fade * saw

    return both(ax, f)


Law = Callable[[Rec, World, int, Array], Array]


def _friction(effect: str, law: Law, amps: bool = False) -> None:
    """Files law(q, world, axis, constants 0..1) of an axis's friction, with its motor current;
    `amps`: where no currents are logged nothing tells it from a lag."""

    @distant(effect)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        files = [q for q in w.recs if q.kind == "trace" and ax in q.moving]
        if not files or (amps and not any(q.meta.get("amps") for q in files)):
            return None
        c = r.uniform(0, 1, 4)

        def shape(q: Rec) -> Array:
            return -law(q, w, ax, c)

        out = both(ax, shape)
        out.current = lambda q, a: -a * shape(q) * w.machine.stiffness[ax] / 400  # type: ignore
        return out


def _tight_guide(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Coulomb that is a sixth to a third more and less along the way, as rails and covers are tight
    (Lee et al. 2015).  Tells: the sign of motion, nothing at rest, at all speeds alike."""
    g = CubicSpline(np.linspace(-0.2, 1.2, 5), np.sin(6.28 * np.array([*c, c.sum()])))
    return moving(q, ax) * (1 + (0.15 + 0.15 * c[0]) * g(unit_place(w, ax, q)))


def _runs_in(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Coulomb that falls by a tenth to a third as the grease is spread, within 1 to 10 m of way
    (Moore 1959).  Tells: the sign of motion; less of it the later."""
    way = np.cumsum(np.abs(np.diff(q.pos[:, ax], prepend=q.pos[0, ax])))
    fall = 0.1 + 0.25 * c[0]
    soft = np.tanh(q.vel[:, ax] / (0.02 + 0.1 * c[1]))
    return soft * (1 - fall * -np.expm1(-way / (1000 * 10 ** c[2])))


def _warms(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Oil that thins as it is sheared warm: speed times a factor that falls by a tenth to a half
    within 5 to 60 s of motion (Stribeck).  Tells: currents that go with speed; less the later."""
    dt = np.diff(q.t, prepend=q.t[0])
    worked = np.cumsum(dt * (np.abs(q.vel[:, ax]) > 0.5))
    return q.vel[:, ax] * (1 - (0.1 + 0.4 * c[0]) * -np.expm1(-worked / (5 * 12 ** c[1])))


def _damper(q: Rec, w: World, ax: int, c: Array) -> Array:
    """A film and a narrow place the oil goes through: speed, and its square with its sign (Merritt
    1967).  Tells: currents that go with speed, more than as a line."""
    v = q.vel[:, ax]
    return v * (1 + (0.5 + 1.5 * c[0]) * np.abs(v) / max(float(np.abs(v).max()), 1e-9))


def _lip(q: Rec, w: World, ax: int, c: Array) -> Array:
    """A wiper whose lip folds over one way: full friction that way, a third to two thirds the other
    way with a fall at low speed (Stribeck).  Tells: the levels of both ways differ in size."""
    s, v = moving(q, ax), np.abs(q.vel[:, ax])
    back = 0.3 + 0.35 * c[0]
    fall = 1 + (0.2 + 0.3 * c[1]) * np.exp(-v / (1 + 6 * c[2]))
    if c[3] < 0.5:
        return np.where(s > 0, fall, np.where(s < 0, -back, 0.0))
    return np.where(s > 0, back, np.where(s < 0, -fall, 0.0))


def _pulled_by_a_belt_cover(q: Rec, w: World, ax: int, c: Array) -> Array:
    """A roll-up cover whose spring pulls one way all the time: Coulomb one way more, one way less,
    the pull a little stronger the farther it is drawn out.  Tells: levels of unlike size, both
    rising along the way."""
    pull = (0.3 + 0.4 * c[0]) * (0.85 + 0.3 * unit_place(w, ax, q))
    s = moving(q, ax)
    return s + pull * np.abs(s) * (1.0 if c[1] < 0.5 else -1.0)


for _e, _law in (
    ("coulomb_friction", _tight_guide),
    ("coulomb_friction", _runs_in),
    ("friction_asymmetry", _lip),
    ("friction_asymmetry", _pulled_by_a_belt_cover),
):
    _friction(_e, _law)
for _law in (_warms, _damper):
    _friction("viscous_friction", _law, amps=True)
