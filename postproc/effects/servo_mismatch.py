"""Servo mismatch: two axes follow with different lags; a circle becomes an ellipse at 45 degrees
that turns over with the sense (ISO 230-4).
"""

import numpy as np

from postproc.effects import State, along, by_name

PARAMETERS = {"delta_tau_ms": "ms, lag of the first axis minus that of the second"}
# No more than the lag of one of the axes, of which the other has at least half on any machine that
# can go round (unverified).
PLAUSIBLE = {"delta_tau_ms": (-125.0, 125.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "simulate", "pair"
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = "Two axes follow with different lags. Match the position gains of the two drives."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    first, second = axis[0], axis[1]
    return along(first, -state.velocity[first] / 2) - along(second, -state.velocity[second] / 2)


parameters, coefficients = by_name(PARAMETERS, {}, "delta_tau_ms")
