"""Noises of the unseen family.  Read this only if you do not work on the tool that is judged.

Fast: unseen-1 a laser in shop air, variance in proportion to the path (Estler 1985; Bobroff 1993),
unseen-2 an encoder that counts in coarse steps (ISO 230-4 and JCGM 101:2008, 6.4.3: rounding),
unseen-3 single readings out to one side (a chip or drop in the beam; Tukey 1960), unseen-4 a
smoothing filter of the second order, critically damped (Altintas 2012, measuring chains), unseen-5
readings at rest of a slide that is hunting by a count of its encoder: three levels.
Slow: unseen-6 a fixture that gives way as it was clamped, Burgers' body (Findley 1976: a part that
settles, a part that goes on), unseen-7 a bar warmed by the hand at each mounting, and its magnetic
centre that moves (ISO 230-4), unseen-8 turbulence while the heater blows, with the path (Estler
1985), unseen-9 mains hum, 50 or 60 Hz with its third harmonic, as it is sampled (Morrison 1998),
unseen-10 an instrument that walks and is set to zero before every run (ISO 230-2).
unseen-0: captures that were missed because the slide had not stood still long enough.

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
from .sealed_noise import from_start
from .world import World


def fast(number: int) -> Callable[[FastKind], FastKind]:
    """Decorator that files a fast kind."""

    def add(f: FastKind) -> FastKind:
        MORE_FAST[f"unseen-{number}"] = f
        return f

    return add


def slow(number: int) -> Callable[[SlowKind], SlowKind]:
    """Decorator that files a slow kind."""

    def add(f: SlowKind) -> SlowKind:
        MORE_SLOW[f"unseen-{number}"] = f
        return f

    return add


def said(number: int, s: float, **more: float) -> dict:
    """What the details say of a kind: a fast one's deviation, numbers of its own."""
    return {"kind": f"unseen-{number}", "sd_um": round(s, 4)} | {
        k: round(v, 4) for k, v in more.items()
    }


def path(rec: Rec, c: int) -> Array:
    """0..1: length of what is measured, from the instrument; radius and parts are all alike."""
    if rec.kind == "targets":
        seen = rec.meta["sensitive"]
        x = rec.pos @ (seen if rec.laser else np.eye(3)[rec.meta["along"]])
    elif rec.kind == "trace":
        x = rec.pos[:, c]
    else:
        return np.ones(rec.n_obs)
    return (x - x.min() + 50.0) / (float(np.ptp(x)) + 50.0)


@fast(1)
def shop_air(r: Rng, s: float, rec: Rec) -> Noise:
    """Variance a^2 + b^2 L; its mean over the file is s^2."""
    x = path(rec, int(rec.channels[0]))
    var = r.uniform(0.05, 0.4) + x
    var = s * s * var / var.mean()
    return Noise(r.normal(0, np.sqrt(var)), var, [said(1, s)])


@fast(2)
def counted(r: Rng, s: float, rec: Rec) -> Noise:
    """White, at least half a step of it, and counted in steps of 0.05 to 1 um."""
    q = float(pick(r, [0.05, 0.1, 0.2] if rec.kind == "trace" else [0.1, 0.2, 0.5, 1.0]))
    s = max(s, 0.5 * q)
    n = rec.n_obs
    return Noise(r.normal(0, s, n), np.full(n, s * s + q * q / 12), [said(2, s, step=q)], quant=q)


@fast(3)
def in_the_beam(r: Rng, s: float, rec: Rec) -> Noise:
    """White, and 0.3 to 2 of a hundred readings off by 4 to 9 s to one side; mean 0."""
    p, k, n = r.uniform(0.003, 0.02), r.uniform(4, 9) * pick(r, [-1, 1]), rec.n_obs
    x = r.normal(0, s, n) + k * s * ((r.random(n) < p) - p)
    return Noise(x, np.full(n, s * s * (1 + k * k * p * (1 - p))), [said(3, s, share=p)])


@fast(4)
def smoothed(r: Rng, s: float, rec: Rec) -> Noise:
    """White through 1 / (1 - p z^-1)^2, p 0.2 to 0.85."""
    p, n = float(r.uniform(0.2, 0.85)), rec.n_obs
    a = [1.0, -2 * p, p * p]
    q = s * np.sqrt((1 - p * p) ** 3 / (1 + p * p))
    x = lfilter([1.0], a, r.normal(0, q, n + 2000))[2000:]
    return Noise(x, np.full(n, q * q), [said(4, s, pole=p)], [1.0], a)


@fast(5)
def hunting_count(r: Rng, s: float, rec: Rec) -> Noise:
    """One count up, none or one down, and a white rest; variance s^2 in all."""
    n, share, p = rec.n_obs, r.uniform(0.3, 0.8), r.uniform(0.2, 0.6)
    step = s * np.sqrt(share / p)
    x = step * np.where(r.random(n) < p, r.choice([-1.0, 1.0], n), 0.0)
    x += r.normal(0, s * np.sqrt(1 - share), n)
    return Noise(x, np.full(n, s * s), [said(5, s, step=step)])


def columns(r: Rng, noise: Noise, shapes: list[Array], spec: dict) -> None:
    """Adds shapes (um) of normal amplitude and lays them down for the oracle."""
    for col in shapes:
        noise.values += col * r.normal()
        noise.columns.append(col)
    noise.spec.append(spec)


@slow(6)
def clamped(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """1 - exp(-t / tau) and t, about s um each at the file's end."""
    t, span = from_start(rec)
    tau = span * logu(r, 0.02, 0.5)
    shapes = [s * (1 - np.exp(-t / tau)), 0.8 * s * t / span]
    columns(r, noise, shapes, {"kind": "unseen-6", "um": round(s, 4), "tau_s": round(tau, 1)})


@slow(7)
def by_hand(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """From each mounting (run) on a bar cools with one time constant; its centre goes in a line."""
    t, span = from_start(rec)
    runs = rec.run[::2] if rec.kind == "features" else rec.run
    tau, cool = logu(r, 60, 600), np.zeros(len(t))
    for k in np.unique(runs):
        cool[runs == k] = np.exp(-(t[runs == k] - t[runs == k][0]) / tau)
    shapes = [1.5 * s * cool]
    if rec.kind == "ballbar":
        shapes += [s * t / span * rec.meta["unit"][:, a] for a in rec.meta["plane"]]
    columns(r, noise, shapes, {"kind": "unseen-7", "um": round(s, 4), "tau_s": round(tau, 1)})


@slow(8)
def blower(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Eddies of 1 to 8 s while the heater is on, a third of that while it is off; with the path."""
    t, span = from_start(rec)
    period, on, tau = logu(r, span / 12, span), r.uniform(0.3, 0.6), logu(r, 1, 8)
    gate = np.where((t / period + r.uniform()) % 1.0 < on, 1.0, 0.33)
    gain = gate * path(rec, c)
    noise.values += s * gain * ou(r, t, tau)
    noise.kernels.append((modulate(k_ou(s * s, tau), gain, t), t))
    noise.spec.append({"kind": "unseen-8", "um": round(s, 4), "tau_s": round(tau, 2)})


@slow(9)
def hum(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """Two lines at the mains' frequency to 0.1 % and its third; at rest, where phase and capture
    have nothing to do with each other, white."""
    t, _ = from_start(rec)
    hz = float(pick(r, [50.0, 50.0, 60.0])) * r.uniform(0.999, 1.001)
    k, spec = r.uniform(0.1, 0.4), {"kind": "unseen-9", "um": round(s, 4), "frequency_hz": hz}
    if rec.kind in ("trace", "ballbar"):
        arg = 2 * np.pi * hz * t
        shapes = [g * s * f(n * arg) for n, g in ((1, 1.0), (3, k)) for f in (np.cos, np.sin)]
        columns(r, noise, shapes, spec)
        return
    noise.values += s * np.sqrt(2 + 2 * k * k) * np.sin(r.uniform(0, 2 * np.pi, len(t)))
    noise.var = noise.var + s * s * (1 + k * k)
    noise.spec.append(spec)


@slow(10)
def zeroed(r: Rng, noise: Noise, s: float, rec: Rec, world: World, c: int) -> None:
    """A walk that starts from 0 in every run, s um at the end of the longest one."""
    t, _ = from_start(rec)
    runs = rec.run[::2] if rec.kind == "features" else rec.run
    starts = t[np.r_[True, np.diff(runs) != 0]]
    since = t - starts[np.searchsorted(starts, t, "right") - 1]
    q = s / np.sqrt(max(float(since.max()), 1e-9))
    for a, b in zip(starts, np.r_[starts[1:], np.inf], strict=True):
        on = (t >= a) & (t < b)
        steps = np.sqrt(np.diff(t[on], prepend=t[on][0]))
        noise.values[on] += q * np.cumsum(r.normal(size=int(on.sum())) * steps)

    def kernel(a: Array, b: Array) -> Array:
        i, j = (np.searchsorted(starts, x + 1e-9, "right") - 1 for x in (a, b))
        return q * q * np.minimum((a - starts[i])[:, None], b - starts[j]) * (i[:, None] == j)

    noise.kernels.append((kernel, t))
    noise.spec.append({"kind": "unseen-10", "um": round(s, 4)})


def missed(r: Rng, rec: Rec) -> Array | None:
    """One to five captures at rest that are not in the file."""
    n = rec.n_obs
    if rec.kind != "targets" or r.random() > 0.2 or n < 20:
        return None
    gone = np.zeros(n, bool)
    gone[r.integers(1, n - 1, int(r.integers(1, 6)))] = True
    return gone


LOSSES["unseen"] = missed
LATER["unseen"] = {
    "fast": ["unseen-1", "unseen-1", "unseen-2", "unseen-3", "unseen-5"],
    "trace": [f"unseen-{k}" for k in (2, 3, 4, 4, 5)],
    "parts": ["unseen-2", "unseen-3"],
    "slow": [f"unseen-{k}" for k in range(6, 11)],
    "all": [f"unseen-{k}" for k in range(1, 11)],
}
