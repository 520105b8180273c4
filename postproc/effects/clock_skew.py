"""Clock skew: the clock of the recording runs faster or slower than the control's; it comes to be late, in all axes alike."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "ppm": "us per s, how much slower the recording's clock runs",
}
# Quartzes differ by 100 ppm, clocks of software by a few hundred (unverified).
PLAUSIBLE = {"ppm": (-1000.0, 1000.0)}  # beyond, it is something else
KIND, USE, PER = "data", "recording", "all"
NEEDS, SEES = ("velocity", "time"), ("scale", "trace")
TEXT = "The two clocks do not run alike. Align the recording with reversals at its start and its end; correct the recording, not the machine."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    late = np.zeros(len(state))
    for file in np.unique(state.file):
        own = state.file == file
        late[own] = (state.time[own] - state.time[own].min()) * 1e-3
    return sum((along(x, -v * late) for x, v in state.velocity.items()), np.zeros((1, 3, len(state))))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"ppm": float(coefficients[0])}


def coefficients(ppm: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([ppm]), {}
