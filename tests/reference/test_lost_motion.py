"""The judge of lost motion against what a slide with play does, worked out by hand."""

import math

import numpy as np
import pytest
from pytest import approx

from .evaluate import Misaligned
from .interpreter import run
from .lost_motion import (
    Execution,
    follow,
    places,
    side_of_play,
    tool_points,
    turns_at,
    weighted_quantile,
)
from .machine import Machine
from .samples import NANOMETRE, flat, make, write_machine
from .test_machine import chains, random_tables

PLAY = 0.04  # mm
LAG = PLAY / 2


def with_play(tmp_path, chain="w-X-Y-b-Z-t", um=40.0, **settings):
    """X lags by 20 µm on either side."""
    tables = flat("XYZ" if "Y" in chain else "ZX")
    tables["X"].update(EXX_um_fwd=[-um / 2, -um / 2], EXX_um_rev=[um / 2, um / 2])
    return make(tmp_path, chain, tables, **settings)


def with_effect(tmp_path, text, tables=None, **settings):
    folder = write_machine(tmp_path, "w-X-Y-b-Z-t", tables or flat("XYZ"), **settings)
    with open(folder / "machine.toml", "a") as file:
        file.write(f'\n[[effect]]\nname = "backlash"\naxis = "X"\n{text}\n')
    return Machine.load(folder)


def executed(machine, text, density=2.0):
    blocks = [
        block for block in run(text, "linuxcnc", axes=list(machine.axes)) if block.kind != "none"
    ]
    return Execution(blocks, machine, density)


def ends(machine, text):
    """(motions, axes) mm: the tool at the end of every motion."""
    execution = executed(machine, text)
    return execution.actual[[part.stop - 1 for part in execution.part]]


def test_the_nut_stays_until_the_play_is_passed():
    command = np.array([0.0, 0.01, 0.02, 1.0, 0.98, 0.96, 0.5, 0.51, 0.5])
    side = [0.0, 0.5, 1.0, 1.0, 0.0, -1.0, -1.0, -0.5, -1.0]
    assert side_of_play(command, np.full(9, PLAY)) == approx(side, abs=1e-9)


def test_without_play_the_last_commanded_motion_decides():
    command = np.array([math.nan, 3.0, 3.0, 3.1, 3.1, 3.099, math.nan, 5.0, 4.0])
    assert list(side_of_play(command, np.zeros(9))) == [0, 0, 0, 1, 1, -1, 0, 0, -1]


def test_a_line_ends_to_the_digit_so_that_no_rounding_says_a_side():
    """159.9736 + 1.0 * (29.00195 - 159.9736) is less than 29.00195: an axis that came down to
    there, and rests, would go up by a rounding, which without play is another side."""
    down, rests = run("G0 X159.9736\nX29.00195\nG4 P1\nG1 X29.00195 F1\n", "linuxcnc", axes="X")[
        1::2
    ]
    assert 159.9736 + 1.0 * (29.00195 - 159.9736) != 29.00195
    command = np.concatenate(
        [places(each, "X", np.array([0.5, 1.0]))[:, 0] for each in (down, rests)]
    )
    assert list(side_of_play(command, np.zeros(4))) == [0, -1, -1, -1]


def test_a_line_to_and_fro(tmp_path):
    """Behind by half the play: 99.98 on the way up, 20.02 on the way down; at the first place the
    nut is in the middle."""
    machine = with_play(tmp_path)
    assert ends(machine, "G0 X0 Y0 Z0\nG1 X100 F100\nG1 X20\nG1 X20.03\nG1 X20.08\n")[
        :, 0
    ] == approx([0.0, 99.98, 20.02, 20.02, 20.06], abs=1e-9)
    nominal = "G0 X0 Y0 Z0\nG1 X100 F100\nG1 X20\n"
    report = follow(nominal, nominal, "linuxcnc", machine)
    assert report.largest_mm == approx(LAG, abs=NANOMETRE) and report.where[2] == "the end point"
    # On a straight line only the ends are off.
    assert (
        report.rms < 0.001 and report.weights.sum() == approx(180.0) and report.share(0.001) > 0.98
    )


def test_a_resting_axis_that_is_crept_back_inside_its_play_does_not_move(tmp_path):
    """Y leans by 400 µrad: at Y = 100 the tool is 40 µm low in X. X came down to 20, so it is
    commanded 20 µm lower; the 40 µm that follow along with Y are spent inside the play."""
    machine = with_play(tmp_path, squareness={"C0Y": 400.0})
    nominal = "G0 X0 Y0 Z0\nG1 X100 F100\nG1 X20\nG1 Y100\n"
    crept = "G0 X0 Y0 Z0\nG1 X100.02 F100\nG1 X99.98\nG1 X19.98\nG1 X20.02 Y100\n"
    report = follow(nominal, crept, "linuxcnc", machine)
    assert report.largest_mm == approx(0.04, abs=1e-5) and report.where[:2] == (4, 5)
    # Along Y the distance grows from 0 to 40 µm: rms 40/sqrt 3 over 100 of 280 mm.
    assert report.rms == approx(0.04 / math.sqrt(3) * math.sqrt(100 / 280), rel=0.01)
    taken_up = crept.replace("G1 X20.02 Y100", "G1 X20.02\nG1 X20.06 Y100")
    report = follow(nominal, taken_up, "linuxcnc", machine)
    assert report.largest_mm < 2e-5 and report.take_ups == 2


def test_a_take_up_removes_the_play(tmp_path):
    machine = with_play(tmp_path)
    nominal = "G0 X0 Y0 Z0\nG1 X100 F100\nG1 X20\nG1 Y10\nG1 X30\n"
    output = "G0 X0 Y0 Z0\nG1 X100.02 F100\nG1 X99.98\nG1 X19.98\nG1 Y10\nG1 X20.02\nG1 X30.02\n"
    report = follow(nominal, output, "linuxcnc", machine)
    assert report.largest_mm < NANOMETRE and report.take_ups == 2
    assert report.weights.sum() == approx(100.02 + 80.0 + 10.0 + 10.0)
    short = follow(nominal, output.replace("X20.02", "X20.005"), "linuxcnc", machine)
    # what is missing is taken up along the way
    assert short.take_ups == 2 and short.largest_mm < NANOMETRE
    far = follow(nominal, output.replace("G1 X20.02", "G1 Y10.02 X20.02"), "linuxcnc", machine)
    assert far.largest_mm == approx(0.02, abs=NANOMETRE) and far.where == (
        5,
        6,
        "the end of a take-up",
    )


def circle(machine, text, line):
    """(angle in degrees, radial deviation in mm) of the samples of one motion; centre (0, 0),
    radius 20."""
    execution = executed(machine, text, density=20.0)
    point = execution.actual[execution.part[line]]
    x, y = point[:, list(machine.axes).index("X")], point[:, list(machine.axes).index("Y")]
    angle = np.degrees(np.arctan2(y, x)) % 360.0
    order = np.argsort(angle)
    return angle[order], np.hypot(x, y)[order] - 20.0


def test_a_circle_has_a_step_of_the_play_where_its_axis_turns(tmp_path):
    """X lags by 20 µm: to the inside before 180 degrees, to the outside behind; passed after acos(1
    - 0.04/20) = 3.62."""
    machine = with_play(tmp_path)
    angle, radial = circle(machine, "G0 X0 Y0 Z0\nG1 X20 F100\nG3 I-20\nG3 I-20\n", 3)
    at = lambda degrees: float(np.interp(degrees, angle, radial))
    assert at(179.9) == approx(-LAG, abs=1e-5)
    behind = 180 + math.degrees(math.acos(1 - PLAY / 20.0))
    assert at(behind + 0.1) == approx(LAG * math.cos(math.radians(behind - 180)), abs=1e-4)
    assert at(behind + 0.1) - at(179.9) == approx(PLAY, rel=0.01)
    assert at(90.0) == approx(0.0, abs=2e-5) and at(45.0) == approx(LAG * math.sqrt(0.5), abs=2e-5)
    # X leads nowhere: its largest deviation is half of the play.
    assert np.abs(radial).max() == approx(LAG, rel=1e-3)


def test_a_circle_with_its_take_ups(tmp_path):
    """X is commanded 20 µm ahead and jumps by the play where it turns: nothing is left."""
    machine = with_play(tmp_path)
    nominal = "G0 X0 Y0 Z0\nG1 X20 F100\nG3 X-20 I-20\nG3 X20 I20\n"
    output = "G0 X0 Y0 Z0\nG1 X20.02 F100\nG1 X19.98\nG3 X-20.02 I-20\nG1 X-19.98\nG3 X20.02 I20\n"
    report = follow(nominal, output, "linuxcnc", machine, density=20.0)
    assert report.largest_mm < 2 * NANOMETRE and report.take_ups == 2
    plain = follow(nominal, nominal, "linuxcnc", machine, density=20.0)
    assert plain.largest_mm == approx(LAG, rel=1e-3)
    # X is off by 20 µm all the way, radially 20 cos: rms 20/sqrt 2, over half of the way up to 20
    # cos 45 degrees. The line counts as 0, so half of the whole path is where asin(u) 2/pi = (1/2 -
    # line) / circle.
    line, round_it = (length / (20 + 40 * math.pi) for length in (20, 40 * math.pi))
    assert plain.quantile(0.5) == approx(
        LAG * math.sin((0.5 - line) / round_it * math.pi / 2), rel=0.03
    )


def test_the_quantile_counts_path_and_not_samples():
    distances, weights = np.array([3.0, 1.0, 2.0]), np.array([1.0, 8.0, 1.0])
    assert [weighted_quantile(distances, weights, part) for part in (0.5, 0.85, 0.95)] == [
        1.0,
        2.0,
        3.0,
    ]


def test_an_arc_is_followed_along_its_way(tmp_path):
    """Half a circle from X = 0 over X = 10 back to X = 0: its ends do not tell that X turned."""
    machine = with_play(tmp_path)
    assert ends(machine, "G0 X0 Y-10 Z0\nG3 X0 Y10 J10 F100\n")[1][0] == approx(LAG, abs=1e-9)
    (arc,) = run("G3 X0 Y10 J10 F100\n", "linuxcnc", axes="XYZ", start={"X": 0, "Y": -10, "Z": 0})
    assert turns_at(arc) == approx([0.0, 0.5, 1.0])
    assert places(arc, ["X", "Y", "Z"], np.array([0.5]))[0] == approx([10.0, 0.0, 0.0])


def test_play_that_grows_along_the_table(tmp_path):
    """B = 0 at X = 0, 40 µm at X = 100: at 50 the tool is 10 µm behind, at 25 on the way back 5
    µm."""
    tables = flat("XYZ", 0.0, 100.0)
    tables["X"].update(EXX_um_fwd=[0.0, -20.0], EXX_um_rev=[0.0, 20.0])
    machine = make(tmp_path, "w-X-Y-b-Z-t", tables)
    assert ends(machine, "G0 X0 Y0 Z0\nG1 X50 F100\nG1 X25\n")[:, 0] == approx(
        [0.0, 49.99, 25.005], abs=1e-9
    )


def test_an_effect_is_lost_motion_and_adds_to_the_tables(tmp_path):
    machine = with_effect(tmp_path / "alone", "size_um = 40.0")
    assert ends(machine, "G0 X0 Y0 Z0\nG1 X50 F100\nG1 X25\n")[:, 0] == approx(
        [0.0, 49.98, 25.02], abs=1e-9
    )
    tables = flat("XYZ", EXX_um=3.0)
    tables["X"].update(EXX_um_fwd=[-5.0, -5.0], EXX_um_rev=[5.0, 5.0])
    del tables["X"]["EXX_um"]
    machine = with_effect(tmp_path / "both", "size_um = 40.0", tables)
    assert ends(machine, "G0 X0 Y0 Z0\nG1 X50 F100\nG1 X25\n")[:, 0] == approx(
        [0.0, 49.975, 25.025], abs=1e-9
    )


def test_pre_travel_is_taken_up_over_its_own_way(tmp_path):
    """10 µm over 0.1 mm: 0.05 mm after the turn the tool is in the middle."""
    machine = with_effect(tmp_path, "size_um = 10.0\nplay_mm = 0.1")
    text = "G0 X0 Y0 Z0\nG1 X50 F100\nG1 X49.95\nG1 X49.9\nG1 X40\n"
    assert ends(machine, text)[:, 0] == approx([0.0, 49.995, 49.95, 49.905, 40.005], abs=1e-9)


def test_another_effect_is_refused(tmp_path):
    with pytest.raises(ValueError, match="knows no effect"):
        with_effect(tmp_path, "size_um = 40.0\ncolour = 3")


def test_other_components_follow_the_same_side(tmp_path):
    """EYX is 6 µm from below and -6 from above: in the middle of the play it is 0, without play it
    jumps."""
    tables = flat("XYZ")
    tables["X"].update(EYX_um_fwd=[6.0, 6.0], EYX_um_rev=[-6.0, -6.0])
    text = "G0 X0 Y0 Z0\nG1 X50 F100\nG1 X49.99\nG1 X49.98\nG1 X49.96\n"
    without = make(tmp_path / "without", "w-X-Y-b-Z-t", tables)
    assert ends(without, text)[:, 1] == approx([0.0, 0.006, -0.006, -0.006, -0.006], abs=1e-9)
    tables["X"].update(EXX_um_fwd=[-20.0, -20.0], EXX_um_rev=[20.0, 20.0])
    machine = make(tmp_path / "with", "w-X-Y-b-Z-t", tables)
    assert ends(machine, text)[:, 1] == approx([0.0, 0.006, 0.003, 0.0, -0.006], abs=1e-9)


def test_a_rapid_counts_by_its_end_alone(tmp_path):
    machine = with_play(tmp_path)
    nominal = "G0 X0 Y0 Z0\nG0 X50 Y50\nG1 Z-1 F100\n"
    report = follow(nominal, nominal, "linuxcnc", machine)
    assert report.largest_mm == approx(LAG, abs=NANOMETRE)
    assert report.weights.sum() == approx(1.0) and report.rms == approx(LAG, abs=NANOMETRE)


def test_after_a_return_to_reference_nobody_knows_the_side(tmp_path):
    machine = with_play(tmp_path)
    text = "G0 X0 Y0 Z0\nG1 X50 F100\nG28 X0\nG0 X10\nG1 X20\n"
    assert ends(machine, text)[:, 0] == approx(
        [0.0, 49.98, math.nan, 10.0, 19.98], abs=1e-9, nan_ok=True
    )
    assert follow(text, text, "linuxcnc", machine).largest_mm == approx(LAG, abs=NANOMETRE)


def test_a_program_that_does_something_else_is_refused(tmp_path):
    machine = with_play(tmp_path)
    nominal = "G0 X0 Y0 Z0\nG1 X10 F100\nM8\nX20\nY10\n"
    follow(nominal, nominal, "linuxcnc", machine)
    for output in (
        "G0 X0 Y0 Z0\nG1 X10 F100\nM8\nX20\n",
        nominal.replace("M8", "M9"),
        nominal.replace("X20", "X21"),
    ):
        with pytest.raises(Misaligned):
            follow(nominal, output, "linuxcnc", machine)


@pytest.mark.parametrize("chain", list(chains())[::3])
def test_many_points_at_once_are_the_same_as_one_at_a_time(tmp_path, chain):
    rng = np.random.default_rng(list(chain.encode()))
    machine = make(
        tmp_path,
        chain,
        random_tables(rng),
        squareness={"C0Y": 120.0, "B0Z": -90.0},
        tool={"X": 20.0, "Z": -70.0},
        measured_at={"X": {"Y": 30.0}, "Z": {"X": -50.0, "Y": 9.0}},
    )
    names = list(machine.axes)
    command, side = rng.uniform(-290, 290, (40, 3)), rng.integers(-2, 3, (40, 3)) / 2
    together = tool_points(machine, command, side)
    for row, s, point in zip(command, side, together):
        assert machine.actual(dict(zip(names, row)), dict(zip(names, s))) == approx(
            point, abs=1e-10
        )
