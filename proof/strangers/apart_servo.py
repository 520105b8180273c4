"""Servo, load, vibration and lost steps of the apart family.  Do not read while working on the
judged tool.

Signs as in forms_motion.  Sources: Altintas 2012 and Koren 1997 (position loops: velocity gain,
loops of the second order; static deflection), NSK (axial rigidity) and Slocum 1992 (Hertz
contacts), ISO 230-4 and Renishaw's manual of the QC20 (servo mismatch: an ellipse at 45 degrees
that turns over with the sense), Weck and Brecher 2006 (Werkzeugmaschinen 3: error in proportion to
acceleration; structural modes), Zirn and Weikert 2006 (Modellbildung und Simulation: cross talk of
acceleration at the tool), ISO/TR 230-8 (forced vibration by unbalance, by the floor), Acarnley 2002
(Stepping motors: synchronism that is lost).
"""

from __future__ import annotations

import numpy as np
from scipy.signal import bilinear, lfilter

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick, stream
from .forms_servo import pair_of
from .registry import along, apart, both, tool_only
from .world import World, slow_ou


def loop_error(q: Rec, ax: int, omega: float, zeta: float) -> Array:
    """Following error over its steady ratio to speed (mm/s) of a loop of the second order, natural
    frequency `omega` (rad/s) and damping `zeta`; circles are steady."""
    v = q.vel[:, ax]
    if q.kind != "trace":
        return v
    omega = min(omega, q.meta["rate"])
    k = omega / (2 * zeta)  # error over speed: k (s + 2 zeta omega) / (s^2 + 2 zeta omega s + ...)
    b, a = bilinear([k, omega**2], [1.0, 2 * zeta * omega, omega**2], q.meta["rate"])
    return lfilter(b, a, v)


@apart("servo_lag")
def velocity_gain(w: World, r: Rng, ax: int) -> Shape:
    """Following error as speed over the velocity gain (Altintas; Koren)."""
    return both(ax, lambda q: -q.vel[:, ax], params=lambda a: {"tau_ms": a})


@apart("servo_lag")
def second_order(w: World, r: Rng, ax: int) -> Shape:
    """A loop of the second order, damping 0.6 to 1.1: its lag is twice the damping over its natural
    frequency (Koren)."""
    zeta = r.uniform(0.6, 1.1)

    def field(q: Rec, a: float) -> Part:
        v = along(q, ax, -a * loop_error(q, ax, 2e3 * zeta / max(a, 0.05), zeta))
        return Part(tool=v, scale=v)

    return Shape(field, AX[ax], lambda a: {"tau_ms": a}, linear=False)


@apart("servo_mismatch")
def unlike_gains(w: World, r: Rng, ax: int) -> Shape:
    """Two loops with unlike velocity gains; what both lag alike is known (ISO 230-4; QC20)."""
    pair, sign = pair_of(w, r, ax), pick(r, [-1.0, 1.0])
    share = r.uniform(0.3, 0.7)

    def field(q: Rec, a: float) -> Part:
        v = along(q, pair[0], sign * a * share * q.vel[:, pair[0]])
        v -= along(q, pair[1], sign * a * (1 - share) * q.vel[:, pair[1]])
        return Part(tool=v, scale=v)

    return Shape(field, AX[pair[0]] + AX[pair[1]], lambda a: {"delta_tau_ms": sign * a})


@apart("servo_mismatch")
def one_slower(w: World, r: Rng, ax: int) -> Shape:
    """One axis is as it should be, the other one's loop of the second order is slower (Koren)."""
    pair, k, zeta = pair_of(w, r, ax), int(r.integers(2)), r.uniform(0.6, 1.1)
    omega, sign = logu(r, 40, 250), -1.0 if k == 0 else 1.0

    def field(q: Rec, a: float) -> Part:
        v = along(q, pair[k], -a * loop_error(q, pair[k], omega, zeta))
        return Part(tool=v, scale=v)

    return Shape(field, AX[pair[0]] + AX[pair[1]], lambda a: {"delta_tau_ms": sign * a})


@apart("force_compliance")
def static_stiffness(w: World, r: Rng, ax: int) -> Shape:
    """Load over stiffness (Altintas)."""
    return tool_only(ax, lambda q: w.force(q, ax), params=lambda a: {"um_per_N": a}, most=2.0)


@apart("force_compliance")
def structure_and_bearing(w: World, r: Rng, ax: int) -> Shape:
    """Half to four fifths of the compliance is the structure's and linear, the rest the ball
    bearings', as load to the power of two thirds (NSK: axial rigidity; Slocum, Hertz)."""
    k, top = r.uniform(0.5, 0.8), max(float(np.abs(w.load[ax]).max()), 1.0)

    def f(q: Rec) -> Array:
        n = w.force(q, ax)
        return k * n + (1 - k) * top * np.sign(n) * np.abs(n / top) ** (2 / 3)

    return tool_only(ax, f, most=2.0)


@apart("inertia")
def acceleration_error(w: World, r: Rng, ax: int) -> Shape:
    """Mass times acceleration over the drive's stiffness (Weck and Brecher)."""
    return both(ax, lambda q: -q.acc[:, ax])


@apart("inertia")
def cross_talk(w: World, r: Rng, ax: int) -> Shape:
    """The structure gives way to an accelerated slide: its own direction at the tool, and 0.15 to
    0.5 of it across; no scale sees it (Zirn and Weikert)."""
    to = int(pick(r, [a for a in w.machine.axes if a != ax]))
    k, seen = r.uniform(0.15, 0.5) * pick(r, [-1.0, 1.0]), any(q.outside for q in w.recs)

    def field(q: Rec, a: float) -> Part:
        own = along(q, ax, -a * q.acc[:, ax])
        if not seen:  # a log of the control: what its loop lets through
            return Part(tool=own, scale=own)
        return Part(tool=own + along(q, to, k * a * q.acc[:, ax]))

    return Shape(field, AX[ax])


def sampled(q: Rec) -> bool:
    """Whether a file is sampled in motion."""
    return q.kind in ("trace", "ballbar")


def band(w: World, low: float, high: float) -> tuple[float, float] | None:
    """Frequencies (Hz) within low..high that every file in motion samples three times a period."""
    rates = [1 / np.median(np.diff(q.t)) for q in w.recs if sampled(q)]
    top = min([high, *(float(x) / 3 for x in rates)])
    return (low, top) if rates and top > 1.2 * low else None


@apart("vibration")
def forced(w: World, r: Rng, ax: int) -> Shape | None:
    """A steady sine of 4 to 80 Hz in one direction (ISO/TR 230-8: supplies, drives)."""
    hz = band(w, 4.0, 80.0)
    if hz is None:
        return None
    f, ph = logu(r, *hz), r.uniform(0, 6.28)

    def y(q: Rec) -> Array:
        return np.sin(2 * np.pi * f * q.t + ph) if sampled(q) else np.zeros(len(q.t))

    return both(ax, y, params=lambda a: {"frequency_hz": f})


@apart("vibration")
def unbalance(w: World, r: Rng, ax: int) -> Shape | None:
    """A spindle out of balance: two directions a quarter turn apart, 0.5 to 1 of it in the second
    one, at the tool alone (ISO/TR 230-8)."""
    hz = band(w, 8.0, 100.0)
    if hz is None or not any(sampled(q) and q.outside for q in w.recs):
        return None
    f, ph, k = logu(r, *hz), r.uniform(0, 6.28), r.uniform(0.5, 1.0)
    to = int(pick(r, [a for a in w.machine.axes if a != ax]))

    def field(q: Rec, a: float) -> Part:
        if not sampled(q):
            return Part()
        th = 2 * np.pi * f * q.t + ph
        return Part(tool=along(q, ax, a * np.sin(th)) + along(q, to, k * a * np.cos(th)))

    return Shape(field, AX[ax], lambda a: {"frequency_hz": f})


@apart("vibration")
def structural_mode(w: World, r: Rng, ax: int) -> Shape | None:
    """A mode of the structure at 6 to 60 Hz with a damping ratio of 0.5 to 2 %, kept going at
    random (Weck and Brecher): a sine whose amplitude and phase wander."""
    hz = band(w, 6.0, 60.0)
    if hz is None:
        return None
    f, zeta, key = logu(r, *hz), r.uniform(0.005, 0.02), int(r.integers(2**62))
    tau = 1 / (2 * np.pi * f * zeta)

    def y(q: Rec) -> Array:
        if not sampled(q):
            return np.zeros(len(q.t))
        g, t = stream(key, q.name), q.t - q.t[0]
        n = max(int(t[-1] / tau * 20), 50)
        grid = np.linspace(0, t[-1], n)
        c, s = (np.interp(t, grid, slow_ou(g, n, grid[1], tau)) for _ in range(2))
        return (c * np.cos(2 * np.pi * f * t) + s * np.sin(2 * np.pi * f * t)) / 3

    return both(ax, y, params=lambda a: {"frequency_hz": f})


def _jump(w: World, r: Rng, ax: int, turn: bool) -> Shape:
    """One jump that stays, in the middle two thirds of a file; where asked, at a reversal."""
    q0 = pick(r, [q for q in w.recs if ax in q.moving] or w.recs)
    sign, n = pick(r, [-1.0, 1.0]), len(q0.t)
    at = np.arange(max(n // 6, 1), n - n // 6)
    if turn:
        back = np.flatnonzero(np.diff(q0.sgn[:, ax], prepend=q0.sgn[0, ax]) != 0)
        at = np.intersect1d(at, back) if len(np.intersect1d(at, back)) else at
    i = int(pick(r, at))
    t0 = float(q0.t[i - 1] + q0.t[i]) / 2
    return both(
        ax,
        lambda q: sign * (q.t > t0),
        params=lambda a: {"jump_um": sign * a, "t_s": round(t0, 3)},
    )


@apart("step_loss")
def lost_position(w: World, r: Rng, ax: int) -> Shape:
    """A jump at some time in motion or between two readings (Acarnley)."""
    return _jump(w, r, ax, False)


@apart("step_loss")
def lost_when_turning(w: World, r: Rng, ax: int) -> Shape:
    """A jump as the axis turns round, where a coupling slips or a motor falls out of step."""
    return _jump(w, r, ax, True)
