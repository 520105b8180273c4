"""Whether a hidden effect can be seen: its energy over the noise that is left when zeros, what the
tables may lack and the shapes that take it for themselves have had their part (Kay, Fundamentals of
Statistical Signal Processing II, 1998: the energy-to-noise ratio of a known signal)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .base import Array, Fields, Rng
from .noise import Noise, make_noise
from .recordings import Recording


def without_zeros(rec: Recording, y: Array) -> Array:
    """um, less what the instrument's zeros take."""
    zeros = rec.zeros()
    if not zeros:
        return y
    columns = np.stack(zeros, 1)
    return y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]


def peak(recs: list[Recording], shapes: list[Fields]) -> float:
    """um: the largest change of a reading once the best zeros are taken out."""
    largest = 0.0
    for rec, shape in zip(recs, shapes, strict=True):
        for channel in rec.channels:
            if channel in shape and np.any(shape[channel]):
                largest = max(largest, float(abs(without_zeros(rec, shape[channel])).max()))
    return largest


def visibility(
    recs: list[Recording],
    noises: list[Noise],
    shapes: list[Fields],
    others: list[list[Fields]],
    r: Rng,
    modes: list[list[tuple[float, Fields]]] | None = None,
) -> float:
    """Standard deviations by which the shape stands out: the square root of its whitened energy
    that zeros, other shapes and the tables' modes (of a known spread, common to all recordings) do
    not take. others: shape by shape, recording by recording; modes: by recording."""
    n_zero = sum(len(rec.zeros()) * len(rec.channels) for rec in recs)
    n_free = n_zero + len(others)
    spreads = [sd for sd, _ in max(modes, key=len)] if modes else []
    size = n_free + len(spreads)
    normal, right, energy, zero_at = np.zeros((size, size)), np.zeros(size), 0.0, 0
    for k, rec in enumerate(recs):
        tables = [rec.project(moved) for _, moved in modes[k]] if modes else []
        none = np.zeros(rec.n)
        for channel in rec.channels:
            white = _whitener(r, rec, noises[k])
            s = white(shapes[k].get(channel, none))
            x = np.zeros((rec.n, size))
            for q in rec.zeros():
                x[:, zero_at] = white(q)
                zero_at += 1
            for j, other in enumerate(others):
                if channel in other[k]:
                    x[:, n_zero + j] = white(other[k][channel])
            for j, moved in enumerate(tables):
                x[:, n_free + j] = white(moved.get(channel, none))
            normal += x.T @ x
            right += x.T @ s
            energy += s @ s
    if spreads:
        at = range(n_free, size)
        normal[at, at] += 1 / np.maximum(np.array(spreads), 1e-6) ** 2
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-20))
    right = right / scale
    found = np.linalg.lstsq(normal / scale[:, None] / scale[None], right, rcond=1e-10)[0]
    return float(np.sqrt(max(energy - right @ found, 0)))


def _whitener(r: Rng, rec: Recording, noise: Noise) -> Callable[[Array], Array]:
    """A first-order whitening filter, fitted to a draw of the noise."""
    y = make_noise(r, rec.t, noise) + r.uniform(-0.5, 0.5, rec.n) * rec.step
    y = y - y.mean()
    phi = 0.0
    if rec.n > 8:
        phi = float(np.clip(y[1:] @ y[:-1] / max(y @ y, 1e-12), 0, 0.9995))
    sd = max(float(np.sqrt(np.mean((y[1:] - phi * y[:-1]) ** 2))), 1e-4)

    def white(y: Array) -> Array:
        out = np.empty(rec.n)
        out[0] = y[0] * np.sqrt(1 - phi**2)
        out[1:] = y[1:] - phi * y[:-1]
        return out / sd

    return white
