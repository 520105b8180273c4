"""Blocks that begin with / while block delete is on: the control steps over them, and so does what
is written out. Each case is the program without that line, which stays as it is."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.expand.plain_lines import LATHE, MILL, text_of

LATHE_A = ("fanuc-lathe-a", replace(LATHE, axes=("X", "Z"), start={"X": 0.0, "Z": 0.0}))
FANUC, SINUMERIK = ("fanuc-mill", MILL), ("siemens", MILL)
HEIDENHAIN = ("heidenhain-iso", MILL)
BEGIN = "G90 G17 G0 X0. Y0. Z5.|G1 F100.|"


@pytest.mark.parametrize(
    ("control", "program"),
    [
        (FANUC, BEGIN + "X50. ,R5.|{/Y50. ,C1.}|X80. Y20."),
        (FANUC, BEGIN + "X50.|{/Y50. ,C1.}|X80. Y20."),
        (FANUC, BEGIN + "X50. ,C5.|{/M8}|Y20."),
        (LATHE_A, "G0 X20. Z60.|G1 X40. C1. F.1|{/X60.}|Z20."),
        (SINUMERIK, BEGIN + "X50 RND=5|{/Y50 RNDM=2}|X80 Y20|Y90"),
        (SINUMERIK, BEGIN + "{/POLY PO[X]=(5,1)}|X80 Y20|Y90"),
        (SINUMERIK, BEGIN + "{/G2 X5 AR=180}|X80 Y20"),
        (HEIDENHAIN, "G71 G90 *|G00 X+0 Y+0 Z+10 *|I+1 J+1 *|{/I+10 J+10 *}|G10 R+5 H+30 *"),
        (HEIDENHAIN, "G71 G90 *|G00 X+0 Y+0 Z+10 *|I+1 J+1 *|{/G02 X+5 Y+5 *}|X+2 Y+2 *"),
        (LATHE_A, "G0 X60. Z102.|G71 U5. R1.|G71 P10 Q20 U0 W0 F.2|N10 G0 X20.|G1 Z80. F.1|"
                  "{/X30. Z70.}|X40. Z60.|N20 X60.|G0 Z110."),
    ],
)  # fmt: skip
def test_a_block_that_is_stepped_over_says_nothing(control, program):
    dialect, setup = control
    setup = replace(setup, block_delete=True)
    before, _, rest = program.partition("{")
    skipped, _, behind = rest.partition("}|")
    without = text_of(before + behind, dialect, setup)
    lines = text_of(before + skipped + "|" + behind, dialect, setup)
    if "P10" in program:  # the cycle writes its shape itself, and steps over its blocks
        assert lines == without
    else:
        assert lines.count(skipped) == 1
        assert [line for line in lines if line != skipped] == without
