"""Servo lag: a following error proportional to the speed, v times the time by which the axis is
late."""

import numpy as np

from postproc.effects import State, along, by_name, followed_speed

PARAMETERS = {
    "tau_ms": "ms, how late the axis is",
    "settle_ms": "ms, time constant with which it comes to be late; 0, at once",
}
OPTIONAL = {"settle_ms": 0.0}
SETTLES = (5.0, 15.0, 45.0)  # ms
CONTINUOUS = {"settle_ms": (2.0, 150.0)}
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
    return [{"settle_ms": v} for v in (0.0, *SETTLES)]


def further_cost(axis: str, shape: dict[str, float]) -> float:
    """That it is late at once is as usual as all of it."""
    return 0.0 if shape.get("settle_ms") else -2 * float(np.log(1 + len(SETTLES)))


def columns(state: State, axis: str, settle_ms: float = 0.0) -> np.ndarray:
    return along(axis, -followed_speed(state, axis, settle_ms))


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "tau_ms")
