"""Sinumerik's frames (TRANS, ROT, SCALE, MIRROR) and polar words written out: against formulas
worked out here, from the programming manual."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from postproc.errors import ProgramError
from tests.expand.frame_lines import ends, moved, turned
from tests.expand.plain_lines import (
    LATHE,
    expand,
    text_of,
)


def test_rot_turns_about_the_shifted_zero_and_trans_ends_it():
    """Programming manual, "Programmable rotation": AROT goes on from TRANS, TRANS replaces all."""
    lines = text_of(
        "G0 X0 Y0 Z50|TRANS X10 Y5|AROT Z30|G1 X20 Y10 F100|X=30|Y=IC(5)|TRANS|X0 Y0|X3", "siemens"
    )
    places = turned([(20, 10), (30, 10), (30, 15)], 30)
    got = [[float(w[1:]) for w in line.split() if w[0] in "XY"] for line in lines[2:5]]
    assert np.array(got) == pytest.approx(places, abs=1e-5)
    assert lines[1] == "TRANS X10 Y5" and lines[5:] == ["TRANS", "X0 Y0", "X3"]


def test_additive_frames_go_on_in_the_coordinates_that_hold():
    """ATRANS within turned coordinates goes along them; ASCALE scales what comes behind it."""
    made = moved(
        "G0 X0 Y0 Z5|ROT RPL=90|ATRANS X10|ASCALE X2 Y2|G1 X3 Y1 F100|G2 X5 Y3 I2 J0", "siemens"
    )
    assert ends(made)[:, :2] == pytest.approx(np.array([(-2, 16), (-6, 20)]), abs=1e-9)
    assert made[1]["centre"] == pytest.approx((-2, 20))


def test_mirror_turns_arcs_round_and_scale_counts_from_zero():
    lines = text_of(
        "G0 X0 Y0 Z5|MIRROR X0|G2 X12 Y3 CR=30 F1|X1 Y1 CR=30|SCALE X2 Y2|G2 X14 Y5 CR=20|ROT|G2 X1"
        " Y1 CR=60",
        "siemens",
    )
    assert [line.split()[0] for line in lines[1:]] == [
        "TRANS",
        "G3",
        "X-1.",
        "TRANS",
        "G2",
        "TRANS",
        "G2",
    ]
    assert "X28. Y10. CR=40." in lines[5]


def test_polar_words_about_a_pole():
    made = moved(
        "G0 X0 Y0 Z5|G111 X10 Y10|G1 RP=10 AP=90 F100|AP=180|AP=IC(90)|RP=5|G110 X1|RP=2 AP=0",
        "siemens",
    )
    assert ends(made)[:, :2] == pytest.approx(
        np.array([(10, 20), (0, 10), (10, 0), (10, 5), (13, 5)]), abs=1e-9
    )


@pytest.mark.parametrize("frame", ["", "TRANS X7 Y-3|", "ROT Z40|"])
def test_an_arc_in_polar_words_goes_about_the_pole(frame):
    """The manual's own pair: G3 X17.203 Y38.029 I-17.5 J-30.211 from X67.5 Y80.211, and G111 X50
    Y50, G3 RP=34.913 AP=200.052; then AP alone, and a clockwise one back."""
    head = f"G0 X0 Y0 Z5|{frame}G0 X67.5 Y80.211|"
    polar = "G111 X50 Y50|G3 RP=34.913 AP=200.052 F500|AP=270|G2 AP=200.052"
    plain = (
        "G3 X17.203 Y38.029 I-17.5 J-30.211 F500|X50 Y15.087 I32.797 J11.971|"
        "G2 X17.203 Y38.029 I0 J34.913"
    )
    lines, others = text_of(head + polar, "siemens"), text_of(head + plain, "siemens")
    numbers = [
        [float(v) for v in re.findall(r"[XYIJ]=?(-?[\d.]+)", line)]
        for line in (*lines[-3:], *others[-3:])
    ]
    for made, meant in zip(numbers[:3], numbers[3:], strict=True):
        assert made == pytest.approx(meant, abs=1.5e-3)


@pytest.mark.parametrize(
    ("program", "why"),
    [
        ("ROT Z30|X5", "names X alone"),
        ("ROT Z30|G91 X5 Y3", "a distance"),
        ("ROT X30 Y30", "about 2 axes"),
        ("ROT X30|G1 X1 Y1 Z1 F1|G41 G1 X2 D1|G2 X11 CR=9", "cutter radius compensation on"),
        ("AP=30", "without RP"),
        ("SCALE X0", "factors"),
        ("ROT Z30|G70", "G70"),
        ("ROT Z30 F1", "a block of its own"),
        ("SCALE X2 Y2|G1 X1 Y1 RND=3 F1", "RND"),
        ("G111 X1 RP=3", "polar words"),
        ("G1 X3 RP=3 AP=4 F1", "beside polar words"),
    ],
)
def test_sinumerik_frames_that_can_not_be_vouched_for_are_refused(program, why):
    with pytest.raises(ProgramError, match=why) as caught:
        expand(("G0 X0 Y0 Z5|" + program).replace("|", "\n"), "siemens")
    assert caught.value.advice


@pytest.mark.parametrize(
    ("program", "lines"),
    [
        ("G1 X1 F500|X2 FB=200|X3|X4", "G1 X1 F500|X2 F200|F500|X3|X4"),
        ("G1 X1 F=500|X2 FB=200|X3 FB=50|X4 F30|X5", "G1 X1 F=500|X2 F200|X3 F50|X4 F30|X5"),
        ("G1 X1 F500|X2 FB=200|; a remark|G0 X3", "G1 X1 F500|X2 F200|; a remark|F500|G0 X3"),
        ("G1 X2 FB=200", "G1 X2 F200"),
    ],
)
def test_a_feed_for_one_block(program, lines):
    assert text_of(program, "siemens") == lines.split("|")


@pytest.mark.parametrize(
    "program",
    [
        "DIAMON|G111 Z0 X0|G1 AP=90 RP=10 F1",
        "G111 Z0 X0|DIAMON|G1 AP=90 RP=10 F1",
        "DIAM90|G111 Z0 X0",
        "DIAMON|G110 Z5 X5",
        "G111 Z0 X0",
    ],
)
def test_polar_words_of_a_diameter_are_refused(program):
    """Whether RP and the pole's X are diameters is in no manual that was found. A lathe's X is one
    without a word."""
    setup = LATHE if program == "G111 Z0 X0" else replace(LATHE, diameter=frozenset())
    with pytest.raises(ProgramError, match="polar words while X is a diameter") as caught:
        text_of("G18 G0 X0 Z9|" + program, "siemens", setup)
    assert caught.value.advice == "write DIAMOF before"


def test_polar_words_of_a_lathe_in_radii():
    """The pole in X0 Z0, 10 along X; then 45 degrees about it: its centre lies 10 below."""
    program = "G18 G0 X0 Z9|DIAMOF|G111 Z0 X0|G1 AP=90 RP=10 F1|G3 AP=45 RP=10"
    assert text_of(program, "siemens", LATHE)[2:] == [
        "G1 Z0. X10. F1",
        "G3 Z7.07107 X7.07107 K0. I-10.",
    ]


def test_a_block_behind_such_a_feed_wants_the_one_before():
    with pytest.raises(ProgramError, match="no F was in force before it"):
        text_of("G1 X2 FB=200|X3", "siemens")


@pytest.mark.parametrize(("frame", "z"), [("SCALE Z2", "Z6."), ("MIRROR Z0", "Z-3.")])
@pytest.mark.parametrize("diameters", ["DIAMON", "DIAM90"])
def test_diameters_stay_where_the_frame_leaves_x_alone(frame, z, diameters):
    """DIAMON, and DIAM90 in G90: a frame along Z changes no X word; one of X is refused."""
    lines = text_of(f"G18 {diameters}|G0 X10 Z5|{frame}|G1 X20 Z3 F1|X30", "siemens")
    assert lines[-2:] == [f"G1 X20 {z} F1", "X30"]
    with pytest.raises(ProgramError, match="X is a diameter within the programmed frame"):
        text_of(f"G18 {diameters}|G0 X10 Z5|SCALE X2|G1 X20 Z3 F1", "siemens")
