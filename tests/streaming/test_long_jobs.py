"""A1 at length: 10,000 lines byte for byte, and memory that does not grow with the program.

At a million lines memory is measured by benchmarks/streaming.py --memory.
"""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from tests.streaming.yes_host import ROOT, YesHost, measure, rows, send  # noqa: E402

GROWTH_MB = 6.0  # a list of 40,000 lines as the sender has them is more


@pytest.mark.parametrize("options", [(), ("--simple",)], ids=["counting", "simple"])
def test_A1_ten_thousand_compensated_lines_are_those_of_the_file(tmp_path, options):
    (tmp_path / "job.nc").write_text("".join(rows(10_000)))
    with YesHost(keep=True) as host:
        send(host, tmp_path, *options)
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "postproc",
            "--machine",
            "example-mill",
            "--dialect",
            "grbl",
            "--offset",
            "G54=X0,Y0,Z-200",
            "--start",
            "X0,Y0,Z-200",
            "job.nc",
        ],
        cwd=tmp_path,
        capture_output=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    file = [row for row in done.stdout.split(b"\n") if row and not row.startswith(b"(")]
    assert len(file) > 10_000 and file != [row.encode().strip() for row in rows(10_000)]
    assert [row for row in host.received if row and not row.startswith(b"$")] == file


@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="peak memory as Linux tells it")
def test_A1_memory_does_not_grow_with_the_program(tmp_path):
    short, _, taken = measure(5_000, tmp_path, "--no-journal")
    assert taken > 5_000
    long, _, taken = measure(40_000, tmp_path, "--no-journal")
    assert taken > 40_000
    assert 10.0 < short and long - short < GROWTH_MB


def test_what_a_kept_line_costs():
    """The test above can fail: so much is one line of the sender, kept."""
    import tracemalloc

    from postproc.streaming.lines import WireLine

    tracemalloc.start()
    kept = [
        WireLine(
            i,
            i,
            0,
            b"G1 X%d.000 Y1.000 Z2.000" % i,
            (i + 0.1, i + 0.2, i + 0.3),
            (i + 0.4, i + 0.5, i + 0.6),
            i + 0.7,
            i + 0.8,
        )
        for i in range(1000)
    ]
    size = tracemalloc.get_traced_memory()[0] / len(kept)
    tracemalloc.stop()
    assert 35_000 * size > 2 * GROWTH_MB * 1e6
