"""How full the wire is, and how long the machine starves: pieces of 0.1 mm on a real GRBL 1.1h
image at 115,200 baud.

    python benchmarks/link.py --fetch

Every sender sends the same job, an arc in pieces of 0.1 mm, at feeds up to one that the wire can
not carry, to the image in ../shared/receivers, in real time. "ideal" is a loop of twenty lines that
counts characters and does nothing else; "ideal, asking" the same, with the ten reports a second
that gcomp asks for, which cost such a GRBL time; "send-response" one that waits for every answer;
"printcore" is printrun's (PyPI, in the environment that benchmarks/streaming.py --fetch makes),
without what GRBL refuses of it: line numbers, checksums, M105, M110. bytes a second: from the first
byte of the job to the last answer; motion: from the first to the last step pulse; of the feed: the
time that the job takes at its feed, without acceleration, by that. --latency: ms by which answers
come late, as those of a USB bridge do (16 of an FTDI's). Where the simulator could not keep up with
the clock the run is made again. The senders take turns --repeat times; the best and the median of
each are said."""

from __future__ import annotations

import argparse
import math
import os
import select
import statistics
import subprocess
import sys
import tempfile
import time
import tty
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.streaming import CACHE, fetch  # noqa: E402
from tests.streaming import real_grbl  # noqa: E402
from tests.streaming.real_grbl import RECORD, RealGrbl  # noqa: E402

CLOCK = 16e6  # Hz, of the image
STEP, RADIUS = 0.1, 8.0  # mm
WINDOW = 128
BAUD = 115200
SILENCE = 10.0  # s
AGAIN = 5
ASKS = 0.1  # s between two questions of "ideal, asking", as gcomp asks to watch the path
ASKING = "ideal, asking"
SENDERS = ("ideal", ASKING, "gcomp", "gcomp --simple", "send-response", "printcore")


def program(feed: int, seconds: float) -> list[str]:
    """An arc in straight pieces; the feed stands in the first of them."""
    n = int(feed / 60 * seconds / STEP)
    rows = ["G21G90G94", f"G1F{feed}"]
    for i in range(1, n + 1):
        angle = i * STEP / RADIUS
        rows.append(f"G1X{RADIUS * math.sin(angle):.3f}Y{RADIUS - RADIUS * math.cos(angle):.3f}")
    return rows


def bare(port: str, rows: list[str], window: int, every: float = 0.0) -> tuple[float, float]:
    """Count characters up to `window` bytes (0: wait for every answer), and ask for a report every
    so many s (0: never); when the first byte left, when the last answer came."""
    fd = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    tty.setraw(fd)
    heard, waiting, used, i = b"", [], 0, 0
    begun = asked = time.monotonic()
    while i < len(rows) or waiting:
        while i < len(rows):
            size = len(rows[i]) + 1
            if waiting and (used + size > window):
                break
            os.write(fd, rows[i].encode() + b"\n")
            waiting.append(size)
            used, i = used + size, i + 1
        if every and time.monotonic() - asked >= every:
            asked = time.monotonic()
            os.write(fd, b"?")
        if not select.select([fd], [], [], every or SILENCE)[0]:
            if every:
                continue
            raise RuntimeError(f"no answer to {len(waiting)} lines behind line {i}")
        heard += os.read(fd, 4096)
        *whole, heard = heard.split(b"\n")
        for line in whole:
            if line.startswith((b"ok", b"error")):
                used -= waiting.pop(0)
    ended = time.monotonic()
    os.close(fd)
    return begun, ended


def gcomp(folder: Path, port: str, *options: str) -> tuple[float, float]:
    """The times of the job itself, by its journal: what is said before and after is not the job."""
    import json

    status, said = real_grbl.stream(folder, port, "job.nc", "--quiet", *options)
    assert status == 0, said
    entries = [
        json.loads(row) for row in (folder / "job.nc.journal").read_text().split("\n") if row
    ]
    sent = next(e["t"] for e in entries if "sent" in e)
    return sent, max(e["t"] for e in entries if "answered" in e)


def printcore(folder: Path, port: str) -> tuple[float, float]:
    """As it says by itself."""
    command = [
        str(CACHE / "bin" / "python"),
        str(HERE / "peer_printcore_grbl.py"),
        port,
        str(folder / "job.nc"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    begun, ended = map(float, done.stdout.split())
    return begun, ended


def run(sender: str, rows: list[str], latency: float) -> tuple[float, float, float]:
    """Bytes a second of the job, seconds of motion, s that the simulator fell
    behind."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "job.nc").write_text("\n".join(rows) + "\n")
        options = ["-baud", str(BAUD), *(("-latency", str(latency)) if latency else ())]
        with RealGrbl(folder, *options) as real:
            if sender in ("ideal", ASKING, "send-response"):
                real.talk("$I")
                window = 0 if sender == "send-response" else WINDOW
                begun, ended = bare(real.path, rows, window, ASKS if sender == ASKING else 0.0)
            elif sender == "printcore":
                begun, ended = printcore(folder, real.path)
            else:
                begun, ended = gcomp(folder, real.path, *sender.split()[1:])
            real.rest()
            behind = real.behind
        steps = np.frombuffer((folder / "t.bin").read_bytes(), RECORD)
    motion = (int(steps["cycle"][-1]) - int(steps["cycle"][0])) / CLOCK
    sent = sum(len(row) + 1 for row in rows)
    return sent / (ended - begun), motion, behind


def kept_up(sender: str, rows: list[str], latency: float) -> tuple[float, float]:
    """A run in which the simulator kept up; else the best of them."""
    runs = []
    for _ in range(AGAIN):
        runs.append(run(sender, rows, latency))
        if runs[-1][2] < real_grbl.BEHIND:
            break
    return min(runs, key=lambda r: r[2])[:2]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--seconds", type=float, default=8.0, help="of motion at the programmed feed"
    )
    parser.add_argument("--feeds", type=int, nargs="+", default=[1000, 2000, 5000], help="mm/min")
    parser.add_argument("--latency", type=float, nargs="+", default=[0.0, 16.0], help="ms")
    parser.add_argument("--repeat", type=int, default=3, help="runs of each sender")
    parser.add_argument(
        "--senders", nargs="+", choices=SENDERS, help="these alone, ideal with them"
    )
    parser.add_argument(
        "--fetch", action="store_true", help="install printcore into the cache first"
    )
    options = parser.parse_args()
    if options.fetch:
        fetch()
    senders = SENDERS if (CACHE / "complete").exists() else SENDERS[:-1]
    if options.senders:
        senders = tuple(s for s in senders if s == "ideal" or s in options.senders)
    print(
        "| latency ms | F | lines a second wanted | sender | bytes a second, best, median |"
        " of ideal | motion s | of the feed |"
    )
    print("|---:|---:|---:|---|---:|---:|---:|---:|")
    for latency in options.latency:
        for feed in options.feeds:
            rows = program(feed, options.seconds)
            seconds = (len(rows) - 2) * STEP / feed * 60
            runs: dict[str, list[tuple[float, float]]] = {sender: [] for sender in senders}
            for _ in range(options.repeat):
                for sender in senders:
                    runs[sender].append(kept_up(sender, rows, latency))
            told(f"{latency:g} | {feed} | {feed / 60 / STEP:.0f}", runs, seconds)


def told(which: str, runs: dict[str, list[tuple[float, float]]], seconds: float) -> None:
    """A row for each sender: bytes a second, that of the ideal one's, motion, s, and what it takes
    at its feed by that."""
    ideal = [rate for rate, _ in runs["ideal"]]
    for sender, pairs in runs.items():
        rates, motion = [rate for rate, _ in pairs], min(motion for _, motion in pairs)
        best = 100 * max(rates) / max(ideal)
        median = 100 * statistics.median(rates) / statistics.median(ideal)
        print(
            f"| {which} | {sender} | {max(rates):.0f}, {statistics.median(rates):.0f} |"
            f" {best:.1f} %, {median:.1f} % | {motion:.2f} | {100 * seconds / motion:.0f} % |",
            flush=True,
        )


if __name__ == "__main__":
    main()
