"""LinuxCNC's turned work offsets written out: the motions of its own interpreter."""

from __future__ import annotations

import random

import pytest

from postproc.errors import ProgramError
from tests.expand.plain_lines import (
    expand,
    needs_oracle,
    same_motions,
)
from tests.linuxcnc import oracle

TURNED = [
    (
        "G10 L2 P1 R30|G0 X1 Y2|X5|Y3|G91 X2|Y1 Z3|G1 X1 Y1|G90 G2 I2 J1|G3 X8 Y3 R40|G91 G2 X2"
        " R4|G90 G81 X3 Y4 R2 Z-3|X5"
    ),
    (
        "G10 L2 P1 X10 Y20 R-17.3|G1 X5|G2 I3|J2 P2|G91.1|G55 G1 X3|G10 L2 P2 R90|X4|Y2|G54 X1|G10"
        " L2 P0 R5|X2|G53 G0 X3"
    ),
    (
        "G0 X3 Y4|G10 L2 P1 R45|Y5|X2|G28.1|X1|G10 L2 P1 X3 Y2|X5|Y1 Z2|G83 X1 R3 Z-1 Q.7|X5|G99"
        " Y2|G91 L2 X1"
    ),
    "G10 L2 P1 R360|G0 X1|G10 L2 P1 R180|X2|Y1|G10 L2 P1|X5|G20 X.1|G21 Y9|G10 L2 P1 R0|X1",
    "G90.1|G10 L2 P1 R30|G0 X5 Y0|G3 X0 Y5 I0 J0|G91.1 G1 X9",
]


@needs_oracle()
@pytest.mark.parametrize("program", TURNED)
def test_turned_work_offsets_are_linuxcncs(program):
    text = f"F100|G1|{program}|M2|".replace("|", "\n")
    same_motions(text, oracle.motions(text))


def _random_turned(draw: random.Random) -> str:
    def number(far: float = 20) -> str:
        return f"{draw.uniform(-far, far):.3f}"

    lines = ["F100", "M3 S100", "G0 X3 Y4 Z5"]
    for _ in range(draw.randint(4, 14)):
        kind = draw.random()
        if kind < 0.15:
            place = draw.choice(["", f"X{number()} Y{number()}", "Z3"])
            lines.append(
                f"G10 L2 P{draw.choice([0, 1, 1, 2])} {place}"
                f" R{draw.choice([0, 90, draw.uniform(-200, 200)]):.2f}"
            )
        elif kind < 0.2:
            lines.append(
                draw.choice(
                    [
                        "G54",
                        "G55",
                        "G90",
                        "G91",
                        "G20",
                        "G21",
                        "G4 P1",
                        "G80",
                        "G98",
                        "G53 G0 X1 Y2",
                    ]
                )
            )
        elif kind < 0.35:
            lines.append(
                f"G{draw.choice([2, 3])} I{number()} J{number()} {draw.choice(['', 'P2', 'Z1'])}"
            )
        elif kind < 0.5:
            cycle = draw.choice(["81", "73 Q1.1", "83 Q1.3", "85"])
            lines.append(
                f"G{cycle} X{number()} Z{draw.uniform(-5, -1):.2f} R{draw.uniform(0, 6):.2f}"
            )
        else:
            words = [x + number() for x in "XYZ" if draw.random() < 0.5]
            lines.append(draw.choice(["", "G0 ", "G1 "]) + " ".join(words))
    return "\n".join([*lines, "M2", ""])


@needs_oracle()
def test_random_programs_in_turned_work_offsets_are_linuxcncs():
    draw = random.Random(3)
    programs = [_random_turned(draw) for _ in range(120)]
    compared = 0
    for text, theirs in zip(
        programs, oracle.motions_of_many([(text, {}) for text in programs]), strict=True
    ):
        if isinstance(theirs, list):
            same_motions(text, theirs)
            compared += 1
    assert compared >= 40


@pytest.mark.parametrize(
    ("program", "why"),
    [
        ("G10 L2 P1 R30|G18 G2 X1 Y1 Z1 I3 K0 P2", "out of its plane, with P"),
        ("G10 L2 P1 R30|G0 X1 Y1|G92 X3", "G92"),
        ("G92 X3|G10 L2 P1 R30|G0 X2 Y1", "G92"), ("G10 L2 P1 R30|G10 L20 P1 X3", "L20"),
        ("G10 L2 P1 R30|G28 X3", "G28"),
    ],
)  # fmt: skip
def test_what_can_not_be_followed_in_a_turned_work_offset_is_refused(program, why):
    with pytest.raises(ProgramError, match=why):
        expand(("G0 X1 Y1|F100|" + program).replace("|", "\n"))
