"""What every part knows: draws, smooth curves, and what follows slowly.

Units: mm, s, um, urad, degrees C, N, A. A deviation is actual less commanded, of the tool relative
to the workpiece.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Rng = np.random.Generator
Fields = dict[str, Array]  # channel of a recording, or direction -> um, one value a reading
T = TypeVar("T")

TURN = 2 * np.pi
LONG_AGO = 1e3  # mm or s since a reversal that was before the test


class Redraw(Exception):
    """What was drawn can not be built on this machine, or not be seen by these tests."""


def log_uniform(r: Rng, low: float, high: float) -> float:
    """Uniform in the logarithm."""
    return float(np.exp(r.uniform(np.log(low), np.log(high))))


def pick(r: Rng, seq: Sequence[T]) -> T:
    return seq[int(r.integers(len(seq)))]


def smooth_curve(r: Rng, modes: int = 4) -> Callable[[Array], Array]:
    """A random smooth curve over 0 to 1, rms about 1."""
    k = np.arange(1, modes + 1)
    a = r.normal(size=modes) / k
    phase = r.uniform(0, TURN, modes)
    slope = r.normal()
    rms = np.sqrt(np.sum(a * a) / 2 + slope * slope / 12) + 1e-9

    def curve(u: Array) -> Array:
        waves = a[:, None] * np.sin(np.pi * k[:, None] * u[None] + phase[:, None])
        return (slope * (u - 0.5) + waves.sum(0)) / rms

    return curve


def levelled(curve: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """A curve over 0 to 1 less its straight line: zero and slope belong to others."""
    u = np.linspace(0, 1, 300)
    line = np.polyfit(u, curve(u), 1)
    return lambda u: curve(u) - np.polyval(line, u)


def relaxed(drive: Array, dt: float, tau: float) -> Array:
    """A first-order lag of `drive`, by steps of dt, s; from rest."""
    y, k = np.zeros(len(drive)), 1 - np.exp(-dt / tau)
    for i in range(1, len(drive)):
        y[i] = y[i - 1] + k * (drive[i] - y[i - 1])
    return y
