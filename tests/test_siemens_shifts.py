"""G58 and G59 of Sinumerik beside TRANS and ATRANS, by hand from "Axial work offset (G58, G59)" of
the NC programming manual: G58 replaces what TRANS gave of an axis, G59 what ATRANS added to it."""

from __future__ import annotations

from pathlib import Path

import pytest

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.units import TICKS_PER_MM

DIALECT = dialects.load("siemens")
SETUP = Setup(
    axes=("X", "Y", "Z"),
    least_increment=dict.fromkeys("XYZ", 1e-4),
    start=dict.fromkeys("XYZ", 0.0),
    offsets={"G54": {}},
)


def follow(text: str):
    """Where the last block goes (mm, machine coordinates), and why it can not be followed."""
    interpreter = Interpreter(DIALECT, SETUP)
    words = lex(
        f"G54 G90\n{text}\nG0 X1 Y2 Z3\n".replace("|", "\n").encode(), DIALECT.grammar, False
    )
    assert words.fault is None
    motions, _, _ = interpreter.run(words, interpreter.initial())
    return (motions.target[:, -1] / TICKS_PER_MM).tolist(), " ".join(
        motions.reasons[motions.reason[-1]]
    )


@pytest.mark.parametrize(
    ("text", "ends"),
    [
        ("G58 X5", [6, 2, 3]),
        ("TRANS X10 Y20|G58 X5", [6, 22, 3]),
        ("TRANS X10 Y20|G59 X5", [16, 22, 3]),
        ("G58 X5 Z-1|ATRANS X1 Y1", [7, 3, 2]),
        ("G58 X5|G58 Y6", [6, 8, 3]),
        ("G58 X5|TRANS Y1", [1, 3, 3]),
        ("ATRANS X5|TRANS|G58 X7", [8, 2, 3]),
        ("G59 X5|ROT|G58 X7", [8, 2, 3]),
    ],
)
def test_shifts_of_single_axes(text, ends):
    assert follow(text) == (ends, " ")


@pytest.mark.parametrize("text", ["ATRANS X5|G58 X7", "G59 X5|G59 X6", "TRANS X1|ATRANS Y2|G58 X3"])
def test_what_part_is_replaced_of_a_shift_in_parts_is_not_distinguished(text):
    assert "write TRANS and ATRANS" in follow(text)[1]
    assert follow(text + "|TRANS X1") == ([2, 2, 3], " ")


@pytest.mark.parametrize("call", ["", '(0,"",0,57,0,0,0,0,0,0,0,0,0,1)', '(0,"",0,57)'])
def test_a_level_plane_is_none_without_rotary_axes(call):
    """CYCLE800 with neither turn nor shift; with either it is refused here."""
    assert follow(f"TRANS X1|CYCLE800{call}") == ([2.0, 2.0, 3.0], " ")
    for wrong in ("0,0,1,0,0,0", "0,0,0,0,0,10"):
        _, why = follow(f'CYCLE800(0,"",0,57,{wrong},0,0,0,1)')
        assert "the machine has no rotary axes" in why


def test_a_line_alone_that_can_not_be_read_is_refused_as_among_others():
    """A batch of which nothing is left but the fault, behind a change of tool."""
    machine = read_machine(Path(__file__).parents[1] / "machines" / "example-mill")
    words = []
    for lines in ([b"T01M06\n", b"(KANAV4IST_1)\n"], [b"T01M06\n(KANAV4IST_1)\n"]):
        filter_ = Filter(machine, dialects.load("siemens"), setup_of(machine))
        with pytest.raises(ProgramError) as fault:
            for line in lines:
                filter_.feed(line)
            filter_.finish()
        words.append(str(fault.value))
    assert words[0] == words[1] and ":2: a comment is opened" in words[0]
