"""Offsets and lengths as words of the command line: how they may be written, and how not."""

from __future__ import annotations

import argparse

import pytest

from postproc.commands import values


@pytest.mark.parametrize(
    "text, name, place",
    [
        ("G54=X1,Z2", "G54", {"X": 1, "Z": 2}),
        ("g59.3 = x-.5", "G59.3", {"X": -0.5}),
        ("G54.1P3=X1", "G54.1 P3", {"X": 1}),
        ("G54.1 P03=X1", "G54.1 P3", {"X": 1}),
        ("G505=X1", "G505", {"X": 1}),
        ("G599=X1", "G599", {"X": 1}),
        ("G92=X1", "G92", {"X": 1}),
        ("G52=X1", "G52", {"X": 1}),
        ("EXT=Z1", "EXT", {"Z": 1}),
        ("T0101=X0,Z80,R0.4", "T0101", {"X": 0, "Z": 80, "R": 0.4}),
        ("H01=Z120", "H1", {"Z": 120}),
        ("D1=R5", "D1", {"R": 5}),
    ],
)
def test_an_offset_may_be_written_so(text, name, place):
    assert values.offset(text) == (name, place)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "G54",
        "G54=",
        "T\u0661=X1",
        "G54=X\u0661",
        "G53=X1",
        "G60=X1",
        "G504=X1",
        "G600=X1",
        "G54.1=X1",
        "G54.2=X1",
        "G54.1P0=X1",
        "H0=Z1",
        "G54=R1",
        "H1=R1",
        "G54=X1,X2",
        "G54=X",
        "G54=Q1",
        "G54=X1;Z2",
        "G54=X1mm",
        "=X1",
        "G54=X" + "9" * 400,
    ],
)
def test_an_offset_may_not_be_written_so(text):
    with pytest.raises(argparse.ArgumentTypeError, match="like G54=X1,Z2"):
        values.offset(text)


@pytest.mark.parametrize(
    "text, says",
    [
        ("20mm", "is that meant in um[?] write 20um"),
        ("2in", "in um"),
        ("0", "not above zero"),
        ("-1um", "not above zero"),
        ("1e-300", "below 1e-09 mm"),
        ("0,5um", "write 0.5um"),
        ("5", "write 5um or 5mm"),
        ("nan", "like 0.5um"),
        ("9" * 400, "like 0.5um"),
        ("", "like 0.5um"),
    ],
)
def test_a_length_may_not_be_written_so(text, says):
    for reader in (values.length, values.tolerance):
        with pytest.raises(argparse.ArgumentTypeError, match=says):
            reader(text)


def test_a_millimetre_is_a_length_and_no_tolerance_beyond_it():
    assert values.length("5mm") == 5
    assert values.tolerance("1mm") == 1
    assert values.tolerance("0.5um") == pytest.approx(0.0005)
    with pytest.raises(argparse.ArgumentTypeError, match="is that meant in um[?]; write 5um"):
        values.tolerance("5mm")
