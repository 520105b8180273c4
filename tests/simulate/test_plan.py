"""A path in time: what can be computed by hand, and limits that no program may break."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from pytest import approx

from postproc.errors import GcompError, ProgramError
from postproc.machine.file import read_machine
from postproc.simulate.limits import Limits
from postproc.simulate.timeline import Conditions
from tests import programs, small_machines

from .samples import STRICT, exact, limits, timed

ROOT = Path(__file__).resolve().parents[2]
MILL = exact()
HEAD = "G21 G90 G94 G54 G17\n"


def duration(body: str, conditions=STRICT, bounds=None, machine=MILL) -> float:
    return timed(HEAD + body + "M2\n", machine, conditions, bounds).duration


def test_a_long_move_takes_its_way_over_its_speed_and_one_ramp():
    """100 mm at 100 mm/s with 1000 mm/s2: 1 s, and 0.1 s that the ramps cost (v / a)."""
    assert duration("G0 X0\nG1 X100 F6000\n") == approx(1.1, abs=1e-12)


def test_a_short_move_never_reaches_its_feed():
    """A triangle: 2 sqrt(s / a) = 2 sqrt(5 / 1000)."""
    assert duration("G0 X0\nG1 X5 F6000\n") == approx(2 * np.sqrt(5 / 1000), abs=1e-12)


def test_a_limited_jerk_costs_one_ramp_of_the_acceleration_more():
    """s / v + v / a + a / j = 1 + 0.1 + 0.1 for 100 mm, 100 mm/s, 1000 mm/s2, 10000 mm/s3."""
    assert duration("G0 X0\nG1 X100 F6000\n", bounds=limits(MILL, jerk=1e4)) == approx(
        1.2, abs=1e-9
    )


def test_a_jerk_so_small_that_the_acceleration_is_never_reached():
    """Four equal ramps: s = 2 j t^3, t = (10 / 2000)^(1/3) for 10 mm and 1000 mm/s3."""
    bounds = limits(MILL, velocity=1e4, acceleration=1e6, jerk=1000.0)
    assert duration("G0 X0\nG1 X10 F600000\n", bounds=bounds) == approx(
        4 * (10 / 2000) ** (1 / 3), abs=1e-9
    )


def test_a_dwell_takes_its_time():
    assert duration("G0 X0\nG1 X100 F6000\nG4 P2.5\nG1 X200\n") == approx(
        1.1 + 2.5 + 1.1, abs=1e-12
    )


@pytest.mark.parametrize(
    ("control", "block", "seconds"),
    [
        ("linuxcnc", "G4 P3", 3.0),
        ("fanuc-lathe", "G4 X3.", 3.0),
        ("fanuc-lathe", "G4 U3.", 3.0),
        ("fanuc-mill", "G4 P3000", 3.0),
        ("haas", "G4 P3000", 3.0),
        ("haas", "G4 P3.0", 3.0),
        ("grbl", "G4 P0.5", 0.5),
        ("marlin", "G4 P500", 0.5),
        ("marlin", "G4 S2", 2.0),
        ("siemens", "G4 F1.5", 1.5),
        ("reprap", "G4 P250", 0.25),
    ],
)
def test_every_control_waits_as_it_writes(control, block, seconds):
    from dataclasses import replace

    machine = replace(exact(), control=control)
    assert timed(f"G1 X0. F600.\n{block}\nG1 X10.\n", machine).duration == approx(
        1.0 + 0.01 + seconds, abs=1e-9
    )


def test_feed_is_that_of_the_path_and_every_axis_keeps_its_own_limit():
    """A 3-4-5 way of 50 mm at 50 mm/s; then the slow axis bounds it: 40 mm at 10 mm/s are 4 s."""
    body = "G0 X0 Y0\nG1 X30 Y40 F3000\n"
    fast = Limits(np.full(3, 1e3), np.full(3, 1e6), np.full(3, np.inf))
    assert duration(body, bounds=fast) == approx(1.0, rel=1e-3)
    slow = Limits(np.array([1e3, 10.0, 1e3]), np.full(3, 1e6), np.full(3, np.inf))
    assert duration(body, bounds=slow) == approx(4.0, rel=1e-3)


def test_inverse_time_inches_and_feed_per_turn():
    fast = limits(MILL, 1e4, 1e7)
    # half a turn of the minute
    assert duration("G0 X0\nG93\nG1 X40 F0.5\n", bounds=fast) == approx(120.0, rel=1e-4)
    # 10 inches a minute
    assert duration("G20\nG0 X0\nG1 X10 F10\n", bounds=fast) == approx(60.0, rel=1e-4)
    # 600 x 0.1 mm/min
    assert duration("M3 S600\nG95\nG0 X0\nG1 X60 F0.1\n", bounds=fast) == approx(60.0, rel=1e-4)


def test_degrees_stay_degrees_in_inch_programs():
    """90 degrees at 360 a minute are 15 s, whatever lengths are written in."""
    machine = read_machine(ROOT / "machines" / "example-five-axis")
    fast = limits(machine, 1e4, 1e7)
    for unit in ("G21", "G20"):
        body = f"{unit}\nG0 X0 Y0 Z0 A0 C0\nG1 C90 F360\n"
        assert duration(body, bounds=fast, machine=machine) == approx(15.0, rel=1e-3)


def test_look_ahead_goes_through_blocks_that_go_on_straight():
    one = duration("G0 X0\nG1 X100 F6000\n")
    assert duration("G0 X0\n" + "".join(f"G1 X{x} F6000\n" for x in range(1, 101))) == approx(
        one, abs=1e-9
    )
    smooth = limits(MILL, jerk=1e5)
    assert duration("G0 X0\nG1 X50 F6000\nG1 X100\n", bounds=smooth) == approx(
        duration("G0 X0\nG1 X100 F6000\n", bounds=smooth), abs=1e-9
    )


def test_exact_stop_stops_and_a_corner_does_without_it():
    straight = "G0 X0 Y0\n{0}G1 X100 F6000\nG1 X200\nM2\n"
    assert duration(straight.format("")) == approx(2.1, abs=1e-9)
    assert duration(straight.format("G61.1\n")) == approx(2.2, abs=1e-9)
    corner = "G0 X0 Y0\nG1 X100 F6000\nG1 Y100\n"
    assert duration(corner) == approx(2.2, abs=1e-9)  # not cut: it stops


def test_a_cut_corner_is_run_at_what_its_radius_allows():
    """By hand: r = d / (sqrt 2 - 1), v^2 / r = 0.866 a; both ways lose (100 - v)^2 / 2 a 100 to
    their ramps at it, and 0.05 s."""
    r = 0.1 / (np.sqrt(2) - 1)
    v = np.sqrt(np.sqrt(0.75) * 1000 * r)
    way = (100 - r) / 100 + 0.05 + (100 - v) ** 2 / 2e5
    corner = "G0 X0 Y0\nG1 X100 F6000\nG1 Y100\n"
    assert duration(corner, Conditions(corner=0.1)) == approx(2 * way + np.pi / 2 * r / v, abs=1e-9)


@pytest.mark.parametrize("size", [0.001, 0.01, 0.1, 1.0])
def test_a_corner_is_cut_by_no_more_than_stated(size):
    t = timed(
        HEAD + "G0 X0 Y0\nG1 X100 F6000\nG1 X150 Y30\nG1 X20 Y40\nM2\n",
        MILL,
        Conditions(corner=size),
    )
    s = t.state(np.linspace(0.0, t.duration, 40_001))
    point = np.stack([s.position["X"], s.position["Y"]])
    for corner in ((100.0, 0.0), (150.0, 30.0)):
        off = np.hypot(point[0] - corner[0], point[1] - corner[1]).min()
        assert 0.5 * size < off <= size * (1 + 1e-3) + 0.003  # 3 um between two samples


def test_the_path_is_as_long_as_the_program():
    """Lines, a full circle of 20 mm, a helix of two turns and 6 mm rise: sqrt((4 pi 10)^2 +
    6^2)."""
    body = "G0 X0 Y0 Z0\nG1 X30 Y40 F1000\nG2 X30 Y40 I20 J0\nG3 X30 Y40 I-10 J0 Z6 P2\nM2\n"
    t = timed(HEAD + body, MILL)
    helix = np.hypot(4 * np.pi * 10, 6)
    assert t.path.length.sum() == approx(50 + 2 * np.pi * 20 + helix, abs=1e-9)
    assert np.abs(t.path.end[:, -1] - [30, 40, 6]).max() < 1e-9


def test_a_spiral_is_as_long_as_a_polygon_on_it():
    t = timed(HEAD.replace("G17", "G17") + "G0 X10 Y0\nG3 X-10.02 Y0 I-10 J0 F600\nM2\n", MILL)
    s = t.state(np.linspace(0.0, t.duration, 20_001))
    polygon = np.hypot(np.diff(s.position["X"]), np.diff(s.position["Y"])).sum()
    assert t.path.length.sum() == approx(polygon, abs=1e-6)


SITE = programs.Site(
    "linuxcnc",
    {"X": (-200.0, 200.0), "Y": (-200.0, 200.0), "Z": (-100.0, 100.0)},
    offsets={"G54": {}},
)
OPTIONS = {"inverse": True, "away": False, "codes": True, "late": False}


def check_limits(t, bounds: Limits, smooth: bool = False) -> None:
    """Positions, speeds and their changes at 7,000 moments and at the ends of all pieces, a tick
    after one another."""
    rng = np.random.default_rng(0)
    moments = np.concatenate([rng.uniform(0.0, t.duration, 7_000), t.plan.start])
    tick = min(1e-4, t.duration / 50)
    first, second = (
        t.state(np.clip(m, 0.0, t.duration)) for m in (moments - tick / 2, moments + tick / 2)
    )
    gap = second.time - first.time
    for i, x in enumerate("XYZ"):
        v0, v1 = first.velocity[x], second.velocity[x]
        fastest, hardest = bounds.velocity[i], bounds.acceleration[i]
        assert np.abs(v0).max() <= fastest * (1 + 1e-9)
        assert (np.abs(v1 - v0) <= hardest * gap * (1 + 1e-6) + 1e-7 * fastest).all()
        went = second.position[x] - first.position[x]
        assert (np.abs(went - (v0 + v1) / 2 * gap) <= hardest * gap**2 + 1e-9).all()
        assert np.abs(first.acceleration[x]).max() <= hardest * (1 + 1e-6)


@given(text=programs.programs(SITE, **OPTIONS))
@settings(max_examples=60, deadline=None)
def test_no_limit_is_ever_exceeded(text):
    bounds = Limits(
        np.array([100.0, 60.0, 20.0]), np.array([1000.0, 400.0, 200.0]), np.full(3, np.inf)
    )
    for conditions in (STRICT, Conditions(corner=0.05, cycle=0.0)):
        try:
            t = timed(text, MILL, conditions, bounds)
        except (GcompError, ProgramError):
            return  # no feed yet, or a code that is not simulated
        if t.duration > 0:
            check_limits(t, bounds)


@given(text=programs.programs(SITE, arcs=0.0, **OPTIONS))
@settings(max_examples=40, deadline=None)
def test_the_jerk_along_the_path_is_kept(text):
    bounds = Limits(
        np.array([100.0, 60.0, 20.0]), np.array([1000.0, 400.0, 200.0]), np.array([5e3, 2e4, 1e4])
    )
    try:
        t = timed(text, MILL, STRICT, bounds)
    except (GcompError, ProgramError):
        return
    if not t.duration:
        return
    check_limits(t, bounds)
    tick = 1e-5
    moments = np.random.default_rng(1).uniform(0.0, t.duration, 5_000)
    first, second = t.state(moments), t.state(np.minimum(moments + tick, t.duration))
    gap = second.time - first.time
    for i, x in enumerate("XYZ"):
        change = np.abs(second.acceleration[x] - first.acceleration[x])
        assert (change <= bounds.jerk[i] * gap * (1 + 1e-6) + 1e-6 * bounds.acceleration[i]).all()


@given(text=programs.programs(SITE, arcs=0.5, **OPTIONS))
@settings(max_examples=40, deadline=None)
def test_a_corner_that_is_not_cut_costs_a_step_of_one_cycle(text):
    """Over any time w the speed of an axis changes by a (w + cycle) and half of that again where
    corners are dense."""
    bounds, cycle = limits(MILL, 80.0, 500.0), 0.001
    try:
        t = timed(text, MILL, Conditions(corner=0.0, cycle=cycle), bounds)
    except (GcompError, ProgramError):
        return
    if not t.duration:
        return
    moments = np.random.default_rng(2).uniform(0.0, t.duration, 4_000)
    for w in (1e-4, 2e-3):
        first, second = t.state(moments), t.state(np.minimum(moments + w, t.duration))
        for x in "XYZ":
            assert (
                np.abs(second.velocity[x] - first.velocity[x]).max()
                <= 500.0 * (1.5 * w + cycle) * (1 + 1e-6) + 1e-6
            )


def test_every_target_is_reached():
    t = timed(
        HEAD + "G0 X1 Y2 Z3\nG1 X10.123 Y-4 F500\nG4 P1\nG2 X20.123 Y-4 I5 J0\nG4 P1\nM2\n",
        MILL,
        Conditions(),
    )
    rests = np.flatnonzero(np.nan_to_num(t.steps.wait[t.path.step]) > 0)
    s = t.state(t.plan.start[rests] + 0.5)
    assert np.stack([s.position[x] for x in "XYZ"]) == approx(
        np.array([[10.123, 20.123], [-4, -4], [3, 3]]), abs=1e-12
    )


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("G1 X10\n", "no feed"),
        ("G95\nG1 X10 F0.1\n", "spindle"),
        ("G0 Z1\nG81 X1 Z-1 R1 F10\n", "canned cycle"),
        ("G41 D1\nG1 X10 F100\n", "cutter radius"),
        ("G0 X0\nG33 Z-5 K1\n", "thread"),
        ("G4 P-1\n", "dwell"),
        ("(nothing)\n", "moves nothing"),
    ],
)
def test_what_can_not_be_simulated_is_refused(body, message):
    with pytest.raises(GcompError, match=message):
        timed(HEAD + body, MILL)


def test_what_stands_behind_the_end_is_not_run(tmp_path):
    assert duration("G0 X0\nG1 X100 F6000\nM30\nG4 P100\n") == approx(1.1, abs=1e-12)


def test_a_machine_folder_of_three_axes_runs(tmp_path):
    machine = read_machine(small_machines.write_mill(tmp_path / "mill", True))
    from dataclasses import replace

    machine = replace(machine, offsets={"G54": {}})
    assert timed(HEAD + "G0 X0 Y0 Z0\nG1 X100 F6000\nM2\n", machine).duration == approx(1.1)
