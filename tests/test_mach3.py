"""Mach3's own words: units by G70 and G71, further fixtures by G59 P, G28.1, and what ends its
programs."""

from __future__ import annotations

import pytest

from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.units import TICKS_PER_MM

SETUP = Setup(
    axes=("X", "Y", "Z"),
    least_increment=dict.fromkeys("XYZ", 1e-4),
    offsets={"G54": {}, "G59": {"X": 100.0}},
    start={},
)


def follow(text: str):
    """Ends of the motions (mm, machine coordinates), and their reasons."""
    dialect = dialects.load("mach3")
    interpreter = Interpreter(dialect, SETUP)
    motions, _, _ = interpreter.run(
        lex(text.encode(), dialect.grammar, False), interpreter.initial()
    )
    return motions.target / TICKS_PER_MM, [motions.reasons[r][0] for r in motions.reason]


def test_g70_and_g71_are_units():
    ends, reasons = follow("G71G91.1G54\nG0X1Y2Z3\nG70\nG1X1F10\nG71X5\n")
    assert not any(reasons)
    assert ends[0].tolist() == pytest.approx([1.0, 25.4, 5.0])


def test_g20_and_g70_in_one_block_are_two_of_a_group():
    with pytest.raises(Exception, match="two codes of the modal group 'units'"):
        follow("G70G21\n")


def test_a_further_fixture_is_refused_and_g59_itself_is_not():
    _, reasons = follow("G59\nG0X1Y2Z3\n")
    assert not any(reasons)
    _, reasons = follow("G59P20\nG0X1Y2Z3\n")
    assert reasons[-1] == "G59 P20 is one of the control's further work offsets"
    _, reasons = follow("G59P20\nG0X1Y2Z3\nG59\nG0X2Y3Z4\n")
    assert not reasons[-1]


def test_behind_g28_1_nobody_knows_where_the_axes_stand():
    dialect = dialects.load("mach3")
    interpreter = Interpreter(dialect, SETUP)
    text = b"G54\nG0X1Y2Z3\nG28.1X0Y0\n"
    _, state, _ = interpreter.run(lex(text, dialect.grammar, False), interpreter.initial())
    assert not state.known[0] and not state.known[1]


def test_subprograms_behind_the_end_are_written_out():
    text = b"%\n(part)\nG71G90G54\nG0X0Y0Z0\nM98 P100 L2\nM30\nO100\nG91\nG1X5F100\nG90\nM99\n%\n"
    interpreter = Interpreter(dialects.load("mach3"), SETUP)
    lines = b"".join(Written(Program("part.tap", text), interpreter, Limits())).decode().split("\n")
    assert lines.count("G1X5F100") == 2
    assert lines[:3] == ["%", "(part)", "G71G90G54"]
