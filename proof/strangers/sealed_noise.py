"""Noises of the sealed family.  Read this only if you do not work on the tool that is judged.

Fast: sealed-1 double exponential (Laplace 1774), sealed-2 two components, one of which grows with
the length (Rocke and Lorenzato 1995; ISO 10360-2 states errors as A + L/K), sealed-3 conditional
heteroscedasticity, loud and quiet spells (Bollerslev 1986), sealed-4 differenced noise, the power
law of a phase that is read twice (Allan 1987; moving average of the first order), sealed-5
impulsive noise of class A (Middleton 1977), sealed-6 arcsine, readings at rest of something that
swings (JCGM 101:2008, 6.4.6).
Slow: sealed-7 shot noise of rounded pulses (Rice 1944; Campbell's theorem), sealed-8 a weather
station or filter that renews its value now and then and holds it between (sampled Ornstein and
Uhlenbeck), sealed-9 a walk with the way instead of the time, as a cable drags or a wheel slips
(Borenstein and Feng 1996), sealed-10 three telegraphs at once, levels instead of one over f
(McWhorter 1957), sealed-11 ageing as the logarithm of time (Vig and Meeker 1991), sealed-12 a drift
with another slope in every run, sealed-13 many small jumps that stay (compound Poisson).
sealed-0: runs that were broken off, and a link that is lost every so often.

Every kind tells the oracle its exact second moments.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .base import Array, Rec, Rng, logu
from .noise import LATER, LOSSES, MORE_FAST, MORE_SLOW, FastKind, Noise, SlowKind, k_ou, ou
from .world import World


def fast(number: int) -> Callable[[FastKind], FastKind]:
    """Decorator that files a fast kind."""

    def add(f: FastKind) -> FastKind:
        MORE_FAST[f"sealed-{number}"] = f
        return f

    return add


def slow(number: int) -> Callable[[SlowKind], SlowKind]:
    """Decorator that files a slow kind."""

    def add(f: SlowKind) -> SlowKind:
        MORE_SLOW[f"sealed-{number}"] = f
        return f

    return add


def said(number: int, s: float, **more: float) -> dict:
    """What the details say of a fast kind."""
    return {"kind": f"sealed-{number}", "sd_um": round(s, 4)} | {
        k: round(v, 4) for k, v in more.items()
    }


@fast(1)
def laplace(r: Rng, s: float, rec: Rec) -> Noise:
    """Scale s / sqrt(2)."""
    n = rec.n_obs
    return Noise(r.laplace(0, s / np.sqrt(2), n), np.full(n, s * s), [said(1, s)])


def length_of(rec: Rec) -> Array:
    """0..1: nominal length of a feature, else distance from the lowest corner of the file."""
    if rec.kind == "features":
        x = np.array([i[3] for i in rec.meta["info"]], float)
    else:
        x = np.linalg.norm(rec.pos - rec.pos.min(0), axis=1)
    return x / max(float(x.max()), 1e-9)


@fast(2)
def two_components(r: Rng, s: float, rec: Rec) -> Noise:
    """Variances a^2 and (b L)^2 add up; their mean over the file is s^2."""
    var = r.uniform(0.05, 0.3) + length_of(rec) ** 2
    var = s * s * var / var.mean()
    return Noise(r.normal(0, np.sqrt(var)), var, [said(2, s)])


@fast(3)
def spells(r: Rng, s: float, rec: Rec) -> Noise:
    """h' = w + alpha x^2 + beta h, white with variance s^2, its size remembered."""
    n, alpha, beta = rec.n_obs, float(r.uniform(0.1, 0.25)), float(r.uniform(0.5, 0.65))
    e, x, h = r.normal(size=n + 100).tolist(), [], s * s
    for z in e:
        x.append(z * np.sqrt(h))
        h = s * s * (1 - alpha - beta) + alpha * x[-1] ** 2 + beta * h
    return Noise(np.array(x[100:]), np.full(n, s * s), [said(3, s, alpha=alpha, beta=beta)])


@fast(4)
def differenced(r: Rng, s: float, rec: Rec) -> Noise:
    """x = e - theta e', theta 0.5 to 0.9; the 0 in the filter tells that its start is unknown."""
    n, theta = rec.n_obs, float(r.uniform(0.5, 0.9))
    q = s / np.sqrt(1 + theta**2)
    e = r.normal(0, q, n + 1)
    x = e[1:] - theta * e[:-1]
    return Noise(x, np.full(n, q * q), [said(4, s, theta=theta)], [1.0, -theta], [1.0, 0.0])


@fast(5)
def impulsive(r: Rng, s: float, rec: Rec) -> Noise:
    """A Poisson number m of impulses in each reading: variance s^2 (m / a + g) / (1 + g)."""
    n, a, g = rec.n_obs, logu(r, 0.1, 0.6), logu(r, 0.02, 0.3)
    var = s * s * (r.poisson(a, n) / a + g) / (1 + g)
    return Noise(r.normal(0, np.sqrt(var)), np.full(n, s * s), [said(5, s, a=a, gamma=g)])


@fast(6)
def arcsine(r: Rng, s: float, rec: Rec) -> Noise:
    """s sqrt(2) times the sine of a phase that knows nothing of the reading before."""
    n = rec.n_obs
    x = s * np.sqrt(2) * np.sin(r.uniform(0, 2 * np.pi, n))
    return Noise(x, np.full(n, s * s), [said(6, s)])


def from_start(rec: Rec) -> tuple[Array, float]:
    """Time since the first reading and the file's length, s."""
    t = rec.t_obs - rec.t_obs[0]
    return t, max(float(t[-1]), 1e-9)


@slow(7)
def pulses(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Pulses u exp(-u), u = time / tau, at random: s^2 (1 + d/tau) exp(-d/tau)."""
    t, span = from_start(rec)
    tau, rate = span * r.uniform(0.01, 0.06), r.uniform(6, 25) / span
    start = np.sort(r.uniform(-12 * tau, span, r.poisson(rate * (span + 12 * tau))))
    for at, size in zip(start, r.normal(size=len(start)), strict=True):
        u = np.maximum(t - at, 0) / tau
        noise.values += s * size / np.sqrt(rate * tau / 4) * u * np.exp(-u)

    def kernel(a: Array, b: Array) -> Array:
        d = np.abs(a[:, None] - b) / tau
        return s * s * (1 + d) * np.exp(-d)

    noise.kernels.append((kernel, t))
    noise.spec.append({"kind": "sealed-7", "um": round(s, 4), "tau_s": round(tau, 2)})


@slow(8)
def renewed(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """An OU value that is renewed 6 to 60 times in the file and held between."""
    t, span = from_start(rec)
    every, tau, ph = span / logu(r, 6, 60), span * r.uniform(0.05, 0.6), r.uniform(0, 1)

    def held(x: Array) -> Array:
        return np.floor(x / every + ph) * every

    steps, at = np.unique(held(t), return_inverse=True)
    noise.values += s * ou(r, steps, tau)[at]
    k = k_ou(s * s, tau)
    noise.kernels.append((lambda a, b: k(held(a), held(b)), t))
    noise.spec.append({"kind": "sealed-8", "um": round(s, 4), "every_s": round(every, 2)})


@slow(9)
def way_walk(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """A walk whose clock is the way gone; rms s at the end. What stands walks with time."""
    t, span = from_start(rec)
    way = np.cumsum(np.linalg.norm(np.diff(rec.via, axis=0, prepend=rec.via[:1]), axis=1))
    way = way[rec.row_at] - way[rec.row_at[0]]
    way = way[::2] if rec.kind == "features" else way
    way = way / way[-1] if way[-1] > 1e-6 else t / span
    noise.values += s * np.cumsum(r.normal(size=len(t)) * np.sqrt(np.diff(way, prepend=0.0)))

    def kernel(a: Array, b: Array) -> Array:
        return s * s * np.minimum(np.interp(a, t, way)[:, None], np.interp(b, t, way))

    noise.kernels.append((kernel, t))
    noise.spec.append({"kind": "sealed-9", "um": round(s, 4)})


@slow(10)
def levels(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Three two-state signals of one size, with rates a factor of 3 to 6 apart."""
    t, span = from_start(rec)
    first, ratio = span / r.uniform(40, 90), r.uniform(3, 6)
    taus = [first * ratio**k for k in range(3)]
    for tau in taus:
        flips = np.cumsum(r.exponential(2 * tau, 40 + int(2 * span / tau)))
        side = 1 - 2 * int(r.integers(2))
        noise.values += side * s / np.sqrt(3) * (1 - 2 * (np.searchsorted(flips, t) % 2))
    noise.kernels.append((lambda a, b: sum(k_ou(s * s / 3, u)(a, b) for u in taus), t))
    noise.spec.append({"kind": "sealed-10", "um": round(s, 4)})


@slow(11)
def ageing(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """log(1 + t / tau), 1.5 s at the file's end."""
    t, span = from_start(rec)
    tau = span * logu(r, 0.003, 0.2)
    col = 1.5 * s * np.log1p(t / tau) / np.log1p(span / tau)
    noise.values += col * r.normal()
    noise.columns.append(col)
    noise.spec.append({"kind": "sealed-11", "um": round(s, 4), "tau_s": round(tau, 2)})


@slow(12)
def slopes(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Each run starts at nothing and runs away, 1.5 s by the end of the longest one."""
    t, _ = from_start(rec)
    since = np.zeros(len(t))
    runs = rec.run[::2] if rec.kind == "features" else rec.run
    for k in np.unique(runs):
        since[runs == k] = t[runs == k] - t[runs == k][0]
    top = max(float(since.max()), 1e-9)
    for k in np.unique(runs):
        col = 1.5 * s * since / top * (runs == k)
        noise.values += col * r.normal()
        noise.columns.append(col)
    noise.spec.append({"kind": "sealed-12", "um": round(s, 4)})


@slow(13)
def jumps(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """20 to 60 double exponential jumps at random; rms s at the file's end."""
    t, span = from_start(rec)
    mean = r.uniform(20, 60)
    at = np.sort(r.uniform(0, span, r.poisson(mean)))
    size = np.r_[0.0, np.cumsum(r.laplace(0, s / np.sqrt(2 * mean), len(at)))]
    noise.values += size[np.searchsorted(at, t)]
    noise.kernels.append((lambda a, b: s * s * np.minimum(a[:, None], b) / span, t))
    noise.spec.append({"kind": "sealed-13", "um": round(s, 4)})


def broken_off(r: Rng, rec: Rec) -> Array | None:
    """Rows that are not in the file: the end of a run, or of every stretch in motion a part."""
    n = rec.n_obs
    if rec.kind == "features" or r.random() > 0.3 or n < 12:
        return None
    gone = np.zeros(n, bool)
    if rec.kind == "targets":
        for k in np.unique(rec.run):
            rows = np.flatnonzero(rec.run == k)
            if r.random() < 0.4:
                gone[rows[int(len(rows) * r.uniform(0.6, 0.95)) :]] = True
    else:
        u = np.arange(n) / n * r.uniform(3, 30)
        gone = (u % 1.0) > 1 - r.uniform(0.01, 0.15)
    gone[[0, -1]] = False
    return gone if gone.any() else None


LOSSES["sealed"] = broken_off
LATER["sealed"] = {
    "fast": [f"sealed-{k}" for k in (1, 2, 3, 5, 6)],
    "trace": [f"sealed-{k}" for k in (1, 2, 3, 4, 4, 5)],
    "parts": [f"sealed-{k}" for k in (1, 2, 5)],
    "slow": [f"sealed-{k}" for k in range(7, 14)],
    "all": [f"sealed-{k}" for k in range(1, 14)],
}
