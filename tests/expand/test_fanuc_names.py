"""Programs by names: what they do is what the same programs do by numbers."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from tests.expand.test_kept import corrected
from tests.test_hole_tolerance import mill

MAIN = """%
<SHAFT_T12-F0.2> (MAIN)
G21 G90 G17
G0 X10. Y0. Z-40.
M98 <GROOVE 3> L2 (CALLS <OTHER>)
M98 <END>
G1 X50. F100
M30
<GROOVE 3>
G91 G1 X5. F200
M98 <END>
G90
M99
<END> (LAST)
G91 Y1.
G90
M99
%
"""
NUMBERS = (("<SHAFT_T12-F0.2>", "O1"), ("<GROOVE 3>\n", "O2\n"), ("M98 <GROOVE 3>", "M98 P2"))


def test_names_are_numbers():
    numbered = MAIN.replace("M98 <END>", "M98 P3").replace("<END> (LAST)", "O3")
    for name, number in NUMBERS:
        numbered = numbered.replace(name, number)
    machine = mill(4.0)
    named = corrected(MAIN, machine)
    assert "<SHAFT_T12-F0.2> (MAIN)" in named and len([x for x in named if "Y" in x]) >= 4
    assert [x.replace("<SHAFT_T12-F0.2>", "O1") for x in named] == corrected(numbered, machine)


def test_a_name_alone_is_no_words():
    text = "<PART> (A)\nG21 G90 G17\nG0 X1. Y1. Z-20.\nM30\n"
    assert corrected(text, mill(0.0)) == text.splitlines()


@pytest.mark.parametrize("head", [":0012", " :12 (PART)", ":0012;", ":12 ; (PART)", "<PART> ;"])
def test_a_colon_is_the_letter_o_of_the_iso_code(head):
    """B-64304EN, "Program number"."""
    text = f"%\n{head}\nG21 G90 G17\nG0 X1. Y1. Z-20.\nM30\n%\n"
    assert corrected(text, mill(0.0)) == text.splitlines()
    wrong = text.replace(head, head + " X5.")
    with pytest.raises(ProgramError, match="'[:<]'"):
        corrected(wrong, mill(0.0))


@pytest.mark.parametrize("call", ["M98 <NOT HERE>", "M98 <PART>", "M98 P<SUB>", "G65 <SUB> A1."])
def test_other_names_are_refused(call):
    text = f"<PART>\nG21 G90 G17\nG0 X1. Y1. Z-20.\n{call}\nM30\n<SUB>\nX2.\nM99\n"
    with pytest.raises(ProgramError):
        corrected(text, mill(0.0))


def test_haas_has_no_names():
    with pytest.raises(ProgramError, match="'<'"):
        corrected(MAIN, mill(0.0), "haas")
