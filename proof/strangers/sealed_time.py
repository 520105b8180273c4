"""Heat, drift, spindle and instrument of the sealed family.  Do not read while working on the
judged tool.

Conventions as in forms_time.  Sources: Mayr et al. 2012 (Thermal issues in machine tools; CIRP
Annals 61), Slocum 1992 (stretched screws), Andrade 1910 (creep as the cube root of time), Carslaw
and Jaeger 1959 (a half-space heated at a constant rate: the square root of time), Palmgren 1959
(friction of bearings: moment as speed to the power of 2/3), ISO 230-3, Bobroff 1993 (Recent
advances in displacement measuring interferometry: paths in unlike air, optics that warm up), Edlen
1966, Estler 1985 (High-accuracy displacement interferometry in air), Allan 1987 (clocks).
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick
from .forms_time import beam, lasers, sensed
from .registry import sealed, tool_only
from .world import World, lowpass


@sealed("screw_heat")
def stretched(w: World, r: Rng, ax: int) -> Shape:
    """A stretched screw: it does not grow until its stretch is used up at 0.15 to 0.5 of the
    largest rise, then as one that is held at one end (Slocum 1992)."""
    lo, hi = w.machine.travel[ax]
    flip, used = r.random() < 0.5, r.uniform(0.15, 0.5) * float(w.screw[ax].max())
    fix = hi + 40 if flip else lo - 40
    grown = np.maximum(w.screw[ax] - used, 0.0)
    return tool_only(ax, lambda q: 0.0115 * w.at(grown, q.t) * (q.pos[:, ax] - fix), most=4.0)


@sealed("screw_heat")
def warm_zone(w: World, r: Rng, ax: int) -> Shape:
    """Only the zone where the nut works gets warm: nothing grows before it, all of it beyond (Mayr
    et al. 2012)."""
    lo, hi = w.machine.travel[ax]
    way = np.concatenate([q.via[:, ax] for q in w.recs])
    a, b = np.quantile(way, [0.05, 0.95])
    mid, half = (a + b) / 2, max((b - a) / 2, 0.1 * (hi - lo)) * r.uniform(0.5, 0.9)
    flip = r.random() < 0.5

    def f(q: Rec) -> Array:
        grow = np.clip(q.pos[:, ax] - (mid - half), 0, 2 * half)
        return 0.0115 * w.at(w.screw[ax], q.t) * (grow - 2 * half * flip)

    return tool_only(ax, f, most=4.0)


def _drift(course) -> None:
    @sealed("structure_drift")
    def f(w: World, r: Rng, ax: int) -> Shape:
        d, series = sensed(w, r), course(w, r)
        return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=15.0)


def _cube_root(w: World, r: Rng) -> Array:
    """Creep of a bed set on its mounts shortly before: the cube root of time (Andrade 1910)."""
    return 3 * np.cbrt(w.grid / w.grid[-1] + logu(r, 1e-4, 0.05))


def _lamp(w: World, r: Rng) -> Array:
    """A face heated at a constant rate from one time on: the square root of the time since."""
    return 3 * np.sqrt(np.maximum(w.grid / w.grid[-1] - r.uniform(0, 0.4), 0.0))


def _shifts(w: World, r: Rng) -> Array:
    """Coolant or hydraulics on and off by the hour: a lag that is charged and discharged (Mayr et
    al. 2012)."""
    n, end = int(r.integers(2, 6)), float(w.grid[-1])
    edges = np.sort(r.uniform(0.05, 0.95, n)) * end
    on = (np.searchsorted(edges, w.grid) + int(r.integers(2))) % 2
    return 3 * lowpass(on.astype(float), float(w.grid[1]), r.uniform(0.03, 0.25) * end)


for _course in (_cube_root, _lamp, _shifts):
    _drift(_course)


def two_rates(power: Array, dt: float, on: float, off: float) -> Array:
    """First-order rise with time constant `on` (s) while there is power and `off` without."""
    a, b = 1 - np.exp(-dt / on), 1 - np.exp(-dt / off)
    y, out = 0.0, np.empty(len(power))
    for i, p in enumerate(power.tolist()):
        y += (a if p > 0 else b) * (p - y)
        out[i] = y
    return out


@sealed("spindle_growth")
def stirred_air(w: World, r: Rng, ax: int) -> Shape | None:
    """Bearings give heat as speed to the power of 5/3 (Palmgren); a spindle that turns stirs its
    air and settles 1.5 to 4 times as soon as one that stands (ISO 230-3)."""
    if not w.rpm.any():
        return None
    tau = logu(r, 240, 1500)
    y = two_rates((w.rpm / 8000) ** (5 / 3), float(w.grid[1]), tau, tau * r.uniform(1.5, 4))
    d = np.array([0.3 * r.normal(), 0.0, -1.0])
    if len(w.machine.axes) == 2 and r.random() < 0.5:
        d = np.array([-1.0, 0.0, 0.3 * r.normal()])
    return Shape(lambda q, a: Part(tool=a * w.at(y, q.t)[:, None] * d), "", most=80.0)


def edlen(air: Array, pressure: Array) -> Array:
    """Change of the index of air (1e-6) from 20 C and 1013.25 hPa by Edlen's refractivity: as
    p / (1 + 0.003661 t), 271.8e-6 there (dry air; K, hPa)."""
    at_20 = (1 + 0.003661 * 20) / 1013.25
    n = 271.8 * (1013.25 + pressure) / (1 + 0.003661 * (20 + air)) * at_20
    return n - 271.8


def _lit(w: World) -> str:
    """Letter of the axis if the lasers look along one only, else nothing."""
    seen = {
        AX[a]
        for q in w.recs
        if q.laser
        for a in w.machine.axes
        if abs(q.meta["sensitive"][a]) > 0.1
    }
    return seen.pop() if len(seen) == 1 else ""


@sealed("laser_air")
def cold_corner(w: World, r: Rng, ax: int) -> Shape | None:
    """Edlen's index of air; the first part of the path only is in air that changes, the rest in air
    that a cover keeps (Bobroff 1993, Estler 1985)."""
    if not lasers(w, ax):
        return None
    far, share = r.random() < 0.5, r.uniform(0.4, 0.9)
    index = edlen(w.air, w.pressure)
    index = index - index[0]

    def field(q: Rec, a: float) -> Part:
        if not q.laser:
            return Part()
        b = beam(w, q, far)
        part = np.sign(b) * np.minimum(np.abs(b), share * float(np.abs(b).max()))
        return Part(reading=a * w.at(index, q.t) * 1e-3 * part)

    return Shape(field, _lit(w), most=4.0)


@sealed("dead_path")
def warm_optics(w: World, r: Rng, ax: int) -> Shape | None:
    """Edlen's index over the dead path, and optics of unlike glass paths that follow the air with a
    lag, 0.1 to 0.5 um/K (Bobroff 1993)."""
    if not lasers(w, ax):
        return None
    far, dead, glass = r.random() < 0.5, r.uniform(300, 2500), r.uniform(0.1, 0.5)
    index = edlen(w.air, w.pressure) * 1e-3
    optics = lowpass(w.air, float(w.grid[1]), logu(r, 300, 3000))

    def field(q: Rec, a: float) -> Part:
        if not q.laser:
            return Part()
        n, o = w.at(index, q.t), w.at(optics, q.t)
        sign = -1 if far else 1
        return Part(reading=a * sign * (dead * (n - n[0]) + glass * (o - o[0])))

    return Shape(field, "", most=3.0)


@sealed("cosine")
def turning_target(w: World, r: Rng, ax: int) -> Shape | None:
    """A beam that is off, and a target that turns with its table: length times the square of an
    angle that grows along the travel (Estler 1985, in the second order)."""
    mine = lasers(w, ax)
    if not mine:
        return None
    one, k = pick(r, mine).name, r.uniform(-0.3, 0.5)

    def field(q: Rec, a: float) -> Part:
        if not q.laser or q.name != one:
            return Part()
        x = q.pos @ q.meta["sensitive"]
        x = x - x.min()
        return Part(reading=-a * x / 1e3 * (1 + k * x / max(float(x.max()), 1e-6)) ** 2)

    return Shape(field, AX[ax])


@sealed("delay")
def filtered(w: World, r: Rng, ax: int) -> Shape | None:
    """An instrument with a filter of the first order: late by its time constant in all axes
    (Altintas 2012, measuring chains)."""
    if not any(q.kind == "trace" for q in w.recs):
        return None

    def field(q: Rec, a: float) -> Part:
        if q.kind != "trace":
            return Part()
        k = 1 - np.exp(-1 / q.meta["rate"] / (max(a, 1e-6) / 1e3))
        return Part(reading=-a * lfilter([k], [1, k - 1], q.vel, axis=0))

    return Shape(field, "", lambda a: {"delay_ms": a}, linear=False)


@sealed("clock_skew")
def dropped_samples(w: World, r: Rng, ax: int) -> Shape | None:
    """A recorder that loses 15 to 60 samples at random and goes on counting: stairs of even height
    (Allan 1987: phase that runs away)."""
    if not any(q.kind == "trace" for q in w.recs):
        return None
    at = np.sort(r.uniform(0.02, 0.98, int(r.integers(15, 61))))

    def field(q: Rec, a: float) -> Part:
        if q.kind != "trace":
            return Part()
        u = (q.t - q.t[0]) / max(float(q.t[-1] - q.t[0]), 1e-9)
        return Part(reading=-a * q.vel * (np.searchsorted(at, u) / len(at))[:, None])

    return Shape(field, "")
