"""Corners and angles of Fanuc and Haas: as Sinumerik's RND and CHR, whose arcs touch both lines,
and as the points that they stand for, calculated by hand."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from postproc.errors import ProgramError
from tests.expand.plain_lines import LATHE, MILL, text_of

TURN = replace(LATHE, axes=("X", "Z"), start={"X": 0.0, "Z": 0.0})
A = "fanuc-lathe-a"


@pytest.mark.parametrize("dialect", ["haas", "fanuc-mill"])
def test_corners_are_those_of_sinumerik(dialect):
    pick = random.Random(3)
    for _ in range(20):
        sizes = [
            pick.choice([f"R{pick.uniform(0.2, 2):.3f}", f"C{pick.uniform(0.2, 2):.3f}"])
            for _ in range(4)
        ]
        places = [(pick.uniform(8, 20) * (1 + k), pick.uniform(-30, 30)) for k in range(5)]
        ours = "G90 G17 G0 X0. Y0. Z5.|G1 F100.|" + "|".join(
            f"X{x:.3f} Y{y:.3f}" + (f" ,{sizes[k]}" if k < 4 else "")
            for k, (x, y) in enumerate(places)
        )
        theirs = ours
        for size in sizes:
            word = ("RND=" if size[0] == "R" else "CHR=") + size[1:]
            theirs = theirs.replace(f",{size}", word)
        lines, others = text_of(ours, dialect, MILL), text_of(theirs, "siemens", MILL)
        assert len(lines) == len(others)
        for one, other in zip(lines, others, strict=True):
            assert [w[0] for w in one.split()] == [w[0] for w in other.split()]
            values, expected = ([float(w[1:]) for w in x.split()] for x in (one, other))
            assert values == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize(
    ("drawn", "written"),
    [
        ("G1 X60. ,C1.|Z-30. ,R6.|X90.",
         ["G1 X58.", "G1 Z-1. X60.", "Z-24.", "G2 Z-30. X72. K0. I6.", "G1 X90."]),
        ("G1 X60. C1.|Z-30. R6.|X90.",
         ["G1 X58.", "G1 Z-1. X60.", "Z-24.", "G2 Z-30. X72. K0. I6.", "G1 X90."]),
        ("G1 X60.|Z-10. A150.", ["G1 X60.", f"Z-10. X{60 + 20 * math.tan(math.pi / 6):.3f}"]),
        ("G1 X60.|X80. A135.", ["G1 X60.", "X80. Z-10."]),
        ("G1 X60.|X80. , a135. (a,A9)", ["G1 X60.", "X80.   Z-10. (a,A9)"]),
        ("G1 X60. K-1.|Z-30. I6.|X90.",
         ["G1 X58.", "G1 Z-1. X60.", "Z-24.", "G1 Z-30. X72.", "X90."]),
        ("G1 X60. R-1.|Z-30. R6.|X90.",
         ["G1 X58.", "G3 Z-1. X60. K-1. I0.", "G1 Z-24.", "G2 Z-30. X72. K0. I6.", "G1 X90."]),
        ("G1 X60. C1.5 (a, C2)|M8|Z-9.", ["G1 X57. (a, C2)", "G1 Z-1.5 X60.", "M8", "Z-9."]),
    ],
)  # fmt: skip
def test_by_hand(drawn, written):
    lines = text_of("G0 X0. Z0.|" + drawn, A, TURN)
    assert lines[1:] == written


@pytest.mark.parametrize(
    ("drawn", "written"),
    [
        ("G91 G1 X10. A135.|X10. A135.", ["G91 G1 X10. Z-5.", "X10. Z-5."]),
        ("G91|G90 G1 X50. A135.", ["G91", "G90 G1 X50. Z45."]),
        (
            "G1 Z45. R1.|G91 X10. A135.",
            ["G1 Z45.414", "G2 Z44.707 X40.586 K0. I1.", "G91 G1 X9.414 Z-4.707"],
        ),
        (
            "G91 G1 Z-5. R1.|X10. A135.",
            ["G91 G1 Z-4.586", "G2 Z-0.707 X0.586 K0. I1.", "G1 X9.414 Z-4.707"],
        ),
    ],
)
def test_a_line_by_its_angle_counts_as_its_block_says(drawn, written):
    """From Z45 X40 5 mm up and 5 along, in G91 of the block itself (system B); the arc of 1 mm
    takes tan(22.5 deg) of both lines, of the second 0.293 in Z and 0.586 in X."""
    lines = text_of("G90 G0 X40. Z50.|" + drawn, "fanuc-lathe", TURN)
    assert lines[1:] == written


@pytest.mark.parametrize(
    ("drawn", "plain"),
    [
        ("G1 Z0.|X30. ,C2.|Z-20. ,R3.|X40.|Z-30.",
         "G1 Z0.|X26.|X30. Z-2.|Z-17.|G2 X36. Z-20. R3.|G1 X40.|Z-30."),
        ("G1 Z0.|X30. C2.|Z-20. R3.|X40.|Z-30.",
         "G1 Z0.|X26.|X30. Z-2.|Z-17.|G2 X36. Z-20. R3.|G1 X40.|Z-30."),
        ("G1 Z0.|X30. K-2.|Z-20. R3.|X40. R-1.|Z-30.",
         "G1 Z0.|X26.|X30. Z-2.|Z-17.|G2 X36. Z-20. R3.|G1 X38.|G3 X40. Z-21. R1.|G1 Z-30."),
        ("G1 Z0.|X30. K-2.|Z-20. I3.|X40.|Z-30.",
         "G1 Z0.|X26.|X30. Z-2.|Z-17.|X36. Z-20.|X40.|Z-30."),
        # 135 degrees from Z: as far out as along. Two lines by their angles meet at X40 Z-20.
        ("G1 Z0.|X30.|A180.|X60. Z-30. A135.|Z-40.", "G1 Z0.|X30.|Z-15.|X60. Z-30.|Z-40."),
        ("G1 Z0.|X30.|Z-20. A180.|X50. A135.|Z-40.", "G1 Z0.|X30.|Z-20.|X50. Z-30.|Z-40."),
        ("G1 Z0.|X30.|Z-20.|X50.,A135. ,R1.|Z-40.", "G1 Z0.|X30.|Z-20.|X50. A135. R1.|Z-40."),
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    "cycle", ["G71 U2. R1.|G71 P10 Q20 U.4 W.1 F.2", "G73 U4. R3|G73 P10 Q20 F.2"]
)
def test_a_shape_is_the_one_that_it_stands_for(drawn, plain, cycle):
    program = "G0 X70. Z2.|{}|N10 G0 X20.|{}|N20 X62.|G70 P10 Q20"
    ours, theirs = (text_of(program.format(cycle, x), A, TURN) for x in (drawn, plain))
    cut = next(k for k, text in enumerate(ours) if text.startswith("N10"))
    assert ours[:cut] == theirs[: theirs.index(next(t for t in theirs if t.startswith("N10")))]
    places = lambda lines: [t for t in _spots(lines)]  # noqa: E731
    assert places(ours[cut:]) == places(theirs[cut:])


def _spots(lines):
    """Places, one after the other, whatever is named again."""
    at: dict[str, float] = {"X": 70.0, "Z": 2.0}
    for text in lines:
        words = {w[0]: float(w[1:]) for w in text.split() if w[0] in "XZ"}
        if words and {**at, **words} != at:
            at = {**at, **words}
            yield tuple(at.items())


@pytest.mark.parametrize(
    ("program", "why"),
    [
        ("G1 X60. ,R5.|W-9.", "W at a line with"),
        ("G1 X60. ,R5. C1.|Z-9.", "two corners in one block"),
        ("G1 X60.|Z-9. ,C1.|G2 X80. Z-19. R10.", "no straight feed"),
        ("G1 X60.|A90.", "A alone"),
        ("G1 X60. K1.|Z-9.", "the way of its sign"),
        ("G1 X60. K-1.|X70. Z-9.", "a line across it"),
        ("G1 X60. I1.|Z-9.", "behind a motion of Z alone"),
        ("G1 X60. Z-1. K-1.|Z-9.", "behind a motion of X alone"),
        ("G1 X60.|Z-9. A90.", "A90 and no X"),
        ("G1 X60.|X80. A180.", "A180 and no Z"),
    ],
)
def test_what_is_not_followed_is_refused(program, why):
    with pytest.raises(ProgramError, match=why):
        text_of("G0 X0. Z0.|" + program, A, TURN)


SHAPES = [
    ("Z0.|A135.|A120.|X50. Z-40. A100.", "two lines of the shape with A alone"),
    ("Z0.|A135.|X50.", "the next line without A"),
    ("Z0.|A135.|X50. Z-20. A135.", "never meet"),
    ("Z0.|Z-10. ,C1.|G2 X40. Z-20. R10.|G1 X50.", "at an arc"),
    ("Z0.|Z-10. ,C15.|X50.", "begins 15 before its point"),
    ("Z0.|Z-10. ,C1.|Z-20.", "goes straight on"),
    ("Z0.|X30. ,C1. R2.|Z-9.", "two corners"),
    ("Z0.|X30. K2.|Z-9.", "the way of its sign"),
    ("Z0.|X30. Z-1. K-2.|Z-9.", "behind a motion of X alone"),
]


@pytest.mark.parametrize(("lines", "why"), SHAPES)
def test_what_a_shape_does_not_say_is_refused(lines, why):
    with pytest.raises(ProgramError, match=why):
        text_of(f"G0 X70. Z2.|G71 U2. R1.|G71 P10 Q20 F.2|N10 G0 X20.|G1 {lines}|N20 X62.", A, TURN)


def test_a_line_that_can_not_be_read_is_reported_at_its_own_place():
    """Behind a comment, and told when a cycle asks where the tool stands."""
    with pytest.raises(ProgramError, match="does not belong to a number") as caught:
        text_of("G0 X40. Z2.|(FACE)|G0 X-4.5.Z0.|(ROUGH)|G71 U1. R1.|M30", A, TURN)
    assert (caught.value.place.line, caught.value.place.text) == (3, "G0 X-4.5.Z0.")
