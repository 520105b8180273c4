"""A slide that sticks and slips, written out by hand: it stands until the drive pulls by as much as
holds it, which differs from time to time, and jumps by twice what that is above what it slides
with."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.diagnose import creep
from postproc.effects import State, deviation, load
from tests.diagnose.test_strangers_forms import names
from tests.diagnose.test_workshop import HEAD, diagnosed

RATE, SECONDS = 300.0, 12.0  # Hz, s of a stroke
FEEDS = (0.05, 0.08, 4.0)  # mm/s


def creeping(feeds: tuple[float, ...] = FEEDS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """s, mm, mm/s of strokes one after the other, all of one direction, with rests between."""
    speed = np.concatenate([np.r_[np.full(int(SECONDS * RATE), f), np.zeros(100)] for f in feeds])
    return np.arange(len(speed)) / RATE, 150.0 + np.cumsum(speed) / RATE, speed


def stuck(place: np.ndarray, slides_um: float, holds_um: float, scatter: float) -> np.ndarray:
    """(N,) um by which it lags, of a drive that follows its own motor and slides evenly above
    1 mm/s."""
    rng = np.random.default_rng(8)
    at = place[0] * 1e3 - slides_um
    limit, result = holds_um, []
    for p, step in zip(place * 1e3, np.diff(place, prepend=place[0]) * RATE, strict=True):
        if step > 1.0:
            at = max(at, p - slides_um)
        elif p - at > limit:
            at = p - (2 * slides_um - limit)
            limit = holds_um * (1 + scatter * rng.standard_normal())
        result.append(p - at)
    return np.array(result)


def scale(lag_um: np.ndarray, t: np.ndarray, place: np.ndarray, noise_um: float = 0.15) -> str:
    rng = np.random.default_rng(9)
    off = -lag_um + noise_um * rng.standard_normal(len(t))
    rows = [f"1,{s:.3f},{c:.5f},{c + d * 1e-3:.6f}" for s, c, d in zip(t, place, off, strict=True)]
    head = HEAD.format("trace", "scale") + '# sees = "scale"\n'
    return head + "run,t_s,X_cmd_mm,X_act_mm\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize("holds_um", [5.5, 7.0])
def test_cycles_that_differ_are_stick_slip(tmp_path, holds_um):
    """4 um while it slides; none of its cycles is as long as the one before, and it never turns
    back."""
    t, place, _ = creeping()
    answer = diagnosed(tmp_path, scale(stuck(place, 4.0, holds_um, 0.05), t, place))
    assert names(answer) == ["stick_slip:X"] and answer["unknown"] is None
    value = {k: p["value"] for k, p in answer["effects"][0]["parameters"].items()}
    assert value["size_um"] == pytest.approx(2 * (holds_um - 4.0), rel=0.1)
    assert value["period_mm"] == pytest.approx(2e-3 * (holds_um - 4.0), rel=0.1)
    assert abs(value["mean_um"]) < 0.5 and value["fastest_mm_s"] < 4.0


def test_an_oscillation_at_creep_does_not_stick(tmp_path):
    """4 um from crest to crest over the same ways as a tooth: it falls as slowly as it rises."""
    t, place, speed = creeping()
    oscillation = 2.0 * np.sin(2 * np.pi * 23.0 * t + 3.0 * np.sin(2 * np.pi * 0.05 * t))
    assert creep.of(place, oscillation * 1e-3, speed, np.ones(len(t))) is None
    assert "stick_slip:X" not in names(diagnosed(tmp_path, scale(oscillation, t, place)))


def test_what_lags_by_more_than_its_way_does_not_stand():
    """Teeth of 6 um over 2 um each, and of 1 um over 10 um each."""
    t, place, speed = creeping((0.1,))
    gone = (place - place[0]) * 1e3
    for size, way in ((6.0, 2.0), (1.0, 10.0)):
        lag = size * ((gone / way) % 1.0)
        assert creep.of(place, lag * 1e-3, speed, np.ones(len(t))) is None


def test_slips_by_hand():
    """Let go at 2, 4.5, 6.5 um and so on, of steps of 0.1 um; it stays as it stopped."""
    ends = np.cumsum(np.resize([2.0, 2.5], 30))
    gone = np.r_[np.arange(0.0, ends[-1] + 1.0, 0.1)]
    lag = gone - np.r_[0.0, ends][np.searchsorted(ends, gone, side="right")]
    place, lag = np.r_[gone, np.full(50, gone[-1])] * 1e-3, np.r_[lag, np.full(50, lag[-1])] * 1e-3
    found = creep.of(place, lag, np.gradient(place) * 1e3, np.ones(len(place)))
    assert found is not None
    assert found.ways.mean() == pytest.approx(2.25e-3, rel=0.06)
    assert found.scatter == pytest.approx(0.11, abs=0.02)
    assert np.abs(found.since - lag)[100:].max() < 0.15e-3 + 2.5e-3 / 2
    assert np.median(np.abs(found.since - lag)[100:]) < 0.02e-3
    assert (found.since[-50:] == found.since[-51]).all()
    # 30 ends, each among as many samples as lie within four standard deviations
    assert found.chosen_from >= 2 ** (len(found.ways))


def test_cycles_are_drawn_where_none_were_seen():
    """2 um of lag at most, over ways that differ by a fifth; nothing above 1 mm/s."""
    way = np.linspace(0.0, 10.0, 20001)
    state = State(
        {"X": way},
        {"X": np.ones(len(way))},
        {"X": (0.0, 100.0)},
        velocity={"X": np.full(len(way), 0.5)},
        distance={"X": way},
    )
    named = {"period_mm": 0.05, "size_um": 4.0, "fastest_mm_s": 1.0, "scatter": 0.2}
    lag = -deviation(load("stick_slip"), state, "X", **named)[0] * 1e3
    drops = np.flatnonzero(np.diff(lag) < -0.5)
    assert np.diff(way[drops]).mean() == pytest.approx(0.05, rel=0.05)
    assert np.diff(way[drops]).std() == pytest.approx(0.01, rel=0.2)
    assert lag[np.isfinite(lag)].mean() == pytest.approx(0.0, abs=0.15)
    state.velocity["X"][:] = 2.0
    assert not deviation(load("stick_slip"), state, "X", **named).any()


def test_what_lags_by_a_part_of_its_way_slips_too():
    """Teeth of 3 um over 20 um each: what is read lies behind a belt that gives."""
    t, place, speed = creeping((0.2,))
    lag = 3.0 * (((place - place[0]) * 1e3 / 20.0) % 1.0)
    found = creep.of(place, lag * 1e-3, speed, np.ones(len(t)))
    assert found is not None and found.ways * 1e3 == pytest.approx(19.3, abs=0.7)


@pytest.mark.parametrize("scatter, found", [(0.0, False), (0.2, True), (1.0, False)])
def test_a_slide_that_creeps_on_while_it_is_held(scatter, found):
    """Teeth of 4 um over 200 um: of one length they are a wave, of any length noise."""
    t, place, speed = creeping((2.0,))
    rng, gone = np.random.default_rng(2), (place - place[0]) * 1e3
    ways = 200.0 * np.maximum(1 + scatter * rng.standard_normal(400), 0.05)
    ends = np.r_[0.0, np.cumsum(ways)]
    k = np.searchsorted(ends, gone, side="right") - 1
    lag = 4.0 * (gone - ends[k]) / ways[k] + 0.05 * rng.standard_normal(len(t))
    slips = creep.of(place, lag * 1e-3, speed, np.ones(len(t)))
    assert (slips is not None) == found
    if slips is not None:
        assert slips.ways.mean() * 1e3 == pytest.approx(200.0, rel=0.08)
        assert slips.scatter == pytest.approx(0.2, abs=0.06)
