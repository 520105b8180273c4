"""How often `gcomp accept` names a turned sign, how often `gcomp volumetric` holds its u, and
figures of ISO 230-2 beside published ones.

    python benchmarks/measuring.py accept [--cases 200]
    python benchmarks/measuring.py volumetric [--fits 20]
    python benchmarks/measuring.py published

The cases are those of the tests (tests/accept/test_signs.py, tests/volumetric/test_volumetric.py),
of other seeds where --seed says so. `benchmarks/calibration.py --conditions` does the same for
calibrate.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.accept import test_signs as signs
from tests.iso import test_published as published
from tests.volumetric import test_volumetric as volumetric


def accept(cases: int, seed: int) -> None:
    """Components of made-up machines, after a correction with a sign turned or without."""
    rng = np.random.default_rng(seed)
    faults = ["", "off", "both", "+", "-", "exchanged"]
    table = {fault: [0, 0, 0] for fault in faults}
    for _ in range(cases):
        axes = signs.machine(rng)
        name, fault = str(rng.choice(signs.TRANSLATIONS)), str(rng.choice(faults))
        result, wanted = signs.found(rng, axes[name[2]], name, fault), signs.expected(fault)
        table[fault][0] += 1
        table[fault][1] += wanted <= set(result.turned)
        table[fault][2] += bool(set(result.turned) - wanted)
    print("| what was turned | cases | named | something else named |\n|---|---|---|---|")
    said = {"": "nothing, taken out", "off": "nothing, not corrected", "both": "both directions"}
    for fault, (number, named, other) in table.items():
        shown = "-" if fault in ("", "off") else str(named)
        print(f"| {said.get(fault, fault)} | {number} | {shown} | {other} |")


def fits(number: int, seed: int) -> None:
    """Clouds of a tracker and lengths of stations on three chains, by turns."""
    rng = np.random.default_rng(seed)
    found = [volumetric.one_fit(k, rng) for k in range(number)]
    every = np.concatenate(found)
    print(f"{number} fits, {len(every)} values: {100 * every.mean():.1f} % within 2 u;", end=" ")
    print(f"by fit {100 * min(map(np.mean, found)):.0f} to {100 * max(map(np.mean, found)):.0f} %")


def beside_published() -> None:
    """ISO 230-2 figures of a published report (tests/iso/test_published.py names it) and ours of
    its readings, in nm."""
    print("| figure | printed, nm | ours, nm | difference, nm |\n|---|---|---|---|")
    for name, (printed, _) in published.PRINTED.items():
        values = published.ours(name).values
        for figure, value in printed.items():
            ours = values[figure]
            print(
                f"| {figure} | {value * 1e6:.2f} | {ours * 1e6:.3f} | {(ours - value) * 1e6:+.3f} |"
            )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("accept", "volumetric", "published"))
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--fits", type=int, default=20)
    parser.add_argument("--seed", type=int)
    options = parser.parse_args()
    if options.what == "accept":
        accept(options.cases, 17 if options.seed is None else options.seed)
    elif options.what == "published":
        beside_published()
    else:
        fits(options.fits, 5 if options.seed is None else options.seed)


if __name__ == "__main__":
    main()
