"""Laser air: the refractive index of the air changed along the beam (0.93 ppm per K, -0.27 ppm per hPa: Edlen)."""

import numpy as np

from postproc.effects import State

PARAMETERS = {
    "ppm_K": "um/(m K), reading over beam length and the air's temperature since the recording's first reading",
    "wrong_ppm": "um/m, by how much the air that the laser was told of is wrong from the first reading on",
    "told": "1, the laser was told of other air; 0, it was not",
}
PLAUSIBLE = {"ppm_K": (-30.0, 30.0), "wrong_ppm": (-150.0, 150.0)}  # beyond, it is something else
OPTIONAL = {"told": 0.0, "wrong_ppm": 0.0}
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = ("time", "T_air_C"), ("laser",)
TEXT = (
    "The air along the beam warmed and the laser did not know. "
    "Use the laser's weather station; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"told": 0.0}, {"told": 1.0}]


def columns(state: State, axis: str, told: float = 0.0) -> np.ndarray:
    air = state.channels["T_air_C"]
    warmer = np.zeros(len(air))
    for file in np.unique(state.file):
        own = np.flatnonzero(state.file == file)
        warmer[own] = air[own] - air[own[np.argmin(state.time[own])]]
    grown = warmer * state.beam * 1e-6
    return np.stack([grown, state.beam * 1e-6]) if told else grown[None]


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    wrong = float(coefficients[1]) if len(coefficients) > 1 else 0.0
    return {"ppm_K": float(coefficients[0]), "wrong_ppm": wrong, "told": shape["told"]}


def coefficients(ppm_K: float, wrong_ppm: float = 0.0, told: float = 0.0) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([ppm_K, wrong_ppm] if told else [ppm_K]), {"told": told}
