"""Drilling cycles of LinuxCNC written out: the motions of its own interpreter, to 1e-9 mm,
and what it refuses or moves wrongly refused with the reason."""

from __future__ import annotations

import random

import pytest

from postproc.errors import ProgramError
from tests.expand.plain_lines import expand, needs_oracle, program_of, same_motions
from tests.linuxcnc import oracle

HOLES = [
    "G81 X1 Y1 Z-3 R1|X2|G98 X3|G0 Z7|G81 X4 Z-3 R1|X5|G99 X6|G98 X7",
    "G98 G81 X1 Z-3 R1|G81 X2 Z-3 R6|X3|X4 R2",
    "G91 G98 G81 X1 Z-3 R-2 L3|X2",
    "G91 G99 G81 X1 Z-3 R-2 L3|X2",
    "G91 G98 G81 X1 Z-3 R2 L2|X2",
    "G98 G82 X1 Z-3 R1 P.5|X2|G83 X3 Z-3 R1 Q1.5|G73 X4 Z-3 R1 Q1.5|Q2 X5",
    "G98|G85 X1 Z-3 R1|G86 X1 Z-3 R1 P1|G89 X4 Z-3 R1 P2",
    "M4|G98 G86 X1 Z-3 R1 P1|X2 P.2",
    "G98|G84 X1 Z-3 R1|X3 Y3|G91 X2",
    "M4|G74 X1 Z-3 R1|X3",
    "G98|G81 X1 Z-3 R1|Z-5|X2 L2|M8|F40|X4",
    "G18 G81 X1 Z3 Y-3 R1|X2",
    "G18 G98 G0 Y4|G83 X1 Z3 Y-3 R1 Q.9|G91 X2 L2",
    "G19 G81 X-1 Z3 Y3 R1|Y4",
    "G19 G99 G73 X-1 Z3 Y3 R4 Q.7|Y4 L2",
    "G20 G98|G0 X2|G73 X1 Z-.3 R.1 Q.15|G83 X1 Z-.3 R.1 Q.15",
    "G98 G81 X1 Z-3 R1|G99 X2|G80|G98 G81 X3 Z-3 R1",
    "G98 G81 X1 Z-3 R1|G99 X2|G4 P1|G98 X3",
    "G98 G81 X1 Z-3 R1|G99 X2|G0|G98 G81 X3 Z-3 R1",
    "G98 G81 X1 Z-3 R1|G99 X2|G18|G98 X3",
    "G98 G81 X1 Z-3 R1|G99 X2|G20|G98 X.1",
    "G98 G81 X1 Z-3 R1|G99 X2|G91|G98 X3",
    "G98 G81 X1 Z-3 R1|G99 X2|G53 G0 Z3|G98 G81 X3 Z-3 R1",
    (
        "G98 G81 X1 Z-3 R1|G99 X2|G53 G0 Z0|G98 G81 X3 Z-3 R1|G99 X2 R2|R3 X3|G98 R4 X4|R2 X5|G91"
        " R1 X5|G99 R-2 X5|G98 X3"
    ),
    (
        "G98 G81 X1 Z-3 R1|G99 X2|R3 X3|G98 R4 X4|R2 X5|G91 R1 X5|G99 R-2 X5|R-1 Y3|G98 X3|G90 R7"
        " X3|G99 R3 X4|R8 X4|R5 X2"
    ),
    "G7 G19 G81 X-2 R12 Z1",
    "G7 G98 G19 G91 G81 X-2 R-2 Z1",
    "G7 G19 G98 G83 X-2 R12 Z1 Q1.5",
    "G7 G19 G98 G73 X-2 R12 Z1 Q1.5",
    "G7 G81 X12 R2 Z-1|X14",
    "G91 G98 G73 X2 R-2 Z-3 Q1 L2",
    "G91 G99 G82 X2 R-2 Z-3 P1 L2",
    "G91 G99 G83 X2 R-2 Z-3.2 Q1.1 L2|X1",
    "G90 G98 G83 X2 R2 Z-3.2 Q1.1 L2|X1",
    "G98 G81 X2 R2 Z-3|R4 X3|Z-4",
    "G98 G81 X2 R2 Z-3|G91 X3|Z-4 X1|R-1 X1|G90 X0",
    "G98 G91 G81 X2 R-2 Z-3|X3|Z-4 X1|R-1 X1|G90 X0",
    "G81 G80 X1 Z-1 R0",
    "G81 X1 Z-1 R0|G1 X5|X6 Z2",
    "G98 G83 X1 Y0 Z0 R1 Q.1",
    "G20 G98 G83 X.1 Y0 Z0 R.1 Q.01",
    "G8 1 X 1 Z - 1 R 2|g81x2z-1r2|G081 X3|G81. X4",
    "/G81 X1 Z-1 R2|/X4",
    "N5 G81 X1 Z-1 R2 F200 S300 M8 (a hole)|N6 X2 (another)",
    "G98 G81 X1 Z-1 R2|G10 L2 P1 Z2|X4",
    "G98 G81 X1 Z-1 R2|G92 Z3|X4 R2 Z-1",
    "G98 G81 X1 Z-3 R1|G92 Z0|X4 R2 Z-1|G99 X2|G98 X2|G92 Z2|X3|G92 Z-2|X3",
    "G98 G81 X1 Z-1 R2|G55|X4",
    "G10 L2 P2 X3 Z1|G55 G98 G81 X1 Z-1 R2|X4",
    "G20 G98 G81 X1 Z-1 R2|X4",
    "G91 G20 G98 G81 X1 Z-1 R-.02|X4",
]


@pytest.fixture(scope="module")
def holes():
    if oracle.available():
        pytest.skip(oracle.available())
    return dict(
        zip(HOLES, oracle.motions_of_many([(program_of(h), {}) for h in HOLES]), strict=True)
    )


def test_there_are_enough_programs():
    assert len(HOLES) >= 40


@pytest.mark.parametrize("program", HOLES)
def test_holes_are_those_of_linuxcnc(program, holes):
    assert isinstance(holes[program], list), holes[program]
    same_motions(program_of(program), holes[program])


def _random_holes(draw: random.Random) -> str:
    """A program of holes in all modes; LinuxCNC moves wrongly in G84 outside the XY plane, so that
    is left out."""
    lines = [
        "F100",
        "M3 S100",
        draw.choice(["G0 X5 Z5", "G0 X-3 Y2 Z9 G98", "G20 G0 Z1", "G0 Z5 G18", "G7 G0 X20 Z5"]),
    ]
    flat = "G18" not in lines[2]
    modes = [
        "G98",
        "G99",
        "G91",
        "G90",
        "G80",
        "G0 Z4",
        "G4 P1",
        "G20",
        "G21",
        "M8",
        "G92 Z1",
        "G92.1",
        "G55",
        "G54",
    ]
    for _ in range(draw.randint(2, 7)):
        if draw.random() < 0.3:
            lines.append(draw.choice(modes + modes[:4]))
        words = [f"{x}{draw.uniform(-5, 5):.2f}" for x in "XYZ" if draw.random() < 0.5] or ["X1"]
        if draw.random() < 0.4:
            cycles = ["73 Q1.3", "81", "82 P.1", "83 Q.7", "85", "86 P.2", "89 P.3"] + ["84"] * flat
            words = ["G" + draw.choice(cycles), *(f"{x}{draw.uniform(-5, 1):.2f}" for x in "XYZ")]
            words.append(f"R{draw.uniform(1, 7):.1f}")
        elif draw.random() < 0.3:
            words.append(f"R{draw.uniform(-2, 7):.1f}")
        if draw.random() < 0.2:
            words.append(f"L{draw.randint(1, 3)}")
        lines.append(
            " ".join(
                ([draw.choice(["G98", "G99", "G90", "G91"])] if draw.random() < 0.2 else []) + words
            )
        )
    return "\n".join([*lines, "M2", ""])


@needs_oracle()
def test_random_holes_are_those_of_linuxcnc():
    draw = random.Random(5)
    programs = [_random_holes(draw) for _ in range(250)]
    compared = 0
    for text, theirs in zip(
        programs, oracle.motions_of_many([(text, {}) for text in programs]), strict=True
    ):
        if isinstance(theirs, list):
            same_motions(text, theirs)
            compared += 1
    assert compared >= 60


REFUSED = {
    "G81 G82 X1 Z-3 R1 P1": "G81 and G82 in one block",
    "G81 X1 Z-3 R1|R3": "R in a block within G81",
    "G81 X1 Z-3 R1|A4": "A in a block within G81",
    "G81 X1 Z3 R1": "below the bottom",
    "G81 X1 R1": "without Z",
    "G81 Z1 X1": "without R",
    "G83 X1 Z-1 R2": "without Q",
    "G82 X1 Z-1 R2": "without P",
    "G81 X1 Z-1 R2 A4": "A in a drilling cycle",
    "G81 X1 Z-1 R2 L0": "no number of holes",
    "G81 X1 Z-1 R2 L1.5": "no number of holes",
    "G81 X1 Z-1 R2|G81": "without X, Y or Z",
    "G83 X1 Z-1 R2 Q-1": "no peck",
    "G83 X1 Z-1 R2 Q.00001": "pecks",
    "G82 X1 Z-1 R2 P-1": "dwell",
    "G93 G81 X1 Z-1 R2 F10": "inverse time",
    "M5|G86 X1 Z-1 R2 P1": "does not turn",
    "G87 X1 Z-1 R1 I1 J1 K1": "undefined",
    "G88 X1 Z-1 R1 P1": "undefined",
    "G81 X1 Z-1 R2|G82 X2 P1": "without R and Z",
    "G28 G81 X1 Z-1 R2": "in one block",
}


@pytest.mark.parametrize("program", REFUSED)
def test_what_is_no_hole_is_refused_with_the_reason(program):
    with pytest.raises(ProgramError, match=REFUSED[program]) as caught:
        expand(program_of(program))
    assert caught.value.advice and caught.value.place.line >= 4
