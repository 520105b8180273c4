"""Noises of the apart family.  Read this only if you do not work on the tool that is judged.

Fast: apart-1 normal, alike everywhere (JCGM 100:2008), apart-2 a reading with a coarse last digit,
0.8 to 2 times its deviation: dial gauges, displays of a ballbar or of a tape (JCGM 101:2008,
6.4.3), apart-3 gross slips, one to four of a hundred readings are three to eight times as wide
(Huber 1964), apart-4 a log of a control or a ballbar's electronics: autoregressive of the first
order, 0.4 to 0.9 (Box and Jenkins 1970), apart-5 parts that are not quite at 20 C on the CMM: each
part's lengths are out by a share of its own, 0.1 to 0.5 K, over the CMM's repeatability (ISO/TR
15530-3; 11.5e-6 per K), apart-6 a laser in turbulent air: deviation as floor and path together, the
path counted from a head that stands 0.2 to 1 m away (Estler 1985; Renishaw XL-80).
Slow: apart-7 a room that wanders smoothly, Matern's spectrum of order 3/2 (Rasmussen and Williams
2006, eq. 4.15), apart-8 a random walk by its first 60 sines (Loeve 1978), apart-9 1/f noise, from a
period of 2.2 times the file to a 60th of that (Mandelbrot and Van Ness 1968), apart-10 a drift of
the set-up in a straight line, and a quarter of it bent (ISO 230-2; ISO 230-3).  The first three are
series of sines over the file, so that the oracle has their covariance without approximation.

Every kind tells the oracle its exact second moments, and `sd_um` is that of one reading before its
digit is rounded.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from .base import Array, Rec, Rng
from .noise import LATER, MORE_FAST, MORE_SLOW, FastKind, Noise, SlowKind
from .world import World


def fast(number: int) -> Callable[[FastKind], FastKind]:
    """Decorator that files a fast kind."""

    def add(f: FastKind) -> FastKind:
        MORE_FAST[f"apart-{number}"] = f
        return f

    return add


def slow(number: int) -> Callable[[SlowKind], SlowKind]:
    """Decorator that files a slow kind."""

    def add(f: SlowKind) -> SlowKind:
        MORE_SLOW[f"apart-{number}"] = f
        return f

    return add


def said(number: int, s: float, **more: float) -> dict:
    """What the details say of a fast kind."""
    return {"kind": f"apart-{number}", "sd_um": round(s, 4)} | {
        k: round(v, 4) for k, v in more.items()
    }


@fast(1)
def normal(r: Rng, s: float, rec: Rec) -> Noise:
    """Independent, of one deviation."""
    return Noise(s * r.normal(size=rec.n_obs), np.full(rec.n_obs, s * s), [said(1, s)])


@fast(2)
def coarse_digit(r: Rng, s: float, rec: Rec) -> Noise:
    """A digit of 1, 2 or 5 times a power of ten next to 0.8 to 2 deviations; the reading is rounded
    to it when its file is written, which adds a twelfth of its square."""
    want = s * r.uniform(0.8, 2.0)
    digits = np.outer(10.0 ** np.arange(-3, 2), [1.0, 2.0, 5.0]).ravel()
    digit = float(digits[np.argmin(np.abs(np.log(digits / want)))])
    var = np.full(rec.n_obs, s * s + digit**2 / 12)
    return Noise(s * r.normal(size=rec.n_obs), var, [said(2, s, digit_um=digit)], quant=digit)


@fast(3)
def gross_slips(r: Rng, s: float, rec: Rec) -> Noise:
    """Two normals; variance in the mean of both s^2."""
    share, wide = r.uniform(0.01, 0.04), r.uniform(3, 8)
    one = s / np.sqrt(1 + share * (wide**2 - 1))
    values = one * r.normal(size=rec.n_obs) * np.where(r.random(rec.n_obs) < share, wide, 1.0)
    return Noise(values, np.full(rec.n_obs, s * s), [said(3, s, share=share, ratio=wide)])


@fast(4)
def first_order(r: Rng, s: float, rec: Rec) -> Noise:
    """x = rho x' + e, in its steady state."""
    rho, n = r.uniform(0.4, 0.9), rec.n_obs
    e = s * np.sqrt(1 - rho**2)
    x = lfilter([1.0], [1.0, -rho], r.normal(0, e, n + 300))[300:]
    return Noise(x, np.full(n, e * e), [said(4, s, rho=rho)], [1.0], [1.0, -rho])


@fast(5)
def warm_parts(r: Rng, s: float, rec: Rec) -> Noise:
    """Repeatability s, and 0.0115 um per mm and K times each part's normal temperature; elsewhere
    repeatability alone."""
    noise = Noise(s * r.normal(size=rec.n_obs), np.full(rec.n_obs, s * s), [said(5, s)])
    if rec.kind == "features":
        kelvin, info = r.uniform(0.1, 0.5), rec.meta["info"]
        part, size = np.array([i[4] for i in info]), np.array([i[3] for i in info])
        for k in np.unique(part):
            _column(r, noise, 0.0115 * kelvin * size * (part == k))
    return noise


@fast(6)
def turbulence(r: Rng, s: float, rec: Rec) -> Noise:
    """Deviation floor + path for a laser (mean variance s^2), else normal."""
    long = np.zeros(rec.n_obs)
    if rec.laser:
        x = rec.pos @ rec.meta["sensitive"]
        long = x - x.min() if r.random() < 0.5 else x.max() - x
        long = (long + r.uniform(200, 1000)) / 1e3
    var = (r.uniform(0.1, 0.4) + long) ** 2
    var = s * s * var / var.mean()
    return Noise(r.normal(0, np.sqrt(var)), var, [said(6, s)])


def _column(r: Rng, noise: Noise, shape: Array) -> None:
    """Adds a shape (um) of normal amplitude and lays it down for the oracle."""
    noise.values += shape * r.normal()
    noise.columns.append(shape)


def _from_start(rec: Rec) -> tuple[Array, float]:
    """Time since the first reading and the length of the file, s."""
    t = rec.t_obs - rec.t_obs[0]
    return t, max(float(t[-1]), 1e-9)


def _series(r: Rng, noise: Noise, s: float, rec: Rec, power: Array, number: int) -> None:
    """Harmonics 1, 2, ... of a period of 2.2 times the file with normal amplitudes, variances in
    proportion to `power`, s^2 in all."""
    t, span = _from_start(rec)
    size = s * np.sqrt(power / power.sum())
    for k, a in enumerate(size, 1):
        angle = 2 * np.pi * k * t / (2.2 * span)
        _column(r, noise, a * np.cos(angle))
        _column(r, noise, a * np.sin(angle))
    noise.spec.append({"kind": f"apart-{number}", "um": round(s, 4)})


@slow(7)
def smooth_room(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Power (3 + w^2 tau^2)^-2, tau 0.05 to 0.4 of the file."""
    rate = 2 * np.pi / 2.2 * np.arange(1, 41) * r.uniform(0.05, 0.4)
    _series(r, noise, s, rec, (3 + rate**2) ** -2.0, 7)


@slow(8)
def random_walk(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Sines of k - 1/2 half waves over the file, s um at its end."""
    t, span = _from_start(rec)
    for k in np.pi * (np.arange(60) + 0.5):
        _column(r, noise, s * np.sqrt(2) / k * np.sin(k * t / span))
    noise.spec.append({"kind": "apart-8", "um": round(s, 4)})


@slow(9)
def one_over_f(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Power as one over the order, 60 of them."""
    _series(r, noise, s, rec, 1 / np.arange(1.0, 61.0), 9)


@slow(10)
def straight_drift(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """A line of s um over the file and a parabola of a quarter of that, both of normal size."""
    t, span = _from_start(rec)
    u = t / span
    _column(r, noise, s * u)
    _column(r, noise, s * u * (1 - u))
    noise.spec.append({"kind": "apart-10", "um": round(s, 4)})


LATER["apart"] = {
    "fast": ["apart-1", "apart-1", "apart-2", "apart-3", "apart-6", "apart-6"],
    "trace": ["apart-1", "apart-2", "apart-3", "apart-4", "apart-4"],
    "parts": ["apart-1", "apart-2", "apart-5", "apart-5"],
    "slow": ["apart-7", "apart-7", "apart-8", "apart-9", "apart-10"],
    "all": [f"apart-{k}" for k in range(1, 11)],
}
