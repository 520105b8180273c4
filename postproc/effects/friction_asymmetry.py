"""Friction that differs with the direction: after a turn the axis is held back more one way than the other.

Like the spike of a reversal, with another height for each direction; where both are alike it is a plain spike.
"""

import numpy as np

from postproc.effects import State, along, grid

PARAMETERS = {
    "size_um": "um, mean height of the excursion after a turn",
    "slope_um": "um, its share that rises first",
    "difference_um": "um, by how much it is higher in +",
    "difference_slope_um": "um, its share that rises first",
    "tau_ms": "ms, how long it lasts",
}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("since", "approach", "velocity"), ("tool", "scale")
TEXT = (
    "Friction differs with the direction of motion. "
    "Balance weight, wiper, guideway strip; more integral action in the drive."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"tau_ms": v} for v in grid(6.0, 250.0, 9)]


def columns(state: State, axis: str, tau_ms: float) -> np.ndarray:
    q = state.since[axis] / (tau_ms * 1e-3)
    fade = np.where(state.velocity[axis] != 0, np.exp(-np.minimum(q, 50.0)), 0.0)
    s = state.approach[axis]
    return along(axis, -fade * s, -q * fade * s, -fade, -q * fade)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    names = ("size_um", "slope_um", "difference_um", "difference_slope_um")
    return {n: float(c) for n, c in zip(names, coefficients, strict=True)} | {"tau_ms": shape["tau_ms"]}


def coefficients(
    size_um: float, slope_um: float, difference_um: float, difference_slope_um: float, tau_ms: float
) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um, slope_um, difference_um, difference_slope_um]), {"tau_ms": tau_ms}
