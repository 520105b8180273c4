"""Of names whose curves differ by no more than a textbook form is wrong by, the commoner one is
told, however many readings there are, and the rarer ones stand beside it."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.effects import State, friction_asymmetry, reversal_spike, sag
from tests.diagnose.test_strangers_forms import circles, laser, names, spike
from tests.diagnose.test_workshop import diagnosed


@pytest.mark.parametrize(
    "taper, told", [(0.0, "backlash:X"), (0.1, "backlash:X"), (0.6, "backlash_position:X")]
)
def test_lost_motion_that_hardly_varies_is_lost_motion(tmp_path, taper, told):
    """9 um, by so much more at the upper end of the travel and less at the lower: 0.1 of it are 0.5
    um rms, which the scatter of 900 readings, 0.2 um, parts from nothing."""

    def off(p, side, run):
        return -side / 2 * 9.0 * (1.0 + taper * (p - 300.0) / 280.0)

    answer = diagnosed(tmp_path, laser(off, runs=25))
    assert names(answer) == [told]
    odds = answer["effects"][0]["names"]
    assert taper != 0.1 or odds["backlash:X"] > odds["backlash_position:X"] > 0.1


@pytest.mark.parametrize("unlike, told", [(0.1, "reversal_spike:X"), (0.8, "friction_asymmetry:X")])
def test_spikes_that_hardly_differ_with_the_direction_are_spikes(tmp_path, unlike, told):
    """Of a loop that makes up for friction in 40 ms, which turns round over 0.05 mm; in + higher by
    so much, in - lower."""

    def radial(t, x, y, vx, vy, a):
        height = 25.0 * (1.0 + unlike * np.sign(vx))
        return -height * spike(t, vx, 0.04, 0.05) * np.cos(a)

    assert names(diagnosed(tmp_path, *circles(radial)))[0] == told


def still(**places: np.ndarray) -> State:
    """Slides at these places, mm, of travels of 400 mm."""
    n = len(places["X"])
    return State(dict(places), {x: np.ones(n) for x in places}, {x: (0.0, 400.0) for x in places})


@pytest.mark.parametrize("moves", [False, True])
def test_a_sag_goes_with_the_place_of_another_slide_where_that_one_moved(moves):
    """A slide that stood still can not say that the curve grows with its place: that is the curve
    of the first one's place alone, which costs more."""
    x = np.linspace(0.0, 400.0, 20)
    z = np.linspace(0.0, 100.0, 20) if moves else np.full(20, 50.0)
    shapes = sag.shapes(still(X=x, Y=np.full(20, 10.0), Z=z), "X")
    second = [s for s in shapes if s["lever"] or (s["beam"] >= 0 and s["beam"] != 0)]
    assert bool(second) == moves


def test_a_general_form_says_which_is_its_special_case():
    shape = {"tau_ms": 20.0, "released": 0.0, "power": 1.0, "length_mm": 0.05}
    name, special = friction_asymmetry.special(**shape)
    time = np.linspace(0.0, 0.2, 40)
    state = State(
        {"X": time},
        {"X": np.where(time < 0.1, 1.0, -1.0)},
        {"X": (0.0, 1.0)},
        velocity={"X": np.where(time < 0.1, 1.0, -1.0)},
        distance={"X": np.where(time < 0.1, time, time - 0.1)},
        since={"X": np.where(time < 0.1, time, time - 0.1)},
        time=time,
        passage=np.zeros(40),
    )
    assert name == "reversal_spike"
    general = friction_asymmetry.columns(state, "X", **shape)
    assert reversal_spike.columns(state, "X", **special) == pytest.approx(general[:2])
    assert friction_asymmetry.special(tau_ms=0.0, length_mm=0.0) is None
