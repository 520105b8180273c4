"""`gcomp stream` as a process with the other protocols, on a pseudo-terminal (A1, A14, A16, A18 of
design/streaming.md)."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from postproc.commands.stream.options import frame as frame_of
from postproc.errors import UsageError
from tests.streaming.models_dnc import DncModel
from tests.streaming.models_marlin import MarlinModel
from tests.streaming.models_smoothie import SmoothieModel
from tests.streaming.models_tinyg import TinyGModel
from tests.streaming.pty_host import PtyHost

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(
    not hasattr(os, "openpty"), reason="there are no pseudo-terminals here"
)
ROWS = ["G21", "G90", *(f"G1 X{i % 9}.5 Y{i % 7}.25 F6000" for i in range(60))]
WANT = [row.replace(" ", "") for row in ROWS]


def stream(folder: Path, host: PtyHost, dialect: str, *options: str):
    job = folder / "job.nc"
    job.write_text("\n".join(ROWS) + "\n")
    command = [
        sys.executable,
        "-m",
        "postproc",
        "stream",
        str(job),
        "--machine",
        "perfect",
        "--dialect",
        dialect,
        "--port",
        host.path,
        "--journal",
        str(folder / "job.journal"),
        *options,
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=ROOT)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize(
    ("protocol", "dialect", "model"),
    [
        ("auto", "marlin", MarlinModel),
        ("auto", "grbl", SmoothieModel),
        ("dnc", "fanuc-mill", DncModel),
    ],
)
def test_A19_compact_is_refused_where_a_point_or_a_word_may_be_missed(
    tmp_path, protocol, dialect, model
):
    """X10. without its point is 10 um on a Fanuc that counts increments; G1 left out is no command
    on Marlin, and M109 without its S waits for nothing."""
    with PtyHost(model()) as host:
        status, _, said = stream(tmp_path, host, dialect, "--protocol", protocol, "--compact")
    assert status == 2 and "--compact" in said and not (tmp_path / "job.journal").exists()


@pytest.mark.parametrize(
    ("protocol", "dialect", "model"),
    [
        ("auto", "marlin", MarlinModel),
        ("auto", "grbl", SmoothieModel),
        ("auto", "grbl", TinyGModel),
        ("g2core", "grbl", lambda: TinyGModel(g2=True)),
    ],
    ids=["marlin", "smoothieware", "tinyg", "g2core"],
)
def test_A1_A16_A18_a_job_from_the_greeting_to_done(tmp_path, protocol, dialect, model):
    with PtyHost(model(), speed=2.0) as host:
        status, out, err = stream(tmp_path, host, dialect, "--protocol", protocol)
    assert status == 0, err
    executed = [row.replace(" ", "") for row in host.model.executed]
    begin = executed.index("G21")
    assert executed[begin : begin + len(WANT)] == WANT
    assert '"outcome": "done"' in out and "Traceback" not in err


def test_A14_a_drip_feed_ends_as_sent(tmp_path):
    model = DncModel(
        baud=0, rx=8192, high=8000, rate=20000.0, begins=6.0
    )  # not before the port is open: what comes before is dropped
    with PtyHost(model) as host:
        status, out, err = stream(tmp_path, host, "fanuc-mill", "--protocol", "dnc")
        for _ in range(100):
            if model.ended:
                break
            time.sleep(0.05)
    assert status == 17, err
    assert [row.replace(" ", "") for row in model.received] == WANT and model.early == 0
    assert "tells nothing of what became of them" in err
    told = [json.loads(row) for row in out.splitlines()]
    waited = [row for row in told if row.get("state") == "waiting for DC1"]
    assert waited and not any(row["bytes"] for row in waited)
    size = len("%\n%\n") + sum(len(row) + 1 for row in ROWS)
    assert f"{len(ROWS)} lines, {size} bytes were sent" in told[-1]["message"]


class Options:
    def __init__(self, protocol: str, baud: int | None = None, frame: str | None = None):
        self.protocol, self.baud, self.frame = protocol, baud, frame


@pytest.mark.parametrize(
    ("protocol", "frame", "expected", "baud"),
    [
        ("auto", None, (8, "N", 1), 115200),
        ("dnc", None, (7, "E", 2), 4800),
        ("dnc-haas", None, (7, "E", 1), 9600),
        ("dnc-siemens", "7o1", (7, "O", 1), 9600),
        ("grbl", None, (8, "N", 1), 115200),
    ],
)
def test_A14_the_frame_is_the_controls_unless_it_is_said(protocol, frame, expected, baud):
    options = Options(protocol, frame=frame)
    assert (frame_of(options), options.baud) == (expected, baud)


@pytest.mark.parametrize("frame", ["8", "9N1", "7X1", "8N3", "7E22"])
def test_a_frame_that_is_none_is_refused(frame):
    with pytest.raises(UsageError):
        frame_of(Options("auto", frame=frame))
