"""Places under turned, scaled and polar coordinates: what their tests share."""

from __future__ import annotations

import math

import numpy as np

from tests.expand.plain_lines import (
    MILL,
    Exact,
    expand,
    motions,
)


def turned(points, degrees: float, centre=(0.0, 0.0)):
    """(n, 2) points turned counter-clockwise about a centre."""
    a = math.radians(degrees)
    matrix = np.array([[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]])
    return (np.asarray(points) - centre) @ matrix.T + centre


def moved(program: str, dialect: str = "fanuc-mill", setup=MILL) -> list[dict]:
    """The motions of a program with | between its lines, written out to a tick; the first one is
    left out."""
    return motions(expand(program.replace("|", "\n"), dialect, setup, Exact), dialect, setup)[1:]


def ends(made: list[dict]) -> np.ndarray:
    """(n, 3) mm."""
    return np.array([m["end"][:3] for m in made], float)
