"""Viscous friction: an error that grows with the speed, of a drive that gives under the grease's
resistance.

In proportion to the speed it is no other than a servo lag. Lubricated guideways and ball screws
resist with a power of it below one (Bo and Pavelescu, The friction-speed relation and its influence
on the critical velocity of stick-slip motion, Wear 82, 1982, 277; Armstrong-Helouvry et al.,
Automatica 30, 1994, 1083), which a lag never does.
"""

import numpy as np

from postproc.effects import State, along, followed
from postproc.effects._named import by_name

PARAMETERS = {
    "um_s_mm": "um per mm/s, deflection for a speed; with a power below 1 at 10 mm/s",
    "power": "1, of the speed that the friction goes with; below 1 for a film of grease",
    "settle_ms": "ms, time constant with which the drive gives and comes back",
}
OPTIONAL = {"power": 1.0, "settle_ms": 0.0}
# It is a lag too, see servo_lag: um per mm/s are ms.
PLAUSIBLE = {"um_s_mm": (-250.0, 250.0)}  # beyond, it is something else
EXPECTED = {"um_s_mm": 1}
USUAL = 10.0  # mm/s
POWERS = (1.0, 0.8, 0.65, 0.5)
CONTINUOUS = {"power": (0.4, 0.9), "settle_ms": (0.5, 250.0)}
KIND, USE, PER = "machine", "simulate", "axis"
ALONG = True
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = (
    "Friction grows with the speed and bends the drive. "
    "Lubrication and preload; feed-forward of the velocity in the drive."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"power": v, "settle_ms": 0.0} for v in POWERS]


def columns(state: State, axis: str, power: float = 1.0, settle_ms: float = 0.0) -> np.ndarray:
    v = state.velocity[axis]
    # of a speed of USUAL as a lag has it, so that the size is comparable whatever the power
    friction = np.sign(v) * USUAL * (np.abs(v) / USUAL) ** power
    return along(axis, -(followed(state, friction, settle_ms * 1e-3) if settle_ms else friction))


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "um_s_mm")
