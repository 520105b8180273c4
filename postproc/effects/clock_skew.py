"""Clock skew: the clock of the recording runs faster or slower than the control's; it comes to be
late, in all axes alike."""

import numpy as np

from postproc.effects import State, along, by_name

PARAMETERS = {
    "ppm": "us per s, how much slower the recording's clock runs",
    "whole": "1, the clocks were set alike at the start of the experiment; 0, of each recording",
}
OPTIONAL = {"whole": 0.0}
# Quartzes differ by 100 ppm, clocks of software by a few hundred (unverified).
PLAUSIBLE = {"ppm": (-1000.0, 1000.0)}  # beyond, it is something else
KIND, USE, PER = "data", "recording", "all"
NEEDS, SEES = ("velocity", "time"), ("scale", "trace")
TEXT = (
    "The two clocks do not run alike. Align the recording with reversals at its start and its end;"
    " correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"whole": 0.0}, {"whole": 1.0}] if len(np.unique(state.file)) > 1 else [{"whole": 0.0}]


def columns(state: State, axis: str, whole: float = 0.0) -> np.ndarray:
    late = state.time * 1e-3
    for file in () if whole else np.unique(state.file):
        own = state.file == file
        late = np.where(own, (state.time - state.time[own].min()) * 1e-3, late)
    return sum(
        (along(x, -v * late) for x, v in state.velocity.items()), np.zeros((1, 3, len(state)))
    )


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "ppm")
