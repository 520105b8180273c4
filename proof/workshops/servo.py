"""Drives: friction, lag, mass, and two loops that differ (position control by its gain Kv)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from . import moving_plans
from .base import Array, Fields, log_uniform, pick
from .case import Case, Hidden
from .recordings import Recording

Friction = Callable[[Array, Array, Recording], Array]


def _friction(c: Case, effect: str, form: str, force: Friction) -> Hidden:
    """A force (about 1 at full speed) of speed (1 is the fastest), its sign and the recording; the
    slide stays behind by it, and the drive's current or a force in the log shows it."""
    a, r, m = c.axis(), c.r, c.machine
    axes, kind = c.both(a), pick(r, ["strokes", "p2p", "circles", "pocket"])
    rate = pick(r, [50, 100, 250, 500, 1000])
    c.once(moving_plans.trace, axes, kind=kind, rate=rate, sees="scale")
    newton, newton_per_ampere = log_uniform(r, 50, 300), log_uniform(r, 20, 120)
    current = f"{a}_current_A"
    column = pick(r, [current, current, f"force_{a}_N"])
    fastest = m.vmax[a] / 60

    def forced(rec: Recording) -> Array:
        return force(rec.vel[a] / fastest, np.tanh(rec.vel[a] / 0.05), rec)

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind not in ("trace", "ballbar"):
            return {}
        return rec.project({a: -size * forced(rec)}, servo=True)

    def columns(rec: Recording) -> dict[str, Array]:
        y = newton * forced(rec)
        y = y + 0.01 * newton * r.normal(size=rec.n)
        return {column: np.round(y / newton_per_ampere if column == current else y, 4)}

    params = {"F0_N": newton, "N_per_A": newton_per_ampere}
    return Hidden(effect, a, form, field, force=columns, params=params)


def viscous_friction(c: Case, form: str) -> Hidden:
    """In proportion to the speed; size: um at full speed."""
    tau = c.r.uniform(60, 300)

    def force(v: Array, sign: Array, rec: Recording) -> Array:
        if form == "thick grease":
            return v
        return v * (0.65 + 0.35 * np.exp(-(rec.t - rec.t[0]) / tau))

    return _friction(c, "viscous_friction", form, force)


def coulomb_friction(c: Case, form: str) -> Hidden:
    """Stribeck, 1902: more at low speed."""
    if form == "dry, constant":
        return _friction(c, "coulomb_friction", form, lambda v, sign, rec: sign)
    more, slow = c.r.uniform(0.3, 0.6), log_uniform(c.r, 0.005, 0.05)

    def force(v: Array, sign: Array, rec: Recording) -> Array:
        return sign * (1 + more * np.exp(-((np.abs(v) / slow) ** 2)))

    return _friction(c, "coulomb_friction", form, force)


def friction_asymmetry(c: Case, form: str) -> Hidden:
    """More one way than the other; size: um."""
    more = c.r.uniform(0.4, 0.8)

    def force(v: Array, sign: Array, rec: Recording) -> Array:
        if form == "wiper pulls more one way (Coulomb)":
            return sign * (1 + more * sign)
        return np.where(v > 0, 1 + more, 1 - more) * v

    return _friction(c, "friction_asymmetry", form, force)


def filtered(y: Array, share: float) -> Array:
    """A filter of first order that takes a share of the difference at every sample."""
    return lfilter([share], [1, -(1 - share)], y)


def servo_lag(c: Case, form: str) -> Hidden:
    """Behind by a time, s: of a loop of first order it is 1 / Kv."""
    a = c.axis()
    c.once(moving_plans.trace, c.both(a), sees="scale")

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind == "targets":
            return {}
        behind = -size * rec.vel[a] * 1e3
        if form == "first order loop (Kv)" and rec.kind == "trace":
            dt = rec.way_t[1] - rec.way_t[0]
            if size >= dt:  # not too quick for the filter
                x = rec.pos[a] - rec.pos[a][0]
                behind = (filtered(x, dt / (dt + max(size, 1e-9))) - x) * 1e3
        return rec.project({a: behind}, servo=True)

    return Hidden("servo_lag", a, form, field, size=1e-3, most=0.03, rounds=5)


def servo_mismatch(c: Case, form: str) -> Hidden:
    """A circle of two axes of which one is later (ISO 230-4); size: s."""
    a, b = c.plane()
    feeds = [float(pick(c.r, [500, 1000])), float(pick(c.r, [2000, 3000, 4000]))]
    c.once(moving_plans.ballbar, a, b, feeds=feeds)
    tau = c.r.uniform(0.01, 0.03)
    pure = form == "pure delay difference"

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind != "ballbar" or set(rec.unit) != {a, b}:
            return {}
        w = rec.head["feed_mm_min"] / 60 / rec.radius
        gain = 1.0 if pure else 1 / (1 + (w * tau) ** 2)
        shrunk = 0.0 if pure else 1e-3 * (w**2) * tau * size * rec.radius
        first = -0.5e3 * size * gain * rec.vel[a]
        second = 0.5e3 * size * gain * rec.vel[b] - 1e3 * shrunk * rec.unit[b]
        return rec.project({a: first, b: second})

    size = pick(c.r, [-1e-3, 1e-3])
    return Hidden("servo_mismatch", a + b, form, field, size=size, axes_too=["", a, b, b + a])


def inertia(c: Case, form: str) -> Hidden:
    """Behind in proportion to the acceleration; size: um s2/mm."""
    a, r = c.axis(), c.r
    axes, kind = c.both(a), pick(r, ["p2p", "strokes", "pocket", "contour"])
    rate, sees = pick(r, [100, 250, 500, 1000]), pick(r, ["scale", "scale", "tool"])
    c.once(moving_plans.trace, axes, kind=kind, rate=rate, sees=sees)
    tau = r.uniform(0.003, 0.01)

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind == "targets":
            return {}
        y = rec.acc[a]
        if form == "acceleration seen through the loop's filter" and rec.kind == "trace":
            y = filtered(y, 1 - np.exp(-(rec.way_t[1] - rec.way_t[0]) / tau))
        return rec.project({a: -size * y}, servo=True)

    return Hidden("inertia", a, form, field, size=0.01)
