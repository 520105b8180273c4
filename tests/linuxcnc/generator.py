"""Random programs that LinuxCNC accepts, nearly always: `random_program(rng, kind)`.

Material for a differential fuzz. Numbers have few decimals, so that what is exact in millimetres stays exact; rotations
are left to the hand-written programs.
"""

from __future__ import annotations

import math
import random

from .oracle import SECONDS_PER_BATCH as SECONDS_PER_BATCH

TOOLS = {1: {"Z": 10.0, "D": 6.0}, 2: {"Z": 20.5, "X": 5.0, "D": 8.0}, 3: {"X": 1.0, "Y": -2.0, "Z": 3.25}}
PARAMETERS = {5161: 5.0, 5163: 60.0, 5182: -7.5, 5221: 10.0, 5222: 20.0, 5223: 30.0, 5241: -100.0, 5242: 50.5, 5263: 7.0}
KEYWORDS = {"tools": TOOLS, "parameters": PARAMETERS}  # what the oracle needs beside the text, for every kind
SYSTEMS = ("G54", "G55", "G56", "G59", "G59.1", "G59.3")


def random_program(rng: random.Random, kind: str) -> str:
    """A program of 20 to 40 blocks; kind is one of KINDS."""
    return "\n".join((f"({kind})", *KINDS[kind](rng, rng.randint(20, 40)), "M2", ""))
