"""How often the truth lies within the uncertainty that `gcomp calibrate` states: 200 known machines of each kind.

    python benchmarks/calibration.py [--machines 200] [--runs 5] [--noise 0.3]

Every machine is made up anew, its recordings are simulated by the rigid-body equation (tests/calibrate/simulation.py),
calibrated, and every value of every table is compared with the truth. A well stated uncertainty has 95 % within 2 u.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from postproc.calibrate import Options
from postproc.calibrate.calibration import calibrate
from postproc.machine.chain import parse
from tests.calibrate.simulation import coverage, three_axes, two_axes

MACHINES = {
    "grinder, X and Z, 5 components": (two_axes, "w-b-Z-X-t", {"X": 80.0, "Z": 200.0}),
    "mill, X Y Z, 18 components": (three_axes, "w-X-Y-b-Z-t", {"X": 200.0, "Y": 150.0, "Z": -100.0}),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--machines", type=int, default=200)
    parser.add_argument("--runs", type=int, nargs="+", default=[2, 3, 5], help="in each direction")
    parser.add_argument("--noise", type=float, default=0.3, help="um and urad")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print("| machine | runs | values | within 2 u | error / u, rms | mean u |")
    print("|---|---|---|---|---|---|")
    for title, (make, chain, rest) in MACHINES.items():
        for runs in options.runs:
            inside, count, spread, u = coverage(
                make, chain, rest, Options(parse(chain)), calibrate, options.machines, options.seed, runs=runs, noise=options.noise
            )  # fmt: skip
            print(f"| {title} | {runs} | {count} | {100 * inside / count:.2f} % | {spread:.3f} | {u:.3f} |", flush=True)


if __name__ == "__main__":
    main()
