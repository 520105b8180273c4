"""Inertia: an error proportional to the acceleration, of a drive or a structure that gives."""

import numpy as np

from postproc.effects import State, along, by_name

PARAMETERS = {"um_per_mm_s2": "um per mm/s2, deflection for an acceleration"}
# 1 over the square of the lowest mode: 0.25 um at 10 Hz, 1 at 5 Hz; of a drive without feed-forward
# 1 over its position and
# velocity gains: 2 um at 10 and 50 per s, which is a slow one.
PLAUSIBLE = {"um_per_mm_s2": (-2.0, 2.0)}  # beyond, it is something else
EXPECTED = {"um_per_mm_s2": -1}
ODD = 0.05  # a slide that leads its drive is seldom
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("acceleration",), ("tool", "scale")
TEXT = (
    "The axis gives way when it is accelerated. Acceleration feed-forward, less jerk; a program can"
    " not correct it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    return along(axis, state.acceleration[axis])


parameters, coefficients = by_name(PARAMETERS, {}, "um_per_mm_s2")
