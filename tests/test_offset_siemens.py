"""Siemens' offset files: what they say in mm and radius, what is told, and what is refused with its
line."""

from __future__ import annotations

import pytest

from tests.offset_texts import UFR, of, refused, told


def test_siemens_frames():
    found = of(UFR, inch=False)
    assert found.format == "siemens"
    assert found.work == {
        "G500": {"X": 0, "Y": 0},
        "G54": {"X": 10.01, "Y": -20.5, "Z": 0.5, "C": 90},
        "G55": {"X": 6.5},
        "G505": {"Z": 0.0015},
        "G599": {},
        "EXT": {"X": 3.25, "Z": 3},
    }
    assert found.rotation == {"G54": 30, "G55": -15}
    assert found.notices == ["G505 shifts SP1 by 4, no axis that gcomp knows: left out"]
    assert of("$P_UIFR[4]=CTRANS(X,1,A,1)", inch=True).work == {"G57": {"X": 25.4, "A": 1}}


def test_siemens_the_compatible_name_of_the_basic_frame_is_the_same_frame():
    assert of("$P_CHBFR[0]=CTRANS(X,1)\n$P_UBFR=CTRANS(X,5)\n$P_UBFR[Y,TR]=2").work == {
        "EXT": {"X": 5, "Y": 2}
    }


@pytest.mark.parametrize(
    "frame",
    [
        "CROT(X,10)",
        "CSCALE(X,2)",
        "CMIRROR(X)",
        "CTRANS(X,1):CMIRROR(Y,1)",
        "CROT(Z,30):CTRANS(X,1)",
    ],
)
def test_siemens_frames_that_are_more_than_a_shift_are_left_out(frame):
    found = of(f"$P_UIFR[1]={frame}\n$P_UIFR[2]=CTRANS(X,1)\n")
    assert set(found.work) == {"G55"}
    assert told(found, "G54 scales, mirrors or turns")
    refused(f"$P_UIFR[2]=CTRANS(X,1)\n$P_CHBFR[0]={frame}\n", "file:2: ", "basic frame")


def test_siemens_tools():
    found = of(
        '%_N_TO_INI\n$TC_TP2[1]="MILL;10"\n$TC_DP1[1,1]=120\n$TC_DP3[1,1]=120.5\n$TC_DP6[1,1]=5\n$TC_DP12[1,1]=-.05\n'
        "$TC_DP15[1,1]=0.01\n$TC_DP21[1,1]=10\n$TC_DP24[1,1]=7\n"
        "$TC_DP1[7,2]=510\n$TC_DP3[7,2]=30\n$TC_DP4[7,2]=40\n$TC_DP6[7,2]=0.8\n"
    )
    assert found.tools == {"T1D1": {"Z": 130.45, "R": 5.01}, "T7D2": {"X": 30, "Z": 40, "R": 0.8}}
    assert told(found, "G17 for mills")
    diameter = of("$TC_DP1[7,2]=510\n$TC_DP3[7,2]=30\n$P_UIFR[1]=CTRANS(X,4)\n", diameter=True)
    assert diameter.tools == {"T7D2": {"X": 15}}
    assert diameter.work == {"G54": {"X": 4}}
    assert told(diameter, "X of frames")
    assert told(of("$TC_DP3[1,1]=5"), "without a type")


@pytest.mark.parametrize(
    "line",
    [
        "$P_UIFR[1]=CTRANS(X,R1)",
        "$P_UIFR[1]=CTRANS(X)",
        "$P_UIFR[1]=CTRANS(X,1",
        "$P_UIFR[1]=CTRANS(1,X)",
        "$P_UIFR[1]=$P_UIFR[2]",
        "$P_UIFR[1]=",
        "$P_UIFR[1,X]=1",
        "$P_UIFR[1,X,QQ]=1",
        "$P_UIFR[N,X,TR]=1",
        "$P_UIFR[100]=CTRANS()",
        "$P_UIFR[1]=CTRANS(X,1):CTRANS(X,1)",
        "$P_UIFR=CTRANS(X,1)",
        "$TC_DP3[1]=5",
        "$TC_DP3[1,1]=LEN",
        "G0 X5",
        "CHANDATA(2)",
    ],
)
def test_siemens_refused(line):
    refused("CHANDATA(1)\n$P_UIFR[2]=CTRANS(X,1)\n" + line, "file:3: ")
