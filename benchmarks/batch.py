"""A thousand programs by `gcomp batch`, with one process and with two: seconds, and the same bytes.

    python benchmarks/batch.py [--programs 1000] [--machine example-mill]

Each program has 122 lines, a zigzag of its own (seeded). The processes share a computer with what
else runs on it, so the runs take turns, `--repeat` times, and what is said of two processes is the
median of the ratios of neighbouring runs. "two runs" is what this computer has to give: two gcomp
batch with one process each, half of the programs each, begun together.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def program(seed: int) -> str:
    """A zigzag in three axes."""
    rng = random.Random(seed)
    lines = ["G21 G90 G54", "G0 X10 Y10 Z-20"]
    for k in range(118):
        x, y, z = 10 + k, rng.uniform(10, 150), rng.uniform(-40, -20)
        lines.append(f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} F1200")
    return "\n".join([*lines, "G0 Z-10", "M2"]) + "\n"


def command(jobs: list[Path], out: Path, machine: str, processes: int) -> list[str]:
    words = [sys.executable, "-m", "postproc", "batch", *map(str, jobs), "--machine", machine]
    return [*words, "-o", str(out), "--quiet", "-j", str(processes), "--offset", "G54=X0,Y0,Z-100"]


def run(commands: list[list[str]], outs: list[Path]) -> tuple[float, float, str]:
    """All of them side by side: s of the clock, s of processors, a digest of all that was
    written."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    running = [
        subprocess.Popen(words, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL)
        for words in commands
    ]
    if any(one.wait() for one in running):
        sys.exit("gcomp batch failed")
    took, after = time.monotonic() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    digest = hashlib.sha256()
    for path in sorted((path for out in outs for path in out.glob("*.nc")), key=lambda p: p.name):
        digest.update(path.read_bytes())
    for out in outs:
        shutil.rmtree(out)
    return took, cpu, digest.hexdigest()


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--programs", type=int, default=1000)
    parser.add_argument("--machine", default="example-mill")
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        (place / "jobs").mkdir()
        halves = [place / "jobs" / "a", place / "jobs" / "b"]
        for k in range(options.programs):
            half = halves[k >= options.programs // 2]
            half.mkdir(exist_ok=True)
            (half / f"{k:04d}.nc").write_text(program(k))
        out = [place / "out", place / "beside"]
        kinds = {
            "one": [command(halves, out[0], options.machine, 1)],
            "two": [command(halves, out[0], options.machine, 2)],
            "two runs": [
                command([half], own, options.machine, 1)
                for half, own in zip(halves, out, strict=True)
            ],
        }
        seen: dict[str, list[tuple[float, float]]] = {kind: [] for kind in kinds}
        digests = set()
        for _ in range(options.repeat):
            for kind, commands in kinds.items():
                took, cpu, digest = run(commands, out[: len(commands)])
                digests.add(digest)
                seen[kind].append((took, cpu))
    print("| processes | s of the clock | s of processors | times as fast |\n|---|---|---|---|")
    for kind, runs in seen.items():
        took, cpu = (statistics.median(values) for values in zip(*runs, strict=True))
        ratios = [one[0] / own[0] for one, own in zip(seen["one"], runs, strict=True)]
        faster = statistics.median(ratios)
        span = f"{min(ratios):.2f} to {max(ratios):.2f}"
        print(f"| {kind} | {took:.1f} | {cpu:.1f} | {faster:.2f} ({span}) |")
    print(f"{options.programs} programs, {options.repeat} times; load {os.getloadavg()[0]:.1f};")
    print("the same bytes" if len(digests) == 1 else "NOT THE SAME BYTES")


if __name__ == "__main__":
    main()
