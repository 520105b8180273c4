"""Laser air: the refractive index of the air changed along the beam (0.93 ppm per K, -0.27 ppm per hPa: Edlen)."""

import numpy as np

from postproc.effects import State

PARAMETERS = {
    "ppm_K": "um/(m K), reading over beam length and the air's temperature",
}
PLAUSIBLE = {"ppm_K": (-3.0, 3.0)}  # beyond, it is something else
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = ("time", "T_air_C"), ("laser",)
TEXT = (
    "The air along the beam warmed and the laser did not know. "
    "Use the laser's weather station; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    air = state.channels["T_air_C"]
    return ((air - air[0]) * state.beam * 1e-6)[None]


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"ppm_K": float(coefficients[0])}


def coefficients(ppm_K: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([ppm_K]), {}
