"""A slide whose forward lies beyond its reverse goes beyond where it turns: that is told."""

from __future__ import annotations

import re

import pytest

from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects

HEAD = b"G21 G90 G18\nG0 X60. Z%d.\nG1 X50. F100\n"
MARK = re.compile(r"X goes up to ([\d.]+) um beyond its place where it turns")


def told(machine: str, program: bytes, z: int = 100) -> list[float]:
    loaded = places.load(machine)
    filter_ = Filter(loaded, dialects.load("fanuc-lathe"), setup_of(loaded, {"G54": {}}))
    filter_.feed(HEAD % z + program + b"M30\n")
    filter_.finish()
    return [float(m[1]) for n in filter_.notices if (m := MARK.search(n.message))]


def test_how_far_a_slide_goes_beyond_its_turn_is_told():
    """At X40 of the S-36 (20 mm of slide) forward lies some 7 um beyond reverse, by its table."""
    (most,) = told("studer-s36", b"G1 X40.\nX50. Z110.\n")
    assert 6.5 < most < 10.5


def test_a_plunge_goes_no_deeper_than_its_place():
    """X40 was followed by X39.9872, the place of X40 with the other side, before X went back."""
    loaded = places.load("studer-s36")
    filter_ = Filter(loaded, dialects.load("fanuc-lathe"), setup_of(loaded, {"G54": {}}))
    text = filter_.feed(HEAD % 100 + b"G1 X40.\nX50.\nM30\n") + filter_.finish()
    assert min(float(x) for x in re.findall(rb"X([\d.]+)", text)) > 40.0
    assert not [n for n in filter_.notices if MARK.search(n.message)]


@pytest.mark.parametrize(("machine", "z"), [("perfect", 100), ("example-lathe", -100)])
def test_dead_travel_is_taken_up_without_a_word(machine, z):
    assert told(machine, b"G1 X40.\nX50.\n", z) == []
