"""How long `gcomp diagnose` takes over a trace of a million samples, and how much memory.

    python -m benchmarks.long_trace [--samples 1000000]

A lathe's two slides go there and back for a thousand seconds, logged at 1 kHz by an instrument at
the tool; X is 2 ms late, Z 1 ms and 8 um behind at every turn.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import numpy as np

BLOCK = 50_000


def wave(t: np.ndarray, low: float, high: float, period: float) -> np.ndarray:
    """(N,) mm: there and back with rounded turns."""
    there = 1 - np.abs(2 * ((t / period + 0.1) % 1) - 1)
    for _ in range(2):
        there = np.convolve(np.pad(there, 25, mode="edge"), np.ones(51) / 51, "valid")
    return low + (high - low) * there


def write(file: Path, samples: int) -> None:
    from postproc.machine import places

    machine, rng = places.load("studer-s36"), np.random.default_rng(1)
    t = np.arange(samples) / 1000.0
    x, z = wave(t, 20, 150, 13.7), wave(t, 50, 450, 29.3)
    vx, vz = np.gradient(x, t), np.gradient(z, t)
    side = np.where(np.stack([vx, vz]) >= 0, 1.0, -1.0)
    off = np.concatenate(
        [
            machine.deviation(np.stack([x, z])[:, a : a + BLOCK], side[:, a : a + BLOCK])
            for a in range(0, samples, BLOCK)
        ],
        axis=1,
    )
    off += np.stack([-0.002 * vx, -0.001 * vz - 0.004 * side[1]]) + rng.normal(0, 4e-4, off.shape)
    with file.open("w") as out:
        out.write(
            '# format = "gcomp-recording/1"\n# kind = "trace"\n# machine = "studer-s36"\n# sees ='
            ' "tool"\n'
        )
        out.write("run,t_s,X_cmd_mm,Z_cmd_mm,X_act_mm,Z_act_mm\n")
        rows = np.stack([1 + t // 200, t, x, z, x + off[0], z + off[1]], axis=1)
        np.savetxt(out, rows, fmt="%d,%.3f,%.6f,%.6f,%.6f,%.6f")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=1_000_000)
    samples = parser.parse_args().samples
    from postproc.cli import main as gcomp

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "long.csv"
        write(file, samples)
        before, wall, own = (
            resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
            time.perf_counter(),
            time.process_time(),
        )
        gcomp(["diagnose", str(file), "--machine", "studer-s36", "--quiet"])
        wall, own = time.perf_counter() - wall, time.process_time() - own
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(
            f"\n{samples:,} samples: {wall:.1f} s, of these {own:.1f} s of the processor; peak"
            f" {peak / 1024:.0f} MB (before: {before / 1024:.0f})"
        )


if __name__ == "__main__":
    main()
