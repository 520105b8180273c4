"""Recordings of inaccurate machines, simulated from textbooks: 34 effects in 87 forms, 12 aliens,
24 tests by ISO 230-1, -2, -3, -4 and -6.

Written from the contracts of machine, recording and answer alone, by somebody who had not read the
tool; it shares no code with the tool, nor with the other generators of `proof`. A case follows from
a seed, a tier and a number; see `tiers.make`.
"""

from .tiers import TIERS, Made, make

__all__ = ["TIERS", "Made", "make"]
