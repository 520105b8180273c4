"""Textbook forms of effects, by hand: friction at rest and at slow speeds, jumps that come back,
leads of screws, a tool ground again."""

from __future__ import annotations

import numpy as np
from pytest import approx

from postproc import effects
from postproc.effects import State, cyclic, step_loss

LIMITS = {"X": (0.0, 100.0)}


def moved(name: str, state: State, axis: str = "X", **named: float) -> np.ndarray:
    """(N,) um along X."""
    return effects.deviation(effects.load(name), state, axis, **named)[0] * 1e3


def test_viscous_friction_with_a_power_is_no_lag():
    """At 10 mm/s it is um_s_mm times 10 whatever the power; at 40 mm/s with the power 1/2 only
    twice as much."""
    state = State(
        {"X": np.zeros(3)}, {"X": np.ones(3)}, LIMITS, velocity={"X": np.array([10.0, 40.0, -40.0])}
    )
    assert moved("viscous_friction", state, um_s_mm=0.5) == approx([-5.0, -20.0, 20.0])
    assert moved("viscous_friction", state, um_s_mm=0.5, power=0.5) == approx([-5.0, -10.0, 10.0])


def test_friction_is_let_go_at_rest_and_higher_when_slow():
    """10 um between the directions; 4 um more at the slowest, fallen by e at 6 mm/s: 5 + 2
    exp(-(1)^2) = 5.736 um behind."""
    speed = np.array([100.0, 6.0, 0.0, -100.0])
    state = State(
        {"X": np.zeros(4)}, {"X": np.array([1.0, 1.0, 1.0, -1.0])}, LIMITS, velocity={"X": speed}
    )
    named = {"size_um": 10.0, "stribeck_um": 4.0, "stribeck_mm_s": 6.0}
    assert moved("coulomb_friction", state, released=1.0, **named) == approx(
        [-5.0, -5.7358, 0.0, 5.0], abs=1e-3
    )
    assert moved("coulomb_friction", state, **named)[2] == approx(-7.0)


def test_steps_are_lost_and_found_again():
    state = State(
        {"X": np.zeros(4)}, {"X": np.ones(4)}, LIMITS, time=np.array([0.0, 10.0, 20.0, 30.0])
    )
    named = {
        "jump_um": 8.0,
        "t_s": 5.0,
        "second_um": -6.0,
        "second_s": 15.0,
        "third_um": 1.0,
        "third_s": 25.0,
    }
    assert moved("step_loss", state, **named) == approx([0.0, 8.0, 2.0, 3.0])


def test_lost_steps_are_named_where_each_is_large_and_all_go_one_way():
    """To and fro is as well an instrument that switches."""
    assert step_loss.sensible(jump_um=-2.0, second_um=-3.0, second_s=7.0)
    assert not step_loss.sensible(jump_um=1.2)
    assert not step_loss.sensible(jump_um=4.0, second_um=0.3, second_s=7.0)
    assert step_loss.sensible(jump_um=3.0, second_um=1.1, second_s=7.0)
    assert step_loss.sensible(jump_um=9.0, second_um=1.6, second_s=7.0)
    assert not step_loss.sensible(jump_um=4.0, second_um=-3.0, second_s=7.0)
    many = np.array([[-2.0, 1.2, 4.0, 4.0], [-3.0, 0.0, 0.3, -3.0]])
    assert step_loss.sensible(*many).tolist() == [True, False, False, False]


def test_a_spike_lasts_over_a_way():
    """8 um at the turn, 8 / e after 0.5 mm, whatever the speed; 8 / e + 2 / e with a slope of 2."""
    state = State(
        {"X": np.zeros(3)},
        {"X": np.array([1.0, 1.0, -1.0])},
        LIMITS,
        distance={"X": np.array([0.0, 0.5, 0.5])},
        velocity={"X": np.array([0.0, 3.0, -30.0])},
        since={"X": np.array([0.0, 9.0, 9.0])},
    )
    named = {"size_um": 8.0, "slope_um": 0.0, "tau_ms": 0.0, "length_mm": 0.5}
    assert moved("reversal_spike", state, **named) == approx([-8.0, -8 / np.e, 8 / np.e])
    assert moved("reversal_spike", state, **named | {"slope_um": 2.0})[1] == approx(-10 / np.e)


def test_a_screw_swings_otherwise_from_the_other_side():
    """2 um, cosine, and 1 um cosine of the side: 3 um coming from below and 1 um from above; both
    are what the tables hold."""
    named = {"period_mm": 10.0, "amplitude_um": 2.0, "phase_deg": 0.0, "sided_um": 1.0}
    for side, size in ((1.0, 3.0), (-1.0, 1.0)):
        state = State({"X": np.array([20.0, 25.0])}, {"X": np.full(2, side)}, LIMITS)
        assert moved("cyclic", state, **named) == approx([size, -size])
    _, _, nodes, forward, reverse = cyclic.tables("X", (0.0, 100.0), **named)[0]
    assert np.interp(20.0, nodes, forward) == approx(3e-3) and np.interp(
        20.0, nodes, reverse
    ) == approx(1e-3)


def test_leads_are_asked_for_where_they_turn_often_enough():
    state = State({"X": np.linspace(0.0, 14.0, 30)}, {"X": np.ones(30)}, LIMITS)
    # two turns of 6 mm are 12 mm, of 8 mm they were 16 mm
    assert max(shape["period_mm"] for shape in cyclic.shapes(state, "X")) == 6.0


def test_beams_give_as_textbooks_say():
    """A beam held at one end: 5/16 of its end's deflection at half the reach. One on two supports
    under its load: s^2 (1 - s)^2, at a quarter (3/16)^2 over (1/4)^2 = 0.5625 of the middle; the
    series of four terms is within 1 %."""
    state = State(
        {"X": np.array([50.0, 100.0, 25.0]), "Z": np.zeros(3)},
        {"X": np.ones(3)},
        LIMITS | {"Z": (0.0, 1.0)},
    )
    sag = effects.load("sag")
    held = effects.deviation(sag, state, "X", size_um=16.0, along=2.0)[2] * 1e3
    assert held[:2] == approx([5.0, 16.0])
    beam = effects.deviation(sag, state, "X", size_um=1.0, along=2.0, beam=0.0)[2]
    assert beam[2] / beam[0] == approx(0.5625, rel=0.01)
    # clamped at both ends, s^3 (1 - s)^3: at a quarter (3/4)^3 of the middle
    clamped = effects.deviation(sag, state, "X", size_um=1.0, along=2.0, free_end=0.0)[2]
    assert clamped[2] / clamped[0] == approx(0.421875)
    # from the low end, beyond 40 % of the travel: nothing at 100, 1/6 of the way out at 50
    # clamped at the low end and propped at the high one: s^3 (1 - s)^2 (4 - s)
    propped = effects.deviation(sag, state, "X", size_um=1.0, along=2.0, propped=1.0)[2]
    assert propped[2] / propped[0] == approx(0.25**3 * 0.75**2 * 3.75 / (0.5**5 * 3.5))
    assert propped[1] == approx(0.0) and propped[0] * 1e3 == approx(0.5**5 * 3.5 / 0.117749)
    low = dict(size_um=432.0, along=2.0, free_end=-1.0, begins=0.4)
    assert effects.deviation(sag, state, "X", **low)[2][:2] * 1e3 == approx([17.0, 0.0])
    # a ram that stands out by 25 % of its travel at its end: (3/5)^3 half way
    ram = dict(size_um=125.0, along=2.0, begins=-0.25, ram=1.0)
    assert effects.deviation(sag, state, "X", **ram)[2][0] * 1e3 == approx(27.0)


def test_a_tool_is_ground_between_two_parts():
    """12 um larger, 6 um from part 3 on: a pocket grows by as much as the tool."""
    channels = {
        "part": np.arange(1.0, 5.0),
        "material": np.ones(4),
        "wall": -np.ones(4),
        "bore": np.zeros(4),
    }
    state = State({"X": np.full(4, 50.0)}, {"X": np.ones(4)}, LIMITS, channels=channels)
    found = moved("tool_size", state, "", diameter_um=12.0, change=3.0, then_um=6.0)
    assert found == approx([12.0, 12.0, 6.0, 6.0])


def test_the_walls_of_the_first_part_are_cut_by_a_worn_edge():
    """10 um a part: 5, 15 and 25 um where walls are finished when half of the part is cut."""
    channels = {
        "part": np.arange(1.0, 4.0),
        "material": np.ones(3),
        "wall": np.ones(3),
        "bore": np.zeros(3),
    }
    state = State({"X": np.full(3, 50.0)}, {"X": np.ones(3)}, LIMITS, channels=channels)
    found = moved("tool_wear", state, rate_um=10.0, start_um=0.0, change=0.0, cut=0.5)
    assert found == approx([5.0, 15.0, 25.0])


def test_a_slide_sticks_for_a_way_and_slips_for_a_time():
    """4 um: wound up over 1 mm, let go in 50 ms, at 2 mm/s over 0.1 mm. Half of it is the middle.
    Above 3 mm/s it slides evenly."""
    way = np.array([0.0, 0.5, 1.0, 1.05, 1.6, 0.5])
    state = State(
        {"X": way},
        {"X": np.ones(6)},
        LIMITS,
        velocity={"X": np.array([2.0] * 5 + [4.0])},
        distance={"X": way},
    )
    named = {"period_mm": 1.0, "size_um": 4.0, "fastest_mm_s": 3.0, "slip_ms": 50.0}
    assert moved("stick_slip", state, **named) == approx([2.0, 0.0, -2.0, 0.0, 0.0, 0.0])
    # with a mean lag of 2 um it never leads
    lagging = moved("stick_slip", state, **named, mean_um=2.0)
    assert lagging == approx([0.0, -2.0, -4.0, -2.0, -2.0, 0.0])


def test_stick_slip_in_rows_that_are_means():
    """A tooth of 1 mm in rows that are means of samples 0.5 mm apart: half of the steps are left
    out, and the mean of 0.25 and 0.75 is the middle."""
    state = State(
        {"X": np.array([0.25])},
        {"X": np.ones(1)},
        LIMITS,
        velocity={"X": np.ones(1)},
        distance={"X": np.array([0.25])},
        inside={"X": np.array([[0.25], [0.75]])},
    )
    assert moved("stick_slip", state, period_mm=1.0, size_um=4.0) == approx([0.0])


def test_the_mean_lag_of_a_sawtooth_lies_within_it():
    within = effects.load("stick_slip").sensible
    assert within(period_mm=1.0, size_um=4.0, mean_um=2.0)
    assert not within(period_mm=1.0, size_um=4.0, mean_um=6.0)
    assert not within(period_mm=1.0, size_um=4.0, mean_um=-2.0)


def test_a_clock_is_set_right_every_so_often():
    """100 us a second, 10 mm/s: 1 um later each second; set right every 4 s, at 3 s first."""
    state = State(
        {"X": np.zeros(4)},
        {"X": np.ones(4)},
        LIMITS,
        velocity={"X": np.full(4, 10.0)},
        time=np.array([0.0, 2.0, 3.5, 8.0]),
        file=np.zeros(4),
    )
    named = {"ppm": 100.0, "every_s": 4.0, "gone": 0.25}
    assert moved("clock_skew", state, "", **named) == approx([-1.0, -3.0, -0.5, -1.0])
    assert moved("clock_skew", state, "", ppm=100.0) == approx([0.0, -2.0, -3.5, -8.0])


def test_a_clock_whose_rate_changes_is_late_by_the_square_of_the_time():
    """100 us a second and 50 us a second squared less, 10 mm/s: level after 2 s."""
    state = State(
        {"X": np.zeros(4)},
        {"X": np.ones(4)},
        LIMITS,
        velocity={"X": np.full(4, 10.0)},
        time=np.array([5.0, 6.0, 7.0, 9.0]),
        file=np.zeros(4),
    )
    named = {"ppm": 100.0, "drift_us_s2": -50.0}
    assert moved("clock_skew", state, "", **named) == approx([0.0, -0.5, 0.0, 4.0])
    clock = effects.load("clock_skew")
    plain = {"whole": 0.0, "every_s": 0.0, "gone": 0.0, "drifts": 0.0}
    (fuller,) = clock.fuller(plain, state, "")
    assert clock.parameters(np.array([100.0, -50.0]), fuller) == clock.OPTIONAL | named | fuller
    assert clock.fuller(plain | {"every_s": 4.0}, state, "") == []
    assert clock.fuller(plain | {"whole": 1.0}, state, "") == []


def test_no_frame_drifts_within_minutes():
    """Of a test of four minutes no drift is asked for; of one of twenty, none that comes within
    a minute."""
    for lasts, soonest in ((240.0, None), (1200.0, 60.0)):
        state = State(
            {"X": np.zeros(2)},
            {"X": np.ones(2)},
            LIMITS,
            time=np.array([100.0, 100.0 + lasts]),
            file=np.zeros(2),
            channels={"T_air_C": np.array([20.0, 20.5])},
        )
        shapes = effects.load("structure_drift").shapes(state, "X")
        comes = [abs(s["tau_s"]) for s in shapes if not s["creep"] and not s["cycle_s"]]
        assert min(comes, default=None) == soonest


def test_a_slide_that_creeps_from_the_start_sticks_and_slips_from_there():
    """No turn is known: it sticks from where its motion began, at 10 mm, 2 mm at a time."""
    place = np.array([10.0, 10.0, 11.0, 11.9, 12.1])
    state = State(
        {"X": place},
        {"X": np.ones(5)},
        LIMITS,
        velocity={"X": np.array([0.0, 1.0, 1.0, 1.0, 1.0])},
        distance={"X": np.full(5, effects.ENDLESS)},
        passage=np.zeros(5),
    )
    found = moved("stick_slip", state, period_mm=2.0, size_um=4.0)
    assert found == approx([0.0, 2.0, 0.0, -1.8, 1.8])


def test_one_axis_leads_and_the_other_lags_more():
    """X lags by 4 ms, Y leads by 2: apart by 6 ms, 1 ms in the mean. Two axes that both lag are two
    lags."""
    state = State(
        {"X": np.zeros(1), "Y": np.zeros(1)},
        {"X": np.ones(1), "Y": np.ones(1)},
        LIMITS | {"Y": (0.0, 100.0)},
        velocity={"X": np.array([3.0]), "Y": np.array([5.0])},
    )
    mismatch = effects.load("servo_mismatch")
    found = effects.deviation(mismatch, state, "XY", delta_tau_ms=6.0, mean_tau_ms=1.0) * 1e3
    assert found[:2, 0] == approx([-12.0, 10.0])
    assert mismatch.sensible(delta_tau_ms=6.0, mean_tau_ms=1.0)
    assert not mismatch.sensible(delta_tau_ms=2.0, mean_tau_ms=4.0)


def test_a_beam_is_aligned_between_two_runs():
    """10 ppm of 500 mm, until run 2."""
    state = State(
        {"X": np.full(3, 500.0)},
        {"X": np.ones(3)},
        {"X": (0.0, 500.0)},
        run=np.array([1.0, 2.0, 3.0]),
        beam=np.full(3, 500.0),
        file=np.zeros(3),
    )
    cosine = effects.load("cosine")
    found = effects.deviation(cosine, state, "X", ppm=-10.0, file=0.0, last=2.0) * 1e3
    assert found == approx([-5.0, -5.0, 0.0])


def test_faces_of_a_step_gauge_that_stands_askew_lie_farther_apart():
    """10 ppm of 500 mm, too long in the second recording alone."""
    state = State(
        {"X": np.full(3, 500.0)},
        {"X": np.ones(3)},
        {"X": (0.0, 500.0)},
        run=np.ones(3),
        beam=np.full(3, 500.0),
        file=np.array([0.0, 1.0, 1.0]),
    )
    cosine = effects.load("cosine")
    found = effects.deviation(cosine, state, "X", ppm=-10.0, file=1.0, touched=1.0) * 1e3
    assert found == approx([0.0, 5.0, 5.0])


def test_askew_in_every_set_up_or_until_a_run():
    """Two recordings along X of three runs each: each set-up, both, and each until run 1 or 2."""
    place = np.tile([0.0, 250.0, 500.0], 6)
    state = State(
        {"X": place},
        {"X": np.ones(18)},
        {"X": (0.0, 500.0)},
        run=np.tile(np.repeat([1.0, 2.0, 3.0], 3), 2),
        beam=place,
        file=np.repeat([0.0, 1.0], 9),
    )
    ways = [(s["file"], s["last"]) for s in effects.load("cosine").shapes(state, "X")]
    assert sorted(ways) == [(-1, 0), (0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]


def test_a_dead_path_shows_at_a_mirror_that_stands():
    """Half a kelvin at 2 um/K, and two hours at 3 um/h of a pressure that rises."""
    state = State(
        {"X": np.zeros(2)},
        {"X": np.ones(2)},
        LIMITS,
        time=np.array([100.0, 7300.0]),
        file=np.zeros(2),
        beam=np.zeros(2),
        passage=np.full(2, -1.0),
        channels={"T_air_C": np.array([20.0, 20.5])},
    )
    path = effects.load("dead_path")
    found = effects.deviation(path, state, "", um_K=2.0, um_h=3.0, file=0.0) * 1e3
    assert found == approx([0.0, 7.0])
    assert {s["file"] for s in path.shapes(state, "")} == {0.0}


def test_a_column_bends_out_and_back():
    """Its front with 1000 s, its back with 4000 s: after 4000 s of 8000 s, 10 um of one less 5 um
    of the other, each as it stands at the end."""
    state = State(
        {"X": np.zeros(3)}, {"X": np.ones(3)}, LIMITS, time=np.array([1.0, 4001.0, 8001.0])
    )
    named = dict(size_um=10.0, tau_s=1000.0, back_um=-5.0, back_s=4000.0)
    front, back = (1 - np.exp(-4)) / (1 - np.exp(-8)), (1 - np.exp(-1)) / (1 - np.exp(-2))
    found = moved("structure_drift", state, **named)
    assert found == approx([0.0, 10.0 * front - 5.0 * back, 5.0])


def test_of_one_axis_alone_a_sawtooth_of_time_is_no_clock():
    """The same motion of X, with Y at rest and with Y on the move."""
    moving, still = np.array([3.0, -3.0, 3.0]), np.zeros(3)
    clock = effects.load("clock_skew")
    for other, known in ((still, False), (moving, True)):
        state = State(
            {"X": np.zeros(3), "Y": np.zeros(3)},
            {"X": np.ones(3), "Y": np.ones(3)},
            LIMITS | {"Y": (0.0, 100.0)},
            velocity={"X": moving, "Y": other},
            time=np.array([0.0, 30.0, 60.0]),
            file=np.zeros(3),
            passage=np.zeros(3),
        )
        assert any(s["every_s"] > 0 for s in clock.shapes(state, "")) == known


def test_a_clock_that_is_set_right_is_no_delay():
    """It comes to be no later than a recording may be, 5 ms, and is set right while it lasts."""
    clock = effects.load("clock_skew")
    assert clock.sensible(ppm=100.0, every_s=40.0)
    assert not clock.sensible(ppm=100.0, every_s=60.0)
    assert clock.sensible(ppm=900.0)
    state = State(
        {"X": np.zeros(2)},
        {"X": np.ones(2)},
        LIMITS,
        velocity={"X": np.full(2, 10.0)},
        time=np.array([0.0, 10.0]),
        file=np.zeros(2),
    )
    assert not moved("clock_skew", state, "", ppm=5.0, every_s=100.0, gone=0.5).any()
