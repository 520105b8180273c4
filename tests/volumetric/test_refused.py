"""Recordings and machines that tell nothing of the volume: refused with the reason."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.machine.file import read_machine
from postproc.recordings import Recording, contract
from postproc.volumetric import VolumetricError, written
from postproc.volumetric.observations import rows_of
from tests.volumetric.readings import MILL, ROOT, fit_of, gcomp, lengths


@pytest.mark.parametrize(
    ("kind", "columns", "says"),
    [
        (
            "points",
            {"X_mm": [0, 1, 2], "Y_mm": [0, 1, 2], "Z_mm": [0, 0, 0]},
            "fewer than four points",
        ),
        (
            "lengths",
            {"X_mm": [0, 1, 2], "Y_mm": [0, 1, 2], "Z_mm": [0, 0, 0]},
            "five lengths at least",
        ),
        ("points", {"X_mm": [0, 1, 2, 3], "Y_mm": [0, 1, 2, 3]}, "where Z stood is not recorded"),
        (
            "ballbar",
            {"X_cmd_mm": [0, 1], "Y_cmd_mm": [0, 1], "Z_cmd_mm": [0, 1]},
            "the centre names no two slides",
        ),
        (
            "trace",
            {"X_cmd_mm": [0, 1], "Y_cmd_mm": [0, 1], "Z_cmd_mm": [0, 1]},
            "a recording of trace tells nothing of the volume",
        ),
    ],
)
def test_what_is_refused(kind, columns, says):
    data = {name: np.array(v, float) for name, v in columns.items()}
    n = len(next(iter(data.values())))
    data |= {c: np.zeros(n) for c in ("mx_mm", "my_mm", "mz_mm", "length_mm")}
    with pytest.raises(VolumetricError, match=says):
        rows_of(Recording(kind, {}, data, "a.csv", np.arange(n)), written.without_errors(MILL), {})


@pytest.mark.parametrize("groups", [[1.0], [1.0, 1.0, 1.0, 1.0, 2.0], [1.0, 1.0, 2.0, 2.0]])
def test_a_straightness_of_one_or_two_places_is_refused(groups):
    """Two numbers of the set-up: two readings leave nothing, and one has no slope at all."""
    at = 10.0 * np.arange(len(groups))
    columns = {"X_mm": at, "Y_mm": 0 * at, "Z_mm": 0 * at, "setup": np.array(groups)}
    head = {"quantity": "straightness", "sensitive": {"Y": 1.0}, "u_um": 0.5}
    read = Recording("targets", head, columns | {"reading_um": at}, "s.csv", np.arange(len(at)) + 2)
    with pytest.raises(VolumetricError, match="a straightness of [12] places in one set-up"):
        fit_of(read)


@pytest.mark.parametrize("tool", ["5.0", '{ Z = "long" }', "{ Q = 1.0 }", "{ Z = nan }", "[1, 2]"])
def test_a_tool_that_is_no_place_is_refused(tool, tmp_path, capsys):
    text = contract.write(lengths([-200.0, -100.0], (900.0, -700.0, 300.0)))
    (tmp_path / "l.csv").write_text(f"# tool = {tool}\n{text}")
    assert gcomp("volumetric", tmp_path / "l.csv", "--like", "example-mill") == 2
    said = capsys.readouterr().err
    assert "tool = " in said and "like tool = { X = 0.0, Z = -100.0 }" in said


@pytest.mark.parametrize("command", ["volumetric", "calibrate"])
def test_a_machine_with_second_slides_is_refused(command, tmp_path, capsys):
    """W's own errors were gone from the machine that was written; calibrate ended in a
    ValueError."""
    folder = tmp_path / "quill"
    folder.mkdir()
    text = (ROOT / "machines" / "perfect" / "machine.toml").read_text()
    said = {f"{x}": f"[axes.{x}]\ntravel = [-300, 300]\nleast_increment = 0.001\n" for x in "XYZW"}
    head = [line for line in text.splitlines() if line.startswith(("format", "name", "control"))]
    head += ['title = "made up"', 'source = "made up"', 'chain = "w-X-Y-b-Z-W-t"']
    (folder / "machine.toml").write_text("\n".join([*head, *said.values()]) + 'table = "W.csv"\n')
    (folder / "W.csv").write_text("W_mm,EZW_um\n-300,0\n300,20\n")
    read_machine(folder)
    file = ROOT / "sample_recordings" / "tracker_1.csv"
    if command == "calibrate":
        file = tmp_path / "z.csv"
        at = np.linspace(-200, 200, 9)
        rows = [f"{r},{z:g},{a},{z / 100:.2f}" for r in (1, 2, 3) for a in (1, -1) for z in at]
        head = ['format = "gcomp-recording/1"', 'kind = "targets"', "sensitive = { Z = 1.0 }"]
        lines = [*(f"# {h}" for h in head), "run,Z_mm,approach_Z,reading_um", *rows]
        file.write_text("\n".join(lines) + "\n")
    assert gcomp(command, file, "--like", folder, "-o", tmp_path / "m") == 2
    assert "second slides too (W)" in capsys.readouterr().err
    assert not (tmp_path / "m").exists()
