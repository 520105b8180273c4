"""Noises of the later family.  Read this only if you do not work on the tool that is judged.

Fast: later-1 a beam that wanders in the shop's air, variance with the third power of the path
(Chiba 1971; Estler 1985), over a floor, later-2 rectangular: a dial read between two marks, a probe
or a triggered capture latched by a clock (JCGM 101:2008, 6.4.2), later-3 a smoother of a few
falling weights, as the electronics of ballbars and sensors have it (Horowitz and Hill: finite
filters), later-4 a sampling clock that jitters: variance with the square of speed (Da Dalt et al.
2002); at rest, with the square of the last feed (settling; ISO 230-2, dwell), later-5 readings of a
CMM: the form of each feature is shared by its repeated readings (ISO 15530-3), later-6 a signal
that weakens within a run until it is set up again, deviation up to thrice (Bobroff 1993, return
beam; ballbar makers on batteries).
Slow: later-7 electronics switched on before the test, out and part of the way back (capacitive
sensors; ADE's and Lion's notes: half an hour), later-8 draught of many sizes, rational quadratic
(Rasmussen and Williams 2006, eq. 4.19), later-9 a drift that is closed at the end of a run: the
return to the first target is shared out evenly, a Brownian bridge in each run (surveyors' rule; ISO
230-2 reads the drift so), later-10 a weather station that rounds: each run has a scale of its own
by parts of a ppm (Renishaw XC-80: 0.1 to 0.3 ppm); where nothing has a length, each run's zero.
later-0: a target that could not be read in some runs, as something was in the way.

Every kind tells the oracle its exact second moments, and `sd_um` is that of one reading.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from .base import Array, Rec, Rng, logu
from .fresh_noise import speed_of
from .noise import LATER, LOSSES, MORE_FAST, MORE_SLOW, FastKind, Noise, SlowKind
from .sealed_noise import from_start
from .unseen_noise import path
from .world import World


def fast(number: int) -> Callable[[FastKind], FastKind]:
    """Decorator that files a fast kind."""

    def add(f: FastKind) -> FastKind:
        MORE_FAST[f"later-{number}"] = f
        return f

    return add


def slow(number: int) -> Callable[[SlowKind], SlowKind]:
    """Decorator that files a slow kind."""

    def add(f: SlowKind) -> SlowKind:
        MORE_SLOW[f"later-{number}"] = f
        return f

    return add


def said(number: int, s: float, **more: float) -> dict:
    """What the details say of a kind: a fast one's deviation, numbers of its own."""
    return {"kind": f"later-{number}", "sd_um": round(s, 4)} | {
        k: round(v, 4) for k, v in more.items()
    }


def uneven(r: Rng, s: float, var: Array, number: int) -> Noise:
    """Normal with variances in proportion to var, s^2 in the mean."""
    var = s * s * var / var.mean()
    return Noise(r.normal(0, np.sqrt(var)), var, [said(number, s)])


@fast(1)
def wandering_beam(r: Rng, s: float, rec: Rec) -> Noise:
    """A floor and the third power of the path."""
    return uneven(r, s, r.uniform(0.15, 0.6) + path(rec, int(rec.channels[0])) ** 3, 1)


@fast(2)
def between_marks(r: Rng, s: float, rec: Rec) -> Noise:
    """A rectangle of 60 to 95 % of the variance and a normal rest."""
    n, share = rec.n_obs, r.uniform(0.6, 0.95)
    x = s * np.sqrt(3 * share) * r.uniform(-1, 1, n) + s * np.sqrt(1 - share) * r.normal(size=n)
    return Noise(x, np.full(n, s * s), [said(2, s, share=share)])


@fast(3)
def falling_weights(r: Rng, s: float, rec: Rec) -> Noise:
    """White through 1 + b1 z^-1 + b2 z^-2 + b3 z^-3 with 1 > b1 > b2 > b3 > 0."""
    b = np.cumprod(np.r_[1.0, r.uniform(0.45, 0.85, 3)])
    n, q = rec.n_obs, s / np.sqrt((b**2).sum())
    x = lfilter(b, [1.0], r.normal(0, q, n + 10))[10:]
    a = [1.0, 0.0, 0.0, 0.0]
    return Noise(x, np.full(n, q * q), [said(3, s, last=float(b[3]))], b.tolist(), a)


@fast(4)
def jitter(r: Rng, s: float, rec: Rec) -> Noise:
    """A floor and the square of speed."""
    return uneven(r, s, r.uniform(0.1, 0.5) + speed_of(rec) ** 2, 4)


@fast(5)
def shared_form(r: Rng, s: float, rec: Rec) -> Noise:
    """A third to two thirds of the variance belong to the feature of a part; elsewhere white."""
    n, share = rec.n_obs, r.uniform(0.33, 0.67)
    if rec.kind != "features":
        return Noise(r.normal(0, s, n), np.full(n, s * s), [said(5, s)])
    x = s * np.sqrt(1 - share) * r.normal(size=n)
    noise = Noise(x, np.full(n, s * s * (1 - share)), [said(5, s, share=share)])
    key = np.array([i[0] * 1000 + i[4] for i in rec.meta["info"]])
    for k in np.unique(key):
        col = s * np.sqrt(share) * (key == k)
        noise.values += col * r.normal()
        noise.columns.append(col)
    return noise


@fast(6)
def weakening(r: Rng, s: float, rec: Rec) -> Noise:
    """Deviation from 1 to 1.5..3 along each run."""
    runs = rec.run[::2] if rec.kind == "features" else rec.run
    since, t = np.zeros(rec.n_obs), rec.t_obs
    for k in np.unique(runs):
        on = runs == k
        since[on] = (t[on] - t[on][0]) / max(float(np.ptp(t[on])), 1e-9)
    return uneven(r, s, (1 + r.uniform(0.5, 2.0) * since) ** 2, 6)


def columns(r: Rng, noise: Noise, shapes: list[Array], spec: dict) -> None:
    """Adds shapes (um) of normal amplitude and lays them down for the oracle."""
    for col in shapes:
        noise.values += col * r.normal()
        noise.columns.append(col)
    noise.spec.append(spec)


@slow(7)
def switched_on(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """u exp(1 - u) and exp(-u), u = time / tau."""
    t, span = from_start(rec)
    tau = logu(r, min(300.0, span / 3), 1800) if span > 60 else span * r.uniform(0.2, 2)
    u = t / tau
    shapes = [1.5 * s * u * np.exp(1 - u), s * np.exp(-u)]
    columns(r, noise, shapes, {"kind": "later-7", "um": round(s, 4), "tau_s": round(tau, 1)})


@slow(8)
def draught(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """s^2 (1 + d^2 / (2 a tau^2))^-a, as waves whose rates are drawn from its spectrum."""
    t, span = from_start(rec)
    tau, a = span * logu(r, 0.01, 0.3), r.uniform(0.5, 2.0)
    rate = r.normal(size=60) * np.sqrt(r.gamma(a, 1 / a, 60)) / tau
    wave = np.cos(np.outer(t, rate) + r.uniform(0, 2 * np.pi, 60))
    noise.values += s * np.sqrt(2 / 60) * wave @ r.normal(size=60)

    def kernel(x: Array, y: Array) -> Array:
        return s * s * (1 + (x[:, None] - y) ** 2 / (2 * a * tau**2)) ** -a

    noise.kernels.append((kernel, t))
    noise.spec.append({"kind": "later-8", "um": round(s, 4), "tau_s": round(tau, 3)})


@slow(9)
def closed(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """A bridge in each run, s um in the middle of the longest one."""
    t, _ = from_start(rec)
    runs = rec.run[::2] if rec.kind == "features" else rec.run
    first = np.flatnonzero(np.r_[True, np.diff(runs) != 0])
    starts, ends = t[first], t[np.r_[first[1:] - 1, len(t) - 1]]
    long = np.maximum(ends - starts, 1e-9)
    q = 4 * s * s / float(long.max())
    for a, b, size in zip(starts, ends, long, strict=True):
        on = (t >= a) & (t <= b)
        u = t[on] - a
        walk = np.cumsum(r.normal(size=len(u)) * np.sqrt(q * np.diff(u, prepend=0.0)))
        noise.values[on] += walk - walk[-1] * u / size

    def kernel(x: Array, y: Array) -> Array:
        i, j = (np.searchsorted(starts, z + 1e-9, "right") - 1 for z in (x, y))
        u = np.clip(x - starts[i], 0, long[i])[:, None]
        v = np.clip(y - starts[j], 0, long[j])
        return q * (np.minimum(u, v) - u * v / long[j]) * (i[:, None] == j)

    noise.kernels.append((kernel, t))
    noise.spec.append({"kind": "later-9", "um": round(s, 4)})


@slow(10)
def rounded_weather(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """(run) x (path 0..1) with normal amplitudes of s um, at most half a ppm of the path, or runs
    by themselves."""
    runs = rec.run[::2] if rec.kind == "features" else rec.run
    long = path(rec, c) if rec.laser else np.ones(rec.n_obs)
    s = (
        min(s, max(0.1, 0.5e-3 * float(np.ptp(rec.pos @ rec.meta["sensitive"]))))
        if rec.laser
        else s
    )
    if len(np.unique(runs)) == 1 and not rec.laser:  # a single zero is the file's own
        draught(r, noise, s, rec, world, c)
        return
    shapes = [s * (runs == k) * long for k in np.unique(runs)]
    columns(r, noise, shapes, {"kind": "later-10", "um": round(s, 4)})


def in_the_way(r: Rng, rec: Rec) -> Array | None:
    """One to three places that some of the runs could not read."""
    if rec.kind != "targets" or r.random() > 0.2 or rec.n_obs < 20:
        return None
    gone = np.zeros(rec.n_obs, bool)
    for _ in range(int(r.integers(1, 4))):
        at = rec.pos[int(r.integers(rec.n_obs))]
        there = (np.abs(rec.pos - at).max(1) < 1e-6) & (rec.run >= int(r.integers(1, 4)))
        if there.sum() < 0.1 * rec.n_obs:
            gone |= there
    gone[[0, -1]] = False
    return gone if gone.any() else None


LOSSES["later"] = in_the_way
LATER["later"] = {
    "fast": ["later-1", "later-1", "later-2", "later-2", "later-4", "later-6"],
    "trace": ["later-2", "later-3", "later-3", "later-4", "later-6"],
    "parts": ["later-2", "later-5", "later-5"],
    "slow": ["later-7", "later-8", "later-8", "later-9", "later-10"],
    "all": [f"later-{k}" for k in range(1, 11)],
}
