"""Cyclic reading error of a sensor: the scale says so, the table does not move so."""

from postproc.effects.cyclic import NEEDS, PARAMETERS, coefficients, columns, parameters, shapes

__all__ = ["NEEDS", "PARAMETERS", "coefficients", "columns", "parameters", "shapes"]  # the same shape, seen elsewhere

KIND, USE, PER = "instrument", "recording", "axis"
SEES = ("scale",)
TEXT = (
    "The encoder's signal is periodic in the position. "
    "Clean or adjust the reading head; correct the recording, not the machine."
)
