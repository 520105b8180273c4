"""What was found is written down, simulated, and then nothing is left; and what is a fault of an
instrument never reaches a program."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from postproc import effects
from postproc.cli import main
from postproc.machine.file import read_machine
from tests.diagnose import command
from tests.diagnose.command import diagnosed

ROOT = Path(__file__).resolve().parents[2]
STUDER = ROOT / "machines" / "studer-s36"
TESTS = ("positioning:Z", "positioning:X", "ballbar:XZ")


def simulated(folder: Path, machine: str, seed: int, *more: str) -> list[str]:
    files = []
    for k, test in enumerate(TESTS):
        rate = ["--set", "rate=50"] if test.startswith("ballbar") else []
        file = folder / f"{seed}-{k}.csv"
        files += command.simulated([file], [test], machine, seed + k, *rate, *more)
    return files


def test_the_machine_that_was_written_explains_the_real_one_and_itself(tmp_path):
    """Recordings of the real machine, and such as the written one gives on another day, hold
    nothing more for its file; the old file misses the effect in both. So they do of lost motion and
    squareness (test_diagnose.py); circles alone do not part this one from the lag of one axis."""
    effect = "servo_mismatch:XZ:delta_tau_ms=0.8"
    real = simulated(tmp_path, str(STUDER), 10, "--with", effect)
    found = str(tmp_path / "found")
    told = diagnosed(real, str(STUDER), tmp_path / "a.json", "--write-machine", found)
    assert told["verdict"] == "left-out-physics"
    assert {e["name"] for e in written(found)} == {
        e["effect"] for e in told["effects"] if e["status"] == "accepted" and e["kind"] == "machine"
    }
    again = simulated(tmp_path, found, 50)
    for files in (real, again):
        rest = diagnosed(files, found, tmp_path / "b.json")
        assert rest["verdict"] == "nothing-left-out" and not rest["effects"]
    missed = diagnosed(again, str(STUDER), tmp_path / "c.json")
    for was, now in zip(told["effects"], missed["effects"], strict=True):
        assert was["effect"] in {
            now["effect"],
            *(name.partition(":")[0] for name in now["equivalent"]),
        }


def written(folder: str) -> list[dict]:
    import tomllib

    return tomllib.loads((Path(folder) / "machine.toml").read_text()).get("effect", [])


CORRECTED = [n for n in effects.names() if effects.load(n).USE == "compensate"]
LEFT_ALONE = [n for n in effects.names() if effects.load(n).USE != "compensate"]


def machine_with(folder: Path, name: str) -> Path:
    """The Studer with an effect in its file, every parameter large."""
    module = effects.load(name)
    axis = {"axis": "Z", "pair": "XZ", "all": ""}[module.PER]
    target = folder / name
    target.mkdir()
    for file in STUDER.iterdir():
        if file.is_file():
            (target / file.name).write_bytes(file.read_bytes())
    lines = ["", "[[effect]]", f'name = "{name}"', f'axis = "{axis}"']
    lines += [
        f"{key} ="
        f" {1.0 if key in ('along', 'across', 'arm', 'turn', 'lever', 'file', 'passages') else 40.0}"  # noqa: E501
        for key in module.PARAMETERS
    ]
    toml = target / "machine.toml"
    toml.write_text(toml.read_text() + "\n".join([*lines, 'source = "a test"', ""]))
    return target


def compensated(folder: Path, machine: Path) -> bytes:
    program, out = folder / "p.nc", folder / f"{machine.name}.out.nc"
    program.write_text("G0 X60 Z60\nG1 X200 Z300 F500\nG1 X80 Z120\nG1 X240 Z400\nM2\n")
    assert main([str(program), "--machine", str(machine), "-o", str(out)]) == 0
    head, _, blocks = out.read_bytes().partition(b"\n")
    assert head.startswith(b"(GCOMP")  # it names the machine's files
    return blocks


@pytest.mark.parametrize("name", LEFT_ALONE)
def test_a_program_is_the_same_with_and_without_what_is_not_to_be_compensated(tmp_path, name):
    """Byte by byte, for every effect of an instrument, of data, and of the machine that only a
    simulator may use."""
    machine = machine_with(tmp_path, name)
    assert read_machine(machine).effects[0].name == name
    assert compensated(tmp_path, machine) == compensated(tmp_path, STUDER)


@pytest.mark.parametrize("name", ["backlash", "scale"])
def test_the_test_before_can_fail(tmp_path, name):
    assert name in CORRECTED
    machine = machine_with(tmp_path, name)
    assert compensated(tmp_path, machine) != compensated(tmp_path, STUDER)


@pytest.mark.parametrize("name", LEFT_ALONE)
def test_its_deviation_is_no_part_of_the_model_that_is_inverted(tmp_path, name):
    machine, bare = read_machine(machine_with(tmp_path, name)), read_machine(STUDER)
    place, side = (
        np.random.default_rng(1).uniform(5, 160, (2, 50)),
        np.where(np.arange(100).reshape(2, 50) % 2, 1.0, -1.0),
    )
    assert np.array_equal(machine.deviation(place, side), bare.deviation(place, side))


def test_a_machine_says_of_which_names_its_effects_were_not_distinguished(tmp_path, capsys):
    """Circles alone do not part lost motion from friction: what is written says so, and so does the
    command."""
    circle, found = str(tmp_path / "c.csv"), tmp_path / "found"
    how = [
        "--test",
        "ballbar:XZ",
        "--machine",
        str(STUDER),
        "--with",
        "backlash:Z:size_um=9",
        "--noise",
        "0.3",
    ]
    assert main(["simulate", *how, "-o", circle, "--quiet"]) == 0
    out = ["--json", str(tmp_path / "a.json"), "--write-machine", str(found)]
    assert main(["diagnose", circle, "--machine", str(STUDER), *out]) == 0
    (effect,) = json.loads((tmp_path / "a.json").read_text())["effects"]
    assert effect["effect"] == "backlash" and effect["equivalent"]
    others = ", ".join(effect["equivalent"])
    assert f"# not told apart from {others}:" in (found / "machine.toml").read_text()
    assert f"backlash:Z is written, and {others} would explain" in capsys.readouterr().err
    assert read_machine(found).effects[0].name == "backlash"
