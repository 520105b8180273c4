"""The command on pipes, under signals and on full disks, run as a process: judged by what is
left."""

# ruff: noqa: F811 (fixtures are imported and named again as arguments)

from __future__ import annotations

import os
import signal
import subprocess

import pytest

from tests.command_process import (
    GRINDER,
    answer,
    corrected,  # noqa: F401
    ended,
    gcomp,
    in_shell,
    place,  # noqa: F401
    started,
    zigzag,
)

has_full = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")


def test_a_live_pipe_is_answered_line_by_line_up_to_the_fault(place):
    with started(place, *GRINDER, "--unbuffered") as process:
        said = b""
        for line in (b"(part)\nG90 G21\n", b"G0 X20. Z10.\n", b"G1 X40. F100\n", b"Z50.\n"):
            process.stdin.write(line)
            got = answer(process)
            assert got.endswith(b"\n")
            said += got
        process.stdin.write(b"X30.\nX400.\nX20.\n")
        said += answer(process)
        ran = ended(process)
    before = gcomp(
        place, *GRINDER, input=b"(part)\nG90 G21\nG0 X20. Z10.\nG1 X40. F100\nZ50.\nX30.\n"
    )
    assert said + ran.out == before.out
    assert ran.status == 2
    assert "<stdin>:7: X = 200.0000 mm" in ran.err


def test_half_a_line_waits_for_the_other_half(place):
    with started(place, *GRINDER, "--unbuffered") as process:
        process.stdin.write(b"G0 X20. Z10.\nG0 X2")
        first = answer(process)
        assert b"X2\n" not in first
        process.stdin.write(b"4. Z12.\n")
        assert answer(process).startswith(b"G0 X2")
        assert ended(process).status == 0


@pytest.mark.parametrize("how", [(), ("--unbuffered",), ("-o", "out.nc")])
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
def test_control_c_leaves_nothing_behind(place, how, end):
    """It waits on its pipe, more than a pipe holds already read."""
    before = sorted(p.name for p in place.iterdir())
    with started(place, *GRINDER, *how) as process:
        if "--unbuffered" in how:
            process.stdin.write(b"G0 X20. Z10.\n")
            answer(process)
        else:
            process.stdin.write(zigzag(20_000))
        process.send_signal(end)
        ran = ended(process)
    assert ran.status == 130
    assert "interrupted" in ran.err
    assert ran.out == b""
    assert sorted(p.name for p in place.iterdir()) == before


@pytest.mark.parametrize("how", [(), ("--unbuffered",)])
def test_a_reader_that_goes_away_is_no_fault(place, how):
    (place / "long.nc").write_bytes(zigzag(20_000))
    with started(place, *GRINDER, *how, "long.nc") as process:
        assert os.read(process.stdout.fileno(), 20)
        process.stdout.close()
        process.stdout = None
        ran = ended(process)
    assert ran.status == 141
    assert ran.err == ""


@pytest.mark.parametrize(
    "line",
    [
        "$GCOMP --machine studer-s36 part.nc",
        "$GCOMP --machine studer-s36 --unbuffered part.nc",
        "$GCOMP --machine studer-s36 --verify --quiet part.nc",
    ],
)
def test_without_standard_error_the_program_is_the_same(place, corrected, line):
    """As a service or a window without a console calls it: no message may end up in the program."""
    ran = in_shell(place, f"{line} 2>&-")
    assert (ran.status, ran.out) == (0, corrected)


def test_without_standard_output_there_is_a_message(place, corrected):
    ran = in_shell(place, "$GCOMP --machine studer-s36 part.nc >&-")
    assert ran.status in (1, 2)
    assert "gcomp: " in ran.err
    ran = in_shell(place, "$GCOMP --machine studer-s36 --quiet part.nc -o out.nc >&-")
    assert (ran.status, ran.err) == (0, "")
    assert (place / "out.nc").read_bytes() == corrected


@has_full
def test_a_full_standard_output_is_reported(place):
    for line in (
        "$GCOMP --machine studer-s36 part.nc",
        "$GCOMP machines",
        "$GCOMP --machine studer-s36 --dry-run part.nc",
    ):
        ran = in_shell(place, f"{line} > /dev/full")
        assert ran.status == 1
        assert "No space left" in ran.err


@pytest.fixture
def small_disk(place):
    """A disk of 256 kB; skipped where none can be mounted."""
    disk = place / "disk"
    disk.mkdir()
    done = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(disk)], capture_output=True
    )
    if done.returncode:
        pytest.skip("no disk can be mounted here")
    try:
        yield disk
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def test_a_full_disk_keeps_the_old_output(place, small_disk):
    (place / "long.nc").write_bytes(zigzag(20_000))
    (small_disk / "out.nc").write_bytes(b"(GCOMP 0.1 old)")
    ran = gcomp(place, *GRINDER, "long.nc", "-o", "disk/out.nc")
    assert (ran.status, ran.out) == (1, b"")
    assert "No space left" in ran.err
    assert [p.name for p in small_disk.iterdir()] == ["out.nc"]
    assert (small_disk / "out.nc").read_bytes() == b"(GCOMP 0.1 old)"


def test_a_disk_without_room_for_the_backup_keeps_the_program(place, small_disk):
    """New file and old one fit, a third copy does not: no half a backup may be left for the next
    run to step over."""
    program = zigzag(6_000)
    assert 2 * len(program) < 256 * 1024 < 3 * len(program)
    (small_disk / "job.nc").write_bytes(program)
    ran = gcomp(place, "--machine", "perfect", "--in-place", "disk/job.nc")
    assert ran.status == 1
    assert "No space left" in ran.err
    assert (small_disk / "job.nc").read_bytes() == program
    assert [p.name for p in small_disk.iterdir()] == ["job.nc"]


@has_full
def test_an_output_that_is_a_device_is_written_to(place):
    assert gcomp(place, *GRINDER, "part.nc", "-o", "/dev/null").status == 0
    ran = gcomp(place, *GRINDER, "part.nc", "-o", "/dev/full")
    assert ran.status == 1
    assert "No space left" in ran.err
