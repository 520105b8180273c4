"""Cosine error: the beam was not parallel to the motion; readings are too short in proportion."""

import numpy as np

from postproc.effects import State

PARAMETERS = {
    "ppm": "um/m, never above zero: minus half the square of the angle",
}
PLAUSIBLE = {"ppm": (-5000.0, 0.0)}  # beyond, it is something else
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = ("position",), ("laser",)
TEXT = (
    "The laser beam was not parallel to the axis. "
    "Align the beam over the whole travel; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    return (state.beam * 1e-6)[None]


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"ppm": float(coefficients[0])}


def coefficients(ppm: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([ppm]), {}
