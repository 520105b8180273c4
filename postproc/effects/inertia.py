"""Inertia: an error proportional to the acceleration, of a drive or a structure that gives.

Of a drive whose velocity is fed forward it is the time constant of the velocity loop over the gain
of the position loop, and goes with the time constant of the latter.
"""

import numpy as np

from postproc.effects import State, along, followed, settling
from postproc.effects._named import by_name

PARAMETERS = {
    "um_per_mm_s2": "um per mm/s2, deflection for an acceleration",
    "settle_ms": "ms, time constant with which it comes and goes; 0: at once",
}
OPTIONAL = {"settle_ms": 0.0}
CONTINUOUS = {"settle_ms": (0.5, 250.0)}
# 1 over the square of the lowest mode: 0.25 um at 10 Hz, 1 at 5 Hz; of a drive without feed-forward
# 1 over its position and
# velocity gains: 2 um at 10 and 50 per s, which is a slow one.
PLAUSIBLE = {"um_per_mm_s2": (-2.0, 2.0)}  # beyond, it is something else
EXPECTED = {"um_per_mm_s2": -1}
fuller = settling
KIND, USE, PER = "machine", "simulate", "axis"
ALONG = True
NEEDS, SEES = ("acceleration",), ("tool", "scale")
TEXT = (
    "The axis gives way when it is accelerated. Acceleration feed-forward, less jerk; a program can"
    " not correct it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"settle_ms": 0.0}]


def columns(state: State, axis: str, settle_ms: float = 0.0) -> np.ndarray:
    if settle_ms <= 0:
        # um per mm/s2, with the sign of the acceleration: what lags has a size below zero
        # (EXPECTED)
        return along(axis, state.acceleration[axis])
    tau, speed = settle_ms * 1e-3, state.velocity[axis]
    # an acceleration through the element is what the speed is ahead of itself through it
    return along(axis, (speed - followed(state, speed, tau)) / tau)


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "um_per_mm_s2")
