"""Structure drift: the whole frame creeps with the room or with time, wherever the slides stand (ISO 230-3)."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "size_um": "um per K, drift over the temperature of bed or room; where none is recorded um at the end",
    "tau_s": "s, 0: by the recorded temperature, else the time in which it comes",
}
PLAUSIBLE = {"size_um": (-100.0, 100.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("time",), ("tool",)
TEXT = (
    "The frame moves with the room's temperature or with time. "
    "A steady room, a warm-up, probing of the zero between cuts."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    known = [{"tau_s": 0.0}] if state.channel("T_bed_C") is not None else []
    known += [{"tau_s": -1.0}] if state.channel("T_air_C") is not None else []
    return known + [{"tau_s": v} for v in (900.0, 2700.0, 8100.0, 1e6)] if len(state.time) else []


def columns(state: State, axis: str, tau_s: float) -> np.ndarray:
    gone = state.time - state.time.min()
    bed, air = state.channel("T_bed_C"), state.channel("T_air_C")
    if tau_s < 0 and air is not None:
        return along(axis, air - air[0])
    if tau_s == 0 and bed is not None:
        return along(axis, bed - bed[0])
    tau = max(tau_s, 1.0)
    return along(axis, (1.0 - np.exp(-gone / tau)) / (1.0 - np.exp(-max(float(gone.max()), 1.0) / tau)))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0]), "tau_s": shape["tau_s"]}


def coefficients(size_um: float, tau_s: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {"tau_s": tau_s}
