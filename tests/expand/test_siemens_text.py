"""The text of Sinumerik programs written out: plain lines stay to the byte, numbers stand where
expressions stood, and positions are those of the tracker; by hand."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from postproc.errors import BlockFault
from tests.expand.siemens_lines import Follower, refused, run, texts

# -- text ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line",
    [
        "N10 G1 X10 Y-2.5 F1000 ; (R1) \xe4",
        "  g1x1y2",
        "",
        "   ",
        "; only a comment IF X",
        "X=1 Y = -2. A3=0.5 CR=20",
        "X=IC(5) Y=AC(-.5)",
        "I=AC(3) J=IC( 4 )",
        'T="BALL_MILL" M6',
        "TRANS X10 Y=5",
        "TRANS",
        "G2 X0 Y0 I5 J0 TURN=3",
        'MSG("a;b=R1")',
        "MSG()",
        "SETAL(12345)",
        "G64 SOFT FFWON",
        "FGROUP(X,Y)",
        "SPOS=90 SPOS[2]=DC(45)",
        "BSPLINE X1 PW=2",
        "POS[U]=10 FA[U]=100",
        "TRAORI(1)",
        "S1=500 M1=3 H5",
        "G4 F1",
        "ACC[X]=50",
        "X1\t Y2 ;\tz",
        "LIMS=3000",
        "N5 SUPA G0 Z0 D0",
        ":5 X1",
        "%_N_MAIN_MPF",
        'WORKPIECE(,,,"BOX",112,0,-20)',
        "CYCLE832(0.01,_ROUGH,1)",
        "PO[X]=(1,2.5)",
        "M30",
        "G1 X5 M17",
    ],
)
def test_plain_lines_stay_as_they_are(line):
    assert [part.text for part in run(line + "\r\n" if line else "\n")] == (
        [line.encode("latin-1")]
    )


@given(
    st.lists(
        st.lists(
            st.sampled_from("G0 G1 X1 Y-2.5 Z.5 x=3 N7 F100. M3 CR=5 A3=-0.1 TRANS SOFT D1".split())
        ),
        max_size=9,
    )
)
def test_plain_programs_stay_as_they_are(words):
    text = "".join(" ".join(line) + "\n" for line in words)
    found = run(text)
    assert b"".join(line.text + b"\n" for line in found).decode() == text
    assert [line.source for line in found] == list(range(1, len(words) + 1))


@pytest.mark.parametrize(
    "line, written",
    [
        ("N1 X = R1*2 ;c", "N1 X = 3. ;c"),
        ("X=IC(R1) Y=AC( R1 + 1 )", "X=IC(1.5) Y=AC( 2.5 )"),
        ("CR=R1 TURN=R2", "CR=1.5 TURN=2"),
        ("G=R2 M=R2 T=R2 D=R2", "G=2 M=2 T=2 D=2"),
        ("F=R1*1000 S1=R2", "F=1500. S1=2."),
        ("TRANS X=R1 Y10", "TRANS X=1.5 Y10"),
        ("G2 X=R1Y=R2 I=AC(R1)", "G2 X=1.5Y=2. I=AC(1.5)"),
        ("X1.5EX1 Y1", "X15. Y1"),
        ("X=1.5EX1", "X=15."),
        ("M=QU(R2)", "M=QU(2)"),
        ('MSG("R1 is "<<R1)', 'MSG("R1 is 1.5")'),
        ("SETAL(65000+R2)", "SETAL(65002)"),
        ("POS[X]=R1 ACC[X]=R2", "POS[X]=1.5 ACC[X]=2."),
        ("SPOS[R2]=DC(R1)", "SPOS[2]=DC(1.5)"),
        ("N5 LA1: X1", "N5 X1"),
        ("LA1:X=R1", "X=1.5"),
        ("X=-R1", "X=-1.5"),
        ("X=0*-R1", "X=0."),
        ("X=1/3", "X=0.33333"),
        ("F=1/3", "F=0.333333"),
    ],
)
def test_numbers_stand_where_expressions_stood(line, written):
    assert texts(f"R1=1.5 R2=2\n{line}") == [written]


def test_a_program_of_nothing():
    assert run("") == [] and run("\n") == run("; ")[:0] + run("\n")
    assert [part.text for part in run("X1\r\nX2")] == [b"X1", b"X2"]


# -- positions -------------------------------------------------------------------------------------


def test_positions_come_from_the_tracker():
    text = "X10 Y5\nTRANS X100\nX1\nR1=$AA_IW[X] R2=$AA_IM[x] R3=$P_EP[Y]\nZ=R1 A=R2 B=R3"
    assert texts(text)[-1] == "Z=1. A=101. B=5."


def test_a_line_that_the_tracker_can_not_follow_is_said_where_it_is_asked():
    tracker = Follower()

    def work(axis):
        raise BlockFault(0, "two X words", "write one")

    tracker.work = work
    refused(
        "X1 X2\nR1=$AA_IW[X]",
        "a line before this one can not be followed: two X words",
        "write one",
        tracker=tracker,
    )


def test_decimals_are_asked_for_again_when_the_unit_may_have_changed():
    tracker = Follower()
    tracker.decimals = lambda letter: 2 if not tracker.inch else 4
    tracker.take = lambda line: setattr(tracker, "inch", tracker.inch or b"G70" in line)
    assert texts("X=1/3\nG70\nX=1/3", tracker=tracker) == ["X=0.33", "G70", "X=0.3333"]
