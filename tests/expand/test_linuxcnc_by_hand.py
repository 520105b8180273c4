"""Values and text of LinuxCNC programs written out, by hand."""

from __future__ import annotations

import math
import re

import pytest

from tests.expand.linuxcnc_lines import run, texts, value
from tests.linuxcnc import oracle


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("2+3*4", 14),
        ("2**3**2", 64),
        ("-2**2", 4),
        ("7-2-3", 2),
        ("24/4/2", 3),
        ("1+1 EQ 2", 1),
        ("1 OR 0 AND 0", 0),
        ("-7 MOD 4", 1),
        ("7 MOD -4", 3),
        ("9+8*7/6+5-4*3**2+1", -35 / 3),
        ("SIN[30]", 0.5),
        ("COS[90] LT 0", 1),
        ("ATAN[1]/[-1]", 135),
        ("FIX[-2.5]", -3),
        ("FUP[-2.5]", -2),
        ("ROUND[2.5]", 3),
        ("ROUND[-2.5]", -3),
        ("FIX[SIN[30]*2]", 1),
        ("SQRT[2]", math.sqrt(2)),
        ("SQRT[0]", 0),
        ("ASIN[-1]", -90),
        ("ASIN[1]", 90),
        ("ACOS[-1]", 180),
        ("LN[EXP[1]]", 1),
        ("1 EQ 1.00009", 1),
        ("1 LE 0.99999", 0),
        ("--5", 5),
        ("-+-[3]", 3),
        ("2 - -3", 5),
        ("EXISTS[#<no>]", 0),
        ("EXISTS[#5602]", 0),
        ("#5599", 1),
        ("ABS[-.5]", 0.5),
    ],
)
def test_expressions(expression, expected):
    assert value(expression) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("G1 X[1+1] Y2 (a #1) ; [b", "G1 X2. Y2 (a #1) ; [b"),
        ("g 1 x [ 1 / 4 ] Y.50", "g 1 x 0.25 Y.50"),
        (
            "N10 G[0] M[3] T[2] S[500] F[1.5] H[1] D[2] P[3] L[4] X-[0]",
            "N10 G0 M3 T2 S500. F1.5 H1 D2 P3 L4 X0.",
        ),
        ("G[59.1] P[0.5] D[1.5] X[1/3]", "G59.1 P0.5 D1.5 X0.33333333"),
        ("#1=5 G0 X[1]", "G0 X1."),
        ("G0 X[1] #1=5", "G0 X1."),
        ("G0 #1=5 X[1] (c)", "G0 X1. (c)"),
        ("G0 X[1] #1=5 (c)", "G0 X1. (c)"),
        ("/N5 #1=5 X[1]", "/N5 X1."),
        ("X1#1=5Y[1]", "X1Y1."),
        ("G0 X--5 Y+-[2]", "G0 X5. Y-2."),
        ("#1=1 (msg, hello)", "(msg, hello)"),
        ("M#9 P[1]", "M0 P1"),
        ("(debug, #1 [2]) ;#3", "(debug, #1 [2]) ;#3"),
        ("G4 P[2.25]", "G4 P2.25"),
        ("X[1]\r", "X1."),
        ("G10 L2 P1 X5 ( kept  as is )", "G10 L2 P1 X5 ( kept  as is )"),
        ("", ""),
        ("\t", "\t"),
    ],
)
def test_text_that_is_no_expression_stays(line, expected):
    assert texts(line + "\nM2") == [expected, "M2"]


@pytest.mark.parametrize(
    "line", ["#1=5", "N10 #1=5 #<a>=2 (set)", "o1 if [1] (c)", "/#1=3 ; c", "o100 sub\no100 endsub"]
)
def test_lines_of_no_words_vanish(line):
    assert texts(line) == []


def test_lines_know_where_they_come_from():
    text = "%\nG0 X1\no<a> call [2]\no1 repeat [2]\nY1\no1 endrepeat\nM2\nX9\n%\n"
    found = run(text, library={"a": b"o<a> sub\n(in a)\nX#1\no<a> endsub\n"})
    assert [(line.source, line.file) for line in found] == [
        (1, ""), (2, ""), (2, "a.ngc"), (3, "a.ngc"), (5, ""), (5, ""), (7, ""), (9, ""),
    ]  # fmt: skip


def test_plain_programs_are_passed_on_unchanged():
    for path in sorted(oracle.PROGRAMS.glob("*.ngc")):
        text, kwargs = oracle.load(path)
        if re.search(r"#|\[|o\s*\d|o\s*<|m\s*(9[89]|7[0-3])", text, re.IGNORECASE):
            continue  # something to run
        all_lines = [
            line for line in text.replace("\r", "").rstrip("\n").split("\n") if line.strip() != "%"
        ]
        found = [line for line in texts(text, kwargs=kwargs) if line.strip() != "%"]
        assert found == all_lines[: len(found)], path.stem
        assert (
            len(found) == len(all_lines)
            or "%" in text
            or "M2" in found[-1].upper()
            or "M30" in found[-1].upper()
        ), path.stem


def test_skipped_lines_are_not_executed():
    kwargs = {"block_delete": True}
    assert texts("#1=1\n/#1=2\n/G0 X9 (c)\n/ X#1\n/M2\n/o1 if [0]\nX#1\n", kwargs=kwargs) == [
        "/#1=2", "/G0 X9 (c)", "/ X#1", "/M2", "/o1 if [0]", "X1.",
    ]  # fmt: skip
    assert texts("#1=1\n/#1=2\n/ X#1\n") == ["/ X2."]


def test_position_behind_the_tape_mark():
    assert texts("%\nG0 X5\nX[#5420+1]\n#1=#<_x>\nY#1\n%\n") == ["%", "G0 X5", "X6.", "Y6.", "%"]


def test_task_is_the_machine():
    """Programs ask #<_task> whether they run on the machine or are only shown; what is written out
    will run there."""
    assert value("#<_task>") == 1


def test_tool_offset_in_force():
    text = "X#<_tool_offset>\nT1 M6 G43\nX#<_tool_offset>\nG49\nX#<_tool_offset>"
    assert texts(text, kwargs={"tools": {1: {"Z": 5.0}}})[::2] == ["X0.", "X1.", "X0."]


def test_reference_points_that_are_stated():
    assert texts("X#5161 Y#5182 Z#5163", kwargs={"parameters": {5161: 7.0, 5182: 8.0}}) == [
        "X7. Y8. Z0."
    ]


def test_reach_of_a_written_number_is_the_least_increment_and_the_unit():
    assert texts("X[1/3] F[1/3]\nG20 X[1/3]\nX[1/3]\nG21\nX[1/3]") == [
        "X0.33333333 F0.333333", "G20 X0.33333333", "X0.333333333", "G21", "X0.33333333",
    ]  # fmt: skip


def test_name_with_a_folder():
    assert texts("o<cycles/a> call [3]\n", library={"a": b"o<a> sub\nX#1\no<a> endsub\n"}) == [
        "X3."
    ]
