"""Servo lag: a following error proportional to the speed, v times the time by which the axis is late."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "size_um": "um, difference between the two directions in motion",
}
EXPECTED = {"size_um": 1}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = "Friction holds the axis back while it moves. Lubrication and preload; friction compensation in the drive."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    return along(axis, -np.sign(state.velocity[axis]) / 2)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0])}


def coefficients(size_um: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {}
