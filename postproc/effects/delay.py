"""Delay: the recording is late by the same time in all axes."""

import numpy as np

from postproc.effects import State, along
from postproc.effects._named import by_name

PARAMETERS = {"delay_ms": "ms, delay of the recording"}
PLAUSIBLE = {"delay_ms": (0.0, 5.0)}  # beyond, it is something else
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = ("velocity",), ("scale", "trace")
TEXT = (
    "The recording is delayed, in all axes alike. Align its clock with a reversal; correct the"
    " recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    # ms times mm/s is um: what is read late was read where the axis had not yet come
    return sum((along(x, -v) for x, v in state.velocity.items()), np.zeros((1, 3, len(state))))


parameters, coefficients = by_name(PARAMETERS, {}, "delay_ms")
