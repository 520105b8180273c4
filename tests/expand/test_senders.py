"""Programs of GRBL's kin written out: what senders keep to themselves passes, and what they send on
behind the end is not lost."""

from __future__ import annotations

import pytest

from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup

SETUP = Setup(
    axes=("X", "Y", "Z"),
    least_increment=dict.fromkeys("XYZ", 1e-4),
    offsets={"G54": {}},
    start=dict.fromkeys("XYZ", 0.0),
)


def plain(text: str, name: str) -> list[str]:
    interpreter, limits = Interpreter(dialects.load(name), SETUP), Limits(steps=100, depth=8)
    written = Written(Program("a.nc", text.encode()), interpreter, limits, tolerance=1e-3)
    return b"".join(written).decode().splitlines()


@pytest.mark.parametrize("name", ["grblhal", "fluidnc"])
@pytest.mark.parametrize("line", ["%wait", "%X0=posx", "$X", "$#"])
def test_lines_of_a_sender_pass(name, line):
    text = f"G21 G90\n{line}\n#1=3\nO100 IF [#1 GT 2]\nG0 X[#1]\nO100 ENDIF\n{line}\nM30\n"
    assert plain(text, name) == ["G21 G90", line, "G0 X3.", line, "M30"]


def test_lines_of_a_sender_that_do_not_run_are_left_out():
    text = "O100 IF [1 GT 2]\n%wait\nO100 ENDIF\nG0 X1\nM2\n"
    assert plain(text, "grblhal") == ["G0 X1", "M2"]


def test_blocks_behind_the_end_stay_where_a_sender_sends_them_on():
    text = "#1=3\nG0 X[#1]\nM30\nG1 X50 F9\n(again)\nG0 Z1\n"
    for name in ("grblhal", "fluidnc"):
        assert plain(text, name) == ["G0 X3.", "M30", "G1 X50 F9", "(again)", "G0 Z1"]
    assert plain(text, "linuxcnc") == ["G0 X3.", "M30"]  # which reads nothing there
    subs = "O<a> CALL\nM30\nO<a> SUB\nG0 X1\nO<a> ENDSUB\n"
    assert plain(subs, "grblhal") == ["G0 X1", "M30"]
