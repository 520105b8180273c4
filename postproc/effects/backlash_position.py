"""Reversal error that varies along the travel: a worn stretch of the screw, a preload that is not even."""

import numpy as np

from postproc.effects import UM, State, along, legendre, taken_up

PARAMETERS = {
    "b0_um": "um, mean lost motion",
    "b1_um": "um, its change from the middle to the end of the travel",
    "b2_um": "um, share of its second Legendre polynomial",
    "play_mm": "mm, way after a turn over which it is taken up",
}
OPTIONAL = {"play_mm": 0.0}
SMALL = 0.02  # mm
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position", "approach"), ("tool",)
TEXT = (
    "The lost motion differs along the travel: a worn stretch of the screw. "
    "A two-way table corrects it; one backlash number can not. Look at the screw where it is largest."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    near = state.distance.get(axis)
    fine = near is not None and bool(np.any(near < SMALL))
    return [{"play_mm": v} for v in (0.0, 0.004, 0.008, 0.016)] if fine else [{"play_mm": 0.0}]


def columns(state: State, axis: str, play_mm: float = 0.0) -> np.ndarray:
    u = state.share(axis)
    half = -state.approach[axis] / 2 * taken_up(state, axis, play_mm)
    return along(axis, half, half * u, half * legendre(u, 2))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {f"b{k}_um": float(c) for k, c in enumerate(coefficients)} | {"play_mm": shape["play_mm"]}


def coefficients(b0_um: float, b1_um: float, b2_um: float, play_mm: float = 0.0) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([b0_um, b1_um, b2_um]), {"play_mm": play_mm}


def tables(axis: str, travel: tuple[float, float], b0_um: float, b1_um: float, b2_um: float, play_mm: float = 0.0):
    nodes = np.linspace(*travel, 21)
    u = np.linspace(-1, 1, 21)
    half = (b0_um + b1_um * u + b2_um * legendre(u, 2)) * UM / 2
    return [(f"E{axis}", axis, nodes, -half, half)]
