"""Lengths without a decimal point that count least increments: what is written out is the same as
with the point, whether the control counts by its nature or by --integers."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.cycles.block import Word
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.expand.plain_lines import LATHE, MILL, text_of

MILLED = (
    "G83 X10. Y20. Z-5. R1. Q2. F100|X30.|G80",
    "G73 X10. Y20. Z-5. R1. Q2. F100|G91 X7. Z-8. R-1.|G90 G80",
    "G68 X5. Y5. R30.|G1 X10. Y0. F100|G2 X20. Y10. R12.|G3 X10. Y0. I3. J-4.|G69",
    "G16|G1 X10. Y30. F100|Y45.|G15",
    "G51 X5. Y5. P2.|G1 X10. F100|G2 X20. Y10. R12.|G50",
    "G1 X10. ,R2. F100|Y10. ,C1.|X0.",
    "G68 X0. Y0. R90.|G0 X0. Y0.|G91 G1 X1. F100|Y2. Z-1.",
    "G51.1 X0.|G91 G1 X1. F100|X-3. Y1.|G50.1",
    "G51 X0. Y0. P2.|G91 G1 X1. F100|X-3. Y1.|G50",
)
TURNED = (
    "G0 X60. Z2.|G90 X50. Z-30. F.2|X45. R-2.",
    "G0 X90. Z2.|G71 U4. R1.|G71 P1 Q2 U1. W.5|N1 G0 X40.|G1 Z-20.|G2 X50. Z-25. R5.|N2 G1 X90.",
    "G0 X60. Z2.|G75 R1.|G75 X50. Z-8. P1000 Q2000 F.1",
    "G0 X0. Z2.|G83 Z-20. R-1. Q4000 F.1|G80",
    "G0 X90. Z2.|G73 P1 Q2 I5. K2. D2 U1. W.5|N1 G0 X40.|G1 Z-20. F.2|N2 X90.",
    "G0 X90. Z2.|G73 U5. W2. R2|G73 P1 Q2 U1. W.5|N1 G0 X40.|G1 Z-20. F.2|N2 X90.",
)
OKUMA = (
    "G0 X50. Z5.|NLAP1 G81|G0 X30. Z2.|G1 Z-20. F.2|X40. Z-25.|G80|G85 NLAP1 D4. F.35 U.2 W.1",
    "G0 X50. Z5.|NLAP1 G81|G0 X30. Z2.|G1 Z-20.|X40.|G80|G85 NLAP1 D4. DA=2. XA=40. U1. W.5",
    "G0 X20. Z0.|G1 X20. Z-5. F.2|G2 X30. Z-10. L5.",
    "G0 X50. Z5.|G181 X30. Z-10. C90. K3. F.1|C180.",
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


@pytest.mark.parametrize("dialect", ["fanuc-lathe-a", "haas-lathe"])
def test_the_distance_of_the_first_cut_of_g73(dialect):
    """I 5 mm, a radius, and K 2 mm: the start X90 Z2 moves to X100 Z4."""
    text = "G0 X90. Z2.|G73 P1 Q2 I5000 K2000 D2 U0 W0|N1 G0 X40.|G1 Z-20. F.2|N2 X90."
    lines = text_of(text, dialect, replace(LATHE, integers="least increments"))
    assert lines[1:3] == ["G0 X100. Z4.", "X50."]


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas"])
def test_a_distance_within_a_rotation(dialect):
    """1000 least increments of 0.001 mm along X, turned by 90 degrees: 1 mm along Y."""
    counted = replace(MILL, integers="least increments", least_increment=dict.fromkeys("XYZ", 1e-3))
    text = "G0 X0. Y0. Z9.|G68 X0. Y0. R90.|G0 X0. Y0.|G91 G1 X1000 F100"
    assert text_of(text, dialect, counted)[-1] == "G91 G1 X0. Y1. F100"


@pytest.mark.parametrize("program", OKUMA, ids=lambda p: p.split()[2].replace("|", "-"))
def test_okuma_lathes(program):
    counted = replace(LATHE, integers="least increments")
    pointed = text_of(program, "okuma-lathe", counted)
    assert len(pointed) > 2
    assert numbers(text_of(without_points(program), "okuma-lathe", counted)) == numbers(pointed)


def test_pecks_along_x_count_the_increments_of_x():
    """Q3000 of 0.0001 mm is 0.3 mm, a radius: 0.6 mm of diameter below R, X46."""
    counted = replace(LATHE, least_increment={"X": 1e-4, "Z": 1e-3, "C": 1e-3})
    lines = text_of("G0 X50. Z5.|G87 X45. Z-3. R-2. Q3000 F.1", "fanuc-lathe-a", counted)
    assert lines[3:5] == ["G1 X45.4", "G0 X46."]


def test_degrees_are_the_same_in_inches():
    """A tenth of a length's increment is one of inches; 90000 thousandths of a degree stay 90."""
    scene = Scene(Tracker(Interpreter(dialects.load("haas-lathe"), LATHE)))
    scene.tracker.take(b"G20")
    counted = lambda axis: scene.length(Word(axis, 90000.0, "90000", 0, 0), axis)  # noqa: E731
    assert [counted(axis) for axis in "CX"] == pytest.approx([90.0, 9.0])


@pytest.mark.parametrize(("p", "begins"), [("P.05", "Z0.05"), ("P50", "Z0.05")])
def test_the_way_before_a_peck_of_a_fadal(p, begins):
    """P of G83 is 0.05 mm above the last peck, at Z0: 50 increments of 0.001 mm."""
    counted = replace(MILL, least_increment=dict.fromkeys("XYZ", 1e-3))
    lines = text_of(f"G0 X0. Y0. Z9.|G83 X1. Z-5. R2. Q2. {p} F9.", "fadal", counted)
    assert lines[3:6] == ["G1 Z0.", "G0 Z2.", begins]


def test_an_angle_without_a_point_is_asked_for():
    """R of G68 counts 0.001 or 0.00001 degrees by a parameter (Fanuc 15i B-63324EN, "Coordinate
    system rotation"); of what size the increments of A are, and those of a Haas, is in no text that
    was found."""
    with pytest.raises(ProgramError, match=r"R30 has no decimal point"):
        text_of("G0 X0. Y0.|G68 X0. Y0. R30", "haas", MILL)
    assert text_of("G0 X0. Y0.|G68 X0. Y0. R30", "fanuc-mill", MILL)
    line = "G0 X40. Z0.|G1 X60. {} F.1|"
    shape = "G0 X90. Z2.|G71 U4. R1.|G71 P1 Q2 U1. W.5|N1 G0 X40.|G1 X60. {} F.1|N2 X90."
    counted = replace(LATHE, integers="least increments")
    for program in (line, shape):
        with pytest.raises(ProgramError, match=r"A135 has no decimal point"):
            text_of(program.format("A135"), "fanuc-lathe-a", counted)
        assert text_of(program.format("A135."), "fanuc-lathe-a", counted)
        assert text_of(program.format("A135"), "fanuc-lathe-a", LATHE)


def test_every_angle_of_a_bolt_pattern_is_asked_for():
    with pytest.raises(ProgramError, match=r"K45 has no decimal point"):
        text_of("G0 X0. Y0. Z9.|G81 Z-5. R2. L0|G71 I20. J0 K45 L2", "haas", MILL)
