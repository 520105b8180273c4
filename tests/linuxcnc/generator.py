"""Random programs that LinuxCNC accepts, nearly always: `random_program(rng, kind)`.

Material for a differential fuzz. Numbers have few decimals, so that what is exact in millimetres
stays exact; functions that jump (FIX, MOD, comparisons) are given exact numbers only. Rotations are
left to the hand-written programs.
"""

from __future__ import annotations

import random

from tests.linuxcnc.drawn_arcs import arcs
from tests.linuxcnc.drawn_cycles import cycles
from tests.linuxcnc.drawn_frames import frames
from tests.linuxcnc.drawn_owords import owords
from tests.linuxcnc.drawn_words import TOOLS

PARAMETERS = {
    5161: 5.0,
    5163: 60.0,
    5182: -7.5,
    5221: 10.0,
    5222: 20.0,
    5223: 30.0,
    5241: -100.0,
    5242: 50.5,
    5263: 7.0,
}
KEYWORDS = {"tools": TOOLS, "parameters": PARAMETERS}  # what these programs need beside their text


def random_program(rng: random.Random, kind: str) -> str:
    """A program of 20 to 40 blocks or a little more; kind is one of KINDS."""
    return "\n".join((f"({kind})", *KINDS[kind](rng, rng.randint(20, 40)), "M2", ""))


KINDS = {"frames": frames, "cycles": cycles, "arcs": arcs, "owords": owords}
