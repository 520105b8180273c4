"""Lengths without a decimal point that count least increments: what is written out is the same as
with the point, whether the control counts by its nature or by --integers."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from postproc.errors import ProgramError
from tests.expand.plain_lines import LATHE, MILL, text_of

MILLED = (
    "G83 X10. Y20. Z-5. R1. Q2. F100|X30.|G80",
    "G73 X10. Y20. Z-5. R1. Q2. F100|G91 X7. Z-8. R-1.|G90 G80",
    "G68 X5. Y5. R30.|G1 X10. Y0. F100|G2 X20. Y10. R12.|G3 X10. Y0. I3. J-4.|G69",
    "G16|G1 X10. Y30. F100|Y45.|G15",
    "G51 X5. Y5. P2.|G1 X10. F100|G2 X20. Y10. R12.|G50",
    "G1 X10. ,R2. F100|Y10. ,C1.|X0.",
)
TURNED = (
    "G0 X60. Z2.|G90 X50. Z-30. F.2|X45. R-2.",
    "G0 X90. Z2.|G71 U4. R1.|G71 P1 Q2 U1. W.5|N1 G0 X40.|G1 Z-20.|G2 X50. Z-25. R5.|N2 G1 X90.",
    "G0 X60. Z2.|G75 R1.|G75 X50. Z-8. P1000 Q2000 F.1",
    "G0 X0. Z2.|G83 Z-20. R-1. Q4000 F.1|G80",
)
LENGTHS = re.compile(r"(?<=[XYZUWRQIJKC])-?\d*\.\d*")


def without_points(program: str) -> str:
    """Every length as a number of micrometres; G R P of turns and factors stay."""
    blocks = []
    for block in program.split("|"):
        turn = re.search(r"G68.*(R[\d.]+)|G51.*(P[\d.]+)", block)
        kept = next((g for g in turn.groups() if g), "") if turn else ""
        head, tail = (block.removesuffix(kept), kept) if kept else (block, "")
        blocks.append(LENGTHS.sub(lambda m: f"{float(m[0]) * 1000:.0f}", head) + tail)
    return "|".join(blocks)


def numbers(lines: list[str]) -> list[str]:
    """Plain lines, each number as it is worth: lengths that stayed as they were count."""
    worth = lambda m: m[1] + f"{float(m[2]) * (1 if '.' in m[2] else 1e-3):g}"  # noqa: E731
    return [re.sub(r"([XYZUWRQIJK])(-?\d+\.?\d*|-?\.\d+)", worth, line) for line in lines]


@pytest.mark.parametrize("program", MILLED, ids=lambda p: p.split()[0])
@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas"])
def test_mills(dialect, program):
    if dialect == "haas" and ("G16" in program or ",R" in program):
        pytest.skip("a Haas has no such code")
    counted = replace(MILL, integers="least increments", least_increment=dict.fromkeys("XYZ", 1e-3))
    begin = "G0 X0. Y0. Z9.|"
    pointed = text_of(begin + program, dialect, counted)
    assert len(pointed) > 2
    assert numbers(text_of(begin + without_points(program), dialect, counted)) == numbers(pointed)


@pytest.mark.parametrize("program", TURNED, ids=lambda p: p.split()[3].replace("|", "-"))
def test_lathes(program):
    counted = replace(LATHE, integers="least increments")
    pointed = text_of(program, "fanuc-lathe-a", counted)
    assert len(pointed) > 2
    assert numbers(text_of(without_points(program), "fanuc-lathe-a", counted)) == numbers(pointed)


def test_an_angle_without_a_point_is_asked_for():
    """Whether R of G68 counts thousandths there is in no text that was found."""
    with pytest.raises(ProgramError, match=r"R30 has no decimal point"):
        text_of("G0 X0. Y0.|G68 X0. Y0. R30", "haas", MILL)
    assert text_of("G0 X0. Y0.|G68 X0. Y0. R30", "fanuc-mill", MILL)
