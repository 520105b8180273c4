"""The map of a machine, as tables of controls have it: measured at zero, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from postproc.machine.tables import AxisTable, GridTable
from postproc.machine.volumetric import VolumetricMap, of_machine

NODES = np.array([50.0, 100.0])


def leaning(values: list[float]) -> np.ndarray:
    """(6, 2): translations of zero, and rotations about X, Y and Z, rad, the same at both nodes."""
    return np.array([[0.0] * 2] * 3 + [[value] * 2 for value in values])


def test_a_rotation_moves_what_stands_off_the_place_of_measurement():
    """1e-5, 2e-5 and 4e-5 rad about X, Y and Z, at 20 mm in Y and 50 mm in Z from there: 2e-5 * 50
    - 4e-5 * 20 mm along X, -1e-5 * 50 along Y, 1e-5 * 20 along Z."""
    values = leaning([1e-5, 2e-5, 4e-5])
    machine = VolumetricMap({"X": AxisTable("X", NODES, values, values)}).machine()
    axis = replace(machine.axes["X"], measured_at=np.array([0.0, -20.0, -50.0]))
    found, left = of_machine(replace(machine, axes={**machine.axes, "X": axis}))
    wanted = [2e-4, -5e-4, 2e-4]
    assert found.axes["X"].forward[:3, 0] == pytest.approx(wanted, abs=1e-12)
    assert found.axes["X"].forward[3:] == pytest.approx(values[3:]) and not left


@pytest.mark.parametrize(("carries", "optic", "sign"), [(0, "workpiece", 1), (1, "tool", -1)])
def test_a_point_fixed_to_the_other_side_has_the_axis_itself_in_its_arm(carries, optic, sign):
    """4e-5 rad about Z move Y by as much times the own position; it counts the other way where the
    axis carries the workpiece."""
    values = leaning([0.0, 0.0, 4e-5])
    tables = {"X": AxisTable("X", NODES, values, values)}
    machine = VolumetricMap(tables, workpiece_axes=carries).machine()
    axis = replace(machine.axes["X"], optic=optic)
    found, _ = of_machine(replace(machine, axes={**machine.axes, "X": axis}))
    assert found.axes["X"].forward[1] == pytest.approx(sign * 4e-5 * NODES, abs=1e-12)


def test_travel_goes_as_far_as_tables_and_grids_of_any_axis():
    grid = GridTable("X", "Y", NODES, np.array([-7.0, 0.0, 9.0]), *np.zeros((2, 6, 2, 3)))
    axes = VolumetricMap({}, (grid,)).machine().axes
    assert [axes[x].travel for x in "XYZ"] == [(50.0, 100.0), (-7.0, 9.0), (-1.0, 1.0)]
