"""Lost motion: the axis lags behind by half the play, on the side it came from.

Positive when it stops short in either direction; negative when the control over-compensates (ISO 230-2 reversal).
"""

import numpy as np

from postproc.effects import UM, State, along

PARAMETERS = {
    "size_um": "um, lost motion between the two directions of approach",
}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("approach",), ("tool",)
TEXT = (
    "Lost motion in nut, bearing or coupling: the same gap wherever the axis turns back. "
    "Set the control's backlash or let the compensator take it up; a growing value is wear."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    return along(axis, -state.approach[axis] / 2)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0])}


def coefficients(size_um: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {}


def tables(axis: str, travel: tuple[float, float], size_um: float):
    nodes = np.array(travel)
    return [(f"E{axis}", axis, nodes, np.full(2, -size_um * UM / 2), np.full(2, size_um * UM / 2))]
