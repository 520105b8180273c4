"""Friction that differs with the direction: in motion the axis is held back more one way than the other."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "size_um": "um, difference between the two directions in motion",
    "viscous_um_s_mm": "um per mm/s, its part that grows with the speed",
}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = (
    "Friction differs with the direction of motion. "
    "Balance weight, wiper, guideway strip; more integral action in the drive."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    v = state.velocity[axis]
    return along(axis, -np.sign(v) / 2, -np.abs(v))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0]), "viscous_um_s_mm": float(coefficients[1])}


def coefficients(size_um: float, viscous_um_s_mm: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um, viscous_um_s_mm]), {}
