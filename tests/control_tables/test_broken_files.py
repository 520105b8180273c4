"""A control's table that is not whole is refused with file, line and reason: it is trusted with
somebody's axis."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc import control_tables
from postproc.control_tables import ExportOptions
from postproc.errors import GcompError, UsageError
from postproc.recordings import Source

OPTIONS = ExportOptions(reference={"X": 0.0}, extra={"cec_sign": "-"})
FANUC = (
    "axis,parameter_no,value\nX,3620,2\nX,3621,1\nX,3622,4\nX,3623,1\nX,3624,20000\nX,1,1\nX,2,0\n"
)
ENC = (
    "%_N_AX_EEC_INI\nCHANDATA(1)\n$AA_ENC_COMP[0,0,X1]=0.0\n$AA_ENC_COMP[0,1,X1]=0.001\n"
    "$AA_ENC_COMP_STEP[0,X1]=10\n$AA_ENC_COMP_MIN[0,X1]=0\n$AA_ENC_COMP_MAX[0,X1]=10\n$AA_ENC_COMP_IS_MODULO[0,X1]=0\nM17\n"
)
CEC = (
    "$AN_CEC_INPUT_AXIS[0]=(AX1)\n$AN_CEC_OUTPUT_AXIS[0]=(AX3)\n$AN_CEC_STEP[0]=10\n$AN_CEC_MIN[0]=0\n$AN_CEC_MAX[0]=10\n"
    "$AN_CEC_DIRECTION[0]=0\n$AN_CEC_MULT_BY_TABLE[0]=0\n$AN_CEC_IS_MODULO[0]=0\n$AN_CEC[0,0]=0.0\n$AN_CEC[0,1]=0.001\nM17\n"
)
COM = (
    "BEGIN A.COM MM\nNR  AXISPOS   X         \n0   0.0000    0.0010\n1   10.0000   0.0020\n[END]\n"
)
HAAS = "axis,point,position_in,value_in\nX,0,0.0,0.0001\nX,1,-0.5,0.0002\n"
FAGOR = "axis,position_mm,error_plus_mm,error_minus_mm\nX,0.0,0.001,0.002\nX,10.0,0.001,0.002\n"
MITSUBISHI = "axis,point,position_mm,increment\nX,0,0,0\nX,1,10,3\n"
G10 = (
    "%\nO1\nG10 L50\nN3620 P1 R2\nN3621 P1 R1\nN3622 P1 R4\nN3623 P1 R1\nN3624 P1 R20000\nN10001"
    " R1\nG11\nM30\n%\n"
)

BROKEN = [
    # control, name, text, line, words of the complaint
    (
        "linuxcnc",
        "X.comp",
        "# nominal forward reverse\n0 0 0\n10 10.001 10\n",
        1,
        "2 lines below are not loaded",
    ),
    ("linuxcnc", "X.comp", "0 0 0\n\n10 10.001 10\n", 2, "not three numbers"),
    ("linuxcnc", "X.comp", "0 0 0\n10 10.001\n", 2, "not three numbers"),
    ("linuxcnc", "X.comp", "0 0 0\n10 10 10\n10 10 10\n", 3, "does not ascend"),
    ("linuxcnc", "X.comp", "0 0 0\n100 0.001 0.002\n", 2, "not a file of type 0"),
    ("linuxcnc", "X.comp", "0 0 0\n10 nan 10\n", 2, "'nan' is not a number"),
    (
        "linuxcnc",
        "X.comp",
        "".join(f"{i} {i} {i}\n" for i in range(257)),
        257,
        "more than 256 entries",
    ),
    ("linuxcnc", "X.comp", " \n", 1, "empty"),
    ("siemens-enc-comp", "e.ini", ENC.replace("M17\n", ""), 8, "M17 is missing"),
    (
        "siemens-enc-comp",
        "e.ini",
        ENC.replace("[0,1,X1]", "[0,2,X1]"),
        4,
        "point 1 of X1 is missing",
    ),
    ("siemens-enc-comp", "e.ini", ENC.replace("[0,1,X1]", "[0,0,X1]"), 4, "stands twice"),
    (
        "siemens-enc-comp",
        "e.ini",
        ENC.replace("MAX[0,X1]=10", "MAX[0,X1]=30"),
        5,
        "does not give 2 points",
    ),
    ("siemens-enc-comp", "e.ini", ENC.replace("MODULO[0,X1]=0", "MODULO[0,X1]=1"), 8, "modulo"),
    (
        "siemens-enc-comp",
        "e.ini",
        ENC.replace("$AA_ENC_COMP_MIN[0,X1]=0\n", ""),
        4,
        "MIN of X1 is missing",
    ),
    ("siemens-enc-comp", "e.ini", ENC.replace("=0.001", "=0,001"), 4, "not a number"),
    ("siemens-enc-comp", "e.ini", ENC + "$AA_ENC_COMP[0,2,X1]=0\n", 10, "after M17"),
    ("siemens-cec", "c.ini", CEC.replace("[0,1]=", "[0,5]="), 10, "gap"),
    ("siemens-cec", "c.ini", CEC.replace("TABLE[0]=0", "TABLE[0]=2"), 7, "multiplied by another"),
    ("siemens-cec", "c.ini", CEC.replace("DIRECTION[0]=0", "DIRECTION[0]=3"), 6, "not 0, 1 or -1"),
    (
        "siemens-cec",
        "c.ini",
        CEC.replace("$AN_CEC_OUTPUT_AXIS[0]=(AX3)\n", ""),
        9,
        "OUTPUT_AXIS of table 0 is missing",
    ),
    ("siemens-cec", "c.ini", CEC.replace("(AX3)", "(Q9)"), 10, "which axis is Q9"),
    (
        "siemens-cec",
        "c.ini",
        CEC[:-4] + CEC.replace("[0", "[1"),
        20,
        "in a direction that another has already",
    ),
    (
        "siemens-cec",
        "c.ini",
        CEC.replace("$AN_CEC_STEP", "$AN_CEC_STEPS"),
        3,
        "no line of a cross error",
    ),
    ("fanuc", "f.csv", FANUC.replace("X,2,0", "X,9,0"), 8, "compensation number 9 is of no axis"),
    ("fanuc", "f.csv", FANUC.replace("X,2,0", "X,3,0"), 7, "number 2 is missing between 1 and 3"),
    ("fanuc", "f.csv", FANUC.replace("X,2,0", "X,1,0"), 8, "stands twice"),
    ("fanuc", "f.csv", FANUC.replace("X,2,0", "X,2,200"), 8, "not an increment"),
    ("fanuc", "f.csv", FANUC.replace("X,2,0", "X,2,0.5"), 8, "not an increment"),
    ("fanuc", "f.csv", FANUC.replace("X,2,0", "X,2"), 8, "2 values under 3 columns"),
    ("fanuc", "f.csv", FANUC.replace("X,3624,20000\n", ""), 0, "parameter 3624 of X is missing"),
    (
        "fanuc",
        "f.csv",
        FANUC.replace("X,1,1\n", "Y,1,1\n"),
        7,
        "lies in the range of X and of another axis",
    ),
    ("fanuc", "f.nc", G10.replace("G11\n", ""), 11, "G11 is missing"),
    (
        "fanuc",
        "f.nc",
        G10.replace("N10001 R1", "N10001 R"),
        9,
        "no parameter or compensation number",
    ),
    ("fanuc", "f.nc", G10.replace("N3620 P1", "N3620 P7"), 4, "no axis number 7"),
    ("fanuc", "f.nc", G10.replace("N3620 P1", "N3630 P1"), 4, "parameter 3630 is none of"),
    ("fanuc", "f.nc", G10.replace("N10001 R1", "G1 X5"), 9, "no parameter or compensation number"),
    ("heidenhain", "AXIS_X.COM", COM.replace("[END]\n", ""), 4, "[END] is missing"),
    ("heidenhain", "AXIS_X.COM", COM.replace("\n1   10", "\n2   10"), 4, "where NR 1 is due"),
    ("heidenhain", "AXIS_X.COM", COM.replace("10.0000 ", "-1.0000 "), 4, "does not ascend"),
    ("heidenhain", "AXIS_X.COM", COM.replace("   0.0020", ""), 4, "a value is missing"),
    ("heidenhain", "AXIS_X.COM", COM.replace("0.0020", "0,0020"), 4, "not a number"),
    ("heidenhain", "AXIS_X.COM", COM.replace("AXISPOS", "POSITIO"), 0, "no line of columns"),
    ("haas", "h.csv", HAAS.replace("-0.5", "-0.6"), 0, "not 0, -0.5, -1.0"),
    ("haas", "h.csv", HAAS.replace("X,1,", "X,0,"), 3, "does not ascend"),
    ("fagor", "f.csv", FAGOR.replace("10.0,", "-10.0,"), 3, "does not ascend"),
    ("fagor", "f.csv", FAGOR.replace("error_plus_mm", "error"), 1, "the columns are"),
    ("mitsubishi", "m.csv", MITSUBISHI.replace("10,3", "10,3.5"), 3, "not a whole number"),
    ("mitsubishi", "m.csv", MITSUBISHI.replace("10,3", "10,300"), 0, "beyond -128 to 127"),
]


@pytest.mark.parametrize(("control", "name", "text", "line", "words"), BROKEN)
def test_a_broken_table_is_refused_with_file_line_and_reason(control, name, text, line, words):
    with pytest.raises(GcompError) as caught:
        control_tables.load(control).read(Source(name, text.encode()), OPTIONS)
    assert words in str(caught.value), str(caught.value)
    if line:
        assert caught.value.place is not None and str(caught.value.place) == f"{name}:{line}"
    else:
        assert name in str(caught.value)


@pytest.mark.parametrize(
    "text", [("siemens-enc-comp", ENC), ("siemens-cec", CEC), ("fanuc", FANUC), ("fanuc", G10)]
)
def test_the_whole_file_is_read(text):
    assert control_tables.load(text[0]).read(Source("f", text[1].encode()), OPTIONS)


def test_bytes_that_are_no_text_are_refused_with_their_line():
    with pytest.raises(GcompError, match="X.comp:2: byte 255 is not UTF-8"):
        control_tables.load("linuxcnc").read(Source("X.comp", b"0 0 0\n\xff 1 1\n"), OPTIONS)


def test_an_axis_that_the_file_does_not_say_is_asked_for():
    for control, text in (("linuxcnc", "0 0 0\n"), ("heidenhain", COM)):
        with pytest.raises(UsageError, match="axis"):
            control_tables.load(control).read(Source("table.txt", text.encode()), OPTIONS)
        told = replace(OPTIONS, extra={"axis": "Z"})
        assert (
            control_tables.load(control).read(Source("table.txt", text.encode()), told)[0].moving
            == "Z"
        )


MINE = (
    "linuxcnc",
    "fanuc",
    "siemens-enc-comp",
    "siemens-cec",
    "heidenhain",
    "haas",
    "fagor",
    "mitsubishi",
)
WHOLE = {
    "linuxcnc": "0 0 0\n10 10.001 10\n",
    "fanuc": FANUC,
    "siemens-enc-comp": ENC,
    "siemens-cec": CEC,
    "heidenhain": COM,
    "haas": HAAS,
    "fagor": FAGOR,
    "mitsubishi": MITSUBISHI,
}


@pytest.mark.parametrize("control", MINE)
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_any_bytes_end_in_tables_or_one_sentence(control, data):
    """A whole file with a few characters put in, taken out or exchanged, or bytes of any kind."""
    text = WHOLE[control]
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(text)))
        gone = data.draw(st.integers(0, 6))
        text = (
            text[:at]
            + data.draw(st.text("0123456789.,;-+eEnaX[]()=\n \t%$#GNPR", max_size=4))
            + text[at + gone :]
        )
    raw = data.draw(st.one_of(st.just(text.encode()), st.binary(max_size=40)))
    try:
        tables = control_tables.load(control).read(
            Source("AXIS_X.COM", raw), replace(OPTIONS, extra={"axis": "X", "cec_sign": "-"})
        )
    except GcompError as error:
        assert error.message
    else:
        assert all(len(t.nodes) for t in tables)
