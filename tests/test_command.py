"""The command as a user, a slicer and a pipe meet it: run as a process, judged by what it writes
where, and by what it refuses to write."""

# ruff: noqa: F811 (fixtures are imported and named again as arguments)

from __future__ import annotations

import os
import re
import stat
import subprocess

import pytest

from postproc.cli import main
from tests.command_process import (
    COMMAND,
    FAULTY,
    GRINDER,
    PATIENCE,
    PROGRAM,
    Ran,
    corrected,  # noqa: F401
    gcomp,
    in_shell,
    place,  # noqa: F401
    pty,
    refused,
    surroundings,
)

MILL = ("--kind", "mill", "--control", "haas", "--squareness", "C0Y=50") + tuple(
    word for x in "XYZ" for word in ("--travel", f"{x}=0,300")
)

# -- where it goes ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ("part.nc", *GRINDER),
        (*GRINDER, "part.nc"),
        ("compensate", *GRINDER, "part.nc"),
        (*GRINDER, "-o", "-", "part.nc"),
    ],
)
def test_a_file_goes_to_standard_output(place, corrected, arguments):
    ran = gcomp(place, *arguments)
    assert (ran.status, ran.out) == (0, corrected)
    assert "motions changed" in ran.err
    assert (place / "part.nc").read_bytes() == PROGRAM


def test_dash_is_standard_input(place, corrected):
    assert gcomp(place, *GRINDER, "-", input=PROGRAM).out == corrected


def test_an_output_file_is_written_and_nothing_else(place, corrected):
    before = sorted(p.name for p in place.iterdir())
    ran = gcomp(place, "part.nc", *GRINDER, "-o", "out.nc")
    assert (ran.status, ran.out) == (0, b"")
    assert (place / "out.nc").read_bytes() == corrected
    assert sorted(p.name for p in place.iterdir()) == sorted([*before, "out.nc"])
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE((place / "out.nc").stat().st_mode) == 0o666 & ~mask


def test_the_output_may_be_the_input(place, corrected):
    assert gcomp(place, "part.nc", *GRINDER, "-o", "part.nc", "--force").status == 0
    assert (place / "part.nc").read_bytes() == corrected


def test_in_place_keeps_the_nominal_program_the_mode_and_the_link(place, corrected):
    (place / "real").mkdir()
    file, link = place / "real" / "job.nc", place / "link.nc"
    file.write_bytes(PROGRAM)
    file.chmod(0o640)
    link.symlink_to("real/job.nc")
    for backup in ("job.nc.bak", "job.nc.bak2"):
        ran = gcomp(place, *GRINDER, "--in-place", "link.nc")
        assert (ran.status, ran.out) == (0, b"")
        assert file.read_bytes() == corrected
        assert stat.S_IMODE(file.stat().st_mode) == 0o640
        assert link.is_symlink()
        assert backup in ran.err
        assert (file.parent / backup).read_bytes() == PROGRAM
        assert stat.S_IMODE((file.parent / backup).stat().st_mode) == 0o640
        file.write_bytes(PROGRAM)
    assert sorted(p.name for p in file.parent.iterdir()) == ["job.nc", "job.nc.bak", "job.nc.bak2"]


def test_as_slicers_call_it_the_path_stands_last_and_nothing_is_said(place, corrected):
    ran = gcomp(place, *GRINDER, "--in-place", "--quiet", str(place / "part.nc"))
    assert (ran.status, ran.out, ran.err) == (0, b"", "")
    assert (place / "part.nc").read_bytes() == corrected


def test_dry_run_writes_nothing(place):
    before = {p.name: p.stat().st_mtime_ns for p in place.iterdir()}
    ran = gcomp(place, *GRINDER, "--dry-run", "part.nc", "-o", "out.nc")
    assert ran.status == 0
    assert re.fullmatch(
        rb"2 of 2 motions changed, \d+ blocks added, largest correction \d+\.\d um, tolerance 0\.5"
        rb" um\n",
        ran.out,
    )
    assert {p.name: p.stat().st_mtime_ns for p in place.iterdir()} == before


def test_a_machine_without_errors_changes_nothing(place):
    ran = gcomp(place, "--machine", "perfect", "part.nc")
    assert (ran.status, ran.out) == (0, PROGRAM)
    assert "nothing to change" in ran.err


def test_an_empty_program_gives_an_empty_program(place):
    (place / "empty.nc").write_bytes(b"")
    ran = gcomp(place, *GRINDER, "empty.nc", "-o", "out.nc")
    assert (ran.status, (place / "out.nc").read_bytes()) == (0, b"")
    ran = gcomp(place, *GRINDER)
    assert (ran.status, ran.out) == (0, b"")


# -- refusals --------------------------------------------------------------------------------------


def test_a_faulty_program_writes_nothing(place):
    refused(
        gcomp(place, *GRINDER, input=FAULTY),
        "<stdin>:4: X = 200.0000 mm",
        "0 to 170 mm",
        "\n    G1 X400. Z50. F100\n",
        "--outside clamp",
    )
    (place / "out.nc").write_bytes(b"(GCOMP 0.1 old)")
    refused(gcomp(place, *GRINDER, "faulty.nc", "-o", "out.nc"), "faulty.nc:4: ")
    assert (place / "out.nc").read_bytes() == b"(GCOMP 0.1 old)"
    refused(gcomp(place, *GRINDER, "--quiet", "--in-place", "faulty.nc"), "faulty.nc:4: ")
    assert (place / "faulty.nc").read_bytes() == FAULTY
    assert not (place / "faulty.nc.bak").exists()


def test_a_second_pass_is_refused(place, corrected):
    (place / "once.nc").write_bytes(corrected)
    refused(
        gcomp(place, *GRINDER, "once.nc"), "once.nc:3: ", "corrected already", "nominal program"
    )


@pytest.mark.parametrize(
    "data",
    [
        b"\x7fELF\x02\x01\x01" + bytes(300),
        bytes(range(256)) * 8,
        b"\x1b[31mG1 X1.\n",
        b"PK\x03\x04" + b"\x00\xff" * 50,
        b"\xff\xfeG\x001\x00",
    ],
    ids=["program", "all bytes", "escape", "zip", "UTF-16"],
)
def test_a_binary_file_is_refused_without_spilling_it(place, data):
    (place / "binary").write_bytes(data)
    refused(gcomp(place, *GRINDER, "binary"), "binary:1: ")


def test_a_line_of_two_megabytes_is_refused(place):
    (place / "long.nc").write_bytes(b"G1 " + b"X1." * 700_000 + b"\n")
    ran = gcomp(place, *GRINDER, "long.nc")
    refused(ran, "long.nc:1: ", "1,000,000 characters")
    assert len(ran.err) < 1000


def test_what_there_is_not_is_answered_with_what_there_is(place):
    refused(
        gcomp(place, "--machine", "studer", "part.nc"),
        "'studer'",
        "perfect",
        "studer-s36",
        "path of a machine folder",
    )
    refused(
        gcomp(place, *GRINDER, "--dialect", "klingon", "part.nc"),
        "'klingon'",
        "fanuc-lathe",
        "linuxcnc",
    )
    refused(gcomp(place, *GRINDER, "no.nc"), "no.nc", "No such file")
    refused(gcomp(place, *GRINDER, "home"), "home is a folder, not a program")
    refused(gcomp(place, "--machine", str(place / "home"), "part.nc"), "has no machine.toml")


def test_an_output_that_can_not_be_written_is_named_as_it_was_given(place):
    ran = gcomp(place, *GRINDER, "part.nc", "-o", "nowhere/out.nc")
    assert ran.status in (1, 2)
    assert "nowhere" in ran.err
    assert ".part" not in ran.err


@pytest.mark.parametrize(
    ("words", "path"),
    [
        (("part.nc", "-o", "home/out.nc"), "home/out.nc"),
        (("machines", "new", "m", *MILL, "-o", "home/m"), "home/m"),
    ],
)
def test_where_nobody_may_write_the_file_is_named_as_it_was_to_be(
    monkeypatch, tmp_path, capfd, words, path
):
    """Root may write anywhere: what the system would answer is made up."""

    def denied(*_, prefix, dir, suffix="", **__):
        raise PermissionError(13, "Permission denied", f"{dir}/{prefix}ab3_x9kz{suffix}")

    monkeypatch.chdir(tmp_path)
    (tmp_path / "home").mkdir()
    (tmp_path / "part.nc").write_bytes(PROGRAM)
    for maker in ("mkstemp", "mkdtemp", "TemporaryDirectory"):
        monkeypatch.setattr(f"tempfile.{maker}", denied)
    grinder = () if words[0] == "machines" else GRINDER
    assert main([*words, *grinder]) == 1
    said = capfd.readouterr().err.splitlines()
    assert said[-2] == f"gcomp: {tmp_path / path} can not be written: Permission denied"
    assert said[-1] == "    name a place that you may write to, with room on its disk"


def test_an_output_that_is_a_folder_is_named_not_the_program(place):
    ran = gcomp(place, *GRINDER, "part.nc", "-o", "home")
    assert ran.status in (1, 2)
    assert "home" in ran.err
    assert "part.nc" not in ran.err


@pytest.mark.parametrize(
    "program",
    [
        ("--in-place",),
        ("--in-place", "-"),
        ("--in-place", "part.nc", "-o", "out.nc"),
        ("--unbuffered", "part.nc", "-o", "out.nc"),
        ("--unbuffered", "--dry-run", "part.nc"),
    ],
)
def test_options_that_exclude_each_other_are_refused(place, program):
    refused(gcomp(place, *GRINDER, *program), program[0])
    assert (place / "part.nc").read_bytes() == PROGRAM


def test_without_a_program_it_says_how(place):
    ran = in_shell(place, "$GCOMP --machine studer-s36 <&-")
    refused(ran, "no program", "gcomp --machine NAME FILE")
    try:
        master, terminal = pty.openpty()
    except OSError as error:  # a container without /dev/pts
        pytest.skip(f"no terminal to be had: {error}")
    try:
        done = subprocess.run(
            [*COMMAND, *GRINDER],
            stdin=terminal,
            capture_output=True,
            cwd=place,
            env=surroundings(place),
            timeout=PATIENCE,
        )
    finally:
        os.close(master), os.close(terminal)
    refused(Ran(done.returncode, done.stdout, done.stderr), "no program")
