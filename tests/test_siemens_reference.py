"""Sinumerik's G74 and G75, which name axes of the machine (X1=0): the values say nothing, the block
passes, and places count from the next one that is named."""

from __future__ import annotations

import pytest

from tests.expand.test_kept import corrected
from tests.test_hole_tolerance import mill

HEAD = "G17 G90 G94 G71\n"


@pytest.mark.parametrize(
    "block", ["G74 X1=0 Y1=0", "N10 G75 Z1=0 FP=2", "G75 FP=1 X1=0 Y1=0 Z1=0", "G74 Z1 = 0 ; home"]
)
@pytest.mark.parametrize("loop", ["", "R1=0\n"])
def test_machine_axes_of_a_reference_block_are_no_places(block, loop):
    """The machine lies 4 um off at z = -40 (tests/test_hole_tolerance.py)."""
    text = HEAD + loop + block + "\nG0 X10 Y0 Z-40\nG1 X20 F100\nM30\n"
    lines = corrected(text, mill(4.0), "siemens", tolerance=0.0005)
    at = lines.index(block)
    assert lines[at + 1].startswith("G0 X9.99") and lines[at + 2].startswith("G1 X19.99")


def test_orientation_smoothing_and_the_number_of_a_fixed_point_are_words():
    text = HEAD + "ORISON\nG0 X0 Y0 Z50\nORISOF\nG75 FP=1 Z0\nM30\n"
    assert corrected(text, mill(0.0), "siemens") == text.splitlines()
