"""Servo, vibration and lost steps of the unseen family.  Do not read while working on the judged
tool.

Signs as in forms_motion.  Sources: Koren 1983 (Computer control of manufacturing systems: first
order loops on lines and circles), Altintas 2012 (drives; flexible screws), Renishaw's manual of the
QC20-W ballbar (servo mismatch), ISO/TR 230-8 (machines on pumps and fans), IEC 60034 (speeds of
induction motors), Acarnley 2002 (stepping motors: steps are lost where the torque is wanted).
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick
from .forms_servo import pair_of
from .registry import along, both, tool_only, unit_place, unseen
from .world import World


def loop(q: Rec, ax: int, tau: float) -> Array:
    """Speed (mm/s) behind a first-order loop of time constant tau (s); on a steady circle in closed
    form, (v - tau a) / (1 + (w tau)^2)."""
    v = q.vel[:, ax]
    if q.kind == "trace":
        k = 1 - np.exp(-1 / q.meta["rate"] / max(tau, 1e-7))
        return lfilter([k], [1, k - 1], v)
    if q.kind == "ballbar":
        turn = np.linalg.norm(q.vel, axis=1) / q.meta["radius"]
        return (v - tau * q.acc[:, ax]) / (1 + (turn * tau) ** 2)
    return v


@unseen("servo_lag")
def position_loop(w: World, r: Rng, ax: int) -> Shape:
    """A proportional position loop: e' = v - e / tau, so that lag and smoothing are one (Koren)."""

    def field(q: Rec, a: float) -> Part:
        v = along(q, ax, -a * loop(q, ax, a / 1e3))
        return Part(tool=v, scale=v)

    return Shape(field, AX[ax], lambda a: {"tau_ms": a}, linear=False)


@unseen("servo_mismatch")
def unlike_gains(w: World, r: Rng, ax: int) -> Shape:
    """Two loops of one time constant of 3 to 30 ms, detuned to either side of it (ballbar manual;
    Koren)."""
    pair, sign, tau = pair_of(w, r, ax), pick(r, [-1.0, 1.0]), logu(r, 0.003, 0.03)
    split = r.uniform(0.35, 0.65)

    def field(q: Rec, a: float) -> Part:
        v = along(q, pair[0], sign * a * split * loop(q, pair[0], tau))
        v -= along(q, pair[1], sign * a * (1 - split) * loop(q, pair[1], tau))
        return Part(tool=v, scale=v)

    return Shape(field, AX[pair[0]] + AX[pair[1]], lambda a: {"delta_tau_ms": sign * a})


@unseen("inertia")
def long_screw(w: World, r: Rng, ax: int) -> Shape:
    """Mass times acceleration over the stiffness of the free screw: more the farther the nut is
    from the bearing (Altintas 2012)."""
    k, flip = r.uniform(0.1, 0.5), r.random() < 0.5

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return -q.acc[:, ax] * (1 - k + 2 * k * (1 - s if flip else s))

    return both(ax, f)


@unseen("vibration")
def motor_nearby(w: World, r: Rng, ax: int) -> Shape | None:
    """An induction motor of 2, 4, 6 or 8 poles on 50 or 60 Hz, 1 to 5 % slow; more of it where the
    slide stands out (ISO/TR 230-8)."""
    rates = [1 / np.median(np.diff(q.t)) for q in w.recs if q.kind in ("trace", "ballbar")]
    if not rates:
        return None
    top = float(min(rates)) / 2.6
    speeds = [hz / pairs for hz in (50, 60) for pairs in (1, 2, 3, 4) if hz / pairs < top]
    hz = float(pick(r, speeds)) * r.uniform(0.95, 0.99) if speeds else logu(r, top / 4, top)
    ph, k, flip = r.uniform(0, 6.28), r.uniform(0.0, 0.6), r.random() < 0.5

    def f(q: Rec) -> Array:
        if q.kind not in ("trace", "ballbar"):
            return np.zeros(len(q.t))
        s = unit_place(w, ax, q)
        return np.sin(2 * np.pi * hz * q.t + ph) * (1 - k * (1 - s if flip else s))

    make = both if r.random() < 0.6 else tool_only
    return make(ax, f, params=lambda a: {"frequency_hz": hz})


@unseen("step_loss")
def at_a_reversal(w: World, r: Rng, ax: int) -> Shape:
    """One jump that stays, at one of the reversals of the axis, where the torque is wanted
    (Acarnley 2002)."""
    q0, sign = pick(r, w.recs), pick(r, [-1.0, 1.0])
    d = np.sign(np.diff(q0.via[:, ax]))
    d = d[np.maximum.accumulate(np.where(d != 0, np.arange(len(d)), 0))]
    turns = q0.via_t[1:-1][np.diff(d) != 0]
    lo, hi = q0.t[0] + 0.15 * np.ptp(q0.t), q0.t[-1] - 0.15 * np.ptp(q0.t)
    turns = turns[(turns > lo) & (turns < hi)]
    t = float(pick(r, turns)) if len(turns) else float(r.uniform(lo, hi))
    return both(
        ax,
        lambda q: sign * (q.t > t),
        params=lambda a: {"jump_um": sign * a, "t_s": round(t, 3)},
    )
