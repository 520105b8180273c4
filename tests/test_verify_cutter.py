"""How `--verify` measures the tool's centre inside G41 G42: which ways, at which places, and on
which side each axis then lies, on ways drawn by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.machine.tip import TipMachine
from postproc.nc.shifted import Way
from postproc.units import UM
from postproc.verify.cutter import CentreVerifier, Contour, _length, _points
from postproc.verify.largest import Largest


def straight(start, end, owner: int = 0, **of) -> Way:
    return Way(owner, np.array(start, float), np.array(end, float), (0, 1), **of)


def circle(sweep: float) -> Way:
    """A full one about (3, 4), from (13, 4)."""
    start = np.array([13.0, 4.0])
    return Way(0, start, start, (0, 1), (3.0, 4.0), sweep=sweep)


def sides(way: Way, approach, t, at_work=None, directed: bool = True):
    """Of each axis at t, and which side is kept behind the way."""
    contour = SimpleNamespace(approach=np.array(approach, float))
    judge = SimpleNamespace(at_work=at_work, directed=directed)
    found = CentreVerifier._approach(
        cast(Any, judge), cast(Any, contour), way, np.array(t, dtype=float)
    )
    return found.tolist(), contour.approach.tolist()


class Slides(TipMachine):
    """Slides that go as X of the tip, against twice Y, up and down about X = 5, away from X = 10,
    and by a millionth of X."""

    def __init__(self):
        pass

    def slides(self, point):
        x, y = point[:2]
        return np.array([x, -2 * y, (x - 5) ** 2, np.abs(x - 10), 1e-6 * x])


def test_an_axis_that_hardly_moves_keeps_its_side():
    """X goes back by 3 mm to a place above zero, Y on by 5 um (10 um say a side), Z rests."""
    way = straight([5.0, 3.0, 7.0], [2.0, 3.005, 7.0])
    found, kept = sides(way, [1.0, -1.0, 1.0], [0.0, 1.0])
    assert found == [[-1.0] * 2, [-1.0] * 2, [1.0] * 2]
    assert kept == [-1.0, -1.0, 1.0]
    assert sides(way, [0.0, 1.0, -1.0], [0.0, 1.0])[1] == [-1.0, 1.0, -1.0]


@pytest.mark.parametrize("sense", [1, -1])
def test_on_a_circle_every_quadrant_has_its_sides(sense):
    """Counter-clockwise from the right: X goes back, back, on, on; Y on, back, back, on. With the
    clock the other way round of the other half."""
    found, kept = sides(circle(sense * 2 * np.pi), [0.0, 0.0], [0.125, 0.375, 0.625, 0.875])
    x, y = ([-1, -1, 1, 1], [1, -1, -1, 1]) if sense > 0 else ([-1, -1, 1, 1], [-1, 1, 1, -1])
    assert found == [x, y]
    assert kept == [x[-1], y[-1]]


def test_without_sides_none_is_told_and_it_is_kept_all_the_same():
    found, kept = sides(straight([0.0, 0.0], [1.0, -1.0]), [0.0, 0.0], [0.5], directed=False)
    assert found == [[0.0], [0.0]]
    assert kept == [1.0, -1.0]


def test_where_the_tip_is_followed_the_slides_have_the_sides():
    """Along the way, and at its ends within it: behind X = 10 the fourth would turn. A slide that
    goes 5 nm over the whole way rests."""
    way = straight([0.0, 0.0, 0.0], [10.0, 5.0, 0.0])
    found, _ = sides(way, [0.0] * 3, [0.0, 0.1, 0.9, 1.0], Slides())
    assert found == [[1.0] * 4, [-1.0] * 4, [-1.0, -1.0, 1.0, 1.0], [-1.0] * 4, [0.0] * 4]
    assert sides(way, [0.0] * 3, [0.5], Slides(), directed=False)[0] == [[0.0]] * 5


def test_what_a_slide_of_a_tip_must_go_to_have_a_side():
    """20 um over the way say a side in its middle, 2 um do not (10 um, looked at within a
    ten-thousandth to both sides)."""
    for length, side in ((0.02, 1.0), (0.002, 0.0)):
        way = straight([0.0, 0.0, 0.0], [length, 0.0, 0.0])
        assert sides(way, [0.0] * 3, [0.5], Slides())[0][0] == [side], length


def measured(way: Way, near: list[Way], deviation) -> Largest:
    """What a machine with this deviation (A, K) of places (A, K) leaves of a way."""
    into = Largest()
    judge = SimpleNamespace(
        at_work=SimpleNamespace(deviation=lambda point, weight: deviation(point), corrected=(0, 1)),
        _approach=lambda contour, way, t: np.zeros((2, len(t))),
        lines={7: 12},
    )
    CentreVerifier._measure(cast(Any, judge), cast(Any, None), way, near, into)
    return into


def bump(place: float, half: float):
    """10 um along Y, within `half` mm of X = place."""
    return lambda point: np.array([0 * point[0], 0.01 * (np.abs(point[0] - place) < half)])


def test_a_way_is_looked_at_every_two_millimetres():
    """100 mm in 51 samples: a bump of 0.1 mm at X = 6 is met and one at X = 7 is not. 8 mm in
    five; a rapid at its end alone."""
    way = straight([0.0, 5.0], [100.0, 5.0], 7)
    found = measured(way, [way], bump(6.0, 0.05))
    assert found.deviation == pytest.approx(0.01, rel=1e-9) and found.line == 12
    assert measured(way, [way], bump(7.0, 0.05)).deviation < 1e-9
    assert measured(way, [way], bump(94.0, 0.05)).deviation == pytest.approx(0.01, rel=1e-9)
    short = straight([0.0, 0.0], [4.0, 0.0], 7)
    assert measured(short, [short], bump(1.0, 0.05)).deviation == pytest.approx(0.01, rel=1e-9)
    rapid = straight([0.0, 0.0], [100.0, 0.0], 7, rapid=True)
    assert measured(rapid, [rapid], bump(6.0, 0.05)).deviation == 0.0
    assert measured(rapid, [rapid], bump(100.0, 0.05)).deviation == pytest.approx(0.01)


def test_of_the_ways_beside_it_the_nearest_counts():
    """10 um beside its own way, and 4 um beside the next; without any nothing is measured."""
    way, beside = (straight([0.0, y], [10.0, y], 7) for y in (0.0, 0.006))
    off = bump(5.0, 9.0)
    assert measured(way, [way, beside], off).deviation == pytest.approx(0.004, rel=1e-9)
    assert measured(way, [way], off).deviation == pytest.approx(0.01, rel=1e-9)
    assert measured(way, [], off).deviation == 0.0


def test_each_way_is_measured_once_against_its_neighbours():
    """Of motions 0 to 5, before 4: not the first, which was; each beside one before and one behind
    it."""
    nominal = [straight([0.0, 0.0], [1.0, 0.0], owner) for owner in range(6)]
    contour = Contour(cast(Any, None), np.zeros(2), list(nominal))
    nominal[0].measured = True
    seen = []
    judge = SimpleNamespace(
        _measure=lambda contour, way, near, into: seen.append((way.owner, [w.owner for w in near]))
    )
    CentreVerifier._measure_until(cast(Any, judge), 4, contour, nominal, Largest())
    assert seen == [(1, [0, 1, 2]), (2, [1, 2, 3]), (3, [2, 3, 4])]


def test_a_way_by_hand():
    """A line of 3, 4, 5; a quarter about (3, 4) whose radius grows from 10 to 12 mm, at most 6 pi
    long."""
    line = straight([5.0, 0.0], [8.0, 4.0])
    assert _length(line) == pytest.approx(5.0)
    assert _points(line, np.array([0.5]))[:, 0] == pytest.approx([6.5, 2.0])
    grows = Way(
        0, np.array([9.0, 12.0]), np.array([-6.6, 11.2]), (0, 1), (3.0, 4.0), sweep=np.pi / 2
    )
    assert _length(grows) == pytest.approx(6 * np.pi)
    half = np.sqrt(0.5)
    assert _points(grows, np.array([0.0, 0.5, 1.0])).T == pytest.approx(
        np.array([[9, 12], [3 - 2.2 * half, 4 + 15.4 * half], [-6.6, 11.2]])
    )


def test_a_way_waits_until_its_neighbours_are_final():
    """Motion 7 still waits, so 6 is the last whose way is final, and 5 the last whose neighbours
    are: of both programs what lies before 6 is measured. Kept are the rest, and on the nominal path
    its neighbour and one more. When all is told nothing is measured twice."""
    judge = CentreVerifier(cast(Any, None), True)
    judge.count, seen = 6, []
    judge._measure = lambda contour, way, near, into: seen.append(  # type: ignore[method-assign]
        (contour is judge.run, way.owner, [w.owner for w in near])
    )
    for name in ("nominal", "run"):
        ways = [straight([0.0, 0.0], [1.0, 0.0], owner) for owner in range(3, 7)]
        waits = SimpleNamespace(queue=[SimpleNamespace(owner=7)], done=ways, flush=lambda: None)
        setattr(judge, name, Contour(cast(Any, waits), np.zeros(2)))
    nominal, run = judge.nominal, judge.run
    assert nominal is not None and run is not None
    judge._compare()
    beside = [(3, [3, 4]), (4, [3, 4, 5]), (5, [4, 5, 6])]
    assert seen == [(which, owner, near) for which in (True, False) for owner, near in beside]
    assert [w.owner for w in run.ways] == [6]
    assert [(w.owner, w.measured) for w in nominal.ways] == [(4, True), (5, True), (6, False)]
    seen.clear()
    judge.finish()
    assert seen == [(True, 6, [5, 6]), (False, 6, [5, 6])]
    assert judge.nominal is None and judge.run is None


def test_with_nothing_waiting_the_last_two_motions_still_wait():
    """The next batch may add a neighbour to the last way, and shift its end."""
    judge = CentreVerifier(cast(Any, None), True)
    judge.count, seen = 4, []
    judge._measure = lambda contour, way, near, into: seen.append(way.owner)  # type: ignore[method-assign]
    for name in ("nominal", "run"):
        ways = [straight([0.0, 0.0], [1.0, 0.0], owner) for owner in range(4)]
        waits = SimpleNamespace(queue=[], done=ways, flush=lambda: None)
        setattr(judge, name, Contour(cast(Any, waits), np.zeros(2)))
    judge._compare()
    assert seen == [0, 1, 2] * 2


@pytest.mark.parametrize(("deviation", "over"), [(0.9, False), (1.0, False), (1.1, True)])
def test_what_is_said_of_the_centre(deviation, over):
    judge = CentreVerifier(cast(Any, None), True)
    judge.corrected.take(deviation * UM, 3)
    judge.uncorrected.take(20 * UM, 5)
    said = judge.report(1.0 * UM)
    assert f"centre {deviation:.2f} um (line 3), uncorrected 20.00 um" in said
    assert ("more than the tolerance" in said) == over
