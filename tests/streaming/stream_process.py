"""`gcomp stream` as a process on a pseudo-terminal, with the model behind it in real time: what its
tests share."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from postproc.streaming import protocols  # noqa: E402
from tests.streaming.grbl_model import GrblModel  # noqa: E402
from tests.streaming.pty_host import PtyHost  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
MILL = ("--machine", "example-mill", "--dialect", "grbl")
PATIENCE = 60.0  # s
# What asks a late one who it is, line by line: Marlin's begins with an empty one.
ASKS = {row.strip().upper() for poke in protocols.pokes() for row in poke.decode().split("\n")}


def program(n: int = 60, feed: int = 3000) -> str:
    rows = ["(part)", "G90 G21 G94 G17", "G54", "G0 X0 Y0 Z20", f"G1 Z10 F{feed}"]
    rows += [f"G1 X{i % 7 + i / 10:.3f} Y{(i * 3) % 11:.3f} F{feed}" for i in range(n)]
    return "\n".join([*rows, "G0 Z20", "M30", ""])


def model(**how) -> GrblModel:
    made = GrblModel(**how)
    made.stored["G54"] = [0.0, 0.0, -200.0]
    return made


def start(
    place: Path, host: PtyHost | None, *arguments: str, machine=MILL, stdin=subprocess.DEVNULL
):
    port = ("--port", host.path) if host else ()
    return subprocess.Popen(
        [
            sys.executable,
            "-m",
            "postproc",
            "stream",
            *machine,
            *port,
            "--check-first",
            "never",
            *arguments,
        ],
        cwd=place,
        stdin=stdin,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "HOME": str(place),
            "XDG_CONFIG_HOME": str(place),
        },
    )


def stream(place: Path, host: PtyHost | None, *arguments: str, **how) -> tuple[int, str, str]:
    process = start(place, host, *arguments, **how)
    out, err = process.communicate(timeout=PATIENCE)
    assert "Traceback" not in err, err
    return process.returncode, out, err


def wire_rows(place: Path, name: str = "job.nc", *more: str) -> list[str]:
    """What `gcomp` writes to a file, as GRBL takes it."""
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "postproc",
            *MILL,
            "--offset",
            "G54=X0,Y0,Z-200",
            "--start",
            "X0,Y0,Z0",
            *more,
            name,
        ],
        cwd=place,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    return [
        row.replace(" ", "") for row in done.stdout.split("\n") if row and not row.startswith("(")
    ]


def sent_rows(host: PtyHost) -> list[str]:
    """Without orders to the controller, and without what asks a late one who it is."""
    return [row for row in host.model.received if row not in ASKS and not row.startswith("$")]


@contextlib.contextmanager
def running(place: Path, host: PtyHost, after: int, *arguments: str):
    """A job of which `after` lines have arrived."""
    process = start(place, host, *arguments)
    deadline = time.monotonic() + PATIENCE
    while len(sent_rows(host)) < after and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.005)
    assert process.poll() is None, process.communicate()
    try:
        yield process
    finally:
        process.kill()
        process.communicate()
