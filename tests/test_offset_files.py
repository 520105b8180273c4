"""Offset files of controls: what they say in mm and radius, what is told, and what is refused with
its line."""

from __future__ import annotations

import argparse

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from postproc import offsets
from postproc.commands import values
from postproc.errors import UsageError
from postproc.offsets import canonical, read


def of(text: str | bytes, **how) -> offsets.Offsets:
    return read(text if isinstance(text, bytes) else text.encode(), "file", **how)


def refused(text: str | bytes, *says: str, **how) -> None:
    with pytest.raises(UsageError) as error:
        of(text, **how)
    for part in says:
        assert part in str(error.value)
    assert error.value.advice


def told(found: offsets.Offsets, part: str) -> bool:
    return any(part in notice for notice in found.notices)


# -- LinuxCNC --------------------------------------------------------------------------------------

VAR = "".join(
    f"{n}\t{v:.6f}\n"
    for n, v in sorted(
        {
            5161: 9,
            5210: 0,
            5211: 0.5,
            5213: -2,
            5220: 2,
            5221: 1,
            5222: 2,
            5223: -3.5,
            5224: 90,
            5227: 4,
            5230: 30,
        }.items()
        | {5241: 7, 5381: -1, 5389: 5, 5390: 0}.items()
    )
)


def test_linuxcnc_parameters():
    found = of(VAR)
    assert found.format == "linuxcnc-var"
    assert found.work["G54"] == {"X": 1, "Y": 2, "Z": -3.5, "A": 90, "U": 4}
    assert found.work["G55"] == {"X": 7}
    assert found.work["G59.3"] == {"X": -1, "W": 5}
    assert found.rotation == {"G54": 30}
    assert set(found.work) == {"G54", "G55", "G59.3"}
    assert told(found, "unit")
    assert told(found, "not in force")
    assert told(found, "G55 is in force")


def test_linuxcnc_parameters_in_inches_with_a_shift():
    found = of(VAR.replace("5210\t0", "5210\t1"), inch=True)
    assert found.work["G54"] == {
        "X": 25.4,
        "Y": 50.8,
        "Z": pytest.approx(-88.9),
        "A": 90,
        "U": pytest.approx(101.6),
    }
    assert found.work["G92"] == {"X": 12.7, "Z": -50.8}
    assert not told(found, "unit")


def test_linuxcnc_x_is_a_radius_whatever_one_says():
    found = of(VAR, diameter=True)
    assert found.work["G54"]["X"] == 1
    assert told(found, "radius")


@pytest.mark.parametrize(
    "line",
    ["5222", "5222 2 3", "5222 x", "5222 nan", "5222 \u0661", "G54 1", "5222 1e300", "5241 1"],
)
def test_linuxcnc_parameters_refused(line):
    refused("5221 1.0\n\n5241 1\n" + line, "file:4: ", line.split()[-1])


def test_parameters_that_are_no_offsets_may_be_any_size():
    assert of("31 1e300\n5221 1\n").work == {"G54": {"X": 1}}


def test_linuxcnc_tool_table():
    found = of(
        "; my tools\nT1 P1 Z+0.511 D0.125 ;1/8 end mill\nT2\tP7 x-1.5 Z0 A45 D+3.000000 I85 J5"
        " Q2\n\nT10 P3 ;\n",
        inch=False,
    )
    assert found.format == "linuxcnc-tool-table"
    assert found.tools == {
        "T1": {"Z": 0.511, "R": 0.0625},
        "T2": {"X": -1.5, "Z": 0, "A": 45, "R": 1.5, "Q": 2},
        "T10": {},
    }
    assert found.notices == []
    assert of("T1 P1 Z1 D1 A5", inch=True).tools == {"T1": {"Z": 25.4, "R": 12.7, "A": 5}}


@pytest.mark.parametrize(
    "line, says",
    [
        ("P2 Z1", "number is missing"),
        ("T2 P2 K5", "'K5' is no word"),
        ("T2 P2 Z1 Z2", "Z stands twice"),
        ("T2.5 P2", "number is missing"),
        ("Tx P1", "number is missing"),
        ("POC FMS LEN", "'FMS' is no word"),
        ("T1 P2", "tool T1 stands twice"),
        ("T2 Z1x", "'1x' is not a number"),
        ("T2 P2 Ix", "'x' is not a number"),
    ],
)
def test_linuxcnc_tool_table_refused(line, says):
    refused("T1 P1 Z1\n" + line + "\n", "file:2: ", says)


# -- Fanuc -----------------------------------------------------------------------------------------


def test_fanuc_work_offsets():
    found = of(
        "%\nO0001(WORK)\nG90\nN1G10L2P0X0.Y0.Z-1.5\nG10 L2 P1 X-100.25 Y50. Z0."
        " B90.\n\r\rG10L20P12X1.Y2.\nM30\n%\n"
    )
    assert found.format == "fanuc"
    assert found.work == {
        "EXT": {"X": 0, "Y": 0, "Z": -1.5},
        "G54": {"X": -100.25, "Y": 50, "Z": 0, "B": 90},
        "G54.1 P12": {"X": 1, "Y": 2},
    }
    assert found.notices == [offsets.NO_UNIT]
    assert of("G20 G10 L2 P6 X1. Y1. C10.").work == {"G59": {"X": 25.4, "Y": 25.4, "C": 10}}
    assert of("G10 L2 P6 X1. Y1.", inch=True).work == {"G59": {"X": 25.4, "Y": 25.4}}


def test_fanuc_mill_tools_geometry_and_wear_are_added():
    found = of(
        "G21\nG10 L10 P1 R120.5\nG10 L11 P1 R-0.05\nG10 L12 P1 R5.\nG10 L13 P01 R.01\nG10 L1 P2"
        " R7.\n"
    )
    assert found.tools == {"H1": {"Z": pytest.approx(120.45)}, "D1": {"R": 5.01}, "H2": {"Z": 7}}
    assert told(found, "5004#2")


def test_fanuc_memory_a_and_b_share_h_and_d():
    found = of("G10 L11 P3 R4.\n")
    assert found.tools == {"H3": {"Z": 4}, "D3": {"R": 4}}
    assert told(found, "H and D")


def test_fanuc_lathe_tools():
    text = (
        "G10 P10001 X-200. Z-100. R0.8 Q3\nG10 P1 X0.1 Z0.02 R0. Q3\nG10 P10012 X10. Z5.\nG10 L2 P1"
        " X4. Z300.\n"
    )
    found = of(text)
    assert found.tools == {
        "T0101": {"X": pytest.approx(-99.95), "Z": pytest.approx(-99.98), "R": 0.8, "Q": 3},
        "T1212": {"X": 5, "Z": 5},
    }
    assert found.work == {"G54": {"X": 2, "Z": 300}}
    assert told(found, "diameter")
    radius = of(text, diameter=False)
    assert radius.tools["T1212"]["X"] == 10
    assert radius.work["G54"]["X"] == 4
    assert not told(radius, "X is read")


def test_fanuc_who_has_only_x_and_z_is_told_that_x_is_taken_as_a_radius():
    assert told(of("G10 L2 P1 X10. Z1."), "X is read as a radius")
    assert not told(of("G10 L2 P1 X10. Y0. Z1."), "X is read")
    assert of("G10 L2 P1 X10. Z1.", diameter=True).work == {"G54": {"X": 5, "Z": 1}}


def test_fanuc_steps_add_to_what_stands_there():
    assert of("G10 L2 P1 X10. Y1.\nG91 G10 L2 P1 X1.\nG90\nG10 L2 P1 Y5.").work == {
        "G54": {"X": 11, "Y": 5}
    }
    assert of("G10 P1 X10. R1.\nG10 P1 U2. C.5", diameter=False).tools == {
        "T0101": {"X": 12, "R": 1.5}
    }


def test_fanuc_integers_are_whole_units_and_told():
    found = of("G10 L2 P1 X10 Y0")
    assert found.work == {"G54": {"X": 10, "Y": 0}}
    assert told(found, "decimal point")
    assert not told(of("G10 L2 P1 X0 Y0"), "decimal point")


@pytest.mark.parametrize(
    "line, says",
    [
        ("G0 X1.", "no G10"),
        ("T0101", "no G10"),
        ("G10 L2 X1.", "needs P"),
        ("G10 L2 P7 X1.", "no offset P7"),
        ("G10 L20 P0 X1.", "no offset P0"),
        ("G10 L2 P1 R30.", "R does not belong"),
        ("G10 L2 P1 U1.", "may be axes"),
        ("G10 L10 P1", "needs R"),
        ("G10 L50", "needs P"),
        ("G10 L52 P1 R1", "sets no offset"),
        ("G10 L0 P1", "G10 L0 sets no offset"),
        ("G10 L2 P1 X#1", "'X#1'"),
        ("G10 L2 P1 X1. X2.", "X stands twice"),
        ("G10 L2 P1.5 X1.", "needs P"),
        ("G10 P0 X5.", "shifts the work coordinates"),
        ("G10 P10000 X5.", "no offset P10000"),
        ("G10 P20001 X5.", "no offset P20001"),
        ("G10 P5 U1.", "a step from a value"),
        ("G10 P1 X1. U1.", "stand together"),
        ("G91 G10 L2 P3 X1.", "a step from a value"),
        ("G10 L2 P1 X" + "9" * 400, "too large"),
    ],
)
def test_fanuc_refused(line, says):
    refused("%\nG10 L2 P1 X1. Y1. Z1.\n" + line + "\n%\n", "file:3: ", says)


def test_a_program_is_no_offset_file():
    refused("%\nO1\nG10 L2 P1 X0 Y0 Z0\nG0 X5. Y5.\nM30\n%\n", "file:4: ", "no G10")


# -- Siemens ---------------------------------------------------------------------------------------

UFR = """%_N_UFR_INI
;$PATH=/_N_NC_ACT_DIR/_N_UFR_DIR
CHANDATA(1)
N10 $P_UIFR[0]=CTRANS(X,0,Y,0)
$P_UIFR[1]=CTRANS(X,10,Y,-20.5,Z,.5,C,90):CFINE(X,0.01,Y,0):CROT(X,0,Y,0,Z,30):CSCALE(X,1,Y,1):CMIRROR(X,0,Y,0)
$p_uifr[2,x,tr]=7 ; second
$P_UIFR[2,X,FI]=-0.5
$P_UIFR[2,Z,RT] = -15
$P_UIFR[5]=CTRANS(Z,1.5EX-3,SP1,4)
$P_UIFR[99]=CTRANS()
$P_CHBFR[0]=CTRANS(X,1):CFINE(X,0.25)
$P_NCBFR[0]=CTRANS(X,2,Z,3)
$MN_MM_NUM=5
M17
"""


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


# -- GRBL ------------------------------------------------------------------------------------------

HASH = (
    "$#\r\n[G54:-100.000,10.500,0.000]\r\n[G59:1.000,2.000,3.000]\r\n[G28:0.000,0.000,0.000]\r\n[G30:1.000,0.000,0.000]\r\n"
    "[G92:0.000,0.000,5.000]\r\n[TLO:12.250]\r\n[PRB:1.000,2.000,3.000:1]\r\nok\r\n"
)


def test_grbl_answer():
    found = of(HASH)
    assert found.format == "grbl"
    assert found.work == {
        "G54": {"X": -100, "Y": 10.5, "Z": 0},
        "G59": {"X": 1, "Y": 2, "Z": 3},
        "G92": {"X": 0, "Y": 0, "Z": 5},
    }
    assert found.tools == {"G43.1": {"Z": 12.25}}
    assert found.notices == []


def test_grbl_decimals_tell_the_unit():
    found = of("[G54:1.0000,2.0000,0.0000,45.000]\n[TLO:0.0000,0.0000,1.0000]\n[GC:G0 G54]\n")
    assert found.work == {"G54": {"X": 25.4, "Y": 50.8, "Z": 0, "A": 45}}
    assert found.tools["G43.1"]["Z"] == 25.4
    assert told(found, "inches")
    assert of("[G54:1.0000,0.0000]", inch=False).work["G54"]["X"] == 1
    assert told(of("[G54:1.0,0.0]"), "unit")
    assert of("[G54:3.000,0.000]", diameter=True).work["G54"]["X"] == 1.5


@pytest.mark.parametrize(
    "line",
    ["[G55:a,b,c]", "[G54:1,2,3]", "G0 X1", "[G55:1,,2]", "[G56]", "[TLO:" + "1," * 9 + "1]"],
)
def test_grbl_refused(line):
    refused("[G54:1.000,1.000,1.000]\n" + line, "file:2: ")


# -- own table -------------------------------------------------------------------------------------


def test_own_table():
    found = of(
        "\ufeff# offsets\nname,X_mm,Y_mm,"
        " z_MM,R_mm,B_deg,rotation_deg\nG54,1,2.5,,,,\ng54.1p3,,,-3,,90,15\n"
        'T0101,0,,80,0.4,,\nh1,,,"120",,,\nD1,,,,5,,\nEXT,1,,,,,0\n'
    )
    assert found.format == "csv-table"
    assert found.work == {
        "G54": {"X": 1, "Y": 2.5},
        "G54.1 P3": {"Z": -3, "B": 90},
        "EXT": {"X": 1},
    }
    assert found.tools == {"T0101": {"X": 0, "Z": 80, "R": 0.4}, "H1": {"Z": 120}, "D1": {"R": 5}}
    assert found.rotation == {"G54.1 P3": 15}
    assert found.notices == []
    assert told(of("name,X_mm\nG54,1", inch=True), "mm")


@pytest.mark.parametrize(
    "text, says",
    [
        ("name,X_mm\nG54,1,2", "3 cells under 2"),
        ("name,X_mm\nG99,1", "'G99'"),
        ("name,X_mm\nG54,1\ng54,2", "stands twice"),
        ("name,X_mm,R_mm\nG54,1,5", "no radius"),
        ("name,X_mm,rotation_deg\nH1,1,5", "not rotated"),
        ("name,X_mm\nG54,1mm", "'1mm'"),
        ("name,X_in\nG54,1", "column is unknown"),
        ("name,X_mm,X_mm\nG54,1", "stands twice"),
        ("name,X_mm\nG54,nan", "'nan'"),
        ('name,X_mm\n"G54,1', "cells"),
    ],
)
def test_own_table_refused(text, says):
    refused(text, "file:", says)


# -- all -------------------------------------------------------------------------------------------


def test_a_format_may_be_named_and_is_then_meant():
    assert of("5221 1", format="linuxcnc-var").work == {"G54": {"X": 1}}
    refused("5221 1", "file:1: ", format="fanuc")
    refused("5221 1", "no offset file format 'klingon'", "linuxcnc-var", format="klingon")


@pytest.mark.parametrize("text", [b"", b"\n\n", b"hello\n", b"G1 X1 Y2\n", b"x,y\n1,2\n"])
def test_what_nobody_knows_is_answered_with_what_there_is(text):
    refused(text, "file is not an offset file", *offsets.names())


@pytest.mark.parametrize("text", ["G10 L11 P1 R1.\n5221 1\n", "[G54:1.000]\nT1 P1 Z1\n"])
def test_what_may_be_two_things_is_not_guessed(text):
    refused(text, "may be", "name the format")


def test_a_file_without_offsets_is_refused():
    refused("5210 0\n5220 1\n", "no offset stands in this LinuxCNC parameter file")


@pytest.mark.parametrize(
    "text", [b"\x7fELF\x02\x01\x01" + bytes(300), b"PK\x03\x04", bytes(range(256)), b"\xff\xfe\x00"]
)
def test_a_binary_file_is_refused(text):
    refused(text, "not text")


def test_text_as_machines_and_editors_save_it():
    plain = of("5221 1\r\n5222 2\r\n").work
    assert of("5221 1\r\n5222 2".encode("utf-16")).work == plain
    assert of(b"\xef\xbb\xbf5221 1\n5222 2").work == plain
    assert of(b"\0\0\x125221 1\n5222 2\x14\x1a").work == plain
    assert of("T1 P1 Z1 ;Fr\u00e4ser".encode("latin-1")).tools == {"T1": {"Z": 1}}


def test_only_the_axes_of_a_machine():
    found = of("name,X_mm,Y_mm,Z_mm,R_mm\nG54,1,0,3,\nG55,1,5,,\nT0101,1,,,0.4\n").of("XZ")
    assert found.work == {"G54": {"X": 1, "Z": 3}, "G55": {"X": 1}}
    assert found.tools == {"T0101": {"X": 1, "R": 0.4}}
    assert found.notices == ["G55 states Y = 5, an axis that the machine has not: left out"]
    assert found.format == "csv-table"


GRAINS = [
    VAR,
    UFR,
    HASH,
    "T1 P1 Z1 D.5 ;x\n",
    "G10 L2 P1 X1. Y2.\nG10 P10001 X1. U2. Q3\n",
    "name,X_mm\nG54,1\n",
]
PIECES = st.sampled_from(
    [
        *"\n\r\t ,;:=[]()%$#.+-0159GXZPLRTDHN",
        "\u2075",
        "\u0661",
        "$P_UIFR[1]=",
        "G10",
        "5221",
        "CTRANS(",
        "1e99",
        "[G54:",
        "[TLO",
        "$TC_DP3[1,1]=",
        "9" * 5000,
    ]
)


@given(st.binary(max_size=100), st.sampled_from([None, *offsets.names()]))
@example(b"[G54:\xc2\xb2]", "grbl")
def test_no_bytes_give_anything_but_offsets_or_a_refusal(data, format):
    try:
        of(data, format=format)
    except UsageError as error:
        assert error.advice
        assert "\n" not in error.message


@given(
    st.sampled_from(GRAINS),
    st.lists(st.tuples(st.floats(0, 1), PIECES), max_size=4),
    st.sampled_from([None, *offsets.names()]),
)
def test_broken_files_give_offsets_or_a_refusal(grain, edits, format):
    for at, piece in edits:
        place = int(at * len(grain))
        grain = grain[:place] + piece + grain[place:]
    try:
        found = of(grain, format=format)
    except UsageError as error:
        assert error.advice
        return
    for name, place in [*found.work.items(), *found.tools.items()]:
        assert canonical(name) == name or name == "G43.1"
        assert set(place) <= set(offsets.TOOL_KEYS)
        assert all(abs(value) < 1e8 for value in place.values())


# -- on the command line ---------------------------------------------------------------------------


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
