"""Viscous friction: an error proportional to the speed, of a drive that gives under the grease's resistance."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "um_s_mm": "um per mm/s, deflection for a speed",
}
# It is a lag too, see servo_lag: um per mm/s are ms.
PLAUSIBLE = {"um_s_mm": (-250.0, 250.0)}  # beyond, it is something else
EXPECTED = {"um_s_mm": 1}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = (
    "Friction grows with the speed and bends the drive. "
    "Lubrication and preload; feed-forward of the velocity in the drive."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    return along(axis, -state.velocity[axis])


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"um_s_mm": float(coefficients[0])}


def coefficients(um_s_mm: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([um_s_mm]), {}
