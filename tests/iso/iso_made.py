"""Recordings made up for the tests of ISO 230, and the tables of the seed."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from postproc.recordings import Recording

SEED = Path(__file__).resolve().parents[2] / "proof" / "seed" / "tables"
TABLES = {
    "dzz": "6_1_studer_s36_z",
    "dxz": "6_1_studer_s36_z",
    "dxx": "6_2_studer_s36_x",
    "dzx": "6_2_studer_s36_x",
}
UM = 1e-3


def seed(column):
    """Positions (m,) and means (2, m), mm, of a column of the seed's tables 6.1 and 6.2."""
    with open(SEED / f"table_{TABLES[column]}_axis.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    position = np.array([float(row[next(iter(row))]) for row in rows])
    return position, np.array(
        [[float(r[f"{column}_{way}_mm"]) for r in rows] for way in ("forward", "reverse")]
    )


def runs_of(position, means, noise=None):
    """position, approach, reading, run (N,) of runs alternating +, -: noise (2, n, m) is added to
    the means (2, m)."""
    n = 1 if noise is None else noise.shape[1]
    reading = np.repeat(means[:, None, :], n, axis=1) + (0 if noise is None else noise)
    m = len(position)
    approach = np.repeat([1.0, -1.0], n * m)
    return (
        np.tile(position, 2 * n),
        approach,
        reading.ravel(),
        np.tile(np.repeat(np.arange(1.0, n + 1), m), 2),
    )


def targets(
    moves, reading_um, approach, sensitive, quantity="displacement", run=None, axes="XYZ", **head
):
    """A recording of targets. moves: positions (N,) by axis, the others stand at 0."""
    count = len(reading_um)
    columns = {
        "run": np.ones(count) if run is None else np.asarray(run, float),
        "t_s": np.arange(count, dtype=float),
    }
    for x in [*axes, *(m for m in moves if m not in axes)]:
        columns[f"{x}_{'mm' if x in 'XYZ' else 'deg'}"] = np.asarray(
            moves.get(x, np.zeros(count)), float
        )
        column = approach.get(x) if isinstance(approach, dict) else approach
        columns[f"approach_{x}"] = np.ones(count) if column is None else np.asarray(column, float)
    columns["reading_urad" if quantity == "angle" else "reading_um"] = np.asarray(reading_um, float)
    known = {"quantity": quantity, "sensitive": sensitive, **head}
    return Recording("targets", known, columns, "made.csv", np.arange(2, count + 2))


def along(letter, position, means_um, sensitive=None, quantity="displacement", **more):
    """A recording of one axis, one run each way; means_um (2, m) approached in + and in -."""
    p, approach, reading, run = runs_of(np.asarray(position, float), np.asarray(means_um, float))
    return targets(
        {letter: p}, reading, approach, sensitive or {letter: 1.0}, quantity, run, **more
    )


def ballbar(circles, radius=100.0, axes="XY", per_turn=720, centre=(0.0, 0.0), **head):
    """A recording of circles: (way, start and turn in degrees, radial(angle, way) in um) each."""
    parts = {
        name: [] for name in ("run", "t_s", *(f"{x}_cmd_mm" for x in axes), "radial_um", "sense")
    }
    clock = 0.0
    for number, (way, start, turn, radial) in enumerate(circles, 1):
        count = round(per_turn * turn / 360)
        angle = np.radians(start) + way * np.arange(count) * 2 * np.pi / per_turn
        parts["run"].append(np.full(count, float(number)))
        parts["t_s"].append(clock + 0.1 * np.arange(count))
        parts[f"{axes[0]}_cmd_mm"].append(centre[0] + radius * np.cos(angle))
        parts[f"{axes[1]}_cmd_mm"].append(centre[1] + radius * np.sin(angle))
        parts["radial_um"].append(radial(angle, way) * np.ones(count))
        parts["sense"].append(np.full(count, float(way)))
        clock += 0.1 * count + 5
    columns = {name: np.concatenate(part) for name, part in parts.items()}
    known = {"centre": dict(zip(axes, centre, strict=True)), "radius_mm": radius, **head}
    return Recording("ballbar", known, columns, "ball.csv", np.arange(8, len(columns["run"]) + 8))


def both_ways(radial, **more):
    """One full circle of each sense."""
    return ballbar([(1, 75.0, 360.0, radial), (-1, 75.0, 360.0, radial)], **more)
