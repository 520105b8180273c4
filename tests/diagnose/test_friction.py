"""Friction that turns round after a reversal: its shape, that it opposes motion, and where a pair
of axes is compared."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from postproc import effects
from postproc.diagnose import library
from postproc.effects import State, friction_asymmetry


def test_friction_turns_round_as_the_loop_settles():
    """10 um of friction between the two senses, a loop of 20 ms: on the old side in the turn, half
    way between after 20 ms x ln 2 = 13.9 ms, 5 um behind in the end."""
    time = np.array([0.0, 1.0, 1.0, 1.0 + 0.02 * np.log(2.0), 10.0])
    state = State(
        {"X": np.zeros(5)},
        {"X": np.array([-1.0, -1.0, 1.0, 1.0, 1.0])},
        {"X": (0.0, 1.0)},
        time=time,
        passage=np.zeros(5),
    )
    found = effects.deviation(
        effects.load("coulomb_friction"), state, "X", size_um=10.0, settle_ms=20.0
    )
    assert found[0] == pytest.approx([5e-3, 5e-3, 5e-3, 0.0, -5e-3])


def test_friction_that_differs_turns_round_as_the_loop_settles():
    """10 um of dry friction at either side, 4 um of grease more in + than in - at 100 mm/s: as it
    was in the turn, half way between after 20 ms x ln 2, on the other side in the end."""
    time = np.array([0.0, 1.0, 1.0, 1.0 + 0.02 * np.log(2.0), 10.0])
    side = np.array([-1.0, -1.0, 1.0, 1.0, 1.0])
    state = State(
        {"X": np.zeros(5)},
        {"X": side},
        {"X": (0.0, 1.0)},
        velocity={"X": 100.0 * side},
        time=time,
        passage=np.zeros(5),
    )
    sizes = {"size_um": 10.0, "slope_um": 0.0, "difference_um": 0.0, "difference_slope_um": 4.0}
    found = effects.deviation(friction_asymmetry, state, "X", tau_ms=0.0, settle_ms=20.0, **sizes)
    assert found[0] == pytest.approx([6e-3, 6e-3, 6e-3, -4e-3, -14e-3])


def test_a_position_loop_lags_as_a_first_order_element():
    """From rest to 100 mm/s at 1000 mm/s2 with a gain of 50 per s: by the solution of
    e' = v - 50 e, e = (a / 50) (t - 20 ms (1 - exp(-t / 20 ms))) while it accelerates, then it
    closes to v / 50 = 2 mm with 20 ms; at rest it is 20 ms late to let go."""
    time = np.arange(0.0, 0.5, 0.002)
    speed = np.interp(time, [0.0, 0.1, 0.3, 0.3], [0.0, 100.0, 100.0, 0.0])
    state = State(
        {"X": np.zeros(len(time))},
        {"X": np.ones(len(time))},
        {"X": (0.0, 1.0)},
        velocity={"X": speed},
        time=time,
        passage=np.zeros(len(time)),
    )
    lag = -effects.deviation(effects.load("servo_lag"), state, "X", tau_ms=20.0, settle_ms=20.0)[0]
    started = time <= 0.1
    ramp = 1000.0 / 50 * (time - 0.02 * (1 - np.exp(-time / 0.02)))
    assert lag[started] == pytest.approx(ramp[started], abs=1e-9)
    left = 2.0 - ramp[time == 0.1][0]
    runs = (time > 0.1) & (time < 0.299)
    assert lag[runs] == pytest.approx(2.0 - left * np.exp(-(time[runs] - 0.1) / 0.02), abs=1e-6)
    assert lag[-1] < 2.0 * np.exp(-(time[-1] - 0.302) / 0.02)


@pytest.mark.parametrize(
    ("size", "slope", "difference", "holds"),
    [
        (6.7, 8.7, -4.2, True),
        (0.0, 10.0, 10.0, True),
        (0.1, 0.1, 20.0, False),
        (0.0, 10.0, 0.5, False),
    ],
)
def test_friction_opposes_motion_in_both_directions(size, slope, difference, holds):
    """A lag of 10 and none is friction of one direction; a push along one of them is none; and
    alike it has another name."""
    assert (
        friction_asymmetry.sensible(
            size_um=size,
            slope_um=slope,
            difference_um=0.0,
            difference_slope_um=difference,
            tau_ms=0.0,
        )
        is holds
    )


@pytest.mark.parametrize(
    ("size", "slope", "difference", "difference_slope", "holds"),
    [
        (10.0, 4.0, 4.0, 2.0, True),
        (-12.0, 18.7, -11.4, 18.6, False),  # after turns of one direction alone
        (2.0, 6.0, -4.0, 15.0, False),  # pushed along in the other one
        (10.0, 20.0, -0.7, 0.5, False),  # alike in both
    ],
)
def test_spikes_that_differ_with_the_direction_oppose_motion_in_both(
    size, slope, difference, difference_slope, holds
):
    values = (size, slope, difference, difference_slope)
    assert friction_asymmetry.sensible(*values, tau_ms=20.0) is holds
    assert friction_asymmetry.sensible(*values, tau_ms=0.0, length_mm=0.1) is holds


ANGLE = np.linspace(0.0, 6.28, 90)
FIRST = np.arange(90) < 45  # readings of a test of two parts


@pytest.mark.parametrize(
    "place, direction, pairs",
    [
        # A circle in XY tells X from Y, and nothing of Z, which stands still.
        (
            {"X": 50 * np.cos(ANGLE), "Y": 50 * np.sin(ANGLE), "Z": 0 * ANGLE},
            np.stack([np.cos(ANGLE), np.sin(ANGLE), 0 * ANGLE], axis=1),
            {"XY"},
        ),
        # X moves first and is read along X, then Z along Z: each lag shows by itself.
        (
            {"X": np.where(FIRST, ANGLE, 0.0), "Y": 0 * ANGLE, "Z": np.where(FIRST, 0.0, ANGLE)},
            np.stack([FIRST, 0 * ANGLE, ~FIRST], axis=1).astype(float),
            {"XZ"},
        ),
    ],
)
def test_a_pair_is_compared_where_both_of_its_axes_move(place, direction, pairs):
    speed = {x: np.where(p != 0, np.gradient(p, ANGLE), 0.0) for x, p in place.items()}
    state = State(
        place,
        {x: np.sign(v) for x, v in speed.items()},
        dict.fromkeys("XYZ", (-60.0, 60.0)),
        velocity=speed,
    )
    module = effects.load("servo_mismatch")
    rows = SimpleNamespace(state=state, direction=direction)
    assert {p for p in ("XY", "XZ", "YZ") if library.needed(rows, module, p)} == pairs


@pytest.mark.parametrize(
    "column, told", [(None, False), (np.full(4, 21.0), False), (np.arange(4.0), True)]
)
def test_an_effect_of_a_channel_is_asked_where_that_was_recorded_and_changed(column, told):
    """Of whatever name: a new effect brings its own."""
    channels = {} if column is None else {"T_column_C": column}
    state = State({"X": np.arange(4.0)}, {"X": np.ones(4)}, {"X": (0.0, 4.0)}, channels=channels)
    module = SimpleNamespace(NEEDS=("position", "T_column_C"), PER="axis", SEES=("tool",))
    assert library.needed(SimpleNamespace(state=state), module, "X") is told
