"""Noise of a channel: one fast kind plus up to three slow ones, with their exact covariance.

Kinds (open): white, student (variance finite, 3-6 dof), ar1, ar2, bursts (variance switching),
ou (Ornstein-Uhlenbeck), walk (Wiener), iou (integrated OU), flicker (1/f as a sum of OU over
decades, Milotti 1995), settle (exponential after set-up), quant (rounding), outlier.
Held: modulated (periodic variance), arma (moving-average part), levy (jumps that relax),
hum (narrow-band, unstable frequency), tempwander (follows the room), telegraph (two states).
Fresh, sealed, unseen, later, apart, distant: see LATER; the modules that file the last ones are not
for who works on the judged tool.
A slow kind is given to the oracle as a kernel (FITC approximation on knots in time); kinds that
are not Gaussian enter with their second moments.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.signal import lfilter

from .base import Array, Rec, Rng, logu, pick
from .registry import ALONE
from .world import World, lowpass

FAST = ["white", "student", "bursts"]
FAST_TRACE = [*FAST, "ar1", "ar1", "ar2"]
SLOW = ["ou", "ou", "walk", "iou", "flicker", "settle"]
HELD_FAST, HELD_FAST_TRACE = ["modulated"], ["modulated", "arma"]
HELD_SLOW = ["levy", "hum", "tempwander", "telegraph"]
HELD_KINDS = sorted(set(HELD_FAST_TRACE + HELD_SLOW))
Kernel = Callable[[Array, Array], Array]
LATER: dict[str, dict[str, list[str]]] = {
    "held": {
        "fast": HELD_FAST,
        "trace": HELD_FAST_TRACE,
        "slow": HELD_SLOW,
        "parts": HELD_FAST,
        "all": HELD_KINDS,
    }
}


@dataclass
class Noise:
    """A drawn noise: values (um), diagonal variance, whitening filter, slow kernels, columns."""

    values: Array
    var: Array
    spec: list[dict[str, Any]]
    white_b: list[float] = field(default_factory=lambda: [1.0])
    white_a: list[float] = field(default_factory=lambda: [1.0])
    kernels: list[tuple[Kernel, Array]] = field(default_factory=list)
    columns: list[Array] = field(default_factory=list)
    quant: float = 0.0
    gone: Array | None = None


FastKind = Callable[[Rng, float, Rec], Noise]
SlowKind = Callable[[Rng, Noise, float, Rec, World, int], None]
MORE_FAST: dict[str, FastKind] = {}
MORE_SLOW: dict[str, SlowKind] = {}
LOSSES: dict[str, Callable[[Rng, Rec], Array | None]] = {}  # rows that are missing, by family


def ou(r: Rng, t: Array, tau: float) -> Array:
    """Exact unit OU at irregular times."""
    f = np.exp(-np.maximum(np.diff(t), 0) / tau)
    e = r.normal(size=len(t))
    if len(t) > 2 and np.ptp(f) < 1e-9:
        e[1:] *= np.sqrt(1 - f[0] ** 2)
        return lfilter([1.0], [1.0, -f[0]], e)
    x = np.empty(len(t))
    x[0] = e[0]
    s = np.sqrt(1 - f * f)
    for i in range(1, len(t)):
        x[i] = f[i - 1] * x[i - 1] + s[i - 1] * e[i]
    return x


def k_ou(s2: float, tau: float, wt: Array | None = None) -> Kernel:
    """Kernel s2 exp(-|dt|/tau)."""
    return lambda a, b: s2 * np.exp(-np.abs(a[:, None] - b) / tau)


def k_iou(s2: float, tau: float) -> Kernel:
    """Kernel of the integral of an OU process that starts at 0."""

    def k(a: Array, b: Array) -> Array:
        lo = np.minimum(a[:, None], b)
        e = np.exp
        return s2 * (
            2 * lo / tau - 1 + e(-a / tau)[:, None] + e(-b / tau) - e(-np.abs(a[:, None] - b) / tau)
        )

    return k


def fast(r: Rng, kind: str, s: float, t: Array, regular: bool) -> Noise:
    """The fast part with marginal standard deviation s (um)."""
    n, spec = len(t), {"kind": kind, "sd_um": round(s, 4)}
    var = np.full(n, s * s)
    if kind == "student":
        nu = float(r.uniform(3.2, 6))
        v = r.standard_t(nu, n) * s * np.sqrt((nu - 2) / nu)
        return Noise(v, var, [{**spec, "dof": round(nu, 2)}])
    if kind == "bursts":
        up, ratio = np.zeros(n, bool), r.uniform(2, 5)
        for _ in range(int(r.integers(1, 5))):
            i = int(r.integers(0, n))
            up[i : i + max(2, int(n * r.uniform(0.02, 0.15)))] = True
        sd = np.where(up, s * ratio, s)
        return Noise(r.normal(0, sd), sd**2, [{**spec, "ratio": round(ratio, 2)}])
    if kind == "modulated":
        p = (t[-1] - t[0] + 1) / r.uniform(1.5, 12)
        sd = s * (1 + 0.8 * np.sin(2 * np.pi * t / p + r.uniform(0, 6.3)))
        return Noise(r.normal(0, 1, n) * sd, sd**2, [{**spec, "period_s": round(p, 3)}])
    if kind in ("ar1", "ar2", "arma"):
        rho = float(r.uniform(0.3, 0.99))
        a, b = [1.0, -rho], [1.0]
        if kind == "ar2":
            mod, w = np.sqrt(rho), r.uniform(0.05, 0.8)
            a = [1.0, -2 * mod * np.cos(w), mod * mod]
        if kind == "arma":
            b = [1.0, float(r.uniform(-0.7, 0.7))]
        h = lfilter(b, a, np.r_[1.0, np.zeros(4000)])
        q = s / np.sqrt((h**2).sum())
        v = lfilter(b, a, r.normal(0, q, n + 2000))[2000:]
        return Noise(v, np.full(n, q * q), [{**spec, "rho": round(rho, 3)}], b, a)
    return Noise(r.normal(0, s, n), var, [spec])


def add_slow(
    r: Rng, noise: Noise, kind: str, s: float, t: Array, world: World, t_abs: Array
) -> None:
    """Add a slow kind of size s (rms, or rms at the end of the file; um)."""
    span = max(t[-1], 1.0)
    spec: dict[str, Any] = {"kind": kind, "um": round(s, 4)}
    tau = logu(r, 20, 7200)
    if kind == "ou":
        noise.values += s * ou(r, t, tau)
        noise.kernels.append((k_ou(s * s, tau), t))
        spec["tau_s"] = round(tau, 1)
    elif kind == "walk":
        q = s / np.sqrt(span)
        noise.values += q * np.cumsum(r.normal(size=len(t)) * np.sqrt(np.diff(t, prepend=t[0])))
        noise.kernels.append((lambda a, b: q * q * np.minimum(a[:, None], b), t))
    elif kind == "iou":
        tau = min(tau, span)
        x = ou(r, t, tau)
        x = np.r_[0, np.cumsum((x[1:] + x[:-1]) / 2 * np.diff(t))] / tau
        g = s / np.sqrt(max(k_iou(1.0, tau)(t[-1:], t[-1:])[0, 0], 1e-9))
        noise.values += g * x
        noise.kernels.append((k_iou(g * g, tau), t))
        spec["tau_s"] = round(tau, 1)
    elif kind == "flicker":
        taus = np.geomspace(max(span / 80, 1e-3), span * 8, 5)
        for u in taus:
            noise.values += s / np.sqrt(5) * ou(r, t, u)
        noise.kernels.append((lambda a, b: sum(k_ou(s * s / 5, u)(a, b) for u in taus), t))
    elif kind == "settle":
        tau = logu(r, 60, 2400)
        c = s * 1.5 * np.exp(-t / tau)
        noise.values += c * r.normal()
        noise.columns.append(c)
        spec["tau_s"] = round(tau, 1)
    elif kind == "levy":
        tau, rate = span * r.uniform(0.02, 0.1), r.uniform(2, 8) / span
        x, v = np.zeros(len(t)), 1 / np.sqrt(rate * tau / 2)
        for tj in np.sort(r.uniform(-3 * tau, span, r.poisson(rate * (span + 3 * tau)))):
            jump = np.clip(r.standard_t(2.2), -6, 6) / 2.0
            x += v * jump * np.where(t >= tj, np.exp(-np.maximum(t - tj, 0) / tau), 0)
        noise.values += s * x
        noise.kernels.append((k_ou(s * s, tau), t))
    elif kind == "hum":
        f = logu(r, 3 / span, max(4 / span, min(1 / 60, 40 / span)))
        if world.family == "held" and len(t) > 1500 and r.random() < 0.5:
            f = logu(r, 2, 9) if span > 5 else 20.0
        tc = max(span * r.uniform(0.2, 1.0), 3 / f)
        for trig in (np.cos(2 * np.pi * f * t), np.sin(2 * np.pi * f * t)):
            noise.values += s * trig * ou(r, t, tc)
            noise.kernels.append((modulate(k_ou(s * s, tc), trig, t), t))
        spec["frequency_hz"] = f
    elif kind == "tempwander":
        x = world.at(lowpass(world.air, world.grid[1], logu(r, 120, 1800)), t_abs)
        x = x - x[0]
        c = s * x / max(float(x.std()), 0.05)
        noise.values += c * r.normal()
        noise.columns.append(c)
    elif kind == "telegraph":
        tau = logu(r, span / 60, span / 4)
        flips = np.cumsum(r.exponential(2 * tau, 400))
        noise.values += s * pick(r, [-1, 1]) * (1 - 2 * (np.searchsorted(flips, t) % 2))
        noise.kernels.append((k_ou(s * s, tau), t))
    noise.spec.append(spec)


def modulate(k: Kernel, trig: Array, t: Array) -> Kernel:
    """Kernel of a slow envelope times a sinusoid, the envelope at the knots."""

    def f(a: Array, b: Array) -> Array:
        return k(a, b)

    f.trig = trig  # type: ignore[attr-defined]
    return f


def spread(rows: Array, n: int) -> Array:
    """Rows that a whitening filter of reach n draws from the given ones (bool)."""
    return np.convolve(rows, np.ones(n))[: len(rows)] > 0.5


def draw_noise(r: Rng, rec: Rec, world: World, held: bool, harsh: bool) -> list[Noise]:
    """Noise for each channel of a file; the kinds are shared by the channels of a file."""
    trace = rec.kind in ("trace", "ballbar")
    scale = {"trace": (0.05, 0.5), "ballbar": (0.1, 0.8), "features": (0.3, 1.2)}
    lo, hi = scale.get(rec.kind, (0.05, 1.5 if harsh else 1.0))
    sd = logu(r, lo, hi)
    fasts = FAST_TRACE if trace else FAST
    alone = world.family in ALONE
    held = held or alone
    own = LATER[world.family if held else "held"]
    if alone or (held and r.random() < 0.5):
        fasts = own["trace" if trace else "parts" if rec.kind == "features" else "fast"]
    kinds = [pick(r, fasts)]
    pool = own["slow"] if alone else SLOW + (own["slow"] * 2 if held else [])
    many = int(r.integers(1, 4)) if harsh else int(pick(r, [0, 1, 1, 2]))
    kinds += [pick(r, pool) for _ in range(many)] if rec.kind != "features" else []
    if held and not set(kinds) & set(own["all"]):
        kinds[1 if len(kinds) > 1 else 0 : 2] = (
            [pick(r, own["slow"])] if len(kinds) > 1 else own["fast"][:1]
        )
    sizes = [logu(r, 0.1, 3.0 if harsh else 1.5) for _ in kinds[1:]]
    quant = float(pick(r, [0.01, 0.1, 0.1, 0.5, 1.0])) if r.random() < 0.35 else 0.0
    if rec.kind == "trace" and quant > 0.1:
        quant = 0.1
    out = []
    t = rec.t_obs - rec.t_obs[0]
    gross = r.random() < (0.5 if harsh else 0.2)
    gone = LOSSES[world.family](r, rec) if world.family in LOSSES else None
    for c in rec.channels:
        size = sd * (r.uniform(0.7, 1.4) if trace else 1)
        x = (
            MORE_FAST[kinds[0]](r, size, rec)
            if kinds[0] in MORE_FAST
            else fast(r, kinds[0], size, t, trace)
        )
        for kind, s in zip(kinds[1:], sizes, strict=False):
            if kind in MORE_SLOW:
                MORE_SLOW[kind](r, x, s, rec, world, c)
            else:
                add_slow(r, x, kind, s, t, world, rec.t_obs)
        if quant and not x.quant:  # a reading is rounded once
            x.quant = quant
            gain = (lfilter(x.white_a, x.white_b, np.r_[1.0, np.zeros(400)]) ** 2).sum()
            x.var = x.var + gain * quant**2 / 12
            x.spec.append({"kind": "quant", "um": quant})
        if gross and c == rec.channels[0]:
            i = int(r.integers(0, len(t)) if gone is None else pick(r, np.flatnonzero(~gone)))
            x.values[i] += pick(r, [-1, 1]) * (6 * sd + logu(r, 3, 30))
            x.var[i : i + (25 if len(x.white_a) > 1 else 1)] += 1e6
            x.spec.append(
                {"kind": "outlier", "row": i + 1 - (0 if gone is None else int(gone[:i].sum()))}
            )
        if gone is not None:
            x.gone = gone
            x.var = x.var + 1e8 * spread(gone, 25 if len(x.white_a) > 1 else 1)
            x.spec.append({"kind": f"{world.family}-0", "rows": int(gone.sum())})
        out.append(x)
    return out
