"""How often the truth lies within the uncertainty that `gcomp calibrate` states: 200 known machines
of each kind.

    python benchmarks/calibration.py [--machines 200] [--runs 5] [--noise 0.3]
    python benchmarks/calibration.py --conditions        20 machines under nine conditions each

Every machine is made up anew, its recordings are simulated by the rigid-body equation
(tests/calibrate/simulation.py), calibrated, and every value of every table is compared with the
truth. A well stated uncertainty has 95 % within 2 u.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from postproc.calibrate import Options
from postproc.calibrate.run import calibrate
from postproc.machine.chain import parse
from tests.calibrate.simulation import coverage, three_axes, two_axes

MACHINES = {
    "grinder, X and Z, 5 components": (two_axes, "w-b-Z-X-t", {"X": 80.0, "Z": 200.0}),
    "mill, X Y Z, 18 components": (
        three_axes,
        "w-X-Y-b-Z-t",
        {"X": 200.0, "Y": 150.0, "Z": -100.0},
    ),
}


def conditions(seed: int) -> None:
    """20 machines, ten of each kind, under nine conditions each, every one drawn anew."""
    print("| runs | noise, um and urad | values | within 2 u |")
    print("|---|---|---|---|")
    held, number = 0, 0
    for k, (runs, noise) in enumerate((r, n) for r in (3, 5, 8) for n in (0.1, 0.4, 1.5)):
        inside, count = 0, 0
        for i, (make, chain, rest) in enumerate(MACHINES.values()):
            some = coverage(
                make,
                parse(chain),
                rest,
                Options(parse(chain)),
                calibrate,
                10,
                seed + 100 * k + i,
                runs=runs,
                noise=noise,
            )
            inside, count = inside + some[0], count + some[1]
        held, number = held + inside, number + count
        print(f"| {runs} | {noise:g} | {count} | {100 * inside / count:.2f} % |", flush=True)
    print(f"| all | | {number} | {100 * held / number:.2f} % |")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--machines", type=int, default=200)
    parser.add_argument("--runs", type=int, nargs="+", default=[2, 3, 5], help="in each direction")
    parser.add_argument("--noise", type=float, default=0.3, help="um and urad")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--conditions",
        action="store_true",
        help="20 machines, 3, 5 and 8 runs with 0.1, 0.4 and 1.5 um",
    )
    options = parser.parse_args()
    if options.conditions:
        conditions(options.seed)
        return
    print("| machine | runs | values | within 2 u | error / u, rms | mean u |")
    print("|---|---|---|---|---|---|")
    for title, (make, chain, rest) in MACHINES.items():
        for runs in options.runs:
            inside, count, spread, u = coverage(
                make,
                chain,
                rest,
                Options(parse(chain)),
                calibrate,
                options.machines,
                options.seed,
                runs=runs,
                noise=options.noise,
            )
            print(
                f"| {title} | {runs} | {count} | {100 * inside / count:.2f} % | {spread:.3f} |"
                f" {u:.3f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
