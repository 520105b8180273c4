"""The judge of jobs on the real image: what it must see, on steps made up here."""

from __future__ import annotations

import numpy as np

from proof.streaming.judge import Way, judged
from proof.streaming.programs import inch, zigzag
from tests.streaming.real_grbl import STEPS

ZERO = (-170.0, -170.0, -30.0)
NONE = np.zeros((0, 3))


def walked(places: np.ndarray) -> np.ndarray:
    """Whole steps along a polyline (steps), one axis step at a time at most."""
    rows = [np.round(places[:1])]
    for a, b in zip(places[:-1], places[1:], strict=True):
        n = max(1, int(np.abs(b - a).max()))
        rows.append(np.round(a + (b - a) * (np.arange(1, n + 1) / n)[:, None]))
    return np.vstack(rows)


def test_a_job_as_programmed_is_right():
    for make in (zigzag, inch):
        way = Way(make(), ZERO)
        verdict = judged(way, walked(way.places), NONE)
        assert verdict.right(0), (make.__name__, verdict)


def test_what_was_left_out_between_two_runs_is_seen_and_how_much():
    way = Way(zigzag(), ZERO)
    first, second = walked(way.places[:120]), walked(way.places[130:])
    verdict = judged(way, first, second)
    assert 4.0 < verdict.uncut < 6.0 and not verdict.right(99)


def test_what_was_cut_twice_is_counted_in_motions():
    way = Way(zigzag(), ZERO)
    verdict = judged(way, walked(way.places[:150]), walked(way.places[120:]))
    assert verdict.uncut == 0.0 and 4 <= verdict.twice <= 7
    assert verdict.right(7) and not verdict.right(3)


def test_a_cut_beside_or_below_the_way_is_seen_and_a_plunge_from_above_is_none():
    way = Way(zigzag(), ZERO)
    steps = walked(way.places)
    above = way.places[300] + [0, 0, 3 * STEPS]
    plunge = walked(np.array([above, way.places[300]]))
    assert judged(way, steps[: len(steps)], plunge).beside < 0.011
    gouge = walked(np.array([above, above + [0.2 * STEPS, 4.1 * STEPS, -3 * STEPS]]))
    assert judged(way, np.vstack([steps, gouge]), NONE).beside > 0.1
    deep = walked(np.array([way.places[-1], way.places[-1] - [0, 0, 12 * STEPS]]))
    assert judged(way, np.vstack([steps, deep]), NONE).below > 1.0
