"""Several statements in one block of a Haas, each example from its mill operator's manual (2017),
"Macros", or by hand."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from postproc.nc.expand.fanuc_statements import parts
from tests.expand.fanuc_lines import plain

HEAD = "O1\n"


def haas(text: str, **options) -> list[str]:
    return [line for line in plain(HEAD + text, "haas", **options)[1:] if line.strip()]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        # "The GOTO is executed after any other commands"
        ("G0 X1. GOTO20\nG0 X5.\nN20 G0 X3.\nM30", ["G0 X1.", "N20 G0 X3.", "M30"]),
        # "the conditional is for the M99 portion of the statement only"
        (
            "#1=0\nN5 #1=#1+1\nG00 X#1 Y0 [#1 LT 3] M99 P5\nM30",
            ["G00 X1. Y0", "G00 X2. Y0", "G00 X3. Y0", "M30"],
        ),
        # "set variable #101 to zero and return from the subprogram"
        (
            "#101=7.\nG65 P2 A180.\nG65 P2 A9.\nG0 X#101\nM30\nO2\n"
            "IF [#1 GE 180] THEN #101=3.0 M99\nG0 Y#1\nM99",
            ["G0 Y9.", "G0 X3.", "M30"],
        ),
        # a loop with its first assignments in the block of DO
        (
            "#1=0\nWHILE [#1 GT -5.] DO1 #1= #1 - 3. IF [#1 LT -5.] THEN #1= -5.\n"
            "G1 Z#1\nEND1 G0 Z9.\nM30",
            ["G1 Z-3.", "G1 Z-5.", "G0 Z9.", "M30"],
        ),
        # "if a conditional evaluates to FALSE, then the remainder of the IF block is ignored"
        ("#1=1. IF [#1 GT 5] THEN #1=2. #1=3.\nG0 X#1\nM30", ["G0 X1.", "M30"]),
        ("#1=9. IF [#1 GT 5] THEN #1=2. #1=#1+1.\nG0 X#1\nM30", ["G0 X3.", "M30"]),
        ("#1=1. #2=#1+1. G0 X#2 (TWO)\nM30", ["G0 X2. (TWO)", "M30"]),
        ("N7 #1=1. GOTO9\nG0 X5.\nN9 G0 X#1\nM30", ["N9 G0 X1.", "M30"]),
    ],
)
def test_statements_run_one_after_the_other(text, wanted):
    assert haas(text) == wanted


def test_a_marked_block_is_marked_in_all_its_statements():
    assert parts(b"/ #1=1. G0 X#1", "end of block") == [b"/ #1=1.", b"/G0 X#1"]


@pytest.mark.parametrize(
    "text",
    ["#1=1.", "G0 X#1 Y[#2+1.] (A)", "IF [#1 EQ 2] GOTO 5", "#1=1. )", "WHILE [#1 LT 2] DO1"],
)
def test_other_blocks_stay_whole(text):
    assert parts(text.encode(), "end of block") == [text.encode()]


def test_a_fanuc_has_one_statement_to_a_block():
    with pytest.raises(ProgramError, match="behind the statement"):
        plain(HEAD + "#1=1. #2=2.\nM30", "fanuc-mill")
