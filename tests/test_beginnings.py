"""How programs begin and end that nobody wrote for a test: no motion code, M99, words that a
firmware passes over."""

from __future__ import annotations

import re

import pytest

from postproc import intake
from postproc.errors import ProgramError
from tests.test_printers import filtered, refused, written

HEAD = "G90\nG0 X10. Y10. Z5.\n"


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas"])
def test_fanucs_begin_in_g0(dialect):
    """B-64304EN-2, "G code list": G00, or G01 by parameter 3402, which ends at the same place; Haas
    96-8210: G00 has the asterisk. G80 ends a cycle, a group of its own: it takes no G0 to G3
    back."""
    named = written("G90 G80\nG0 X10. Y10. Z5.\nG1 X20. F100.\nM30\n", dialect)
    bare = written("G90 G80\nX10. Y10. Z5.\nG80\nG1 X20. F100.\nG80\nX30.\nM30\n", dialect)
    assert bare[1].removeprefix("G0 ") == named[1].removeprefix("G0 ").replace("G0", "")
    assert bare[-2].startswith("X29.") or bare[-2].startswith("X30.0")


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas"])
def test_m99_in_the_main_program_ends_it(dialect):
    """The control goes back to the first block: nothing behind it is reached, but behind a /M99, as
    the switch may be on."""
    lines = written(HEAD + "G1 X20. F100.\n/M99\nX30.\nM99\nX40.\n", dialect)
    assert lines[-1] == "X40."
    assert lines[-2] == "M99" and lines[-3] != "X30." and lines[-3].startswith(("X29.", "X30."))


def test_marlin_passes_over_words_without_a_command():
    """Marlin/src/gcode/parser.cpp: without GCODE_MOTION_MODES a line that begins with an axis
    letter is no command; with it, it moves: no place is known behind it. Words behind G90 G91 G21
    mean nothing to these."""
    home = {"X": 0.0, "Y": 0.0, "Z": 0.0}
    text = "G28\nG90 E0\nG1 X10 Y10 Z5 F600\nG1 X20\n"
    lines = written(text, "marlin", home)
    assert "G90 E0" in lines
    assert written(text.replace(" E0", ""), "marlin", home)[2:] == lines[2:]
    filter_ = filtered(text + "Z10\nG1 X30\n", "marlin", home)[0]
    assert any("no axis has a known place" in n.message for n in filter_.notices)


def test_grbl_answers_a_question_mark():
    """gnea/grbl, grbl/serial.c: ? and ~ are picked out of the stream, they are no part of a
    line."""
    home = {"X": 0.0, "Y": 0.0, "Z": 0.0}
    assert written("?  \n$H\nG0 X10 Y10 Z5\n~\nG1 X20 F100\n", "grbl", home)[0] == "?  "


@pytest.mark.parametrize(
    "text",
    [
        "G91\nG0 X5\nX5\n",
        "G91 F100\nG1 X5\nY5\n",
        "G91 G18 F100\nG2 X5 I2.5\n",
        "F9\nG92 X0 Y0 Z0\nG91 G1 X9\n",
    ],
)
@pytest.mark.parametrize("dialect", ["linuxcnc", "grbl", "fanuc-mill"])
def test_the_first_increments_count_from_where_the_slides_stand(dialect, text):
    """A feed 5 mm long that begins at X100 is 5 mm long, not 105."""
    lines = written(text, dialect, start={"X": 100.0, "Y": 100.0, "Z": 100.0})
    numbers = [abs(float(x)) for x in re.findall(r"[XYZ](-?[\d.]+)", " ".join(lines))]
    assert max(numbers) < 10 and len(numbers) > 3


def test_marlin_passes_over_a_remark_behind_two_strokes():
    """Marlin/src/gcode/parser.cpp, parse(): a sign that is no letter is no parameter, a letter
    without a number has no value; a word in the remark would be one."""
    home = {"X": 0.0, "Y": 0.0, "Z": 0.0}
    lines = written(
        "G28\nG1 X10 Y10 Z5 F600\nG1 X20 // Protect bed, then go\nG1 Z9\n", "marlin", home
    )
    plain = written("G28\nG1 X10 Y10 Z5 F600\nG1 X20\nG1 Z9\n", "marlin", home)
    assert [x.replace(" // Protect bed, then go", "") for x in lines] == plain and lines != plain
    said = refused("G28\nG1 X10 Y10 Z5 F600\nG1 X20 // to X 30\n", "marlin", home)
    assert "'//' begins no remark" in said.message


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas"])
@pytest.mark.parametrize(("under", "moves"), [("G0", "G0"), ("G1", "G1")])
def test_g80_brings_back_the_motion_code_that_held_under_the_cycle(dialect, under, moves):
    """B-64304EN-2, "Canned cycle for drilling": "a group 01 G code is not affected by a canned
    cycle"."""
    text = f"{HEAD}G1 X11. F9.\n{under} X12.\nG81 X20. Z-1. R2.\nX25.\nG80\nX30.\nX31.\nM30\n"
    named = written(text.replace("X30.", f"{moves} X30."), dialect)
    bare = written(text, dialect)
    assert [x.replace(" ", "") for x in bare] == [x.replace(" ", "") for x in named]


@pytest.mark.parametrize("head", ["", "%\n"])
def test_a_percent_sign_behind_blocks_ends_the_program(head):
    """LinuxCNC, docs/src/gcode/overview.adoc, "File Requirements": the demarcation line that ends a
    program may stand without one that begins it; nothing behind it is read."""
    text = head + "G21 G90 G17\nG0 X10. Y10. Z5.\nG1 X20. F100.\n%\nG999 no word\n"
    lines = written(text, "linuxcnc")
    assert lines[-2:] == ["%", "G999 no word"] and lines[-3] != "G1 X20. F100."


def test_behind_the_end_of_a_program_a_line_may_have_any_length():
    """Nothing there is executed: a tail of data without a line end passes as it is, where the same
    before M2 is refused."""
    tail = "x" * (intake.LINE + 1)
    ended, _ = filtered(HEAD + "M2\n", "linuxcnc")
    assert ended.feed(tail.encode()) + ended.finish() == tail.encode()
    assert "a line of more than 1,000,000 characters" in refused(HEAD + tail, "linuxcnc").message


def test_a_line_may_have_a_million_characters_and_no_more():
    """With a line end behind it or none yet: a pipe that never ends a line is refused while it is
    read, and memory stays flat."""
    longest = "(" + "x" * (intake.LINE - 2) + ")"
    assert written(HEAD + longest + "\n", "linuxcnc")[-1] == longest
    too_long = f"a line of more than {intake.LINE:,} characters"
    assert too_long in refused("(" + longest + "\n", "linuxcnc").message
    pipe, _ = filtered(HEAD, "linuxcnc")
    assert pipe.feed(longest.encode()) == b""
    with pytest.raises(ProgramError, match=too_long):
        pipe.feed(b"x")
