"""Cyclic reading error of a sensor: the scale says so, the table does not move so."""

import numpy as np

from postproc.effects import State, along, blurred, swing, swing_coefficients

PARAMETERS = {
    "period_mm": "mm, its period",
    "amplitude_um": "um, half of the swing",
    "phase_deg": "degrees, of a cosine at zero",
}
KIND, USE, PER = "instrument", "recording", "axis"
NEEDS, SEES = ("position",), ("scale",)
TEXT = (
    "The encoder's signal is periodic in the position. "
    "Clean or adjust the reading head; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return []  # found from the spectrum of what is left, see diagnose


def columns(state: State, axis: str, period_mm: float) -> np.ndarray:
    angle = 2 * np.pi * state.position[axis] / period_mm
    left = blurred(state, state.velocity[axis] / period_mm) if axis in state.velocity else 1.0
    return along(axis, left * np.cos(angle), left * np.sin(angle))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"period_mm": shape["period_mm"]} | swing(coefficients)


def coefficients(period_mm: float, amplitude_um: float, phase_deg: float) -> tuple[np.ndarray, dict[str, float]]:
    return swing_coefficients(amplitude_um, phase_deg), {"period_mm": period_mm}
