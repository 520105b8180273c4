"""Servo, vibration and lost steps of the fresh family.  Do not read while working on the judged
tool.

Signs as in forms_motion.  Sources: Altintas 2012 (Manufacturing Automation: drives with dead time,
flexible drives), Koren 1980 (cross-coupled axes), ISO 230-8 (vibration of pumps and compressors).
"""

from __future__ import annotations

import numpy as np

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick
from .forms_servo import lag_speed, pair_of
from .registry import along, both, fresh, tool_only
from .world import World


def late_speed(q: Rec, ax: int, dead: float) -> Array:
    """Speed (mm/s) of `dead` seconds ago; circles are steady and keep theirs."""
    v = q.vel[:, ax]
    return np.interp(q.t - dead, q.t, v) if q.kind == "trace" else v


@fresh("servo_lag")
def dead_time(w: World, r: Rng, ax: int) -> Shape:
    """A loop that closes after a dead time of 1 to 30 ms."""
    dead = logu(r, 0.001, 0.03)
    return both(ax, lambda q: -late_speed(q, ax, dead), params=lambda a: {"tau_ms": a})


@fresh("servo_lag")
def part_forward(w: World, r: Rng, ax: int) -> Shape:
    """Speed fed forward in part: a lag at steady speed, and more of it while speed changes."""
    k, t1 = r.uniform(0.1, 0.5), logu(r, 0.004, 0.04)

    def f(q: Rec) -> Array:
        v = q.vel[:, ax]
        return -(v + k * (v - lag_speed(q, ax, "first", t1, 0.7)))

    return both(ax, f, params=lambda a: {"tau_ms": a})


@fresh("servo_mismatch")
def unlike_loops(w: World, r: Rng, ax: int) -> Shape:
    """Two loops with unlike gains and unlike dead times."""
    pair, sign = pair_of(w, r, ax), pick(r, [-1.0, 1.0])
    dead = [logu(r, 0.001, 0.02), logu(r, 0.001, 0.02)]
    split = r.uniform(0, 1)

    def field(q: Rec, a: float) -> Part:
        v = along(q, pair[0], sign * a * split * late_speed(q, pair[0], dead[0]))
        v -= along(q, pair[1], sign * a * (1 - split) * late_speed(q, pair[1], dead[1]))
        return Part(tool=v, scale=v)

    return Shape(field, AX[pair[0]] + AX[pair[1]], lambda a: {"delta_tau_ms": sign * a})


@fresh("inertia")
def flexible(w: World, r: Rng, ax: int) -> Shape:
    """Mass on a damped spring: acceleration through a second-order filter, 5 to 60 Hz."""
    t1, zeta = 1 / (2 * np.pi * logu(r, 5, 60)), r.uniform(0.15, 0.7)

    def f(q: Rec) -> Array:
        if q.kind != "trace":
            return -q.acc[:, ax]
        twin = Rec(**{**{k: getattr(q, k) for k in Rec.__dataclass_fields__}, "vel": q.acc})
        return -lag_speed(twin, ax, "second", t1, zeta)

    return both(ax, f)


@fresh("vibration")
def pump(w: World, r: Rng, ax: int) -> Shape | None:
    """A pump or compressor that cuts in and out: one frequency, now there and now not."""
    rates = [1 / np.median(np.diff(q.t)) for q in w.recs if q.kind in ("trace", "ballbar")]
    if not rates:
        return None
    top = min(float(min(rates)) / 2.6, 60.0)
    hz, ph, on, where = (
        logu(r, min(0.8, top / 2), top),
        r.uniform(0, 6.28),
        r.uniform(0.4, 0.8),
        r.uniform(),
    )
    parts = int(r.integers(1, 5))

    def f(q: Rec) -> Array:
        u = (q.t - q.t[0]) / max(float(np.ptp(q.t)), 1e-9) * parts + where
        gate = 1 / (1 + np.exp(np.clip((np.abs(u % 1.0 - 0.5) - on / 2) / 0.01, -50, 50)))
        return np.sin(2 * np.pi * hz * q.t + ph) * gate

    out = both(ax, f) if r.random() < 0.7 else tool_only(ax, f)
    inner = out.field
    out.field = lambda q, a: inner(q, a) if q.kind in ("trace", "ballbar") else Part()
    out.params = lambda a: {"frequency_hz": hz}
    return out


@fresh("step_loss")
def slipping(w: World, r: Rng, ax: int) -> Shape:
    """A loss that takes three slips in short succession (a belt that skips, a motor that falls
    out)."""
    q0, sign = pick(r, w.recs), pick(r, [-1.0, 1.0])
    span = float(np.ptp(q0.t))
    t0 = float(r.uniform(q0.t[0] + 0.15 * span, q0.t[-1] - 0.2 * span))
    t, size = t0 + span * np.r_[0.0, np.sort(r.uniform(0, 0.02, 2))], r.dirichlet(np.ones(3) * 3)
    return both(
        ax,
        lambda q: sign * ((q.t[:, None] >= t) @ size),
        params=lambda a: {"jump_um": sign * a, "t_s": t0},
    )
