"""`gcomp stream --expand`: loops and subprograms are written out and sent, and every wire line
knows the line written by hand."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.stream_process import ROOT, model, sent_rows, stream  # noqa: E402

MACHINE = ("--machine", "example-mill", "--dialect", "linuxcnc", "--expand")
LOOP = """G90 G21 G94 G17 G54
G0 X0 Y0 Z20
#1 = 0
o100 while [#1 LT 5]
G1 X[#1 * 10] Y30 Z10 F3000
o200 call [#1]
#1 = [#1 + 1]
o100 endwhile
G0 Z20
M2
"""
SUB = "o200 sub\nG1 Y[#1 + 40.5]\nG91 G1 X1\nG90\no200 endsub\n"


@pytest.fixture
def job(place):
    (place / "job.nc").write_text(LOOP)
    (place / "200.ngc").write_text(SUB)
    return place


def rows_of_file(folder) -> list[str]:
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "postproc",
            *MACHINE,
            "--offset",
            "G54=X0,Y0,Z-200",
            "--start",
            "X0,Y0,Z0",
            "job.nc",
        ],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    return [row.replace(" ", "") for row in done.stdout.split("\n") if row and row[0] not in "(;"]


def test_A1_A17_what_is_written_out_arrives_and_knows_its_source(job):
    with PtyHost(model(), speed=4.0) as host:
        status, _, err = stream(job, host, "job.nc", machine=MACHINE)
    assert status == 0, err
    assert sent_rows(host) == rows_of_file(job) and len(sent_rows(host)) > 20
    sent = [
        entry
        for entry in map(json.loads, (job / "job.nc.journal").read_text().splitlines())
        if "sent" in entry
    ]
    ours = LOOP.split("\n") + SUB.split("\n")
    feeds = [entry for entry in sent if "F3000" in entry["text"] and not entry["piece"]]
    assert [entry["source"] for entry in feeds] == [5] * 5
    assert all(
        "Y[#1 + 40.5]" in ours[len(LOOP.split("\n")) + entry["source"] - 1]
        for entry in sent
        if "Y40.5" in entry["text"]
    )
    assert sent[-1]["source"] == 10
    assert all(
        ("200.ngc" in entry.get("file", "")) == ("Y40.5" in entry["text"] or "G91" in entry["text"])
        for entry in feeds + [entry for entry in sent if "Y40.5" in entry["text"]]
    )
    status, _, err = stream(
        job, None, "job.nc", "--resume-from", "job.nc.journal", "--port", "x", machine=MACHINE[:-1]
    )
    assert status == 2 and "written out" in err


def test_A18_a_pipe_is_read_first(job):
    with PtyHost(model(), speed=4.0) as host, open(job / "job.nc") as source:
        status, _, err = stream(
            job, host, "-", "--library", ".", "--no-journal", machine=MACHINE, stdin=source
        )
    assert status == 0, err
    assert sent_rows(host) == rows_of_file(job)


def test_A5_a_refused_line_is_named_as_it_was_written(job):
    (job / "200.ngc").write_text(SUB.replace("G91 G1 X1", "G1 X1 H7"))
    with PtyHost(model()) as host:
        status, _, err = stream(job, host, "job.nc", machine=("--machine", "perfect", *MACHINE[2:]))
    assert status == 10 and "source line 3 of " in err and "200.ngc" in err and "H7" in err, err


def test_a_fault_is_reported_at_the_line_written_by_hand_and_before_the_first_byte(job):
    (job / "job.nc").write_text(LOOP.replace("#1 * 10", "#1 * 1000"))
    with PtyHost(model()) as host:
        status, _, err = stream(job, host, "job.nc", machine=MACHINE)
    assert status == 2 and "job.nc:5" in err and not sent_rows(host), err


def test_relative_moves_begin_where_the_controller_stands(job):
    """Written out from the controller's own place and modes, not from those that a program begins
    with."""
    (job / "job.nc").write_text("#1 = #5420\nG90 G21 G94 G17 G54\nG1 X[#1 + 1] Y2 Z20 F3000\nM2\n")
    made = model()
    made.place, made.target = [50.0, 60.0, -170.0], [50.0, 60.0, -170.0]
    with PtyHost(made, speed=4.0) as host:
        status, _, err = stream(job, host, "job.nc", machine=("--machine", "perfect", *MACHINE[2:]))
    assert status == 0, err
    assert [row for row in sent_rows(host) if row.startswith("G1")] == ["G1X51.Y2Z20F3000"]
