"""Scale: an error proportional to the position. A screw or a scale of the wrong length, or a wrong
factor in the control.

ISO 230-2: the slope of the positioning deviation.
"""

import numpy as np

from postproc.effects import State, Table, along, one_way
from postproc.effects._named import by_name

PARAMETERS = {"ppm": "um/m, how much too long the travel is per length"}
# Rolled trapezoidal screws, the worst, are sold with 0.3 mm on 300 mm (unverified: makers'
# catalogues); 30 K of a screw of steel are 345 ppm. A belt is off by what its pulley is and by its
# tension, 0.1 to 2 % of the steps per mm that a control begins with (unverified: makers' guides to
# the calibration of steps per mm). More is a wrong number of teeth or of the unit.
PLAUSIBLE = {"ppm": (-20000.0, 20000.0)}  # beyond, it is something else
FORM = 0.02  # of a factor the line is exact; what a screw adds is a curve, which has a name
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool", "part")
TEXT = (
    "The axis travels too far or too short in proportion. Correct the pitch factor of the control"
    " or write it into the table; check the temperature of the screw first."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    # ppm times mm is 1e-3 um
    return along(axis, state.position[axis] * 1e-3)


parameters, coefficients = by_name(PARAMETERS, {}, "ppm")


def tables(axis: str, travel: tuple[float, float], ppm: float) -> list[Table]:
    return [one_way(axis, f"E{axis}", travel, 2, lambda p: ppm * p * 1e-3)]
