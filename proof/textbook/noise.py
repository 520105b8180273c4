"""Noise as instruments have it: white, heavy tails, slow wander (an Ornstein-Uhlenbeck process),
random walk, 1/f, bursts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.signal import lfilter

from .base import Array, Rng, log_uniform, pick
from .recordings import Recording

KINDS = ["none", "none", "tails", "wander", "wander", "walk", "pink", "bursts"]
WORDS = {
    "tails": "heavy tails",
    "wander": "slow wander",
    "walk": "random walk",
    "pink": "1/f",
    "bursts": "bursts",
}
Noise = dict[str, Any]  # white: um; of the others their numbers; kinds: in words


def wander(r: Rng, t: Array, sd: float, tau: float) -> Array:
    """An Ornstein-Uhlenbeck process at the times t (s), of time constant tau (s)."""
    n = len(t)
    dt = np.diff(t, prepend=t[0])
    if n > 3 and np.ptp(dt[1:]) < 1e-6 * dt[1:].mean() + 1e-12:
        p = np.exp(-dt[1] / tau)
        e = r.normal(size=n) * np.sqrt(1 - p * p)
        e[0] = r.normal()
        return sd * lfilter([1], [1, -p], e)
    y, z, e = np.empty(n), r.normal(), r.normal(size=n)
    p = np.exp(-np.maximum(dt, 0) / tau)
    for i in range(n):
        z = p[i] * z + np.sqrt(max(1 - p[i] ** 2, 0)) * e[i]
        y[i] = z
    return sd * y


def pink(r: Rng, n: int, sd: float) -> Array:
    """1/f over n readings."""
    f = np.fft.rfftfreq(max(n, 4))
    f[0] = f[1]
    spectrum = (r.normal(size=len(f)) + 1j * r.normal(size=len(f))) / np.sqrt(f)
    y = np.fft.irfft(spectrum, max(n, 4))[:n]
    y -= y.mean()
    return sd * y / max(y.std(), 1e-12)


def draw_noise(r: Rng, rec: Recording, harsh: bool = False) -> Noise:
    """What noise a recording has, by its instrument."""
    white = log_uniform(r, *_white(rec))
    kind = pick(r, KINDS)
    if rec.kind == "features" and kind != "none":
        kind = "tails"
    h = 2.5 if harsh else 1.0
    drawn: Noise = {"white": white}
    numbers: dict[str, Callable[[], Any]] = {
        "tails": lambda: float(r.uniform(3, 6)),
        "wander": lambda: (white * r.uniform(0.4, 1.2) * h, log_uniform(r, 0.05, 0.5)),
        "walk": lambda: white * r.uniform(0.5, 1.5) * h,
        "pink": lambda: white * r.uniform(0.4, 1.0) * h,
        "bursts": lambda: (float(r.uniform(2, 4)), 0.05),
    }
    drawn["kinds"] = ["white"]
    if kind in WORDS:
        drawn[kind] = numbers[kind]()
        drawn["kinds"].append(WORDS[kind])
    if rec.step >= 0.05:
        drawn["kinds"].append(f"quantisation {rec.step:g} um")
    return drawn


def _white(rec: Recording) -> tuple[float, float]:
    """Lowest and largest standard deviation, um."""
    if rec.kind == "targets":
        instrument = rec.head.get("instrument", "")
        fine = any(word in instrument for word in ("laser", "scale", "capac"))
        return (0.15, 0.6) if fine else (0.3, 0.9)
    if rec.kind == "trace":
        return (0.04, 0.6) if rec.sees == "scale" else (0.1, 1.0)
    return (0.1, 0.8) if rec.kind == "ballbar" else (0.3, 0.9)


def make_noise(r: Rng, t: Array, noise: Noise) -> Array:
    """um, at the times t (s)."""
    n = len(t)
    w = r.normal(size=n)
    if "tails" in noise:
        nu = noise["tails"]
        w = r.standard_t(nu, n) * np.sqrt((nu - 2) / nu)
    y = noise["white"] * w
    span = max(t[-1] - t[0], 1e-9)
    if "bursts" in noise:
        factor, part = noise["bursts"]
        for _ in range(max(1, int(r.poisson(2)))):
            i = int(r.integers(n))
            y[i : min(n, i + max(2, int(part * n)))] *= factor
    if "wander" in noise:
        y = y + wander(r, t, noise["wander"][0], noise["wander"][1] * span)
    if "walk" in noise:
        steps = np.sqrt(np.maximum(np.diff(t, prepend=t[0]), 0) / span)
        y = y + noise["walk"] * np.cumsum(r.normal(size=n) * steps)
    if "pink" in noise:
        y = y + pink(r, n, noise["pink"])
    return y
