"""Squareness: two axes do not stand at the assumed angle; the first leans as the second moves (ISO 230-1)."""

import numpy as np

from postproc.effects import State, along, one_way

PARAMETERS = {
    "urad": "urad, change of the angle: positive where it is more than a right one",
}
KIND, USE, PER = "machine", "compensate", "pair"
NEEDS, SEES = ("position",), ("tool",)
TEXT = "Two axes are not square. Write it into the machine's squareness; a program compensates it."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    first, second = axis[0], axis[1]
    return along(first, -state.position[second] * 1e-3)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"urad": float(coefficients[0])}


def coefficients(urad: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([urad]), {}


def tables(axis: str, travel: tuple[float, float], urad: float):
    """The second axis' travel moves the tool along the first; travel: of the second axis."""
    first, second = axis[0], axis[1]
    return [one_way(second, f"E{first}", travel, 2, lambda p: -urad * p * 1e-3)]
