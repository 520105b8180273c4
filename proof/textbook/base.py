"""What every part knows: names of axes, draws, and a case that has to be drawn again.

Units: mm, um, urad, s, degrees C, N, A. A deviation is actual less commanded, of the tool relative
to the workpiece.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rng = np.random.Generator
Fields = dict[str, Array]  # channel of a recording, or direction -> um, one value a reading
T = TypeVar("T")

AT = {"X": 0, "Y": 1, "Z": 2}
ABOUT = {"A": 0, "B": 1, "C": 2}
SQUARENESS = {"XY": "C0Y", "XZ": "B0X", "YZ": "A0Z"}  # name of a plane's squareness
LONG_AGO = 1e4  # mm or s since a reversal that was before the test


class Redraw(Exception):
    """What was drawn can not be seen, or not be built, with this machine and this test."""


def log_uniform(r: Rng, low: float, high: float) -> float:
    """Uniform in the logarithm."""
    return float(np.exp(r.uniform(np.log(low), np.log(high))))


def pick(r: Rng, seq: Sequence[T]) -> T:
    return seq[int(r.integers(len(seq)))]


def sign(r: Rng) -> int:
    return pick(r, [1, -1])


def perpendicular(a: str, b: str) -> str:
    """The rotation about the axis that is square to two others."""
    return "ABC"[3 - AT[a] - AT[b]]


def relaxed(drive: Array, dt: Array, tau: float) -> Array:
    """A first-order lag of `drive`, held over each step dt (s) before its value; from rest."""
    y, out, stay = 0.0, np.zeros(len(drive)), np.exp(-dt / tau)
    for i in range(len(drive)):
        y = y * stay[i] + drive[i] * (1 - stay[i])
        out[i] = y
    return out
