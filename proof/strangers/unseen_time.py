"""Heat, drift, spindle and instrument of the unseen family.  Do not read while working on the
judged tool.

Conventions as in forms_time.  Sources: Mayr et al. 2012 (Thermal issues in machine tools; CIRP
Annals 61), ISO 230-3 (environment, spindle and axes that warm up), Bryan 1990, Edlen 1966 and
Ciddor 1996 (index of air), Steinmetz 1990 (Sub-micron position measurement and control: dead path),
ISO 230-1 and Schwenke et al. 2008 (beams aligned anew), Mills 1991 (Internet time synchronization),
IEC 61158 (cyclic fieldbuses).
"""

from __future__ import annotations

import numpy as np

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick, stream
from .forms_time import beam, lasers, sensed
from .registry import tool_only, unseen
from .sealed_time import edlen
from .world import World, lowpass


@unseen("screw_heat")
def bearing_goes_along(w: World, r: Rng, ax: int) -> Shape:
    """A screw that grows from its fixed bearing, whose warm housing shifts as well, later (Mayr et
    al. 2012)."""
    lo, hi = w.machine.travel[ax]
    flip, share = r.random() < 0.5, r.uniform(0.05, 0.2) * (hi - lo)
    fix, side = (hi + 60, -1.0) if flip else (lo - 60, 1.0)
    housing = lowpass(w.screw[ax], float(w.grid[1]), logu(r, 900, 3600), 0.0)

    def f(q: Rec) -> Array:
        grown = w.at(w.screw[ax], q.t) * (q.pos[:, ax] - fix)
        return 0.0115 * (grown + side * share * w.at(housing, q.t))

    return tool_only(ax, f, most=1.5)


def _drift(course) -> None:
    @unseen("structure_drift")
    def f(w: World, r: Rng, ax: int) -> Shape:
        d, series = sensed(w, r), course(w, r)
        return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=15.0)


def _heating(w: World, r: Rng) -> Array:
    """A hall whose heating comes on at the start of a shift: a ramp to a new level, as a frame
    follows it (ISO 230-3, environmental variation)."""
    end = float(w.grid[-1])
    rise = np.clip((w.grid - r.uniform(0, 0.4) * end) / (r.uniform(0.1, 0.5) * end), 0, 1)
    return 3 * lowpass(rise, float(w.grid[1]), r.uniform(0.03, 0.3) * end, 0.0)


def _front_and_back(w: World, r: Rng) -> Array:
    """A column whose front warms up first and whose back follows: out and part of the way home
    (Bryan 1990; Mayr et al. 2012)."""
    tau = r.uniform(0.05, 0.25) * float(w.grid[-1])
    late, k = tau * r.uniform(2.5, 6), r.uniform(0.5, 0.9)
    return 3 * ((1 - np.exp(-w.grid / tau)) - k * (1 - np.exp(-w.grid / late)))


_drift(_heating)
_drift(_front_and_back)


@unseen("spindle_growth")
def cooled_spindle(w: World, r: Rng, ax: int) -> Shape | None:
    """Loss in proportion to speed, and a cooled jacket that takes the more the warmer it is: growth
    that flattens at high speeds; the headstock lifts a little with it (ISO 230-3)."""
    if not w.rpm.any():
        return None
    y = lowpass(w.rpm / 8000, float(w.grid[1]), logu(r, 300, 1800), 0.0)
    y = y / (1 + r.uniform(0.2, 0.8) * y / max(float(y.max()), 1e-9))
    d = np.array([0.15 * r.normal(), r.uniform(0.1, 0.5), -1.0])
    if len(w.machine.axes) == 2:
        d = np.array([-1.0, 0.0, 0.3 * r.normal()] if r.random() < 0.5 else [0.2, 0.0, -1.0])
    return Shape(lambda q, a: Part(tool=a * w.at(y, q.t)[:, None] * d), "", most=80.0)


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


@unseen("laser_air")
def entered_once(w: World, r: Rng, ax: int) -> Shape | None:
    """Temperature and pressure typed in when the laser was set up, and left: what the air does from
    there on (Edlen's index)."""
    if not lasers(w, ax):
        return None
    far, index = r.random() < 0.5, edlen(w.air, w.pressure) * 1e-3

    def field(q: Rec, a: float) -> Part:
        if not q.laser:
            return Part()
        n = w.at(index, q.t)
        return Part(reading=a * (n - n[0]) * beam(w, q, far))

    return Shape(field, _lit(w), most=4.0)


@unseen("dead_path")
def not_entered(w: World, r: Rng, ax: int) -> Shape | None:
    """A dead path that nobody entered, in air that follows the hall's by minutes; the index on the
    measured path is compensated (Steinmetz 1990; Edlen's index)."""
    if not lasers(w, ax):
        return None
    side, dead = pick(r, [-1.0, 1.0]), r.uniform(200, 1500)
    index = edlen(lowpass(w.air, float(w.grid[1]), logu(r, 60, 600)), w.pressure) * 1e-3

    def field(q: Rec, a: float) -> Part:
        if not q.laser:
            return Part()
        n = w.at(index, q.t)
        return Part(reading=a * side * dead * (n - n[0]))

    return Shape(field, "", most=2.0)


@unseen("cosine")
def aligned_anew(w: World, r: Rng, ax: int) -> Shape | None:
    """A beam at an angle whose operator aligns it better after a run or two, if he does: a fifth of
    the shortfall at most is left then (ISO 230-1)."""
    mine = lasers(w, ax)
    if not mine:
        return None
    q0, left = pick(r, mine), r.uniform(0.0, 0.2)
    runs = int(q0.run.max())
    last = int(r.integers(max(1, runs - 2), runs + 1)) if runs > 1 else 1

    def field(q: Rec, a: float) -> Part:
        if q.name != q0.name:
            return Part()
        x = q.pos @ q.meta["sensitive"]
        return Part(reading=-a * (x - x.min()) / 1e3 * np.where(q.run <= last, 1.0, left))

    return Shape(field, AX[ax])


def _late(effect: str, course) -> None:
    @unseen(effect)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        if not any(q.kind == "trace" for q in w.recs):
            return None
        c, key = r.uniform(0, 1, 2), int(r.integers(2**62))

        def field(q: Rec, a: float) -> Part:
            if q.kind != "trace":
                return Part()
            late = course(q, c, stream(key, q.name))
            return Part(reading=-a * q.vel * late[:, None])

        return Shape(field, "", lambda a: {"delay_ms": a} if effect == "delay" else {})


def _fieldbus(q: Rec, c: Array, g: Rng) -> Array:
    """Late by a few cycles of a bus, and each sample by up to a quarter of that more or less (IEC
    61158)."""
    return 1 + (0.05 + 0.2 * c[0]) * g.uniform(-1, 1, len(q.t))


def _set_right(q: Rec, c: Array, g: Rng) -> Array:
    """A clock that runs away and is set right over the network 2 to 4 times in a file (Mills)."""
    u = (q.t - q.t[0]) / max(float(q.t[-1] - q.t[0]), 1e-9)
    return (u * (2.2 + 2 * c[0]) + c[1]) % 1.0


_late("delay", _fieldbus)
_late("clock_skew", _set_right)
