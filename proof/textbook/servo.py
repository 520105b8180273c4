"""What follows from speed, acceleration and time: friction, lag, inertia, reversal spikes, stick
slip, vibration, delays and clocks.

A servo lags: actual is behind by speed times a time constant. A force against the loop's stiffness
moves the slide back, and the drive's current pays for it. Friction by Coulomb and Stribeck; a slide
that sticks moves as a spring with a mass.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import bilinear, lfilter

from .base import SQUARENESS, Array, Redraw, Rng, log_uniform, pick, sign
from .case import Case
from .recordings import Recording
from .registry import NUISANCES, Hidden, along, form, moved, with_current

SPIKE = "ballbar ts_circ tt_circ ts_lin"
SLOW = "ts_slow tt_slow"
FRICTION = "ts_lin_cur ts_lin_cur ts_lin"
LAG = "ts_lin tt_lin ts_lin_cur"
CIRCLES, BOTH_CIRCLES = "ballbar ts_circ tt_circ", "ts_circ tt_circ"
VIBRATION = "ts_lin tt_lin ballbar ts_circ tt_circ"
CLOCK = "ts_lin tt_lin ts_circ"

NUISANCES["friction_asymmetry"] = lambda c, rec: [
    rec.project({c.axis: _way(rec, c.axis)}),
    rec.project({c.axis: rec.vel[c.axis]}),
]
NUISANCES["servo_mismatch"] = lambda c, rec: [
    rec.project(c.machine.by_squareness(rec.pos, SQUARENESS[c.pair], 1.0))
]
for _effect in ("inertia", "clock_skew"):
    NUISANCES[_effect] = lambda c, rec: [rec.project({c.axis: rec.vel[c.axis]})]


def _way(rec: Recording, axis: str) -> Array:
    """Sign of the speed, 0 at rest."""
    v = rec.vel[axis]
    return np.sign(np.where(abs(v) < 1e-3 * abs(v).max() + 1e-9, 0, v))


def _recovery(c: Case, r: Rng) -> float:
    """s: over some samples, a twentieth of a second at most."""
    rate = c.recs[0].sample_rate
    return log_uniform(r, 4 / rate, max(14 / rate, 0.06))


def _spike(c: Case, pulse: Callable[[Array], Array]) -> Hidden:
    """A pulse after each reversal by the time since it, s, against the new direction."""
    return along(c.axis, lambda rec: -rec.sense_of[c.axis] * pulse(rec.since_s[c.axis]))


@form("reversal_spike", SPIKE)
def stiction(c: Case, r: Rng) -> Hidden:
    """stiction then exponential recovery"""
    tau = _recovery(c, r)
    return _spike(c, lambda t: np.exp(-t / tau))


@form("reversal_spike", SPIKE)
def half_sine_in_time(c: Case, r: Rng) -> Hidden:
    """half sine in time"""
    length = 3 * _recovery(c, r)

    def pulse(t: Array) -> Array:
        return np.where(t < length, np.sin(np.pi * np.minimum(t / length, 1)), 0)

    return _spike(c, pulse)


@form("reversal_spike", SPIKE)
def quadrant_glitch(c: Case, r: Rng) -> Hidden:
    """quadrant glitch t exp(-t) with a small undershoot"""
    tau, k = _recovery(c, r), r.uniform(0, 0.35)

    def pulse(t: Array) -> Array:
        z = np.minimum(t / tau, 60)
        return z * np.exp(1 - z) - k * np.where(z > 2, (z - 2) * np.exp(3 - z), 0)

    return _spike(c, pulse)


def _saw(c: Case, r: Rng, scatter: float, ring: float) -> Hidden:
    """A spring that is stretched while the slide sticks, and slips. scatter, of the lengths of
    stick; ring: share of a slip by which it overshoots."""
    axis, first = c.axis, c.recs[0]
    stick = 2 * c.peak * 1e-3  # mm
    fastest, travel = abs(first.vel[axis]).max(), np.ptp(first.pos[axis])
    if first.sample_rate < 5 * fastest / stick or travel < 8 * stick:
        raise Redraw
    n = int(travel * 8 / stick) + 50
    lengths = stick * (1 + scatter * np.clip(r.normal(size=n), -1.5, 1.5))
    slips = np.concatenate([[0], np.cumsum(lengths)])
    decay = r.uniform(0.01, 0.03)  # s

    def value(rec: Recording) -> Array:
        path = np.concatenate([[0], np.cumsum(abs(np.diff(rec.pos[axis])))])
        i = np.clip(np.searchsorted(slips, path, "right") - 1, 0, n - 1)
        y = ((path - slips[i]) - lengths[i] / 2) * 1e3
        if ring:
            start = np.concatenate([[0], np.flatnonzero(np.diff(i)) + 1])
            since = np.zeros(rec.n, int)
            since[start] = start
            since = np.maximum.accumulate(since)
            t = rec.t - rec.t[since]
            wave = np.exp(-t / decay), np.cos(2 * np.pi * t / (2.2 * decay)), since > 0
            y = y - ring * lengths[i] * 1e3 * wave[0] * wave[1] * wave[2]
        return -rec.sense_of[axis] * np.where(abs(rec.vel[axis]) > 0.05 * fastest, y, 0)

    return along(axis, value)


@form("stick_slip", SLOW)
def regular_saw(c: Case, r: Rng) -> Hidden:
    """regular saw tooth: the slide stands, then jumps"""
    return _saw(c, r, 0.0, 0.0)


@form("stick_slip", SLOW)
def irregular_saw(c: Case, r: Rng) -> Hidden:
    """irregular saw tooth, stick lengths scatter by a quarter"""
    return _saw(c, r, 0.25, 0.0)


@form("stick_slip", SLOW)
def ringing_saw(c: Case, r: Rng) -> Hidden:
    """spring and mass: the slip overshoots and rings out"""
    return _saw(c, r, 0.1, 0.2)


@form("viscous_friction", FRICTION)
def viscous(c: Case, r: Rng) -> Hidden:
    """force proportional to speed"""
    return with_current(c.axis, r, lambda rec: -rec.vel[c.axis])


@form("viscous_friction", FRICTION)
def thinning_grease(c: Case, r: Rng) -> Hidden:
    """shear-thinning grease: force as speed to the power 2/3"""
    n = r.uniform(0.6, 0.8)

    def value(rec: Recording) -> Array:
        v = rec.vel[c.axis]
        return -np.sign(v) * abs(v) ** n

    return with_current(c.axis, r, value)


@form("coulomb_friction", FRICTION)
def coulomb(c: Case, r: Rng) -> Hidden:
    """sign of the speed"""
    return with_current(c.axis, r, lambda rec: -_way(rec, c.axis))


@form("coulomb_friction", FRICTION)
def smooth_step(c: Case, r: Rng) -> Hidden:
    """smooth step (tanh) at reversal"""
    slow = log_uniform(r, 0.3, 3)  # mm/s
    return with_current(c.axis, r, lambda rec: -np.tanh(rec.vel[c.axis] / slow))


@form("coulomb_friction", FRICTION)
def stribeck(c: Case, r: Rng) -> Hidden:
    """Stribeck: static level above the Coulomb one"""
    slow, k = log_uniform(r, 2, 8), r.uniform(0.15, 0.4)

    def value(rec: Recording) -> Array:
        v = rec.vel[c.axis]
        return -np.tanh(v / 0.3) * (1 + k * np.exp(-((v / slow) ** 2)))

    return with_current(c.axis, r, value)


@form("friction_asymmetry", FRICTION)
def coulomb_one_way(c: Case, r: Rng) -> Hidden:
    """Coulomb level of one direction higher (counterweight, wiper)"""
    k, s = r.uniform(0.1, 0.5), sign(r)

    def value(rec: Recording) -> Array:
        way = _way(rec, c.axis)
        return -np.where(way * s > 0, way, k * way)

    return with_current(c.axis, r, value)


@form("friction_asymmetry", FRICTION)
def viscous_one_way(c: Case, r: Rng) -> Hidden:
    """viscous coefficient of one direction higher"""
    k, s = r.uniform(0.05, 0.4), sign(r)

    def value(rec: Recording) -> Array:
        v = rec.vel[c.axis]
        return -np.where(v * s > 0, 1, k) * v

    return with_current(c.axis, r, value)


@form("servo_lag", LAG)
def following_error(c: Case, r: Rng) -> Hidden:
    """following error exactly proportional to speed"""
    return along(c.axis, lambda rec: -rec.vel[c.axis])


@form("servo_lag", LAG)
def first_order_lag(c: Case, r: Rng) -> Hidden:
    """first order: the lag follows the speed with a time constant"""
    tau = log_uniform(r, 0.006, 0.04)

    def value(rec: Recording) -> Array:
        p = np.exp(-1 / (rec.sample_rate * tau))
        return -lfilter([1 - p], [1, -p], rec.vel[c.axis])

    return along(c.axis, value)


@form("servo_mismatch", CIRCLES, "pair")
def one_lags(c: Case, r: Rng) -> Hidden:
    """one axis lags, the other is perfect"""
    s = sign(r)
    return along(c.axis, lambda rec: -s * rec.vel[c.axis])


@form("servo_mismatch", "ballbar tt_circ ts_circ", "pair")
def half_and_half(c: Case, r: Rng) -> Hidden:
    """half and half: plus and minus about the common lag"""
    s = sign(r)
    return moved(lambda rec: {c.axis: -s * rec.vel[c.axis] / 2, c.other: s * rec.vel[c.other] / 2})


@form("servo_mismatch", CIRCLES, "pair")
def detuned(c: Case, r: Rng) -> Hidden:
    """lag of one axis plus a share of acceleration (feed forward of one axis detuned)"""
    s, k = sign(r), r.uniform(0.15, 0.4)

    def value(rec: Recording) -> Array:
        v, a = rec.vel[c.axis], rec.acc[c.axis]
        return -s * (v / abs(v).max() + k * a / abs(a).max())

    return along(c.axis, value)


@form("inertia", LAG)
def mass_on_loop(c: Case, r: Rng) -> Hidden:
    """mass on the stiffness of the loop: minus acceleration"""
    return along(c.axis, lambda rec: -rec.acc[c.axis])


@form("inertia", "ts_lin tt_lin")
def damped(c: Case, r: Rng) -> Hidden:
    """damped second order: acceleration through the structure's own response"""
    w = 2 * np.pi * log_uniform(r, 12, 30)
    zeta = r.uniform(0.3, 0.7)

    def value(rec: Recording) -> Array:
        b, a = bilinear([w * w], [1, 2 * zeta * w, w * w], rec.sample_rate)
        return -lfilter(b, a, rec.acc[c.axis])

    return along(c.axis, value)


def _frequency(c: Case, r: Rng) -> float:
    """Hz, that the samples can show."""
    rate = c.recs[0].sample_rate
    return log_uniform(r, max(0.04 * rate, 2), 0.35 * rate)


@form("vibration", VIBRATION)
def steady_sine(c: Case, r: Rng) -> Hidden:
    """steady sine in time"""
    f, phase = _frequency(c, r), r.uniform(0, 6.28)
    return along(c.axis, lambda rec: np.sin(2 * np.pi * f * rec.t + phase))


@form("vibration", VIBRATION)
def beat(c: Case, r: Rng) -> Hidden:
    """beat of two neighbouring frequencies (two motors)"""
    f, apart = _frequency(c, r), log_uniform(r, 0.1, 0.8)
    p, q = r.uniform(0, 6.28, 2)
    k = r.uniform(0.3, 0.8)

    def value(rec: Recording) -> Array:
        one = np.sin(2 * np.pi * f * rec.t + p)
        return one + k * np.sin(2 * np.pi * (f + apart) * rec.t + q)

    return along(c.axis, value)


@form("vibration", VIBRATION)
def modulated(c: Case, r: Rng) -> Hidden:
    """floor-excited resonance, slowly modulated amplitude"""
    f, phase = _frequency(c, r), r.uniform(0, 6.28)
    k, period, slow_phase = r.uniform(0.3, 0.7), r.uniform(2, 6), r.uniform(0, 6.28)

    def value(rec: Recording) -> Array:
        size = 1 + k * np.sin(2 * np.pi * rec.t / period + slow_phase)
        return size * np.sin(2 * np.pi * f * rec.t + phase)

    return along(c.axis, value)


def _late(by: Callable[[Recording, str], Array]) -> Hidden:
    """Every axis that moves is read late."""
    return moved(lambda rec: {a: by(rec, a) for a in rec.moving})


@form("delay", BOTH_CIRCLES, "")
def constant_delay(c: Case, r: Rng) -> Hidden:
    """constant delay in all axes"""
    return _late(lambda rec, a: -rec.vel[a])


@form("delay", BOTH_CIRCLES, "")
def jitter(c: Case, r: Rng) -> Hidden:
    """delay with jitter of the bus"""
    seed, k = int(r.integers(1 << 30)), r.uniform(0.1, 0.3)

    def by(rec: Recording, a: str) -> Array:
        each = np.random.default_rng(seed + rec.n).uniform(-1, 1, rec.n)
        return -rec.vel[a] * (1 + k * each)

    return _late(by)


@form("clock_skew", CLOCK, "")
def fast_clock(c: Case, r: Rng) -> Hidden:
    """two clocks, one runs fast by ppm"""
    s, begin = sign(r), c.recs[0].t[0]
    return _late(lambda rec, a: -s * rec.vel[a] * (rec.t - begin) / c.span)


@form("clock_skew", CLOCK, "")
def lost_samples(c: Case, r: Rng) -> Hidden:
    """samples lost once: the rest is late"""
    s, when = pick(r, [1, 1, -1]), r.uniform(0.3, 0.7) * c.span
    return _late(lambda rec, a: -s * rec.vel[a] * (rec.t > when))
