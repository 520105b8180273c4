"""A machine as tables of one axis each: whole where nothing turns, and honest about what they can
not hold."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc.machine import marginals as module
from postproc.machine.axis import Axis
from postproc.machine.chain import Chain
from postproc.machine.file import read_machine
from postproc.machine.marginals import _far_away, marginals
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.units import UM, URAD

STUDER = Path(__file__).resolve().parents[1] / "machines" / "studer-s36"
CHAINS = ["w-b-X-Y-Z-t", "w-X-Y-b-Z-t", "w-Z-b-X-Y-t", "w-Y-X-Z-b-t"]


def machine(chain: str, turning: bool, seed: int = 1) -> Machine:
    """Three axes with all translations, squareness, and perhaps rotations."""
    draw = np.random.default_rng(seed)
    axes = {}
    for x in "XYZ":
        forward = draw.normal(0, 5 * UM, (6, 6))
        forward[3:] = draw.normal(0, 20 * URAD, (3, 6)) if turning else 0.0
        reverse = forward + draw.normal(0, 1, (6, 1)) * np.array([UM] * 3 + [0.0] * 3)[:, None]
        table = AxisTable(x, np.array([0.0, 40.0, 100.0, 150.0, 220.0, 300.0]), forward, reverse)
        axes[x] = Axis(x, (0.0, 300.0), 1e-4, draw.uniform(0, 300, 3), table)
    parts = chain.split("-")
    letters = tuple(p for p in parts if p in "XYZ")
    square = {"X": np.array([0.0, 50 * URAD, -30 * URAD]), "Y": np.array([20 * URAD, 0.0, 0.0])}
    return Machine("m", "", "linuxcnc", Chain(letters, parts.index("b") - 1), axes, square=square)


def total(found, position, approach):
    """(3, N) mm: what tables of one axis add up to."""
    result = np.zeros_like(position)
    for t in found:
        m, a = "XYZ".index(t.moving), "XYZ".index(t.along)
        for way in (1.0, -1.0):
            column = t.forward if way > 0 else t.reverse
            result[a] += np.where(approach[m] == way, np.interp(position[m], t.nodes, column), 0.0)
    return result


@pytest.mark.parametrize("chain", CHAINS)
def test_without_rotations_the_tables_of_single_axes_are_the_whole_machine(chain):
    m = machine(chain, turning=False)
    found, notices = marginals(m)
    draw = np.random.default_rng(2)
    position, approach = draw.uniform(0, 300, (3, 500)), draw.choice([-1.0, 1.0], (3, 500))
    np.testing.assert_allclose(
        total(found, position, approach), m.deviation(position, approach), atol=1e-9
    )
    assert not notices


@pytest.mark.parametrize("chain", CHAINS)
def test_with_rotations_they_are_off_by_no_more_than_the_notices_say(chain):
    m = machine(chain, turning=True)
    at = {"X": 150.0, "Y": 100.0, "Z": 50.0}
    found, notices = marginals(m, at)
    said = np.zeros((3, 3))
    for n in notices:
        said["XYZ".index(n[1]), "XYZ".index(n[2])] = float(n.rsplit("up to ", 1)[1].split()[0]) * UM
    draw = np.random.default_rng(3)
    position, approach = draw.uniform(0, 300, (3, 2000)), draw.choice([-1.0, 1.0], (3, 2000))
    off = np.abs(total(found, position, approach) - m.deviation(position, approach)).max(axis=1)
    bound = said.sum(axis=1) + 9 * module.SEEN
    assert np.all(off <= bound)
    assert np.all(off >= 0.2 * said.max(axis=1)) and off.max() > UM  # and they do not cry wolf


def test_at_the_stated_place_each_axis_is_right_by_itself():
    m = machine("w-X-Y-b-Z-t", turning=True)
    at = {"X": 150.0, "Y": 100.0, "Z": 50.0}
    found, _ = marginals(m, at)
    walk = np.linspace(0, 300, 1201)
    for i, moving in enumerate("XYZ"):
        alone = replace(
            m, axes={x: a if x == moving else a.bare for x, a in m.axes.items()},
            square={x: v for x, v in m.square.items() if x == moving},
        )  # fmt: skip
        position = np.array([[at[x]] * len(walk) for x in "XYZ"])
        position[i] = walk
        approach = np.ones_like(position)
        mine = [t for t in found if t.moving == moving]
        np.testing.assert_allclose(
            total(mine, position, approach), alone.deviation(position, approach), atol=module.SEEN
        )


def test_the_studers_tables_are_those_measured_and_its_squareness_is_a_line():
    found, notices = marginals(read_machine(STUDER))
    by = {f"E{t.along}{t.moving}": t for t in found}
    assert set(by) == {"EXX", "EZX", "EXZ", "EZZ"}
    assert (by["EXX"].forward[-1] / UM, by["EXX"].reverse[0] / UM) == approx((30.5, -0.4))
    assert (by["EZZ"].nodes[0], by["EZZ"].nodes[-1], len(by["EZZ"].nodes)) == (0.0, 510.0, 18)
    # straightness 8.3 um at 170 mm, and +65 um of squareness (thesis 6.3.4); at the end of travel
    # the line goes on
    at = dict(zip(by["EZX"].nodes, by["EZX"].forward / UM, strict=True))
    assert at[170.0] == approx(8.3 + 65.0) and at[175.0] == approx(8.3 + 65.0 * 175 / 170)
    # yaw of Z, 8.7 urad at most, at an arm of 175 mm: 1.52 um
    assert len(notices) == 1 and "EZZ" in notices[0] and "1.52 um" in notices[0]


def test_what_belongs_to_no_single_slide_is_said():
    """A turntable whose line lies 10 um beside the nominal one: at 90 degrees the part stands off
    by 10 um in X and in Y."""
    m = machine("w-b-X-Y-Z-t", turning=False)
    line = np.array([10 * UM, 0.0, 0.0, 0.0, 0.0, 0.0])
    table = Axis("C", (0.0, 90.0), 1e-4, np.zeros(3), location=line)
    found, notices = marginals(
        replace(m, chain=Chain(("C", "X", "Y", "Z"), 1), axes={**m.axes, "C": table})
    )
    assert {t.moving for t in found} == {"X", "Y", "Z"}
    said = [n for n in notices if "belong to no single slide" in n]
    assert [n.split(" along ")[1][0] for n in said] == ["X", "Y"]
    assert all(9.0 < float(n.split()[2]) <= 10.01 for n in said)


def test_an_effect_belongs_to_the_table_of_its_axis(tmp_path):
    axes = "".join(f"[axes.{x}]\ntravel = [0, 300]\nleast_increment = 0.001\n" for x in "XYZ")
    (tmp_path / "machine.toml").write_text(
        'format = "gcomp-machine/1"\nname = "m"\ncontrol = "linuxcnc"\n'
        f'chain = "w-X-Y-b-Z-t"\nsource = "made up"\n{axes}'
        '[[effect]]\nname = "backlash"\naxis = "X"\nsize_um = 7.0\n'
    )
    (table,), notices = marginals(read_machine(tmp_path))
    assert (table.moving, table.along) == ("X", "X") and not notices
    assert np.abs(table.forward - table.reverse) / UM == approx(7.0)


def test_ends_that_hold_a_value_are_left_out_where_both_directions_hold_it():
    nodes = np.arange(7.0)
    up = np.array([1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0])
    down = np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0])
    found = module._trimmed(module.Marginal("X", "X", nodes, up, down))
    assert (found.nodes[0], found.nodes[-1]) == (1.0, 4.0)
    # one direction rises by as much as the other falls
    found = module._trimmed(module.Marginal("X", "X", nodes, up, -up))
    assert (found.nodes[0], found.nodes[-1]) == (2.0, 4.0)
    flat = module._trimmed(module.Marginal("X", "X", nodes, np.ones(7), np.zeros(7)))
    assert list(flat.nodes) == [5.0, 6.0]


def test_the_deviation_is_another_where_an_axis_is_another_by_more_than_can_be_seen():
    """0.05 um: what is less names no axis, unless none has more."""
    pose = {"X": 1.0, "Y": 2.0, "Z": 3.0}
    assert _far_away(pose, {"X": 1e-3, "Y": 1e-6}) == {"X": 1.0}
    assert _far_away(pose, {"X": 1e-6, "Y": 0.0}) == {"X": 1.0, "Y": 2.0}


def turning_x(nodes: np.ndarray, forward: np.ndarray) -> Machine:
    """X alone has a table, over a part of its travel of 300 mm, and a squareness."""
    axes = {x: Axis(x, (0.0, 300.0), 1e-4, np.zeros(3)) for x in "XYZ"}
    axes["X"] = Axis("X", (0.0, 300.0), 1e-4, np.zeros(3), AxisTable("X", nodes, forward, forward))
    square = {"X": np.array([0.0, 0.0, 50 * URAD])}
    return Machine("m", "", "linuxcnc", Chain(("X", "Y", "Z"), 0), axes, square=square)


@pytest.mark.parametrize("nodes", [(40.0, 100.0, 300.0), (0.0, 100.0, 240.0)], ids=["low", "high"])
def test_a_line_goes_on_where_the_table_of_its_axis_is_held(nodes):
    """The squareness goes on to either end of the travel, beyond the table's first and last."""
    forward = np.zeros((6, 3))
    forward[1] = [2 * UM, -1 * UM, 3 * UM]
    m = turning_x(np.array(nodes), forward)
    found, _ = marginals(m)
    position = np.zeros((3, 61))
    position[0] = np.linspace(0, 300, 61)
    ways = np.ones_like(position)
    np.testing.assert_allclose(
        total(found, position, ways), m.deviation(position, ways), atol=1e-12
    )


@pytest.mark.parametrize("far", [10.0, 290.0])
def test_what_a_table_can_not_hold_is_largest_where_both_arms_are_longest(far):
    """X pitches and yaws: its table holds what that does at Y = Z = `far`, and misses both parts at
    the other ends of Y and Z."""
    forward = np.zeros((6, 3))
    forward[4], forward[5] = [0.0, 10 * URAD, 0.0], [0.0, -10 * URAD, 0.0]
    m = turning_x(np.array([0.0, 100.0, 300.0]), forward)
    _, notices = marginals(m, {"X": 150.0, "Y": far, "Z": far})
    (said,) = [float(n.rsplit("up to ", 1)[1].split()[0]) for n in notices if n[1:3] == "XX"]
    assert said == approx(2 * 290.0 * 10 * URAD / UM, abs=0.01)
