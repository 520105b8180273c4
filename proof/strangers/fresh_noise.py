"""Noises of the fresh family.  Read this only if you do not work on the tool that is judged.

Fast: fresh-1 mixture of two normals whose exceedances come with speed (Tukey 1960; Huber 1964),
fresh-2 nonsubtractive triangular dither and rounding (Lipshitz, Wannamaker and Vanderkooy 1992:
total error variance Q^2/4), fresh-3 skewed contact noise (gamma; a dirty or rough contact reads to
one side), fresh-4 fractionally integrated white noise, power law 1/f^(2d) with 2d < 1 (Hosking
1981; Kasdin 1995).
Slow: fresh-5 fractional Brownian motion, power law 1/f^(2H+1) (Mandelbrot and Van Ness 1968; the
Allan variance of a power law grows with the 2H-th power of the averaging time), fresh-6 turbulence
of the air along a beam, variance growing with the path (Estler 1985; Bobroff 1993), fresh-7
switching between two states of which one is rare (Machlup 1954), fresh-8 the day's cycle of a room
nobody recorded, with its half (ISO/TR 16015; ISO 230-3, environmental test), fresh-9 a new seat at
every run (thread or cup of a ballbar, a mirror's kinematic seat).
fresh-0: captures or stretches that are missing (a broken beam, a lost radio link).

Every kind tells the oracle its exact second moments.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from .base import Array, Rec, Rng, logu, pick
from .noise import (
    LATER,
    LOSSES,
    MORE_FAST,
    MORE_SLOW,
    FastKind,
    Noise,
    SlowKind,
    k_ou,
    modulate,
    ou,
)
from .world import World

TAPS = 300  # of the autoregression that stands for a fractional difference


def fast(number: int) -> Callable[[FastKind], FastKind]:
    """Decorator that files a fast kind."""

    def add(f: FastKind) -> FastKind:
        MORE_FAST[f"fresh-{number}"] = f
        return f

    return add


def slow(number: int) -> Callable[[SlowKind], SlowKind]:
    """Decorator that files a slow kind."""

    def add(f: SlowKind) -> SlowKind:
        MORE_SLOW[f"fresh-{number}"] = f
        return f

    return add


def speed_of(rec: Rec) -> Array:
    """0..1: path speed in motion, feed of the last move at rest; constants become 0.5."""
    v = np.linalg.norm(rec.vel, axis=1) if rec.kind in ("trace", "ballbar") else rec.feed
    v = v[::2] if rec.kind == "features" else v
    return (v - v.min()) / np.ptp(v) if np.ptp(v) > 1e-6 * abs(v).max() else np.full(rec.n_obs, 0.5)


@fast(1)
def exceeding(r: Rng, s: float, rec: Rec) -> Noise:
    """Normal with a share of wide ones that grows with speed."""
    k, base, more = r.uniform(3, 6), r.uniform(0.005, 0.03), r.uniform(0.02, 0.12)
    p = base + more * speed_of(rec)
    wide = r.random(rec.n_obs) < p
    values = s * r.normal(size=rec.n_obs) * np.where(wide, k, 1.0)
    spec = {"kind": "fresh-1", "sd_um": round(s, 4), "ratio": round(k, 2)}
    return Noise(values, s * s * (1 + p * (k * k - 1)), [spec])


@fast(2)
def dithered(r: Rng, s: float, rec: Rec) -> Noise:
    """White, triangular dither of two steps' width, rounding."""
    q = 0.1 if rec.kind in ("trace", "ballbar") else float(pick(r, [0.2, 0.5, 1.0, 2.0]))
    n = rec.n_obs
    values = s * r.normal(size=n) + q * (r.uniform(-0.5, 0.5, n) + r.uniform(-0.5, 0.5, n))
    sd = float(np.sqrt(s * s + q * q / 6))
    return Noise(
        values, np.full(n, s * s + q * q / 4), [{"kind": "fresh-2", "sd_um": round(sd, 4)}], quant=q
    )


@fast(3)
def skewed(r: Rng, s: float, rec: Rec) -> Noise:
    """Gamma noise of shape 0.8 to 4, centred: a contact that errs to one side."""
    shape, side = logu(r, 0.8, 4), pick(r, [-1, 1])
    values = side * s * (r.gamma(shape, size=rec.n_obs) - shape) / np.sqrt(shape)
    spec = {"kind": "fresh-3", "sd_um": round(s, 4), "shape": round(shape, 2)}
    return Noise(values, np.full(rec.n_obs, s * s), [spec])


@fast(4)
def fractional(r: Rng, s: float, rec: Rec) -> Noise:
    """(1 - B)^d x = e with d in 0.15..0.45, as an autoregression of 300 terms."""
    d = float(r.uniform(0.15, 0.45))
    k = np.arange(1, TAPS)
    a = np.r_[1.0, np.cumprod((k - 1 - d) / k)]
    h = lfilter([1.0], a, np.r_[1.0, np.zeros(8000)])
    q = s / np.sqrt((h**2).sum())
    values = lfilter([1.0], a, r.normal(0, q, rec.n_obs + 8000))[8000:]
    spec = {"kind": "fresh-4", "sd_um": round(s, 4), "d": round(d, 3)}
    return Noise(values, np.full(rec.n_obs, q * q), [spec], [1.0], a.tolist())


def fbm(r: Rng, t: Array, h: float, n: int = 1 << 15) -> Array:
    """Fractional Brownian motion, unit at t[-1]: exact on a grid of n (Davies and Harte 1987)."""
    k = np.arange(n + 1.0)
    g = 0.5 * ((k + 1) ** (2 * h) - 2 * k ** (2 * h) + np.abs(k - 1) ** (2 * h))
    lam = np.maximum(np.fft.fft(np.r_[g, g[-2:0:-1]]).real, 0.0)
    m = len(lam)
    z = np.fft.fft(np.sqrt(lam / m) * (r.normal(size=m) + 1j * r.normal(size=m))).real[:n]
    x = np.r_[0.0, np.cumsum(z)] / n**h
    return np.interp(t / max(float(t[-1]), 1e-9) * n, np.arange(n + 1.0), x)


@slow(5)
def power_law(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """s um at the end of the file; exponent 2H + 1 of 1.2 to 2.8, away from the walk's 2."""
    h = float(pick(r, [r.uniform(0.1, 0.4), r.uniform(0.6, 0.9)]))
    t = rec.t_obs - rec.t_obs[0]
    span = max(float(t[-1]), 1e-9)

    def kernel(a: Array, b: Array) -> Array:
        u, v = a[:, None] / span, b[None, :] / span
        return 0.5 * s * s * (u ** (2 * h) + v ** (2 * h) - np.abs(u - v) ** (2 * h))

    noise.values += s * fbm(r, t, h)
    noise.kernels.append((kernel, t))
    noise.spec.append({"kind": "fresh-5", "um": round(s, 4), "hurst": round(h, 3)})


@slow(6)
def turbulence(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Eddies of 0.5 to 20 s; rms s at the far end of the path, the square root of it between."""
    t = rec.t_obs - rec.t_obs[0]
    if rec.kind == "targets":
        x = rec.pos @ (
            rec.meta["sensitive"] if np.any(rec.meta["sensitive"]) else np.eye(3)[rec.meta["along"]]
        )
    elif rec.kind == "ballbar":
        x = np.full(len(t), rec.meta["radius"])
    else:
        x = rec.pos[:, c]
    far = x.max() - x if r.random() < 0.5 else x - x.min()
    path = (far + logu(r, 10, 200)) / (float(far.max()) + 200)
    gain, tau = np.sqrt(np.minimum(path, 1.0)), logu(r, 0.5, 20)
    noise.values += s * gain * ou(r, t, tau)
    noise.kernels.append((modulate(k_ou(s * s, tau), gain, t), t))
    noise.spec.append({"kind": "fresh-6", "um": round(s, 4), "tau_s": round(tau, 2)})


@slow(7)
def rare_state(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Two states with the other one visited for 3 to 20 % of the time; rms s."""
    t = rec.t_obs - rec.t_obs[0]
    span = max(float(t[-1]), 1.0)
    p, stay = r.uniform(0.03, 0.2), logu(r, span / 150, span / 10)
    away = stay * (1 - p) / p
    up = bool(r.random() < p)
    edges, now, start = [], 0.0, up
    while now < span:
        now += r.exponential(stay if up else away)
        edges.append(now)
        up = not up
    state = (np.searchsorted(np.array(edges), t) + start) % 2
    noise.values += pick(r, [-1, 1]) * s * (state - p) / np.sqrt(p * (1 - p))
    noise.kernels.append((k_ou(s * s, 1 / (1 / stay + 1 / away)), t))
    noise.spec.append(
        {
            "kind": "fresh-7",
            "um": round(s, 4),
            "share": round(float(p), 3),
            "stay_s": round(stay, 2),
        }
    )


@slow(8)
def day(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """A sine of 24 h and a smaller one of 12 h with free phases; 4 s is the day's rms."""
    for hours, size in ((24.0, 4.0), (12.0, 1.5)):
        for trig in (np.cos, np.sin):
            col = s * size * trig(2 * np.pi * rec.t_obs / (3600 * hours))
            noise.values += col * r.normal()
            noise.columns.append(col)
    noise.spec.append({"kind": "fresh-8", "um": round(s, 4)})


@slow(9)
def seats(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Each run has a small offset of its own, and on circles a small centre of its own."""
    if len(np.unique(rec.run)) == 1:  # a single seat is the file's zero: something else instead
        power_law(r, noise, s, rec, world, c)
        return
    for k in np.unique(rec.run):
        on = (rec.run == k) * s
        shapes = [on]
        if rec.kind == "ballbar":
            shapes += [0.7 * on * rec.meta["unit"][:, a] for a in rec.meta["plane"]]
        for col in shapes:
            noise.values += col * r.normal()
            noise.columns.append(col)
    noise.spec.append({"kind": "fresh-9", "um": round(s, 4)})


def missing(r: Rng, rec: Rec) -> Array | None:
    """Rows that are not in the file: single captures at rest, one to three stretches in motion."""
    n = rec.n_obs
    if rec.kind == "features" or r.random() > 0.25 or n < 12:
        return None
    gone = np.zeros(n, bool)
    if rec.kind == "targets":
        gone = r.random(n) < r.uniform(0.02, 0.15)
    else:
        for _ in range(int(r.integers(1, 4))):
            i = int(r.integers(0, n))
            gone[i : i + max(2, int(n * logu(r, 0.003, 0.05)))] = True
    gone[[0, -1]] = False
    return gone if gone.any() else None


LOSSES["fresh"] = missing
LATER["fresh"] = {
    "fast": ["fresh-1", "fresh-2", "fresh-3"],
    "trace": ["fresh-1", "fresh-2", "fresh-3", "fresh-4", "fresh-4"],
    "parts": ["fresh-1", "fresh-2", "fresh-3"],
    "slow": ["fresh-5", "fresh-5", "fresh-6", "fresh-7", "fresh-8", "fresh-9"],
    "all": [f"fresh-{k}" for k in range(1, 10)],
}
