"""Tool wear: a ramp with the length that was cut, set back when the tool is changed."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "rate_um": "um, wear of the edge from part to part",
    "start_um": "um, the quick wear of a new edge",
    "change": "number of the part before which the tool was changed, 0: never",
    "bores": "1, a worn tool makes bores larger, as one tool post does; -1, smaller, as an edge does",
}
OPTIONAL = {"bores": 1.0}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("part",), ("part",)
TEXT = "The tool wears while it cuts. Tool wear offset, or a change of tool in time; measure after a change to be sure."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    parts = np.unique(state.channels["part"][state.channels["wall"] != 0])
    ways = (1.0, -1.0) if state.channels.get("bore", np.zeros(1)).any() else (1.0,)
    return [{"change": float(p), "bores": w} for p in (0.0, *parts[1:]) for w in ways]


def columns(state: State, axis: str, change: float, bores: float = 1.0) -> np.ndarray:
    part, wall = state.channels["part"], state.channels["wall"]
    wall = np.where(state.channels.get("bore", np.zeros(len(wall))) > 0, bores * wall, wall)
    known = part[wall != 0]
    first = float(known.min()) if len(known) else 0.0
    age = np.where((part >= change) & (change > 0), part - change, part - first)
    return along(axis, wall * age, wall * (1.0 - np.exp(-age)))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {
        "rate_um": float(coefficients[0]),
        "start_um": float(coefficients[1]),
        "change": shape["change"],
        "bores": shape.get("bores", 1.0),
    }


def coefficients(
    rate_um: float, start_um: float, change: float, bores: float = 1.0
) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([rate_um, start_um]), {"change": change, "bores": bores}
