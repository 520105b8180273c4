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
    since = np.array([0.0, 0.02 * np.log(2.0), 10.0])
    state = State(
        {"X": np.zeros(3)},
        {"X": np.ones(3)},
        {"X": (0.0, 1.0)},
        since={"X": since},
        passage=np.zeros(3),
    )
    found = effects.deviation(
        effects.load("coulomb_friction"), state, "X", size_um=10.0, settle_ms=20.0
    )
    assert found[0] == pytest.approx([5e-3, 0.0, -5e-3])


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
