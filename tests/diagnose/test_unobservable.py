"""What a circle in one sense at one feed can not tell apart, wherever its centre lies."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from postproc.cli import main

STUDER = str(Path(__file__).parents[2] / "machines" / "studer-s36")


@pytest.mark.parametrize("senses", [("1",), ("-1",), ("1", "-1")])
def test_circles_of_one_sense_hide_which_it_is(tmp_path, senses):
    file, out = tmp_path / "a.csv", tmp_path / "a.json"
    assert (
        main(
            [
                "simulate",
                "--test",
                "ballbar:XZ",
                "--machine",
                STUDER,
                "--noise",
                "0.3",
                "-o",
                str(file),
                "--quiet",
            ]
        )
        == 0
    )
    lines = file.read_text().splitlines()
    head = next(k for k, line in enumerate(lines) if not line.startswith("#"))
    sense = lines[head].split(",").index("sense")
    kept = [line for line in lines[head + 1 :] if line.split(",")[sense] in senses]
    assert len(kept) > 100 and (len(kept) < len(lines) - head - 1) == (len(senses) == 1)
    file.write_text("\n".join([*lines[: head + 1], *kept]) + "\n")
    assert main(["diagnose", str(file), "--machine", STUDER, "--json", str(out), "--quiet"]) == 0
    told = [
        s for s in json.loads(out.read_text())["not_visible"] if s["effect"] == "servo_mismatch"
    ]
    if len(senses) == 2:
        assert not told
    else:
        assert (
            told[0]["axis"] == "XZ"
            and "one sense" in told[0]["why"]
            and "ballbar:XZ" in told[0]["next_test"]
        )


@pytest.mark.parametrize("lines", [1, 2])
def test_targets_on_one_line_hide_a_rotation_that_the_file_lacks(tmp_path, lines):
    """The S-36's file has rotations, whose arm may be wrong: that shows on one line. A rotation
    that it has not looks there like an error of position."""
    readings = ["run,X_mm,Z_mm,approach_Z,reading_um"]
    for run in range(1, 4):
        for x in (20, 90)[:lines]:
            readings += [f"{run},{x},{z},1,{(z * run) % 7 / 10}" for z in range(10, 510, 30)]
    file, out = tmp_path / "a.csv", tmp_path / "a.json"
    head = '# format = "gcomp-recording/1"\n# kind = "targets"\n# quantity = "displacement"\n'
    file.write_text(head + "# sensitive = { X = 0.0, Z = 1.0 }\n" + "\n".join(readings) + "\n")
    assert main(["diagnose", str(file), "--machine", STUDER, "--json", str(out), "--quiet"]) == 0
    told = [s for s in json.loads(out.read_text())["not_visible"] if s["effect"] == "abbe"]
    along = [s for s in told if s["axis"] == "Z"]
    assert bool(along) == (lines == 1)
    if along:
        assert "on two lines" in along[0]["why"] and "arms:Z" in along[0]["next_test"]
