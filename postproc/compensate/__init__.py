"""Motions + machine -> pieces: what to command so that the actual path is the nominal one.

One inverse for the sum of all effects (inverse.py), one rule for the direction of approach
(approach.py), straight motions cut at the nodes of the tables (cut.py), arcs kept where they are
provably within tolerance (fit.py).
"""

from postproc.compensate.compensator import Compensator
from postproc.compensate.settings import Carry, Options
from postproc.pieces import Pieces

__all__ = ["Carry", "Compensator", "Options", "Pieces"]
