"""A made-up three-axis milling machine for the benchmarks, in the format gcomp-machine/1.

    python benchmarks/machine.py DIR [--two-way]

All 18 components of the slides and the three squareness errors, smooth and of a realistic size
(10-30 um, 10-30 urad). With `--two-way` the positioning components have a column for each
direction, a few um apart.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

SEED = 230
STEP = 25.0  # between nodes, mm
RANGES = {"X": (-5.0, 405.0), "Y": (-5.0, 305.0), "Z": (-105.0, 105.0)}

TOML = """\
format  = "gcomp-machine/1"
name    = "{name}"
title   = "Three-axis mill of the benchmarks"
control = "linuxcnc"
chain   = "w-X-Y-b-Z-t"
source  = "made up by benchmarks/machine.py: no such machine exists"
{axes}
[squareness]                       # urad
C0Y = 25.0
A0Z = -15.0
B0Z = 20.0

[tool]
X = 0.0
Y = 0.0
Z = 0.0

[offsets]
G54 = {{ X = 0.0, Y = 0.0, Z = 0.0 }}
"""

AXIS = """
[axes.{axis}]
travel = [{low}, {high}]
least_increment = 0.0001
table  = "{axis}.csv"
measured_at = {{ {others} }}
"""


def smooth(rng: np.random.Generator, share: np.ndarray, size: float) -> np.ndarray:
    """A slope and three waves over `share` of the travel (0..1), zero at its start, `size` at its
    largest."""
    values = rng.normal() * share
    for waves in (0.5, 1.0, 2.0):
        values = values + rng.normal() / (1.0 + waves) * np.sin(
            2.0 * np.pi * (waves * share + rng.random())
        )
    values = values - values[0]
    return size * values / np.abs(values).max()


def table(axis: str, two_way: bool) -> str:
    """The CSV table of an axis. Both variants of the machine have the same values but for the two
    directions."""
    low, high = RANGES[axis]
    nodes = np.append(np.arange(low, high - 1.0, STEP), high)
    share = (nodes - low) / (high - low)
    rng = np.random.default_rng([SEED, ord(axis)])
    columns = {f"{axis}_mm": nodes}
    for directions, unit in (("XYZ", "um"), ("ABC", "urad")):
        for direction in directions:
            name = f"E{direction}{axis}"
            values = smooth(rng, share, rng.uniform(10.0, 30.0))
            if two_way and direction == axis:
                half = 2.0 + 0.5 * np.sin(3.0 * share)
                columns[f"{name}_{unit}_fwd"] = values - half
                columns[f"{name}_{unit}_rev"] = values + half
            else:
                columns[f"{name}_{unit}"] = values
    rows = zip(*columns.values(), strict=True)
    lines = [
        ",".join(columns),
        *(f"{at:g}," + ",".join(f"{value:.3f}" for value in values) for at, *values in rows),
    ]
    return "\n".join(lines) + "\n"


def write_machine(folder: Path, two_way: bool = False) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    sections = []
    for axis, (low, high) in RANGES.items():
        others = ", ".join(f"{other} = 0.0" for other in RANGES if other != axis)
        sections.append(AXIS.format(axis=axis, low=low, high=high, others=others))
        (folder / f"{axis}.csv").write_text(table(axis, two_way), encoding="ascii")
    toml = TOML.format(name=folder.name, axes="".join(sections))
    (folder / "machine.toml").write_text(toml, encoding="ascii")


def main() -> None:
    parser = argparse.ArgumentParser(description="Write the machine of the benchmarks.")
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument(
        "--two-way", action="store_true", help="positioning measured in both directions"
    )
    options = parser.parse_args()
    write_machine(options.folder, options.two_way)


if __name__ == "__main__":
    main()
