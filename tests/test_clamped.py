"""Where a table is held beyond its ends (--outside clamp) the deviation bends at its end, and a
motion is cut there."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from postproc.compensate import Options
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.tables import AxisTable
from postproc.nc import dialects
from postproc.units import UM
from postproc.verify import Verifier

ROOT = Path(__file__).resolve().parents[1]


def test_a_motion_from_the_last_interval_over_the_end_is_cut_at_the_end(tmp_path):
    """EYX rises by 20 um over the last 50 mm and is held: without a cut at X = 100 Y misses by up
    to 5 um."""
    folder = tmp_path / "m"
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    (folder / "X.csv").write_text("X_mm,EYX_um\n0,0\n50,0\n100,20\n")
    m = read_machine(folder)
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m), Options(outside="clamp"))
    verifier = Verifier(filter_)
    out = filter_.feed(b"G0 X75 Y0\nG1 X150 F500\n") + filter_.finish()
    assert b"\nG1 X100.0000 Y-0.0200 F500\nX150.0000\n" in out
    assert verifier.corrected.deviation < 0.1 * UM


def test_beyond_its_ends_a_table_is_flat():
    """What bounds cuts there: from slope to none, and the slope at most."""
    nodes, rise = np.array([0.0, 50.0, 100.0]), np.zeros((6, 3))
    rise[0] = 0.0, 0.010, 0.020  # mm: 200 um/m
    table = AxisTable("X", nodes, rise, rise)
    low, high = np.array([10.0, -10.0, 90.0]), np.array([90.0, 10.0, 110.0])
    differs, largest = table.slope_range(low, high)
    assert differs[0] == pytest.approx([0.0, 2e-4, 2e-4]) and largest[0] == pytest.approx(
        [2e-4] * 3
    )
