"""Force compliance: a deflection in proportion to the load or cutting force along the axis."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "um_per_N": "um per N, deflection along the axis",
}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("force",), ("tool",)
TEXT = "The axis gives way under load. Less force, a stiffer set-up; part of it can be measured with a weight."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    return along(axis, state.channels[f"force_{axis}_N"])


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"um_per_N": float(coefficients[0])}


def coefficients(um_per_N: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([um_per_N]), {}
