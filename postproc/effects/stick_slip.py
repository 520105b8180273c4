"""Stick-slip: saw-tooth motion at low feed; the slide waits, then jumps."""

import numpy as np

from postproc.effects import State, along, grid

PARAMETERS = {
    "period_mm": "mm, way between two jumps",
    "size_um": "um, how far it lags before it jumps",
}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("distance", "velocity", "approach"), ("tool", "scale")
TEXT = (
    "The slide sticks and jumps at low feed. "
    "Lubrication, guideway material, a higher feed; a program can not correct it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"period_mm": v} for v in grid(0.02, 2.0, 12)]


def columns(state: State, axis: str, period_mm: float) -> np.ndarray:
    phase = (state.distance[axis] / period_mm) % 1.0
    moves = state.velocity[axis] != 0
    return along(axis, -state.approach[axis] * moves * (phase - 0.5))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"period_mm": shape["period_mm"], "size_um": float(coefficients[0])}


def coefficients(period_mm: float, size_um: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {"period_mm": period_mm}
