"""Coulomb friction: the axis stays behind by the friction over the stiffness of its drive, in motion and after it.

A drive without integral action does not make up for it. After a turn the friction is taken up over a little way (pre-sliding).
"""

import numpy as np

from postproc.effects import State, along, sampled, taken_up

PARAMETERS = {
    "size_um": "um, difference between the two directions",
    "play_mm": "mm, way after a turn over which the friction turns round",
}
OPTIONAL = {"play_mm": 0.0}
SMALL = 0.05  # mm
EXPECTED = {"size_um": 1}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = "Friction holds the axis back while it moves. Lubrication and preload; friction compensation in the drive."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    near = state.distance.get(axis)
    fine = near is not None and bool(np.any(near < SMALL))
    return [{"play_mm": v} for v in (0.0, 0.01, 0.03, 0.1)] if fine else [{"play_mm": 0.0}]


def columns(state: State, axis: str, play_mm: float = 0.0) -> np.ndarray:
    return along(axis, -state.approach[axis] / 2 * taken_up(state, axis, play_mm) * sampled(state))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0]), "play_mm": shape["play_mm"]}


def coefficients(size_um: float, play_mm: float = 0.0) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {"play_mm": play_mm}
