"""Cycles of Fanuc's and Haas' mills and lathes that can not be vouched for: refused, each with its
reason."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from tests.expand.plain_lines import LATHE, MILL, lathe, text_of

HAAS_REFUSED = {
    "haas": {
        "G83 Z-9. R2. Q2. I1.": "Q and I of G83 together",
        "G73 Z-9. R2. Q2. K6.": "Q and K of G73 together",
        "G83 Z-9. R2. I2. J.5": "I and J of G83 together",
        "G81 Z-9. R2. P500": "P in a drilling cycle",
        "G12 I8. X5. D0": "X in a pocket cycle .G12.: that is no word of it",
        "G13 I8. D7": "the tool's radius D7 of G13 is not stated",
    },
    "haas-lathe": {
        "G71 P10 Q20 D2. R1|N10 G0 X40.|G1 Z-5.|X30.|N20 Z-9.": "X turns back|goes deeper",
        "G71 P10 Q20 D2. I.5|N10 G0 X40.|N20 G1 Z-5.": (
            "I.5 in a turning cycle .G71.: the allowance of a rough"
        ),
        "G73 P10 Q20 D2 I1.|N10 G0 G42 X40.|N20 G1 G40 Z-5.": "G42 in the shape of G73",
        "G74 X50. Z-5. K1. D.2": "draws the tool aside",
        "G74 Z-5. Q1000": "Q in a grooving cycle .G74.: that is no word of it",
        "G81 X50. W-5. R2.": (
            "W-5. in a drilling cycle .G81.: from where it counts the bottom is not certain"
        ),
        "G241 Z-5. U-5. R2.": (
            "U-5. in a drilling cycle .G241.: from where it counts the bottom is not certain"
        ),
        "G83 Z-9. R2. Q2. K1.": "Q and K of G83 together",
        "G87 Z-9. R2.": "G87 can not be written out: the operator draws the tool out by hand",
    },
}


@pytest.mark.parametrize(
    ("dialect", "program"), [(d, p) for d, programs in HAAS_REFUSED.items() for p in programs]
)
def test_what_haas_means_otherwise_is_refused(dialect, program):
    with pytest.raises(ProgramError, match=HAAS_REFUSED[dialect][program]):
        text_of("G0 X100. Z12.|" + program, dialect, MILL if dialect == "haas" else LATHE)


LATHE_REFUSED = {
    "G71 U2. R1.|G71 P10 Q20 R1.|N10 G0 X40.|N20 G1 Z-5.": "type II",
    "G71 U2. R1.|G71 P10 U1.|N10 G0 X40.|N20 G1 Z-5.": "number of a block in Q",
    "G71 U2. R1.|G71 P10 Q20.5|N10 G0 X40.|N20 G1 Z-5.": "number of a block in Q",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|G1 Z-5.|N20 G0 X100. Z2.": (
        "last block of the shape takes Z back"
    ),
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|G1 Z-5.|N20 X30. Z-9.": "goes deeper in X",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5. R2.": "behind its last line",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|G4 X1.|N20 G1 Z-5.": "G4 in the shape",
    "G70 P10 Q20|N10 G0 G42 X40.|N20 G1 Z-5.": "G42 is still on at the end",
    "G42 G1 X90.|G90 X80. Z-5.": "compensation on",
    "G71": "without its words",
    "G74 R1. Z-5.": "draws the tool aside",
    "G74 Z-5. Q1000 K1.": "Q and K both",
    "G90 X50. Z-5. R1. I1.": "both say the taper",
    "G90 X50. U-5. Z-5.": "X is named twice",
    "G90 X50. Z-5.|C9.": "C in a block within G90",
    "G83 Z-5. R-1. K2 L2": "both say how often",
    "G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5.": "depth of cut is not in the program",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 Z0.|N20 G1 Z-5.": "does not go to its depth in X",
    "G71 U2. R1.|G71 P10 Q30|N10 G0 X40.|N20 G1 Z-5.": "no block N30",
    "G71 U2. R1.|G71 P11 Q20|N10 G0 X40.|N20 G1 Z-5.": "no block N11",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|Z-5.|X30. Z-9.|N20 X100.": "turns back",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|G1 Z-5.|G2 Z-20. R13.|N20 G1 X90.": (
        "X turns back within the shape: the control stops .alarm PS0329"
    ),
    "G71 U2. R1.|G71 P10 Q20|N10 G1 Z0.|X10.|N20 X40. Z-20.": (
        "X turns back within the shape: the control stops .alarm PS0329"
    ),
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5. ,R2.": "behind its last line",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5.|X1.": "no motion code is named",
    "G73 U2.|G73 P10 Q20|N10 G0 X40.|N20 G1 Z-5.": "how often",
    "G74 X50. Z-5. P1000 Q1000 R-.2": "draws the tool aside",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40. M98 P5|N20 G1 Z-5.": "in the shape of a cycle",
    "G71 U2. R1.|G71 P10 Q20 V1.|N10 G0 X40.|N20 G1 Z-5.": "V in a turning cycle",
    "G90 X50.": "without Z",
}


@pytest.mark.parametrize("program", LATHE_REFUSED)
def test_lathe_cycles_that_can_not_be_vouched_for_are_refused(program):
    with pytest.raises(ProgramError, match=LATHE_REFUSED[program]) as caught:
        lathe("G0 X100. Z2.|" + program)
    assert caught.value.advice
