"""The measured grinder's printed tables as recordings: one run each way, as a laser would have
written them."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from postproc.recordings import Recording

SEED = Path(__file__).resolve().parents[2] / "proof" / "seed" / "tables"
TABLES = {"Z": "table_6_1_studer_s36_z_axis.csv", "X": "table_6_2_studer_s36_x_axis.csv"}
COLUMNS = {"EZZ": "dzz", "EXZ": "dxz", "EBZ": "eyz", "EXX": "dxx", "EZX": "dzx"}
QUANTITIES = {
    "EZZ": "displacement",
    "EXX": "displacement",
    "EBZ": "angle",
    "EXZ": "straightness",
    "EZX": "straightness",
}
FIRST_LINE = 8


def recording(component: str) -> Recording:
    """One component; there and back again, the other axis at 0."""
    letter = component[2]
    with open(SEED / TABLES[letter], encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    unit = "" if component == "EBZ" else "_mm"  # the yaw is printed in mm/m
    q = np.array([float(r[f"{letter.lower()}_mm"]) for r in rows])
    forward, reverse = (
        np.array([float(r[f"{COLUMNS[component]}_{way}{unit}"]) * 1e3 for r in rows])
        for way in ("forward", "reverse")
    )
    n = len(q)
    other = "XZ".replace(letter, "")
    columns = {
        "run": np.ones(2 * n),
        f"{letter}_mm": np.concatenate([q, q[::-1]]),
        f"{other}_mm": np.zeros(2 * n),
        f"approach_{letter}": np.repeat([1.0, -1.0], n),
        "reading_urad" if component == "EBZ" else "reading_um": np.concatenate(
            [forward, reverse[::-1]]
        ),
    }
    head = {
        "quantity": QUANTITIES[component],
        "sensitive": {{"B": "Y"}.get(component[1], component[1]): 1.0},
        "instrument": "laser interferometer",
    }
    return Recording("targets", head, columns, f"{component}.csv", np.arange(2 * n) + FIRST_LINE)


def all_recordings() -> list[Recording]:
    return [recording(component) for component in COLUMNS]
