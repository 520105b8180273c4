"""What the control's own tables do already is taken out of the map, once."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc.commands.reading import with_control_tables
from postproc.errors import MachineError
from postproc.machine.file import read_machine

ROOT = Path(__file__).resolve().parents[1]
PLACES = np.array(
    [[-1000.0, -730.0, -333.0, 0.0, 20.0], [-600.0, -333.0, -100.0, 0.0, 10.0], [-10.0] * 5]
)


def mv(folder: Path, measured: str, active: bool, file: str = 'file     = "fanuc_pitch.csv"'):
    shutil.copytree(ROOT / "machines" / "mv-1060", folder)
    toml = folder / "machine.toml"
    text = toml.read_text().replace('measured = "off"', f'measured = "{measured}"')
    text = text.replace("active   = false", f"active   = {str(active).lower()}").replace(
        'file     = "fanuc_pitch.csv"', file
    )
    toml.write_text(text)
    return read_machine(folder)


def deviation(machine, way=1.0):
    return machine.deviation(PLACES, np.full_like(PLACES, way)) * 1000


def test_off_then_off_is_the_map(tmp_path):
    """By hand: the increments of Table 7.2 from 51 to 100 add up to 36, so the map begins at +36
    um."""
    machine = mv(tmp_path / "m", "off", False)
    assert deviation(machine)[0, 0] == approx(36.0)
    assert np.array_equal(deviation(with_control_tables(machine)), deviation(machine))


@pytest.mark.parametrize("way", [-1.0, 0.0, 1.0])
def test_measured_without_the_table_and_used_with_it_nothing_is_left(tmp_path, way):
    machine = with_control_tables(mv(tmp_path / "m", "off", True))
    assert deviation(machine, way) == approx(np.zeros_like(PLACES), abs=1e-9)


def test_measured_with_the_table_and_used_without_it_what_it_did_comes_back(tmp_path):
    machine = mv(tmp_path / "m", "on", False)
    plain = deviation(machine)
    # this map is the table's own
    assert deviation(with_control_tables(machine)) == approx(2 * plain, abs=1e-9)


def test_measured_with_it_and_used_with_it_is_the_map(tmp_path):
    machine = mv(tmp_path / "m", "on", True)
    assert np.array_equal(deviation(with_control_tables(machine)), deviation(machine))


def test_what_nobody_knows_is_asked_for(tmp_path):
    with pytest.raises(MachineError, match="what this table does is not known"):
        mv(tmp_path / "a", "off", True, "")
    with pytest.raises(MachineError, match="there is no file"):
        mv(tmp_path / "b", "off", True, 'file = "other.csv"')
    with pytest.raises(MachineError, match="measured with this table") as told:
        mv(tmp_path / "c", "perhaps", True)
    assert "machine.toml:" in str(told.value)
