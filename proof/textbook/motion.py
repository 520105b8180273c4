"""What turns with the direction of motion, and what is periodic along the travel: play, wind-up,
screw and scale.

Play is the play operator (a dead band that the slide crosses); pre-sliding hysteresis is Iwan's
chain; friction falls from its static level as Stribeck found. The distortion of an encoder's two
signals is that of their Lissajous figure.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .base import Array, Redraw, Rng, log_uniform, pick, sign
from .case import Case
from .recordings import Recording
from .registry import NUISANCES, Hidden, along, form

REVERSING = "laser probing ballbar tt_circ tt_lin"
WORN = "laser probing laser_long"
WINDING = "laser probing ballbar tt_circ"
SCREW = "laser_fine ballbar tt_lin"
ENCODER = "ts_slow ts_lin"

for _effect in ("backlash_position", "windup"):
    NUISANCES[_effect] = lambda c, rec: [rec.project({c.axis: rec.sense_of[c.axis]})]


def play(rec: Recording, axis: str, width: Any) -> Array:
    """Lost motion, um: the slide lags by half the width on either side, and crosses it linearly."""
    crossed = np.clip(2 * rec.since_mm[axis] * 1e3 / np.maximum(abs(width), 1e-9) - 1, -1, 1)
    return -rec.sense_of[axis] * crossed * width / 2


@form("backlash", REVERSING)
def dead_band(c: Case, r: Rng) -> Hidden:
    """plain dead band"""
    return along(c.axis, lambda rec: play(rec, c.axis, 2 * c.peak))


@form("backlash", REVERSING)
def relaxing(c: Case, r: Rng) -> Hidden:
    """dead band with Stribeck relaxation of the elastic part after the reversal"""
    k, decay = r.uniform(0.1, 0.2), r.uniform(0.1, 0.5)

    def value(rec: Recording) -> Array:
        return play(rec, c.axis, 2 * c.peak) * (1 + k * np.exp(-rec.since_mm[c.axis] / decay))

    return along(c.axis, value)


@form("backlash", REVERSING)
def over_compensated(c: Case, r: Rng) -> Hidden:
    """over-compensated dead band (negative)"""
    return along(c.axis, lambda rec: -play(rec, c.axis, 2 * c.peak))


@form("backlash_position", WORN)
def growing(c: Case, r: Rng) -> Hidden:
    """play grows linearly along the travel"""
    k, s = r.uniform(0, 0.25), sign(r)
    return _worn(c, lambda x: k + (1 - k) * (0.5 + 0.5 * s * x))


@form("backlash_position", WORN)
def worn_zone(c: Case, r: Rng) -> Hidden:
    """nut and screw worn in the much used zone"""
    k, middle, w = r.uniform(0, 0.2), r.uniform(-0.6, 0.6), r.uniform(0.25, 0.5)
    return _worn(c, lambda x: k + (1 - k) * np.exp(-(((x - middle) / w) ** 2)))


def _worn(c: Case, share: Callable[[Array], Array]) -> Hidden:
    """Play whose width is a share of the largest, by the place from -1 to 1."""
    return along(c.axis, lambda rec: play(rec, c.axis, c.peak * 2 * share(c.place(rec, c.axis))))


def _wound(c: Case, rise: Callable[[Array], Array]) -> Hidden:
    """A deflection that rises from -1 to 1 with the travel since the reversal."""
    return along(c.axis, lambda rec: -rec.sense_of[c.axis] * rise(rec.since_mm[c.axis]))


def _windup_length(c: Case, r: Rng) -> float:
    """mm."""
    rec = c.recs[0]
    if rec.kind == "targets":
        step = np.median(np.diff(np.unique(rec.pos[c.axis])))
        return log_uniform(r, 0.6, 3.5) * step
    if rec.kind == "ballbar":
        return log_uniform(r, 0.03, 0.5) * rec.radius
    return log_uniform(r, 0.05, 0.4) * np.ptp(rec.pos[c.axis])


@form("windup", WINDING)
def exponential(c: Case, r: Rng) -> Hidden:
    """exponential approach to the saturated elastic deflection"""
    length = _windup_length(c, r)
    return _wound(c, lambda d: 1 - 2 * np.exp(-d / length))


@form("windup", WINDING)
def torsion(c: Case, r: Rng) -> Hidden:
    """linear torsion until breakaway"""
    length = _windup_length(c, r) * 1.5
    return _wound(c, lambda d: 2 * np.minimum(d / length, 1) - 1)


@form("windup", WINDING)
def iwan(c: Case, r: Rng) -> Hidden:
    """Iwan chain of three elements (pre-sliding hysteresis)"""
    length = _windup_length(c, r)
    weights = r.dirichlet([2, 2, 2])
    lengths = length * np.array([0.4, 1.2, 3.0])

    def value(rec: Recording) -> Array:
        side, d = -rec.sense_of[c.axis], rec.since_mm[c.axis]
        chain = zip(weights, lengths, strict=True)
        return side * sum(w * (2 * np.minimum(d / q, 1) - 1) for w, q in chain)

    return along(c.axis, value)


def _screw_period(c: Case, r: Rng) -> float:
    """mm."""
    if c.plan == "ballbar":
        return max(c.machine.lead, 5.0)
    return c.machine.lead * pick(r, [1, 1, 0.5])


@form("cyclic", SCREW)
def lead_sine(c: Case, r: Rng) -> Hidden:
    """sine of the screw's lead (axial run-out of the thrust bearing)"""
    return _one_harmonic(c, r, _screw_period(c, r))


def _one_harmonic(c: Case, r: Rng, period: float) -> Hidden:
    phase = r.uniform(0, 6.28)
    return along(c.axis, lambda rec: np.sin(2 * np.pi * rec.pos[c.axis] / period + phase))


def _two_harmonics(c: Case, r: Rng, period: float, second: tuple[float, float]) -> Hidden:
    p, q = r.uniform(0, 6.28, 2)
    k = r.uniform(*second)

    def value(rec: Recording) -> Array:
        x = rec.pos[c.axis]
        return np.sin(2 * np.pi * x / period + p) + k * np.sin(4 * np.pi * x / period + q)

    return along(c.axis, value)


@form("cyclic", SCREW)
def lead_and_second(c: Case, r: Rng) -> Hidden:
    """lead and its second harmonic (bent screw and coupling)"""
    return _two_harmonics(c, r, _screw_period(c, r), (0.2, 0.6))


@form("cyclic", SCREW)
def away_from_bearing(c: Case, r: Rng) -> Hidden:
    """amplitude that grows away from the bearing"""
    period, phase = _screw_period(c, r), r.uniform(0, 6.28)
    k = r.uniform(0.3, 0.7) * sign(r)

    def value(rec: Recording) -> Array:
        wave = np.sin(2 * np.pi * rec.pos[c.axis] / period + phase)
        return (1 + k * c.place(rec, c.axis)) * wave

    return along(c.axis, value)


def _encoder_period(c: Case, r: Rng) -> float:
    """mm: short enough for the travel, long enough for the samples."""
    rec = c.recs[0]
    travel, fastest = np.ptp(rec.pos[c.axis]), abs(rec.vel[c.axis]).max()
    lead = c.machine.lead
    known = [0.02, 0.04, 0.1, 0.2, 0.5, 1.0, 2.0] if c.plan == "ts_slow" else [1.0, 2.0, lead, lead]
    rate = rec.rate or 0.0
    fit = [q for q in known if q < travel / 3 and fastest / q < rate / 6]
    period = pick(r, fit or [0])
    if not period:
        raise Redraw
    return period


@form("encoder_cyclic", ENCODER)
def eccentric_disk(c: Case, r: Rng) -> Hidden:
    """one harmonic (offset of a Lissajous signal, eccentric disk)"""
    return _one_harmonic(c, r, _encoder_period(c, r))


@form("encoder_cyclic", ENCODER)
def offset_and_quadrature(c: Case, r: Rng) -> Hidden:
    """two harmonics (offset, and unequal amplitudes or quadrature)"""
    return _two_harmonics(c, r, _encoder_period(c, r), (0.4, 1.5))


@form("encoder_cyclic", ENCODER)
def lissajous(c: Case, r: Rng) -> Hidden:
    """arctangent of a distorted Lissajous ellipse, all harmonics"""
    period = _encoder_period(c, r)
    o1, o2 = r.normal(size=2) * 0.12
    gain, skew = 1 + r.normal() * 0.12, r.normal() * 0.1

    def value(rec: Recording) -> Array:
        phase = 2 * np.pi * rec.pos[c.axis] / period
        cosine, sine = np.cos(phase) + o1, gain * np.sin(phase + skew) + o2
        return np.angle(np.exp(1j * (np.arctan2(sine, cosine) - phase)))

    return along(c.axis, value)
