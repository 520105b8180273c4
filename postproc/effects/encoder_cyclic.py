"""Cyclic reading error of a sensor: the scale says so, the table does not move so."""

from postproc.effects.cyclic import (
    NEEDS,
    OPTIONAL,
    PARAMETERS,
    coefficients,
    columns,
    fuller,
    parameters,
    sensible,
    shapes,
)

__all__ = [  # the same shape, seen elsewhere
    "NEEDS", "OPTIONAL", "PARAMETERS", "coefficients", "columns", "fuller", "parameters", "sensible", "shapes",
]  # fmt: skip

KIND, USE, PER = "instrument", "recording", "axis"
SEES = ("scale",)
TEXT = (
    "The encoder's signal is periodic in the position. "
    "Clean or adjust the reading head; correct the recording, not the machine."
)
