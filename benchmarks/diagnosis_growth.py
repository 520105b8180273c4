"""How the time of `gcomp diagnose` grows with samples, effects and recordings.

    python -m benchmarks.diagnosis_growth

Samples: the trace of long_trace. Effects: none, one, two, four of EFFECTS in a circle and two tests
of ISO 230-2 on studer-s36. Recordings: so many circles of other seeds. Each is a process of its
own, as a user calls it: CPU seconds, start-up included, peak memory in MB, and the power of the
number with which the time beyond the start-up grows from one line to the next.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.long_trace import write

MACHINE = ["--machine", "studer-s36"]
SAMPLES = (15_625, 62_500, 250_000, 1_000_000)
EFFECTS = (
    "servo_lag:X:tau_ms=1.5",
    "backlash:Z:size_um=8",
    "scale:Z:ppm=20",
    "cyclic:X:amplitude_um=3,period_mm=10,phase_deg=20",
)
TESTS = ("ballbar:XZ", "positioning:X", "positioning:Z")
RECORDINGS = (1, 2, 4, 8)
CALL = "import sys; from postproc.cli import main; sys.exit(main(sys.argv[1:]))"


def measured(files: list[Path]) -> tuple[float, float]:
    """CPU seconds and peak MB of one diagnosis."""
    words = ["diagnose", *map(str, files), *MACHINE, "--quiet", "--json", os.devnull]
    return _used([sys.executable, "-c", CALL, *words])


def _used(words: list[str]) -> tuple[float, float]:
    child = [sys.executable, "-I", "-S", str(Path(__file__).with_name("child.py")), *words]
    status, seconds, _, peak = map(float, subprocess.check_output(child).split())
    if status:
        raise SystemExit(f"{' '.join(words)} ended with {status:.0f}")
    return seconds, peak


def recorded(file: Path, test: str, seed: int, effects: tuple[str, ...]) -> Path:
    """A recording of a test with these effects."""
    from postproc.cli import main as gcomp

    words = ["simulate", "--test", test, *MACHINE, "--noise", "0.4", "--seed", str(seed)]
    words += ["--set", "rate=20"] if test.startswith("ballbar") else []
    more = [word for effect in effects for word in ("--with", effect)]
    if gcomp([*words, *more, "-o", str(file), "--quiet"]):
        raise SystemExit(f"{file.name} was not simulated")
    return file


def lines(
    name: str, cases: list[tuple[int, list[Path]]], start: float
) -> list[tuple[str, int, float, float, float]]:
    """Name, number, CPU seconds, MB and power of growth of each case."""
    result: list[tuple[str, int, float, float, float]] = []
    for number, files in cases:
        seconds, peak = measured(files)
        power = float("nan")
        if result and result[-1][1]:
            ratio = (seconds - start) / max(result[-1][2] - start, 1e-9)
            power = float(np.log(ratio) / np.log(number / result[-1][1]))
        result.append((name, number, seconds, peak, power))
    return result


def main() -> None:
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    start, _ = _used([sys.executable, "-c", "import postproc.diagnose.analysis"])
    print(
        f"start-up {start:.2f} s\n\n| | number | CPU s | peak MB | power |\n|---|---|---|---|---|"
    )
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        traces = []
        for number in SAMPLES:
            write(folder / f"{number}.csv", number)
            traces.append((number, [folder / f"{number}.csv"]))
        hidden = [
            (
                number,
                [
                    recorded(
                        folder / f"e{number}{test[:3]}{test[-1]}.csv", test, 1, EFFECTS[:number]
                    )
                    for test in TESTS
                ],
            )
            for number in (0, 1, 2, 4)
        ]
        circles = [recorded(folder / f"c{k}.csv", "ballbar:XZ", k, EFFECTS[:2]) for k in range(8)]
        several = [(number, circles[:number]) for number in RECORDINGS]
        for name, cases in (("samples", traces), ("effects", hidden), ("recordings", several)):
            for row in lines(name, cases, start):
                print("| {} | {:,} | {:.1f} | {:.0f} | {:.2f} |".format(*row), flush=True)


if __name__ == "__main__":
    main()
