"""Offset files of LinuxCNC and GRBL: what they say in mm and radius, what is told, and what is
refused with its line."""

from __future__ import annotations

import pytest

from tests.offset_texts import HASH, VAR, of, refused, told

# -- LinuxCNC --------------------------------------------------------------------------------------


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


# -- GRBL ------------------------------------------------------------------------------------------


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
