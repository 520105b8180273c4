"""Tool wear: a ramp with the length that was cut, set back when the tool is changed."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "rate_um": "um, wear of the edge from part to part",
    "start_um": "um, the quick wear of a new edge",
    "change": "number of the part before which the tool was changed, 0: never",
    "worn_um": "um, wear of the first tool before the first part",
    "bores": "1, a worn tool makes bores larger, as one tool post does; -1, smaller, as an edge does",
}
OPTIONAL = {"bores": 1.0, "worn_um": 0.0}
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
    parts = [wall * age, wall * (1.0 - np.exp(-age))]
    return along(axis, *parts, wall * (part < change)) if change > 0 else along(axis, *parts)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    values = [*(float(c) for c in coefficients), 0.0][:3]
    named = dict(zip(("rate_um", "start_um", "worn_um"), values, strict=True))
    return named | {"change": shape["change"], "bores": shape.get("bores", 1.0)}


def coefficients(
    rate_um: float, start_um: float, change: float, worn_um: float = 0.0, bores: float = 1.0
) -> tuple[np.ndarray, dict[str, float]]:
    values = [rate_um, start_um, worn_um] if change > 0 else [rate_um, start_um]
    return np.array(values), {"change": change, "bores": bores}
