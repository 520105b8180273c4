"""Cyclic reading error of a sensor: the scale says so, the table does not move so.

A loop that is closed on such a scale follows it: then the table moves so, the other way round, and
the scale shows nothing. What an instrument at the tool sees of that is `cyclic`, of the machine,
and a program can correct it. What is left in the scale's own reading the loop does not follow (a
motor's encoder controls, or the period goes by too fast), and the table does not move by that part.
No recording and no machine's file says on which sensor the loop is closed, so one never stands for
the other: this is seen in the scale's signal alone, and where there is none it is never named. A
loop that follows half-way shows both, of one period.
"""

from postproc.effects import State
from postproc.effects.cyclic import (
    CONTINUOUS,
    NEEDS,
    OPTIONAL,
    PARAMETERS,
    PLAIN,
    coefficients,
    columns,
    fuller,
    parameters,
    sensible,
)

__all__ = [  # the same shape, seen elsewhere
    "CONTINUOUS",
    "NEEDS",
    "OPTIONAL",
    "PARAMETERS",
    "PLAIN",
    "coefficients",
    "columns",
    "fuller",
    "parameters",
    "sensible",
]

# Of a signal's period an unadjusted head is wrong by a few hundredths: of 2 mm, the longest, 100 um
# (unverified).
PLAUSIBLE = {"amplitude_um": (0.0, 100.0)}  # beyond, it is something else
KIND, USE, PER = "instrument", "recording", "axis"
ALONG = True
SEES = ("scale",)
TEXT = (
    "The encoder's signal is periodic in the position. "
    "Clean or adjust the reading head; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return []  # found from the spectrum of what is left, see diagnose
