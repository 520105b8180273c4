"""Friction that turns round after a reversal: its shape, and when an excursion beside it is a cause of its own."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from postproc import effects
from postproc.diagnose import doubt, library
from postproc.effects import State


def test_friction_turns_round_as_the_loop_settles():
    """10 um of friction between the two senses, a loop of 20 ms: on the old side in the turn, half way between after
    20 ms x ln 2 = 13.9 ms, 5 um behind in the end."""
    since = np.array([0.0, 0.02 * np.log(2.0), 10.0])
    state = State({"X": np.zeros(3)}, {"X": np.ones(3)}, {"X": (0.0, 1.0)}, since={"X": since}, passage=np.zeros(3))
    found = effects.deviation(effects.load("coulomb_friction"), state, "X", size_um=10.0, settle_ms=20.0)
    assert found[0] == pytest.approx([5e-3, 0.0, -5e-3])


def findings(*named: tuple[str, str, dict[str, float]]) -> SimpleNamespace:
    return SimpleNamespace(
        findings=[
            SimpleNamespace(block=SimpleNamespace(name=n, axis=a), value=v, status="accepted") for n, a, v in named
        ]
    )


@pytest.mark.parametrize(
    ("size", "slope", "axis", "own"),
    [
        (-10.0, 4.0, "X", False),  # from the old side: minus twice 5 um of friction in the turn
        (-10.0, 30.0, "X", True),  # it rises to (-10 + 30 x 1.33) exp(-1.33) = 7.9 um above: more than friction holds
        (6.0, 0.0, "X", True),
        (-10.0, 4.0, "Y", True),  # of another axis
    ],
)
def test_an_excursion_that_friction_makes_is_no_second_cause(size, slope, axis, own):
    """Beside 10 um of friction between the senses, 5 um each way."""
    d = findings(
        ("coulomb_friction", "X", {"size_um": 10.0}),
        ("reversal_spike", axis, {"size_um": size, "slope_um": slope, "tau_ms": 10.0}),
    )
    assert (doubt._turns(d) == []) is own


def test_a_pair_is_compared_where_both_of_its_axes_move():
    """A circle in XY tells X from Y, and nothing of Z, which stands still."""
    angle = np.linspace(0.0, 6.28, 90)
    place = {"X": 50 * np.cos(angle), "Y": 50 * np.sin(angle), "Z": np.zeros(90)}
    speed = {"X": -50 * np.sin(angle), "Y": 50 * np.cos(angle), "Z": np.zeros(90)}
    state = State(place, {x: np.sign(v) for x, v in speed.items()}, dict.fromkeys("XYZ", (-60.0, 60.0)), velocity=speed)
    module = effects.load("servo_mismatch")
    told = {pair for pair in ("XY", "XZ", "YZ") if library.needed(SimpleNamespace(state=state), module, pair)}
    assert told == {"XY"}
