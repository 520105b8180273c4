"""Friction and lost motion of the sealed family.  Do not read while working on the judged tool.

Signs and what sees what as in forms_motion.  Sources: Nordin and Gutman 2002 (Controlling
mechanical systems with backlash, a survey; Automatica 38), Archard 1953 (Contact and rubbing of
flat surfaces; wear goes with the way slid), Masing 1926 (branches of hysteresis are the virgin
curve doubled), Kondner 1963 (hyperbolic stress and strain), Armstrong-Helouvry, Dupont and Canudas
de Wit 1994 (A survey of models, analysis tools and compensation methods for the control of machines
with friction; Automatica 30: seven-parameter model, frictional memory), Rabinowicz 1958 (static
friction grows with the time of stick), Cross 1965 (shear thinning), Reynolds 1886 (viscosity falls
exponentially with temperature), Erkorkmaz and Altintas 2001 (High speed CNC system design, part II:
unlike friction in the two directions).
"""

from __future__ import annotations

import numpy as np

from .base import Array, Rec, Rng, Shape, logu
from .forms_motion import maxwell
from .registry import both, moving, sealed, tool_only, unit_place
from .world import World


@sealed("backlash")
def ramp(w: World, r: Rng, ax: int) -> Shape:
    """Teeth that come over one after another: the loss builds up in a straight line (Nordin and
    Gutman 2002)."""
    s0 = logu(r, 0.003, 0.05)
    return tool_only(
        ax,
        lambda q: -0.5 * q.sgn[:, ax] * (2 * np.minimum(q.since[:, ax] / s0, 1.0) - 1),
        params=lambda a: {"size_um": a},
    )


@sealed("backlash")
def gear_then_nut(w: World, r: Rng, ax: int) -> Shape:
    """Two gaps of a drive train, one before a sluggish part: a share of the loss comes after a way
    of its own (Nordin and Gutman 2002)."""
    late, share = logu(r, 0.01, 0.06), r.uniform(0.1, 0.4)
    return tool_only(
        ax,
        lambda q: -0.5 * q.sgn[:, ax] * np.where(q.since[:, ax] < late, 1 - 2 * share, 1.0),
        params=lambda a: {"size_um": a},
    )


@sealed("backlash_position")
def stroke(w: World, r: Rng, ax: int) -> Shape:
    """Archard: wear goes with the way slid, so one stroke run all day leaves a trapezoid."""
    a, b = r.uniform(0.05, 0.4), r.uniform(0.55, 0.95)
    flank, new = r.uniform(0.03, 0.15), r.uniform(0.05, 0.25)

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        worn = np.clip(np.minimum(s - a, b - s) / flank, 0.0, 1.0)
        return -0.5 * q.sgn[:, ax] * (new + worn)

    return tool_only(ax, f)


@sealed("backlash_position")
def dirty_end(w: World, r: Rng, ax: int) -> Shape:
    """Abrasion by chips that get in at one end: play dies away along the screw (Archard 1953, with
    a coefficient that follows the dirt)."""
    d, flip = r.uniform(0.12, 0.35), r.random() < 0.5

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return -0.5 * q.sgn[:, ax] * (0.1 + np.exp(-(1 - s if flip else s) / d))

    return tool_only(ax, f)


def hyperbola(s0: float, n: int = 24) -> tuple[Array, Array]:
    """Reaches (mm) and shares of slip elements whose virgin curve is about x / (x + s0).

    The slope falls at a reach u by share / u, so the share of u is -u f''(u) du.
    """
    edge = np.geomspace(s0 / 30, s0 * 60, n + 1)
    reach = np.sqrt(edge[1:] * edge[:-1])
    share = reach * 2 * s0 / (reach + s0) ** 3 * np.diff(edge)
    return reach, share / share.sum()


@sealed("windup")
def masing(w: World, r: Rng, ax: int) -> Shape:
    """Masing branches over Kondner's hyperbola: half the loss soon, the rest over a long way."""
    reach, share = hyperbola(logu(r, 0.02, 0.8))
    return tool_only(ax, lambda q: -maxwell(q.via[:, ax], reach, share)[q.row_at])


@sealed("reversal_spike")
def surge(w: World, r: Rng, ax: int) -> Shape:
    """Difference of two exponentials over distance, of unlike height in the two directions
    (Erkorkmaz and Altintas 2001)."""
    s1 = logu(r, 0.05, 1.2)
    s2, k = s1 * r.uniform(0.08, 0.5), r.uniform(0.5, 1.0)
    at = s1 * s2 * np.log(s1 / s2) / (s1 - s2)
    top = np.exp(-at / s1) - np.exp(-at / s2)

    def f(q: Rec) -> Array:
        s = q.since[:, ax]
        y = (np.exp(-s / s1) - np.exp(-s / s2)) / top
        return -np.where(q.sgn[:, ax] > 0, 1.0, np.where(q.sgn[:, ax] < 0, -k, 0.0)) * y

    return both(ax, f)


@sealed("stick_slip")
def aged_contact(w: World, r: Rng, ax: int) -> Shape:
    """The longer it sticks, the higher it climbs (Rabinowicz 1958): height as the logarithm of the
    time of stick, a slip of the shape of half a cosine."""
    seg, top, tau = logu(r, 0.05, 1.2), logu(r, 3, 12), logu(r, 0.005, 0.1)
    back = r.uniform(0.1, 0.35)

    def f(q: Rec) -> Array:
        v = np.abs(q.vel[:, ax])
        on = (v > 1e-4) & (v < top)
        high = np.log1p(seg / np.maximum(v, 1e-4) / tau) / np.log1p(seg / 0.1 / tau)
        u = (q.since[:, ax] / seg) % 1.0
        slip = 0.5 + 0.5 * np.cos(np.pi * (u - 1 + back) / back)
        return -q.sgn[:, ax] * on * high * np.where(u < 1 - back, u / (1 - back), slip)

    return both(ax, f)


def _friction(effect: str, law) -> None:
    """Files law(q, world, axis, constants 0..1) of an axis's friction, with its motor current."""

    @sealed(effect)
    def f(w: World, r: Rng, ax: int) -> Shape:
        c = r.uniform(0, 1, 4)

        def shape(q: Rec) -> Array:
            return -law(q, w, ax, c)

        out = both(ax, shape)
        out.current = lambda q, a: -a * shape(q) * w.machine.stiffness[ax] / 400  # type: ignore
        return out


def speed_share(q: Rec, w: World, ax: int) -> Array:
    """Speed as a share of the fastest one, signed."""
    return q.vel[:, ax] / max(w.machine.vmax / 60, 1e-9)


def _memory(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Coulomb with a Lorentzian Stribeck part, 1 to 30 ms late (seven-parameter model)."""
    v = q.vel[:, ax]
    if q.kind == "trace":
        v = np.interp(q.t - 0.001 * 30 ** c[0], q.t, v)
    fall = 1 / (1 + (v / (0.5 * 30 ** c[1])) ** 2)
    return moving(q, ax) * (1 + (0.15 + 0.5 * c[2]) * fall)


def _cross(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Grease that thins as it is sheared: v / (1 + |v| / v0)."""
    v, v0 = speed_share(q, w, ax), 0.1 + 0.6 * c[0]
    return v / (1 + np.abs(v) / v0)


def _thinning(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Oil that loses 3 to 8 % of its viscosity for each kelvin the screw gets warmer (Reynolds)."""
    rise = w.at(w.screw[ax], q.t)
    return speed_share(q, w, ax) * np.exp(-(0.03 + 0.05 * c[0]) * rise)


def _four(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Coulomb and viscous shares of their own in each direction (Erkorkmaz and Altintas 2001)."""
    v, s = np.abs(speed_share(q, w, ax)), moving(q, ax)
    up, down = 1 + (0.3 + c[0]) * v, 0.25 + 0.35 * c[1] + 0.3 * c[2] * v
    return np.where(s > 0, up, np.where(s < 0, -down, 0.0))


for _e, _law in (
    ("coulomb_friction", _memory),
    ("viscous_friction", _cross),
    ("viscous_friction", _thinning),
    ("friction_asymmetry", _four),
):
    _friction(_e, _law)
