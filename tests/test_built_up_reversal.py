"""A reversal that builds up with the way after a turn is taken up over that way, not at the turn."""

from __future__ import annotations

import shutil
from pathlib import Path

from pytest import approx

from postproc.compensate.compensator import Compensator, Options
from postproc.machine.file import read_machine

ROOT = Path(__file__).parent.parent
WINDUP = '[[effect]]\nname = "windup"\naxis = "X"\nsize_um = {}\nlength_mm = 0.2\n'


def machine(tmp_path, size_um: float, stated: str = ""):
    folder = tmp_path / f"m{size_um:g}"
    shutil.copytree(ROOT / "machines" / "studer-s36", folder)
    text = (folder / "machine.toml").read_text()
    (folder / "machine.toml").write_text(stated + text + "\n" + WINDUP.format(size_um))
    return read_machine(folder)


def test_the_largest_reversal_says_how_all_are_taken_up(tmp_path):
    """The S-36's tables differ by up to 9.8 um: a windup of 30 um is larger, one of 2 um is not."""
    large, small = machine(tmp_path, 30.0), machine(tmp_path, 2.0)
    assert (large.reversal, small.reversal) == ("ramp", "step")
    assert large.ramp == approx(0.6) and small.ramp == 0.0
    assert Compensator(large).mode == "ramp" and Compensator(large, Options(reversal="step")).mode == "step"


def test_what_the_file_states_holds(tmp_path):
    assert machine(tmp_path, 30.0, 'reversal = "step"\n').reversal == "step"
