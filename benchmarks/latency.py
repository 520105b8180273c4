"""How long a line takes that comes alone: the filter by itself, and with the wire lines that `gcomp
stream -` makes of it.

    python benchmarks/latency.py [--lines 1000] [--passes 5] [--json FILE]

The programs are those of files.py: turning on the map of studer-s36, surfacing and arcs on the mill
of machine.py, whose 18 components and three squareness errors make 21. Every line is fed by itself,
as it comes through a pipe; what is told is the time per line fed and per line that came out, of
each line the least of --passes passes, so that other processes on the computer count less. Nothing
here passes or fails: the table is the result.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

import files  # noqa: E402
import machine as mill  # noqa: E402

from postproc.filter import Filter, setup_of  # noqa: E402
from postproc.machine.file import read_machine  # noqa: E402
from postproc.nc import dialects  # noqa: E402
from postproc.streaming.protocols.grbl import Grbl  # noqa: E402
from postproc.streaming.source import Source  # noqa: E402

WARM = 50  # lines before the first that counts
ROWS = (("b", "studer-s36", "turning"), ("a", "mill", "surfacing"), ("c", "mill", "arcs"))


def timed(
    feed: Callable[[bytes], object], count: Callable[[object], int], lines: list[bytes]
) -> np.ndarray:
    """(n, 2): CPU seconds of each line, and how many lines came out."""
    rows = []
    for line in lines:
        begun = time.perf_counter()
        out = feed(line)
        rows.append((time.perf_counter() - begun, count(out)))
    return np.array(rows[WARM:])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--lines", type=int, default=1000, help="lines of each program (default %(default)s)"
    )
    parser.add_argument(
        "--passes", type=int, default=5, help="times that each is fed (default %(default)s)"
    )
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="also write all figures to this file"
    )
    options = parser.parse_args()
    print(
        "| program | machine | way | lines | ms a line: median | 99 % | ms a line out: median | 99"
        " % | longest |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    figures = []
    with tempfile.TemporaryDirectory(prefix="gcomp-latency-") as place:
        mill.write_machine(Path(place) / "mill")
        for name, which, title in ROWS:
            folder = Path(place) / "mill" if which == "mill" else HERE.parent / "machines" / which
            n = options.lines + WARM
            files.write_program(name, Path(place) / f"{name}.nc", 5 * n if name == "c" else n)
            lines = (Path(place) / f"{name}.nc").read_bytes().splitlines(keepends=True)[:n]
            for way in ("filter", "stream"):
                model = read_machine(folder)
                rows = np.zeros((0, 2))
                for _ in range(max(1, options.passes)):
                    filter_ = Filter(model, dialects.load("linuxcnc"), setup_of(model))
                    if way == "filter":
                        again = timed(filter_.feed, lambda out: out.count(b"\n"), lines)
                    else:
                        again = timed(
                            Source(filter_, Grbl().prepare, sampled=True).feed, len, lines
                        )
                    rows = np.minimum(rows, again) if len(rows) else again
                each, out = rows[:, 0] * 1e3, rows[rows[:, 1] > 0]
                per = np.repeat(out[:, 0] / out[:, 1], out[:, 1].astype(int)) * 1e3
                row = {
                    "program": title,
                    "machine": which,
                    "way": way,
                    "lines": len(rows),
                    "median": float(np.median(each)),
                    "p99": float(np.percentile(each, 99)),
                    "median_out": float(np.median(per)),
                    "p99_out": float(np.percentile(per, 99)),
                    "longest": float(each.max()),
                }
                figures.append(row)
                texts = [f"{v:.3f}" if isinstance(v, float) else str(v) for v in row.values()]
                print("| " + " | ".join(texts) + " |", flush=True)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
