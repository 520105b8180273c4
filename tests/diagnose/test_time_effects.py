"""What comes with time, with the tool or at once: wear between changes, jumps between runs,
channels between recordings."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from postproc.diagnose import assembly, library, outliers
from postproc.effects import State, deviation, low_pass, screw_heat, structure_drift, tool_wear


def state(rpm: np.ndarray, gauged: float = 1.0) -> State:
    n = len(rpm)
    channels = {"spindle_rpm": rpm, "gauged": np.full(n, gauged)}
    return State(
        position={"X": np.zeros(n)},
        approach={"X": np.ones(n)},
        travel={"X": (0.0, 100.0)},
        time=np.arange(n) * 200.0,
        run=np.arange(n) + 1.0,
        channels=channels,
        file=np.zeros(n),
    )


def test_what_a_body_follows_is_the_same_reading_by_reading():
    """Readings at uneven times, not in the order of time."""
    rng = np.random.default_rng(3)
    t, driver = rng.permutation(np.cumsum(rng.uniform(0.1, 900.0, 37))), rng.normal(size=37)
    found = low_pass(replace(state(driver), time=t), driver, 500.0)
    now, before = 0.0, None
    for k in np.argsort(t):
        if before is not None:
            kept = np.exp(-(t[k] - before) / 500.0)
            now = kept * now + (1 - kept) * driver[k]
        before = t[k]
        assert found[k] == pytest.approx(now, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize(
    "times, files, heats",
    [
        ([0.0, 20.0, 40.0, 60.0], [0, 0, 0, 0], set()),
        ([0.0, 20.0, 1800.0, 1820.0], [0, 0, 1, 1], {0.0}),
        ([0.0, 600.0, 1200.0, 1800.0], [0, 0, 0, 0], {0.0, 1.0}),
    ],
)
def test_a_screw_gets_warm_in_minutes(times, files, heats):
    """Within one minute neither with time nor with travel; between two recordings with time, since
    of that nobody recorded the travel."""
    read = replace(state(np.zeros(4)), time=np.array(times), file=np.array(files, float))
    shapes = screw_heat.shapes(replace(read, position={"X": np.arange(4.0)}), "X")
    assert {s["by_travel"] for s in shapes if not s["to_s"] and not s["until_s"]} == heats


def test_wear_at_a_gauge_begins_again_after_each_life():
    shown = tool_wear.columns(state(np.full(12, 1500.0)), "X", change=0.0, life=4.0)
    assert shown.shape == (2, 3, 12)
    assert np.allclose(shown[0, 0] * 1e3, np.tile([0.0, 0.25, 0.5, 0.75], 3))
    assert not shown[:, 1:].any()


def test_no_edge_wears_while_the_spindle_stands():
    rpm = np.array([0.0, 1500.0, 0.0, 0.0, 1500.0, 1500.0])
    shown = tool_wear.columns(state(rpm), "X", change=0.0, life=5.0)[0, 0] * 1e3
    assert np.allclose(shown, [0.0, 0.2, 0.2, 0.2, 0.4, 0.0])


def test_a_tool_that_was_changed_in_the_second_recording():
    """Parts 1 to 4 in two recordings: 3 um a part, from anew before part 3 of the second one."""
    part = np.tile(np.arange(1.0, 5.0), 2)
    channels = {"part": part, "wall": np.ones(8), "bore": np.zeros(8)}
    both = replace(state(np.zeros(8)), channels=channels, file=np.repeat([0.0, 1.0], 4))
    assert {(s["file"], s["change"]) for s in tool_wear.shapes(both, "X")} >= {(0, 3), (1, 3)}
    shown = deviation(
        tool_wear, both, "X", rate_um=3.0, start_um=0.0, change=3.0, file=1.0, worn_um=1.0
    )
    assert shown[0] * 1e3 == pytest.approx([1, 4, 7, 10, 1, 4, 0, 3])


def test_wear_is_not_in_what_a_mirror_shows():
    assert not tool_wear.shapes(state(np.full(20, 1500.0), gauged=0.0), "X")
    assert tool_wear.shapes(state(np.full(20, 1500.0)), "X")


def test_a_tool_only_loses():
    sensible = {"rate_um": 5.0, "start_um": 1.0, "worn_um": 2.0, "life": 8.0}
    assert tool_wear.sensible(**sensible)
    assert not tool_wear.sensible(**sensible | {"worn_um": -2.0})
    assert not tool_wear.sensible(**sensible | {"start_um": -4.0})
    assert not tool_wear.sensible(**sensible | {"start_um": 9.0})


@pytest.mark.parametrize(
    "shape", [{"life": 7.0, "older": 1.0}, {"life": 7.0, "older": 0.0}, {"life": 0.0}]
)
def test_wear_names_its_coefficients_and_takes_them_back(shape):
    shape = {
        "change": 0.0,
        "bores": 1.0,
        "older": 0.0,
        "cut": 0.0,
        "every": 0.0,
        "file": -1.0,
    } | shape
    values = np.array([3.0, 1.0, 2.0][: 3 if shape["older"] else 2])
    back, same = tool_wear.coefficients(**tool_wear.parameters(values, shape))
    assert np.array_equal(back, values) and same == shape


def test_parts_that_were_turned_drift_from_part_to_part():
    part = np.array([0.0, 1.0, 2.0, 3.0, 1.0, 3.0])
    channels = {
        "part": part,
        "wall": np.array([0, 1, 1, 1, -1, -1.0]),
        "material": np.array([0, 0, 0, 0, 1, 1.0]),
    }
    at = replace(
        state(np.zeros(6)), channels=channels, time=np.zeros(6), file=np.array([0, 1, 1, 1, 1, 1.0])
    )
    shown = structure_drift.columns(at, "X", tau_s=1e6, file=1.0)[0, 0] * 1e3
    # what lies between two walls keeps its size
    assert np.allclose(shown, [0.0, 0.0, 0.5, 1.0, 0.0, 0.0])


def test_a_step_may_be_in_every_pause():
    t = np.concatenate([start + 4.0 * np.arange(120) for start in (0.0, 1000.0, 3000.0)])
    readings = SimpleNamespace(
        state=SimpleNamespace(passage=np.full(len(t), -1), time=t), sees=np.full(len(t), "laser"),
        signal=np.zeros(len(t), int), residual=np.where(t > 1234.0, 5e-3, 0.0),
    )  # fmt: skip
    gaps = np.array(library._steps(readings))
    assert len(gaps) <= library.MOST_STEPS + 2
    assert np.any((gaps > 1232) & (gaps < 1236))  # and where readings differ most
    assert np.any((gaps > 480) & (gaps < 1000)) and np.any((gaps > 1480) & (gaps < 3000))


def test_a_spindle_of_which_nobody_says_that_it_turned_stood_still():
    told = np.array([1500.0, np.nan, np.nan, 750.0])
    at = replace(
        state(np.zeros(4)), channels={"spindle_rpm": told, "part": told, "force_X_N": told}
    )
    assert (
        assembly._filled("spindle_rpm", at).tolist()
        == assembly._filled("part", at).tolist()
        == [1500.0, 0.0, 0.0, 750.0]
    )
    assert assembly._filled("force_X_N", at).tolist() == [1500.0, 1125.0, 1125.0, 750.0]


def test_a_slip_at_the_end_of_a_passage_is_seen_by_another_run():
    place = np.arange(10.0)
    other = 1e-3 * np.sin(place)
    value = other + 0.02  # another zero
    value[1] += 0.04
    times, size = outliers.at_ends(place, value, other, np.full(10, 1e-3))
    assert times[1] > 20 and np.isclose(size[1], 0.04, atol=2e-3)
    assert (np.delete(times, 1) < 2).all()
    assert not outliers.at_ends(place, value, np.full(10, np.nan), np.full(10, 1e-3))[0].any()
