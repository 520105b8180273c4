"""G24 and G25 of Heidenhain's DIN/ISO: corners by hand, and a datum shift (G54) in place."""

from __future__ import annotations

import math

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.filter import setup_of
from postproc.machine import places
from postproc.nc import dialects
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.units import TICKS_PER_MM
from tests.expand.test_pole import path, plain

START = "G00 G90 X+0 Y+0|G01 X+20 F100|"


def test_a_chamfer_begins_and_ends_as_far_from_the_corner():
    lines = plain(START + "N5 G24 R3|Y+30 M8|G00 X+9")
    assert lines == [
        "G00 G90 X+0 Y+0*", "G01 X17 Y0 F100*", "G01 X20 Y3*", "Y+30 M8*", "G00 X+9*",
    ]  # fmt: skip


def test_where_the_lines_go_on_straight_there_is_no_corner():
    lines = plain(START + "G24 R3|X+30")
    assert lines == ["G00 G90 X+0 Y+0*", "G01 X+20 F100*", "X+30*"]
    with pytest.raises(ProgramError, match="G25 where the line runs back"):
        plain(START + "G25 R3|X+20")


def test_a_rounding_touches_both_lines():
    """Radius 5 at a right angle: from X15 around X15 Y5 to Y5."""
    lines = plain(START + "G25 R5|Y+30")
    assert lines[1] == "G01 X15 Y0 F100*" and lines[-1] == "Y+30*" and lines[-2] == "G01 X20 Y5*"
    arc = path(lines[2:-1], (15.0, 0.0))
    away = np.hypot(*(arc - [15, 5]).T)
    assert away == pytest.approx(5, abs=1e-4)
    middles = np.hypot(*((arc[:-1] + arc[1:]) / 2 - [15, 5]).T)
    assert 5 - middles.min() <= 1.01e-3


def test_a_rounding_at_a_sharp_corner_with_a_feed_of_its_own():
    """X+10 Y+40, X+40 Y+25, R5 F100, X+10 Y+5. The corner
    of 60.255 degrees begins 5 / tan 30.13 degrees before it; F100 holds in it alone."""
    lines = plain("G01 G41 X+10 Y+40 F300 M3|G01 X+40 Y+25|G25 R5 F100|G01 X+10 Y+5")
    one, two = np.array([-30.0, 15.0]), np.array([-30.0, -20.0])
    one, two = one / np.hypot(*one), two / np.hypot(*two)
    away = 5 / math.tan(math.acos(one @ two) / 2)
    first, last = np.array([40, 25]) + away * one, np.array([40, 25]) + away * two
    arc = path(lines[1:-1], (10.0, 40.0))
    assert arc[1] == pytest.approx(first, abs=1e-4)
    assert arc[-1] == pytest.approx(last, abs=1e-4)
    assert lines[2].endswith("F100*") and not any("F" in line for line in lines[3:-1])
    assert lines[-1] == "G01 X+10 Y+5 F300*"


def test_a_line_without_a_corner_is_not_held_back():
    """An arc behind it begins where it ends."""
    lines = plain("G00 G90 X+0 Y+0|G01 X+50 Y+20 F100|G03 X+80 Y+50 I+50 J+50|G01 X+90|G24 R2|Y+99")
    arc = path(lines[2:-3], (50.0, 20.0))
    assert np.hypot(*(arc - [50, 50]).T) == pytest.approx(30, abs=1e-3)
    assert lines[-3:] == ["G01 X88 Y50*", "G01 X90 Y52*", "Y+99*"]


def test_corners_one_after_the_other_share_a_line():
    lines = plain(START + "G24 R3|Y+30|G24 R4|X+0")
    assert lines[1:] == [
        "G01 X17 Y0 F100*", "G01 X20 Y3*", "X20 Y26*", "G01 X16 Y30*", "X+0*",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("G24 R3|G00 Y+30", "G24 beside something else"),
        ("G24 R3|G01 Z-2", "G24 beside something else"),
        ("G25 R0|Y+30", "more than its size R, or without it"),
        ("G25 R50|Y+30", "G25 50 begins 50 before the corner"),
        ("G25 R5|X+0", "G25 where the line runs back"),
        ("G91 Y+5|G25 R1|X+5", "G25 in G91"),
        ("G00 Y+5|G25 R1|G01 X+5", "G25 beside something else"),
        ("L1,0|Y+5|G25 R1|X+5", "a program that calls labels"),
    ],
)
def test_what_is_not_followed_is_refused(program, message):
    with pytest.raises(ProgramError, match=message):
        plain(START + program)


def test_a_datum_shift_counts_from_the_preset():
    """G54 moves the axes that it names, from the preset; X+0 takes it back."""
    machine = places.load("example-mill")
    dialect = dialects.load("heidenhain-iso")
    interpreter = Interpreter(
        dialect, setup_of(machine, {"G54": {"X": 100.0, "Y": 50.0, "Z": 0.0}})
    )
    text = (
        b"G00 G90 X+10 Y+10 Z-50*\nG54 X+25 Y-10*\nG00 X+10 Y+10*\nG54 X+5*\nG00 X+10 Y+10*\n"
        b"G54 X+0 Y+0*\nG00 X+10 Y+10*\n"
    )
    motions = interpreter.run(lex(text, dialect.grammar, False), interpreter.initial())[0]
    found = motions.target[:2].T / TICKS_PER_MM
    assert found.tolist() == [[110, 60], [135, 50], [115, 50], [110, 60]]
    assert not motions.reason.any()


def test_a_datum_shift_in_g91_is_refused():
    machine = places.load("example-mill")
    dialect = dialects.load("heidenhain-iso")
    interpreter = Interpreter(
        dialect, setup_of(machine, {"G54": {"X": 100.0, "Y": 50.0, "Z": 0.0}})
    )
    text = b"G00 G90 X+10 Y+10 Z-50*\nG91 G54 X+25*\nG90 G00 X+10 Y+10*\n"
    motions = interpreter.run(lex(text, dialect.grammar, False), interpreter.initial())[0]
    assert "counts from the datum in force" in motions.reasons[motions.reason[1]][0]
