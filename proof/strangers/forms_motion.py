"""Friction and lost motion.

Assumed signs: the slide lags, so after a move in + the deviation is negative.  Play, wind-up
and screw errors sit between motor encoder and table: outside instruments and parts see them,
traces of the axis's own sensor do not.  Servo errors, friction (drive stiffness), stick-slip,
spikes, vibration of the slide and lost steps are seen by both.
"""

from __future__ import annotations

import numpy as np

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick, stream
from .registry import along, both, form, moving, tool_only, unit_place
from .world import World


def play(cmd: Array, width: float) -> Array:
    """Dead-band play operator (Visintin 1994): state - command, in the unit of cmd."""
    h, out, s = width / 2, [], float(cmd[0])
    for c in cmd.tolist():
        s = c - h if s < c - h else c + h if s > c + h else s
        out.append(s - c)
    return np.array(out)


def dahl(cmd: Array, s0: float, steady: Array | None = None) -> Array:
    """Dahl (1968) bristle state in -1..1 with rest length s0 (mm); steady value optional."""
    z, out, last = 0.0, [], float(cmd[0])
    f = np.ones(len(cmd)) if steady is None else steady
    e = np.exp(-np.abs(np.diff(cmd, prepend=cmd[0])) / s0)
    for c, k, g in zip(cmd.tolist(), e.tolist(), f.tolist(), strict=False):
        if c != last:
            d = g if c > last else -g
            z = d + (z - d) * k
        last = c
        out.append(z)
    return np.array(out)


def maxwell(cmd: Array, reach: Array, share: Array) -> Array:
    """Generalised Maxwell-slip / Iwan model: weighted stop operators with reaches (mm)."""
    z, out = np.zeros(len(reach)), np.empty(len(cmd))
    unit = share / reach
    for i, d in enumerate(np.diff(cmd, prepend=cmd[0])):
        if d:
            z = np.minimum(np.maximum(z + d, -reach), reach)
        out[i] = z @ unit
    return out


@form("backlash", "play")
def backlash_play(w: World, r: Rng, ax: int) -> Shape:
    """Dead band (play operator)."""
    return Shape(
        lambda q, a: Part(tool=along(q, ax, 1e3 * play(q.via[:, ax], a / 1e3)[q.row_at])),
        AX[ax],
        lambda a: {"size_um": a},
        linear=False,
        start=8.0,
    )


@form("backlash", "tanh")
def backlash_smooth(w: World, r: Rng, ax: int) -> Shape:
    """Reversal error that goes over within a few um of travel."""
    s0 = logu(r, 0.003, 0.03)
    return tool_only(
        ax,
        lambda q: -0.5 * q.sgn[:, ax] * (2 * np.tanh(q.since[:, ax] / s0) - 1),
        params=lambda a: {"size_um": a},
    )


@form("backlash", "gap_and_spring", "held")
def backlash_spring(w: World, r: Rng, ax: int) -> Shape:
    """Gap followed by a spring: most of the loss at once, a rest over 20-80 um."""
    s0 = logu(r, 0.02, 0.08)
    return tool_only(
        ax,
        lambda q: -0.5 * q.sgn[:, ax] * (1 - 0.3 * np.exp(-q.since[:, ax] / s0)),
        params=lambda a: {"size_um": a},
    )


def lost(name: str, family: str, profile) -> None:
    """Files a form of backlash_position whose size over place (0..1) is profile(r)(s)."""

    @form("backlash_position", name, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        g = profile(r)
        return tool_only(ax, lambda q: -0.5 * q.sgn[:, ax] * g(unit_place(w, ax, q)))


def _worn(r: Rng):
    c, d = r.uniform(0.3, 0.7), r.uniform(0.1, 0.2)
    return lambda s: 0.15 + np.exp(-0.5 * ((s - c) / d) ** 2)


def _ends(r: Rng):
    k = pick(r, [-1, 1])
    return lambda s: 0.5 + 0.9 * k * (s - 0.5) + 0.1


def _spline(r: Rng):
    from scipy.interpolate import PchipInterpolator

    y = np.abs(r.normal(0.5, 0.5, 6))
    return PchipInterpolator(np.linspace(-0.1, 1.1, 6), y)


def _steps(r: Rng):
    c = r.uniform(0.3, 0.7)
    return lambda s: 0.2 + 1.0 / (1 + np.exp(-(s - c) / 0.03))


lost("worn_middle", "open", _worn)
lost("growing", "open", _ends)
lost("spline", "open", _spline)
lost("two_zones", "held", _steps)


def _windup(kind: str, family: str) -> None:
    @form("windup", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        s0 = logu(r, 0.02, 8)
        n = int(r.integers(4, 16))
        reach, share = s0 * r.lognormal(0, 1, n), r.dirichlet(np.ones(n))
        vs = logu(r, 1, 30)

        def state(q: Rec) -> Array:
            x = q.via[:, ax]
            if kind == "maxwell_slip":
                return maxwell(x, reach, share)
            if kind == "lugre":
                dt = np.maximum(np.diff(q.via_t, prepend=q.via_t[0] - 1), 1e-4)
                v = np.abs(np.diff(x, prepend=x[0])) / dt
                return dahl(x, s0, 1 + 0.4 * np.exp(-((v / vs) ** 2)))
            if kind == "torsion":
                g = 0.4 + 0.6 * (x - w.machine.travel[ax][0]) / np.ptp(w.machine.travel[ax])
                return g * dahl(x, s0)
            return dahl(x, s0)

        return tool_only(ax, lambda q: -state(q)[q.row_at])


for _k, _f in (("dahl", "open"), ("maxwell_slip", "open"), ("lugre", "open"), ("torsion", "held")):
    _windup(_k, _f)


def _spike(kind: str, family: str) -> None:
    @form("reversal_spike", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        s0, t0 = logu(r, 0.02, 2.0), logu(r, 0.03, 0.4)

        def shape(q: Rec) -> Array:
            s, t = q.since[:, ax], q.revt[:, ax]
            y = {
                "distance": np.exp(-s / s0),
                "time": t / t0 * np.exp(1 - t / t0),
                "rebound": np.exp(-t / t0) * np.cos(2 * np.pi * t / (3 * t0)) * (t < 9 * t0),
            }
            return -q.sgn[:, ax] * y[kind]

        return both(ax, shape)


for _k, _f in (("distance", "open"), ("time", "open"), ("rebound", "held")):
    _spike(_k, _f)


def _saw(kind: str, family: str) -> None:
    @form("stick_slip", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        seg, top = logu(r, 0.05, 1.5), logu(r, 2, 10)
        per, seed = logu(r, 0.1, 1.5), int(r.integers(2**62))

        def shape(q: Rec) -> Array:
            v = np.abs(q.vel[:, ax])
            slow = (v < top) & (v > 1e-4)
            if kind == "in_distance":
                ph = (q.since[:, ax] / seg) % 1.0
            elif kind == "in_time":
                ph = (q.revt[:, ax] / per) % 1.0
            else:
                g = stream(seed, q.name)
                edge = np.cumsum(seg * g.uniform(0.4, 1.6, 6000))
                ph = q.since[:, ax] - np.r_[0, edge][np.searchsorted(edge, q.since[:, ax])]
                ph = ph / seg
            return -q.sgn[:, ax] * slow * ph

        return both(ax, shape)


for _k, _f in (("in_distance", "open"), ("in_time", "open"), ("random_slips", "held")):
    _saw(_k, _f)


def _friction(effect: str, kind: str, family: str) -> None:
    @form(effect, kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        vs, ratio = logu(r, 2, 20), r.uniform(0.3, 0.6)

        def shape(q: Rec) -> Array:
            v, s = q.vel[:, ax], moving(q, ax)
            u = np.abs(v) / max(w.machine.vmax / 60, 1e-9)
            y = {
                "sign": s,
                "smooth": np.tanh(v / 0.2),
                "stribeck": s * (1 + 0.4 * np.exp(-((v / vs) ** 2))),
                "linear": v,
                "power": np.sign(v) * u**0.8,
                "two_thirds": np.sign(v) * u**0.67,
                "two_levels": np.where(s > 0, 1.0, np.where(s < 0, -ratio, 0.0)),
                "bias": 0.35 * s + 0.65 * np.abs(s),
                "speed_bias": np.where(v > 0, 1.0, ratio) * np.sign(v) * u**0.4,
            }
            return -y[kind]

        out = both(ax, shape)
        out.current = lambda q, a: -a * shape(q) * w.machine.stiffness[ax] / 400  # type: ignore
        return out


for _e, _k, _f in (
    ("coulomb_friction", "sign", "open"),
    ("coulomb_friction", "smooth", "open"),
    ("coulomb_friction", "stribeck", "held"),
    ("viscous_friction", "linear", "open"),
    ("viscous_friction", "power", "open"),
    ("viscous_friction", "two_thirds", "held"),
    ("friction_asymmetry", "two_levels", "open"),
    ("friction_asymmetry", "bias", "open"),
    ("friction_asymmetry", "speed_bias", "held"),
):
    _friction(_e, _k, _f)
