"""Tool wear: a ramp with the length that was cut, set back when the tool is changed."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "rate_um": "um, wear of the edge from part to part",
    "start_um": "um, the quick wear of a new edge",
    "change": "number of the part before which the tool was changed, 0: never",
}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("part",), ("part",)
TEXT = "The tool wears while it cuts. Tool wear offset, or a change of tool in time; measure after a change to be sure."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    parts = np.unique(state.channels["part"][state.channels["wall"] != 0])
    return [{"change": 0.0}] + [{"change": float(p)} for p in parts[1:]]


def columns(state: State, axis: str, change: float) -> np.ndarray:
    part, wall = state.channels["part"], state.channels["wall"]
    known = part[wall != 0]
    first = float(known.min()) if len(known) else 0.0
    age = np.where((part >= change) & (change > 0), part - change, part - first)
    return along(axis, wall * age, wall * (1.0 - np.exp(-age)))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"rate_um": float(coefficients[0]), "start_um": float(coefficients[1]), "change": shape["change"]}


def coefficients(rate_um: float, start_um: float, change: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([rate_um, start_um]), {"change": change}
