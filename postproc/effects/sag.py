"""Sag: a structure bends with the place of a mass on another axis."""

import numpy as np

from postproc.effects import XYZ, State
from postproc.effects import along as towards

PARAMETERS = {
    "size_um": "um, at the end of the other axis' travel",
    "along": "0, 1, 2: X, Y, Z, the direction of the error",
    "lever": "1, it grows with the place of the next axis too; 0, it does not",
}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool",)
TEXT = (
    "A moving mass bends what carries it. "
    "Measure the straightness with the mass at both ends; a table over two axes corrects it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [
        {"along": float(XYZ.index(x)), "lever": v} for x in state.position if x != axis and x in XYZ for v in (0.0, 1.0)
    ]


def columns(state: State, axis: str, along: float, lever: float) -> np.ndarray:
    reach = (state.share(axis) + 1) / 2
    others = [x for x in state.position if x != axis and x != XYZ[int(along)]]
    arm = (state.share(others[0]) + 1) / 2 if others and lever else 1.0
    return towards(XYZ[int(along)], reach**2 * arm)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0]), "along": shape["along"], "lever": shape["lever"]}


def coefficients(size_um: float, along: float, lever: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {"along": along, "lever": lever}
