"""gcomp simulate as a person runs it."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import numpy as np
import pytest
from pytest import approx

from postproc.cli import main
from postproc.recordings import Source, read
from postproc.simulate import instruments
from postproc.simulate.experiments import TESTS

from .samples import ROOT

STUDER = str(ROOT / "machines" / "studer-s36")


def gcomp(*arguments: str, data: bytes = b"") -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-m", "postproc", *arguments],
        input=data,
        capture_output=True,
        cwd=ROOT,
        env=os.environ,
    )


def run(capfd, *arguments: str) -> tuple[int, str, str]:
    status = main(["simulate", *arguments])
    out, err = capfd.readouterr()
    return status, out, err


def recording(path):
    return read(Source(str(path), path.read_bytes()))


def test_a_test_of_its_own_and_its_program(tmp_path, capfd):
    out, program = tmp_path / "z.csv", tmp_path / "z.nc"
    status, text, said = run(
        capfd,
        "--test",
        "positioning:Z,runs=1",
        "--machine",
        STUDER,
        "--noise",
        "0.5",
        "--seed",
        "7",
        "--program-out",
        str(program),
        "-o",
        str(out),
    )
    assert status == 0 and text == "" and "34 rows of laser interferometer" in said
    assert "states no velocity and acceleration" in said
    found = recording(out)
    assert found.kind == "targets" and found.head["seed"] == 7 and found.u == approx(0.5e-3)
    again = tmp_path / "again.csv"
    more = [
        "--machine",
        STUDER,
        "--instrument",
        "laser",
        "--set",
        "along=Z",
        "--set",
        "dwell=3",
        "-o",
        str(again),
    ]
    assert run(capfd, str(program), "--noise", "0.5", "--seed", "7", *more)[0] == 0
    assert recording(again).reading == approx(found.reading, abs=1e-9)


def test_a_corrected_program_leaves_next_to_nothing(tmp_path, capfd):
    """The laser's targets, corrected by gcomp for the very machine: what is left at the nominal
    places is the tolerance."""
    nominal, corrected = tmp_path / "n.nc", tmp_path / "c.nc"
    out = tmp_path / "r.csv"
    test = "positioning:Z,step=30,even=1,runs=1,at_X=85"
    assert (
        run(
            capfd,
            "--test",
            test,
            "--machine",
            STUDER,
            "--program-out",
            str(nominal),
            "-o",
            str(out),
        )[0]
        == 0
    )
    before = recording(out)
    assert (
        main(
            [
                "compensate",
                "--machine",
                STUDER,
                "--outside",
                "clamp",
                str(nominal),
                "-o",
                str(corrected),
                "--quiet",
            ]
        )
        == 0
    )
    status, _, said = run(
        capfd,
        str(corrected),
        "--machine",
        STUDER,
        "--instrument",
        "laser",
        "--set",
        "along=Z",
        "-o",
        str(out),
    )
    assert status == 0 and "this program is corrected" in said
    after = recording(out)
    left = after.reading + after.position("Z") - before.position("Z")
    assert np.abs(before.reading).max() > 5e-3 and np.abs(left).max() < 0.6e-3


def test_more_effects_fewer_columns(tmp_path, capfd):
    out = tmp_path / "r.csv"
    common = [
        "--test",
        "positioning:X,runs=1",
        "--machine",
        "perfect",
        "--test",
        "positioning:X,runs=1,step=50",
    ]
    machine = tmp_path / "m"
    machine.mkdir()
    (machine / "machine.toml").write_text(
        'format = "gcomp-machine/1"\nname = "m"\ncontrol = "linuxcnc"\nchain ='
        ' "w-b-X-t"\n[axes.X]\ntravel = [0.0, 300.0]\nleast_increment = 0.001\nmax_velocity ='
        " 6000\nmax_acceleration = 500\nmax_jerk = 5000\n"
    )
    common[3] = str(machine)
    status, _, said = run(
        capfd,
        *common,
        "--with",
        "backlash:X:size_um=8",
        "--with",
        "scale:X:ppm=10",
        "--without",
        "T,spindle_rpm",
        "--force",
        "X=50",
        "-o",
        str(out),
    )
    assert status == 0 and "states no" not in said
    found = recording(out)
    assert found.reading * 1e3 == approx(
        0.01 * found.position("X") - 4 * found.approach("X"), abs=1e-3
    )
    assert not any(c.startswith("T_") for c in found.columns) and "force_X_N" in found.columns
    assert found.head["with"] == ["backlash:X:size_um=8", "scale:X:ppm=10"]


def test_cycles_are_simulated_when_they_are_written_out(tmp_path, capfd):
    program = tmp_path / "holes.ngc"
    program.write_text(
        "G21 G90 G94 G54 G17\nG0 X0 Y0 Z5\nG82 X10 Y10 Z-5 R1 P2 F300\nX20\nG80\nM2\n"
    )
    common = [
        str(program),
        "--machine",
        "example-mill",
        "--instrument",
        "laser",
        "-o",
        str(tmp_path / "r.csv"),
        "--quiet",
    ]
    assert run(capfd, *common, "--offset", "G54=X0,Y0,Z-100")[0] == 2
    assert run(capfd, *common, "--offset", "G54=X0,Y0,Z-100", "--expand")[0] == 0
    assert recording(tmp_path / "r.csv").position("Z").tolist() == [-105, -105]


def test_readings_beyond_a_table_are_named(tmp_path, capfd):
    program = tmp_path / "p.nc"
    program.write_text("G21 G90 G54\nG1 X0 Z0 F1000\nX344. Z30.\n")
    common = [
        str(program),
        "--machine",
        STUDER,
        "--instrument",
        "log",
        "--set",
        "rate=10",
        "-o",
        str(tmp_path / "r.csv"),
    ]
    assert "X is read beyond its table (0 to 170)" in run(capfd, *common)[2]
    program.write_text("G21 G90 G54\nG1 X0 Z0 F1000\nX340. Z30.\n")
    assert "beyond" not in run(capfd, *common)[2]


def test_it_works_in_a_pipe():
    done = gcomp(
        "simulate",
        "-",
        "--machine",
        "studer-s36",
        "--instrument",
        "log",
        "--set",
        "rate=10",
        "--quiet",
        data=b"G21 G90 G54\nG1 X0 Z0 F1000\nX20. Z30.\n",
    )
    assert (
        done.returncode == 0
        and done.stdout.startswith(b'# format = "gcomp-recording/1"')
        and not done.stderr
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--test", "positioning:Z", "x.nc"], "brings its own program"),
        (["x.nc"], "which instrument"),
        (["x.nc", "--instrument", "eye"], "no instrument 'eye'"),
        (["missing.nc", "--instrument", "log"], "can not be read"),
        (["--test", "positioning:Z", "--tolerance", "1um"], "nothing is corrected"),
        (["--test", "positioning:Z", "--cut-rapids"], "--cut-rapids is for corrections"),
        (["--test", "positioning:Z", "--with", "magic:X"], "no effect 'magic'"),
        (["--test", "positioning:Z", "--with", "backlash:XZ:size_um=1"], "acts on"),
        (["--test", "positioning:Z", "--with", "backlash:X:um=1"], "has no 'um'"),
        (["--test", "positioning:Z", "--with", "backlash:X"], "size_um is missing"),
        (["--test", "positioning:Z", "--with", "bow:X:size_um=3,across=3"], "no number of an axis"),
        (["--test", "positioning:Z", "--with", "sag:Z:size_um=3,along=1.5"], "number of an axis"),
        (["--test", "positioning:Z", "--with", "pitch_shape:Z:degree=12"], "12 is above 9, the"),
        (
            ["--test", "positioning:Z", "--with", "backlash_position:Z:b0_um=3,b1_um=0,degree=7"],
            "degree = 7 is above 6, the highest",
        ),
        (["--test", "positioning:Z", "--without", "T_moon_C"], "no such channel"),
        (["--test", "positioning:Z", "--force", "Y=3"], "no axis of"),
        (["--test", "moon:Z"], "no test 'moon'"),
        (["--test", "positioning:Z", "--program-out", "p.nc", "--noise", "-1"], "below zero"),
        (["--test", "positioning:Z", "--tails", "2"], "no standard deviation"),
        (["--test", "positioning:Z", "--with", "abbe:X:arm_mm=1,turn=1,arm=2"], "not simulated"),
        (["far.nc", "--instrument", "log"], "beyond its travel"),
        (["bad.nc", "--instrument", "log"], "bad.nc:2"),
        (["x.nc", "--program-out", "p.nc", "--instrument", "log"], "of a --test"),
    ],
)
def test_what_makes_no_sense_is_refused_with_a_way_out(
    arguments, message, tmp_path, capfd, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.nc").write_text("G21 G90 G54\nG1 X0 Z0 F1000\nX20. Z30.\n")
    (tmp_path / "far.nc").write_text("G21 G90 G54\nG1 X0 Z0 F1000\nX200. Z900.\n")
    (tmp_path / "bad.nc").write_text("G21 G90 G54\nG1 X0 ?\n")
    status, out, err = run(capfd, *arguments, "--machine", STUDER)
    assert status == 2 and message in err and "Traceback" not in err
    assert out == ""


def test_the_help_names_every_test_and_instrument(capfd):
    _, out, _ = run(capfd, "--help")
    words = re.split(r"[\s,:()]+", out)
    assert {*TESTS, *instruments.names()} <= {*words}


def test_an_instrument_lists_its_settings(capfd):
    status, out, _ = run(capfd, "--test", "ballbar:XZ", "--machine", STUDER, "--set", "help=1")
    assert status == 0 and "rate: Hz" in out
