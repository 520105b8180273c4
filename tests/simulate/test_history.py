"""What an axis has been through: sides, ways and times since a turn, and the heat of its travel."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from pytest import approx

from postproc.errors import GcompError
from postproc.simulate.history import FAR, Heat
from postproc.simulate.timeline import Conditions
from tests import programs

from .samples import STRICT, exact, limits, timed
from .test_plan import OPTIONS, SITE

MILL = exact()


def test_by_hand():
    """X goes up 100 mm, back 30, rests, and on 20; Y never moves. 10 mm/s, so hard that ramps do
    not count."""
    text = "G0 X0\nG1 X100 F600\nG1 X70\nG4 P5\nG1 X50\nG1 X60\nM2\n"
    t = timed(text, MILL, STRICT, limits(MILL, 1e3, 1e8))
    s = t.state(np.array([5.0, 11.0, 15.0, 19.0, 20.5]))
    assert s.approach["X"].tolist() == [1, -1, -1, -1, 1]
    assert s.approach["Y"].tolist() == [0] * 5
    assert s.distance["X"] == approx([FAR, 10.0, 30.0, 40.0, 5.0], abs=1e-4)
    assert s.since["X"] == approx([FAR, 1.0, 5.0, 9.0, 0.5], abs=1e-4)
    assert s.position["X"] == approx([50.0, 90.0, 70.0, 60.0, 55.0], abs=1e-4)


@given(text=programs.programs(SITE, arcs=0.5, **OPTIONS))
@settings(max_examples=40, deadline=None)
def test_sides_and_ways_are_those_that_dense_samples_show(text):
    try:
        t = timed(text, MILL, STRICT, limits(MILL))
    except GcompError:
        return
    if not t.duration:
        return
    time = np.linspace(0.0, t.duration, 20_001)
    s = t.state(time)
    for x in "XYZ":
        step = np.diff(s.position[x])
        clear = np.abs(step) > 1e-5
        same = s.approach[x][1:] == s.approach[x][:-1]  # no turn between the two samples
        assert (s.approach[x][1:][clear & same] == np.sign(step)[clear & same]).all()
        turned = (s.distance[x][1:] < FAR / 2) & same
        gone = np.diff(s.distance[x])
        fine = turned & (gone >= 0)  # else it turned twice
        assert gone[fine] == approx(np.abs(step)[fine], abs=1e-6)


def test_going_back_by_less_than_the_play_is_no_turn():
    text = "G0 X0\nG1 X100 F600\nG1 X99.99\nG4 P1\nG1 X50\nM2\n"
    at = np.array([10.5])
    for play, side in ((0.0, -1), (0.02, -1), (60.0, 1)):
        assert (
            timed(text, MILL, Conditions(play=play), limits(MILL, 1e3, 1e8)).state(at).approach["X"]
            == side
        )
    short = text.replace("G1 X50", "G1 X150")
    assert (
        timed(short, MILL, Conditions(play=0.02), limits(MILL, 1e3, 1e8)).state(at).approach["X"]
        == 1
    )


def test_a_screw_warms_with_its_travel_and_cools_at_rest():
    """5 m/min to and fro for an hour with 0.8 K a m/min and 1800 s: 4 (1 - exp(-2)) K; then exp(-1)
    of it after 1800 s."""
    swing = "G1 X100 F5000\nG1 X0\n" * 1500
    text = f"G0 X0\n{swing}G4 P1800\nM2\n"
    t = timed(text, MILL, STRICT, limits(MILL, 1e3, 1e7))
    time = np.array([0.0, 3600.0, t.duration])
    s = t.state(time, t.plan.at(time)[0])
    top = 4 * (1 - np.exp(-2))
    assert s.channels["T_screw_X_C"] - 20 == approx(
        [0.0, top, top * np.exp(-1)], rel=1e-3, abs=1e-9
    )
    assert s.channels["T_screw_Y_C"] == approx([20.0] * 3)


def test_air_drifts_and_bed_and_screws_follow():
    """The answer of a first order to a ramp of 2 K/h: r (t - tau (1 - exp(-t / tau)))."""
    heat = Heat(air=18.0, drift=2.0, tau=1800.0, bed_tau=7200.0)
    t = timed("G0 X0\nG1 X1 F600\nG4 P7200\nM2\n", MILL, Conditions(heat=heat))
    c = t.state(np.array([7200.0])).channels
    assert c["T_air_C"] == approx([22.0])
    assert c["T_bed_C"] == approx([18 + 2 * (2 - 2 * (1 - np.exp(-1)))])
    assert c["T_screw_Y_C"] == approx([18 + 2 * (2 - 0.5 * (1 - np.exp(-4)))])


def test_the_spindle_turns_from_its_block_on():
    text = "G0 X0\nG1 X100 F6000\nM3 S1200\nG1 X200\nS800\nG1 X300\nM5\nG1 X400\nM2\n"
    t = timed(text, MILL, STRICT)
    s = t.state(np.array([0.5, 1.6, 2.7, 4.0]))
    assert s.channels["spindle_rpm"].tolist() == [0, 1200, 800, 0]


def test_parts_are_counted_and_the_second_begins_where_the_first_ended():
    t = timed("G0 X0\nG1 X100 F6000\nM2\n", MILL, STRICT, parts=3)
    s = t.state(np.array([0.5, t.duration - 0.5]))
    assert s.channels["part"].tolist() == [1, 3]
    assert t.path.length.sum() == approx(100 * 5)
    assert s.distance["X"][1] < 100


def test_time_of_the_experiment_begins_where_it_is_said():
    t = timed("G0 X0\nG1 X100 F6000\nM2\n", MILL, Conditions(begin=500.0))
    assert t.state(np.array([0.25])).time == approx([500.25])
