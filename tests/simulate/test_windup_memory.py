"""Windup remembers more than its last turn: a drive of plays, and Masing's rules."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from postproc import effects
from postproc.effects import State, windup

LENGTH = 0.8
MANY = 4000  # plays that stand for all


def through(turns: list[float], step: float = 0.003) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (N,), which of them a turn lies before (T,), and where it lies (T,): from turn to turn
    in small steps."""
    parts = [np.arange(a, b, np.sign(b - a) * step) for a, b in zip(turns, turns[1:], strict=False)]
    begin = np.cumsum([len(p) for p in parts])[:-1]
    return np.concatenate(parts), begin, np.array(turns[1:-1])


def state(turns: list[float]) -> State:
    place, begin, at = through(turns)
    first = float(np.sign(turns[1] - turns[0]))
    ways = effects.reversal_memory(place, first, begin, at)
    side = np.full(len(place), first)
    distance = np.full(len(place), 1e6)
    for k, (a, turn) in enumerate(zip(begin, at, strict=True)):
        side[a:] = first * (-1.0) ** (k + 1)
        distance[a:] = np.abs(place[a:] - turn)
    return State(
        {"X": place}, {"X": side}, {"X": (-50.0, 50.0)}, distance={"X": distance}, path={"X": ways}
    )  # fmt: skip


def shown(at: State) -> np.ndarray:
    """um of 1 um of windup."""
    return windup.columns(at, "X", LENGTH)[0, 0] * 1e3


def of_plays(turns: list[float], r: np.ndarray | None = None) -> np.ndarray:
    """The same of very many stops, one sample after the other: thresholds r as frequent as exp(-2 r
    / length), pressed home at first."""
    share = (np.arange(MANY) + 0.5) / MANY
    r = -LENGTH / 2 * np.log1p(-share) if r is None else r
    first = np.sign(turns[1] - turns[0])
    place, begin, at = through(turns)
    place = np.insert(place, begin, at)
    held, last, found = first * r, place[0], []
    for x in place:
        held = np.clip(held + x - last, -r, r)
        last = x
        found.append(-held.mean() / LENGTH)
    # The density of stops is (2 / L) exp(-2 r / L) times 1 / L in what each adds, and they reach L
    # / 2 in the mean.
    return np.delete(np.array(found), begin + np.arange(len(begin)))


def test_after_a_long_way_and_one_turn_it_is_dahl():
    at = state([-20.0, 20.0, -20.0])
    assert shown(at) == pytest.approx(shown(replace(at, path={})), abs=1e-12)


TURNS = [
    [-9.0, 0.0, -1.0, 0.5],
    [-9.0, 0.0, -1.0, -0.3, -0.8, 3.0, -5.0],
    [9.0, 0.0, 2.0, 0.3, 1.5, 0.5, 1.2, 0.7],
]


@pytest.mark.parametrize("turns", TURNS)
def test_it_is_a_drive_of_plays(turns):
    assert shown(state(turns)) == pytest.approx(of_plays(turns), abs=2e-3)


@pytest.mark.parametrize("turns", TURNS)
def test_of_one_play_alone_it_builds_up_in_proportion_and_lets_go_at_once(turns):
    at = state(turns)
    one = windup.columns(at, "X", LENGTH, spread=-1.0)[0, 0] * 1e3
    assert one == pytest.approx(of_plays(turns, np.array([LENGTH / 2])), abs=1e-9)
    last = windup.columns(replace(at, path={}), "X", LENGTH, spread=-1.0)[0, 0] * 1e3
    long = at.distance["X"] > LENGTH
    assert last[long] == pytest.approx(-at.approach["X"][long] / 2)


def test_a_small_loop_closes_and_is_forgotten():
    """Masing: back and forth by less than before ends where it began, and from there on nothing of
    it is left."""
    with_loop, without = state([-20.0, 0.0, -1.0, -0.4, -3.0]), state([-20.0, 0.0, -3.0])
    a, b = shown(with_loop), shown(without)
    behind = with_loop.position["X"] < -1.0
    plain = without.position["X"] < -1.0
    assert np.interp(-2.0, with_loop.position["X"][behind][::-1], a[behind][::-1]) == pytest.approx(
        np.interp(-2.0, without.position["X"][plain][::-1], b[plain][::-1]), abs=1e-4
    )
    assert not with_loop.path["X"][2:, np.flatnonzero(behind)[-1]].any()


def test_a_branch_is_the_first_branch_at_twice_the_size():
    """Masing: every branch adds size * (1 - exp(-way / length)) to where it begins."""
    at = state([-20.0, 0.0, -0.6, -0.2])
    value, back = shown(at), np.flatnonzero(at.approach["X"] > 0)
    last = back[at.position["X"][back] > -0.6 - 1e-9][-100:]
    begin = -(-0.5 + 1 - np.exp(-0.6 / LENGTH)) * -1
    assert value[last] == pytest.approx(
        begin - (1 - np.exp(-(at.position["X"][last] + 0.6) / LENGTH)), abs=1e-9
    )


def test_the_last_turn_alone_is_wrong_by_much_after_a_short_way():
    at = state([-20.0, 0.0, -0.2, 0.5])
    assert np.abs(shown(at) - shown(replace(at, path={}))).max() > 0.3


def test_no_more_is_remembered_than_there_is_room_for():
    """A spiral of forty turns: what is left out changes little."""
    turns = [-20.0, *(2.0 * (-1.0) ** k * 0.93**k for k in range(40))]
    at = state(turns)
    assert len(at.path["X"]) <= effects.DEEPEST + 1
    assert shown(at) == pytest.approx(of_plays(turns), abs=0.02)


def test_many_turns_take_no_time():
    place = np.tile(np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0, 50)]), 1000)
    begun = time.process_time()
    ways = effects.reversal_memory(
        place, 1.0, np.arange(50, len(place), 50), np.resize([1.0, 0.0], len(place) // 50 - 1)
    )
    assert time.process_time() - begun < 1.0 and len(ways) <= 3
