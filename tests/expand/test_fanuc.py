"""Fanuc and Haas programs written out: what the manuals print, what was worked out by hand, and
what is refused."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.errors import ProgramError
from postproc.nc.dialects import load
from postproc.nc.expand import Limits, Line, Program, lines_of
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import PLAIN
from postproc.nc.state import Setup

LEAST = dict.fromkeys("XYZ", 0.001)
ZERO = dict.fromkeys("XYZ", 0.0)
MILL = Setup(("X", "Y", "Z"), least_increment=LEAST, offsets={"G54": ZERO}, start=ZERO)
LATHE = Setup(
    ("X", "Z"),
    frozenset("X"),
    {"X": 0.001, "Z": 0.001},
    {"G54": {"X": 0.0, "Z": 0.0}},
    {"X": 10.0, "Z": 0.0},
)


def run(
    text, dialect="fanuc-mill", setup=MILL, library=None, limits=Limits(), **grammar
) -> list[Line]:
    dialect = load(dialect)
    if grammar:
        dialect = replace(dialect, grammar=PLAIN._replace(**grammar))
    tracker = Tracker(Interpreter(dialect, setup))
    data = text if isinstance(text, bytes) else text.encode("latin-1")
    out = []
    for line in lines_of("fanuc", Program("p.nc", data, (library or {}).get), tracker, limits):
        tracker.take(line.text)
        out.append(line)
    return out


def plain(text, *more, **kw) -> list[str]:
    return [line.text.decode("latin-1") for line in run(text, *more, **kw)]


def value(expression: str, before: str = "", **kw) -> float:
    """An expression's value, as the X word that it leaves; nan: the word goes."""
    found = re.search(
        r"X(-?[\d.]+)", " ".join(plain(f"O1\n{before}\nG1 X[{expression}] Z1.\n", **kw)[1:])
    )
    return float(found[1]) if found else math.nan


def refused(text, *parts, **kw) -> ProgramError:
    with pytest.raises(ProgramError) as caught:
        run(text, **kw)
    for part in parts:
        assert part in str(caught.value)
    assert caught.value.advice
    return caught.value


def places(lines: list[str]) -> np.ndarray:
    rows = [re.findall(r"[XY](-?[\d.]+)", line) for line in lines if line.startswith("G1X")]
    return np.array(rows, float)


# -- expressions -----------------------------------------------------------------------------------


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


# -- control ---------------------------------------------------------------------------------------


def test_the_sum_of_1_to_10():
    """B-64304EN, "Conditional branch" and "Repetition": sample programs O9500 and O0001; the sum is
    55."""
    assert plain("#1=0\n#2=1\nN1 IF[#2 GT 10]GOTO 2\n#1=#1+#2\n#2=#2+1\nGOTO 1\nN2 X#1\nM30\n") == [
        "N2 X55.",
        "M30",
    ]
    assert plain("#1=0\n#2=1\nWHILE[#2 LE 10]DO 1\n#1=#1+#2\n#2=#2+#2-#2+1\nEND 1\nX#1\n") == [
        "X55."
    ]


def test_three_nested_loops_and_their_numbers_again():
    text = (
        "WHILE[#1LT2]DO1\n#2=0\nWHILE[#2LT2]DO2\n#3=0\nWHILE[#3LT2]DO3\n#9=#9+1\n#3=#3+1\nEND3\n#2=#2+1\nEND2\n#1=#1+1\nEND1\n"
        "WHILE[#1LT4]DO1\n#1=#1+1\nEND1\nDO1\n#1=#1+1\nIF[#1GT9]GOTO9\nEND1\nN9X#9Y#1\n"
    )
    assert plain(text) == ["N9X8.Y10."]


def test_goto_looks_ahead_first_and_then_from_the_top():
    assert plain(
        "N1X1\n#1=#1+1\nIF[#1GT1]GOTO5\nGOTO 1\nX9\nN1X2\nIF[#1GT1]GOTO5\n#2=1\nGOTO[#2]\nN5 M30\n"
    ) == [
        "N1X1",
        "N1X2",
        "N1X1",
        "N5 M30",
    ]
    assert plain("GOTO 7\nX1\n/ N7 X7\n(N7) N8 X8\n") == ["/ N7 X7", "(N7) N8 X8"]
    assert plain("GOTO 2;N1 X1;N2 X2;X3;\nX4;\n") == ["N2 X2;", "X3;", "X4;"]
    text = (
        "IF[#1EQ#0]THEN#1=5\nIF[#1EQ5]THEN GOTO 3\nX1\nN3 IF [#1 EQ 4] THEN X4\nIF[#1 EQ 5] THEN"
        " X#1 (YES)\n"
    )
    assert plain(text) == ["X5. (YES)"]


def test_subprograms_in_both_forms():
    sub = "O1234(SUB)\nX1\nM99\n"
    assert plain("O1\nM98P1234L3\nM30\n" + sub).count("X1") == 3
    assert plain("O1\nM98P0031234\nM30\n" + sub).count("X1") == 3
    assert plain("O1\nM98 P31234\nM30\n" + sub) == ["O1", "X1", "X1", "X1", "M30"]
    assert plain("O1\nM98 P1234\nM30\n" + sub.replace("O", ":")) == ["O1", "X1", "M30"]
    # five digits
    assert plain("O1\nM98 P31234\nM30\nO31234\nX5\nM99\n", dialect="haas") == ["O1", "X5", "M30"]
    first = plain("O1\nN5 G1 M98 P1234 X10. (THERE)\nM30\n" + sub)  # the motion, then the call
    assert first == ["O1", "N5 G1   X10. (THERE)", "X1", "M30"]


def test_subprograms_share_the_local_variables_and_macros_do_not():
    text = "O1\n#1=5\nM98P2\nX#1\nG65P2A1.\nX#1\nM30\nO2\n#1=#1+1\nY#1\nM99\n"
    assert plain(text) == ["O1", "Y6.", "X6.", "Y2.", "X6.", "M30"]


def test_library_and_files():
    files = {"1234": b"%\nO1234\nX#100\nM98P5\nM99\n%\n", "5": b"Y5\nM99"}
    lines = run("O1\n#100=1.5\nM98P1234\nM198P5\nM30\n%\n", library=files)
    assert [(line.text, line.source, line.file) for line in lines[:4]] == [
        (b"O1", 1, ""), (b"X1.5", 3, "O1234"), (b"Y5", 1, "O5"), (b"Y5", 1, "O5"),
    ]  # fmt: skip
    refused("O1\nM198P1\n", "there is no program O1 in the library")
    refused("O1\nM98P7\n", "there is no program O7", "p.nc:2")
    refused("O1\nM98P7\n", "O7:1", library={"7": b"X[1/0]\nM99\n"})


def test_local_calls_of_haas():
    # Haas 96-8000, M97: "runs the N1000 line five times".
    text = "O1\nG00 X0\nM97 P1000 L5\nM30\nN1000 G91 Z-0.1\nG90\nM99\n"
    assert plain(text, dialect="haas") == ["O1", "G00 X0", *["N1000 G91 Z-0.1", "G90"] * 5, "M30"]
    assert "M97 P1000 L5" in plain(text)  # a builder's code on a Fanuc


def test_haas_reads_some_things_its_own_way():
    # Haas 96-8000, M99: "N50 [#100 LT 10] M99 P10" branches only when #100 is less than 10.
    text = "O1\n#100=9\nN10 X#100\n#100=#100+0.5\n[#100 LT 10] M99 P10\nX0\nM30\n"
    assert plain(text, dialect="haas") == ["O1", "N10 X9.", "N10 X9.5", "X0", "M30"]
    assert value("ATAN2[1]/[-1]+ASIN[-0.5]", dialect="haas") == 105
    refused("X[ATAN[1]/[-1]]\n", "may be a quotient", dialect="haas")


def test_return_with_p():
    text = "O1\nX1\nM98P2\nX9\nN5X5\nM30\nO2\nY1\nM99P5\n"
    assert plain(text) == ["O1", "X1", "Y1", "N5X5", "M30"]
    assert plain("O1\nM99 P5\nX1\nN5 X5\nM30\n") == ["O1", "N5 X5", "M30"]
    assert plain("O1\nM98P2\nM30\nO2\nX1 M99\n") == ["O1", "X1", "M30"]


def test_a_program_that_begins_again_is_written_out_once():
    """B-64304EN, "Subprogram (M98, M99)": M99 in the main program goes back to its first block.
    What is written out goes back as well, if it would be the same text again: variables are
    followed through a second time to see that."""
    assert plain("O1\nX1\nM98P2\nM99\nO2\nX2\nM99\n") == ["O1", "X1", "X2", "M99"]
    assert plain("O1\n#1=5\nX#1\n#1=#1+1\nM99\n") == ["O1", "X5.", "M99"]


def test_arguments():
    show = "O9\n" + "".join(f"F[#{n}]\n" for n in range(1, 34)) + "M99\n"

    def local(call: str, **kw) -> dict[int, str]:
        lines = run(f"O1\n{call}\nM30\n{show}", **kw)
        return {
            line.source - 4: line.text[1:].decode() for line in lines if line.text.startswith(b"F")
        }

    # B-63684EN, "Mixture of argument specifications I and II": #1 1.0, #2 2.0, #4 -3.0, #7 5.0 (D
    # comes after the second I).
    assert local("G65 A1.0 B2.0 I-3.0 I4.0 D5.0 P9") == {1: "1.", 2: "2.", 4: "-3.", 7: "5."}
    letters = "ABCDEFHIJKMQRSTUVWXYZ"
    numbers = dict(
        zip(
            letters,
            (1, 2, 3, 7, 8, 9, 11, 4, 5, 6, 13, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26),
            strict=True,
        )
    )
    assert local("G65P9" + "".join(f"{x}{n}." for x, n in numbers.items())) == {
        n: f"{n}." for n in numbers.values()
    }
    assert local("G65P9" + "I1.J2.K3." * 10) == {n: f"{(n - 1) % 3 + 1}." for n in range(4, 34)}
    assert local("G65P9 K1. I2. J3.") == {6: "1.", 7: "2.", 8: "3."}
    # a vacant one stays so
    assert local("#5=7\nG65P9A#5B#6C[#5+1]".replace("\n", ";")) == {1: "7.", 3: "8."}
    assert local("G65P9X10D3", dialect="haas") == {24: "0.01", 7: "3."}  # least increments
    assert local("G65P9X10") == {24: "10."}
    # Haas 96-8000: "Local values are retained from repetition to repetition when the L address is
    # greater than 1".
    assert plain("O1\nG65P2L3A1.\nM30\nO2\nX#1\n#1=#1+1\nM99\n") == [
        "O1",
        "X1.",
        "X2.",
        "X3.",
        "M30",
    ]


def test_modal_calls():
    # B-64304EN, "Modal call (G66)": order of the sample of nested calls: 1-1 2-1 1-2 3-1 2-1 3-2
    # 2-1 1-3 2-1 1-4.
    text = "O1\nG66P2A1.\nG0X1.\nM8\nG4X1.\nG66P3\nX2.\nG67\nX3.\nG67\nX4.\nM30\nO2\nZ#1\n#1=#1+1\nM99\nO3\nX60.\nY70.\nM99\n"  # noqa: E501
    expected = "O1 G0X1. Z1. M8 G4X1. X2. X60. Z2. Y70. Z3. X3. Z4. X4. M30"
    assert plain(text) == expected.split()  # the argument is set once, by G66


# -- classic macros --------------------------------------------------------------------------------


def test_bolt_hole_circle():
    """B-64304EN, sample program of G65: holes on a circle of radius I from angle A by B, H of
    them."""
    macro = (
        "O9100\nWHILE[#11 GT"
        " 0]DO1\n#5=#24+#4*COS[#1]\n#6=#25+#4*SIN[#1]\nG1X#5Y#6\n#1=#1+#2\n#11=#11-1\nEND1\nM99\n"
    )
    found = places(plain("O2\nG65 P9100 X100.0 Y50.0 I100.0 A0 B45.0 H5\nM30\n" + macro))
    angles = [math.radians(45 * k) for k in range(5)]
    assert found == pytest.approx(
        np.array([(100 + 100 * math.cos(a), 50 + 100 * math.sin(a)) for a in angles]), abs=5.1e-4
    )


def test_ellipse():
    program = "O1\n#1=0\nWHILE[#1LE360]DO1\nG1X[50*COS[#1]]Y[30*SIN[#1]]\n#1=#1+2.5\nEND1\nM30\n"
    expected = [
        (50 * math.cos(math.radians(2.5 * k)), 30 * math.sin(math.radians(2.5 * k)))
        for k in range(145)
    ]
    found = places(plain(program))
    assert found == pytest.approx(np.array(expected), abs=5.1e-4)


def test_rectangular_pocket():
    """From the centre outwards, each round one step larger, the last at the wall."""
    macro = (
        "O9\n#10=#3*0.5\nN1 IF[#10 GT #1/2-#18]THEN"
        " #10=#1/2-#18\n#11=#10*#2/#1\nG1X-#10Y-#11\nG1X#10Y-#11\nG1X#10Y#11\nG1X-#10Y#11\nIF[#10"
        " GE #1/2-#18]GOTO 2\n#10=#10+#3\nGOTO 1\nN2 M99\n"
    )
    expected, x = [], 4.0
    while True:
        x = min(x, 60 / 2 - 5)
        y = x * 40 / 60
        expected += [(-x, -y), (x, -y), (x, y), (-x, y)]
        if x >= 25:
            break
        x += 8
    found = places(plain("O1\nG65P9A60.B40.C8.R5.\nM30\n" + macro))
    assert found == pytest.approx(np.array(expected), abs=5.1e-4)


def test_positions():
    setup = replace(MILL, offsets={"G54": {"X": 100.0, "Y": 0.0, "Z": -50.0}})
    text = (
        "G54 G90 G1 X10. Y5. Z2. F100\n#1=#5001\n#2=#5021\n#3=#5043\nX[#1+1] Y[#2+1] Z#3\nX#5221"
        " Z#5223\nX#5001\n"
    )
    assert plain(text, setup=setup)[1:] == ["X11. Y111. Z2.", "X100. Z-50.", "X100."]
    inch = "G20 G1 X1. F5\nX[#5001*2]Y#5021\n"
    assert plain(inch, setup=setup)[1:] == ["X2.Y4.937"]  # 1 inch + 100 mm = 4.93701 inch
    lathe = "G1 X30. Z-5. F0.1\nX[#5001+2] Z#5002\nX#5021\nW[#5022-1]\n"
    # diameters
    assert plain(lathe, dialect="fanuc-lathe", setup=LATHE)[1:] == ["X32. Z-5.", "X32.", "W-6."]


def test_modal_information():
    text = (
        "G1 G91 X1. F250\n#1=#4001\n#3=#4003\nG90 G0 X0\nG#1 G#3 X#4109\nG#4006 X#4012 F#4109\nG66"
        " P2\n#5=#4012\nG67\nX#5 Y#4115\n"
    )
    assert plain("O7\nG21 T12\n" + text + "X#4120\nM30\nO2\nM99\n")[4:] == [
        "G1 G91 X250.", "G21 X67. F250.", "X66. Y7.", "X12.", "M30",
    ]  # fmt: skip
    lathe = "G1 X1. Z1. F1\nG97\nX#4016 Z#4002\n"
    assert plain(lathe, dialect="fanuc-lathe", setup=LATHE)[2:] == ["X18. Z97."]


def test_alarm_and_message():
    error = refused(
        "O1\nIF[#1EQ#0]THEN#3000=1(NO DEPTH GIVEN)\n", "alarm #3000=1: NO DEPTH GIVEN", "p.nc:2"
    )
    assert error.place.start == 15
    assert plain("#3006=1(TURN THE PART)\nX1\n#3001=0\n") == ["(TURN THE PART)", "X1"]
    assert plain("POPEN\nN5 DPRNT[X#1[53]]\nBPRNT[O#1]\nPCLOS\nSETVN500[A]\nX1\n") == ["X1"]


@pytest.mark.parametrize(
    "block, message",
    [
        ("X#500", "only the control knows"),
        ("X#2001", "tool offset"),
        ("X#3001", "timer"),
        ("X#1000", "interface signal"),
        ("X#5061", "probe"),
        ("X#4119", "the last S is not followed"),
        ("X#4109", "no F has been given"),
        ("X#5241", "G55 is not stated"),
        ("X#5004", "no axis number 4"),
        ("X#40", "#40"),
        ("#0=1", "always vacant"),
        ("#5221=1", "work offset"),
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


def test_limits_and_the_place_of_a_fault():
    place = refused("O1\nN5 G1 X10. (ALL) Y[ 1 / #1 ]\n", "p.nc:2").place
    assert place.text[place.start - 1 : place.stop - 1] == "/ #1"
    refused("N1 GOTO 1\n", "1000 blocks have been executed (limit 1000)", limits=Limits(steps=1000))
    refused("O1\nM98P1\n", "nested 11 deep (limit 10)", limits=Limits(depth=10))
    assert len(run("X1\n" * 50, limits=Limits(steps=10))) == 50  # the text itself is never too long
    refused("#1=1\n" + "X1\n" * 50 + "GOTO 1\nN1 GOTO 1\n", "limit 53", limits=Limits(steps=10))


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
