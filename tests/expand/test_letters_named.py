"""Messages name the letters of their control: the bottom is Z on a Fanuc and I on a Fagor."""

from __future__ import annotations

from dataclasses import replace

import pytest

from postproc.errors import ProgramError
from tests.expand.plain_lines import LATHE, MILL, text_of

HEAD = "G0 X0. Y0. Z9.|"
SHAPE = "|N1 G0 X40.|G1 Z-20. F.2|N2 X90."


@pytest.mark.parametrize(
    ("dialect", "program", "message", "advice"),
    [
        ("fanuc-mill", "G81 X1. R2. F9.", r"G81 without its bottom \(Z\)", "first block"),
        ("fanuc-mill", "G83 X1. Z-5. R2. F9.", "G83 without Q\n", "a peck, above 0"),
        ("fagor", "G81 X1. Z2. F9.", r"G81 without its bottom \(I\)", "first block"),
        ("fagor", "G83 X1. Z2. J3 F9.", r"G83 without its bottom \(I\)", "first block"),
        ("fagor", "G83 X1. Z2. I0 J3 F9.", "G83 without I\n", "a peck, above 0"),
        ("okuma", "G73 X1. Z-5. R2. M54 F9.", "G73 without I\n", "a peck, above 0"),
        ("okuma", "G83 X1. Z-5. R2. M54 F9.", "G83 without Q\n", "a peck, above 0"),
        ("fagor", "G83 X1. Z2. I-.00001 J3000000 F9.", "pecks", "the pecks and of the hole"),
        (
            "fanuc-lathe-a",
            "G71 P1 Q2 U0 W0 D-2." + SHAPE,
            "D -2 as the depth of a cut",
            "no sign",
        ),
        (
            "fanuc-lathe-a",
            "G71 U-2. R1.|G71 P1 Q2 U0 W0" + SHAPE,
            "U -2 as the depth of a cut",
            "no sign",
        ),
        ("haas-lathe", "G73 P1 Q2 I5. K2. D2.5 U0 W0" + SHAPE, "how often", "write D here, or R"),
        ("okuma-lathe", "G74 X90. Z-9. D.0001", "steps of", "without a decimal point may count"),
    ],
)
def test_the_letter_that_is_missing(dialect, program, message, advice):
    lathe = "lathe" in dialect
    head = "G0 X90. Z2.|" if lathe else HEAD
    setup = replace(LATHE if lathe else MILL, integers="units")
    with pytest.raises(ProgramError, match=message) as caught:
        text_of(head + program, dialect, setup)
    assert advice in caught.value.advice


def test_a_radius_of_an_arc_in_space_has_the_name_of_the_control():
    program = "G0 X0 Y0 Z5|ROT X30|G1 X0 Y0 Z0 F100|G2 X10 Y0 {}"
    with pytest.raises(ProgramError, match="CR=4 makes no arc") as caught:
        text_of(program.format("CR=4"), "siemens")
    assert caught.value.advice == "check CR and the end"


@pytest.mark.parametrize(("radius", "right"), [(".0353", False), (".0345", False), (".05", True)])
def test_a_radius_of_a_shape_in_inches(radius, right):
    """The ends lie 0.070711 inch apart; 0.001 mm, 0.00004 inch, may be missing."""
    setup = replace(LATHE, integers="units", least_increment=dict.fromkeys("XZC", 1e-4))
    program = (
        f"G20 G0 X.9 Z.2|G71 U.1 R.02|G71 P1 Q2 U0 W0|N1 G0 X.4|G1 Z-.2 F.01|"
        f"G2 X.5 Z-.25 R{radius}|N2 G1 X.9"
    )
    if right:
        assert text_of(program, "fanuc-lathe-a", setup)
        return
    with pytest.raises(ProgramError, match=f"a radius of {radius} is too short for an arc"):
        text_of(program, "fanuc-lathe-a", setup)


CORNERED = "|N1 G0 X40.|G1 Z-20. F.2 M8|X60. ,R2.|Z-30.|N2 X90."


def test_a_shape_is_finished_by_g72_in_system_c():
    """M8 of a shape with a corner is the finishing's, as in system A, and so are the sentences."""
    begin = "G0 X90. Z2.|{} U4. R1.|{} P1 Q2 U1. W.5" + CORNERED
    ends = []
    for dialect, rough, finish in (("a", "G71", "G70"), ("c", "G73", "G72")):
        program = begin.format(rough, rough) + f"|{finish} P1 Q2"
        lines = text_of(program, f"fanuc-lathe-{dialect}", LATHE)
        ends.append(lines[next(i for i, line in enumerate(lines) if "M8" in line) - 1 :])
    assert ends[0] == ends[1] and len(ends[0]) > 5
    with pytest.raises(ProgramError, match="G41 is still on at the end of the shape of G72"):
        shape = CORNERED.replace("N1 G0", "N1 G0 G41").replace(" ,R2.", "")
        text_of(f"G0 X90. Z2.|G72 P1 Q2{shape}", "fanuc-lathe-c", LATHE)
