"""Offset files of any control: own tables, formats that are named or recognised, texts as machines
and editors save them; any bytes end in offsets or one sentence."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from postproc import offsets
from postproc.errors import UsageError
from postproc.offsets import canonical
from tests.offset_texts import HASH, UFR, VAR, of, refused, told

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


def test_every_work_offset_of_a_table_is_one():
    """G15 H1 of an Okuma and G247 P2 of a Heidenhain are zeros, and no tools."""
    found = of("name,X_mm,rotation_deg\nG15 H1,100,\nG247 P2,1,\nG54.1 P3,2,30\n")
    assert found.work == {"G15 H1": {"X": 100}, "G247 P2": {"X": 1}, "G54.1 P3": {"X": 2}}
    assert not found.tools and found.rotation == {"G54.1 P3": 30}


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
        assert set(place) <= set(offsets.AXES + "RQ")
        assert all(abs(value) < 1e8 for value in place.values())
