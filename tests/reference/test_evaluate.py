"""The reference's evaluation of a corrected program against residuals worked out by hand."""

import math

import pytest
from pytest import approx

from .evaluate import Judge, Misaligned, residual
from .interpreter import run
from .machine import Machine
from .samples import NANOMETRE, SECOND_ORDER, flat, make, seed_machine

ZERO_PROGRAM = """G21 G90 G17
G0 X0 Y0 Z0
G1 X30 F300
M8
G2 X50 Y20 I20
G3 X50 Y20 I0 J-20
G4 P0.5
G1 X40
X40
G0 Z5
M2
"""


def test_a_perfect_machine_leaves_nothing(tmp_path):
    machine = make(tmp_path, "w-X-Y-b-Z-t", flat("XYZ"))
    report = residual(ZERO_PROGRAM, ZERO_PROGRAM, "linuxcnc", machine)
    assert report.largest_mm < 1e-9 and report.uncompensated_mm < 1e-9
    assert [r.output_lines for r in report.by_block] == [[line] for line in (2, 3, 5, 6, 8, 9, 10)]
    assert (report.nominal_motions, report.output_motions, report.take_ups) == (7, 7, 0)
    assert report.end_points[1][0] == 3 and list(report.end_points[1][1]) == [30.0, 0.0, 0.0]
    assert report.feed_changes == [] and report.unmeasured == [] and report.outside_travel == []


def test_a_shift_is_found_and_its_opposite_heals_it(tmp_path):
    """EXX = 10 µm everywhere: uncompensated 10 µm; commanded 10 µm less, nothing."""
    machine = make(tmp_path, "w-b-Z-X-t", flat("ZX", EXX_um=10.0), tool={"X": 5.0})
    nominal = "G0 X10 Z0\nG1 Z50 F100\nG1 X40 Z80\n"
    report = residual(nominal, "G0 X9.99 Z0\nG1 Z50 F100\nG1 X39.99 Z80\n", "linuxcnc", machine)
    assert report.largest_mm < NANOMETRE and report.uncompensated_mm == approx(0.010, abs=NANOMETRE)
    assert report.end_points[2][1] == approx([45.0, 0.0, 80.0]) and report.end_points[2][
        2
    ] == approx([45.0, 0.0, 80.0])
    half = residual(
        nominal, "G0 X9.99 Z0\nG1 X9.993 Z50 F100\nG1 X39.99 Z80\n", "linuxcnc", machine
    )
    assert half.largest_mm == approx(0.003, abs=NANOMETRE) and half.where[:2] == (2, 2)
    assert half.by_block[1].end_mm == approx(0.003, abs=NANOMETRE)


def test_pieces_cut_by_hand_at_a_kink(tmp_path):
    """EZX: 0 at X = 0, 20 µm at X = 10, 0 at X = 30. Uncut 20 µm are left; cut at the kink,
    nothing."""
    tables = {
        "X": {"nodes": [0.0, 10.0, 30.0], "EZX_um": [0.0, 20.0, 0.0]},
        "Z": {"nodes": [-10.0, 10.0]},
    }
    machine = make(tmp_path, "w-b-Z-X-t", tables)
    nominal = "G0 X0 Z0\nG1 X30 F100\nG0 Z5\n"
    uncut = residual(nominal, nominal, "linuxcnc", machine, samples_per_mm=50)
    assert uncut.largest_mm == approx(0.020, abs=3e-5) and uncut.where[2]["X"] == approx(
        10.0, abs=0.05
    )
    cut = residual(
        nominal, "G0 X0 Z0\n(cut)\nG1 X10 Z-0.02 F100\nX30 Z0\nG0 Z5\n", "linuxcnc", machine
    )
    assert cut.largest_mm < NANOMETRE and cut.by_block[1].output_lines == [3, 4]
    assert cut.uncompensated_mm == approx(0.020, abs=5e-4)


def two_way(tmp_path, **settings):
    """Lost motion of 8 µm: X stands where it should when it comes from below, 8 µm high when from
    above."""
    tables = flat(settings.pop("axes", "ZX"))
    tables["X"].update(EXX_um_fwd=[0.0, 0.0], EXX_um_rev=[8.0, 8.0])
    return make(tmp_path, settings.pop("chain", "w-b-Z-X-t"), tables, **settings)


def test_a_take_up_counts_by_its_end_alone(tmp_path):
    """Back from X30 the slide first goes to 29.992 and the tool stays, then to 9.992."""
    machine = two_way(tmp_path)
    nominal = "G0 X0 Z0\nG0 X10\nG1 X30 F100\nG1 Z20\nG1 X10\nG1 Z0\n"
    output = "G0 X0.0 Z0\nG0 X10\nG1 X30 F100\nG1 Z20\nG1 X29.992 F50\nX9.992 F100\nG1 Z0\n"
    report = residual(nominal, output, "linuxcnc", machine)
    assert report.take_ups == 1 and report.by_block[4].output_lines == [5, 6]
    assert report.by_block[4].largest_mm < NANOMETRE and report.feed_changes == []
    # The first move comes from nowhere known: the mean, 4 µm.
    assert report.by_block[0].end_mm == approx(0.004, abs=NANOMETRE)
    assert max(r.largest_mm for r in report.by_block[1:]) < NANOMETRE
    without = residual(
        nominal, "G0 X0 Z0\nG0 X10\nG1 X30 F100\nZ20\nX9.992\nZ0\n", "linuxcnc", machine
    )
    assert without.take_ups == 0 and without.by_block[4].largest_mm == approx(0.0, abs=NANOMETRE)


def test_a_take_up_inside_an_arc_lies_at_the_reversal(tmp_path):
    """Half a circle over the top of X: the slide stands 8 µm lower on the way down."""
    machine = two_way(tmp_path, axes="XY", chain="w-X-b-Y-t")
    nominal = "G0 X0 Y-10\nG1 X5 Y-10 F100\nG3 X5 Y10 J10\n"
    output = "G0 X-0.004 Y-10\nG1 X5 Y-10 F100\nG3 X15 Y0 J10\nG1 X14.992 Y0\nG3 X4.992 Y10 I-10\n"
    report = residual(nominal, output, "linuxcnc", machine)
    assert report.take_ups == 1 and report.largest_mm < NANOMETRE
    assert report.uncompensated_mm == approx(0.008, abs=2e-5)


@pytest.mark.parametrize(
    "x, um", [(9.99, 2.0), (9.9988, 6.8), (9.9991, 0.9), (10.0, 0.0), (10.02, 20.0)],
    ids=["turned", "just turned", "within the hysteresis", "at rest", "on the same side"],
)  # fmt: skip
def test_the_side_is_that_of_the_commanded_motion_though_the_axis_rests(tmp_path, x, um):
    """X came from below, and creeps along with Z: behind 1 µm and an increment it stands 8 µm
    high."""
    nominal = "G0 X0 Z0\nG1 X10 F100\nG1 Z20\n"
    report = residual(
        nominal, f"G0 X0 Z0\nG1 X10 F100\nG1 X{x} Z20\n", "linuxcnc", two_way(tmp_path)
    )
    assert report.by_block[2].end_mm == approx(um / 1000, abs=NANOMETRE)
    # The nominal program itself never turns X.
    assert max(block.largest_mm for block in report.by_block[1:2]) < NANOMETRE
    assert report.uncompensated_mm == approx(0.004, abs=NANOMETRE)  # the mean, at the first place


@pytest.mark.parametrize("x, um", [(10.001, 5.0), (10.0012, 1.2), (9.999, 3.0), (9.998, 6.0)])
def test_before_it_has_moved_the_mean_holds(tmp_path, x, um):
    """From its first place by no more than the hysteresis and an increment it has not moved: there
    it stands 4 µm high."""
    nominal = "G0 X10 Z0\nG1 Z20 F100\n"
    report = residual(nominal, f"G0 X10 Z0\nG1 X{x} Z20 F100\n", "linuxcnc", two_way(tmp_path))
    assert report.by_block[1].end_mm == approx(um / 1000, abs=NANOMETRE)


def test_the_machine_says_how_far_a_slide_may_turn_back(tmp_path):
    """20 µm: 15 back, 5 on, 9 back are 19 from the farthest; 2 more and the side is the other."""
    two_way(tmp_path)
    with open(tmp_path / "machine.toml", "a") as file:
        file.write("hysteresis_um = 20.0\n")
    machine = Machine.load(tmp_path)
    nominal = "G0 X0 Z0\nG1 X10 F100\nG1 Z20\nZ30\nZ40\nZ50\n"
    output = "G0 X0 Z0\nG1 X10 F100\nG1 X9.985 Z20\nX9.99 Z30\nX9.981 Z40\nX9.979 Z50\n"
    report = residual(nominal, output, "linuxcnc", machine)
    ends = [1000 * block.end_mm for block in report.by_block[2:]]
    assert ends == approx([15.0, 10.0, 19.0, 13.0], abs=1e-3)


def test_an_arc_turns_its_axis_behind_its_quadrant(tmp_path):
    """Half a circle over the top of X, R = 10: the side changes when X has come back by 1.1 µm."""
    machine = two_way(tmp_path, axes="XY", chain="w-X-b-Y-t")
    (arc,) = run("G3 X0 Y10 J10 F100\n", "linuxcnc", axes="XY", start={"X": 0, "Y": -10})
    judge = Judge(machine, 1.0, False, 0.5, 0.5)
    judge.execute([arc])
    turned = 0.5 + math.acos(1 - 0.0011 / 10) / math.pi
    # of Y from its first place: there it begins along X
    moved = math.acos(1 - 0.0011 / 10) / math.pi
    assert [
        judge.approach(arc, t)["X"] for t in (1e-3, 0.5, turned - 1e-6, turned + 1e-6, 1.0)
    ] == [1, 1, 1, -1, -1]
    assert [judge.approach(arc, t)["Y"] for t in (0.0, moved - 1e-6, moved + 1e-6, 1.0)] == [
        0,
        0,
        1,
        1,
    ]


def test_a_circle_in_four_pieces_and_two_circles_one_after_the_other(tmp_path):
    machine = make(tmp_path, "w-X-b-Y-t", flat("XY", EXX_um=5.0))
    nominal = "G0 X10 Y0\nG3 I-10 F100\nG3 I-10\n"
    four = "G3 X-0.005 Y10 I-10\nX-10.005 Y0 J-10\nX-0.005 Y-10 I10\nX9.995 Y0 J10\n"
    report = residual(nominal, "G0 X9.995 Y0 F100\n" + four + four, "linuxcnc", machine)
    assert [len(r.output_lines) for r in report.by_block] == [
        1,
        4,
        4,
    ] and report.largest_mm < NANOMETRE
    assert (
        residual(nominal, "G0 X9.995 Y0 F100\nG3 I-10\nG3 I-10\n", "linuxcnc", machine).largest_mm
        < NANOMETRE
    )


def test_a_circle_that_became_a_sliver_is_found(tmp_path):
    machine = make(tmp_path, "w-X-b-Y-t", flat("XY"))
    with pytest.raises(Misaligned, match="62.83"):
        residual(
            "G0 X10 Y0\nG3 I-10 F100\n", "G0 X10 Y0\nG3 X10 Y0.001 I-10 F100\n", "linuxcnc", machine
        )


def test_an_arc_in_chords_is_measured_by_its_sagitta(tmp_path):
    """Chords of 10 degrees on R = 10: 10 (1 - cos 5 degrees) = 38.05 µm."""
    machine = make(tmp_path, "w-b-Z-X-t", flat("ZX"))
    chords = "".join(
        f"G1 Z{10 * math.cos(a):.9f} X{10 * math.sin(a):.9f}\n"
        for a in (math.radians(10 * k) for k in range(1, 10))
    )
    report = residual(
        "G18 G0 X0 Z10\nG3 X10 Z0 K-10 F100\n",
        "G18 G0 X0 Z10 F100\n" + chords,
        "linuxcnc",
        machine,
        samples_per_mm=200,
    )
    assert report.largest_mm == approx(10 * (1 - math.cos(math.radians(5))), rel=1e-3)
    assert len(report.by_block[1].output_lines) == 9


def test_many_short_motions_keep_their_partners(tmp_path):
    """0.1 mm motions, far below the 0.5 mm within which an end may lie, under a 65 µm shift; one of
    them cut."""
    machine = make(tmp_path, "w-b-Z-X-t", flat("ZX", EZX_um=65.0))
    points = [(10 * math.cos(k / 100), 10 * math.sin(k / 100)) for k in range(120)]
    nominal = "G0 X0 Z0\n" + "".join(f"G1 X{x:.6f} Z{z:.6f} F100\n" for x, z in points)
    lines = [f"G1 X{x:.6f} Z{z - 0.065:.6f} F100\n" for x, z in points]
    (x, z), (x1, z1) = points[59], points[60]
    lines.insert(60, f"G1 X{(x + x1) / 2:.6f} Z{(z + z1) / 2 - 0.065:.6f} F100\n")
    report = residual(nominal, "G0 X0 Z-0.065\n" + "".join(lines), "linuxcnc", machine)
    assert [len(r.output_lines) for r in report.by_block] == [1] + [1] * 60 + [2] + [1] * 59
    assert report.largest_mm < 2 * NANOMETRE and report.uncompensated_mm == approx(
        0.065, abs=NANOMETRE
    )


@pytest.mark.parametrize(
    "output, why",
    [
        ("G0 X0 Z0\nG1 X10 F100\nM8\nX20\n", "ends within|only 3|continues none"),
        ("G0 X0 Z0\nG1 X10 F100\nX20\nZ10\n", "do not move"),
        ("G0 X0 Z0\nG1 X10 F100\nM9\nX20\nZ10\n", "do not move"),
        ("G0 X0 Z0\nM8\nG1 X10 F100\nX20\nZ10\n", "continues none"),
        ("G0 X0 Z0\nG1 X10 F100\nM8\nX20\nZ10\nX0\n", "continues none"),
        ("G0 X0 Z0\nG1 X8 F100\nX2\nX10\nM8\nX20\nZ10\n", "together"),
        ("G0 X0 Z0\nG0 X10\nM8\nG1 X20 F100\nZ10\n", "continues none"),
    ],
)
def test_a_program_that_does_something_else_is_refused(tmp_path, output, why):
    machine = make(tmp_path, "w-b-Z-X-t", flat("ZX"))
    nominal = "G0 X0 Z0\nG1 X10 F100\nM8\nX20\nZ10\n"
    residual(nominal, nominal, "linuxcnc", machine)
    with pytest.raises(Misaligned, match=why):
        residual(nominal, output, "linuxcnc", machine)


def test_outside_the_tables_travel_and_feeds_are_reported(tmp_path):
    machine = make(tmp_path, "w-b-Z-X-t", flat("ZX", 0.0, 50.0, EXX_um=10.0), travel=(0.0, 60.0))
    outside = "G0 X0 Z0\nG1 X55 F100\n"
    with pytest.raises(ValueError, match="X = 5.* mm is outside"):
        residual(outside, outside, "linuxcnc", machine)
    report = residual(
        outside, "G0 X-0.01 Z0\nG1 X20 F90\nX54.99\n", "linuxcnc", machine, clamp=True
    )
    assert report.outside_travel == [(1, "X", -0.01)] and report.largest_mm < NANOMETRE
    assert report.feed_changes == [(2, 2, 100.0, 90.0), (2, 3, 100.0, 90.0)]


def test_the_machine_may_ask_to_hold_the_end_values(tmp_path):
    machine = make(tmp_path, "w-b-Z-X-t", flat("ZX", 0.0, 50.0, EXX_um=10.0), outside="clamp")
    assert residual("G0 X55 Z0\n", "G0 X54.99 Z0\n", "linuxcnc", machine).largest_mm < NANOMETRE


def test_inverse_time_feeds_of_the_pieces_add_up(tmp_path):
    machine = make(tmp_path, "w-b-Z-X-t", flat("ZX"))
    nominal = "G93 G0 X0 Z0\nG1 X10 F2\n"
    right = residual(nominal, "G93 G0 X0 Z0\nG1 X4 F5\nX10 F3.33333\n", "linuxcnc", machine)
    wrong = residual(nominal, "G93 G0 X0 Z0\nG1 X4 F2\nX10 F2\n", "linuxcnc", machine)
    assert right.feed_changes == [] and wrong.feed_changes[0][2:] == approx((2.0, 1.0))


def test_home_and_machine_coordinates_are_matched_and_not_measured(tmp_path):
    machine = make(tmp_path, "w-b-Z-X-t", flat("ZX", EXX_um=10.0))
    nominal = "G0 X10 Z0\nG53 G0 X5\nG28 X0\nG0 Z5\nG0 X1\nG1 X3 F100\n"
    report = residual(
        nominal,
        nominal.replace("X10 Z0", "X9.99 Z0").replace("X1\n", "X.99\n").replace("X3", "X2.99"),
        "linuxcnc",
        machine,
    )
    assert report.largest_mm < NANOMETRE and report.unmeasured == [4]
    assert [r.where is None for r in report.by_block] == [False, True, True, True, False, False]


def test_the_diagonal_of_the_grinder_uncompensated(tmp_path):
    """One block from (0, 0) to (510, 170): the farthest end is off by its own deviation, summed by
    hand."""
    machine = seed_machine(tmp_path, offsets={"G54": {"X": 0.0, "Z": 0.0}})
    text = "G90 G0 X0. Z0.;\nG1 X340. Z510. F100;\nM30;\n"
    report = residual(text, text, "fanuc-lathe", machine, samples_per_mm=0.5)
    e_z = -0.0096 + 0.0083 + 0.065 + 7.5e-6 * 170
    e_x = 0.0305 + 0.0035
    assert report.by_block[1].end_mm == approx(math.hypot(e_z, e_x), abs=SECOND_ORDER)
    assert report.largest_mm == report.uncompensated_mm
