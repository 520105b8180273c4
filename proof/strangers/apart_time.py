"""Heat, drift, spindle and instrument of the apart family.  Do not read while working on the judged
tool.

Conventions as in forms_time.  Sources: ISO 230-3:2020 (environmental variation, spindle and linear
axes; approach to a level with one time constant), ASME B5.54 (drift tests), Bryan 1990 (CIRP Annals
39/2), Mayr et al. 2012 (CIRP Annals 61/2: temperatures times coefficients; screws), NSK's and
Steinmeyer's notes on the heating of screws (12e-6 per K from the fixed bearing), ISO 230-2 and
Renishaw's manual of the XL-80 (1 um per m for each K, 3.3 hPa; dead path; alignment), Birch and
Downs 1993 (Metrologia 30: updated Edlen equation), Estler 1985 (dead path), ISO 230-1 and Slocum
1992 (cosine error), Butterworth 1930 (Wireless Engineer 7), Vig 1992 (quartz clocks: offsets of
rate, warm-up).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import butter, lfilter

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick
from .forms_time import beam, lasers, sensed
from .registry import apart, tool_only
from .world import World, lowpass


def bearing(w: World, r: Rng, ax: int) -> float:
    """Place (mm) of the fixed bearing, 30 to 100 mm outside one end of the travel."""
    lo, hi = w.machine.travel[ax]
    off = r.uniform(30, 100)
    return float(hi + off if r.random() < 0.5 else lo - off)


@apart("screw_heat")
def from_the_fixed_bearing(w: World, r: Rng, ax: int) -> Shape:
    """Rise times length from the fixed bearing, 12e-6 per K (NSK; Mayr et al.)."""
    still = bearing(w, r, ax)
    return tool_only(
        ax, lambda q: 0.012 * w.at(w.screw[ax], q.t) * (q.pos[:, ax] - still), most=3.0
    )


@apart("screw_heat")
def own_time_constant(w: World, r: Rng, ax: int) -> Shape:
    """The screw follows its own work with 10 to 40 minutes, whatever the thermometer beside it
    shows (ISO 230-3, linear axes: growth of near and far target)."""
    still, dt = bearing(w, r, ax), float(w.grid[1])
    rise = lowpass(w.duty[ax], dt, logu(r, 600, 2400), 0.0)
    rise = rise / max(float(rise.max()), 1e-9) * max(float(w.screw[ax].max()), 0.5)
    return tool_only(ax, lambda q: 0.012 * w.at(rise, q.t) * (q.pos[:, ax] - still), most=4.0)


def _drift(course: Callable[[World, Rng], Array]) -> None:
    @apart("structure_drift")
    def f(w: World, r: Rng, ax: int) -> Shape:
        d, series = sensed(w, r), course(w, r)
        return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=15.0)


def _follows_the_air(w: World, r: Rng) -> Array:
    """A structure that follows the air with half an hour to four hours (Bryan; ISO 230-3, ETVE)."""
    return lowpass(w.air, float(w.grid[1]), logu(r, 1800, 14400))


def _warms_up(w: World, r: Rng) -> Array:
    """From switching on towards a level with 0.15 to 0.6 of the test's time (ISO 230-3)."""
    return -3 * np.expm1(-w.grid / (float(w.grid[-1]) * r.uniform(0.15, 0.6)))


def _temperatures_times_coefficients(w: World, r: Rng) -> Array:
    """Frame and air, each times a coefficient of its own (Mayr et al., linear model)."""
    return w.frame * r.uniform(0.5, 1.0) + w.air * r.uniform(0.2, 0.6) * pick(r, [-1.0, 1.0])


for _course in (_follows_the_air, _warms_up, _temperatures_times_coefficients):
    _drift(_course)


def _growth(w: World, r: Rng, series: Array) -> Shape:
    """Nose of the spindle away from its bearings: -Z, or -X for a wheelhead across."""
    d = np.array([0.1 * r.normal(), 0.15 * r.normal(), -1.0])
    if len(w.machine.axes) == 2:
        d = np.array([-1.0, 0.0, 0.15]) if r.random() < 0.5 else np.array([0.1, 0.0, -1.0])
    return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=80.0)


@apart("spindle_growth")
def towards_a_level(w: World, r: Rng, ax: int) -> Shape | None:
    """Towards a level in proportion to speed with one time constant of 8 to 35 minutes
    (ISO 230-3)."""
    if not w.rpm.any():
        return None
    return _growth(w, r, lowpass(w.rpm / 8000, float(w.grid[1]), logu(r, 480, 2100), 0.0))


@apart("spindle_growth")
def with_its_temperature(w: World, r: Rng, ax: int) -> Shape | None:
    """In proportion to the temperature of the spindle's bearings (Mayr et al.)."""
    return _growth(w, r, w.spindle / 8) if w.rpm.any() else None


def _looked_along(w: World) -> str:
    """Letter of the axis if the lasers look along one only, else nothing."""
    seen = {
        AX[a]
        for q in w.recs
        if q.laser
        for a in w.machine.axes
        if abs(q.meta["sensitive"][a]) > 0.1
    }
    return seen.pop() if len(seen) == 1 else ""


def rule_of_thumb(w: World) -> Array:
    """Index of air (1e-3 um per mm) from 20 C and the standard's pressure: 1e-6 for each K, and for
    each 3.3 hPa (XL-80)."""
    return 1e-3 * (-w.air + w.pressure / 3.3)


def birch_downs(w: World) -> Array:
    """The same by the updated Edlen equation for dry air."""

    def index(p: Array, t: Array) -> Array:
        dense = (1 + 1e-8 * (0.601 - 0.00972 * t) * p) / (1 + 0.003661 * t)
        return 2.7653e-4 * p / 96095.43 * dense

    p, t = 101325.0 + 100 * w.pressure, 20.0 + w.air
    at_20 = index(np.array(101325.0), np.array(20.0))
    return 1e3 * (index(p, t) - at_20)


@apart("laser_air")
def not_compensated(w: World, r: Rng, ax: int) -> Shape | None:
    """The laser assumes the standard's air all the time (XL-80 without its unit)."""
    if not lasers(w, ax):
        return None
    far, left = r.random() < 0.5, rule_of_thumb(w)

    def field(q: Rec, a: float) -> Part:
        return Part(reading=a * w.at(left, q.t) * beam(w, q, far)) if q.laser else Part()

    return Shape(field, _looked_along(w), most=4.0)


@apart("laser_air")
def set_once_a_file(w: World, r: Rng, ax: int) -> Shape | None:
    """Air that is entered as each file begins; what it does from then on is left (ISO 230-2, annex;
    Birch and Downs)."""
    if not lasers(w, ax):
        return None
    far, left = r.random() < 0.5, birch_downs(w)

    def field(q: Rec, a: float) -> Part:
        n = w.at(left, q.t)
        return Part(reading=a * (n - n[0]) * beam(w, q, far)) if q.laser else Part()

    return Shape(field, _looked_along(w), most=4.0)


def _dead(index: Callable[[World], Array]) -> None:
    @apart("dead_path")
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        """Dead path of 200 to 1500 mm times what the air's index has done since the zero."""
        if not lasers(w, ax):
            return None
        side, long, left = pick(r, [-1.0, 1.0]), r.uniform(200, 1500), index(w)

        def field(q: Rec, a: float) -> Part:
            n = w.at(left, q.t)
            return Part(reading=a * side * long * (n - n[0])) if q.laser else Part()

        return Shape(field, "", most=4.0)


for _index in (rule_of_thumb, birch_downs):  # XL-80; Estler
    _dead(_index)


def _misaligned(every: bool) -> None:
    @apart("cosine")
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        """Short by half the square of the beam's angle, in all files along the axis or in one."""
        mine = [q.name for q in lasers(w, ax)]
        if not mine:
            return None
        off = mine if every else [pick(r, mine)]

        def field(q: Rec, a: float) -> Part:
            if q.name not in off:
                return Part()
            x = q.pos @ q.meta["sensitive"]
            return Part(reading=-a * (x - x.min()) / 1e3)

        return Shape(field, AX[ax])


for _every in (True, False):  # ISO 230-1; Slocum
    _misaligned(_every)


def _recorder(effect: str, field: Callable[[Rec, float, Array], Array], linear: bool) -> None:
    """Files field(q, a, c) (um, n x 3) of traces; c holds constants 0..1."""

    @apart(effect)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        if not any(q.kind == "trace" for q in w.recs):
            return None
        c = r.uniform(0, 1, 2)
        return Shape(
            lambda q, a: Part(reading=field(q, a, c)) if q.kind == "trace" else Part(),
            "",
            lambda a: {"delay_ms": a} if effect == "delay" else {},
            linear=linear,
        )


def _transport(q: Rec, a: float, c: Array) -> Array:
    """Samples that are stamped a milliseconds late: the way of that time before."""
    t = q.t - q.t[0]
    was = np.stack([np.interp(t - a / 1e3, t, q.pos[:, i]) for i in range(3)], 1)
    return 1e3 * (was - q.pos)


def _butterworth(q: Rec, a: float, c: Array) -> Array:
    """A Butterworth filter of the second order against aliasing, sampled: late by the root of two
    over its corner (rad/s, warped so that the delay of a steady speed is a)."""
    rate = q.meta["rate"]
    corner = rate / np.pi * np.arctan(1e3 / (np.sqrt(2) * rate * max(a, 1e-3)))
    num, den = butter(2, corner, fs=rate)
    way = q.pos - q.pos[0]
    return 1e3 * (lfilter(num, den, way, axis=0) - way)


def _wrong_rate(q: Rec, a: float, c: Array) -> Array:
    """A clock that is slow or fast: late in proportion to the time since the file began."""
    u = (q.t - q.t[0]) / max(float(np.ptp(q.t)), 1e-9)
    return -a * q.vel * u[:, None]


def _warming_clock(q: Rec, a: float, c: Array) -> Array:
    """A clock whose rate comes to rest as the recorder warms up: an exponential towards a level."""
    u = (q.t - q.t[0]) / max(float(np.ptp(q.t)), 1e-9)
    tau = 0.2 + 0.6 * c[0]
    return -a * q.vel * (np.expm1(-u / tau) / np.expm1(-1 / tau))[:, None]


_recorder("delay", _transport, linear=False)
_recorder("delay", _butterworth, linear=False)
_recorder("clock_skew", _wrong_rate, linear=True)
_recorder("clock_skew", _warming_clock, linear=True)
