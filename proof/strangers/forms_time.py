"""Heat, drift, spindle, and the measuring instrument.

Heat moves the tool (outside instruments, parts), not the axis's own sensor.  Screw: 11.5 um/m/K
from the fixed bearing.  Air: dn/dT = -0.93e-6/K, dn/dp = +0.27e-6/hPa (Ciddor 1996, ISO 230-2
annex); a beam that is not compensated reads short when the air is warm.  Cosine: reads short.
"""

from __future__ import annotations

import numpy as np

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick
from .registry import form, tool_only
from .world import World, lowpass


def screw_field(w: World, ax: int, flip: bool, nodes: int = 30) -> tuple[Array, Array]:
    """1-D heat equation of a screw with the nut as moving source (Li et al. 1997): x, rise(t,x).

    Implicit Euler, diffusivity 1.3e-5 m2/s, convection 1/1500 s; unit is the lumped rise's.
    """
    lo, hi = w.machine.travel[ax]
    x = np.linspace(lo, hi, nodes)
    step = max(1, len(w.grid) // 600)
    t = w.grid[::step]
    dt, dx = t[1], (x[1] - x[0]) / 1e3
    k = 1.3e-5 * dt / dx**2
    lap = np.diag(np.full(nodes, 1 + 2 * k + dt / 1500)) - k * (
        np.eye(nodes, k=1) + np.eye(nodes, k=-1)
    )
    lap[0, 0] -= k
    lap[-1, -1] -= k
    inv = np.linalg.inv(lap)
    via_t = np.concatenate([q.via_t for q in w.recs])
    via_x = np.concatenate([q.via[:, ax] for q in w.recs])
    nut = np.interp(t, via_t, via_x)
    span = max(float(np.ptp(via_x)), 0.15 * (hi - lo)) / 2
    rise, out = np.zeros(nodes), np.zeros((len(t), nodes))
    duty = np.add.reduceat(w.duty[ax], np.arange(0, len(w.grid), step))[: len(t)]
    for i in range(len(t)):
        src = np.exp(-0.5 * ((x - nut[i]) / (0.6 * span)) ** 2)
        rise = inv @ (rise + duty[i] * src / src.sum())
        out[i] = rise
    grow = np.cumsum(out, 1) if not flip else -np.cumsum(out[:, ::-1], 1)[:, ::-1]
    top = max(float(np.abs(grow).max()), 1e-12)
    return t, grow / top * float(w.screw[ax].max()) * (hi - lo)


def _screw(kind: str, family: str) -> None:
    @form("screw_heat", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        lo, hi = w.machine.travel[ax]
        flip = r.random() < 0.5
        fix = hi + 40 if flip else lo - 40
        fast = lowpass(w.duty[ax], w.grid[1], 240, 0.0)
        fast = fast / max(float(fast.max()), 1e-9) * float(w.screw[ax].max())
        cache: dict[str, Array] = {}

        def shape(q: Rec) -> Array:
            x = q.pos[:, ax]
            if kind == "moving_source":
                if not cache:
                    cache["t"], cache["g"] = screw_field(w, ax, flip)
                from scipy.interpolate import RegularGridInterpolator

                g = RegularGridInterpolator(
                    (cache["t"], np.linspace(lo, hi, 30)),
                    cache["g"],
                    bounds_error=False,
                    fill_value=None,
                )
                return 0.0115 * g(np.c_[q.t, x])
            rise = w.at(w.screw[ax], q.t)
            if kind == "two_constants":
                rise = 0.6 * rise + 0.4 * w.at(fast, q.t)
            y = x - fix
            if kind == "stretched_both_ends":
                s = (x - lo) / (hi - lo)
                y = (hi - lo) * s * (1 - s) * 0.8 + 0.15 * y
            return 0.0115 * rise * y

        return tool_only(ax, shape, most=2.0)


for _k, _f in (
    ("lumped", "open"),
    ("moving_source", "open"),
    ("two_constants", "open"),
    ("stretched_both_ends", "held"),
):
    _screw(_k, _f)


def sensed(w: World, r: Rng) -> Array:
    """A direction that some outside file senses, with a smaller part across; unit vector."""
    d = np.zeros(3)
    for q in w.recs:
        if q.kind == "targets" and q.meta["quantity"] != "angle":
            d += q.meta["sensitive"] * r.uniform(0.3, 1)
        elif q.outside and q.kind in ("trace", "ballbar"):
            for a in q.moving:
                d[a] += r.normal()
    for a in w.machine.axes:
        d[a] += 0.2 * r.normal()
    return d / np.linalg.norm(d) * pick(r, [-1.0, 1.0])


def _drift(kind: str, family: str) -> None:
    @form("structure_drift", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        d, end, dt = sensed(w, r), float(w.grid[-1]), float(w.grid[1])
        tau, tau2 = end * r.uniform(0.1, 0.8), logu(r, 300, 7200)
        door, k = r.uniform(0.1, 0.8) * end, r.uniform(0.3, 0.9)
        cycle, ph = r.uniform(15, 40) * 60, r.uniform(0, 6.28)
        g = w.grid
        series = {
            "frame": w.frame,
            "room_lagged": lowpass(w.air, dt, tau2),
            "warm_up": 3 * (1 - np.exp(-g / tau)),
            "hvac": np.sin(2 * np.pi * g / cycle + ph),
            "door": 2 * (g > door) * (1 - np.exp(-np.maximum(g - door, 0) / 700)),
            "two_lags": k * lowpass(w.air, dt, 600) - (1 - k) * lowpass(w.air, dt, 9000),
            "creep": 2 * np.log1p(g / 300),
        }[kind]
        return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=15.0)


for _k, _f in (
    ("frame", "open"),
    ("room_lagged", "open"),
    ("warm_up", "open"),
    ("hvac", "open"),
    ("door", "open"),
    ("two_lags", "held"),
    ("creep", "held"),
):
    _drift(_k, _f)


def _spindle(kind: str, family: str) -> None:
    @form("spindle_growth", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        if not w.rpm.any():
            return None
        p, t1, dt = r.uniform(1, 2), logu(r, 300, 2400), float(w.grid[1])
        s = (w.rpm / 8000) ** p
        y = lowpass(s, dt, t1, 0.0)
        if kind == "two_constants":
            y = 0.6 * y + 0.4 * lowpass(s, dt, t1 * 4, 0.0)
        if kind == "with_shift":  # balls move out at once, housing follows
            y = 0.25 * (w.rpm / 8000) ** 2 + 0.75 * y
        if kind == "sink":  # shaft grows, then the headstock gives way
            y = y - 0.4 * lowpass(s, dt, t1 * 6, 0.0)
        d = np.array([0.25 * r.normal(), 0.0, -1.0])
        if len(w.machine.axes) == 2 and r.random() < 0.5:
            d = np.array([-1.0, 0.0, 0.3 * r.normal()])
        return Shape(lambda q, a: Part(tool=a * w.at(y, q.t)[:, None] * d), "", most=80.0)


for _k, _f in (
    ("one_constant", "open"),
    ("two_constants", "open"),
    ("with_shift", "open"),
    ("sink", "held"),
):
    _spindle(_k, _f)


def lasers(w: World, ax: int) -> list[Rec]:
    """Displacement laser files that sense an axis."""
    return [q for q in w.recs if q.laser and abs(q.meta["sensitive"][ax]) > 0.1]


def beam(w: World, q: Rec, far: bool) -> Array:
    """Signed beam length (mm) along `sensitive`, from an interferometer beyond one end."""
    x = q.pos @ q.meta["sensitive"]
    return x - x.max() - 60 if far else x - x.min() + 60


def _light(effect: str, kind: str, family: str) -> None:
    @form(effect, kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        if not lasers(w, ax):
            return None
        far, dead = r.random() < 0.5, r.uniform(300, 2500)
        dt, k = float(w.grid[1]), r.uniform(0.3, 1)
        warm = -0.93e-3 * w.air + 0.27e-3 * w.pressure * (0.2 if kind == "temperature" else 1)
        if kind == "pressure":
            warm = 0.27e-3 * w.pressure
        if kind == "late_sensor":
            warm = -0.93e-3 * (w.air - lowpass(w.air, dt, 1800)) + 0.27e-3 * w.pressure * k
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
            n = w.at(warm, q.t)
            if effect == "dead_path":
                return Part(reading=a * dead * (n - n[0]) * (-1 if far else 1))
            return Part(reading=a * n * beam(w, q, far))

        name = AX[seen[0]] if len(seen) == 1 and effect == "laser_air" else ""
        return Shape(field, name, most=3.0)


for _e in ("laser_air", "dead_path"):
    for _k, _f in (("temperature", "open"), ("pressure", "open"), ("late_sensor", "held")):
        _light(_e, _k, _f)


def _cosine(kind: str, family: str) -> None:
    @form("cosine", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        mine = lasers(w, ax)
        if not mine:
            return None
        one = pick(r, mine).name
        walk = r.uniform(0.05, 0.3)

        def field(q: Rec, a: float) -> Part:
            if not q.laser or (q not in mine if kind == "fixture" else q.name != one):
                return Part()
            x = q.pos @ q.meta["sensitive"]
            x = x - x.min()
            y = -x / 1e3
            if kind == "beam_walk":
                y = y - walk * (x / 1e3) ** 2 / max(float(x.max()) / 1e3, 1e-6)
            if kind == "mirror_tilt":
                y = y * 2 + 0.05 * np.sin(2 * np.pi * x / max(float(x.max()), 1e-6)) * y
            return Part(reading=a * y)

        return Shape(field, AX[ax])


for _k, _f in (
    ("one_setup", "open"),
    ("fixture", "open"),
    ("beam_walk", "open"),
    ("mirror_tilt", "held"),
):
    _cosine(_k, _f)


def _late(effect: str, kind: str, family: str) -> None:
    @form(effect, kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        if not any(q.kind == "trace" for q in w.recs):
            return None
        per = logu(r, 0.5, 5)

        def field(q: Rec, a: float) -> Part:
            if q.kind != "trace":
                return Part()
            t = q.t - q.t[0]
            if kind == "shift":
                late = np.stack([np.interp(t - a / 1e3, t, q.pos[:, c]) for c in range(3)], 1)
                return Part(reading=1e3 * (late - q.pos))
            g = {
                "taylor": 1.0,
                "wobbling": 1 + 0.3 * np.sin(2 * np.pi * t / per),
                "rate": t / max(float(t[-1]), 1e-9),
                "stepwise": np.floor(5 * t / max(t[-1], 1e-9)) / 4,
                "bent_rate": (t / max(float(t[-1]), 1e-9)) ** 2,
            }[kind]
            return Part(reading=-a * q.vel * np.reshape(g, (-1, 1) if np.ndim(g) else ()))

        return Shape(
            field,
            "",
            lambda a: {"delay_ms": a} if kind in ("shift", "taylor") else {},
            linear=kind != "shift",
        )


for _e, _k, _f in (
    ("delay", "shift", "open"),
    ("delay", "taylor", "open"),
    ("delay", "wobbling", "held"),
    ("clock_skew", "rate", "open"),
    ("clock_skew", "stepwise", "open"),
    ("clock_skew", "bent_rate", "held"),
):
    _late(_e, _k, _f)
