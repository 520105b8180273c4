"""Tool size: the tool's diameter is not the one that was assumed; every wall is off by half of the difference."""

import numpy as np

from postproc.effects import State

PARAMETERS = {
    "diameter_um": "um, how much larger the tool is",
}
# A cutter that was ground again; beyond, it is another tool (unverified).
PLAUSIBLE = {"diameter_um": (-1000.0, 1000.0)}
KIND, USE, PER = "machine", "compensate", "all"
NEEDS, SEES = ("material",), ("part",)
TEXT = "The tool's diameter is not what the control believes. Measure the tool and set its radius."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    """Half a diameter towards the wall: of a pocket it grows, of a boss it shrinks; on a lathe the same by the tool's nose."""
    walls = state.channels["material"].copy()
    turned = (walls == 0) & (state.channels.get("wall", walls) != 0)
    walls[turned] = np.where(state.channels.get("bore", walls)[turned] > 0, 0.5, -0.5)
    value = np.zeros((1, 3, len(state)))
    value[:] = walls * 1e-3
    return value


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"diameter_um": float(coefficients[0])}


def coefficients(diameter_um: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([diameter_um]), {}
