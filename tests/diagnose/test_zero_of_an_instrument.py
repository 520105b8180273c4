"""An instrument's zero is nobody's departure, whatever its size."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np

from postproc.cli import main
from postproc.diagnose import map_agreement
from postproc.machine.file import read_machine

STUDER = Path(__file__).resolve().parents[2] / "machines" / "studer-s36"


def test_a_large_zero_where_some_places_were_read_more_often_leaves_no_reading_out(tmp_path):
    """100 um of zero; of two runs the first half of the places was read a third time, and in a
    changed order."""
    path = tmp_path / "r.csv"
    words = [
        "simulate",
        "--test",
        "positioning:Z,runs=3",
        "--machine",
        str(STUDER),
        "--noise",
        "0.4",
        "--seed",
        "3",
    ]
    assert main([*words, "-o", str(path), "--quiet"]) == 0
    head = [line for line in path.read_text().splitlines(keepends=True) if line.startswith("#")]
    rows = list(
        csv.DictReader(line for line in path.read_text().splitlines() if not line.startswith("#"))
    )
    middle = float(np.median([float(row["Z_mm"]) for row in rows]))
    kept = [row for row in rows if row["run"] != "3" or float(row["Z_mm"]) < middle]
    for k, row in enumerate(kept):
        row["reading_um"] = f"{float(row['reading_um']) - 100.0:.3f}"
        row["run"] = str(1 + k % 2)
    out = io.StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(kept)
    path.write_text("".join(head) + out.getvalue())
    answer = tmp_path / "a.json"
    assert (
        main(["diagnose", str(path), "--machine", str(STUDER), "--json", str(answer), "--quiet"])
        == 0
    )
    left_out = json.loads(answer.read_text())["data_faults"]
    assert len(left_out) <= 2, left_out


def test_a_disagreement_stays_where_all_readings_of_a_recording_were_left_out():
    class NoRows:
        file = np.zeros(0, int)

    disagreements = {1: ["it does not fit"], 2: []}
    left = map_agreement.remaining(disagreements, NoRows(), read_machine(STUDER), np.zeros(0))
    assert left == ["it does not fit"]
