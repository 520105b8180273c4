"""Sag: a structure bends with the place of a mass on another axis."""

import numpy as np

from postproc.effects import XYZ, State
from postproc.effects import along as towards

PARAMETERS = {
    "size_um": "um, at the end of the other axis' travel",
    "along": "0, 1, 2: X, Y, Z, the direction of the error",
}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool",)
TEXT = (
    "A moving mass bends what carries it. "
    "Measure the straightness with the mass at both ends; a table over two axes corrects it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"along": float(XYZ.index(x))} for x in state.position if x != axis and x in XYZ]


def columns(state: State, axis: str, along: float) -> np.ndarray:
    reach = (state.share(axis) + 1) / 2
    others = [x for x in state.position if x != axis and x != XYZ[int(along)]]
    lever = (state.share(others[0]) + 1) / 2 if others else 1.0
    return towards(XYZ[int(along)], reach**2 * lever)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0]), "along": shape["along"]}


def coefficients(size_um: float, along: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {"along": along}
