"""Friction and lost motion of the fresh family.  Do not read while working on the judged tool.

Signs and what sees what as in forms_motion.  Sources: Bouc 1967 and Wen 1976 (hysteresis), Tustin
1947 (friction falling with speed), Eyring 1936 (shear of a film), Rabinowicz 1958 (stick-slip
fading with speed), Tarng, Kao and Lin 1997 (quadrant glitches), Armstrong-Helouvry, Dupont and
Canudas de Wit 1994.
"""

from __future__ import annotations

import numpy as np

from .base import Array, Rec, Rng, Shape, logu, pick
from .registry import both, fresh, moving, tool_only, unit_place
from .world import World


@fresh("backlash")
def soft_gap(w: World, r: Rng, ax: int) -> Shape:
    """A gap whose last third is taken up by contacts that harden, a power of the way."""
    s0, share = logu(r, 0.004, 0.04), r.uniform(0.1, 0.35)
    return tool_only(
        ax,
        lambda q: -0.5 * q.sgn[:, ax] * (1 - share / (1 + q.since[:, ax] / s0) ** 2),
        params=lambda a: {"size_um": a},
    )


@fresh("backlash_position")
def bent_rack(w: World, r: Rng, ax: int) -> Shape:
    """A rack or screw out of true: play that goes with the square of the distance from a place."""
    c, k = r.uniform(0.2, 0.8), pick(r, [1.0, -0.9])
    g0 = 0.15 if k > 0 else 1.0

    def f(q: Rec) -> Array:
        return -0.5 * q.sgn[:, ax] * (g0 + k * (unit_place(w, ax, q) - c) ** 2 / max(c, 1 - c) ** 2)

    return tool_only(ax, f)


@fresh("backlash_position")
def two_shops(w: World, r: Rng, ax: int) -> Shape:
    """Wear at the two places where most parts are made."""
    c = np.array([r.uniform(0.1, 0.35), r.uniform(0.6, 0.9)])
    d, h = r.uniform(0.05, 0.12, 2), np.array([1.0, r.uniform(0.4, 1.0)])

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)[:, None]
        return -0.5 * q.sgn[:, ax] * (0.1 + np.exp(-0.5 * ((s - c) / d) ** 2) @ h)

    return tool_only(ax, f)


def bouc_wen(cmd: Array, s0: float, n: float, beta: float) -> Array:
    """Bouc-Wen state in -1..1: dz = dx/s0 (1 - |z|^n (beta sign(dx z) + 1 - beta)), small steps."""
    z, out = 0.0, [0.0]
    for d in np.diff(cmd).tolist():
        rest = min(abs(d), 8 * s0)  # beyond that it has settled
        steps = int(np.ceil(rest / (0.1 * s0))) if rest else 0
        h, s = (rest / steps / s0, np.sign(d)) if steps else (0.0, 0.0)
        for _ in range(steps):
            z += s * h * (1 - abs(z) ** n * (beta * (1.0 if s * z > 0 else -1.0) + 1 - beta))
            z = min(max(z, -1.0), 1.0)
        out.append(z)
    return np.array(out)


@fresh("windup")
def hysteresis(w: World, r: Rng, ax: int) -> Shape:
    """Bouc-Wen; the exponent sets how sharp the elbow is."""
    s0, n, beta = logu(r, 0.02, 1.5), r.uniform(0.8, 3), r.uniform(0.5, 0.9)
    return tool_only(ax, lambda q: -bouc_wen(q.via[:, ax], s0, n, beta)[q.row_at])


@fresh("reversal_spike")
def trapezoid(w: World, r: Rng, ax: int) -> Shape:
    """Rise, hold and fall over distance, the pulse that controls compensate with."""
    a = np.cumsum([logu(r, 0.005, 0.1), logu(r, 0.02, 0.6), logu(r, 0.05, 1.5)])
    return both(
        ax, lambda q: -q.sgn[:, ax] * np.interp(q.since[:, ax], np.r_[0, a], [0.0, 1.0, 1.0, 0.0])
    )


@fresh("stick_slip")
def fading_slip(w: World, r: Rng, ax: int) -> Shape:
    """Saw-tooth with a slip of finite time, that fades as the feed nears a critical speed."""
    seg, top, back = logu(r, 0.05, 1.2), logu(r, 3, 12), r.uniform(0.05, 0.25)

    def f(q: Rec) -> Array:
        v = np.abs(q.vel[:, ax])
        u = (q.since[:, ax] / seg) % 1.0
        return (
            -q.sgn[:, ax]
            * (v > 1e-4)
            * np.clip(1 - v / top, 0, 1)
            * np.minimum(u / (1 - back), (1 - u) / back)
        )

    return both(ax, f)


def _friction(effect: str, law) -> None:
    """Files a law(v, sign, r's constants) of an axis's friction, with its motor current."""

    @fresh(effect)
    def f(w: World, r: Rng, ax: int) -> Shape:
        c = r.uniform(0, 1, 3)
        top = max(w.machine.vmax / 60, 1e-9)

        def shape(q: Rec) -> Array:
            return -law(q.vel[:, ax] / top, moving(q, ax), c, q.since[:, ax])

        out = both(ax, shape)
        out.current = lambda q, a: -a * shape(q) * w.machine.stiffness[ax] / 400  # type: ignore
        return out


def _tustin(v: Array, s: Array, c: Array, x: Array) -> Array:
    return s * (1 + (0.1 + 0.4 * c[0]) * np.exp(-np.abs(v) / (0.01 + 0.1 * c[1])))


def _presliding(v: Array, s: Array, c: Array, x: Array) -> Array:
    """Coulomb reached over the first 5 to 100 um after a reversal."""
    return s * (1 - np.exp(-x / (0.005 * 20 ** c[0])))


def _eyring(v: Array, s: Array, c: Array, x: Array) -> Array:
    v0 = 0.1 + 0.5 * c[0]
    return v0 * np.arcsinh(v / v0)


def _windage(v: Array, s: Array, c: Array, x: Array) -> Array:
    return v + (0.2 + c[0]) * v * np.abs(v)


def _hung(v: Array, s: Array, c: Array, x: Array) -> Array:
    """A mass that hangs: one level up, another down, and a film on top."""
    return np.where(s > 0, 1.0, np.where(s < 0, -0.2 - 0.5 * c[0], 0.0)) + 0.4 * c[1] * v


def _wiper(v: Array, s: Array, c: Array, x: Array) -> Array:
    """A wiper whose lip folds: drag in both directions, more against the lip."""
    return s * np.where(s > 0, 1.0, 0.3 + 0.4 * c[0]) * (1 - 0.5 * np.exp(-x / (0.5 + 3 * c[1])))


for _e, _law in (
    ("coulomb_friction", _tustin),
    ("coulomb_friction", _presliding),
    ("viscous_friction", _eyring),
    ("viscous_friction", _windage),
    ("friction_asymmetry", _hung),
    ("friction_asymmetry", _wiper),
):
    _friction(_e, _law)
