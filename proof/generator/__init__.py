"""Concealed cases for `gcomp diagnose`, made by physics that shares no equation with the tool.

A case is a folder as a user would hand it in: the map of the machine that the user has, and
recordings. What was hidden in it stands in a truth file outside. Nothing here imports the tool
(tests/proof checks that); effects are known to both sides by their names in the contract of answers
only.

The order of drawing is what keeps the cases sealed: machine and experiments come first, from a
stream that knows neither kind of case nor effect, so that rows, columns, heads and channels can not
tell what follows. See `cases.make`.
"""

from proof.generator.cases import KINDS, Case, make

__all__ = ["KINDS", "Case", "make"]
