"""Bow: the way of an axis is curved; the tool leaves the line across the motion (straightness, ISO 230-1)."""

import numpy as np

from postproc.effects import XYZ, State, along, legendre, one_way

PARAMETERS = {
    "size_um": "um, second Legendre polynomial over the travel",
    "third_um": "um, the third",
    "across": "0, 1, 2: X, Y, Z, the direction of the error",
}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool",)
TEXT = "The guideway is bowed. Measure the straightness and write the table; check the machine's level."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"across": float(XYZ.index(x))} for x in state.position if x != axis and x in XYZ]


def columns(state: State, axis: str, across: float) -> np.ndarray:
    u, way = state.share(axis), XYZ[int(across)]
    return along(way, legendre(u, 2), legendre(u, 3))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0]), "third_um": float(coefficients[1]), "across": shape["across"]}


def coefficients(size_um: float, third_um: float, across: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um, third_um]), {"across": across}


def tables(axis: str, travel: tuple[float, float], size_um: float, third_um: float, across: float):
    def shape(p: np.ndarray) -> np.ndarray:
        u = 2 * (p - travel[0]) / (travel[1] - travel[0]) - 1
        return size_um * legendre(u, 2) + third_um * legendre(u, 3)

    return [one_way(axis, f"E{XYZ[int(across)]}", travel, 161, shape)]
