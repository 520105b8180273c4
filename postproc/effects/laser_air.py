"""Laser air: the refractive index of the air changed along the beam (0.93 ppm per K, -0.27 ppm per hPa: Edlen)."""

import numpy as np

from postproc.effects import State

PARAMETERS = {
    "ppm_K": "um/(m K), reading over beam length and the air's temperature",
    "from_C": "degrees Celsius, from which it counts; -300, from the first reading",
}
PLAUSIBLE = {"ppm_K": (-30.0, 30.0)}  # beyond, it is something else
OPTIONAL = {"from_C": -300.0}
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = ("time", "T_air_C"), ("laser",)
TEXT = (
    "The air along the beam warmed and the laser did not know. "
    "Use the laser's weather station; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"from_C": -300.0}, {"from_C": 20.0}]


def columns(state: State, axis: str, from_C: float = -300.0) -> np.ndarray:
    air = state.channels["T_air_C"]
    return ((air - (air[0] if from_C < -270 else from_C)) * state.beam * 1e-6)[None]


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"ppm_K": float(coefficients[0]), "from_C": shape["from_C"]}


def coefficients(ppm_K: float, from_C: float = -300.0) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([ppm_K]), {"from_C": from_C}
