"""Dead path: the air between interferometer and zero changed; the same error at every place."""

import numpy as np

from postproc.effects import State

PARAMETERS = {
    "um_K": "um per K, reading over the temperature of the air",
}
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = ("time", "T_air_C"), ("laser",)
TEXT = (
    "The dead path of the laser was not compensated. "
    "Set the interferometer close to the reflector's zero; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    air = state.channels["T_air_C"]
    return ((air - air[0]) * 1e-3)[None]


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"um_K": float(coefficients[0])}


def coefficients(um_K: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([um_K]), {}
