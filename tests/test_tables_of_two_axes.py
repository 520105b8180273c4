"""What depends on a second axis counts wherever that one stands: the least play, the shape of the
deviation, and what tables of one axis can not hold. By hand."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc.compensate import Options
from postproc.compensate.settings import Settings
from postproc.effects.sag import OPTIONAL
from postproc.errors import MachineError
from postproc.machine import overshoot, places
from postproc.machine.effect_file import term
from postproc.machine.marginals import marginals
from postproc.machine.model import Machine
from postproc.machine.stated import Limits
from postproc.machine.tables import AxisTable, GridTable
from postproc.units import UM

ENDS = np.array([0.0, 400.0])


def bare() -> Machine:
    """A mill of X Y Z without errors."""
    return places.load("example-mill").bare


def over_y(others: list[float], forward: list[float], reverse: list[float]) -> GridTable:
    """EXX of X by where Y stands, mm, alike all along X."""
    values = np.zeros((2, 6, 2, len(others)))
    values[:, 0] = np.array([forward, reverse])[:, None]
    return GridTable("X", "Y", ENDS, np.array(others), *values)


def with_grids(machine: Machine, *grids: GridTable, **axis) -> Machine:
    x = replace(machine.axes["X"], grids=grids, **axis)
    return replace(machine, axes={**machine.axes, "X": x})


@pytest.mark.parametrize("others", [[0.0, 300.0], [-300.0, 0.0]])
def test_the_least_play_is_looked_for_wherever_the_second_axis_stands(others):
    """Forward 20 um beyond reverse at the upper end of Y, alike at the lower one."""
    machine = with_grids(bare(), over_y(others, [0.0, 0.02], [0.0, 0.0]))
    assert machine.least_play.tolist() == pytest.approx([-0.02, 0.0, 0.0])
    assert Settings(machine, Options()).overshoots.tolist() == [True, False, False]


def test_plays_of_one_place_add_up_and_second_axes_stand_where_they_like():
    """15 um of the table less 20 um at Y300, less 10 um at Z-50, is -15 um; two grids by Y of which
    one gives what the other takes leave the 15 um that there are."""
    zeros = np.zeros((2, 6, 2))
    zeros[:, 0] = np.array([[-0.0075], [0.0075]])
    table = AxisTable("X", ENDS, *zeros)
    by_y = over_y([0.0, 300.0], [0.0, 0.02], [0.0, 0.0])
    by_z = replace(over_y([-50.0, 0.0], [0.01, 0.0], [0.0, 0.0]), other="Z")
    machine = with_grids(bare(), by_y, by_z, table=table)
    assert machine.least_play[0] == pytest.approx(-0.015)
    back = over_y([0.0, 300.0], [0.0, 0.0], [0.0, 0.02])
    assert with_grids(bare(), by_y, back, table=table).least_play[0] == 0.0


def test_a_slide_that_goes_beyond_its_command_at_one_place_of_the_second_axis_is_named():
    """-5 um at Y0, -20 um at Y300, at both ends of X."""
    grid = over_y([0.0, 300.0], [0.005, 0.02], [0.0, 0.0])
    (said,) = overshoot.found(with_grids(bare(), grid))
    assert "EXX goes beyond" in said and "-20.0 to -5.0 um, -12.5 in the median" in said
    assert "4 of 4 targets" in said


def test_a_reversal_by_two_axes_that_is_the_largest_is_taken_up_at_once():
    """12 um at once by Y, beside 8 um that build up over some way."""
    machine = bare()
    slow = term("windup", "X", {"size_um": 8.0, "length_mm": 0.2}, machine.axes, None)
    machine = replace(machine, effects=(slow,))
    assert machine.pretravel["X"] > 0
    grid = over_y([0.0, 300.0], [0.0, 0.0], [0.0, 0.012])
    assert "X" not in with_grids(machine, grid).pretravel


def test_a_slope_over_a_second_axis_may_turn_from_its_steepest_up_to_its_steepest_down():
    """10 um at Y100 between none at Y0 and Y200: 1e-4 up, 1e-4 down; the chord misses by 10 um on
    200 mm, which is kink * 200 / 4."""
    machine = with_grids(bare(), over_y([0.0, 100.0, 200.0], [0.0, 0.01, 0.0], [0.0, 0.01, 0.0]))
    assert machine.bounds.kink == pytest.approx(2e-4)
    assert machine.bounds.local(np.zeros((3, 1)), np.full((3, 1), 200.0))[0] == pytest.approx(2e-4)
    assert machine.bounds.steepest == pytest.approx(1e-4)


@pytest.mark.parametrize("outside, kink", [("error", 0.0), ("clamp", 1e-4)])
def test_a_straight_table_turns_where_it_ends_and_the_travel_does_not(outside, kink):
    """40 um over 400 mm, held beyond: where programs may go on, the slope falls to none there."""
    values = np.zeros((6, 2))
    values[0, 1] = 0.04
    machine = replace(bare(), limits=Limits(outside=outside))
    travel = (-100.0, 500.0)
    machine = with_grids(machine, table=AxisTable("X", ENDS, values, values), travel=travel)
    assert machine.bounds.kink == pytest.approx(kink)


def test_a_sag_that_is_largest_in_the_middle_of_a_second_axis_is_seen_there():
    """A beam along X gives most in its middle; with X at an end of its travel nothing of it is in
    the table of Y, and in the middle all is missing."""
    machine = bare()
    low, high = machine.axes["X"].travel
    named = {"size_um": 30.0, "along": 2.0, **OPTIONAL, "beam": 0.0}
    sag = term("sag", "Y", named, machine.axes, None)
    _, notices = marginals(replace(machine, effects=(sag,)), {"X": low})
    (said,) = [text for text in notices if text.startswith("EZY")]
    # sin(n pi / 2)^2 / n^4 of the waves 1 and 3: 1 + 1/81, downwards
    assert sag.grids[0].forward[2].min() == pytest.approx(-30 * (1 + 1 / 81) * UM)
    assert "up to 30.37 um" in said


def five_axes(folder: Path, key: str, table: str) -> Machine:
    """example-five-axis with a table over two axes, named by the first of them."""
    shutil.copytree(Path(__file__).resolve().parents[1] / "machines" / "example-five-axis", folder)
    (folder / "by.csv").write_text(table)
    text = (folder / "machine.toml").read_text()
    head = f"[axes.{key[0]}]\n"
    by = f'by = {{ {key[1]} = "by.csv" }}\n'
    (folder / "machine.toml").write_text(text.replace(head, head + by))
    return places.load(str(folder))


def grid_of(key: str, last: float = 0.0) -> str:
    """EX of the first axis: 10 um with C at 90, -10 um at 270, alike wherever X stands."""
    turn = [(0, 0.0), (90, 10.0), (180, 0.0), (270, -10.0), (360, last)]
    rows = [({"X": x, "C": c}, um) for x in (-300, 300) for c, um in turn]
    names = {"X": "X_mm", "C": "C_deg"}
    lines = [f"{names[key[0]]},{names[key[1]]},EX{key[0]}_um"]
    return "\n".join(lines + [f"{at[key[0]]},{at[key[1]]},{um}" for at, um in rows]) + "\n"


@pytest.mark.parametrize("key", ["XC", "CX"])
def test_a_full_turn_of_an_axis_is_repeated_over_its_travel(key, tmp_path):
    """C travels 20 turns either way: at 3690 and at -3510 it stands as at 90."""
    (grid,) = five_axes(tmp_path / "m", key, grid_of(key)).grids
    at = np.array([90.0, 3690.0, -3510.0, -90.0, 7110.0])
    there = (0 * at, at) if key == "XC" else (at, 0 * at)
    value = grid.evaluate(*there, 0 * at)[0]
    assert value / UM == pytest.approx([10.0, 10.0, 10.0, -10.0, -10.0])


def test_a_turn_of_a_second_axis_that_does_not_close_is_refused(tmp_path):
    with pytest.raises(MachineError, match="EXX ends a full turn of C with another value") as said:
        five_axes(tmp_path / "m", "XC", grid_of("XC", last=2.0))
    assert said.value.place.file.endswith("by.csv")
