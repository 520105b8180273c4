"""Drilling cycles of Fanuc's and Haas' lathes: plain lines by hand, from the manuals that each test
names."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Line, Program
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.expand.plain_lines import LATHE, lathe


def test_lathe_drilling_counts_r_from_where_it_stands():
    """B-64304EN-1, "Front drilling cycle (G83)", "Side drilling (G87)": R is a distance from the
    initial level."""
    assert lathe("G0 X0 Z5.|G83 Z-4. R-3. F.1", "fanuc-lathe")[1:] == [
        "G0 Z2. F.1",
        "G1 Z-4.",
        "G0 Z5.",
    ]
    lines = lathe("G0 X50. Z5.|G99 G87 X20. Z-3. R-5. Q6000 P100", "fanuc-lathe")
    assert lines[1:] == [
        "G99 G0 Z-3.",
        "X40.",
        "G1 X28.",
        "G0 X40.",
        "X29.",
        "G1 X20.",
        "G4 P100",
        "G0 X40.",
    ]


def test_the_m_code_of_a_hole_clamps_c_and_the_next_one_frees_it():
    """B-64304EN-1, "C-axis clamp/unclamp": M is sent behind the positioning, before R level, the
    code above it behind the way back; a hole without M is not clamped. M8 and M5 are no clamps."""
    lines = lathe("G0 X50. Z5. C0.|G83 Z-4. R-3. F.1 M31 M8|C90. M31|C180.|G80 M5", "fanuc-lathe-a")
    hole = ["G1 Z-4.", "G0 Z5."]
    assert lines[1:] == [
        *("M31 F.1 M8", "G0 Z2.", *hole, "M32"),
        *("G0 C90.", "M31", "Z2.", *hole, "M32"),
        *("G0 C180.", "Z2.", *hole),
        "G80 M5",
    ]
    lines = lathe("G0 X50. Z5. C0.|G88 X40. R-3. F.1 M31|G80", "fanuc-lathe-a")
    assert lines[1] == "G88 X40. R-3. F.1 M31"


def test_holes_of_a_haas_lathe_go_to_r_as_a_place_and_back_to_where_they_began():
    """Haas lathe operator's manual, G83, G85, G243; written as Autodesk's `haas lathe.cps` writes a
    hole: to the clearance, then X Z R F, G80. R of a radial hole is a diameter, pecks are radii: X
    46 less 2 x 2 is 42, and 40 is the bottom."""
    lines = lathe("G18|G0 X0. Z5.|G0 Z5.|G83 X0. Z-4. R2. Q4. P500 F.1|G80|G0 Z5.", "haas-lathe")
    assert lines[3:] == [
        "G0 X0. F.1",
        "Z2.",
        "G1 Z-2.",
        "G0 Z2.",
        "Z-1.5",
        "G1 Z-4.",
        "G4 P500",
        "G0 Z5.",
        "G80",
        "G0 Z5.",
    ]
    lines = lathe("G19|G0 X50. Z-10.|G243 X40. Z-10. R46. Q2. F.1|G80|G0 X60.", "haas-lathe")
    assert lines[2:-2] == [
        "G0 Z-10. F.1",
        "X46.",
        "G1 X42.",
        "G0 X46.",
        "X43.",
        "G1 X40.",
        "G0 X50.",
    ]
    lines = lathe("G0 X20. Z5.|G85 X20. Z-8. R2. F.1|U4.|G80", "haas-lathe")
    assert lines[1:-1] == [
        "G0 X20. F.1",
        "Z2.",
        "G1 Z-8.",
        "Z2.",
        "G0 Z5.",
        "G0 U4.",
        "Z2.",
        "G1 Z-8.",
        "Z2.",
        "G0 Z5.",
    ]


def test_a_haas_lathes_hole_without_r_begins_where_the_tool_stands():
    assert lathe("G0 X0. Z2.|G81 Z-8. F.1|G80", "haas-lathe")[1:] == [
        "G1 Z-8. F.1",
        "G0 Z2.",
        "G80",
    ]


def test_where_a_haas_lathe_ends_behind_a_hole_is_said_and_nothing_counts_from_there():
    resolver = Resolver(
        Program("part", b""), Tracker(Interpreter(dialects.load("haas-lathe"), LATHE))
    )
    for n, one in enumerate(["G0 X20. Z5.", "G81 Z-8. R2. F.1", "G80", "G0 X30."], 1):
        resolver.take(Line(one.encode(), n))
    (notice,) = resolver.scene.notices
    assert (
        "goes back to Z5." in notice.message and "at R, Z2." in notice.message and notice.line == 2
    )
    with pytest.raises(ProgramError, match="W1. counts from where the cycle left Z"):
        resolver.take(Line(b"W1.", 5))
    (home,) = resolver.take(Line(b"G28 U0 W0.", 5))  # no way before the reference point
    assert home.text == b"G28 U0 W0."
    assert resolver.take(Line(b"Z9.", 6))[0].text == b"Z9."
    assert resolver.take(Line(b"W1.", 7))[0].text == b"W1."


@pytest.mark.parametrize(
    ("program", "bottoms"),
    [
        ("G0 X10. Z5.|G83 Z-10. R2. I4. J1. K2. F.1", ["Z-2.", "Z-5.", "Z-7.", "Z-9.", "Z-10."]),
        (
            "G0 X60. Z5.|G243 X20. R50. I4. J1. K2. F.1",
            ["X42.", "X36.", "X32.", "X28.", "X24.", "X20."],
        ),
    ],
)
def test_pecks_that_grow_less_are_lengths_along_z_and_radii_along_x(program, bottoms):
    """Haas lathe operator's manual, G83 and G243: the first peck is I, each one J less, none below
    K. From Z2: 4, 3, 2, 2 and what is left; from the diameter 50 twice that."""
    lines = lathe(program, "haas-lathe")
    assert [line.removeprefix("G1 ") for line in lines if line.startswith("G1")] == bottoms
