"""Stick-slip: saw-tooth motion at low feed; the slide waits, then jumps.

Where the jumps are too short for the samples only their mean is seen: while the axis creeps it lags
by half a tooth and more.
"""

import numpy as np

from postproc.effects import State, along, by_name, grid

PARAMETERS = {
    "period_mm": "mm, way between two jumps; 0, too short to be told apart",
    "size_um": "um, how far it lags before it jumps",
    "fastest_mm_s": "mm/s, speed above which it slides evenly; 0, none",
}
OPTIONAL = {"fastest_mm_s": 0.0}
EXPECTED = {"size_um": 1}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("distance", "velocity", "approach"), ("tool", "scale")
TEXT = (
    "The slide sticks and jumps at low feed. "
    "Lubrication, guideway material, a higher feed; a program can not correct it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    long = [{"period_mm": v, "fastest_mm_s": 0.0} for v in grid(0.02, 2.0, 12)]
    speed = np.abs(state.velocity[axis])
    slow = [
        v
        for v in grid(0.5, 6.0, 8)
        if np.any(speed > 1.5 * v) and np.count_nonzero((speed > 0) & (speed < v)) > 8
    ]
    return long + [{"period_mm": 0.0, "fastest_mm_s": v} for v in slow]


def columns(state: State, axis: str, period_mm: float, fastest_mm_s: float = 0.0) -> np.ndarray:
    speed = np.abs(state.velocity[axis])
    moves = speed > 0
    if fastest_mm_s > 0:
        moves &= speed < fastest_mm_s
    phase = (state.distance[axis] / period_mm) % 1.0 - 0.5 if period_mm > 0 else 0.5
    return along(axis, -state.approach[axis] * moves * phase)


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "size_um")
