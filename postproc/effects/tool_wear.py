"""Tool wear: a ramp with the length that was cut, set back when the tool is changed."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "rate_um": "um, wear from the first to the last part",
    "start_um": "um, the quick wear of a new edge",
}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("part",), ("part",)
TEXT = "The tool wears while it cuts. Tool wear offset, or a change of tool in time; measure after a change to be sure."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    part = state.channels["part"]
    run = (part - part.min()) / max(float(np.ptp(part)), 1.0)
    sign = state.channels["material"]
    return along(axis, sign * run, sign * (1.0 - np.exp(-6.0 * run)))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"rate_um": float(coefficients[0]), "start_um": float(coefficients[1])}


def coefficients(rate_um: float, start_um: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([rate_um, start_um]), {}
