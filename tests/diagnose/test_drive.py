"""What a drive pushes with is judged by halves of its motion, each of which holds some."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from postproc import recordings
from postproc.diagnose import answer, drive


def motion(passage: list[int]) -> drive.Motion:
    values = np.arange(len(passage), dtype=float)
    return drive.Motion(*[values] * 9, passage=np.array(passage, float))


@pytest.mark.parametrize("passage", [[0] * 8, [1] * 8, [0] * 3 + [2] * 5, [4, 4, 7, 7, 7, 9, 9, 9]])
def test_neither_half_is_empty(passage):
    """Of passages in which the axis hardly moved nothing is left: the others are what there is."""
    second = drive._halves(motion(passage))
    assert 0 < second.sum() < len(passage)
    if len(set(passage)) > 1:  # a passage is not cut
        assert all(len(set(second[np.array(passage) == p])) == 1 for p in set(passage))


@pytest.mark.parametrize(("after", "named"), [(5.21, True), (7.4, False)])
def test_a_force_that_is_mostly_another_one_names_nothing(after, named):
    """The spread of a real mill's current, 8.62 A, is told to 5.21 A by its dry friction; of a
    force that is told to 7.4 of 8.62 most is cutting or drift."""
    term = SimpleNamespace(term=SimpleNamespace(name="coulomb_friction"), delayed=False)
    one = SimpleNamespace(axis="Y", fitted=(term,), raw=8.62, after=after)
    found = list(answer.felt(SimpleNamespace(findings=[], drives=[one])))
    assert found == ([(one, term)] if named else [])


@pytest.mark.parametrize(
    ("said", "named"),
    [("friction_asymmetry:Y", False), ("friction_asymmetry:X", True), ("windup:Y", True)],
)
def test_the_mean_of_a_friction_that_differs_with_the_direction_is_no_other_friction(said, named):
    term = SimpleNamespace(term=SimpleNamespace(name="coulomb_friction"), delayed=False)
    one = SimpleNamespace(axis="Y", fitted=(term,), raw=1.0, after=0.1)
    finding = SimpleNamespace(block=SimpleNamespace(key=said), status="accepted")
    assert bool(list(answer.felt(SimpleNamespace(findings=[finding], drives=[one])))) == named


def circle(turns_per_s: list[float], friction: float) -> recordings.Recording:
    """The current of 30 A per m/s2 behind a motor filter of 0.5 ms, and viscous friction of so many
    A per m/s, over 4 s at each speed of a circle of 50 mm, 500 Hz."""
    t = np.arange(0, 4, 0.002)
    parts = []
    for number, turns in enumerate(turns_per_s):
        w = 2 * np.pi * turns
        v = 50e-3 * w * np.cos(w * t)
        a, jerk = -50e-3 * w**2 * np.sin(w * t), -50e-3 * w**3 * np.cos(w * t)
        current = 30 * (a - 0.5e-3 * jerk) + friction * v
        parts.append((np.full(len(t), number + 1.0), 5.0 * number + t, 50 * np.sin(w * t), current))
    run, time, x, current = np.concatenate(parts, axis=1)
    current = current + np.random.default_rng(5).normal(0, 0.01, len(time))
    columns = {"run": run, "t_s": time, "X_cmd_mm": x, "X_act_mm": x, "X_current_A": current}
    return recordings.Recording(
        "trace", {"kind": "trace"}, columns, "made.csv", np.arange(len(time))
    )


@pytest.mark.parametrize(
    ("turns_per_s", "friction", "names"),
    [
        ([0.5], 0.0, set()),
        ([0.5], 1.0, set()),
        ([0.2, 0.5] * 2, 0.0, set()),
        ([0.2, 0.5] * 2, 1.0, {"viscous_friction"}),
    ],
)
def test_a_filtered_current_is_no_friction(turns_per_s, friction, names):
    """At one speed of a circle the delay of the current, m j T, goes with the velocity like viscous
    friction: two speeds part them. That a drive accelerates a mass is no error of the path."""
    (one,) = drive.drives([circle(turns_per_s, friction)])
    assert one.fitted[0].value["A_per_m_s2"] == pytest.approx(30, rel=0.01)
    found = answer.felt(SimpleNamespace(findings=[], drives=[one]))
    assert {f.term.name for _, f in found} == names
