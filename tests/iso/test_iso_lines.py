"""Reference lines, straightness and squareness, ISO 230-1."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iso_made import UM, along, runs_of

from postproc.iso import Options, choose, straightness
from postproc.iso.lines import LINES, reference, straightness_error
from postproc.iso.minimax import minimax
from postproc.iso.positioning import evaluate
from postproc.units import URAD

X = np.array([0.0, 100, 200, 300, 400])


def test_lines_by_hand():
    y = np.array([0, 3, 1, 3, 4.0])
    # end-point: slope 4/400 = 0.01; deviations 0 2 -1 0 0: error 3.
    line = reference("end-point", X, y)
    assert line.slope == pytest.approx(0.01) and straightness_error(
        "end-point", X, y
    ) == pytest.approx(3)
    # least squares: mean 2.2, sum (x-200) y = (0*-200 + 3*-100 + 3*100 + 4*200) = 800, / 100000 =
    # 0.008; line 0.6 1.4 2.2 3.0 3.8; deviations -0.6 1.6 -1.2 0 0.2: error 2.8.
    line = reference("least-squares", X, y)
    assert (line.slope, float(line.value(200.0))) == pytest.approx((0.008, 2.2))
    assert straightness_error("least-squares", X, y) == pytest.approx(2.8)
    # minimum zone: parallel to the chord 0 (0,0) - 200 (200,1), slope 0.005: y - 0.005 x = 0 2.5 0
    # 1.5 2: width 2.5; parallel to 100 (100,3) - 400 (400,4), slope 1/300: 0 2.667 0.333 2 2.667:
    # 2.667. The first is the narrower.
    line = reference("minimum-zone", X, y)
    assert line.slope == pytest.approx(0.005) and straightness_error(
        "minimum-zone", X, y
    ) == pytest.approx(2.5)
    assert float(line.value(0.0)) == pytest.approx(1.25)


def brute_line(x, y):
    """Width of the narrowest zone: one edge goes through two points."""
    pairs = [(i, j) for i, j in itertools.combinations(range(len(x)), 2) if x[i] != x[j]]
    return min(np.ptp(y - (y[j] - y[i]) / (x[j] - x[i]) * x) for i, j in pairs)


points = st.integers(0, 2**32 - 1)


@settings(max_examples=150, deadline=None)
@given(points)
def test_minimum_zone_line_against_every_pair(seed):
    generator = np.random.default_rng(seed)
    m = int(generator.integers(2, 12))
    x = np.sort(generator.choice(500, m, replace=False)).astype(float)
    # few digits: points that coincide and tie
    y = np.round(generator.normal(size=m), int(generator.integers(0, 4)))
    assert straightness_error("minimum-zone", x, y) == pytest.approx(brute_line(x, y), abs=1e-11)


@settings(max_examples=100, deadline=None)
@given(points)
def test_no_line_has_a_narrower_zone_and_tilt_plays_no_part(seed):
    generator = np.random.default_rng(seed)
    x, y = np.sort(generator.uniform(0, 500, 9)), generator.normal(size=9)
    zone = {kind: straightness_error(kind, x, y) for kind in LINES}
    assert zone["minimum-zone"] <= min(zone["least-squares"], zone["end-point"]) + 1e-12
    for kind in LINES:
        assert straightness_error(kind, x, y + 3 + 0.02 * x) == pytest.approx(zone[kind], abs=1e-11)
        assert straightness_error(kind, x, -2 * y) == pytest.approx(2 * zone[kind])
        assert reference(kind, x, y + 3 + 0.02 * x).slope == pytest.approx(
            reference(kind, x, y).slope + 0.02
        )


def test_least_squares_need_not_be_narrower_than_the_end_points():
    # y = 0 0 0 1 0: end-point line level, zone 1. Least squares: slope 0.1 a step, level 0.2 in the
    # middle: deviations 0 -0.1 -0.2 0.7 -0.4, zone 1.1.
    y = np.array([0, 0, 0, 1, 0.0])
    assert straightness_error("end-point", X, y) == pytest.approx(1)
    assert straightness_error("least-squares", X, y) == pytest.approx(1.1)


@settings(max_examples=60, deadline=None)
@given(points)
def test_minimax_leaves_the_largest_residual_at_both_signs(seed):
    """Chebyshev's mark of the best fit with 3 coefficients: 4 points where the residual is largest,
    or a tie of fewer."""
    generator = np.random.default_rng(seed)
    angle, y = generator.uniform(0, 2 * np.pi, 40), generator.normal(size=40)
    basis = np.column_stack([np.ones(40), np.cos(angle), np.sin(angle)])
    coefficients, h = minimax(basis, y)
    left = y - basis @ coefficients
    assert np.abs(left).max() == pytest.approx(h)
    edge = np.abs(np.abs(left) - h) < 1e-9
    assert edge.sum() >= 4 and len(set(np.sign(left[edge]))) == 2
    for _ in range(20):
        other = coefficients + generator.normal(size=3) * 0.05
        assert np.abs(y - basis @ other).max() > h - 1e-12


def test_minimax_with_points_that_coincide():
    # Two values at each of three angles: the largest gap of a pair, halved, can not be beaten.
    angle = np.repeat(np.radians([0, 120, 240]), 2)
    y = np.array([0, 1, 5, 5.2, -3, -3.4])
    basis = np.column_stack([np.ones(6), np.cos(angle), np.sin(angle)])
    assert minimax(basis, y)[1] == pytest.approx(0.5)
    with pytest.raises(ValueError):
        minimax(basis[:2], y[:2])
    with pytest.raises(ValueError):
        minimax(basis[[0, 1, 0, 1]], y[:4])


def test_straightness_of_each_direction_about_its_own_line():
    # + bows by 2, - lies 3 lower, bows by -2 and is tilted by 10 urad: the mean of both is straight
    # (end points).
    up = np.array([0, 2.0, 0])
    down = np.array([-3, -5.0, -3]) + np.array([0, 1.0, 2.0])
    test = evaluate(*runs_of(np.array([0.0, 100, 200]), np.stack([up, down]) * UM))
    found = straightness.evaluate("end-point", test)
    assert {n: v / UM for n, v in found.errors.items()} == pytest.approx(
        {"straightness": 0, "straightness +": 2, "straightness -": 2}
    )
    assert found.lines["straightness -"].slope == pytest.approx(10 * URAD)
    one_way = straightness.evaluate(
        "end-point", evaluate(*(c[:3] for c in runs_of(X[:3], np.stack([up, down]))))
    )
    assert one_way.errors["straightness"] is None and one_way.best == "straightness +"


def two_runs(first, second, lean_first, lean_second, sign=1.0):
    """Straightness of both axes of a pair, in um, on one square; leans in urad: deviation per
    motion."""
    x = np.arange(0, 401, 50.0)
    one = along(first, x, np.tile(lean_first * x * 1e-3, (2, 1)), {second: 1.0}, "straightness")
    two = along(
        second, x, np.tile(sign * lean_second * x * 1e-3, (2, 1)), {first: sign}, "straightness"
    )
    return one, two


@pytest.mark.parametrize("kind", LINES)
@pytest.mark.parametrize(
    ("pair", "name", "expected"),
    [  # the second axis leans to - of the first by 30 urad: angle 90 degrees + 30 urad
        ("XY", "C0Y", +30), ("YZ", "A0Z", +30), ("XZ", "B0Z", -30),
    ],
)  # fmt: skip
def test_signs_of_squareness(kind, pair, name, expected):
    """C0Y = +S (Y leans to -X), A0Z = +S (Z leans to -Y), B0Z = -S; S > 0: the angle is larger than
    90 degrees."""
    for first, second, lean_first, lean_second in (
        (*pair, 0, -30),
        (*pair, -30, 0),
        (*pair, 10, -40),
        (*pair[::-1], -40, 10),
    ):
        found, _ = choose.results(
            two_runs(first, second, lean_first, lean_second), Options(line=kind)
        )
        square = found[-1]
        assert (square.test, square.subject) == ("squareness", name)
        assert square[name].value == pytest.approx(expected * URAD, abs=1e-12)


def test_squareness_is_the_turn_of_the_second_axis():
    """A0Z, B0Z and C0Y are rotations: turning the second axis' direction by them about X, Y, Z
    makes it lean so."""
    axis = {"X": 0, "Y": 1, "Z": 2}
    for pair, name in (("XY", "C0Y"), ("YZ", "A0Z"), ("XZ", "B0Z")):
        turn = np.zeros(3)
        turn["ABC".index(name[0])] = 1e-5
        direction = np.eye(3)[axis[pair[1]]]
        leans = float(np.cross(turn, direction)[axis[pair[0]]])
        assert straightness.squareness(*pair, 0.0, leans) == (name, pytest.approx(1e-5))


def test_a_reading_towards_minus_counts_the_other_way():
    plain, _ = choose.results(two_runs("X", "Y", 5, -25), Options())
    turned, _ = choose.results(two_runs("X", "Y", 5, -25, sign=-1.0), Options())
    assert (
        turned[-1]["C0Y"].value == pytest.approx(plain[-1]["C0Y"].value) == pytest.approx(20 * URAD)
    )
    assert any("their sign is turned" in n for n in turned[1].notices)


@pytest.mark.parametrize("count", [2, 3, 5, 12])
def test_the_narrowest_parallels_of_many_rows_are_those_of_every_pair(count):
    """By trying the slopes of all pairs, as `test_minimum_zone_line_against_every_pair` does; with
    readings that are equal, and on a line that rises by 3."""
    rng = np.random.default_rng(count)
    x = np.sort(rng.uniform(0, 1000, count))
    y = np.concatenate([rng.normal(0, 1, (50, count)), rng.integers(0, 2, (50, count))])
    y = np.concatenate([y, 1e-4 * y + 3 * x])
    zone, slope = straightness._narrowest(x, y)
    slopes = [
        (y[:, k] - y[:, i]) / (x[k] - x[i]) for i, k in itertools.combinations(range(count), 2)
    ]
    least = np.min([np.ptp(y - s[:, None] * x, axis=1) for s in slopes], axis=0)
    assert zone == pytest.approx(least, abs=1e-11)
    assert np.ptp(y - slope[:, None] * x, axis=1) == pytest.approx(zone, abs=1e-11)


def test_the_narrowest_parallels_of_many_targets_take_no_pairs():
    """2000 targets have two million pairs; the zone of 1000 draws is found in a second."""
    x = np.arange(2000.0)
    y = np.random.default_rng(1).normal(0, 1, (1000, 2000))
    zone, _ = straightness._narrowest(x, y)
    assert zone[0] == pytest.approx(straightness_error("minimum-zone", x, y[0]), rel=1e-9)
