"""A thermometer that hangs or jumps is listed and not used; one that warms, or is coarse, is."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from postproc.cli import main
from postproc.diagnose.thermometers import faulty

N = 120
TIME = np.arange(N) * 12.0
WARMING = 20.0 + 3.0 * (1 - np.exp(-TIME / 900.0)) + np.random.default_rng(3).normal(0, 0.03, N)
MILL = Path(__file__).parents[2] / "machines" / "example-mill"


def test_what_metal_does_is_no_fault():
    assert faulty(np.round(WARMING, 2), TIME) is None
    assert faulty(np.round(WARMING, 0), TIME) is None, "a coarse thermometer"
    assert faulty(np.repeat(np.round(WARMING, 2), 40), np.arange(N * 40) * 0.3) is None, (
        "a slow one"
    )
    gone = WARMING.copy()
    gone[::3] = np.nan
    assert faulty(gone, TIME) is None
    assert faulty(np.full(N, np.nan), TIME) is None
    rest = np.concatenate([np.full(60, 20.0), np.round(WARMING[:60], 1)])
    assert faulty(rest, TIME) is None, "a coarse one that was at rest"


def test_it_hangs():
    bad = np.round(WARMING, 2)
    bad[50:90] = bad[50]
    rows, what = faulty(bad, TIME)
    assert rows.tolist() == list(range(50, 90)) and "40 times in a row" in what
    bad[rows] = np.nan
    assert faulty(bad, TIME) is None, "what it read before and after is used"


@pytest.mark.parametrize("hang", [slice(0, 30), slice(90, N)])
def test_it_hangs_at_an_end(hang):
    """No reading on the other side says what it was meanwhile."""
    bad = np.round(WARMING, 2)
    bad[hang] = bad[hang][0]
    rows, what = faulty(bad, TIME)
    assert rows[0] == hang.start and sorted(rows) == list(range(N)) and "30 times" in what


@pytest.mark.parametrize("jump", [-4.0, 1.5])
def test_it_jumps(jump):
    bad = WARMING + np.where(np.arange(N) >= 70, jump, 0.0)
    rows = faulty(bad, TIME / 2)[0]
    assert rows[0] == 70 and sorted(rows) == list(range(N)), "which level was right is unknown"
    assert faulty(bad, TIME * 10) is None or abs(jump) / 120 >= 0.1, "in two minutes a body may"


def test_one_wrong_reading_is_no_step():
    bad = WARMING.copy()
    bad[70] += 5.0
    assert faulty(bad, TIME) is None


def test_it_is_listed_with_its_row_and_not_used(tmp_path):
    """From row 60 on the column's thermometer reads 8 degrees too much."""
    file, out = tmp_path / "a.csv", tmp_path / "a.json"
    test = [
        "simulate",
        "--test",
        "positioning:X",
        "--machine",
        str(MILL),
        "--instrument",
        "laser",
        "--seed",
        "3",
    ]
    assert main([*test, "-o", str(file), "--quiet"]) == 0
    lines = file.read_text().splitlines()
    head = next(k for k, line in enumerate(lines) if not line.startswith("#"))
    rows = [line.split(",") for line in lines[head + 1 :]]
    assert len(rows) > 70
    noise = np.random.default_rng(8).normal(20, 0.03, len(rows)) + np.where(
        np.arange(len(rows)) >= 60, 8.0, 0.0
    )
    text = [f"{line},{v:.2f}" for line, v in zip(lines[head + 1 :], noise, strict=True)]
    file.write_text("\n".join([*lines[:head], lines[head] + ",T_column_C", *text]) + "\n")
    assert main(["diagnose", str(file), "--machine", str(MILL), "--json", str(out), "--quiet"]) == 0
    told = json.loads(out.read_text())
    fault = next(
        f for f in told["data_faults"] if f["fault"].startswith("sensor_drift: T_column_C jumps by")
    )
    assert fault["row"] == head + 62 and fault["fault"].endswith("not recorded")
