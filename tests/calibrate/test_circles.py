"""Squareness and lost motion from a ballbar: by the equation's own numbers, by machines that are
known, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

from postproc.calibrate import CalibrationError, Options, circles, square
from postproc.calibrate.run import calibrate
from postproc.machine.chain import XYZ, parse
from postproc.recordings import Recording
from tests.calibrate.test_places import CHAINS, SQUARE, UM, URAD, measured, truth

CENTRE = {"X": 250.0, "Y": 200.0, "Z": -150.0}
RADIUS = 100.0
TURN = (np.arange(360) + 0.5) * np.pi / 180  # no sample where an axis turns round


def circle(plane: str, radial, rng=None, noise=0.0, senses=(1, -1), runs=1, turn=TURN) -> Recording:
    """radial(angle, sense, place) -> mm, of both senses by turns."""
    parts = []
    for k in range(runs * len(senses)):
        sense = senses[k % len(senses)]
        t = sense * turn
        place = {x: np.full(len(t), CENTRE[x]) for x in XYZ}
        place[plane[0]] = CENTRE[plane[0]] + RADIUS * np.cos(t)
        place[plane[1]] = CENTRE[plane[1]] + RADIUS * np.sin(t)
        reading = radial(t, sense, place) / UM + (rng.normal(0, noise, len(t)) if rng else 0.0)
        parts.append(
            {
                "run": np.full(len(t), k + 1.0),
                "t_s": 10.0 * k + np.arange(len(t)) / 100,
                "radial_um": reading,
                "sense": np.full(len(t), 1.0 * sense),
            }
            | {f"{x}_cmd_mm": v for x, v in place.items()}
        )
    columns = {n: np.concatenate([p[n] for p in parts]) for n in parts[0]}
    head = {"centre": {x: CENTRE[x] for x in plane}, "radius_mm": RADIUS, "feed_mm_min": 1000.0}
    return Recording("ballbar", head, columns, f"{plane}.csv", np.arange(len(columns["run"])))


def equation(g, scale, play, lag, centre=(0.0, 0.0), zero=0.0):
    """What the bar reads, written from the axes' own errors: a leans by g per mm of b, both have
    play, one follows later."""

    def radial(t, sense, place):
        ways = -sense * np.sin(t), sense * np.cos(t)
        first = (
            centre[0]
            + scale * RADIUS * np.cos(t)
            + g * RADIUS * np.sin(t)
            - play[0] / 2 * np.sign(ways[0])
        )
        second = centre[1] - play[1] / 2 * np.sign(ways[1])
        return first * np.cos(t) + second * np.sin(t) + zero + lag * sense * np.sin(2 * t)

    return radial


def test_each_number_of_the_equation_comes_back():
    one = circle("XY", equation(80e-6, -25e-6, (0.006, 0.002), 0.004, (0.005, -0.003), 0.007))
    found = circles.fit([one], [np.zeros(len(one))])
    assert found.square == approx(80e-6, abs=1e-9) and found.scale == approx(-25e-6, abs=1e-9)
    assert found.play == approx((0.006, 0.002), abs=1e-7) and found.rms < 1e-7


def test_the_intervals_hold():
    """100 circles with 0.5 um of scatter: at least 93 % of squareness, scale and both lost motions
    within 2 u."""
    rng = np.random.default_rng(7)
    inside = []
    for _ in range(100):
        g, scale, lag = rng.normal(0, 1e-4), rng.normal(0, 3e-5), rng.normal(0, 3e-3)
        play, centre, zero = rng.uniform(0, 1e-2, 2), rng.normal(0, 5e-3, 2), rng.normal(0, 5e-3)
        one = circle("XY", equation(g, scale, play, lag, centre, zero), rng, 0.5)
        found = circles.fit([one], [np.zeros(len(one))])
        off = np.array(
            [
                found.square - g,
                found.scale - scale,
                found.play[0] - play[0],
                found.play[1] - play[1],
            ]
        )
        u = [found.u[n] for n in ("square", "scale", "first play", "second play")]
        inside.append(np.abs(off) <= 2 * np.array(u))
    assert (np.mean(inside, axis=0) >= 0.93).all()


def by_machine(machine):
    """radial(t, sense, place) of a machine, along the plane of two axes."""

    def of(plane):
        def radial(t, sense, place):
            q = np.stack([place[x] for x in machine.letters])
            off = machine.deviation(q, np.zeros_like(q))
            rows = [machine.letters.index(x) for x in plane]
            return np.cos(t) * off[rows[0]] + np.sin(t) * off[rows[1]]

        return radial

    return of


@pytest.mark.parametrize("chain", CHAINS)
def test_circles_and_two_straightnesses_give_one_squareness(chain):
    """A machine of 18 components, measured at scattered places: circles anywhere say what a square
    says, for they are read beside the components. What parts them is the interpolation between 11
    targets."""
    machine = truth(np.random.default_rng(3), parse(chain))
    single = measured(machine, "scattered")
    round_ = [circle(p, by_machine(machine)(p)) for p in ("XY", "YZ", "XZ")]
    options = Options(parse(chain), keep_all=True, square_error=(0.0, 1e-9))
    by_square = calibrate(single, options).squareness
    bare = [replace(r, head=r.head | {"reference": ""}) for r in single]
    found = calibrate(bare + round_, options)
    assert set(found.squareness) == set(SQUARE)
    for name in SQUARE:
        one = found.squareness[name]
        assert one.source.startswith("ballbar")
        assert abs(one.value - by_square[name].value) < 4 * URAD + 2 * one.u, name
    told = [f for f in found.findings if f.check == "ballbar"]
    assert len(told) == 9 and not [f for f in told if "play_um" in f.numbers and f.level == "doubt"]


@pytest.mark.parametrize("name", square.NAMES)
def test_every_name_has_its_sign(name):
    """An axis that leans by 120 urad alone, as Machine has it (chain.leans): found under the same
    name."""
    chain = parse("w-b-X-Y-Z-t")
    machine = truth(np.random.default_rng(1), chain)
    axes = {
        x: replace(
            a, table=replace(a.table, forward=0 * a.table.forward, reverse=0 * a.table.reverse)
        )
        for x, a in machine.axes.items()
    }
    lean = np.zeros(3)
    lean["ABC".index(name[0])] = 120 * URAD
    machine = replace(machine, axes=axes, square={name[2]: lean})
    plane = square.pair_of(name)
    options = Options(chain, keep_all=True, squareness={name: "ballbar"})
    found = calibrate(
        [*measured(machine, "zero"), circle(plane, by_machine(machine)(plane))], options
    )
    assert found.squareness[name].value == approx(120 * URAD, abs=0.5 * URAD)


@pytest.mark.parametrize(
    "one, says",
    [
        (circle("XY", equation(0, 0, (0, 0), 0), senses=(1,)), "turn one way only"),
        (circle("XY", equation(0, 0, (0, 0), 0), turn=TURN[:150]), "no full turns"),
        (
            replace(
                circle("XY", equation(0, 0, (0, 0), 0)),
                head={"centre": {"X": 0.0}, "radius_mm": 1.0},
            ),
            "names no two linear",
        ),
        (
            replace(
                circle("XY", equation(0, 0, (0, 0), 0)),
                head={"centre": CENTRE | {}, "radius_mm": 1.0},
            ),
            "names no two linear",
        ),
        (
            replace(
                circle("XY", equation(0, 0, (0, 0), 0)),
                head={"centre": {"X": 0.0, "Y": 0.0}, "radius_mm": 1.0},
            ),
            "samples lie on",
        ),
    ],
)
def test_what_is_no_circle_in_both_senses_is_refused(one, says):
    machine = truth(np.random.default_rng(1), parse(CHAINS[0]))
    with pytest.raises(CalibrationError, match=says):
        calibrate([*measured(machine, "zero"), one], Options(parse(CHAINS[0]), keep_all=True))


def test_a_plane_that_the_machine_has_not_is_refused():
    machine = truth(np.random.default_rng(1), parse(CHAINS[0]))
    only = [r for r in measured(machine, "zero") if r.file[:3] in ("EXX", "EZX", "EZZ", "EXZ")]
    with pytest.raises(CalibrationError, match="a circle of XY, and the chain has Z X"):
        calibrate(
            [*only, circle("XY", equation(0, 0, (0, 0), 0))],
            Options(parse("w-b-Z-X-t"), keep_all=True),
        )


@pytest.mark.parametrize("plane", ["XY", "XZ"])
def test_the_way_round_is_told_by_the_samples_and_runs_may_have_no_number(plane):
    """Counter-clockwise in XZ may be told as it is seen from +Y, from Z to X: lost motion has its
    sign all the same. Without a column `run` the two senses are still two runs."""
    one = circle(plane, equation(80e-6, -25e-6, (0.006, 0.002), 0.004))
    from_behind = one.columns | {"sense": -one.columns["sense"]}
    without = {name: column for name, column in one.columns.items() if name != "run"}
    for columns in (from_behind, without):
        found = circles.fit([replace(one, columns=columns)], [np.zeros(len(one))])
        assert found.play == approx((0.006, 0.002), abs=1e-7)
        assert found.square == approx(80e-6, abs=1e-9)


def test_play_that_the_map_has_is_taken_off_whatever_the_senses_are_called():
    """6 um of lost motion of X in the components and on the circle: nothing is beyond the map."""
    machine = truth(np.random.default_rng(3), parse("w-X-Y-b-Z-t"))
    parts = measured(machine, "scattered")
    told = []
    for sign in (1.0, -1.0):
        one = circle("XY", equation(0.0, 0.0, (0.006, 0.0), 0.0))
        one.columns["sense"] = sign * one.columns["sense"]
        found = calibrate([*parts, one], Options(parse("w-X-Y-b-Z-t"), keep_all=True)).findings
        told.append([f.numbers["play_um"] for f in found if "play_um" in f.numbers])
    assert told[0] == approx(told[1]) and len(told[0]) == 2
