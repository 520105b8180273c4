"""Abbe error: a measured rotation of an axis times an arm that the machine's file does not know."""

import numpy as np

from postproc.effects import State

PARAMETERS = {
    "arm_mm": "mm, the arm that was left out",
    "turn": "0, 1, 2: A, B, C, the rotation",
    "arm": "0, 1, 2: X, Y, Z, the direction of the arm",
}
PLAUSIBLE = {"arm_mm": (-2000.0, 2000.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position", "angles"), ("tool",)
TEXT = (
    "A rotation of the axis acts on an arm that is not in the model. "
    "State where the axis was measured and how long the tool is; measure at two heights."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    known = state.angles.get(axis)
    if known is None:
        return []
    turns = [k for k in range(3) if known[k].any()]
    return [{"turn": float(k), "arm": float(a)} for k in turns for a in range(3) if a != k]


def columns(state: State, axis: str, turn: float, arm: float) -> np.ndarray:
    turned, reach = np.zeros((3, len(state))), np.zeros((3, len(state)))
    turned[int(turn)] = state.angles[axis][int(turn)]
    reach[int(arm)] = 1.0
    return np.cross(turned, reach, axis=0)[None]


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"arm_mm": float(coefficients[0]), "turn": shape["turn"], "arm": shape["arm"]}


def coefficients(arm_mm: float, turn: float, arm: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([arm_mm]), {"turn": turn, "arm": arm}
