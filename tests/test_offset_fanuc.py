"""Fanuc's offset files (G10): what they say in mm and radius, what is told, and what is refused
with its line."""

from __future__ import annotations

import pytest

from postproc import offsets
from tests.offset_texts import of, refused, told


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


def test_fanuc_integers_are_whole_units_and_reported():
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
