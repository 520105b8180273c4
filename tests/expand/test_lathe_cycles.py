"""Turning cycles of Fanuc's and Haas' lathes: plain lines and places by hand, from the manuals that
each test names."""

from __future__ import annotations

import re

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Line, Program
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.expand.plain_lines import LATHE, lathe, text_of


def test_g90_of_system_a_is_g77_of_b_and_g20_of_c():
    """B-64304EN-1, "Outer diameter/internal diameter cutting cycle": rapid in, cut, feed out, rapid
    back; X holds."""
    for code, dialect in (
        ("G90", "fanuc-lathe-a"),
        ("G77", "fanuc-lathe"),
        ("G20", "fanuc-lathe-c"),
    ):
        assert lathe(f"G0 X60. Z2.|{code} X50. Z-30. F.2|X45. M8|G0 X100.", dialect) == [
            "G0 X60. Z2.",
            "G0 X50. F.2", "G1 Z-30.", "X60.", "G0 Z2.",
            "G0 X45. M8", "G1 Z-30.", "X60.", "G0 Z2.", "G0 X100.",
        ]  # fmt: skip


def test_tapers_of_g90_and_g94():
    """The same, "Taper cutting cycle": with U<0 W<0 R<0 the cut begins on a smaller radius, by R,
    than it ends on."""
    assert lathe("G0 X60. Z2.|G90 U-10. W-32. R-5.")[1:] == [
        "G0 X40.",
        "G1 X50. Z-30.",
        "X60.",
        "G0 Z2.",
    ]
    assert lathe("G0 X60. Z2.|G94 X20. Z-5. R-1.")[1:] == [
        "G0 Z-6.",
        "G1 X20. Z-5.",
        "Z2.",
        "G0 X60.",
    ]


def test_g71_cuts_by_d_down_to_the_shape_and_then_along_it():
    """B-64304EN-1, "Stock removal in turning (G71)", type I: C is A moved by du/2 and dw, cuts dd
    apart, escape e at 45 degrees, the last cut along the shape, and back to A. Levels: radius 50.5
    - 4 n above 20.5."""
    lines = lathe(
        "G0 X100. Z2.|G71 U4. R1.|G71 P10 Q20 U1. W.5 F.3|N10 G0 X40.|G1 Z-20. F.1|N20 X100."
        " Z-50.|G0 X200."
    )
    assert lines[1] == "G0 X101. Z2.5 F.3"
    levels = [2 * (50.5 - 4 * n) for n in range(1, 8)]
    assert [line for line in lines if re.fullmatch(r"X[\d.]+", line)][:-1] == [
        f"X{x:g}." for x in levels
    ]
    ends = [-19.5 - (x - 41) / 2 for x in levels]  # the shape falls by 30 mm in radius over 30 mm
    assert [float(line[4:]) for line in lines if line.startswith("G1 Z")][:-1] == pytest.approx(
        ends
    )
    assert lines[4] == f"G0 X{levels[0] + 2:g}. Z{ends[0] + 1:g}"
    assert lines[-5:] == ["X41.", "G1 Z-19.5", "X101. Z-49.5", "G0 X100. Z2.", "G0 X200."]


def test_g71_ends_its_cuts_on_arcs():
    """The fillet is a circle about (Z-30, X80), radius 10; level radius 38.5: Z = -30 - sqrt(100 -
    2^2) + 0.5."""
    lines = lathe(
        "G0 X100. Z2.|G71 U4. R1.|G71 P10 Q20 U1. W.5|"
        "N10 G0 X40.|G1 Z-20.|X60. Z-30.|G2 X80. Z-40. R10.|N20 G1 X100.|G0 Z9."
    )
    assert lines[lines.index("X77.") + 1] == f"G1 Z{-30 - (100 - 2**2) ** 0.5 + 0.5:.3f}"
    assert "G2 X81. Z-39.5 R10." in lines


def test_g72_is_g71_with_the_axes_changed_over_and_g70_follows():
    lines = lathe(
        "G0 X100. Z2.|G72 W4. R1.|G72 P10 Q20|N10 G0 Z-9.|G1 X80.|N20 X60. Z1.|G70 P10 Q20"
        " F.1|G0 Z9."
    )
    assert lines[1:5] == ["G0 Z-2.", "G1 X66.", "G0 X68. Z-1.", "X100."]
    assert lines[-10:] == [
        "Z-9.", "G1 X80.", "X60. Z1.", "G0 X100. Z2.",
        "F.1", "N10 G0 Z-9.", "G1 X80.", "N20 X60. Z1.", "G0 X100. Z2.", "G0 Z9.",
    ]  # fmt: skip


def test_one_block_form_and_internal_shapes():
    lines = lathe(
        "G0 X20. Z2.|G71 P10 Q20 U-1. W.5 D3000|N10 G1 X60.|Z-20.|X40. Z-30.|N20 X20.|G0 Z9."
    )
    assert lines[1:6] == ["G0 X19. Z2.5", "G1 X25.", "Z-29.5", "G0 X24. Z-29.", "Z2.5"]


def test_g73_repeats_the_shape_nearer_each_time():
    """B-64304EN-1, "Pattern repeating (G73)": di, dk shared over d cuts, the last one du/2 and dw
    off."""
    lines = lathe(
        "G0 X100. Z2.|G73 U6. W3. R3|G73 P10 Q20 U1. W.5|N10 G0 X40. Z0.|N20 G1 Z-20.|G0 Z9."
    )
    assert lines[1:-1] == [
        "G0 X113. Z5.5",
        "X53. Z3.5",
        "G1 Z-16.5",
        "G0 X107. Z4.",
        "X47. Z2.",
        "G1 Z-18.",
        "G0 X101. Z2.5",
        "X41. Z0.5",
        "G1 Z-19.5",
        "G0 X100. Z2.",
    ]


def test_g74_and_g75_peck_by_least_increments():
    """B-64304EN-1, "End face peck drilling (G74)", "Outer diameter drilling (G75)": P, Q count
    0.001 mm, radius."""
    lines = lathe("G0 X100. Z2.|G74 R1.|G74 X88. Z-6. P6000 Q5000|X20.")
    one = ["G1 Z-3.", "G0 Z-2.", "G1 Z-6.", "G0 Z2."]
    assert lines[1:] == [*one, "X88.", *one, "X100.", "G0 X20."]
    lines = lathe("G0 X100. Z2.|G75 R.5|G75 X90. Z-2. P3000 Q4000|G0 X120.")
    one = ["G1 X94.", "G0 X95.", "G1 X90.", "G0 X100."]
    assert lines[1:] == [*one, "Z-2.", *one, "Z2.", "G0 X120."]


def test_g75_draws_the_tool_aside_behind_the_first_cut():
    """B-64304EN-1, G75: R of the second block is the "relief amount of the tool at the cutting
    bottom"; ADTECH CNC4620 3.6.6: against the step, and not at the first cut. Steps to -Z: 0.2 to
    +Z; in G74 steps to +X: 0.1 by the radius to -X, so X 102 - 0.2 = 101.8."""
    out = ["G0 X100.", "Z-2."]
    lines = lathe("G0 X100. Z2.|G75 R.5|G75 X90. Z-6. P9000 Q4000 R.2|G0 X120.")
    one = ["G1 X90.", "G0 Z-1.8", "X100."]
    last = ["Z-6.", "G1 X90.", "G0 Z-5.8", "X100.", "Z2."]
    assert lines[1:] == ["G1 X90.", *out, *one, *last, "G0 X120."]
    lines = lathe("G0 X100. Z2.|G74 R.5|G74 X102. Z-6. P1000 Q9000 R.1|G0 Z9.")
    assert lines[1:] == [
        *("G1 Z-6.", "G0 Z2.", "X102."),
        *("G1 Z-6.", "G0 X101.8", "Z2.", "X100."),
        "G0 Z9.",
    ]


def test_m_codes_of_a_shape_are_the_finishings():
    """30i B-63944EN-1, 4.2.1, note 3: F, S and T between A and B are ineffective, "M and second
    auxiliary functions are treated in the same way". A G72 may name V, where it is 0."""
    shape = "G0 X50. Z2.|G71 U5. R1.|G71 P10 Q20|N10 G0 X40.{}|N20 G1 Z-5.{}|G70 P10 Q20|G0 X60."
    bare, full = lathe(shape.format("", "")), lathe(shape.format(" M8", " T0202 M6"))
    assert full[:-4] == bare[:-4]
    assert full[-4:] == ["N10 G0 X40. M8", "N20 G1 Z-5. T0202 M6", "G0 X50. Z2.", "G0 X60."]
    face = "G0 X50. Z2.|G72 W1. R1.|G72 P10 Q20 U0{}|N10 G0 Z-2.|N20 G1 X0.|G0 Z9."
    assert lathe(face.format(" V0 W0")) == lathe(face.format(" W0"))


def test_a_zero_centre_word_outside_of_the_plane_of_a_shape_says_nothing():
    """As G2 does outside of a shape on Fanuc's lathes; any other value is refused."""
    shape = "G0 X50. Z2.|G71 U5. R1.|G71 P10 Q20|N10 G0 X40.|N20 G2 X44. Z-2. I2.{} K0|G0 X60."
    assert lathe(shape.format(" J0.0")) == lathe(shape.format(""))
    with pytest.raises(ProgramError, match="in the shape of a cycle"):
        lathe(shape.format(" J1."))


def test_threads_of_a_lathe_stay_and_end_where_they_began():
    program = (
        "G0 X30. Z2.|G92 X29. Z-20. F1.5|X28.5|G0 X40.|G76 P011060 Q100 R.05|G76 X28. Z-20. P900"
        " Q300 F1.5|G90 U-2. Z-5."
    )
    assert lathe(program)[:6] == program.split("|")[:6] and lathe(program)[6] == "G0 X38."


def test_the_angle_of_a_haas_thread_names_no_axis():
    """A of G76 is the angle of its tool: it stays in its block, also where the place behind it is
    asked for."""
    program = "G0 X30. Z2.|G76 X28. Z-20. K.9 D.3 F1.5 A60|G90 U-2. Z-5."
    assert lathe(program, "haas-lathe")[:3] == [*program.split("|")[:2], "G0 X28."]


def test_g74_and_g75_in_one_block_have_i_along_x_and_k_along_z():
    """Haas lathe operator's manual, G74, G75; Fanuc's Series 10/11 format: I steps or pecks along
    X, a radius, K along Z.
    X 100 to 88 by a radius of 3: 94 and 88; Z 2 to -6 by 5: -3 and -6, each 0.5 mm back in place of
    setting 22."""
    one = ["G1 Z-3.", "G0 Z-2.5", "G1 Z-6.", "G0 Z2."]
    over = ["G1 X94.", "G0 X95.", "G1 X88.", "G0 X100."]
    for dialect in ("haas-lathe", "fanuc-lathe-a"):
        lines = lathe("G0 X100. Z2.|G74 X88. Z-6. I3. K5. F.1|G0 X120.", dialect)
        first = ["G1 Z-3. F.1", *one[1:]]
        assert lines[1:] == [*first, "X94.", *one, "X88.", *one, "X100.", "G0 X120."]
        lines = lathe("G0 X100. Z2.|G75 U-12. W-8. I3. K5. D0|G0 X120.", dialect)
        assert lines[1:] == [*over, "Z-3.", *over, "Z-6.", *over, "Z2.", "G0 X120."]


def test_the_taper_of_g90_and_g94_is_i_and_k_in_one_block_formats():
    """Series 10/11 format, and Haas: I and K are what R is above."""
    for dialect in ("haas-lathe", "fanuc-lathe-a"):
        lines = lathe("G0 X60. Z2.|G90 U-10. W-32. I-5.", dialect)
        assert lines[1:] == ["G0 X40.", "G1 X50. Z-30.", "X60.", "G0 Z2."]
        lines = lathe("G0 X60. Z2.|G94 X20. Z-5. K-1.", dialect)
        assert lines[1:] == ["G0 Z-6.", "G1 X20. Z-5.", "Z2.", "G0 X60."]


NOSE = (
    "G0 X100. Z2.|G71 U4. R1.|G71 P10 Q20 U1. W.5|N10 G0 G42 X40.|G1 Z-20.|N20 G40 X100. Z-50.|G70"
    " P10 Q20|G0 X200."
)


def test_nose_radius_compensation_in_the_shape_holds_in_g70_and_a_notice_says_so():
    """The roughing is the one without it; G70 runs the blocks as they stand, and goes back without
    it."""
    resolver = Resolver(
        Program("part", b""), Tracker(Interpreter(dialects.load("fanuc-lathe-a"), LATHE))
    )
    program = NOSE.split("|")
    resolver.program = Program("part", NOSE.replace("|", "\n").encode())
    lines = [
        x.text.decode()
        for n, one in enumerate(program, 1)
        for x in resolver.take(Line(one.encode(), n))
    ]
    assert lines[-5:] == [
        "N10 G0 G42 X40.",
        "G1 Z-20.",
        "N20 G40 X100. Z-50.",
        "G0 X100. Z2.",
        "G0 X200.",
    ]
    assert lines[:-5] == lathe(NOSE.replace("G42 ", "").replace("G40 ", ""))[:-5]
    [notice] = resolver.scene.notices
    assert notice.line == 3 and notice.message.startswith(
        "G42 in the shape of G71 holds in G70 alone"
    )


def test_the_nose_of_a_haas_is_led_along_the_shape_of_the_roughing_too():
    """Haas lathe manual, "TNC with a G71 Roughing Canned Cycle": the last cut has G42; the rapid
    with G40 is no shape."""
    program = (
        "G0 X100. Z2.|G71 P10 Q20 U1. W.5 D4.|N10 G0 G42 X40. Z2.|G1 Z-20.|X100. Z-50.|N20 G0 G40"
        " Z2.|G0 X200."
    )
    lines = text_of(program, "haas-lathe", LATHE)
    assert lines[-5:] == [
        "G0 G42 X41.",
        "G1 Z-19.5",
        "X101. Z-49.5",
        "G0 G40 X100. Z2.",
        "G0 X200.",
    ]
    bare = program.replace("G42 ", "").replace("|X100. Z-50.|N20 G0 G40 Z2.", "|N20 X100. Z-50.")
    assert [x.replace("G0 G42 ", "").replace(" G40", "") for x in lines[:-1]] == text_of(
        bare, "haas-lathe", LATHE
    )[:-1]


def test_a_distance_of_nothing_behind_a_cycle_needs_no_motion_code():
    """G28 U0 and then W0, as programs have it for the way to the reference point: whichever code
    holds behind G71, nothing moves."""
    shape = "N10 G0 X40.|N20 G1 Z-5."
    lines = text_of(f"G0 X100. Z2.|G71 U2. R1.|G71 P10 Q20 F.2|{shape}|W0", "fanuc-lathe-a", LATHE)
    assert lines[-1] == "W0"
