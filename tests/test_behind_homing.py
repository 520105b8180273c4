"""Where slides bear that something else (G28) has taken home."""

from __future__ import annotations

import pytest
from fuzz.cases import Case, filter_of
from fuzz.laws import broken

from postproc.units import UM
from postproc.verify import Verifier


@pytest.mark.parametrize(
    "blocks", ["G1 X0.002 F100", "G1 X0.1 F100|G1 Y0.1|G1 X0.003", "G1 X10. F100|G1 Y10.|G1 Z5."]
)
@pytest.mark.parametrize("dialect", ["grbl", "marlin", "smoothie"])
def test_behind_homing_each_slide_bears_as_its_way_from_there_leads_it(dialect, blocks):
    """Also where the correction is longer than that motion, or all of it: the side of the motion
    was taken, or the mean of both (3 to 4 um left)."""
    case = Case(f"G28|{blocks}|G1 X20.|".replace("|", "\n").encode(), dialect, "two-way")
    assert broken(case) == ""
    filter_ = filter_of(case)
    verifier = Verifier(filter_)
    filter_.feed(case.text)
    filter_.finish()
    assert verifier.corrected.deviation < 1.1 * UM
