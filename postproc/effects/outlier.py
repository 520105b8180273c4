"""Outlier: one reading that is off by itself: a beam that was touched, a chip under the probe, a
number mistyped."""

import numpy as np

from postproc.effects import State, along
from postproc.effects._named import by_name

PARAMETERS = {"jump_um": "um, by how much the reading is off", "t_s": "s, when it was taken"}
KIND, USE, PER = "data", "recording", "axis"
NEEDS, SEES = ("time",), ("tool",)
LISTED = True
TEXT = (
    "One reading is off and its neighbours are not. It is left out; take it again, and correct the"
    " recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return []  # rows are compared with their neighbours and with the other runs, and listed


def columns(state: State, axis: str, t_s: float) -> np.ndarray:
    off = np.zeros(len(state))
    # the reading taken next to that moment, and no other
    off[np.argmin(np.abs(state.time - t_s))] = 1.0
    return along(axis, off)


parameters, coefficients = by_name(PARAMETERS, {}, "jump_um")
