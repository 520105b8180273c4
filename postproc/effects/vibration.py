"""Vibration: an oscillation at a fixed frequency in time.

What swings by itself does so in another phase at every passage: with `passages` 1 each has its own.
"""

import numpy as np

from postproc.effects import State, along, swing, swing_coefficients, waves_of

PARAMETERS = {
    "frequency_hz": "Hz, its frequency",
    "amplitude_um": "um, half of the swing",
    "phase_deg": "degrees, of a cosine at t = 0; of the first passage",
    "passages": "1, every passage has a phase of its own; 0, one for all",
}
OPTIONAL = {"passages": 0.0, "phase_deg": 0.0}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("time", "velocity"), ("tool", "scale")
TEXT = (
    "Something swings at a fixed frequency. "
    "Find what turns at that frequency (spindle, fan, pump) or which mode it is; a program can not correct it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return []  # found from the spectrum of what is left, see diagnose


def columns(state: State, axis: str, frequency_hz: float, passages: float = 0.0) -> np.ndarray:
    swings = waves_of(state, "time", frequency_hz)
    if not passages:
        return along(axis, *swings)
    moves = state.since[axis] < 1e9 if axis in state.since else np.ones(len(state), bool)
    number = np.where(moves, state.passage, -1)
    parts = [number == p for p in np.unique(number[number >= 0])]
    return along(axis, *(swing * part for part in parts for swing in swings))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    pairs = np.asarray(coefficients).reshape(-1, 2)
    first = swing(pairs[0])
    size = float(np.sqrt(np.mean((pairs**2).sum(axis=1))))
    return (
        {"frequency_hz": shape["frequency_hz"], "passages": shape.get("passages", 0.0)} | first | {"amplitude_um": size}
    )


def coefficients(
    frequency_hz: float, amplitude_um: float, phase_deg: float = 0.0, passages: float = 0.0
) -> tuple[np.ndarray, dict[str, float]]:
    """One phase for all: which phases other passages have nobody can foretell."""
    return swing_coefficients(amplitude_um, phase_deg), {"frequency_hz": frequency_hz, "passages": 0.0}
