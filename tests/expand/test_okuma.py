"""Okuma's user tasks, run: each program by hand, as the manual's pages (5238-E) say it goes."""

from __future__ import annotations

from dataclasses import replace

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.okuma_expressions import Expression
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from tests.expand.plain_lines import LATHE, MILL

SETUP = replace(LATHE, axes=("X", "Z"), start={"X": 0.0, "Z": 0.0})


def written(text: str, dialect: str = "okuma-lathe", library=None, setup=SETUP) -> str:
    files = {name: t.replace("|", "\n").encode() for name, t in (library or {}).items()}
    program = Program("part", text.replace("|", "\n").encode() + b"\n", files.get)
    interpreter = Interpreter(dialects.load(dialect), setup)
    lines = b"".join(Written(program, interpreter, Limits(steps=500))).decode().splitlines()
    return "|".join(lines)


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        # three times round, then on
        (
            "V1=0|N1 G0 X=20+V1 Z5|V1=V1+1|IF [V1 LT 3] N1|G0 X90|M2",
            "N1 G0 X20 Z5|N1 G0 X21 Z5|N1 G0 X22 Z5|G0 X90|M2",
        ),
        ("V1=3|IF [V1 EQ 3] GOTO N9|X1|N9 X2|M2", "N9 X2|M2"),
        ("V1=4|IF[V1 EQ 3] N9|X1|N9 X2|M2", "X1|N9 X2|M2"),
        ("GOTO N02|N2 X1|N02 X2|M2", "N02 X2|M2"),  # names are text
        # the subprogram's name and RTS stay out; its variable is gone behind it
        (
            "G0 X5|CALL O2 Q2 DIA1=40 ZL1=-20|IF DIA1 N9|X7|N9 M2|O2|G1 X=DIA1+2 Z=ZL1|RTS",
            "G0 X5|G1 X42 Z-20|G1 X42 Z-20|X7|N9 M2",
        ),
        ("CALL O2 PX=1|$ PZ=2|M2|O2|X=PX Z=PZ|RTS", "X1 Z2|M2"),
        ("IF [PX NE EMPTY] N1|PX=7|N1 X=PX|M2", "N1 X7|M2"),
        # behind every motion, and not behind its own
        (
            "MODIN O2|G0 X5|M8|Z3|MODOUT|X9|M2|O2|G91 G1 X1|X-1 G90|RTS",
            "G0 X5|G91 G1 X1|X-1 G90|M8|Z3|G91 G1 X1|X-1 G90|X9|M2",
        ),
        # a block that goes on behind $ is one motion; setting a zero is none
        ("MODIN O2|G0 X5|$ Z3|G92 X1|M2|O2|M8|RTS", "G0 X5 Z3|M8|G92 X1|M2"),
        ("MODIN O2|G1 F9|$ Z3|$X1|G92|$X1|M2|O2|M8|RTS", "G1 F9 Z3 X1|M8|G92 X1|M2"),
        # words, comments, and what has a plain number behind =
        ("V3=5|X=-V3 Z = V3*2 SB=1200 F=.1(X=V9)|M2", "X-5 Z10 SB=1200 F.1(X=V9)|M2"),
        ("V3=1|T=100+V3|M2", "T0101|M2"),
        ("$A-1.MIN%|O1|X1|M02|%", "$A-1.MIN%|O1|X1|M02|%"),
        # what stands behind the end is not run
        ("X1|M2|O3|X9|RTS", "X1|M2"),
    ],
)
def test_a_program_runs(text, plain):
    assert written(text) == plain


def test_a_subprogram_in_a_file_of_its_own_calls_those_beside_it():
    library = {"O7": "O7|CALL O8|RTS|O8|X=PX|RTS"}
    assert written("CALL O7 PX=5|M2", library=library) == "X5|M2"


SHAPE = "NLAP1 G81|G0 X=V1-10 Z2|G1 Z-20 F.2|X=V1|Z=-V1|G80|"
NUMBERS = "NLAP1 G81|G0 X30 Z2|G1 Z-20 F.2|X40|Z-40|G80|"
CALLS = "G0 X50 Z5|G85 NLAP1 D4 F.35 U.2 W.1|G87 NLAP1|"


def test_the_numbers_of_a_shape_are_worked_out_where_the_program_comes_to_it():
    assert written("V1=40|" + SHAPE + CALLS + "M2") == written(NUMBERS + CALLS + "M2")


def test_a_shape_of_a_subprogram_has_the_numbers_of_each_call():
    text = "CALL O2 DX=30|CALL O2 DX=32|M2|O2|NLAP1 G81|G0 X=DX Z2|G1 Z-20|G80|G0 X50 Z5|{}RTS"
    plain = "".join(
        f"NLAP{n} G81|G0 X{x} Z2|G1 Z-20|G80|G0 X50 Z5|G87 NLAP{n}|" for n, x in ((1, 30), (2, 32))
    )
    assert written(text.format("G87 NLAP1|")) == written(plain + "M2")


def test_a_shape_whose_numbers_have_changed_before_its_call_is_refused():
    with pytest.raises(ProgramError, match="line 3 of the shape has other numbers here"):
        written("V1=40|" + SHAPE + "V1=38|" + CALLS + "M2")
    after = "G0 X9|V1=40|" + CALLS + "GOTO N9|" + SHAPE + "N9 M2"  # never come to
    with pytest.raises(ProgramError, match="is more than words and numbers"):
        written(after)


def test_a_mill_runs_the_same():
    """MachinistFTW/OkumaMacros, OROTA.SSB: EMPTY, sines in degrees."""
    text = "PA=30|IF[PP NE EMPTY] NX|PP=40|NX|G0 X=PP*COS[PA*2] Y=PP*SIN[PA]|M2"
    assert written(text, "okuma", setup=MILL) == "NX|G0 X20 Y20|M2"


def test_a_block_that_is_deleted_says_nothing():
    off = replace(SETUP, block_delete=True)
    assert written("V1=1|/V1=2|X=V1|M2", setup=off) == "/V1=2|X1|M2"
    assert written("V1=1|/V1=2|X=V1|M2") == "X2|M2"


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2+3*4", 14),
        ("[2+3]*4", 20),
        ("-V1+1", -4),
        ("SQRT[V1*V1+144]", 13),
        ("SIN[30]+COS[60]", 1),
        ("ATAN[1]", 45),
        ("MOD[17,5]", 2),
        ("ROUND[2.5]", 3),
        ("FIX[2.9]", 2),
        ("FUP[2.1]", 3),
        ("ABS[-3]", 3),
    ],
)
def test_an_expression_by_hand(text, value):
    assert Expression(text, {"V1": 5.0}).first() == (pytest.approx(value), len(text))


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("[V1 EQ 5]", True),
        ("[V1 NE 5]", False),
        ("[V1 GT 4]", True),
        ("[V1 GE 5.1]", False),
        ("[V1 LT 5]", False),
        ("[V1 LE 5]", True),
        ("[[V1 LT 5] OR [V1 GT 4]]", True),
        ("[V1 GT 4 AND V1 GT 9]", False),
        ("[NOT [V1 GT 9]]", True),
        ("[[V1+1] EQ 6]", True),
        ("[PX EQ EMPTY]", True),
    ],
)
def test_a_condition_by_hand(text, holds):
    assert Expression(text, {"V1": 5.0}).holds() == (holds, len(text))


@pytest.mark.parametrize(
    "text",
    [
        "ATAN2[1,2]",  # which number is first is not said
        "DROUND[1.5]",
        "FIX[-1.5]",
        "FIX[SIN[30]*2]",  # whole but for rounding
        "FUP[2.3*100]",
        "V2",
        "VZOFZ[1]",
        "1/0",
        "[" * 300 + "1" + "]" * 300,
        "",
    ],
)
def test_what_is_not_known_gives_no_number(text):
    with pytest.raises(ProgramError):
        written(f"X={text}|M2")


def test_a_variable_that_noex_sets_is_not_known():
    with pytest.raises(ProgramError, match="V1 has no value"):
        written("V1=1|NOEX V1=2|X=V1|M2")


def test_the_variables_of_the_control_stay_and_are_refused_in_place():
    assert written("VZOFZ[1]=10|M2") == "VZOFZ[1]=10|M2"
