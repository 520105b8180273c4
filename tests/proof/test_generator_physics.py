"""The generator's physics against hand calculations."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from proof.generator import designs, machines, mechanics, oracle, physics
from proof.generator.physics import Scene
from proof.generator.physics.instrument import refractive
from proof.generator.readings import project
from proof.generator.streams import stream
from proof.generator.world import STEP, World, delayed


@pytest.fixture(scope="module")
def lathe() -> machines.Machine:
    for number in range(100):
        machine = machines.draw(stream("physics", number))
        if machine.form == "lathe":
            return replace(machine, errors=machines.errors_of(machine, stream("physics", "errors")))
    raise AssertionError("no lathe in a hundred machines")


def scene_of(machine, tracks) -> Scene:
    rng = stream("physics", "design")
    design = replace(designs.draw(rng, machine), tracks=tracks)
    return Scene(design, World(design, stream("physics", "room")))


def effect(name, scene, axis):
    return physics.names()[name](scene, axis, stream("physics", name))


def channels() -> dict[str, bool]:
    return dict.fromkeys(
        ("air", "screw", "bed", "force", "spindle", "feed", "current", "stated"), True
    )


def line(machine, axis="Z", **more):
    return designs.axis_line(
        stream("physics", "line"), machine, axis, axis, 0.0, channels(), **more
    )


def test_backlash_reads_half_its_size_to_either_side(lathe):
    track = line(lathe, both=True)
    scene = scene_of(lathe, [track])
    rows = project(lathe, track, effect("backlash", scene, "Z").on(track).times(9.0))[:, 0]
    going = track.direction[:, 2]
    assert rows[going > 0] == pytest.approx(-4.5) and rows[going < 0] == pytest.approx(4.5)


def test_scale_is_parts_per_million(lathe):
    track = line(lathe)
    scene = scene_of(lathe, [track])
    rows = project(lathe, track, effect("scale", scene, "Z").on(track).times(20.0))[:, 0]
    z = track.position[:, 2]
    assert np.polyfit(z, rows, 1)[0] == pytest.approx(20e-3)  # 20 ppm = 20 nm/mm


def test_lag_on_a_circle_is_half_of_lag_times_feed(lathe):
    """Radial part of -tau v along one axis: tau v / 2 sin 2 theta; 4000 mm/min and 0.1 ms: 3.33 um.
    The loop's own order takes off less than a tenth at this feed."""
    (track,) = designs.ballbars(stream("physics", "bar"), lathe, "XZ", [1, -1], [4000.0], 0.0)
    scene = scene_of(lathe, [track])
    rows = project(lathe, track, effect("servo_lag", scene, "X").on(track).times(0.1))
    assert oracle.peak([track], [rows]) == pytest.approx(0.1 * 4000 / 60 / 2, rel=0.1)
    theta = np.arctan2(
        track.position[:, 2] - track.head["centre"]["Z"],
        track.position[:, 0] - track.head["centre"]["X"],
    )
    even = [
        (rows[track.sense == d, 0] * np.sin(2 * theta[track.sense == d])).mean() for d in (1, -1)
    ]
    # changes sides with the sense, as squareness does not
    assert even[0] == pytest.approx(-even[1], rel=0.2)


def test_squareness_is_the_contracts_sign(lathe):
    """B0X = 100 urad: e_Z = -B0X x, 100 mm further out 10 um less (contract of a machine)."""
    track = line(lathe, "X")
    scene = scene_of(lathe, [track])
    tool = effect("squareness", scene, "X").on(track).times(100.0).tool
    assert tool[:, 2] == pytest.approx(-0.1 * track.position[:, 0]) and not tool[:, :2].any()


def test_an_arm_that_is_longer_turns_yaw_into_positioning(lathe):
    """e_Z = -b (x + tool.X - measured_at.X): 100 mm more of tool and 10 urad take 1 um off
    (contract of a machine)."""
    flat = np.full(len(lathe.axes["Z"].nodes), 10.0)
    z = replace(lathe.axes["Z"], tables={"EBZ": (flat, flat)})
    turning = replace(lathe, axes=lathe.axes | {"Z": z}, errors=lathe.errors | {"EBZ": np.zeros(6)})
    track = line(turning)
    tool = effect("abbe", scene_of(turning, [track]), "Z").on(track).times(100.0).tool
    assert tool[:, 2] == pytest.approx(-1.0)


def test_iwan_closes_its_loop_and_follows_masing():
    """After the first turn the branches of a loop are the same curve turned round, and the loop is
    closed."""
    yields, shares = np.geomspace(0.1, 2.0, 8), np.full(8, 1 / 8)
    up, down = np.linspace(0, 1.5, 301), np.linspace(1.5, 0, 301)
    way = np.r_[up, down, up, down]
    force = mechanics.iwan(way, yields, shares)
    first, second = force[301:602], force[602:903]
    assert first - first[0] == pytest.approx(-(second - second[0]), abs=1e-12)
    assert force[602] == pytest.approx(force[1203], abs=1e-12)
    assert np.abs(force).max() <= 1.0


def test_lugre_settles_at_the_coulomb_level_and_turns_over_the_bristle():
    force = mechanics.lugre(0.001, np.full(2000, 20.0), 1.0, 0.5, 1.3, 1.0, 0.005)
    assert force[-1] == pytest.approx(1.0)
    back = mechanics.lugre(0.001, np.full(2000, -20.0), 1.0, 0.5, 1.3, 1.0, 0.005)
    assert back[-1] == pytest.approx(-0.5)
    slow = mechanics.lugre(0.001, np.full(6, 0.5), 1.0, 1.0, 1.0, 1.0, 0.005)
    # way over bristle, by hand
    assert slow[-1] == pytest.approx(1 - np.exp(-6 * 0.001 * 0.5 / 0.005))


def test_a_loop_with_an_integral_forgets_a_constant_force():
    force = np.r_[np.zeros(200), np.ones(4000)]
    error = mechanics.loop_response(0.001, force, 0.05, 0.003)
    assert error.min() < -0.7 and abs(error[-1]) < 1e-6
    assert mechanics.loop_response(0.001, force, None, 0.003)[-1] == pytest.approx(-1.0)


def test_stick_slip_jumps_by_twice_what_holds_above_what_slides():
    """Held at 1, sliding at 0.6: each slip is 2 (1 - 0.6) of the way, a tenth more or less."""
    way = np.linspace(0, 40, 40001)
    saw = mechanics.slip_steps(way, np.full(len(way), 0.2), 1.0, 0.6, 3.0, np.random.default_rng(0))
    jumps = np.diff(saw)
    assert (jumps > 0.3).sum() == pytest.approx(40 / 0.8, rel=0.1)
    assert np.median(jumps[jumps > 0.3]) == pytest.approx(0.8, rel=0.15)


def test_air_is_that_of_the_textbook():
    """Dry air of 20 degrees and 1013.25 hPa: n - 1 = 271.8 ppm at 633 nm; -0.93 ppm/K and +0.27
    ppm/hPa (design notes)."""
    one = np.array([20.0]), np.array([1013.25])
    assert refractive(*one) == pytest.approx(271.8, abs=0.2)
    assert refractive(one[0] + 1, one[1]) - refractive(*one) == pytest.approx(-0.93, abs=0.01)
    assert refractive(one[0], one[1] + 1) - refractive(*one) == pytest.approx(0.27, abs=0.01)


def test_a_delayed_series_has_gone_two_thirds_after_its_time():
    step = np.r_[0.0, np.ones(1000)]
    assert delayed(step, 40 * STEP)[40] == pytest.approx(1 - np.exp(-1), rel=1e-6)


def test_a_screw_warms_where_its_nut_runs_and_grows_by_its_own_heat(lathe):
    track = line(lathe, both=True)
    track.active = [(0.0, 20000.0, "Z", 0.0, 0.3 * lathe.axes["Z"].high, 20.0)]
    track.time = track.time + 20000.0
    scene = scene_of(lathe, [track])
    room = scene.design.room | {"swing": 0.0, "walk": 0.0, "heating": 0.0, "bearing": 0.0}
    scene = Scene(
        replace(scene.design, room=room), World(replace(scene.design, room=room), stream("quiet"))
    )
    rise = scene.world.screws["Z"][int(19900 / STEP)] - room["start"]
    assert rise[0] > 3 * rise[-1] > -1e-9
    made = effect("screw_heat", scene, "Z")
    rows = project(lathe, track, made.on(track).times(11.5))[:, 0]
    first = rows[: len(np.unique(track.position[:, 2]))]
    steps = np.abs(np.diff(first)) / np.diff(track.position[: len(first), 2])
    assert steps[0] > 3 * steps[-1]  # grows near the warm end, hardly at the other
    # never more than alpha times the warmest node
    assert steps.max() <= 11.5e-3 * rise.max() * 1.01


def test_squareness_is_reported_as_the_angle_between_the_two_axes():
    """The ways of both slides over a metre: minus their product is by how much the angle between
    them is more than a right one."""
    seen = set()
    for number in range(60):
        machine = machines.draw(stream("square", number))
        scene = scene_of(machine, [])
        made = physics.names()["squareness"](scene, "Z", stream("square", "effect", number))
        place = np.eye(3) * 1000.0
        ways = place + made.on(SimpleNamespace(position=place)).tool * 1e-3
        first, second = ("XYZ".index(x) for x in made.axis)
        opened = -ways[first] @ ways[second]
        assert made.parameters(1.0)["urad"] == pytest.approx(opened, abs=1e-3)
        seen.add((machine.form, made.axis, round(opened)))
    assert {way for _, _, way in seen} == {1, -1} and len(seen) >= 3
