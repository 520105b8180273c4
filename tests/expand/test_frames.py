"""Turned, scaled, mirrored and polar coordinates of Fanuc and Haas written out, and the maps that
do it: against formulas worked out here, from the manuals that each test names."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.cycles.affine import Affine, rotation, scaling
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.expand.frame_lines import ends, moved, turned
from tests.expand.plain_lines import (
    LATHE,
    MILL,
    expand,
    motions,
    text_of,
)

CLOSE = 1e-9  # mm
START = "G90 G0 X1 Y2 Z5|"


# -- Fanuc: G68 ------------------------------------------------------------------------------------


@pytest.mark.parametrize("degrees", [0, 30, 90, -137.5, 180, 400])
def test_g68_turns_about_its_centre(degrees):
    """B-64304EN-2, "Coordinate system rotation": counter-clockwise by R about X Y."""
    points = [(20, 10), (35.5, 10), (35.5, -3), (0, 0)]
    words = "|".join(f"X{x} Y{y}" for x, y in points)
    made = moved(START + f"G68 X10. Y-4. R{degrees}|G1 F100 {words}|Z-1.|G69|X7. Y8.")
    assert ends(made)[:4, :2] == pytest.approx(turned(points, degrees, (10, -4)), abs=CLOSE)
    assert ends(made)[4:] == pytest.approx(
        np.array([[*turned([(0, 0)], degrees, (10, -4))[0], -1], [7, 8, -1]]), abs=CLOSE
    )


def test_g68_turns_one_word_with_the_coordinate_that_holds():
    made = moved(START + "G68 X0 Y0 R30.|G0 X10. Y0|Y4.|X-3. Z2.")
    assert ends(made)[:, :2] == pytest.approx(turned([(10, 0), (10, 4), (-3, 4)], 30), abs=CLOSE)


@pytest.mark.parametrize(("plane", "i", "j"), [("G17", 0, 1), ("G18", 2, 0), ("G19", 1, 2)])
def test_g68_turns_in_its_plane(plane, i, j):
    """Counter-clockwise turns the plane's first axis towards its second: X Y, Z X, Y Z."""
    a, b = "XYZ"[i], "XYZ"[j]
    made = moved(START + f"{plane} G68 {a}1. {b}2. R25.|G1 {a}5. {b}-7. F100|G2 {a}9. {b}-3. R6.")
    assert ends(made)[:, [i, j]] == pytest.approx(turned([(5, -7), (9, -3)], 25, (1, 2)), abs=CLOSE)


def test_g68_turns_arcs_with_their_centres():
    made = moved(
        START + "G68 X0 Y0 R40.|G1 X10. Y0 F100|G3 X0 Y10. I-10. J0|G2 I5. J5.|X3. Y-2. R30."
    )
    places = turned([(0, 0), (5, 15)], 40)
    assert made[1]["centre"] == pytest.approx(places[0], abs=CLOSE) and made[1]["sweep"] > 0
    assert made[2]["centre"] == pytest.approx(places[1], abs=CLOSE) and made[2][
        "sweep"
    ] == pytest.approx(-2 * math.pi)
    assert (
        ends(made)[3, :2] == pytest.approx(turned([(3, -2)], 40)[0], abs=CLOSE)
        and made[3]["sweep"] < 0
    )


def test_increments_behind_g68_go_on_from_where_the_tool_stands():
    """The same: "the centre of rotation for an incremental command is the tool position"."""
    made = moved(START + "G68 X50. Y50. R90.|G91 G1 X3. F100|Y4. Z1.|X1. Y1.")
    assert ends(made) == pytest.approx(np.array([[1, 5, 5], [-3, 5, 6], [-4, 6, 6]]), abs=CLOSE)


def test_rounding_of_increments_does_not_add_up():
    steps = "|".join(["X.3333"] * 300)
    lines = expand((START + f"G68 X0 Y0 R33.|G91 G1 F100|{steps}").replace("|", "\n"), "fanuc-mill")
    made = motions(lines, "fanuc-mill")
    far = 300 * 0.3333
    want = [1 + far * math.cos(math.radians(33)), 2 + far * math.sin(math.radians(33))]
    assert made[-1]["end"][:2] == pytest.approx(want, abs=1e-4)


def test_holes_are_turned_with_their_place():
    made = moved(START + "G68 X0 Y0 R30.|G99 G81 X10. Y0 Z-5. R1. F100|Y10.|G80")
    assert ends(made)[[0, 4], :2] == pytest.approx(turned([(10, 0), (10, 10)], 30), abs=CLOSE)
    assert list(ends(made)[:, 2]) == [5, 1, -5, 1, 1, -5, 1]


def test_tapping_is_turned_and_stays():
    lines = text_of(
        START + "G68 X0 Y0 R90.|G84 X10. Y0 Z-5. R1. F100|X0 Y20.|G80|G69", "fanuc-mill"
    )
    assert lines[1:] == ["G84 X0. Y10. Z-5. R1. F100", "X-20. Y0.", "G80"]


FANUC_REFUSED = {
    "G68 X0 Y0 R30. Q5.": "Q in a rotation .G68.: that is no word of it",
    "G68 X0 Y0 Z1. R30.": "Z in a rotation .G68.: it lies across the plane",
    "G51 X0 Y0 Z0 P2. I2.": "P and I both say a factor",
    "G51 X0 Y0 Z0 P2. R5.": "R in a scaling .G51.: that is no word of it",
    "G51.1 X0 A9.": "A in a mirror .G51.1.: that is no word of it",
    "G68 X0 Y0 R30.|X5.": "names X alone",
    "G68 X0 Y0 R30.|G1 X5. Y5. F1|G69|G91 X1.": "is a distance",
    "G68 X0 Y0": "without its angle R",
    "G68 X0 R30.": "X alone",
    "G68 X0 Y0 Z0 I0 J0 K1 R30.": "turns in space",
    "G68 X0 Y0 R30.|G18": "another plane",
    "G68 X0 Y0 R30.|G54": "within the rotation",
    "G68 X0 Y0 R30.|G92 X0": "within the rotation",
    "G68 X0 Y0 R30.|G28 X0": "names X",
    "G68 X0 Y0 R30.|G53 G0 X0": "names X",
    "G68 X0 Y0 R30.|G20": "within the rotation",
    "G68 X0 Y0 R30.|G31 X9. Y9.": "G31 within the rotation",
    "G68 X0 Y0 R30.|X#1": "more than words and numbers",
    "G91 G68 X0 Y0 R30.|G68 X0 Y0 R30.": "in G91",
    "G68 X0 Y0 R30.|G51 X0 Y0 P2.": "G51 within a rotation",
    "G51 X0 Y0 Z0 P2.|G68 X0 Y0 R30.|G50": "G50 within a rotation",
    "G51 X0 Y0 Z0 I2. J3. K1.|G2 X5. Y5. I2. J0": "ellipse",
    "G51 X0 Y0 Z0": "without P",
    "G51 X0 Y0 Z0 P0.": "factor",
    "G51.1 X0|G68 X0 Y0 R30.": "mirror",
    "G51 X0 Y0 Z0 P2.|G51.1 X0": "mirror",
    "G51.1": "without an axis",
    "G41 D1 G1 X5. F1|G51.1 X0": "cutter radius compensation",
    "G16|X50.": "must name",
    "G16|G91 X5. Y30.": "must name",
    "G51 X0 Y0 Z0 P2.|G84 Z-5. R1.": "tapping within",
}  # fmt: skip


@pytest.mark.parametrize("program", FANUC_REFUSED)
def test_what_the_manual_leaves_open_is_refused(program):
    with pytest.raises(ProgramError, match=FANUC_REFUSED[program]) as caught:
        expand((START + program).replace("|", "\n"), "fanuc-mill")
    assert caught.value.advice


def test_references_that_name_no_turned_axis_pass():
    lines = text_of(START + "G68 X0 Y0 R30.|G1 X5. Y5. F1|G91 G28 Z0|G90 G69", "fanuc-mill")
    assert lines[2:] == ["G91 G28 Z0", "G90"]


def test_the_place_of_the_tool_is_the_centre_where_none_is_named():
    made = moved(START + "G68 R90.|G0 X4. Y2.")
    assert ends(made)[0, :2] == pytest.approx([1, 5], abs=CLOSE)
    nowhere = replace(MILL, start={}, offsets={})
    with pytest.raises(ProgramError, match="the centre is where the tool stands"):
        expand("G68 R90.\n", "fanuc-mill", nowhere)


# -- Fanuc: G51, G51.1, G16 ------------------------------------------------------------------------


def test_g51_scales_about_its_centre():
    """B-64304EN-2, "Scaling (G50, G51)": P for all axes, with a point a factor, without one counted
    in 0.001."""
    for factor in ("P2.5", "P2500"):
        made = moved(
            START
            + f"G51 X10. Y4. Z0 {factor}|G1 X12. Y-1. Z2. F1|G3 X16. Y3. I4. J0|X18. R3.|G50|X1."
            " Y1. Z1."
        )
        scale = lambda p: (np.array(p) - (10, 4, 0)) * 2.5 + (10, 4, 0)  # noqa: E731
        assert ends(made) == pytest.approx(
            np.array([scale(p) for p in [(12, -1, 2), (16, 3, 2), (18, 3, 2)]] + [(1, 1, 1)])
        )
        assert made[1]["centre"] == pytest.approx(scale((16, -1, 0))[:2])


def test_g51_scales_each_axis_and_a_negative_factor_mirrors():
    made = moved(
        START
        + "G51 X0 Y0 Z0 I-1. J1. K3.|G1 X12. Y-1. Z2. F1|G2 X16. Y3. I4. J0|G91 X1. Z1.|G90 G50|X0"
    )
    assert ends(made)[:3] == pytest.approx(np.array([(-12, -1, 6), (-16, 3, 6), (-17, 3, 9)]))
    assert made[1]["sweep"] > 0 and made[1]["centre"] == pytest.approx((-16, -1))


def test_scaling_first_and_then_the_rotation_about_the_scaled_centre():
    """B-63944EN-2, "Scaling and coordinate system rotation": scaled first; the centre is scaled,
    the angle is not."""
    points = [(5, 7), (-2, 3)]
    made = moved(
        START
        + "G51 X1. Y1. Z0 P2.|G68 X4. Y0 R30.|G1 X5. Y7. F1|X-2. Y3.|G69|G1 X5. Y7.|G50|X5. Y7."
    )
    scaled = [((x - 1) * 2 + 1, (y - 1) * 2 + 1) for x, y in points]
    assert ends(made)[:2, :2] == pytest.approx(turned(scaled, 30, (7, -1)), abs=CLOSE)
    assert ends(made)[2:, :2] == pytest.approx(np.array([scaled[0], (5, 7)]), abs=CLOSE)


def test_g51_1_mirrors_single_axes_and_swaps_arcs_and_sides():
    """B-64304EN-2, "Programmable mirror image": arcs and cutter compensation change their sense in
    one mirrored axis."""
    lines = text_of(
        START + "G51.1 X10.|G1 X12. F1|G2 X16. Y3. R9.|X20. Y7. R9.|G50.1 X0|X9. Y9. R9.|G1 X1.",
        "fanuc-mill",
    )
    assert lines[1:] == ["G1 X8. F1", "G3 X4. Y3. R9.", "X0. Y7. R9.", "G2 X9. Y9. R9.", "G1 X1."]
    both = moved(START + "G51.1 X0 Y0|G1 X12. Y1. F1|G2 X16. Y5. I4. J0")
    assert both[1]["sweep"] < 0 and both[1]["centre"] == pytest.approx((-16, -1))
    sides = text_of(START + "G51.1 Y0|G41 D1 G1 X5. Y5. F1|G40 X0 Y0", "fanuc-mill")
    assert "G42 D1" in sides[1]


def test_polar_words_about_the_work_zero():
    """B-64304EN-2, "Polar coordinate command", example: holes on 100 mm at 30, 150, 270 degrees,
    absolute and by steps."""
    for steps in ("Y150.|Y270.", "G91 Y120. K2", "G91 Y120.|Y120."):
        made = moved(START + f"G17 G90 G16|G99 G81 X100. Y30. Z-20. R-5. F200|{steps}|G15 G80")
        cut = [m["end"][:3] for m in made if m["kind"] == "feed"]
        want = [
            [100 * math.cos(math.radians(a)), 100 * math.sin(math.radians(a)), -20]
            for a in (30, 150, 270)
        ]
        assert np.array(cut) == pytest.approx(np.array(want), abs=1e-8), steps


def test_polar_radius_in_g91_counts_from_where_the_tool_stands():
    made = moved(START + "G16|G1 X10. Y0 F1|G91 X5. Y90.|Y45.|G90 G15 X0")
    want = [(10, 0), (10, 5), (10 - 5 * math.sqrt(0.5), 5 * math.sqrt(0.5))]
    assert ends(made)[:3, :2] == pytest.approx(np.array(want), abs=1e-8)


@pytest.mark.parametrize(("plane", "i", "j"), [("G17", 0, 1), ("G18", 2, 0), ("G19", 1, 2)])
def test_polar_words_in_each_plane_under_a_rotation(plane, i, j):
    a, b = "XYZ"[i], "XYZ"[j]
    made = moved(
        START + f"{plane} G68 {a}0 {b}0 R20.|G16|G1 {a}7. {b}33. F1|{b}60.|G2 {a}8. {b}90. R20."
    )
    want = [
        (r * math.cos(math.radians(p + 20)), r * math.sin(math.radians(p + 20)))
        for r, p in ((7, 33), (7, 60), (8, 90))
    ]
    assert ends(made)[:, [i, j]] == pytest.approx(np.array(want), abs=1e-8)


def test_haas_wants_a_point_in_a_factor():
    with pytest.raises(ProgramError, match="no decimal point"):
        expand("G0 X1. Y2.\nG51 X0 Y0 Z0 P2\n", "haas")
    assert text_of("G0 X1. Y2. Z1.|G51 X0 Y0 Z0 P2.|X3.", "haas")[-1] == "X6."


def test_a_lathes_double_turret_mirror_is_no_rotation():
    assert text_of("G0 X1. Z2.|G68|G0 X3.|G69", "fanuc-lathe", LATHE) == [
        "G0 X1. Z2.",
        "G68",
        "G0 X3.",
        "G69",
    ]


# -- the maps --------------------------------------------------------------------------------------


def test_a_map_and_its_inverse_are_nothing():
    draw = random.Random(1)
    for _ in range(200):
        p = tuple(draw.uniform(-100, 100) for _ in range(3))
        m = rotation(
            *draw.choice([("X", "Y"), ("Y", "Z"), ("Z", "X")]), draw.uniform(-400, 400), p
        ).after(scaling({"X": draw.uniform(0.1, 9), "Y": -draw.uniform(0.1, 9)}, p))
        assert m.inverse(m(p)) == pytest.approx(p, abs=1e-9)


def test_what_circles_become():
    assert rotation("X", "Y", 33).similarity("X", "Y") == pytest.approx(1)
    assert scaling({"X": -2, "Y": 2}).similarity("X", "Y") == pytest.approx(-2)
    assert scaling({"X": 1.1, "Y": 1}).similarity("X", "Y") is None
    assert rotation("X", "Y", 33).similarity("Z", "X") is None
    assert rotation("X", "Y", 180).partners("X") == ["X"] and Affine().leaves("Z")


def test_the_tracker_hears_what_leaves():
    lines = expand(
        (START + "G68 X0 Y0 R90.|G0 X10. Y0|G81 X20. Y0 Z-1. R1. F1|G80").replace("|", "\n"),
        "fanuc-mill",
    )
    tracker = Tracker(Interpreter(dialects.load("fanuc-mill"), MILL))
    for line in lines:
        tracker.take(line.text)
    assert [tracker.work(x) for x in "XYZ"] == pytest.approx([0, 20, 5])


def test_local_coordinates_of_nothing_stay_none_within_a_mirror():
    """G52 X0 Y0 where none are in force (Haas, mill operator's manual, G52): nothing moves, as
    without it. With a shift, before or in it, which of both comes first is not said."""
    text = START + "G101 Y0|{}G1 X3. Y4. F100|G100 Y0|X5."
    made, plain = (moved(text.format(x), "haas") for x in ("G52 X0. Y0 Z0|", ""))
    assert ends(made) == pytest.approx(ends(plain), abs=CLOSE)
    assert list(ends(made)[0, :2]) == pytest.approx([3, -4])
    for shift in ("G52 Y1.|", "G52 Y1. X0|"):
        with pytest.raises(ProgramError, match="local coordinates"):
            moved(text.format(shift), "haas")
    with pytest.raises(ProgramError, match="local coordinates"):
        moved(START + "G52 Y1.|G101 Y0|G52 Y0|G1 X3. Y4. F100", "haas")
