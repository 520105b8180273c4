"""Noises of the distant family.  Read this only if you do not work on the tool that is judged.

Fast: distant-1 double exponential, as triggers have it (Laplace; JCGM 101), distant-2 one reading
in ten or twenty four times as wide, a gust in the beam (Tukey 1960), distant-3 deviation that grows
as a line with the distance from one end of the file's places, as trackers' and levels' do (ISO
10360-10; ASME B89.4.19), distant-4 wander over white in one channel, autoregression under a floor
(Box and Jenkins: ARMA 1,1), distant-5 successive differences of a counter: blue, a negative
neighbour (Lyons 2011; Norsworthy et al. 1997), distant-6 variance that comes and goes as people
and gates do, log normal (Taylor 1986: stochastic volatility), distant-7 two to three times as wide
in the first part, as stands and electronics settle (ISO 230-2: warm-up of the instrument).
Slow: distant-8 a stand that follows the hall smoothly, once differentiable (Matern 3/2; Rasmussen
and Williams 2006, eq. 4.17), distant-9 the hall's controller whose phase wanders: damped waves
(harmonic Ornstein-Uhlenbeck), distant-10 a magnetic foot that settles in many small jerks (compound
Poisson), distant-11 creep of a clamp as the logarithm of time (Flugge 1975), distant-12 wander
between one over f and a walk (Milotti 1995), distant-13 each run zeroed at its start and with a
slope of its own, as a laser's frame takes the operator's warmth (Estler 1985).
distant-0: samples that were lost on the way, some tens in a row from a sampled file, single ones
from a test at rest.

Every kind tells the oracle its exact second moments, and `sd_um` is that of one reading.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from .base import Array, Rec, Rng, logu, smooth
from .noise import LATER, LOSSES, MORE_FAST, MORE_SLOW, FastKind, Noise, SlowKind, ou
from .world import World


def fast(number: int) -> Callable[[FastKind], FastKind]:
    """Decorator that files a fast kind."""

    def add(f: FastKind) -> FastKind:
        MORE_FAST[f"distant-{number}"] = f
        return f

    return add


def slow(number: int) -> Callable[[SlowKind], SlowKind]:
    """Decorator that files a slow kind."""

    def add(f: SlowKind) -> SlowKind:
        MORE_SLOW[f"distant-{number}"] = f
        return f

    return add


def said(number: int, s: float, **more: float) -> dict:
    """What the details say of a fast kind: its deviation, numbers of its own."""
    return {"kind": f"distant-{number}", "sd_um": round(s, 4)} | {
        k: round(v, 4) for k, v in more.items()
    }


def uneven(r: Rng, s: float, sd: Array, number: int) -> Noise:
    """Normal with deviations in proportion to sd, variance s^2 in the mean."""
    var = s * s * sd**2 / (sd**2).mean()
    return Noise(r.normal(0, np.sqrt(var)), var, [said(number, s)])


@fast(1)
def triggers(r: Rng, s: float, rec: Rec) -> Noise:
    """Laplace of variance s^2."""
    n = rec.n_obs
    return Noise(r.laplace(0, s / np.sqrt(2), n), np.full(n, s * s), [said(1, s)])


@fast(2)
def gusts(r: Rng, s: float, rec: Rec) -> Noise:
    """Normal, a share of 5 to 12 % with four times the deviation; which ones is not told."""
    n, share = rec.n_obs, r.uniform(0.05, 0.12)
    q = s / np.sqrt(1 + 15 * share)
    x = r.normal(0, q, n) * np.where(r.random(n) < share, 4.0, 1.0)
    return Noise(x, np.full(n, s * s), [said(2, s, share=share)])


@fast(3)
def with_distance(r: Rng, s: float, rec: Rec) -> Noise:
    """Deviation from 1 to 2..4 along the places of the file."""
    x = rec.pos[::2] if rec.kind == "features" else rec.pos
    way = x - x.mean(0)
    u = way[:, int(np.argmax(np.ptp(x, axis=0)))]
    u = (u - u.min()) / max(float(np.ptp(u)), 1e-9)
    return uneven(r, s, 1 + r.uniform(1, 3) * (u if r.random() < 0.5 else 1 - u), 3)


@fast(4)
def wander_under_a_floor(r: Rng, s: float, rec: Rec) -> Noise:
    """Autoregression of 0.9 to 0.99 with 20 to 60 % of the variance, the rest white: as one
    ARMA(1,1), whose moving part b solves b / (1 + b^2) = ratio of the two autocovariances."""
    rho, share = r.uniform(0.9, 0.99), r.uniform(0.2, 0.6)
    drive, floor = share * (1 - rho**2), 1 - share
    g0, g1 = drive + floor * (1 + rho**2), -floor * rho
    b = (g0 - np.sqrt(g0**2 - 4 * g1**2)) / (2 * g1)
    var, n = s * s * g1 / b, rec.n_obs
    x = lfilter([1.0, b], [1.0, -rho], r.normal(0, np.sqrt(var), n + 2000))[2000:]
    said_of = said(4, s, rho=rho, share=share)
    return Noise(x, np.full(n, var), [said_of], [1.0, float(b)], [1.0, -float(rho)])


@fast(5)
def differences(r: Rng, s: float, rec: Rec) -> Noise:
    """White through 1 - k z^-1, k 0.3 to 0.75."""
    k, n = float(r.uniform(0.3, 0.75)), rec.n_obs
    q = s / np.sqrt(1 + k * k)
    x = lfilter([1.0, -k], [1.0], r.normal(0, q, n + 10))[10:]
    return Noise(x, np.full(n, q * q), [said(5, s, k=k)], [1.0, -k], [1.0, 0.0])


@fast(6)
def comes_and_goes(r: Rng, s: float, rec: Rec) -> Noise:
    """Deviation exp(0.5 g) of a smooth g of time."""
    t = rec.t_obs - rec.t_obs[0]
    long = max(float(t[-1]), 1e-6) * r.uniform(0.05, 0.25)
    return uneven(r, s, np.exp(0.5 * smooth(r, t, long)), 6)


@fast(7)
def wide_at_first(r: Rng, s: float, rec: Rec) -> Noise:
    """Deviation 1 + k exp(-u / d), k 1 to 2, u 0..1 of the file."""
    t = rec.t_obs - rec.t_obs[0]
    u = t / max(float(t[-1]), 1e-9)
    return uneven(r, s, 1 + r.uniform(1, 2) * np.exp(-u / r.uniform(0.05, 0.3)), 7)


def times(rec: Rec) -> tuple[Array, float]:
    """Time from the start of a file and its length, s."""
    t = rec.t_obs - rec.t_obs[0]
    return t, max(float(t[-1]), 1e-6)


@slow(8)
def stand(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """s^2 (1 + d) exp(-d), d = sqrt(3) |dt| / tau, as waves whose rates are drawn from its
    spectrum (a Student's t of 3 degrees)."""
    t, span = times(rec)
    tau = span * logu(r, 0.05, 1.0)
    rate = r.standard_t(3, 80) / tau
    wave = np.cos(np.outer(t, rate) + r.uniform(0, 2 * np.pi, 80))
    noise.values += s * np.sqrt(2 / 80) * wave @ r.normal(size=80)

    def kernel(x: Array, y: Array) -> Array:
        d = np.sqrt(3) * np.abs(x[:, None] - y) / tau
        return s * s * (1 + d) * np.exp(-d)

    noise.kernels.append((kernel, t))
    noise.spec.append({"kind": "distant-8", "um": round(s, 4), "tau_s": round(tau, 2)})


@slow(9)
def controller(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """s^2 cos(w dt) exp(-|dt| / tau): 2 to 9 waves in the file, right for one to three of them."""
    t, span = times(rec)
    p = span / r.uniform(2, 9)
    tau, w = p * r.uniform(1, 3), 2 * np.pi / p
    noise.values += s * (np.cos(w * t) * ou(r, t, tau) + np.sin(w * t) * ou(r, t, tau))

    def kernel(x: Array, y: Array) -> Array:
        d = x[:, None] - y
        return s * s * np.cos(w * d) * np.exp(-np.abs(d) / tau)

    noise.kernels.append((kernel, t))
    noise.spec.append({"kind": "distant-9", "um": round(s, 4), "period_s": round(p, 2)})


@slow(10)
def jerks(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """20 to 60 jumps in the file, s um (rms) at its end, none of them much."""
    t, span = times(rec)
    rate = r.uniform(20, 60) / span
    q = s * s / span
    at = np.sort(r.uniform(0, span, r.poisson(rate * span)))
    jumps = np.r_[0.0, np.cumsum(r.normal(0, np.sqrt(q / rate), len(at)))]
    noise.values += jumps[np.searchsorted(at, t)]
    noise.kernels.append((lambda x, y: q * np.minimum(x[:, None], y), t))
    noise.spec.append({"kind": "distant-10", "um": round(s, 4)})


@slow(11)
def clamp(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """log(1 + t / tau) with a normal amplitude, s um at the end."""
    t, span = times(rec)
    tau = span * logu(r, 0.003, 0.1)
    col = s * np.log1p(t / tau) / np.log1p(span / tau)
    noise.values += col * r.normal()
    noise.columns.append(col)
    noise.spec.append({"kind": "distant-11", "um": round(s, 4), "tau_s": round(tau, 2)})


@slow(12)
def steeper_than_flicker(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Six Ornstein-Uhlenbeck processes over three decades, variance as the root of their times:
    1 / f^1.5."""
    t, span = times(rec)
    taus = np.geomspace(max(span / 200, 1e-3), span * 5, 6)
    var = s * s * np.sqrt(taus) / np.sqrt(taus).sum()
    for v, tau in zip(var, taus, strict=True):
        noise.values += np.sqrt(v) * ou(r, t, float(tau))

    def kernel(x: Array, y: Array) -> Array:
        d = np.abs(x[:, None] - y)
        return sum(v * np.exp(-d / tau) for v, tau in zip(var, taus, strict=True))

    noise.kernels.append((kernel, t))
    noise.spec.append({"kind": "distant-12", "um": round(s, 4)})


@slow(13)
def slope_of_each_run(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """A line of time in each run with a normal slope, nothing at its start, s um at its end."""
    t, _ = times(rec)
    runs = rec.run[::2] if rec.kind == "features" else rec.run
    for k in np.unique(runs):
        on = runs == k
        if on.sum() > 1:
            u = t[on] - t[on][0]
            col = np.zeros(len(t))
            col[on] = s * u / max(float(u[-1]), 1e-9)
            noise.values += col * r.normal()
            noise.columns.append(col)
    noise.spec.append({"kind": "distant-13", "um": round(s, 4)})


def lost_on_the_way(r: Rng, rec: Rec) -> Array | None:
    """One to three gaps of 8 to 40 samples, or one to three readings at rest, never the ends."""
    n = rec.n_obs
    if rec.kind == "features" or r.random() > 0.15 or n < 40:
        return None
    gone = np.zeros(n, bool)
    for _ in range(int(r.integers(1, 4))):
        size = int(r.integers(8, 41)) if rec.kind != "targets" else 1
        i = int(r.integers(1, n - size - 1)) if n > size + 2 else 1
        gone[i : i + size] = True
    gone[[0, -1]] = False
    return gone if gone.sum() < 0.1 * n else None


LOSSES["distant"] = lost_on_the_way
LATER["distant"] = {
    "fast": [f"distant-{k}" for k in (1, 2, 3, 6, 7)],
    "trace": [f"distant-{k}" for k in (1, 2, 4, 4, 5, 6, 7)],
    "parts": [f"distant-{k}" for k in (1, 2, 6)],
    "slow": [f"distant-{k}" for k in range(8, 14)],
    "all": [f"distant-{k}" for k in range(1, 14)],
}
