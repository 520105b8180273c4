"""Sentences of Fadal's subroutines and repeated blocks."""

from __future__ import annotations

from tests.advice.follow import WRITE, Case

NONE = {"offsets": {"E1": {}, "H1": {}}}
MAIN = "M30|G90 G0 E1 X0. Y0. Z5.|"
DRILL = "G81 X0. Y0. Z-5. R2. F90. L0|L101|G80"


def fadal(before: str, after: str, first=None) -> Case:
    return Case("fadal", before, after, first=first or {}, how={**WRITE, **NONE})


SUB = "L100|X5. Y5.|X9. Y5.|M17|"
ALL = [
    fadal(SUB + SUB + MAIN + DRILL, SUB + MAIN + DRILL),
    fadal("L100|X5. Y5.|" + MAIN + DRILL, SUB + MAIN + DRILL),
    fadal(SUB + "G90 G0 E1 X0. Y0. Z5.|" + DRILL, SUB + MAIN + DRILL),
    fadal(SUB + MAIN + "L201", SUB + MAIN + "X9."),
    fadal("L100|L101|M17|" + MAIN + "L101", SUB + MAIN + "G1 F90.|L101"),
    fadal(SUB + MAIN + "G1 F90.|L102", SUB + MAIN + "G1 F90.|L102", first={"steps": 5}),
    fadal(MAIN[4:] + "G91 X1. L3", MAIN[4:] + "G91 X1.|X1.|X1."),
]
