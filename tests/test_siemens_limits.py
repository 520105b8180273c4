"""Sinumerik's limits of speed, acceleration and jerk, FGREF and FGROUP: they say how fast, and
stay as they are; a feed and an axis that are not followed are refused by their names."""

from __future__ import annotations

import pytest

from postproc.nc import dialects, spellings
from tests.advice.follow import WRITE, stopped

HEAD = "G17 G90 G94|G0 X0 Y0 Z5|G1 Z1 F100|"


@pytest.mark.parametrize(
    "words",
    [
        "ACC[X]=50",
        "ACC[S1]=50",
        "VELOLIM[X]=80 JERKLIM[Y]=20.5",
        "FL[Z] = 100",
        "FA[A]=100",
        "N10 FGREF[A]=10 FGREF[C]=57.296",
        "FGREF[AX]=10 G1 X40",
        "FGROUP()",
        "FGROUP(X,Y,Z,A,C)",
        "FGROUP (Z, Y , X)",
    ],
)
@pytest.mark.parametrize("how", [{}, WRITE])
def test_how_fast_passes(words, how):
    assert (
        stopped("siemens", f"{HEAD}{words}|X300 Y30|Y50 {words.removeprefix('N10 ')}", how) is None
    )


def test_they_are_no_words():
    grammar = dialects.load("siemens").grammar
    line = b"G1 X5 ACC[X]=50 FGREF[A]=10 FGROUP(X,Y,Z) Y3"
    assert b"".join(spellings.respelled(line, grammar).split()) == b"G1X5Y3"


def test_a_feed_for_one_block_is_written_out():
    error = stopped("siemens", HEAD + "X10 FB=50|X20", {})
    assert error.message == "FB is a feed for one block"
    assert "--expand" in error.advice
    assert stopped("siemens", HEAD + "X10 FB=50|X20", WRITE) is None


@pytest.mark.parametrize(
    ("words", "says", "instead"),
    [
        ("FGROUP(X,Y)", "FGROUP (the axes that F speaks of)", "FGROUP(X,Y,Z)|X10"),
        ("FGROUP(X,Y,A)", "FGROUP (the axes that F speaks of)", "X10"),
        ("POS[X]=10", "POS moves an axis by itself, beside the path", "G1 X10"),
        ("POSA[A]=IC(5)", "POSA moves an axis by itself, beside the path", "G1 A5"),
    ],
)
@pytest.mark.parametrize("how", [{}, WRITE])
def test_what_is_not_followed_is_named(words, says, instead, how):
    error = stopped("siemens", HEAD + words, how)
    assert error.message == says
    assert error.advice
    assert stopped("siemens", HEAD + instead, how) is None
