"""Where it differs: an angle's reading in urad, the stretch and not the rest of the way, one
direction or both."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from postproc.cli import main
from tests.diagnose.test_burst_noise import HEAD, MACHINE

MILL = str(Path(__file__).parents[2] / "machines" / "example-mill")


def recorded(folder: Path, test: str, instrument: str, column: str, off) -> str:
    """A recording with so much added to the readings: off(row as a dictionary of its columns)."""
    file = folder / f"{instrument}.csv"
    words = [
        "simulate",
        "--test",
        test,
        "--machine",
        MILL,
        "--instrument",
        instrument,
        "--seed",
        "4",
        "--noise",
        "0.3",
    ]
    assert main([*words, "-o", str(file), "--quiet"]) == 0
    lines = file.read_text().splitlines()
    head = next(k for k, line in enumerate(lines) if not line.startswith("#"))
    names = lines[head].split(",")
    for k in range(head + 1, len(lines)):
        row = dict(zip(names, lines[k].split(","), strict=True))
        row[column] = f"{float(row[column]) + off({n: float(v) for n, v in row.items()}):.3f}"
        lines[k] = ",".join(row.values())
    file.write_text("\n".join(lines) + "\n")
    return str(file)


def told(folder: Path, *files: str) -> dict:
    out = folder / "a.json"
    words = [
        "diagnose",
        *files,
        "--machine",
        MILL,
        "--json",
        str(out),
        "--residuals",
        str(folder / "r.csv"),
        "--quiet",
    ]
    assert main(words) == 0
    return json.loads(out.read_text())


def test_an_angle_is_located_in_urad(tmp_path):
    laser = recorded(tmp_path, "positioning:X", "laser", "reading_um", lambda row: 0.0)
    angle = recorded(
        tmp_path, "angle:X", "angle", "reading_urad", lambda row: 12.0 * (row["X_mm"] > 100)
    )
    answer = told(tmp_path, laser, angle)
    (place,) = answer["mismatch"]
    assert (
        place["recording"].endswith("angle.csv")
        and place["unit"] == "urad"
        and 6 < place["rms_um"] < 10
    )
    where = place["where"]
    assert (
        where["axis"] == "X"
        and where["from_mm"] == pytest.approx(137.4, abs=0.1)
        and where["to_mm"] == pytest.approx(349)
    )
    assert where["approach"] == "both"
    assert answer["unknown"]["unit"] == "urad" and 4 < answer["unknown"]["rms_um"] < 8
    rows = [line.split(",") for line in (tmp_path / "r.csv").read_text().splitlines()[1:]]
    held = [float(r[5]) ** 2 for r in rows if r[6] == "1"]
    assert answer["fit"]["rms_after_um"] == pytest.approx((sum(held) / len(held)) ** 0.5, rel=1e-3)


@pytest.mark.parametrize("side", [-1, 1])
def test_one_direction_alone(tmp_path, side):
    bump = recorded(
        tmp_path, "positioning:X", "laser", "reading_um",
        lambda row: 6.0 * (-180 < row["X_mm"] < 60 and row["approach_X"] == side),
    )  # fmt: skip
    where = told(tmp_path, bump)["mismatch"][0]["where"]
    assert (
        where["approach"] == "-+"[side > 0]
        and -180 < where["from_mm"] < -120
        and 0 < where["to_mm"] < 60
    )


def located(folder: Path, capsys, shows: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> str:
    """The line that says where a trace of X, to and fro four times in 56 s, differs: by shows(place
    mm, time s), um."""
    time = np.arange(5600) * 0.01
    place = 200 + 40 * np.sin(2 * np.pi * time / 14.0)
    noise = np.random.default_rng(5).normal(0, 0.2, len(time))
    error = (shows(place, time) + noise) * 1e-3
    rows = [
        f"1,{t:.2f},{c:.5f},100,{c + e:.5f},100" for t, c, e in zip(time, place, error, strict=True)
    ]
    file = folder / "trace.csv"
    names = "run,t_s,X_cmd_mm,Y_cmd_mm,X_act_mm,Y_act_mm"
    file.write_text("\n".join([HEAD.format("tool") + names, *rows, ""]))
    (folder / "machine.toml").write_text(MACHINE)
    assert main(["diagnose", str(file), "--machine", str(folder)]) == 0
    said = capsys.readouterr()
    return next(x for x in (said.out + said.err).splitlines() if x.startswith("WHERE"))


@pytest.mark.parametrize("width", [4.0, 25.0])
def test_what_is_always_there_has_no_time(tmp_path, capsys, width):
    line = located(tmp_path, capsys, lambda x, t: 4.0 * np.exp(-(((x - 210) / width) ** 2)))
    assert not re.search(r"to \d+ s", line), line


@pytest.mark.parametrize("width", [8.0, 15.0])
def test_what_comes_later_has_one(tmp_path, capsys, width):
    """Passed in half a second, it is no noise that comes and goes either."""
    line = located(
        tmp_path, capsys, lambda x, t: 4.0 * np.exp(-(((x - 210) / width) ** 2)) * (t > 28.0)
    )
    begin, end = map(float, re.search(r"from (\d+) to (\d+) s", line).groups())
    assert 27 < begin < 30 and 47 < end < 50, line  # the passages at 28.6 to 48.4 s


def test_without_times_nothing_has_one(tmp_path, capsys):
    file = Path(
        recorded(
            tmp_path,
            "positioning:X",
            "laser",
            "reading_um",
            lambda row: 6.0 * (-180 < row["X_mm"] < 60),
        )
    )
    lines = file.read_text().splitlines()
    head = next(k for k, line in enumerate(lines) if not line.startswith("#"))
    at = lines[head].split(",").index("t_s")
    rows = [line.split(",") for line in lines[head:]]
    plain = [",".join([*row[:at], *row[at + 1 :]]) for row in rows]
    file.write_text("\n".join([*lines[:head], *plain, ""]))
    assert main(["diagnose", str(file), "--machine", MILL]) == 0
    said = capsys.readouterr()
    line = next(x for x in (said.out + said.err).splitlines() if x.startswith("WHERE"))
    assert not re.search(r"to \d+ s", line), line
