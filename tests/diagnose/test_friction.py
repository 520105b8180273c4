"""Friction that turns round after a reversal: its shape; and where a pair of axes is compared."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from postproc import effects
from postproc.diagnose import library
from postproc.effects import State


def test_friction_turns_round_as_the_loop_settles():
    """10 um of friction between the two senses, a loop of 20 ms: on the old side in the turn, half way between after
    20 ms x ln 2 = 13.9 ms, 5 um behind in the end."""
    since = np.array([0.0, 0.02 * np.log(2.0), 10.0])
    state = State({"X": np.zeros(3)}, {"X": np.ones(3)}, {"X": (0.0, 1.0)}, since={"X": since}, passage=np.zeros(3))
    found = effects.deviation(effects.load("coulomb_friction"), state, "X", size_um=10.0, settle_ms=20.0)
    assert found[0] == pytest.approx([5e-3, 0.0, -5e-3])


def test_a_pair_is_compared_where_both_of_its_axes_move():
    """A circle in XY tells X from Y, and nothing of Z, which stands still."""
    angle = np.linspace(0.0, 6.28, 90)
    place = {"X": 50 * np.cos(angle), "Y": 50 * np.sin(angle), "Z": np.zeros(90)}
    speed = {"X": -50 * np.sin(angle), "Y": 50 * np.cos(angle), "Z": np.zeros(90)}
    state = State(place, {x: np.sign(v) for x, v in speed.items()}, dict.fromkeys("XYZ", (-60.0, 60.0)), velocity=speed)
    module = effects.load("servo_mismatch")
    told = {pair for pair in ("XY", "XZ", "YZ") if library.needed(SimpleNamespace(state=state), module, pair)}
    assert told == {"XY"}
