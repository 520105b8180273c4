"""A rapid gains no word of an axis that it does not name, unless the correction there exceeds the
tolerance."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from postproc.compensate import Options
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects

ROOT = Path(__file__).resolve().parents[1]
START = "G21 G90\nG0 X0 Y0 Z50\n"


def corrected(folder: Path, program: str, **tables: str) -> list[str]:
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    for letter, text in tables.items():
        (folder / f"{letter}.csv").write_text(text)
    m = read_machine(folder)
    offsets = {"H1": {"Z": 100.0}}
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, offsets), Options(tolerance=0.001))
    return (filter_.feed(program.encode()) + filter_.finish()).decode().splitlines()


@pytest.mark.parametrize(("um", "block"), [(0.7, "G0 X100 Y50"), (1.2, "G0 X100 Y50 Z49.9988")])
def test_a_first_rapid_in_x_and_y_keeps_its_words(tmp_path, um, block):
    """Straightness of X in Z, 0 at X0 and so much at X100; tolerance 1 um, increments of 0.1 um."""
    out = corrected(
        tmp_path / "m", START + "G0 X100 Y50\nG1 Z-1 F100\n", X=f"X_mm,EZX_um\n0,0\n100,{um}\n"
    )
    assert block in out
    assert f"G1 Z{-1 - um / 1000:.4f} F100" in out, "the feed behind it is exact"


@pytest.mark.parametrize(
    ("um", "block"),
    [(0.6, "G43 H1 G0 Z5"), (0.8, "G43 H1 G0 Z5 X0.0008"), (1.2, "G43 H1 G0 Z5 X0.0012")],
)
def test_a_tool_length_block_keeps_its_words(tmp_path, um, block):
    """Straightness of Z in X, 0 at Z50 and Z150 and so much at Z105 (H1 is 100 long). Two axes
    rest: 1 um over root 2 each."""
    z = f"Z_mm,EXZ_um\n0,0\n90,0\n105,{-um}\n150,0\n400,0\n"
    program = START + "G0 Z150\nG43 H1 G0 Z5\nG1 X10 F100\n"
    out = corrected(tmp_path / "m", program, Z=z)
    assert block in out
