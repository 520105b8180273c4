"""Expressions and text of Fanuc and Haas programs written out: values by hand, vacancy as the
manual has it, all other text to the byte."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.errors import ProgramError
from tests.expand.fanuc_lines import MILL, plain, refused, run, value


@pytest.mark.parametrize(
    "text, expected",
    list(
        {
            "1+2*3": 7,
            "[1+2]*3": 9,
            "2-3-4": -5,
            "24/4/3": 2,
            "-2+5": 3,
            "-[COS[0]]": -1,
            "2*-3": -6,
            "SIN[30]": 0.5,
            "COS[60]": 0.5,
            "TAN[45]": 1,
            "SIN[-90]": -1,
            "COS[720]": 1,
            "ACOS[0.5]": 60,
            "ACOS[-1]": 180,
            "ATAN[1]": 45,
            "ATAN[-1]": -45,
            "ATAN[-1]/[-1]": 225,  # B-64304EN: 225.0 with parameter NAT = 0
            # 270 to 90 degrees with NAT = 0
            "ATAN[1,-1]": 135,
            "ATAN[0]/[1]": 0,
            "ASIN[0.5]": 30,
            "ASIN[-0.5]": 330,
            "SQRT[9]": 3,
            "SQR[16]": 4,
            "ABS[-15]": 15,
            "LN[EXP[2]]": 2,
            "POW[2,10]": 1024,
            "FIX[1.2]": 1,
            "FIX[-1.2]": -1,
            "FUP[1.2]": 2,
            "FUP[-1.2]": -2,  # B-64304EN: FIX and FUP
            "FIX[0.002*1000]": 2,
            "FIX[0.3/0.1+0.0001]": 3,
            "27 MOD 20": 7,  # Haas 96-8000, "Arithmetic operators"
            "-27 MOD 20": -7,
            "7.6 MOD 3": 2,  # B-64484EN: rounded first; the sign of the dividend
            "5 AND 3": 1,
            "1 OR 2": 3,
            "5 XOR 3": 6,  # Haas 96-8000, "Logical operators": 0101, 0011
            "1 OR 2 AND 3": 3,
            "6 AND 3 + 1": 3,  # AND binds like *, OR like +
            "BCD[12]": 18,
            "BIN[18]": 12,
            "3 GT 2": 1,
            "[3 GT 2] AND [1 EQ 2]": 0,
            "[3 GT 2] OR [1 EQ 2]": 1,
            "2 LE 2": 1,
            "2 GE 3": 0,
            "2 NE 2": 0,
            "1 LT 2": 1,
            "RO[0]+FU[1.1]+SI[90]": 3,  # first two letters of a function
        }.items()
    ),
)
def test_expressions(text, expected):
    assert value(text) == pytest.approx(expected, abs=5e-4)


@pytest.mark.parametrize("text", ["FIX[0.3/0.1]", "FUP[2.3*100]", "FIX[-0.3/0.1]"])
def test_what_rounding_decides_is_not_cut(text):
    """B-63944EN, 16, "Limitation", FIX function: it "may not" be the whole number."""
    with pytest.raises(ProgramError, match="is one but for rounding"):
        value(text)


def test_round_in_words_and_numbers_of_variables():
    # Haas 96-8000, "ROUND": #1=1.00333, X[#1+#1] goes to 2.007, X[ROUND[#1]+ROUND[#1]] to 2.006;
    # #2=ROUND[1.714] is 2.
    assert plain(
        "#1=1.00333\nX[#1+#1]\nX[ROUND[#1]+ROUND[#1]]\n#2=ROUND[1.714]\nX#2\nX[RND[2.5]]\n#2=ROUND[-1.5]\nX#2\n"
    ) == [
        "X2.007",
        "X2.006",
        "X2.",
        "X2.5",
        "X-2.",
    ]
    assert plain("G20\n#1=1.00333\nX[ROUND[#1]]\nX#1\nG21\nX#1\n") == [
        "G20",
        "X1.0033",
        "X1.0033",
        "G21",
        "X1.003",
    ]
    # an empty variable counts as 0 in a function (B-64304EN-1, "undefined variable")
    assert plain("X[ROUND[#1]]\nX[ROUND[#1]+2.5]\n") == ["X0.", "X2.5"]
    # Haas 96-8000: "sets #3 to the value 6.5"
    assert plain("#1=3\n#[#1]=3.5+#1\nX#3\n") == ["X6.5"]
    assert plain("#5=7\n#7=9.5\nX##5\nX#[#5-0.4]\n") == ["X9.5", "X9.5"]  # rounded


def test_arithmetic_vacancy():
    # B-64304EN, table "Undefined variables": #2=#1 vacant, #2=#1*5 zero, #2=#1+#1 zero.
    assert plain("#2=#1\n#3=#1*5\n#4=#1+#1\nX#2Y#3Z#4\n") == ["Y0.Z0."]
    assert plain("#5=3\n#5=#0\nG0X#5Y1000\n") == ["G0Y1000"]
    # a block of vacant words goes
    assert plain("G0 X-#1 Y[#1] ,R#1 Z-1\nX#1 Y#1\n") == ["G0    Z-1"]


@pytest.mark.parametrize(
    "condition, vacant, zero",
    [
        ("#1 EQ #0", 1, 0),
        ("#1 NE #0", 0, 1),
        ("#1 EQ 0", 0, 1),
        ("#1 NE 0", 1, 0),
        ("#1 GE #0", 1, 1),
        ("#1 GT 0", 0, 0),
        ("#1 LE #0", 1, 1),
        ("#1 LT 0", 0, 0),
    ],
)
def test_conditional_vacancy(condition, vacant, zero):
    """B-64304EN, "Undefined variables": vacant differs from 0 for EQ and NE only."""
    program = "O1\n{}\nIF[{}]THEN #2=1\nX[#2+0]\n"
    assert plain(program.format("#1=#0", condition))[1:] == [f"X{vacant}."]
    assert plain(program.format("#1=0", condition))[1:] == [f"X{zero}."]


def test_numbers_are_written_as_their_address_asks():
    text = "#1=3\n#2=54.1\nG#2P#1X#1M#1S[1000.5]T#1D[1.67]F#1R-#1I[1/3]H[2.4]N1\n"
    assert plain(text) == ["G54.1P3X3.M3S1001T3D2F3.R-3.I0.333H2N1"]
    assert plain("#1=3\nG4X#1\nG4P[500.2]\nG51 X0 Y0 P#1\n") == ["G4X3.", "G4P500", "G51 X0 Y0 P3."]
    assert plain("G4 P[0.5]\n", dialect="haas") == ["G4 P0.5"]
    refused("G[90.55]\n", "G90.55 is no G code")
    refused("X[POW[10,9]]\n", "limit 1e+09")
    refused("#1=99\nM#1\n", "M99 as the value of an expression")


def test_all_else_stays_byte_for_byte():
    assert plain("n10  g1 x#1 (KEEP [#1] THIS)  Y [ 1 + 1 ]   f100 (é)\n") == [
        "n10  g1  (KEEP [#1] THIS)  Y 2.   f100 (é)"
    ]
    assert plain("#1=2 (TWO)\r\nG1 X#1\r\n") == ["G1 X2."]


def test_tape_marks_heads_and_the_end():
    text = "%\nO1(A)\n\n(B)\n#1=1\nX#1\nM30\n\n(C)\n%\nO2\nX5\n"
    assert plain(text) == ["%", "O1(A)", "", "(B)", "X1.", "M30", "", "(C)", "%"]
    assert plain("O1\n#1=1\nM30\nN5 X9\n%\n") == ["O1", "M30", "%"]
    assert plain("X1\nM2\nX2\n") == ["X1", "M2"]
    assert plain("O1\nM98P2\nX9\nO2\nX1\nM30\n") == ["O1", "X1", "M30"]
    assert plain("O1 G90 X[1]\nM98P2\nM30\nO2 N7 X2 (A)\nM99\n") == ["O1 G90 X1.", "X2 (A)", "M30"]


def test_end_of_block_or_comment():
    assert plain("#1=1;G1 X#1;(ONE) ;\nY#1 ; (Y)\nZ1; Z2;\n") == [
        "G1 X1.;(ONE) ;",
        "Y1. ; (Y)",
        "Z1; Z2;",
    ]
    assert plain("#1=1 ; SET #2\nG1 X#1 ; TO #1\n", semicolon="comment") == ["G1 X1. ; TO #1"]
    assert plain("G66P2;\nX1;Y1;M8;\nG67;X2;\nM30;\nO2;Z1;M99;\n") == [
        "X1;",
        "Z1;",
        "Y1;",
        "Z1;",
        "M8;",
        "X2;",
        "M30;",
    ]


def test_block_delete():
    text = "#1=1\n/#1=2\n/ M98 P9\nX#1\n/X9\n/M99\nM30\n"
    assert plain(text, setup=replace(MILL, block_delete=True)) == [
        "/#1=2",
        "/ M98 P9",
        "X1.",
        "/X9",
        "/M99",
        "M30",
    ]
    assert plain("#1=1\n/#1=2\n/2 X#1\n") == ["/2 X2."]


NUMBERS = st.decimals(-500, 500, places=3, allow_nan=False)
BLOCKS = st.one_of(
    st.builds(
        lambda x, y, c: f"G1 X{x} Y{y}{c}",
        NUMBERS,
        NUMBERS,
        st.sampled_from(["", " F100", " (TO GOTO 5)", ";", " ; (A);X1;"]),
    ),
    st.sampled_from(
        [
            "",
            "M3",
            "N10 G0 Z5.",
            "(DO1 [#5] M98 P1)",
            "G91",
            "t1 m6",
            "/G0 X1",
            "G20",
            "G28 Z0",
            "G81 X1. Z-1. R1.",
        ]
    ),
)


@settings(deadline=None)
@given(
    st.lists(BLOCKS, max_size=30),
    st.sampled_from([[], ["M30"], ["M30", "", "%"], ["M02"]]),
    st.booleans(),
)
def test_a_program_without_macros_is_unchanged(blocks, end, crlf):
    text = "\n".join(["%", "O1234 (ROUND #1)", *blocks, *end]) + "\n"
    data = (text.replace("\n", "\r\n") if crlf else text).encode()
    expected = [(line.encode(), n, "") for n, line in enumerate(text.split("\n")[:-1], 1)]
    assert run(data) == expected
