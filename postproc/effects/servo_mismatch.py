"""Servo mismatch: two axes follow with different lags; a circle becomes an ellipse at 45 degrees
that turns over with the sense (ISO 230-4).
"""

import numpy as np

from postproc.effects import State, along, by_name, followed_speed
from postproc.effects.servo_lag import CONTINUOUS, OPTIONAL, further_cost, shapes

__all__ = ["CONTINUOUS", "OPTIONAL", "further_cost", "shapes"]

PARAMETERS = {
    "delta_tau_ms": "ms, lag of the first axis minus that of the second",
    "settle_ms": "ms, time constant with which they come to be late; 0, at once",
}
# No more than the lag of one of the axes, of which the other has at least half on any machine that
# can go round (unverified).
PLAUSIBLE = {"delta_tau_ms": (-125.0, 125.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "simulate", "pair"
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = "Two axes follow with different lags. Match the position gains of the two drives."


def columns(state: State, axis: str, settle_ms: float = 0.0) -> np.ndarray:
    lag = [-followed_speed(state, x, settle_ms) / 2 for x in axis]
    return along(axis[0], lag[0]) - along(axis[1], lag[1])


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "delta_tau_ms")
