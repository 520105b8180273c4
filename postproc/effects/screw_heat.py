"""Screw heat: the screw grows with its own temperature, from the bearing that holds it.

The temperature of the screw where it is recorded, else heat that comes with time, or with the axis' travel.
"""

import numpy as np

from postproc.effects import State, along, warmth

PARAMETERS = {
    "alpha_ppm_K": "um/(m K), expansion by the recorded temperature; 0 where none is recorded",
    "grown_ppm": "um/m, expansion at the end where no temperature is recorded",
    "fixed_um_K": "um per K, growth of what holds the screw",
    "tau_s": "s, 0: by the recorded temperature, else the time in which the heat comes",
    "by_travel": "1, the heat comes with the axis' own travel and goes when it rests; 0, it comes with time",
    "held_at_mm": "mm, where the screw is held: it grows from there",
    "free": "1, what holds it grows too; 0, it does not",
}
OPTIONAL = {"alpha_ppm_K": 0.0, "grown_ppm": 0.0, "by_travel": 0.0, "held_at_mm": 0.0, "free": 1.0, "fixed_um_K": 0.0}
EXPECTED = {"alpha_ppm_K": 1, "grown_ppm": 1}
PLAUSIBLE = {
    "alpha_ppm_K": (-150.0, 150.0),
    "grown_ppm": (-150.0, 150.0),
    "fixed_um_K": (-60.0, 60.0),
}  # beyond, it is something else
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position", "time"), ("tool", "part")
WALLS = True  # features are wider where both their walls are farther apart
TEXT = (
    "The screw grows with its own heat. "
    "Warm up, a scale instead of the motor's encoder, or compensation by the screw's temperature."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    if not len(state.time):
        return []
    low, high = state.travel[axis]
    ends = [(low, 0.0), (high, 0.0), (0.0, 1.0)]
    known = state.channel(f"T_screw_{axis}_C", f"T_scale_{axis}_C") is not None
    heats = [(0.0, 0.0)] if known else [(v, w) for v in (600.0, 1800.0, 5400.0) for w in (0.0, 1.0)]
    return [{"tau_s": t, "by_travel": w, "held_at_mm": end, "free": free} for t, w in heats for end, free in ends]


def columns(
    state: State, axis: str, tau_s: float, by_travel: float = 0.0, held_at_mm: float = 0.0, free: float = 1.0
) -> np.ndarray:
    heat = warmth(state, axis, tau_s, by_travel)
    grown = heat * (state.position[axis] - held_at_mm) * 1e-3
    return along(axis, grown, heat) if free else along(axis, grown)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    fixed = float(coefficients[1]) if len(coefficients) > 1 else 0.0
    slope = float(coefficients[0])
    alpha, grown = (0.0, slope) if shape["tau_s"] > 0 else (slope, 0.0)
    return {"alpha_ppm_K": alpha, "grown_ppm": grown, "fixed_um_K": fixed} | shape


def coefficients(
    alpha_ppm_K: float = 0.0, grown_ppm: float = 0.0, fixed_um_K: float = 0.0, tau_s: float = 0.0, by_travel: float = 0.0,
    held_at_mm: float = 0.0, free: float = 1.0,
) -> tuple[np.ndarray, dict[str, float]]:  # fmt: skip
    slope = alpha_ppm_K + grown_ppm
    value = np.array([slope, fixed_um_K] if free else [slope])
    return value, {"tau_s": tau_s, "by_travel": by_travel, "held_at_mm": held_at_mm, "free": free}
