"""Reversal spike: a short excursion after an axis turns back (stiction, the quadrant glitch of a
circular test, ISO 230-4)."""

import numpy as np

from postproc.effects import State, along, by_name, grid

PARAMETERS = {
    "size_um": "um, height of the excursion",
    "slope_um": "um, its share that rises first",
    "tau_ms": "ms, how long it lasts",
    "rebounds": "1, the loop overshoots and swings once or twice; 0, it does not",
}
OPTIONAL = {"rebounds": 0.0}
# turns in the time that it lasts: damped by 0.4 of the critical damping, as position loops are set
SWINGS = 1 / 3
CONTINUOUS = {"tau_ms": (4.0, 600.0)}
PLAUSIBLE = {"size_um": (-500.0, 500.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("since", "approach", "velocity"), ("tool", "scale")
TEXT = (
    "The axis sticks when it turns back and lets go late. "
    "Friction compensation in the drive, guideway lubrication; a program can not correct it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"tau_ms": v, "rebounds": r} for r in (0.0, 1.0) for v in grid(6.0, 400.0, 9)]


def columns(state: State, axis: str, tau_ms: float, rebounds: float = 0.0) -> np.ndarray:
    q = np.minimum(state.since[axis] / (tau_ms * 1e-3), 50.0)
    fade = np.where(state.velocity[axis] != 0, np.exp(-q), 0.0) * state.approach[axis]
    if rebounds:
        angle = 2 * np.pi * SWINGS * q
        return along(axis, -fade * np.cos(angle), -fade * np.sin(angle))
    return along(axis, -fade, -q * fade)


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "size_um", "slope_um")
