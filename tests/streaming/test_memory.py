"""A1: memory does not grow with the program. At full length it is measured by benchmarks/streaming.py --memory."""

from __future__ import annotations

import pytest

pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from tests.streaming.yes_host import measure  # noqa: E402

GROWTH_MB = 6.0  # a list of 40,000 lines as the sender has them is more


def test_A1_memory_does_not_grow_with_the_program(tmp_path):
    short, _, taken = measure(5_000, tmp_path, "--no-journal")
    assert taken > 5_000
    long, _, taken = measure(40_000, tmp_path, "--no-journal")
    assert taken > 40_000
    assert long - short < GROWTH_MB


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
