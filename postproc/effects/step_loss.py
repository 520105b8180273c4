"""Step loss: one jump that stays, of a lost step, a slipped coupling or belt."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "jump_um": "um, the jump",
    "t_s": "s, when it happened",
}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("time",), ("tool",)
TEXT = "The axis has lost its place by one jump. Home the machine again; look at load, acceleration, coupling and belt."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return []  # between any two readings, see diagnose


def columns(state: State, axis: str, t_s: float) -> np.ndarray:
    return along(axis, (state.time > t_s).astype(float))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"jump_um": float(coefficients[0]), "t_s": shape["t_s"]}


def coefficients(jump_um: float, t_s: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([jump_um]), {"t_s": t_s}
