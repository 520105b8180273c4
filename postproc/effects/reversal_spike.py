"""Reversal spike: a short excursion after an axis turns back (stiction, the quadrant glitch of a
circular test, ISO 230-4).

It lasts as long as the loop takes to push the slide on, or over the way in which friction builds
up (pre-sliding: Armstrong-Helouvry, Dupont, Canudas de Wit, A survey of models, analysis tools and
compensation methods for the control of machines with friction, Automatica 30, 1994, 1083). Where
both count, the friction, which turns round over a way, is what the integral action of the loop
takes back in a time: at a higher feed the spike is higher.
"""

import numpy as np

from postproc.effects import State, along, followed, grid, sampled
from postproc.effects._named import by_name

PARAMETERS = {
    "size_um": "um, height of the excursion",
    "slope_um": "um, its share that rises first",
    "tau_ms": "ms, how long it lasts; 0, it lasts over a way",
    "rebounds": "1, the loop overshoots and oscillates once or twice; 0, it does not",
    "length_mm": "mm, over which way friction builds up; alone, at any speed; 0, at the turn",
}
OPTIONAL = {"rebounds": 0.0, "length_mm": 0.0}
# turns in the time that it lasts: damped by 0.4 of the critical damping, as position loops are set
SWINGS = 1 / 3
CONTINUOUS = {"tau_ms": (4.0, 600.0), "length_mm": (0.01, 4.0)}
BUILT_UP = (0.01, 0.05, 0.25)  # mm: over which way friction turns round while the loop acts
TIMES = (10.0, 30.0, 100.0)  # ms: over which the loop makes up for it
FADED = 10.0  # lengths after which nothing is left
PLAUSIBLE = {"size_um": (-500.0, 500.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "simulate", "axis"
ALONG = True
NEEDS, SEES = ("since", "approach", "velocity"), ("tool", "scale")
TEXT = (
    "The axis sticks when it turns back and lets go late. "
    "Friction compensation in the drive, guideway lubrication; a program can not correct it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    plain = {"rebounds": 0.0, "length_mm": 0.0}
    times = [plain | {"tau_ms": v, "rebounds": r} for r in (0.0, 1.0) for v in grid(6.0, 400.0, 9)]
    return times + [plain | {"tau_ms": 0.0, "length_mm": v} for v in ways(state, axis)]


def ways(state: State, axis: str) -> list[float]:
    """mm: over which it may last, where some reading stands near enough to a turn to show it."""
    near = float(np.min(state.distance.get(axis, np.inf), initial=np.inf))
    return [v for v in grid(0.02, 2.0, 9) if near < FADED * v]


def fuller(shape: dict[str, float], state: State, axis: str) -> list[dict[str, float]]:
    """The same of friction that builds up over a way, in a loop."""
    if shape["rebounds"] or not np.any(sampled(state)):
        return []
    if shape["tau_ms"] > 0:
        return [shape | {"length_mm": v} for v in BUILT_UP]
    return [shape | {"tau_ms": v} for v in TIMES]


def of_loop(
    state: State, axis: str, tau_ms: float, length_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) what a loop leaves of a friction of 1 that turns round over a way, and the same as it
    rises when the loop is of the second order."""
    # friction turns round over the way, from -1/2 of its new side to +1/2
    turned = -np.expm1(-np.minimum(state.distance[axis] / length_mm, 50.0)) - 0.5
    friction = state.approach[axis] * turned
    left = friction - followed(state, friction, tau_ms * 1e-3)
    return left, followed(state, left, tau_ms * 1e-3)


def columns(
    state: State, axis: str, tau_ms: float, rebounds: float = 0.0, length_mm: float = 0.0
) -> np.ndarray:
    if length_mm > 0 and tau_ms > 0:
        left, second_order = of_loop(state, axis, tau_ms, length_mm)
        return along(axis, -left, -second_order)
    if length_mm > 0:
        q = np.minimum(state.distance[axis] / length_mm, 50.0)
        fade = np.exp(-q) * state.approach[axis]
        return along(axis, -fade, -q * fade)
    #    off ^          .             -(size + slope q) exp(-q), q = time since the turn / tau: a
    #        |         : '.           jump that fades (size), and one that rises first (slope);
    #        +---------:----'---> t   against the new direction, since it sticks
    #                 turn
    q = np.minimum(state.since[axis] / (tau_ms * 1e-3), 50.0)
    fade = np.where(state.velocity[axis] != 0, np.exp(-q), 0.0) * state.approach[axis]
    if rebounds:
        angle = 2 * np.pi * SWINGS * q
        return along(axis, -fade * np.cos(angle), -fade * np.sin(angle))
    return along(axis, -fade, -q * fade)


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "size_um", "slope_um")
