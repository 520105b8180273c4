"""Sinumerik's frames (TRANS, ROT, SCALE, MIRROR) and polar words written out: against formulas
worked out here, from the programming manual."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.errors import ProgramError
from tests.expand.frame_lines import ends, moved, turned
from tests.expand.plain_lines import (
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


@pytest.mark.parametrize(
    ("program", "why"),
    [
        ("ROT Z30|X5", "names X alone"),
        ("ROT Z30|G91 X5 Y3", "a distance"),
        ("ROT X30 Y30", "about 2 axes"),
        ("ROT X30|G1 X1 Y1 Z1 F1|G2 X11 I4 J1", "ellipse"),
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
