"""Heat, drift, spindle and instrument of the fresh family.  Do not read while working on the judged
tool.

Conventions as in forms_time.  Sources: Bryan 1990, Ramesh, Mannan and Poo 2000, Mayr et al. 2012
(thermal errors), Carslaw and Jaeger 1959 (fins, rods, half-spaces), Birch and Downs 1994 (water
vapour in the refractive index), Bobroff 1993 (beam paths and optics), ISO 230-3.
"""

from __future__ import annotations

import numpy as np
from scipy.special import erfc

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick, stream
from .forms_time import beam, lasers, sensed
from .registry import fresh, tool_only
from .world import World, lowpass, slow_ou


@fresh("screw_heat")
def bearing_fin(w: World, r: Rng, ax: int) -> Shape:
    """Heat of the fixed bearing that dies away along the screw as in a fin, beside a share all
    along."""
    lo, hi = w.machine.travel[ax]
    flip, fin, share = r.random() < 0.5, r.uniform(0.15, 0.6) * (hi - lo) + 40, r.uniform(0.2, 0.6)

    def f(q: Rec) -> Array:
        d = (hi + 40 - q.pos[:, ax]) if flip else (q.pos[:, ax] - lo + 40)
        grow = (1 - share) * fin * (1 - np.exp(-d / fin)) + share * d
        return 0.0115 * w.at(w.screw[ax], q.t) * grow * (-1 if flip else 1)

    return tool_only(ax, f, most=4.0)


def _drift(course) -> None:
    @fresh("structure_drift")
    def f(w: World, r: Rng, ax: int) -> Shape:
        d, series = sensed(w, r), course(w, r)
        return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=15.0)


def _wall(w: World, r: Rng) -> Array:
    """A thick wall heated at its face: erfc, slow to begin and slower to end."""
    end = float(w.grid[-1])
    t0, tau = r.uniform(0, 0.3) * end, r.uniform(0.05, 0.5) * end
    return 3 * erfc(np.sqrt(tau / np.maximum(w.grid - t0, 1e-6))) * (w.grid > t0)


def _gradient(w: World, r: Rng) -> Array:
    """What bends a column: its skin, which follows the air soon, less its core."""
    return lowpass(w.air, float(w.grid[1]), logu(r, 60, 600)) - w.frame


_drift(_wall)
_drift(_gradient)


@fresh("spindle_growth")
def rod_modes(w: World, r: Rng, ax: int) -> Shape | None:
    """The modes of heat in a rod: time constants as 1, 1/9, 1/25 with weights alike."""
    if not w.rpm.any():
        return None
    s, tau, dt = (w.rpm / 8000) ** r.uniform(1, 2), logu(r, 1200, 6000), float(w.grid[1])
    y = sum(lowpass(s, dt, tau / k**2, 0.0) / k**2 for k in (1, 3, 5)) / (1 + 1 / 9 + 1 / 25)
    d = np.array([0.3 * r.normal(), 0.0, -1.0])
    if len(w.machine.axes) == 2 and r.random() < 0.5:
        d = np.array([-1.0, 0.0, 0.3 * r.normal()])
    return Shape(lambda q, a: Part(tool=a * w.at(y, q.t)[:, None] * d), "", most=100.0)


def _light(effect: str, where: str) -> None:
    @fresh(effect)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        if not lasers(w, ax):
            return None
        far, dead, dt = r.random() < 0.5, r.uniform(300, 2500), float(w.grid[1])
        g = stream("vapour", w.key)
        vapour = logu(g, 0.3, 3) * slow_ou(g, len(w.grid), dt, logu(g, 1800, 20000))
        index = (
            -0.93e-3 * lowpass(w.air, dt, logu(r, 10, 900))
            + 0.27e-3 * w.pressure
            - 0.037e-3 * vapour
        )
        hold = np.floor(w.grid / r.uniform(900, 3600))
        if where == "held":  # a weather station that is asked now and then: what has passed since
            first = np.unique(hold, return_index=True)[1]
            index = index - index[first][hold.astype(int)]
        seen = sorted(
            {
                a
                for q in w.recs
                if q.laser
                for a in w.machine.axes
                if abs(q.meta["sensitive"][a]) > 0.1
            }
        )

        def field(q: Rec, a: float) -> Part:
            if not q.laser:
                return Part()
            n = w.at(index, q.t)
            if effect == "dead_path":
                return Part(reading=a * dead * (n - n[0]) * (-1 if far else 1))
            b = beam(w, q, far)
            layer = (
                0.3 * np.abs(b) / max(float(np.abs(b).max()), 1.0) if where == "layered" else 0.0
            )
            return Part(reading=a * n * b * (1 + layer))

        return Shape(
            field, AX[seen[0]] if len(seen) == 1 and effect == "laser_air" else "", most=4.0
        )


for _e, _k in (("laser_air", "held"), ("laser_air", "layered"), ("dead_path", "vapour")):
    _light(_e, _k)


@fresh("cosine")
def nudged(w: World, r: Rng, ax: int) -> Shape | None:
    """A beam that is set anew for each run and never quite right: short by another amount each
    time."""
    mine = lasers(w, ax)
    if not mine:
        return None
    one, key = pick(r, mine).name, int(r.integers(2**62))

    def field(q: Rec, a: float) -> Part:
        if not q.laser or q.name != one:
            return Part()
        x = q.pos @ q.meta["sensitive"]
        each = stream(key, "runs").uniform(0.7, 1.0, int(q.run.max()) + 1)
        return Part(reading=-a * (x - x.min()) / 1e3 * each[q.run])

    return Shape(field, AX[ax])


def _late(effect: str, course) -> None:
    @fresh(effect)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        if not any(q.kind == "trace" for q in w.recs):
            return None
        k = r.uniform(0, 1, 2)

        def field(q: Rec, a: float) -> Part:
            if q.kind != "trace":
                return Part()
            t = q.t - q.t[0]
            return Part(reading=-a * q.vel * course(t, t / max(float(t[-1]), 1e-9), k)[:, None])

        return Shape(field, "", lambda a: {"delay_ms": a} if effect == "delay" else {})


def _blocks(t: Array, u: Array, k: Array) -> Array:
    """Samples that arrive in blocks of 20 to 500 ms: the first of a block waits longest; mean 1."""
    return 1 + 0.5 * k[1] * (1 - 2 * ((t / (0.02 * 25 ** k[0])) % 1.0))


def _resync(t: Array, u: Array, k: Array) -> Array:
    """A clock that runs away and is set right once on the way."""
    c = 0.35 + 0.3 * k[0]
    return np.where(u < c, u, (0.5 + k[1]) * (u - c))


def _warming(t: Array, u: Array, k: Array) -> Array:
    """A quartz that warms up: its rate settles."""
    tau = 0.15 + 0.5 * k[0]
    return (u - tau * (1 - np.exp(-u / tau))) / (1 - tau * (1 - np.exp(-1 / tau)))


_late("delay", _blocks)
_late("clock_skew", _resync)
_late("clock_skew", _warming)
