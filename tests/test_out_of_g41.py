"""Behind cutter radius compensation."""

from __future__ import annotations

import pytest
from fuzz.cases import Case
from fuzz.laws import broken


@pytest.mark.parametrize("leaving", ["G40 G1 Z35.", "G40 G0 Z35.", "G40 G1 X20. Y10. Z35."])
@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-mill", "siemens", "mach3"])
def test_a_feed_behind_g40_begins_at_its_place(dialect, leaving):
    """A block that leads out and moves Z alone leaves X and Y where they were corrected for the Z
    before it: 24 um left of a map that bends by that over Z."""
    units = "" if dialect == "siemens" else " G21"
    text = (
        f"G90 G17{units}\nG0 X60. Y-10. Z-35.\nG42 G1 X70. Y0. F100\nX120.\nY30.\n{leaving}\n"
        "G1 X150. Y20.\nX10.\nM30\n"
    )
    assert broken(Case(text.encode(), dialect, "one-way")) == ""
