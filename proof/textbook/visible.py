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
    tables: list[tuple[float, list[Fields]]],
) -> float:
    """Standard deviations by which the shape stands out: the square root of its whitened energy
    that zeros, other shapes and what the tables may lack do not take. shapes, and each of others:
    by recording; tables: standard deviation, and shape by recording."""
    n_zero = sum(len(rec.zeros()) * len(rec.channels) for rec in recs)
    free = [*others, *(shape for _, shape in tables)]
    size = n_zero + len(free)
    normal, right, energy, zero_at = np.zeros((size, size)), np.zeros(size), 0.0, 0
    for k, rec in enumerate(recs):
        for channel in rec.channels:
            white = _whitener(r, rec, noises[k])
            s = white(shapes[k].get(channel, np.zeros(rec.n)))
            columns = dict(enumerate(rec.zeros(), zero_at))
            zero_at += len(columns)
            columns |= {j: y[k][channel] for j, y in enumerate(free, n_zero) if channel in y[k]}
            x = np.zeros((rec.n, size))
            for j, y in columns.items():
                x[:, j] = white(y)
            normal += x.T @ x
            right += x.T @ s
            energy += float(s @ s)
    for at, (spread, _) in enumerate(tables, n_zero + len(others)):
        normal[at, at] += 1 / max(spread, 1e-6) ** 2
    return _left(normal, right, energy)


def _left(normal: Array, right: Array, energy: float) -> float:
    """The square root of what least squares leave of an energy."""
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-20))
    right = right / scale
    found = np.linalg.lstsq(normal / scale[:, None] / scale[None], right, rcond=1e-10)[0]
    return float(np.sqrt(max(energy - float(right @ found), 0.0)))


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
