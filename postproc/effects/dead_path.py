"""Dead path: the air between interferometer and zero changed; the same error at every place."""

import numpy as np

from postproc.effects import State

PARAMETERS = {
    "um_K": "um per K, reading over the temperature of the air",
    "file": "number of the recording, 0 the first; -1: all",
}
OPTIONAL = {"file": -1.0}
# 0.93 ppm/K of air (Edlen), and 10 m of it.
PLAUSIBLE = {"um_K": (-10.0, 10.0)}  # beyond, it is something else
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = ("time", "T_air_C"), ("laser",)
TEXT = (
    "The dead path of the laser was not compensated. "
    "Set the interferometer close to the reflector's zero; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"file": float(f)} for f in np.unique(state.file[state.beam > 0])]


def columns(state: State, axis: str, file: float = -1.0) -> np.ndarray:
    air = state.channels["T_air_C"]
    own = (state.file == file) | (file < 0)
    return ((air - air[0]) * own * 1e-3)[None]


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"um_K": float(coefficients[0]), "file": shape["file"]}


def coefficients(um_K: float, file: float = -1.0) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([um_K]), {"file": file}
