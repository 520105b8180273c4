"""Heidenhain, DIN/ISO: a cycle's definition passes with its Q values; what moves where it is
defined does not."""

from __future__ import annotations

import pytest
from fuzz.cases import Case, filter_of
from fuzz.laws import broken, outcome

from postproc.nc import dialects
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.units import TICKS_PER_MM

SETUP = Setup(
    axes=("X", "Y", "Z"),
    least_increment=dict.fromkeys("XYZ", 1e-4),
    offsets={"G54": {}, "T1": {}},
    start=dict.fromkeys("XYZ", 0.0),
)
HEAD = "%PART G71 *|N10 G00 G40 G90 X+0 Y+0 Z+50 *|"


def follow(program: str):
    """X of the ends of the motions (mm), and why they can not be followed."""
    dialect = dialects.load("heidenhain-iso")
    interpreter = Interpreter(dialect, SETUP)
    words = lex((HEAD + program).replace("|", "\n").encode() + b"\n", dialect.grammar, False)
    assert words.fault is None, words.fault
    motions, _, _ = interpreter.run(words, interpreter.initial())
    return (motions.target[0] / TICKS_PER_MM).tolist(), [
        motions.reasons[r][0] for r in motions.reason
    ]


def test_a_motion_behind_the_definition_of_a_cycle_is_read():
    ends, reasons = follow("N20 G200 Q200=+2 Q201=-15 Q206=+250 * N30 G01 X+10 F500 *|N40 X+20 *")
    assert ends == [0.0, 10.0, 20.0]
    assert not any(reasons)


@pytest.mark.parametrize(
    "cycle",
    [
        "G220 Q216=+50 Q217=+50 Q244=80",
        "G221 Q225=+15 Q226=+15",
        "G224 Q301=+1",
        "G238",
        "G239 Q570=+0",
    ],
)
def test_what_moves_where_it_is_defined_is_refused(cycle):
    """Cycles 220, 221 and 224 act without a call (TNC7 user's manual, machining cycles), and 239;
    of 238 and 246 nothing was found, and to refuse is the safe side."""
    _, reasons = follow(f"N20 {cycle} *|N40 G01 X+20 F100 *")
    assert cycle[:4] in "".join(reasons)


def test_an_oversize_of_the_radius_in_a_tool_call_moves_nothing():
    """T1 G17 S2000 DR+1 (iTNC 530 user's manual, DIN/ISO, "Tool call data": delta values)."""
    ends, reasons = follow("N20 T1 G17 S2000 DR+1 DR2-0.1 *|N30 G01 X+10 F500 *")
    assert ends == [0.0, 10.0]
    assert not any(reasons)


CORNERS = ["G30 *", "G30 G17 X+0 Y+0 Z-40 *|N16 G31 G90 X+100 Y+60 Z+0 *|N17 G91 *"]


@pytest.mark.parametrize("blank", CORNERS)
def test_the_corners_of_the_blank_move_nothing(blank):
    """G30 is no reference point here: an axis that rests behind it has its lost motion as before
    ("Define the blank", DIN/ISO)."""
    text = "%P G71 *|N10 G91 G1 X+2 Z+1.7 F200 *|{}N20 G90 G0 Y-8.9 Z-35 *|N30 G1 Y+4 *|N40 X+1 *|"
    answers = []
    for between in ("", f"N15 {blank}|"):
        case = Case(text.format(between).replace("|", "\n").encode(), "heidenhain-iso", "two-way")
        assert broken(case) == ""
        answers.append(outcome(filter_of(case), [case.text])[0].splitlines())
    said = {line.encode() for line in f"N15 {blank}".split("|")}
    assert answers[0] == [line for line in answers[1] if line not in said]
