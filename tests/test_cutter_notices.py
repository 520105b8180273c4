"""The figures that are told of cutter radius compensation."""

from __future__ import annotations

from postproc.filter import Filter, setup_of
from postproc.nc import dialects
from tests.test_lost_motion import backlash, machine

HEAD = "G21 G17 G90 G40\nG0 X-20 Y-20 Z0\n"
SMALL = "G41.1 D6\nG1 X0 Y0 F500\nY30\nX30\nY0\nX0\nG40 G1 X-20 Y-20\n"
LARGE = "G41.1 D20\nG1 X-60 Y-60 F500\nY30\nX90\nY-60\nX-60\nG40 G1 X-120 Y-120\n"


def said(m, program: str) -> dict[str, str]:
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m))
    filter_.feed((HEAD + program + "M2\n").encode())
    filter_.finish()
    return {n.code: n.message for n in filter_.notices}


def test_a_reversal_is_that_of_the_tables_and_of_the_effects_together(tmp_path):
    """8 um of a table and 5 um of backlash: 8.0 um were told."""
    two_way = "X_mm,EXX_um_fwd,EXX_um_rev\n-500,0,8\n500,0,8\n"
    m = machine(tmp_path / "m", backlash("X", 5), X=two_way)
    assert "reversal of up to 13.0 um is spread" in said(m, SMALL)["beside"]


def test_corners_are_told_of_the_largest_tool(tmp_path):
    """Of two contours the first, with the
    smaller tool, was told of."""
    scale = "X_mm,EXX_um\n-500,0\n500,200\n"
    m = machine(tmp_path / "m", "[squareness]\nC0Y=300\n", X=scale)
    one, both = said(m, SMALL)["centre"], said(m, SMALL + LARGE)["centre"]
    assert "3 mm beside each block" in one and "10 mm beside each block" in both
    figures = [float(s.split("wrong by ")[1].split(" um")[0]) for s in (one, both)]
    assert figures == [3.0, 10.0] and said(m, LARGE + SMALL)["centre"] == both
