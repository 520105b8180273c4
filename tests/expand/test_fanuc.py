"""Jumps, loops, subprograms and macros of Fanuc and Haas: what the manuals' sample programs print,
and what was worked out by hand."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from postproc.nc import dialects
from postproc.nc.lexer import lex
from tests.expand.fanuc_lines import LATHE, MILL, plain, refused, run, value


def places(lines: list[str]) -> np.ndarray:
    rows = [re.findall(r"[XY](-?[\d.]+)", line) for line in lines if line.startswith("G1X")]
    return np.array(rows, float)


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


def test_work_offsets_are_written():
    """B-64484EN, "Workpiece zero point offset values": #5221 on are G54, #5201 on the external one,
    #7001 on G54.1 P1, #14021 on P2. Where the machine stands (#5021) is worked out by hand."""
    setup = replace(MILL, offsets={"G54": dict.fromkeys("XYZ", 0.0), "EXT": {"X": 0.5}})
    text = (
        "G54 G90 G1 X10. Y5. Z2. F100\n#5221=#5221+5.\nX10.\nY#5021\n"  # 10 + 5 + 0.5
        "#5201=1.5\nX10.\nY#5021\n"  # + 1.5
        "#[7000+1]=100.\n#7002=2.\n#7003=3.\nG54.1 P1 X10.\nY#5021 Z#7001\n"  # 10 + 100 + 1.5
        "#14021=-7.\n#14022=0\n#14023=-3.\nG54.1 P2 X10.\nY#5021\n"  # 10 - 7 + 1.5
    )
    assert plain(text, setup=setup)[1:] == [
        "G10 L2 P1 X5.", "X10.", "Y15.5", "G10 L2 P0 X1.5", "X10.", "Y16.5",
        "G10 L20 P1 X100.", "G10 L20 P1 Y2.", "G10 L20 P1 Z3.", "G54.1 P1 X10.", "Y111.5 Z100.",
        "G10 L20 P2 X-7.", "G10 L20 P2 Y0.", "G10 L20 P2 Z-3.", "G54.1 P2 X10.", "Y4.5",
    ]  # fmt: skip
    lathe = "#5221=4.\nG1 X30. Z-5. F0.1\nZ#5021\n"  # diameters
    assert plain(lathe, dialect="fanuc-lathe", setup=LATHE)[2:] == ["Z34."]
    assert plain("G20\n#5242=1/3\n")[1:] == ["G10 L2 P2 Y0.3333"]
    haas = "#7001=1.\n#7002=2.\n#7003=0\nG110 G90 G1 X10. Y5. Z2. F100\nZ#5021\nG154 P1\nX#5022\n"
    assert plain(haas, dialect="haas")[4:] == ["Z11.", "G154 P1", "X7."]  # G110 is G154 P1
    refused("#5201=1", "G52", dialect="haas")


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
    assert plain("#100=#3901\n#3901=#3901+1\nX1\n#101=#3020-#100\n") == ["X1"]
    assert plain("#3006=1(TURN THE PART)\nX1\n#3001=0\n") == ["(TURN THE PART)", "X1"]
    draws = "[BILLET X100 Y80 Z30\n[edgemove X-5 Y-2\n[TOOLDEF T1 D6.000"
    assert plain(draws + "\n#1=2\nX#1\n") == [*draws.split("\n"), "X2."]
    assert plain("[BILLET X60 Z9\n(A)\nO1\n#1=2\nX#1\nM2\n")[3] == "X2."  # before its O number
    assert plain("POPEN\nN5 DPRNT[X#1[53]]\nBPRNT[O#1]\nPCLOS\nSETVN500[A]\nX1\n") == ["X1"]


@pytest.mark.parametrize("name", ["fanuc-mill", "fanuc-lathe-a"])
def test_what_a_simulation_draws_holds_no_words(name):
    """Blank, tool and datum of Denford's software (its QuickCAM posts write them)."""
    text = b"[BILLET X3 Y5.Z.75\nG0 X1.\n [TOOLDEF T05 D6.0\n[billet x52 z31;\n"
    words = lex(text, dialects.load(name).grammar, False)
    assert words.fault is None
    assert bytes(words.letter).decode() == "GX"


def test_the_last_speed_is_read():
    """#4119, B-64304EN "Custom macro", "Modal information": of the blocks before this one."""
    text = (
        "O1\nS1200 M3\nG1 X1. F100\nIF[#4119GE1000]GOTO2\nX9.\nN2 S[#4119/2] X2.\nM98 P2\nM30\n"
        "O2\nS#4119 X3.\nM99\n"
    )
    assert plain(text)[1:] == [
        "S1200 M3",
        "G1 X1. F100",
        "N2 S600 X2.",
        "S600 X3.",
        "M30",
    ]
    assert "S7" in plain("O1\nS7\n#100=#4119\nM5\nX#5001\nS#100\nM30\n")
