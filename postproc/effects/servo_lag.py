"""Servo lag: a following error proportional to the speed, v times the time by which the axis
lags.

A position loop without feed-forward is a first-order element: the error comes and goes with the
loop's time constant, 1 over its gain, which in steady motion is the lag itself; feed-forward of the
velocity takes of the lag, not of the time constant (Altintas, Manufacturing Automation, 2012, on
the control of feed drives).
"""

import numpy as np

from postproc.effects import State, along, followed, settling
from postproc.effects._named import by_name

PARAMETERS = {
    "tau_ms": "ms, lag behind the command in steady motion, as a time",
    "settle_ms": "ms, time constant with which the lag comes and goes; 0: at once",
}
OPTIONAL = {"settle_ms": 0.0}
# 1 over the position gain: 60 ms at 1 m/min per mm, 200 ms at 0.3, as slow as drives ever were; and
# filters of the command.
PLAUSIBLE = {"tau_ms": (0.0, 250.0)}  # beyond, it is something else (unverified: usual gains)
EXPECTED = {"tau_ms": 1}
CONTINUOUS = {"settle_ms": (0.5, 250.0)}
FORM = 0.05  # a loop of the first order lags so; of the second it differs while it settles
fuller = settling
KIND, USE, PER = "machine", "simulate", "axis"
ALONG = True
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = (
    "The axis lags behind its command in proportion to its speed. "
    "Position gain and velocity feed-forward of the drive; the same for all axes that interpolate."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"settle_ms": 0.0}]


def columns(state: State, axis: str, settle_ms: float = 0.0) -> np.ndarray:
    # ms times mm/s is um; behind: against the speed
    speed = state.velocity[axis]
    return along(axis, -(followed(state, speed, settle_ms * 1e-3) if settle_ms > 0 else speed))


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "tau_ms")
