"""Squareness: two axes do not stand at the assumed angle; one leans against the other (ISO 230-1)."""

import numpy as np

from postproc.effects import State, along, one_way

PARAMETERS = {
    "urad": "urad, change of the angle: positive where it is more than a right one",
    "leans": "0, the first axis of the pair leans as the second moves; 1, the second as the first moves",
}
OPTIONAL = {"leans": 0.0}
# A router that was put up by eye: 1 mm on 200 mm (unverified).
PLAUSIBLE = {"urad": (-5000.0, 5000.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "compensate", "pair"
NEEDS, SEES = ("position",), ("tool",)
RESTING = True
TEXT = "Two axes are not square. Write it into the machine's squareness; a program compensates it."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"leans": 0.0}, {"leans": 1.0}]


def columns(state: State, axis: str, leans: float = 0.0) -> np.ndarray:
    first, second = (axis[1], axis[0]) if leans else (axis[0], axis[1])
    return along(first, -state.position[second] * 1e-3)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"urad": float(coefficients[0]), "leans": shape["leans"]}


def coefficients(urad: float, leans: float = 0.0) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([urad]), {"leans": leans}


def moving(axis: str, leans: float = 0.0, **named: float) -> str:
    """The axis whose travel moves the tool along the other."""
    return axis[0] if leans else axis[1]


def tables(axis: str, travel: tuple[float, float], urad: float, leans: float = 0.0):
    """travel: of the axis that moves the tool along the other."""
    driver = moving(axis, leans)
    leaning = axis.replace(driver, "")
    return [one_way(driver, f"E{leaning}", travel, 2, lambda p: -urad * p * 1e-3)]
