"""Servo lag: a following error proportional to the speed, v times the time by which the axis is
late."""

import numpy as np

from postproc.effects import State, along, by_name

PARAMETERS = {"tau_ms": "ms, how late the axis is"}
# 1 over the position gain: 60 ms at 1 m/min per mm, 200 ms at 0.3, as slow as drives ever were; and
# filters of the command.
PLAUSIBLE = {"tau_ms": (0.0, 250.0)}  # beyond, it is something else (unverified: usual gains)
EXPECTED = {"tau_ms": 1}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = (
    "The axis follows late in proportion to its speed. "
    "Position gain and velocity feed-forward of the drive; the same for all axes that interpolate."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    return along(axis, -state.velocity[axis])


parameters, coefficients = by_name(PARAMETERS, {}, "tau_ms")
