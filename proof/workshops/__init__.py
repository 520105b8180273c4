"""Recordings of inaccurate machines, simulated as workshops make them: 34 effects in 90 forms, 12
aliens, 9 harms; tests cold and warm, with coarse gauges, with two instruments, on real contours.

Written from the contracts of machine, recording and answer alone, by the owner of a retrofit shop
and a servo engineer who had not read the tool; it shares no code with the tool, nor with the other
generators of `proof`. A seed and the number of cases of every tier give the cases; see
`tiers.make`.
"""

from .tiers import TIERS, Made, make

__all__ = ["TIERS", "Made", "make"]
