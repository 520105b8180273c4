"""The command run as a process: what its tests share."""

from __future__ import annotations

import contextlib
import os
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pty = pytest.importorskip("pty", reason="pipes, modes and signals as POSIX has them")
ROOT = Path(__file__).resolve().parents[1]
PROGRAM = b"(part)\nG90 G21\nG0 X20. Z10.\nG1 X40. Z50. F100\nM30\n"
FAULTY = b"(part)\nG90 G21\nG0 X20. Z10.\nG1 X400. Z50. F100\nM30\n"
GRINDER = ("--machine", "studer-s36")
# As the console script runs it; without a blank, at which a shell would split it.
COMMAND = (sys.executable, "-c", "__import__('postproc.entry').entry.program()")
PATIENCE = 20.0  # s


@pytest.fixture
def place(tmp_path):
    """A folder to work in, with a folder for temporary files inside that must be empty
    afterwards."""
    for name in ("home", "temporary"):
        (tmp_path / name).mkdir()
    (tmp_path / "part.nc").write_bytes(PROGRAM)
    (tmp_path / "faulty.nc").write_bytes(FAULTY)
    yield tmp_path
    assert not list((tmp_path / "temporary").iterdir())
    assert not list(tmp_path.rglob("*.part"))


def surroundings(place: Path) -> dict[str, str]:
    return {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "HOME": str(place / "home"),
        "XDG_CONFIG_HOME": str(place / "home"),
        "TMPDIR": str(place / "temporary"),
        "LC_ALL": "C.UTF-8",
    }


class Ran:
    """What a run left: status, standard output (bytes), standard error (text)."""

    def __init__(self, status: int, out: bytes, err: bytes):
        self.status, self.out, self.err = status, out, err.decode("utf-8", "replace")
        assert "Traceback" not in self.err, self.err
        assert status >= 0, f"killed by signal {-status}"


def gcomp(place: Path, *arguments: str, input: bytes | None = None) -> Ran:
    done = subprocess.run(
        [*COMMAND, *arguments],
        input=input,
        stdin=None if input is not None else subprocess.DEVNULL,
        capture_output=True,
        cwd=place,
        env=surroundings(place),
        timeout=PATIENCE,
    )
    return Ran(done.returncode, done.stdout, done.stderr)


def in_shell(place: Path, line: str) -> Ran:
    """`line` with $GCOMP for the command."""
    done = subprocess.run(
        ["sh", "-c", line],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        cwd=place,
        timeout=PATIENCE,
        env={**surroundings(place), "GCOMP": " ".join(COMMAND)},
    )
    return Ran(done.returncode, done.stdout, done.stderr)


@contextlib.contextmanager
def started(place: Path, *arguments: str):
    process = subprocess.Popen(
        [*COMMAND, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        bufsize=0,
        cwd=place,
        env=surroundings(place),
        # ignored in jobs of a background shell
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        process.wait(PATIENCE)
        for stream in filter(None, (process.stdin, process.stdout, process.stderr)):
            with contextlib.suppress(OSError):
                stream.close()


def answer(process: subprocess.Popen) -> bytes:
    """What comes next on standard output, as far as whole lines; b"" at its end."""
    got, until = b"", time.monotonic() + PATIENCE
    while not got.endswith(b"\n"):
        ready, _, _ = select.select([process.stdout], [], [], max(0.0, until - time.monotonic()))
        assert ready, f"no answer after {PATIENCE} s, only {got!r}"
        more = os.read(process.stdout.fileno(), 1 << 16)
        if not more:
            return got
        got += more
    return got


def ended(process: subprocess.Popen) -> Ran:
    process.stdin.close()
    process.stdin = None
    out, err = process.communicate(timeout=PATIENCE)
    return Ran(process.returncode, out, err)


def zigzag(lines: int) -> bytes:
    """A program of so many motions, 25 bytes each or so."""
    return b"G90 G21\nG0 X20. Z10.\nG1 F500\n" + b"".join(
        b"X%d.%03d Z%d.%03d\n" % (20 + i % 50, i % 1000, 10 + i % 70, (7 * i) % 1000)
        for i in range(lines)
    )


@pytest.fixture(scope="module")
def corrected(tmp_path_factory) -> bytes:
    """The corrected PROGRAM, which every way of asking for it must give."""
    place = tmp_path_factory.mktemp("corrected")
    for name in ("home", "temporary"):
        (place / name).mkdir()
    ran = gcomp(place, *GRINDER, input=PROGRAM)
    assert ran.status == 0
    assert ran.out.startswith(b"(part)\nG90 G21\n(GCOMP ")
    assert ran.out.endswith(b"\nM30\n")
    return ran.out


def refused(ran: Ran, *says: str) -> None:
    """Status 2, nothing on standard output, one message that says all this, in letters that a
    terminal shows."""
    assert (ran.status, ran.out) == (2, b"")
    assert len(re.findall("^gcomp: ", ran.err, re.MULTILINE)) == 1
    for part in says:
        assert part in ran.err
    assert not [c for c in ran.err if ord(c) < 32 and c != "\n"]
