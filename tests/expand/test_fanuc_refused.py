"""Fanuc and Haas programs that are refused, with the place; limits; no text raises anything but a
sentence for the user."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.errors import ProgramError
from postproc.nc.expand import Limits
from tests.expand.fanuc_lines import LATHE, MILL, refused, run


@pytest.mark.parametrize(
    "block, message",
    [
        ("X#500", "only the control knows"),
        ("X#2001", "tool offset"),
        ("X#3001", "timer"),
        ("#1=#3011\n#100=#1+1\nX#100", "#3011 is read: a state of the control"),
        ("#100=#600\nIF [#100 EQ 1] GOTO 9", "#600 is read but never set"),
        ("#600=#3001\nX#600", "#3001 is read: a timer"),
        ("#3000=#600", "#600 is read"),
        ("X#1000", "interface signal"),
        ("X#5061", "probe"),
        ("X#4119", "no S has been given yet"),
        ("G92 S2000\nS#4119", "the last S stands beside G50 or G92"),
        ("X#4111", "the last H is not followed"),
        ("X#4109", "no F has been given"),
        ("X#5241", "G55 is not stated"),
        ("X#5004", "no axis number 4"),
        ("X#40", "#40"),
        ("#0=1", "always vacant"),
        ("G91\n#5221=1", "adds to the offset"),
        ("#5221=#0", "would be vacant"),
        ("#5221=#600", "#600 is read"),
        ("#5224=1", "no axis number 4"),
        ("#2001=1", "tool offset"),
        ("#1100=1", "interface signal"),
        ("#3003=1", "state of the control"),
        ("#5001=1", "no variable"),
        ("X#4016", "no G code for 'rotation'"),
        ("G81 X1. Z-1. R1. F1\nX#4001", "canned cycles"),
        ("G28 X0\nX#5001", "where X stands is not known"),
        ("G68 X0 Y0 R30.\nX#5001", "turned"),
        ("X1 X2\nX#5001", "two X words"),
        ("G43 H1\nX#5043", "where Z stands"),
        ("G43 H1\nX#5023", "where Z stands"),
        ("G55\nX#5021", "where X stands"),
        ("#100=1/0", "division of 1 by zero"),
        ("X[3 MOD 0]", "division of 3 by zero"),
        ("X[SQRT[-4]]", "SQRT[-4] has no value"),
        ("X[LN[0]]", "LN[0]"),
        ("X[ASIN[1.5]]", "ASIN[1.5]"),
        ("X[TAN[90]]", "TAN[90]"),
        ("X[EXP[1000]]", "EXP[1000]"),
        ("X[ATAN[0]/[0]]", "ATAN[0, 0]"),
        ("X[1.5 AND 1]", "operand of AND is 1.5"),
        ("X[FOO[1]]", "'FOO' is no function"),
        ("X[ADP[#1]]", "'ADP' is no function"),
        ("X[1+]", "a value is missing"),
        ("X[1", "is not closed"),
        ("X[1]]", "']'"),
        ("X#", "without the number"),
        ("#1", "a variable alone"),
        ("#1=", "a value is missing"),
        ("#1=5 X1", "'X1' behind"),
        ("X1 #2", "'#' can not be read"),
        ("X[1 EQ 1 EQ 1]", "two comparisons"),
        ("X[SIN 1]", "takes its argument"),
        ("X[" + "[" * 60 + "1" + "]" * 61, "deeper than 40"),
        ("IF[1 EQ 1]", "without GOTO or THEN"),
        ("X[#[0-1]]", "no variable #-1"),
        ("WHILE[1]DO4\nEND4", "numbered 1 to 3"),
        ("WHILE[1]DO1", "DO1 without END1"),
        ("END2", "END2 without DO2"),
        ("WHILE[1]", "WHILE without"),
        ("WHILE[1]DO1\nWHILE[1]DO2\nEND1\nEND2", "is cut by END1"),
        ("WHILE[1]DO1\nWHILE[1]DO1\nEND1\nEND1", "DO1 inside DO1"),
        ("GOTO 9", "there is no N9"),
        ("GOTO#1", "vacant"),
        ("GOTO[1.5]", "GOTO 1.5"),
        ("GOTO 5\nWHILE[1]DO1\nN5X1\nEND1", "inside the loop of line 3"),
        ("M98", "M98 without P"),
        ("M98P#1", "M98 without P"),
        ("M98P9L0", "repeated 0 times"),
        ("G65A1.", "G65 without P"),
        ("M98P1.5", "P is 1.5"),
        ("G65P9G1\nM30\nO9\nM99", "G can not hand over"),
        ("X1 G65P9", "X before G65"),
        ("G66.1P9", "G66.1"),
        ("M98P9M99", "two calls"),
        ("G65P9" + "I1." * 11 + "\nM30\nO9\nM99", "11 sets"),
        ("/M99", "M99 in the main program"),
        (
            "IF[#101EQ#0]THEN#101=5\nX#101\n#101=#101+1\nM99",
            "the second time it would be another program",
        ),
        ("M98P9\nM30\nO9\nX1", "O9 ends without M99"),
        ("X1\nO9\nM99", "runs into O9"),
        ("G66P9\nM98P9X1.\nM30\nO9\nM99", "under G66"),
        ("X#1 GOTO 5", "the letter G"),
        ("X1 GOTO 5", "the letter G"),
    ],
)
def test_refusals(block, message):
    refused(f"O1\n{block}\n", message, "p.nc:")


@pytest.mark.parametrize("block", ["G20 /M8", "M98 P9 /M8", "M30 /M9", "X#1 /M8"])
def test_a_slash_within_a_block_of_the_language_is_refused(block):
    refused(f"O1\n{block}\n", "'/' can not be read here", "p.nc:2", dialect="haas")


def test_limits_and_the_place_of_a_fault():
    place = refused("O1\nN5 G1 X10. (ALL) Y[ 1 / #1 ]\n", "p.nc:2").place
    assert place.text[place.start - 1 : place.stop - 1] == "/ #1"
    said = "more than 1,000 lines were executed"
    refused("#1=0\nN1 #1=#1+1\nGOTO 1\n", said, limits=Limits(steps=1000))
    refused("O1\nM98P1\n", "more than 10 calls are nested in each other", limits=Limits(depth=10))
    assert len(run("X1\n" * 50, limits=Limits(steps=10))) == 50  # the text itself is never too long
    refused(
        "#1=1\n" + "X1\n" * 50 + "GOTO 1\nN1 GOTO 1\n",
        "more than 53 lines",
        limits=Limits(steps=10),
    )


@pytest.mark.parametrize(
    "text",
    [
        "N1 X1\nGOTO 1",
        "N1 X1\nM99 P1",
        "WHILE[1 EQ 1]DO1\nX1\nEND1",
        "#1=0\nN1 #1=1-#1\nWHILE[#1 LT 3]DO1\n#1=#1+1\nEND1\n#1=0\nX1\nGOTO 1",
        "M98 P9\nM30\nO9\nN1 X1\nGOTO 1\nM99",
    ],
)
def test_a_round_that_nothing_ends_is_reported_at_once(text):
    refused(f"O1\n{text}\n", "goes round without end", "p.nc:", limits=Limits(steps=40))


def test_rounds_that_end_are_no_such():
    """One pass of a loop each time, in a program that is run twice; a call each time from the same
    line; and what decides by more than the memory may be another thing each time."""
    once = "#1=0\nWHILE[#1 LT 1]DO1\nG1 X1. F9.\n#1=#1+1\nEND1\n"
    assert len(run(f"O1\n{once}M99\n")) == 3
    assert len(run(f"O1\nM98 P90003\nM30\nO0003\n{once}M99\n")) == 11
    text = "G0 X0\nG91\nN1 G1 X1. F9.\nIF[#5001 LT 5.]GOTO 1\nM30"
    assert sum(b"X1." in line.text for line in run(f"O1\n{text}\n")) == 5


PIECES = st.sampled_from(
    "#1 #2 #[ #[#1] ##2 = [ ] + - * / MOD AND XOR SIN[ ATAN[ ]/[ SQRT[ ROUND[ BCD[ POW[ , EQ GT 1 2"
    " 0.5 10 9999999999 IF[ ]GOTO ]THEN GOTO WHILE[ ]DO1 DO2 END1 END2 N1 N2 M98 P2 P1 L2 M99 M97"
    " G65 G66 G67 A1. I2 K#1 X Y1. Z#2 G1 G2 G20 M30 O1 O2 :3 % / ; ( ) (A) #5001 #4003 #3000=1 #0"
    " #500 E DPRNT[ ,R . é \x00 WH[ TH \n \n \n \r".split(" ")
)


@settings(deadline=None, max_examples=300)
@given(
    st.one_of(
        st.binary(max_size=60),
        st.lists(PIECES, max_size=30).map(lambda p: "".join(p).encode("latin-1")),
    ),
    st.sampled_from(["fanuc-mill", "haas", "fanuc-lathe"]),
)
def test_no_text_raises_anything_but_a_program_error(data, dialect):
    try:
        run(data, dialect, LATHE if "lathe" in dialect else MILL, {"2": data}, Limits(200, 5))
    except ProgramError as error:
        assert str(error) and error.advice is not None
