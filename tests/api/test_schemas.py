"""One schema for each command that reports: what it writes fits it, and has no field that the
schema does not tell of."""

from __future__ import annotations

import argparse
import importlib
import json
from pathlib import Path

import pytest

from postproc.cli import DEFAULT, commands, main
from postproc.commands.as_json import SCHEMAS
from tests.api.schemas import held, schema

jsonschema = pytest.importorskip(
    "jsonschema", reason="jsonschema is not installed: schemas are not held against what is written"
)

ROOT = Path(__file__).resolve().parents[2]
RECORDINGS = ROOT / "sample_recordings"
SHAFT = str(ROOT / "sample_programs" / "shaft.nc")
Z = str(RECORDINGS / "z_positioning.csv")
STUDER = ["--machine", "studer-s36"]
# Who writes a format, with lines that show it; accept, control, diagnose, receive, stream and
# volumetric have theirs in their own tests.
LINES = {
    "gcomp-program/1": [
        [SHAFT, *STUDER, "-o", "s.nc", "--verify"],
        [SHAFT, *STUDER, "-o", "s2.nc"],
    ],
    "gcomp-batch/1": [["batch", SHAFT, "bad.nc", *STUDER, "-o", "b", "-j", "1", "--quiet"]],
    "gcomp-iso/1": [
        ["iso", Z, str(RECORDINGS / "ballbar_xz.csv"), str(RECORDINGS / "x_straightness.csv")]
    ],
    "gcomp-calibration/1": [
        ["calibrate", *map(str, sorted(RECORDINGS.glob("?_*.csv"))), "--like", "example-lathe"]
    ],
    "gcomp-machines/1": [
        ["machines"],
        ["machines", "show", "example-mill"],
        ["machines", "show", "example-five-axis"],
        ["machines", "check", "example-router"],
        ["machines", "show", "perfect"],
    ],
    "gcomp-recordings/1": [["recordings", Z, str(RECORDINGS / "ballbar_xz.csv"), "bad.nc"]],
    "gcomp-explain/1": [["explain", SHAFT, *STUDER]],
    "gcomp-export/1": [
        ["export", *STUDER, "--control", "linuxcnc", "-o", "t/", "--residual", "rest"],
        ["export", "--control", "linuxcnc", "--read", "t/Z.comp", "--set", "type=0"],
        ["export", "--list"],
        ["export", "--list", "--control", "fanuc"],
    ],
    "gcomp-hook/1": [
        ["hook", "install", "fusion", *STUDER, "-o", "hooks", "--", "--tolerance", "5um"],
        ["hook", "list"],
    ],
    "gcomp-simulate/1": [
        ["simulate", "--test", "positioning:Z", *STUDER, "-o", "z.csv", "--noise", "0.1"],
        ["simulate", "--test", "positioning:Z", *STUDER, "--program-out", "z.nc"],
    ],
}
ELSEWHERE = {
    "gcomp-accept/1",
    "gcomp-control/1",
    "gcomp-diagnosis/1",
    "gcomp-receive/1",
    "gcomp-run/1",
    "gcomp-volumetric/1",
}
# Commands that find nothing out: texts for a shell and for man, and a page that is looked at.
WITHOUT = {"completion", "man", "show"}


@pytest.mark.parametrize("format", LINES)
def test_what_is_written_fits_its_schema(tmp_path, monkeypatch, capfd, format):
    monkeypatch.chdir(tmp_path)
    Path("bad.nc").write_text("G21 G90 G0 X20. Z0.\nG1 X9000. F100\n")
    for k, line in enumerate(LINES[format]):
        at = line.index("--") if "--" in line else len(line)
        assert main([*line[:at], "--json", f"{k}.json", *line[at:]]) in (0, 1, 2)
        data = json.loads(Path(f"{k}.json").read_text("utf-8"))
        assert data["format"] == format
        held(data)
    capfd.readouterr()


def test_json_goes_to_standard_output_alone(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    for line in (
        ["iso", Z],
        ["recordings", Z],
        ["machines", "show", "perfect"],
        ["explain", SHAFT, *STUDER],
        ["export", *STUDER, "--control", "linuxcnc", "-o", "t/"],
        ["export", "--control", "linuxcnc", "--read", "t/Z.comp"],
        ["hook", "install", "folder", *STUDER, "-o", "hooks"],
        ["simulate", "--test", "positioning:Z", *STUDER, "-o", "z.csv"],
    ):
        assert main([*line, "--json", "-"]) == 0
        held(json.loads(capfd.readouterr().out))


def test_every_schema_is_of_a_command_and_every_field_has_its_meaning():
    names = {json.loads(p.read_text("utf-8"))["$id"] for p in SCHEMAS.glob("*.json")}
    assert names == {*LINES, *ELSEWHERE}
    for name in names:
        jsonschema.Draft202012Validator.check_schema(schema(name))
        assert without_meaning(schema(name)) == []


def without_meaning(own: dict, path: str = "") -> list[str]:
    found = []
    for key, part in own.get("properties", {}).items():
        described = part.get("description") or "const" in part
        found += [] if described else [f"{path}.{key}"]
        found += without_meaning(part, f"{path}.{key}") + without_meaning(
            part.get("items", {}), f"{path}.{key}"
        )
    return found


def test_two_documents_do_not_go_to_standard_output(capfd):
    assert main(["simulate", "--test", "positioning:Z", *STUDER, "--json", "-"]) == 2
    told = capfd.readouterr()
    assert not told.out and "-o FILE.csv" in told.err


def test_every_command_that_reports_has_json():
    """What a command finds or does it says to programs too."""
    for name in commands():
        parser = argparse.ArgumentParser()
        importlib.import_module(f"postproc.commands.{name}").arguments(parser)
        options = {o for action in parser._actions for o in action.option_strings}
        assert ("--json" in options) == (name not in WITHOUT), name
    assert DEFAULT in commands()


def test_the_page_of_formats_names_them_all():
    text = (ROOT / "docs" / "JSON.md").read_text("utf-8")
    for name in (*LINES, *ELSEWHERE):
        assert f"`{name}`" in text and f"postproc/schemas/{name.replace('/', '-')}.json" in text, (
            name
        )
