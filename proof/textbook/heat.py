"""Heat: screws that the nut's friction warms, the frame in the air of the room, spindles (ISO
230-3), by lags of first order; and tools that wear, or are not as large as is thought."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.special import erf

from .base import Array, Redraw, Rng, log_uniform, relaxed, sign
from .case import Case
from .geometry import EXPANSION
from .recordings import Recording
from .registry import NUISANCES, Hidden, along, form, moved, read

HEATRUN = "heatrun heatrun laser_long"
SPINDLE, PARTS = "thermal_spindle", "features"

NUISANCES["tool_wear"] = lambda c, rec: [{"r": _cutter_side(rec)}]


def _friction(rec: Recording, axis: str, tau: float) -> Array:
    """Warmth by the axis's mean speed, with a time constant, s."""
    travel = np.diff(rec.path[axis], prepend=0.0)
    dt = np.maximum(np.diff(rec.t, prepend=0.0), 1e-3)
    return relaxed(travel / dt, dt, tau)


def _screw(
    c: Case,
    r: Rng,
    warmth: Callable[[Recording], Array],
    longer: Callable[[Recording, float], Array] | None = None,
) -> Hidden:
    """A screw fixed at one end grows. warmth: of each reading, any unit; longer: mm that are warm
    between the fixed end and the nut, where not all of it is."""
    low, high = c.machine.travel[c.axis]
    fixed = low - 30 if r.random() < 0.6 else high + 30
    most = max(np.max(abs(warmth(rec))) for rec in c.recs)
    noted, seed = r.random() < 0.55, int(r.integers(1 << 30))

    def value(rec: Recording) -> Array:
        warm = (rec.pos[c.axis] - fixed) if longer is None else longer(rec, fixed)
        return EXPANSION * (warmth(rec) / most) * warm

    def after(rec: Recording, size: float) -> None:
        if noted:
            q = np.random.default_rng(seed)
            true = c.room.air(rec.t) + size * (warmth(rec) / most)
            rec.more[f"T_screw_{c.axis}_C"] = true + 0.1 * q.normal() + q.normal(0, 0.03, rec.n)

    return along(c.axis, value, after=after, most=25.0)  # K


@form("screw_heat", HEATRUN)
def whole_screw(c: Case, r: Rng) -> Hidden:
    """one time constant, whole screw, fixed bearing at one end"""
    tau = log_uniform(r, 900, 3600)
    return _screw(c, r, lambda rec: _friction(rec, c.axis, tau))


@form("screw_heat", HEATRUN)
def screw_and_nut(c: Case, r: Rng) -> Hidden:
    """two time constants (screw, then nut and bearing housing)"""
    fast, slow, k = log_uniform(r, 400, 1200), log_uniform(r, 3000, 9000), r.uniform(0.3, 0.7)

    def warmth(rec: Recording) -> Array:
        return (1 - k) * _friction(rec, c.axis, fast) + k * _friction(rec, c.axis, slow)

    return _screw(c, r, warmth)


@form("screw_heat", "heatrun")
def warm_zone(c: Case, r: Rng) -> Hidden:
    """heat only in the zone the nut runs over, bell along the screw"""
    tau = log_uniform(r, 900, 3600)
    low, high = c.machine.travel[c.axis]
    middle = r.uniform(0.35, 0.65) * (high - low) + low
    w = r.uniform(0.2, 0.35) * (high - low)

    def upto(x: Array | float) -> Array:
        return w * np.sqrt(np.pi) / 2 * erf((x - middle) / w)

    return _screw(
        c,
        r,
        lambda rec: _friction(rec, c.axis, tau),
        lambda rec, fixed: upto(rec.pos[c.axis]) - upto(fixed),
    )


def _drift(c: Case, r: Rng, value: Callable[[Recording], Array]) -> Hidden:
    """The frame goes in a direction of its own, mostly the case's axis."""
    way = {a: r.normal() * 0.3 for a in c.machine.axes}
    way[c.axis] = sign(r)
    return moved(lambda rec: {a: k * value(rec) for a, k in way.items()})


@form("structure_drift", "thermal_etve thermal_etve laser_temp", "")
def follows_room(c: Case, r: Rng) -> Hidden:
    """frame follows the room's temperature with one time constant"""
    tau = log_uniform(r, 900, 9000)
    return _drift(c, r, lambda rec: c.room.lag(rec.t, tau) - 20)


@form("structure_drift", "thermal_etve laser_long probing", "")
def warming_up(c: Case, r: Rng) -> Hidden:
    """exponential warming up after the morning start"""
    tau = log_uniform(r, 0.15 * c.span, 0.8 * c.span)
    return _drift(c, r, lambda rec: 1 - np.exp(-rec.t / tau))


@form("structure_drift", "thermal_etve", "")
def column_and_bed(c: Case, r: Rng) -> Hidden:
    """thin column at once, thick bed late (difference of two lags)"""
    fast, slow, k = log_uniform(r, 300, 1500), log_uniform(r, 5000, 15000), r.uniform(0.6, 1.2)

    def value(rec: Recording) -> Array:
        return c.room.lag(rec.t, fast) - k * c.room.lag(rec.t, slow) - 20 * (1 - k)

    return _drift(c, r, value)


def _growth(c: Case, r: Rng, value: Callable[[Recording, Array], Array]) -> Hidden:
    """A spindle grows along Z, and leans a little. value: by the speed in 10 000 rpm."""
    way = {"Z": 1.0, "X": r.normal() * 0.3, "Y": r.normal() * 0.3}
    if "Z" not in c.machine.axes:
        way[c.axis] = 1.0
    return moved(lambda rec: {a: way[a] * value(rec, rec.rpm / 1e4) for a in rec.axes})


def _lagging(rec: Recording, drive: Array, tau: float) -> Array:
    return relaxed(drive, np.diff(rec.t, prepend=rec.t[0]), tau)


@form("spindle_growth", SPINDLE, "")
def by_speed(c: Case, r: Rng) -> Hidden:
    """first order in time, proportional to speed"""
    tau = log_uniform(r, 600, 3600)
    return _growth(c, r, lambda rec, n: _lagging(rec, n, tau))


@form("spindle_growth", SPINDLE, "")
def by_bearing_power(c: Case, r: Rng) -> Hidden:
    """two time constants, speed to the power 5/3 (bearing power)"""
    fast, slow, k = log_uniform(r, 250, 900), log_uniform(r, 3000, 8000), r.uniform(0.3, 0.7)

    def value(rec: Recording, n: Array) -> Array:
        power = n ** (5 / 3)
        return (1 - k) * _lagging(rec, power, fast) + k * _lagging(rec, power, slow)

    return _growth(c, r, value)


@form("spindle_growth", SPINDLE, "")
def with_preload(c: Case, r: Rng) -> Hidden:
    """slow growth plus the prompt shift of the preloaded bearings with speed squared"""
    tau, k = log_uniform(r, 900, 3600), r.uniform(0.1, 0.3)
    return _growth(c, r, lambda rec, n: _lagging(rec, n, tau) - k * n**2)


def _cutter_side(rec: Recording, milled_only: bool = False) -> Array:
    """1 where a larger cutter makes a feature larger, -1 where smaller."""
    bore = 0.0 if milled_only else 1.0
    sides = {"pocket_size": 1.0, "boss_diameter": -1.0, "bore_diameter": bore}
    return np.array([sides.get(k, 0.0) for k in rec.parts["kind"]])


def _tool_size(c: Case, r: Rng, milled_only: bool) -> Hidden:
    if c.recs[0].turned:
        raise Redraw
    s = sign(r)
    return read(lambda rec: s * _cutter_side(rec, milled_only))


@form("tool_size", PARTS, "")
def one_tool(c: Case, r: Rng) -> Hidden:
    """all milled features of one tool"""
    return _tool_size(c, r, False)


@form("tool_size", PARTS, "")
def bores_apart(c: Case, r: Rng) -> Hidden:
    """pockets and bosses only, bores come from another tool"""
    return _tool_size(c, r, True)


def _wear(c: Case, r: Rng, curve: Callable[[Array], Array]) -> Hidden:
    """curve: wear by the share of the tool's life."""
    n = int(c.recs[0].parts["part"].max())
    life = int(np.clip(round(n * r.uniform(0.35, 0.8)), 4, 40))
    before = int(r.integers(0, max(life // 3, 1)))

    def value(rec: Recording) -> Array:
        used = ((rec.parts["part"] - 1 + before) % life) / max(life - 1, 1)
        return -_cutter_side(rec) * curve(used)

    return read(value)


@form("tool_wear", PARTS, "")
def ramp(c: Case, r: Rng) -> Hidden:
    """straight ramp with the cut length, reset at the tool change"""
    return _wear(c, r, lambda u: u)


@form("tool_wear", PARTS, "")
def three_stages(c: Case, r: Rng) -> Hidden:
    """three-stage wear curve (running in, steady, end of life), reset"""
    k, q = r.uniform(0.15, 0.35), r.uniform(0.15, 0.4)
    return _wear(c, r, lambda u: k * (1 - np.exp(-u / 0.08)) + (1 - k - q) * u + q * u**6)
