"""What LinuxCNC has and gcomp refuses, with the reason; any text ends in lines or a fault."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.errors import ProgramError
from postproc.nc.expand import Limits
from tests.expand.linuxcnc_lines import PROGRAMS, refused, run, texts
from tests.linuxcnc.test_against_linuxcnc import (
    setup_for,
)

# -- what LinuxCNC has and gcomp refuses -----------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("X#5061", "#5061 is known to the machine only"),
        ("X#5070", "known to the machine only"),
        ("X#5399", "known to the machine only"),
        ("X#5410", "known to the machine only"),
        ("X#5600", "known to the machine only"),
        ("X#<_hal[pin]>", "#<_hal[pin]> is known to the machine only"),
        ("X#<_ini[axis_x]home>", "known to the machine only"),
        ("X[EXISTS[#<_hal[pin]>]]", "known to the machine only"),
        ("X#<_rpm>", "known to the machine only"),
        ("X#<_vmajor>", "known to the machine only"),
        ("X#5210", "#5210 is not known"),
        ("F100\nG20 X#<_feed>\nX#<_feed>", "#<_feed> is not known"),
        ("#5221=1", "#5221 belongs to the control"),
        ("#5211=1", "#5211 belongs to the control"),
        ("#5161=1", "#5161 belongs to the control"),
        ("#5399=1", "#5399 belongs to the control"),
        ("#<_hal[pin]>=1", "can be read only"),
        ("M61 Q2\nX#5400", "M61 has changed the tool"),
        ("G28.1\nX#5161", "G28.1 has changed it"),
        ("G10 L2 P1 R30\nX#5420", "G10 R has turned coordinates"),
        ("G0 Z3\nG81 Z-1 R2 F100\nG0 Z5\nX#<_motion_mode>", "cycles are written out"),
        ("G0 X1\nG38.2 X5 F10\nX#5420", "#5420 is not known"),
        ("(py, x=1)", "runs Python"),
        (";py,x=1", "runs Python"),
        ("(PYRUN,x=1)\nM2", "runs Python"),
        ("M99", "M99 in the main program"),
        ("G0 X1\nM99\nM2", "M99 in the main program"),
        ("M98 P5 X1\nM2\nO5\nM99", "followed by more than P and L"),
        ("o1 do\no1 while [0]\no1 do\no1 while [0]", "o1 is used already, in line 1"),
        ("X[TAN[90]]", "X would be -3.98679763e+19"),
        ("X[ROUND[3000000000]]", "ROUND of 3000000000"),
        ("X[1e30]", "']' is missing"),
        ("X[" + 400 * "9" + "]", "a number of 400 digits"),
        ("o1 repeat [9999999999]\no1 endrepeat", "a repeat count of 9999999999"),
        ("o1 while [1]\no1 endwhile", "more than 100,000 lines were executed"),
        ("o1 sub\no1 call\no1 endsub\no1 call", "calls nest deeper than 20"),
        ("X" + 50 * "[" + "1" + 50 * "]", "more than 40 brackets"),
        ("X" + 50 * "-" + "#1", "more than 40 brackets"),
        ("%\no1 if [0]\n%\n", "o1 if has no o1 endif"),
        ("G0 X1 (c\nX[1] (c", "a comment is opened and not closed"),
        ("o<a", "the name is not closed by '>'"),
        ("o1 sub\no1 endsub [1/0]\nX#<_value>", "#<_value> is not known"),
    ],
)
def test_refused(text, message):
    error = refused(text)
    assert message in error.message
    assert error.advice


def test_position_that_nobody_knows():
    setup = replace(setup_for({}), start={})
    assert "#5420 is not known" in refused("Y1\nX#5420", setup=setup).message
    assert texts("G0 X3\nX[#5420+1]", setup=setup) == ["G0 X3", "X4."]
    nothing = replace(setup_for({}), offsets={})
    for what in (
        "#5161",
        "#5185",
        "#5221",
        "#5400",
        "#5403",
        "#<_current_tool>",
        "#<_selected_tool>",
        "#<_coord_system>",
    ):
        assert f"{what} is not known" in refused(f"X{what}", setup=nothing).message


def test_the_tool_in_the_spindle_at_the_start():
    """Said, it is the one until M6; what is selected by T is another thing."""
    setup = replace(setup_for({}), tool=4)
    text = "X#<_current_tool>\nX#5400\nT2\nX#<_current_tool>\nX#<_selected_tool>\nM6\nX#5400"
    assert texts(text, setup=setup) == ["X4.", "X4.", "T2", "X4.", "X2.", "M6", "X2."]


def test_files_without_their_end():
    for library, message in (
        ({"a": b"o<a> sub\nX1\n"}, "the file ends within sub o<a>"),
        ({"a": b"X1\n"}, "there is no sub o<a> in a.ngc"),
        ({"a": b""}, "there is no sub o<a> in a.ngc"),
        ({"a": b"%\no<a> sub\nX1\n%\n"}, "'%' within sub o<a>"),
        ({"a": b"o<a> sub\no<b> sub\n"}, "sub o<b> begins within sub o<a>"),
    ):
        assert message in refused("o<a> call\n", library=library).message
    assert "the file ends within sub o5" in refused("M98 P5\nM2\nO5\n").message


def test_fault_in_a_file_names_the_file():
    error = refused("o<a> call\n", library={"a": b"o<a> sub\n\nX#<n>\n"})
    assert (error.place.file, error.place.line, error.place.start, error.place.stop) == (
        "a.ngc",
        3,
        2,
        6,
    )


def test_a_line_that_can_not_be_followed_is_told_where_it_matters():
    assert "because of a line before" in refused("G0 X1 X2\nX#5420").message


def test_length_alone_is_no_fault():
    assert len(run("X1\n" * 3000, limits=Limits(steps=10, depth=5))) == 3000


# -- anything --------------------------------------------------------------------------------------

SEEDS = [path.read_bytes() for path in PROGRAMS]
PIECES = [
    b"#",
    b"[",
    b"]",
    b"<",
    b">",
    b"=",
    b"o1",
    b"o1 if [",
    b"endif",
    b"\n",
    b"(",
    b")",
    b";",
    b"%",
    b"/",
    b"-",
    b"**",
    b"M98 P",
    b"M99",
    b"M2",
    b"sub",
    b"endsub",
    b"call",
    b"\xff",
    b"\x00",
    b"9" * 30,
    b"1e9",
    b"EXISTS[",
    b"ATAN[",
    b".",
]


@settings(max_examples=300, deadline=None)
@given(
    st.sampled_from(SEEDS),
    st.lists(
        st.tuples(
            st.integers(0, 2000),
            st.integers(0, 12),
            st.sampled_from(PIECES) | st.binary(max_size=3),
        ),
        max_size=4,
    ),
)
def test_whatever_the_text_it_ends_in_lines_or_a_fault(text, changes):
    for at, gone, piece in changes:
        at %= len(text) + 1
        text = text[:at] + piece + text[at + gone :]
    try:
        run(text, library={"a": text, "5": text}, limits=Limits(steps=2000, depth=5))
    except ProgramError as error:
        assert error.message and error.advice and error.place.line >= 1


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.sampled_from(PIECES)
        | st.binary(max_size=2)
        | st.sampled_from([b" ", b"1", b"X", b"G1"]),
        max_size=30,
    )
)
def test_pieces_in_any_order(pieces):
    try:
        run(b"".join(pieces), limits=Limits(steps=200, depth=5))
    except ProgramError as error:
        assert error.message and error.advice
