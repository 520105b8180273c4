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
    (most,) = told("studer-s36", b"G1 X40.\nX50.\n")
    assert 6.5 < most < 8.5


@pytest.mark.parametrize(("machine", "z"), [("perfect", 100), ("example-lathe", -100)])
def test_dead_travel_is_taken_up_without_a_word(machine, z):
    assert told(machine, b"G1 X40.\nX50.\n", z) == []
