"""Drilling cycles of Fanuc's and Haas' mills, and pockets of Haas: plain lines and places by hand,
from the manuals that each test names."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from postproc.errors import ProgramError
from tests.expand.plain_lines import MILL, expand, motions, text_of


def test_fanuc_g81_goes_to_the_initial_level_in_g98_and_to_r_in_g99():
    """B-64304EN-2, G81: positioning, rapid to point R, feed to Z, rapid to R (G99) or the initial
    level (G98)."""
    assert text_of(
        "G0 X0 Y0 Z50|N10 G99 G81 X10. Y20. Z-5. R2. F100 (hole)|G98 X30. M8|G80|X5.", "fanuc-mill"
    ) == [
        "G0 X0 Y0 Z50",
        "N10 G99 G0 X10. Y20. F100 (hole)",
        "Z2.",
        "G1 Z-5.",
        "G0 Z2.",
        "G98 G0 X30. M8",
        "G1 Z-5.",
        "G0 Z50.",
        "G80",
        "G0 X5.",
    ]


def test_behind_g80_the_motion_code_from_before_the_cycle_holds():
    lines = text_of(
        "G0 Z50|G1 X1 F100|G81 X10. Z-5. R2.|G80|M8|X5.|G81 X1. Z-5. R2.|G80 G0 X3", "fanuc-mill"
    )
    assert lines[lines.index("M8") + 1] == "G1 X5." and lines[-1] == "G80 G0 X3"


def test_fanuc_g91_repeats_and_counts_r_from_the_initial_level_and_z_from_r():
    lines = motions(
        expand("G0 X0 Y0 Z50\nG91 G81 X10. Z-12. R-48. K3\nG80\n", "fanuc-mill"), "fanuc-mill"
    )
    assert [m["end"][:3] for m in lines][1:5] == [
        [10, 0, 50],
        [10, 0, 2],
        [10, 0, -10],
        [10, 0, 50],
    ]
    assert [m["end"][0] for m in lines[1:]] == [10] * 4 + [20] * 4 + [30] * 4


def test_fanuc_data_hold_from_cycle_to_cycle_and_through_g90():
    lines = text_of(
        "G0 Z50|G91 G81 X1. Z-12. R-48.|G90 X5.|G82 X6. P500|G99 G85 X7.|X8. K0|G80", "fanuc-mill"
    )
    assert lines[5:] == [
        "G90 G0 X5.", "Z2.", "G1 Z-10.", "G0 Z50.",
        "G0 X6.", "Z2.", "G1 Z-10.", "G4 P500", "G0 Z50.",
        "G99 G0 X7.", "Z2.", "G1 Z-10.", "Z2.", "G80",
    ]  # fmt: skip


def test_fanuc_pecks_reach_q_each_and_the_bottom_exactly():
    """B-64304EN-2, G83: q each, out to R, back to d above the last depth; G73: back by d. d is 0.5
    mm here."""
    deep = text_of("G0 Z50|G99 G83 X1. Z-5. R1. Q2.5", "fanuc-mill")[1:]
    assert deep == [
        "G99 G0 X1.",
        "Z1.",
        "G1 Z-1.5",
        "G0 Z1.",
        "Z-1.",
        "G1 Z-4.",
        "G0 Z1.",
        "Z-3.5",
        "G1 Z-5.",
        "G0 Z1.",
    ]
    chips = text_of("G0 Z50|G99 G73 X1. Z-5. R1. Q2.5", "fanuc-mill")[1:]
    assert chips == [
        "G99 G0 X1.",
        "Z1.",
        "G1 Z-1.5",
        "G0 Z-1.",
        "G1 Z-4.",
        "G0 Z-3.5",
        "G1 Z-5.",
        "G0 Z1.",
    ]


def test_fanuc_g86_stops_the_spindle_and_g89_dwells_before_the_feed_back():
    assert text_of("G0 Z9|M3|G99 G86 Z-1. R2.", "fanuc-mill")[2:] == [
        "G99 G0 Z2.",
        "G1 Z-1.",
        "M5",
        "G0 Z2.",
        "M3",
    ]
    assert text_of("G0 Z9|G99 G89 Z-1. R2. P50", "fanuc-mill")[1:] == [
        "G99 G0 Z2.",
        "G1 Z-1.",
        "G4 P50",
        "Z2.",
    ]


def test_tapping_stays_and_gets_the_words_that_the_control_would_have_held():
    lines = text_of("G0 Z50|G99 G81 X1. Z-5. R2.|G98 G84 X2.|X3.|G80 G0 X9", "fanuc-mill")
    assert lines[5:] == ["G0 Z50.", "G98 G84 X2. R2. Z-5.", "X3.", "G80 G0 X9"]


def test_of_a_cycle_and_another_motion_code_in_a_block_the_last_holds():
    assert text_of("G0 Z50|G81 G1 X5. Z3. F1", "fanuc-mill")[-1] == "G81 G1 X5. Z3. F1"
    assert text_of("G0 Z50|G99 G1 G81 X5. Z-3. R1. F1", "fanuc-mill")[1] == "G99 G0 X5. F1"


def test_haas_pecks_that_grow_less():
    """Haas mill operator's manual, G83 with I J K: first peck I, each less by J, none below K."""
    lines = text_of("G0 Z2.|G99 G83 X1. Z-2. R0. I1. J.4 K.5", "haas")
    assert [float(line[4:]) for line in lines if line.startswith("G1")] == [-1, -1.6, -2]


@pytest.mark.parametrize("code", ["G76", "G87", "G88"])
def test_what_a_parameter_or_the_operator_shapes_is_refused(code):
    with pytest.raises(ProgramError, match="can not be written out"):
        expand(f"G0 Z50\n{code} X1. Z-5. R2. Q.1\n", "fanuc-mill")


def test_an_unknown_place_is_asked_for_and_only_where_it_matters():
    nowhere = replace(MILL, start={}, offsets={})
    with pytest.raises(ProgramError, match="where Z stands") as caught:
        expand("G81 X1. Y1. Z-1. R2.\n", "fanuc-mill", nowhere)
    assert "--start Z0" in caught.value.advice
    assert len(expand("G99 G81 X1. Y1. Z-1. R2.\n", "fanuc-mill", nowhere)) == 5
    with pytest.raises(ProgramError, match="initial level is where Z stood"):
        expand("G99 G81 X1. Y1. Z-1. R2.\nG98 X2.\n", "fanuc-mill", nowhere)
    with pytest.raises(ProgramError, match="an offset in force is not stated"):
        expand(
            "G0 Z50\nG43 H1\nG81 X1. Y1. Z-1. R2.\n",
            "fanuc-mill",
            replace(nowhere, start={"Z": 0.0}),
        )
    assert expand("G0 G43 H1 Z50\nG81 X1. Y1. Z-1. R2.\n", "fanuc-mill", nowhere)


def test_g12_and_g13_of_haas_are_circles_about_where_the_tool_stands():
    """Manual: I is the finished radius, less the tool's, 5: 10. I 8 by Q 5 to K 15 is 8, 13, 15: 3,
    8, 10. All arcs; the last circle is gone round in two halves, and half a circle leads in and
    out."""
    setup = replace(MILL, offsets={"D1": {"R": 5.0}}, start=dict.fromkeys("XYZABC", 0.0))
    lines = text_of("G90 G17 G0 X10. Y20. Z1.|G13 I15. D1 Z-2. F100.|G0 Z9.", "haas", setup)
    ring = [
        "G3 X20. Y20. I5. J0.",
        "X0. Y20. I-10. J0.",
        "X20. Y20. I10. J0.",
        "X10. Y20. I-5. J0.",
    ]
    assert lines[1:] == ["G1 Z-2. F100.", *ring, "G0 Z9."]
    lines = text_of("G90 G17 G0 X10. Y20. Z1.|G12 I8. K15. Q5. D1|G0 Z9.", "haas", setup)
    ends = [float(re.search(r"X(-?[0-9.]+)", line)[1]) - 10.0 for line in lines[1:-1]]
    assert ends == [3.0, -3.0, 3.0, -8.0, 8.0, -8.0, 10.0, -10.0, 10.0, 0.0]
    assert lines[1].startswith("G2 ") and not any("Z" in line for line in lines[1:-1])
    lines = text_of("G17 G0 X0. Y0. Z0.|G91 G13 I8. D0 Z-1. L2|G90 G0 Z9.", "haas", setup)
    assert (
        lines.count("G1 Z-1.") + lines.count("G91 G1 Z-1.") == 2
        and lines[2] == "G3 X8. Y0. I4. J0."
    )


def test_a_mill_drills_without_r_from_where_it_stands():
    """B-63534EN, "Canned cycle cancel": G80 leaves R = 0 and Z = 0 in incremental command."""
    assert text_of("G0 Z9.|G98 G81 X5. Z-1.", "haas")[1:] == ["G98 G0 X5.", "G1 Z-1.", "G0 Z9."]
    assert text_of("G0 Z9.|G98 G81 X5. Z-1.|X6. R2.", "haas")[-4:] == [
        "G0 X6.",
        "Z2.",
        "G1 Z-1.",
        "G0 Z9.",
    ]
    assert text_of("G0 Z9.|G91 G98 G81 X5. Z-3.", "fanuc-mill")[-2:] == ["G1 Z-3.", "G0 Z3."]


def test_haas_dwells_behind_the_last_peck():
    """Haas mill operator's manual, G73, G83: P is a dwell behind the last peck."""
    for code in ("G73", "G83"):
        assert text_of(f"G0 Z9.|G99 {code} Z-1. R2. Q3. P.5", "haas")[-3:] == [
            "G1 Z-1.",
            "G4 P.5",
            "G0 Z2.",
        ]
