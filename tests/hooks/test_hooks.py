"""Hooks run as the programs run them: from another folder, without PATH, with a foreign Python's
variables set."""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import stat
import subprocess
import sys
import types
from pathlib import Path

import pytest

from postproc import hooks
from postproc.cli import main
from tests.cam.make import washer

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = b"G90 G21 G18\nG0 X20. Z0.\nG1 X40. Z80. F100\nM30\n"
BAD = b"G90 G21 G18\nG0 X20. Z0.\nG1 X900. F100\n"
# What a program with windows hands on: no PATH of a shell, and, of an AppImage, variables of its
# own Python.
FOREIGN = {
    "PATH": "/usr/bin:/bin",
    "HOME": "/nonexistent",
    "PYTHONHOME": "/nonexistent",
    "LD_LIBRARY_PATH": "/nonexistent",
}


OFFSETS = ("--offset", "G54=X0,Y0,Z-100", "--offset", "H1=Z0")


def install(folder: Path, name: str, *words: str) -> Path:
    """The hook's one file, in a folder of its own."""
    assert (
        main(["hook", "install", name, "--machine", "studer-s36", "-o", str(folder), *words]) == 0
    )
    return next(p for p in folder.iterdir() if p.is_file())


def called(script: Path, file: Path, *words: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [str(script), *words, str(file)], cwd="/", env=FOREIGN, capture_output=True
    )


@pytest.fixture
def expected(tmp_path) -> bytes:
    source, out = tmp_path / "nominal.nc", tmp_path / "expected.nc"
    source.write_bytes(PROGRAM)
    assert main(["--machine", "studer-s36", str(source), "-o", str(out), "--quiet"]) == 0
    return out.read_bytes()


@pytest.mark.parametrize("name", ["prusaslicer", "folder"])
@pytest.mark.skipif(os.name == "nt", reason="a shell's script")
def test_a_script_corrects_the_file_named_last_from_anywhere(tmp_path, expected, name):
    script = install(tmp_path / "hooks", name)
    job = tmp_path / "a job with spaces.nc"
    job.write_bytes(PROGRAM)
    done = called(script, job, "--some-option-of-the-slicer" if name == "folder" else "x")
    assert (done.returncode, job.read_bytes()) == (0, expected), done.stderr
    # nothing is left beside it
    assert {p.name for p in tmp_path.iterdir() if p.name.startswith("a job")} == {job.name}
    assert done.stdout == b"" and done.stderr == b""


@pytest.mark.skipif(os.name == "nt", reason="a shell's script")
def test_a_refusal_has_a_status_and_a_message_and_leaves_the_file(tmp_path):
    script = install(tmp_path / "hooks", "prusaslicer")
    job = tmp_path / "job.nc"
    job.write_bytes(BAD)
    done = called(script, job)
    assert done.returncode == 2 and b"X = 450.0000 mm lies outside" in done.stderr
    assert job.read_bytes() == BAD
    assert called(script, tmp_path / "none.nc").returncode == 2
    assert subprocess.run([str(script)], capture_output=True, env=FOREIGN).returncode == 2


@pytest.mark.skipif(os.name == "nt", reason="a shell's script")
def test_keep_and_options_are_handed_on(tmp_path):
    script = install(tmp_path / "hooks", "prusaslicer", "--keep", "--", "--tolerance", "7um")
    job = tmp_path / "job.nc"
    job.write_bytes(PROGRAM)
    assert called(script, job).returncode == 0
    assert b"TOL 7 UM" in job.read_bytes()
    assert (tmp_path / "job.nc.bak").read_bytes() == PROGRAM


@pytest.mark.skipif(os.name == "nt", reason="a shell's script")
def test_linuxcnc_gets_a_filter_and_the_lines_of_its_ini(tmp_path, expected, capfd):
    script = install(tmp_path / "hooks", "linuxcnc")
    said = capfd.readouterr().out
    assert "[FILTER]" in said and all(f"{e} = {script}" in said for e in ("ngc", "nc", "tap"))
    job = tmp_path / "job.ngc"
    job.write_bytes(PROGRAM)
    done = called(script, job)
    assert (done.returncode, done.stdout) == (0, expected)
    assert b"FILTER_PROGRESS=100" in done.stderr
    job.write_bytes(BAD)
    done = called(script, job)
    assert done.returncode == 2 and b"lies outside" in done.stderr and done.stdout == b""


def test_curas_script_corrects_the_layers_and_prints_nothing_that_was_refused(
    tmp_path, expected, monkeypatch
):
    script = install(tmp_path / "hooks", "cura")
    text = script.read_text().replace("from ..Script import Script", "Script = object")
    module = types.ModuleType("Gcomp")
    exec(compile(text, str(script), "exec"), module.__dict__)
    monkeypatch.chdir("/")
    one = module.Gcomp()
    assert '"key": "Gcomp"' in one.getSettingDataString()
    layers = PROGRAM.decode().splitlines(keepends=True)
    assert "".join(one.execute(layers)).encode() == expected
    refused = "".join(one.execute([BAD.decode()]))
    assert "lies outside" in refused and all(line.startswith(";") for line in refused.splitlines())


@pytest.mark.parametrize("name", hooks.names())
def test_every_hook_says_where_it_goes_and_names_everything_by_its_whole_path(
    tmp_path, capfd, name
):
    path = install(tmp_path / "hooks", name)
    said = capfd.readouterr().out
    assert str(path) in said and path.is_absolute()
    text = path.read_text()
    assert str(ROOT / "machines" / "studer-s36") in text and os.path.abspath(sys.executable) in text
    if path.suffix == ".py":
        ast.parse(text)
    else:
        assert path.stat().st_mode & stat.S_IXUSR
    assert main(["hook", "install", name, "--machine", "studer-s36", "-o", str(path.parent)]) == 2
    assert (
        main(
            ["hook", "install", name, "--machine", "studer-s36", "-o", str(path.parent), "--force"]
        )
        == 0
    )


@pytest.mark.parametrize(
    "words, says",
    [
        (["install"], "for which program?"),
        (["install", "catia", "--machine", "perfect"], "there is no hook for 'catia'"),
        (["install", "prusaslicer"], "--machine is missing"),
        (["install", "prusaslicer", "--machine", "perfect", "-o", "a b"], "has a space in it"),
        (
            ["install", "prusaslicer", "--machine", "perfect", "--", "--tolernace", "1um"],
            "no option --tolernace",
        ),
        (
            ["install", "prusaslicer", "--machine", "perfect", "--", "--tolerance", "fine"],
            "not a length",
        ),
        (
            ["install", "prusaslicer", "--machine", "perfect", "--", "--in-place"],
            "says where the program goes",
        ),
    ],
)
def test_what_can_not_be_is_refused_when_it_is_installed(tmp_path, monkeypatch, capfd, words, says):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert main(["hook", *words]) == 2
    assert says in capfd.readouterr().err
    assert list(tmp_path.rglob("*.sh")) == []


def test_the_list_says_with_what_each_was_tried(capfd):
    assert main(["hook", "list"]) == 0
    out = capfd.readouterr().out
    assert all(name in out for name in hooks.names()) and out.count("tried:") == len(hooks.names())


@pytest.mark.programs
def test_prusaslicer_itself_exports_the_corrected_program(tmp_path):
    slicer = shutil.which("prusa-slicer")
    if slicer is None:
        pytest.skip("prusa-slicer is not installed (apt-get install prusa-slicer)")
    machine = tmp_path / "printer"
    shutil.copytree(ROOT / "machines" / "example-mill", machine)
    toml = machine / "machine.toml"
    text = re.sub(r'control\s*=\s*"[^"]*"', 'control = "marlin"', toml.read_text())
    toml.write_text(
        text.replace("[limits]", "[home]\nX = 0.0\nY = 0.0\nZ = 0.0\n\n[limits]")
        if "[home]" not in text
        else text
    )
    folder = tmp_path / "hooks"
    assert (
        main(
            [
                "hook",
                "install",
                "prusaslicer",
                "--machine",
                str(machine),
                "-o",
                str(folder),
                "--",
                "--outside",
                "clamp",
            ]
        )
        == 0
    )
    script = next(folder.iterdir())
    (tmp_path / "washer.stl").write_text(washer())
    common = [
        slicer,
        "--export-gcode",
        "--gcode-flavor",
        "marlin2",
        "--layer-height",
        "0.2",
        "--first-layer-height",
        "0.2",
        "--start-gcode",
        "G28",
        "--skirts",
        "0",
        "washer.stl",
        "--output",
    ]
    env = {**os.environ, "HOME": str(tmp_path)}
    plain = subprocess.run(
        [*common, "plain.gcode"], cwd=tmp_path, env=env, capture_output=True, text=True
    )
    assert plain.returncode == 0, plain.stdout + plain.stderr
    done = subprocess.run(
        [*common, "done.gcode", "--post-process", str(script)],
        cwd=tmp_path,
        env=env,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert (
        "GCOMP" in (tmp_path / "done.gcode").read_text()
        and "GCOMP" not in (tmp_path / "plain.gcode").read_text()
    )
    assert not list(tmp_path.glob("*.bak"))


@pytest.mark.programs
def test_freecad_itself_posts_the_corrected_program(tmp_path):
    if shutil.which("freecadcmd") is None:
        pytest.skip("freecadcmd is not installed (apt-get install freecad-python3)")
    macros = tmp_path / "macros"
    assert (
        main(
            [
                "hook",
                "install",
                "freecad",
                "--machine",
                str(ROOT / "machines" / "example-mill"),
                "-o",
                str(macros),
                "--",
                *OFFSETS,
            ]
        )
        == 0
    )
    script = (ROOT / "tests" / "cam" / "freecad_plate.py").read_text()
    script = (
        script[: script.index('for line in os.environ["CAM_POSTS"]')]
        + f"""
from PathScripts.PathPostProcessor import PostProcessor
FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Macro").SetString("MacroPath", {str(macros)!r})
for name in ("linuxcnc", "gcomp_linuxcnc"):
    post = PostProcessor.load(name)
    post.export(chain, os.path.join({str(tmp_path)!r}, name + ".nc"), "--no-show-editor")
print("POSTED")
"""
    )
    (tmp_path / "plate.py").write_text(script)
    env = {**os.environ, "HOME": str(tmp_path)}
    done = subprocess.run(
        ["freecadcmd", str(tmp_path / "plate.py")],
        cwd=tmp_path,
        env=env,
        capture_output=True,
        text=True,
    )
    assert "POSTED" in done.stdout, done.stdout[-2000:] + done.stderr[-2000:]
    nominal, out = (
        (tmp_path / "linuxcnc.nc").read_text(),
        (tmp_path / "gcomp_linuxcnc.nc").read_text(),
    )
    assert "GCOMP" in out and "GCOMP" not in nominal
    assert (
        main(
            [
                str(tmp_path / "linuxcnc.nc"),
                "--machine",
                "example-mill",
                *OFFSETS,
                "-o",
                str(tmp_path / "same.nc"),
                "--quiet",
            ]
        )
        == 0
    )
    same = (tmp_path / "same.nc").read_text()
    blocks = [[x for x in text.splitlines() if not x.startswith("(")] for text in (out, same)]
    assert blocks[0] == blocks[1] and len(blocks[0]) > 20  # comments name the post and the time


@pytest.mark.parametrize("name", ["fusion", "mastercam"])
@pytest.mark.skipif(os.name == "nt", reason="a shell's script")
def test_where_nothing_is_shown_a_refused_file_goes_out_of_the_way(tmp_path, expected, name):
    """So that nobody runs a nominal program that he takes for a corrected one."""
    script = install(tmp_path / "hooks", name)
    good, bad = tmp_path / "good job.nc", tmp_path / "bad job.nc"
    good.write_bytes(PROGRAM)
    bad.write_bytes(BAD)
    assert called(script, good).returncode == 0 and good.read_bytes() == expected
    done = called(script, bad)
    assert done.returncode == 2 and b"X = 450.0000 mm" in done.stderr
    assert not bad.exists() and Path(f"{bad}.not-corrected").read_bytes() == BAD
    assert "X = 450.0000 mm" in Path(f"{bad}.refused.txt").read_text()


def test_fusion_is_told_what_its_post_calls(tmp_path, capfd):
    script = install(tmp_path / "a folder", "fusion")
    said = capfd.readouterr().out
    assert "function onTerminate() {" in said
    assert f'execute({json.dumps(str(script))}, "\\"" + getOutputPath() + "\\"", true, "");' in said
