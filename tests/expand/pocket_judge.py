"""Whether a tool clears a pocket and keeps to it, measured on its way: a rectangle with round
corners (a circle, a slot), by its middle, half sides, the radius of its corners and its turn in
degrees."""

from __future__ import annotations

import math

import numpy as np

Wall = tuple[tuple[float, float], tuple[float, float], float, float]


def from_wall(xy: np.ndarray, middle, sides, corner: float, turn: float) -> np.ndarray:
    """How far inside of the wall places lie."""
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    x, y = (xy - middle).T
    u = np.abs(x * c + y * s) - sides[0] + corner
    v = np.abs(y * c - x * s) - sides[1] + corner
    outside = np.hypot(np.maximum(u, 0), np.maximum(v, 0)) + np.minimum(np.maximum(u, v), 0)
    return corner - outside


def assert_cleared(places: np.ndarray, wall: Wall, radius: float, left: float) -> None:
    """The tool keeps to the pocket less what is left, and passes all of it."""
    assert from_wall(places[:, :2], *wall).min() >= radius + left - 1e-3
    middle, sides, corner, turn = wall
    rng = np.random.default_rng(1)
    reach = max(sides) * 1.5
    points = middle + rng.uniform(-reach, reach, (1500, 2))
    round_ = max(corner - left, radius)  # what a tool leaves in a corner
    inner = (middle, (sides[0] - left, sides[1] - left), round_, turn)
    points = points[from_wall(points, *inner) > 2e-3]
    away = [np.hypot(*(places[:, :2] - p).T).min() for p in points]
    assert max(away) < radius + 1e-3
