"""Cyclic error: periodic in the position, of a screw's turn or a scale's grating."""

import numpy as np

from postproc.effects import UM, State, along, blurred, swing, swing_coefficients

PARAMETERS = {
    "period_mm": "mm, its period",
    "amplitude_um": "um, half of the swing",
    "phase_deg": "degrees, of a cosine at zero",
}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool",)
TEXT = (
    "The position swings once per turn of the screw or per period of the scale. "
    "Compare the period with the lead; the table must be several nodes a period."
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


def tables(axis: str, travel: tuple[float, float], period_mm: float, amplitude_um: float, phase_deg: float):
    """24 nodes a period: what is left between them is below 1 % of the amplitude."""
    number = min(int(np.ceil((travel[1] - travel[0]) / period_mm * 24)) + 1, 200_000)
    nodes = np.linspace(*travel, number)
    value = amplitude_um * np.cos(2 * np.pi * nodes / period_mm - np.radians(phase_deg)) * UM
    return [(f"E{axis}", axis, nodes, value, value)]
