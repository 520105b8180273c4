"""Servo, inertia, vibration of a slide and lost steps; signs as in forms_motion."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick, stream
from .registry import along, both, form, tool_only
from .world import World


def lag_speed(q: Rec, ax: int, kind: str, t1: float, zeta: float) -> Array:
    """Speed (mm/s) as a loop of a given order follows it; traces only are filtered."""
    v = q.vel[:, ax]
    if q.kind != "trace" or kind == "direct":
        return v
    dt = 1 / q.meta["rate"]
    if kind == "first":
        a = 1 - np.exp(-dt / t1)
        return lfilter([a], [1, a - 1], v)
    if kind == "second":
        wn = min(1 / t1, 0.8 / dt)
        p = np.exp(-zeta * wn * dt)
        c = -2 * p * np.cos(wn * np.sqrt(1 - zeta**2) * dt)
        return lfilter([1 + c + p * p], [1, c, p * p], v)
    return v * (1 + 0.3 * np.abs(v) / max(np.abs(v).max(), 1e-9))


def _servo(kind: str, family: str) -> None:
    @form("servo_lag", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        t1, zeta = logu(r, 0.002, 0.05), r.uniform(0.4, 0.9)
        return both(
            ax,
            lambda q: -lag_speed(q, ax, kind, t1, zeta),
            params=lambda a: {"tau_ms": a} if kind != "bent" else {},
        )

    @form("servo_mismatch", kind, family)
    def g(w: World, r: Rng, ax: int) -> Shape | None:
        t1, zeta = logu(r, 0.002, 0.05), r.uniform(0.4, 0.9)
        pair = pair_of(w, r, ax)
        sign = pick(r, [-1.0, 1.0])

        def field(q: Rec, a: float) -> Part:
            v = along(q, pair[0], 0.5 * sign * a * lag_speed(q, pair[0], kind, t1, zeta))
            v -= along(q, pair[1], 0.5 * sign * a * lag_speed(q, pair[1], kind, t1, zeta))
            return Part(tool=v, scale=v)

        return Shape(
            field,
            AX[pair[0]] + AX[pair[1]],
            lambda a: {"delta_tau_ms": sign * a} if kind != "bent" else {},
        )


for _k, _f in (("direct", "open"), ("first", "open"), ("second", "open"), ("bent", "held")):
    _servo(_k, _f)


def pair_of(w: World, r: Rng, ax: int) -> list[int]:
    """A pair of axes that move in the experiment, with `ax` in it."""
    live = sorted({a for q in w.recs for a in q.moving} - {ax}) or [
        a for a in w.machine.axes if a != ax
    ]
    return sorted([ax, pick(r, live)])


def _inertia(kind: str, family: str) -> None:
    @form("inertia", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        t1, sign = logu(r, 0.005, 0.05), 1.0 if kind == "over_forward" else -1.0

        def shape(q: Rec) -> Array:
            a = q.acc[:, ax]
            if q.kind == "trace" and kind == "lagged":
                k = 1 - np.exp(-1 / q.meta["rate"] / t1)
                a = lfilter([k], [1, k - 1], a)
            return sign * a

        return both(ax, shape)


for _k, _f in (("rigid", "open"), ("lagged", "open"), ("over_forward", "held")):
    _inertia(_k, _f)


def resonate(x: Array, dt: float, hz: float, zeta: float) -> Array:
    """Unit-gain second-order resonator driven by x."""
    w = 2 * np.pi * hz
    p, c = np.exp(-zeta * w * dt), np.cos(w * np.sqrt(1 - zeta**2) * dt)
    return lfilter([1.0], [1, -2 * p * c, p * p], x)


def _vibration(kind: str, family: str) -> None:
    @form("vibration", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        rates = [1 / np.median(np.diff(q.t)) for q in w.recs if q.kind in ("trace", "ballbar")]
        if not rates:
            return None
        top = min(float(min(rates)) / 2.6, 60.0)
        hz = logu(r, min(0.8, top / 2), top)
        zeta, phase, seed = logu(r, 0.002, 0.03), r.uniform(0, 6.28), int(r.integers(2**62))
        slide = r.random() < 0.7

        def shape(q: Rec) -> Array:
            t = q.t
            dt = float(np.median(np.diff(t)))
            if kind == "forced":
                return np.sin(2 * np.pi * hz * t + phase)
            if kind == "beating":
                return np.sin(2 * np.pi * hz * t + phase) * np.cos(2 * np.pi * hz * 0.03 * t)
            if kind == "ring_down":
                y = resonate(
                    q.acc[:, ax] - np.convolve(q.acc[:, ax], np.ones(5) / 5, "same"),
                    dt,
                    hz,
                    zeta * 4,
                )
            else:
                y = resonate(stream(seed, q.name).normal(size=len(t) + 500), dt, hz, zeta)[500:]
            return y / max(float(np.abs(y).max()), 1e-12)

        out = both(ax, shape) if slide else tool_only(ax, shape)
        inner = out.field
        out.field = lambda q, a: inner(q, a) if q.kind in ("trace", "ballbar") else Part()
        out.params = lambda a: {"frequency_hz": hz}
        return out


for _k, _f in (
    ("forced", "open"),
    ("narrow_band", "open"),
    ("ring_down", "open"),
    ("beating", "held"),
):
    _vibration(_k, _f)


def _jump(kind: str, family: str) -> None:
    @form("step_loss", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        q0 = pick(r, w.recs)
        n = 1 if kind == "one" else int(r.integers(2, 4))
        t = np.sort(r.uniform(q0.t[0] + 0.15 * np.ptp(q0.t), q0.t[-1] - 0.15 * np.ptp(q0.t), n))
        sign = pick(r, [-1.0, 1.0])
        size = np.r_[1.0, r.uniform(0.4, 1, n - 1)]
        if kind == "and_back":
            size = np.r_[1.0, -0.8, 0.5][:n]
        return both(
            ax,
            lambda q: sign * ((q.t[:, None] >= t) @ size),
            params=lambda a: {"jump_um": sign * a, "t_s": float(t[0])} if n == 1 else {},
        )


for _k, _f in (("one", "open"), ("two", "open"), ("and_back", "held")):
    _jump(_k, _f)
