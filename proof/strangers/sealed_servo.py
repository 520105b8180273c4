"""Servo, vibration and lost steps of the sealed family.  Do not read while working on the judged
tool.

Signs as in forms_motion.  Sources: Biagiotti and Melchiorri 2008 (Trajectory planning: moving
averages as interpolators), Altintas 2012 (Manufacturing automation: drives), ISO/TR 230-8
(vibration and relative motion that comes from the acceleration of axes), Randall 1987 (Frequency
analysis: harmonics of gear mesh and unbalance), Acarnley 2002 (Stepping motors: a lost step is a
whole tooth, four full steps).
"""

from __future__ import annotations

import numpy as np

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick
from .forms_servo import lag_speed, pair_of
from .registry import along, both, sealed, tool_only
from .world import World


def averaged_speed(q: Rec, ax: int, window: float) -> Array:
    """Speed (mm/s) averaged over the last `window` seconds; circles are steady and keep theirs."""
    v = q.vel[:, ax]
    n = max(1, round(window * q.meta["rate"])) if q.kind == "trace" else 1
    return np.convolve(v, np.ones(n) / n)[: len(v)]


@sealed("servo_lag")
def averaging_interpolator(w: World, r: Rng, ax: int) -> Shape:
    """A loop behind an interpolator that averages over 4 to 80 ms (Biagiotti and Melchiorri)."""
    window = logu(r, 0.004, 0.08)
    return both(ax, lambda q: -averaged_speed(q, ax, window), params=lambda a: {"tau_ms": a})


@sealed("servo_lag")
def two_gains(w: World, r: Rng, ax: int) -> Shape:
    """A loop gain that is switched to a lower one above a speed, so that the lag bends upwards or
    downwards there (Altintas 2012)."""
    knee, k = r.uniform(0.2, 0.7), r.uniform(0.6, 1.5)

    def f(q: Rec) -> Array:
        v = q.vel[:, ax]
        top = knee * max(float(np.abs(v).max()), 1e-9)
        return -np.sign(v) * (np.minimum(np.abs(v), top) + k * np.maximum(np.abs(v) - top, 0))

    return both(ax, f)


@sealed("servo_mismatch")
def unlike_orders(w: World, r: Rng, ax: int) -> Shape:
    """One axis with a current loop as slow as its speed loop (second order), the other one with an
    averaging interpolator (Altintas 2012)."""
    pair, sign = pair_of(w, r, ax), pick(r, [-1.0, 1.0])
    t1, zeta, window = logu(r, 0.002, 0.03), r.uniform(0.4, 0.9), logu(r, 0.004, 0.06)
    split = r.uniform(0, 1)

    def field(q: Rec, a: float) -> Part:
        v = along(q, pair[0], sign * a * split * lag_speed(q, pair[0], "second", t1, zeta))
        v -= along(q, pair[1], sign * a * (1 - split) * averaged_speed(q, pair[1], window))
        return Part(tool=v, scale=v)

    return Shape(field, AX[pair[0]] + AX[pair[1]], lambda a: {"delta_tau_ms": sign * a})


@sealed("inertia")
def cross_talk(w: World, r: Rng, ax: int) -> Shape:
    """An accelerated slide pitches the frame: its own axis gives way, and the tool goes aside by
    0.2 to 0.6 of that; the scale sees a third of the first and nothing of the second (ISO/TR
    230-8)."""
    to, k = int(pick(r, [a for a in w.machine.axes if a != ax])), r.uniform(-0.6, 0.6)
    k = k if abs(k) > 0.2 else 0.2

    def field(q: Rec, a: float) -> Part:
        own = along(q, ax, -a * q.acc[:, ax])
        return Part(tool=own + along(q, to, -a * k * q.acc[:, ax]), scale=own / 3)

    return Shape(field, AX[ax])


@sealed("vibration")
def unbalance_and_mesh(w: World, r: Rng, ax: int) -> Shape | None:
    """A shaft that turns steadily: its frequency with a second and a third harmonic (Randall)."""
    rates = [1 / np.median(np.diff(q.t)) for q in w.recs if q.kind in ("trace", "ballbar")]
    if not rates:
        return None
    top = min(float(min(rates)) / 2.6 / 3, 40.0)
    hz, ph = logu(r, min(0.8, top / 2), top), r.uniform(0, 6.28, 3)
    h = np.r_[1.0, r.uniform(0.1, 0.5), r.uniform(0.05, 0.3)]

    def f(q: Rec) -> Array:
        return sum(g * np.sin(2 * np.pi * (i + 1) * hz * q.t + ph[i]) for i, g in enumerate(h))

    out = both(ax, f) if r.random() < 0.6 else tool_only(ax, f)
    inner = out.field
    out.field = lambda q, a: inner(q, a) if q.kind in ("trace", "ballbar") else Part()
    out.params = lambda a: {"frequency_hz": hz}
    return out


@sealed("step_loss")
def whole_teeth(w: World, r: Rng, ax: int) -> Shape:
    """A stepping motor loses a whole tooth at a time: one to three jumps of the same size to the
    same side (Acarnley 2002)."""
    q0, sign, n = pick(r, w.recs), pick(r, [-1.0, 1.0]), int(r.integers(1, 4))
    span = float(np.ptp(q0.t))
    t = np.sort(r.uniform(q0.t[0] + 0.1 * span, q0.t[-1] - 0.1 * span, n))
    return both(
        ax,
        lambda q: sign * (q.t[:, None] >= t).sum(1) / n,
        params=lambda a: {"jump_um": sign * a, "t_s": float(t[0])} if n == 1 else {},
    )
