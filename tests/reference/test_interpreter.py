"""The reference's interpreter against motions worked out by hand."""

import math

import pytest
from pytest import approx

from .interpreter import NotUnderstood, run


def ends(text, dialect="linuxcnc", axes="XZ", **settings):
    return [
        tuple(block.end[axis] for axis in axes)
        for block in run(text, dialect, axes=axes, **settings)
        if block.kind not in ("none", "dwell")
    ]


def test_absolute_incremental_and_the_sum_does_not_drift():
    text = "G21 G90 G0 X0 Z0\nG91\n" + "G1 X0.1 F100\n" * 1000 + "G90 Z5\n"
    assert ends(text)[-1] == (100.0, 5.0)


def test_unknown_until_told():
    assert ends("G0 X1\nG91 Z5\nG90 Z2") == [(1.0, None), (1.0, None), (1.0, 2.0)]
    assert ends("G91 G0 X1 Z5", start={"X": 2}) == [(3.0, None)]


def test_lines_words_comments_and_blanks():
    text = "%\n(a ; comment) n10 g 0 x - 1 0 . 5 z+.5 ; G1 X99\n\n"
    text += "; only a comment\n/N20 G1 X2 F50 (mid) Z3.\nM2\nX7\n%\nX8"
    blocks = run(text, "linuxcnc", axes="XZ")
    assert [(b.line, b.number, b.kind) for b in blocks] == [
        (2, 0, "rapid"),
        (5, 1, "feed"),
        (6, 2, "none"),
    ]
    assert blocks[0].end == {"X": -10.5, "Z": 0.5} and blocks[1].end == {"X": 2.0, "Z": 3.0}
    assert blocks[1].feed == 50.0 and blocks[2].codes == ("M2",)
    assert [b.line for b in run(text, "linuxcnc", axes="XZ", block_delete=True)] == [2, 6]


def test_a_lathe_semicolon_ends_a_block_and_a_block_may_share_its_line():
    text = (
        "%\nO1234;\nN1 G90 G0 X40. Z2.; G1 U-4. W-2. F100; (X9;)\nG4 U1.5;G4 P250;G4 X2.\n/2 G91"
        " X2.; M30;\n%"
    )
    blocks = run(text, "fanuc-lathe", axes="ZX", diameter="X")
    assert [(b.line, b.kind) for b in blocks] == [
        (2, "none"),
        (3, "rapid"),
        (3, "feed"),
        (4, "dwell"),
        (4, "dwell"),
        (4, "dwell"),
        (5, "feed"),
        (5, "none"),
    ]
    assert blocks[2].end == {"X": 18.0, "Z": 0.0}
    assert [b.dwell for b in blocks[3:6]] == [1.5, 0.25, 2.0]
    assert blocks[6].end == {"X": 19.0, "Z": 0.0}
    # "; M30" is another block
    assert len(run(text, "fanuc-lathe", axes="ZX", diameter="X", block_delete=True)) == 7


def test_inches_and_diameters():
    assert ends("G20 G0 X2 Z1", diameter="X") == [(25.4, 25.4)]
    assert ends("G7 G0 X2 Z1\nG91 X2\nG8 X2\nG90 X2") == [
        (1.0, 1.0),
        (2.0, 1.0),
        (4.0, 1.0),
        (2.0, 1.0),
    ]
    blocks = run("G20 G94 F10 G0 X0 Z0\nG93 G1 X1 F2\nG95 G1 X2 F.01", "linuxcnc", axes="XZ")
    assert [(b.feed_mode, b.feed) for b in blocks] == [("G94", 254.0), ("G93", 2.0), ("G95", 0.254)]


def test_offsets_machine_coordinates_and_home():
    offsets = {"G54": {"X": 10.0, "Z": -100.0}, "G55": {"X": 0.1, "Z": 0.2}}
    text = "G0 X1 Z1\nG55 X1\nG53 G0 X5\nG0 X0\nG28 Z0\nG0 X3\nG28\nG54 G0 X0 Z0"
    assert ends(text, offsets=offsets) == [
        (11.0, -99.0),
        (1.1, -99.0),
        (5.0, -99.0),
        (0.1, -99.0),
        (0.1, None),
        (3.1, None),
        (None, None),
        (10.0, -100.0),
    ]
    assert [b.kind for b in run(text, "linuxcnc", axes="XZ", offsets=offsets)] == [
        "rapid",
        "rapid",
        "machine",
        "rapid",
        "machine",
        "rapid",
        "machine",
        "rapid",
    ]
    assert ends("G0 X1 Z1") == [(1.0, 1.0)]
    with pytest.raises(NotUnderstood, match="line 2: the work offset G56 is not stated"):
        run("G0 X1\nG56 X1", "linuxcnc", axes="XZ", offsets=offsets)


@pytest.mark.parametrize(
    "plane, first, second, letters",
    [("G17", "X", "Y", "IJ"), ("G18", "Z", "X", "KI"), ("G19", "Y", "Z", "JK")],
)
def test_counterclockwise_is_from_the_first_axis_to_the_second(plane, first, second, letters):
    """From (10, 0) about (0, 0) to (0, 10): a quarter with G3, three with G2."""
    text = f"G0 X0 Y0 Z0\nG0 {first}10\n{plane} %s {first}0 {second}10 {letters[0]}-10 F100"
    quarter = run(text % "G3", "linuxcnc", axes="XYZ")[-1]
    rest = run(text % "G2", "linuxcnc", axes="XYZ")[-1]
    assert (quarter.plane, quarter.centre, quarter.plane_axes) == (
        plane,
        (0.0, 0.0),
        (first, second),
    )
    assert quarter.sweep == approx(math.pi / 2, abs=1e-15) and rest.sweep == approx(
        -1.5 * math.pi, abs=1e-15
    )
    assert quarter.length == approx(5 * math.pi) and rest.length == approx(15 * math.pi)
    middle = quarter.point(0.5)
    assert (middle[first], middle[second]) == approx((10 * math.sqrt(0.5), 10 * math.sqrt(0.5)))
    assert quarter.point(1) == quarter.end and quarter.point(0) == quarter.start


def test_circles_turns_helices_and_absolute_centres():
    text = (
        "G0 X10 Y0 Z0\nG2 I-10 F100\nG3 X10 Y0 Z6 I-10 P3\nG90.1 G3 X-10 Y0 I0 J0\nG91.1 G2 X10 Y0"
        " I10 J0 P2\nG91 G3 X-20 I-10"
    )
    _, circle, helix, half, more, back = run(text, "linuxcnc", axes="XYZ")
    assert circle.sweep == approx(-2 * math.pi) and circle.start == circle.end
    assert helix.sweep == approx(6 * math.pi) and helix.point(0.5)["Z"] == 3.0
    assert (helix.point(0.5)["X"], helix.point(1 / 12)["Y"]) == approx((-10.0, 10.0))
    assert helix.length == approx(math.hypot(60 * math.pi, 6))
    assert half.sweep == approx(math.pi) and half.centre == (0.0, 0.0)
    assert more.sweep == approx(-3 * math.pi) and back.sweep == approx(math.pi)


def test_arcs_on_a_lathe_have_radii_where_words_are_diameters():
    """From (Z 0, X 10 radius) about (Z 0, X 20) to (Z -10, X 20): G18, ccw from Z to X, so G2
    sweeps -90 degrees."""
    text = "G90 G0 X20. Z0.;G2 X40. Z-10. I10. F0.1;G3 U20. W10. R10."
    _, arc, other = run(text, "fanuc-lathe", axes="XZ", diameter="X")
    assert arc.plane == "G18" and arc.centre == (0.0, 20.0)
    assert arc.sweep == approx(-math.pi / 2)
    assert other.end == {"X": 30.0, "Z": 0.0} and other.sweep == approx(math.pi / 2)
    assert other.centre == approx((-10.0, 30.0))


@pytest.mark.parametrize(
    "word, code, centre, degrees",
    [
        ("R10", "G3", (0, 0), 90),
        ("R10", "G2", (10, 10), -90),
        ("R-10", "G3", (10, 10), 270),
        ("R-10", "G2", (0, 0), -270),
    ],
)
def test_the_sign_of_r_picks_the_way_round(word, code, centre, degrees):
    arc = run(f"G0 X10 Y0\n{code} X0 Y10 {word} F1", "linuxcnc", axes="XY")[-1]
    assert arc.centre == approx(centre, abs=1e-12) and math.degrees(arc.sweep) == approx(degrees)


def test_a_sliver_stays_a_sliver_and_a_nearly_whole_circle_nearly_whole():
    """The trap of the compensated circle: an end 1 µm past the start, and 1 µm before it."""
    past = run("G0 X10 Y0\nG3 X10 Y0.001 I-10 F1", "linuxcnc", axes="XY")[-1]
    before = run("G0 X10 Y0\nG3 X10 Y-0.001 I-10 F1", "linuxcnc", axes="XY")[-1]
    assert past.length == approx(0.001, rel=1e-3) and before.length == approx(20 * math.pi - 0.001)


@pytest.mark.parametrize(
    "text, dialect, why",
    [
        ("G0 X1 X2", "linuxcnc", "twice"),
        ("G0 G1 X1", "linuxcnc", "one group"),
        ("X1", "linuxcnc", "without G0"),
        ("G0 X#1", "linuxcnc", "no number"),
        ("G0 X[1]", "linuxcnc", "no number"),
        ("G0 X1.2.3", "linuxcnc", "no number"),
        ("G0 X1e3", "linuxcnc", "no use for E"),
        ("G41 X1", "linuxcnc", "G41 is not"),
        ("G81 X1 R2", "linuxcnc", "G81"),
        ("G0 X1 (a", "linuxcnc", "not closed"),
        ("G0 U1", "linuxcnc", "no use for U"),
        ("G43 H1", "linuxcnc", "G43"),
        ("G0 X1\nG18 G2 X2 I1 F1", "linuxcnc", "unknown point"),
        ("G0 X0 Z0\nG18 G2 X9 I1 F1", "linuxcnc", "misses"),
        ("G0 X0 Z0\nG18 G2 X9 F1", "linuxcnc", "no centre"),
        ("G0 X0 Z0\nG18 G2 X9 R4 F1", "linuxcnc", "cannot reach"),
        ("G1 X1 R5", "linuxcnc", "no use for R"),
        ("G0 X1 U2", "fanuc-lathe", "X and U"),
        ("M98 P1", "fanuc-lathe", "M98"),
        ("G92 X1", "fanuc-lathe", "S alone"),
        ("G7 G0 X1", "fanuc-lathe", "G7"),
        ("G93 G1 X1", "linuxcnc", "needs F"),
        ("G91 G53 G0 X1", "linuxcnc", "absolute"),
        ("G28 ;", "fanuc-lathe", "names its axes"),
    ],
)
def test_what_it_does_not_know_it_refuses(text, dialect, why):
    with pytest.raises(NotUnderstood, match=why):
        run(text, dialect, axes="XZ")
