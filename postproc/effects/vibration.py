"""Vibration: an oscillation at a fixed frequency in time."""

import numpy as np

from postproc.effects import State, along, swing, swing_coefficients

PARAMETERS = {
    "frequency_hz": "Hz, its frequency",
    "amplitude_um": "um, half of the swing",
    "phase_deg": "degrees, of a cosine at zero",
}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("time", "velocity"), ("tool", "scale")
TEXT = (
    "Something swings at a fixed frequency. "
    "Find what turns at that frequency (spindle, fan, pump) or which mode it is; a program can not correct it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return []  # found from the spectrum of what is left, see diagnose


def columns(state: State, axis: str, frequency_hz: float) -> np.ndarray:
    angle = 2 * np.pi * frequency_hz * state.time
    return along(axis, np.cos(angle), np.sin(angle))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"frequency_hz": shape["frequency_hz"]} | swing(coefficients)


def coefficients(frequency_hz: float, amplitude_um: float, phase_deg: float) -> tuple[np.ndarray, dict[str, float]]:
    return swing_coefficients(amplitude_um, phase_deg), {"frequency_hz": frequency_hz}
