"""Screw heat: the screw grows with its own temperature, from the bearing that holds it.

The temperature of the screw where it is recorded, else heat that comes with time, or with the axis' travel.
"""

import numpy as np

from postproc.effects import State, along, warmth

PARAMETERS = {
    "alpha_ppm_K": "um/(m K), expansion; where no temperature is recorded um/m at the end",
    "fixed_um_K": "um per K, growth of what holds the screw",
    "tau_s": "s, 0: by the recorded temperature, else the time in which the heat comes",
    "by_travel": "1, the heat comes with the axis' own travel and goes when it rests; 0, it comes with time",
}
OPTIONAL = {"by_travel": 0.0}
EXPECTED = {"alpha_ppm_K": 1}
PLAUSIBLE = {"alpha_ppm_K": (-150.0, 150.0), "fixed_um_K": (-60.0, 60.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position", "time"), ("tool",)
TEXT = (
    "The screw grows with its own heat. "
    "Warm up, a scale instead of the motor's encoder, or compensation by the screw's temperature."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    if state.channel(f"T_screw_{axis}_C", f"T_scale_{axis}_C") is not None:
        return [{"tau_s": 0.0, "by_travel": 0.0}]
    return (
        [{"tau_s": v, "by_travel": w} for v in (600.0, 1800.0, 5400.0) for w in (0.0, 1.0)] if len(state.time) else []
    )


def columns(state: State, axis: str, tau_s: float, by_travel: float = 0.0) -> np.ndarray:
    heat = warmth(state, axis, tau_s, by_travel)
    return along(axis, heat * state.position[axis] * 1e-3, heat)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    named = {"alpha_ppm_K": float(coefficients[0]), "fixed_um_K": float(coefficients[1]), "tau_s": shape["tau_s"]}
    return named | {"by_travel": shape.get("by_travel", 0.0)}


def coefficients(
    alpha_ppm_K: float, fixed_um_K: float, tau_s: float, by_travel: float = 0.0
) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([alpha_ppm_K, fixed_um_K]), {"tau_s": tau_s, "by_travel": by_travel}
