"""The shipped recordings of a ballbar beside a turning table, in both modes of ISO 10791-6."""

from __future__ import annotations

import json
from pathlib import Path

from postproc import cli
from tests.volumetric import table_ballbar

FILES = [table_ballbar.ROOT / "sample_recordings" / name for name in table_ballbar.texts()]
TRUTH = {"Y0A": 9, "Z0A": -12, "X0C": 7, "Y0C": -6, "B0A": 14, "C0A": -9, "A0C": 11, "B0C": -16}


def found(files: list[Path], tmp_path: Path) -> dict:
    words = ["volumetric", *map(str, files), "--like", "example-five-axis"]
    assert cli.main([*words, "--json", str(tmp_path / "found.json")]) == 0
    return json.loads((tmp_path / "found.json").read_text())


def test_the_files_are_what_the_model_gives():
    for path, text in zip(FILES, table_ballbar.texts().values(), strict=True):
        assert path.read_text() == text


def test_both_modes_tell_how_two_rotary_axes_lie(tmp_path, capsys):
    errors = found(FILES, tmp_path)["errors"]
    assert set(errors) == set(TRUTH)
    for name, value in TRUTH.items():
        one = errors[name]
        assert one["told"] and abs(one["value"][0] - value) < 3 * one["u"][0] < 5, (name, one)


def test_one_mode_alone_says_what_it_can_not_part(tmp_path, capsys):
    """Radially a lean of C and its place move the ball alike, at one height: A0C and Y0C, B0C and
    X0C. Along the axis its place is hardly seen, and the ball's own place, known to half a
    millimetre, sets the bar a little askew, which mixes the two."""
    radial, axial = (found([path], tmp_path) for path in FILES)
    assert ["A0C", "Y0C"] in radial["not_parted"] and ["X0C", "B0C"] in radial["not_parted"]
    assert not {n for n, e in axial["errors"].items() if e["told"]} & {"X0C", "Y0C", "Y0A", "Z0A"}
    assert "gcomp" not in capsys.readouterr().err
