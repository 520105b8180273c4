"""Receivers that nobody here wrote: gcomp as a process against OctoPrint's virtual printer with its
default faults (A13).

Its faults (plugin settings, simulated_errors): line 100 is asked for again, 105 is asked for and
what is then sent is not answered, 110 is refused without a request, 115 has a bad checksum. Line
105 is counted as received by the printer, and never handled, by its own code (resend_with_timeout);
all others are handled once and in order. Fetched by tests/streaming/fetch_octoprint.sh.
"""

from __future__ import annotations

import json
import os
import queue
import random
import subprocess
import sys
import threading
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gcomp" / "octoprint"
PYTHON = CACHE / "bin" / "python"
MISSING = (
    "OctoPrint is not installed: sh tests/streaming/fetch_octoprint.sh (about 200 MB, in the cache)"
)
pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(not (CACHE / "complete").exists(), reason=MISSING),
    pytest.mark.skipif(not hasattr(os, "openpty"), reason="there are no pseudo-terminals here"),
]
LIMIT = 100.0  # s


@contextmanager
def printer(folder: Path, **settings):
    """Its port, and a list of the commands that it has handled, growing."""
    folder.mkdir()
    process = subprocess.Popen(
        [PYTHON, Path(__file__).with_name("octoprint_host.py"), folder, json.dumps(settings)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert process.stdout is not None and process.stdin is not None
    port: queue.Queue[str] = queue.Queue()
    handled: list[str] = []

    def listen() -> None:
        for line in process.stdout:  # type: ignore[union-attr]
            kind, _, rest = line.rstrip("\n").partition(" ")
            port.put(rest) if kind == "port" else handled.append(rest)

    threading.Thread(target=listen, daemon=True).start()
    try:
        yield port.get(timeout=60), handled
    finally:
        process.stdin.close()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()


def program(n: int) -> list[str]:
    r = random.Random(7)
    rows = ["G21", "G90", "G0 X10.000 Y10.000 Z5.000"]
    rows += [
        f"G1 X{r.uniform(10, 12):.3f} Y{r.uniform(10, 12):.3f} F{r.choice((9000, 6000))}"
        for _ in range(n - len(rows) - 1)
    ]
    return [*rows, "M5"]


def stream(folder: Path, port: str, rows: list[str], *options: str):
    job = folder / "job.gcode"
    job.write_text("\n".join(rows) + "\n")
    command = [
        sys.executable,
        "-m",
        "postproc",
        "stream",
        str(job),
        "--machine",
        "perfect",
        "--dialect",
        "marlin",
        "--port",
        port,
        "--journal",
        str(folder / "job.journal"),
        *options,
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, cwd=ROOT)
    return done.returncode, done.stderr


def of_program(handled: list[str]) -> list[str]:
    """Without what gcomp asks before and behind a job."""
    return [
        text
        for text in handled
        if not text.startswith(("M110", "M113", "M114", "M115", "M400", "M503"))
    ]


def test_A13_a_thousand_lines_past_its_default_faults(tmp_path):
    rows = program(1000)
    with printer(tmp_path / "octoprint") as (port, handled):
        status, said = stream(tmp_path, port, rows)
    assert status == 0, said
    # which it takes and drops, see above
    numbered = [row for n, row in enumerate(rows, 1) if n != 105]
    assert of_program(handled) == numbered


@pytest.mark.parametrize(
    "settings",
    [
        {"okFormatString": "ok N{lastN} P15 B{buffer}"},
        {"brokenResend": True},
        {"okBeforeCommandOutput": True},
        {
            "simulated_errors": [
                "20:resend",
                "21:resend",
                "22:checksum_mismatch",
                "60:missing_lineno",
            ],
            "sendBusy": True,
        },
    ],
    ids=["ADVANCED_OK", "no ok behind a request", "ok before the report", "other faults"],
)
def test_A13_its_other_habits(tmp_path, settings):
    rows = program(130)
    quiet = {"simulated_errors": ["40:resend", "80:checksum_mismatch"]} | settings
    with printer(tmp_path / "octoprint", **quiet) as (port, handled):
        status, said = stream(tmp_path, port, rows)
    assert status == 0, said
    assert of_program(handled) == rows


def test_A13_auto_knows_it(tmp_path):
    rows = program(30)
    with printer(tmp_path / "octoprint") as (port, handled):
        status, said = stream(tmp_path, port, rows, "--protocol", "auto")
    assert status == 0 and "Virtual Marlin" in said, said
    assert of_program(handled) == rows


def test_A10_a_printer_that_goes_away(tmp_path):
    with printer(tmp_path / "octoprint") as (port, _):
        pass
    status, said = stream(tmp_path, port, program(30))
    assert status not in (0, 17) and "Traceback" not in said
