"""What no name explains: its map, what it goes with, what the map is worth where it took no part;
and never where only noise is left."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from postproc.cli import main
from postproc.diagnose import unknown

from .command import diagnosed
from .damage import cells, split

ROOT = Path(__file__).resolve().parents[2]
STUDER = str(ROOT / "machines" / "studer-s36")


@pytest.fixture(scope="module")
def plain(tmp_path_factory) -> str:
    file = tmp_path_factory.mktemp("plain") / "r.csv"
    assert (
        main(
            [
                "simulate",
                "--test",
                "positioning:Z,runs=4",
                "--machine",
                STUDER,
                "--noise",
                "0.3",
                "--seed",
                "9",
                "-o",
                str(file),
                "--quiet",
            ]
        )
        == 0
    )
    return file.read_text()


def strange(text: str) -> str:
    """Dents that no screw has: up and down from target to target, the same in every run, in one
    direction other than in the other."""
    _, names, rows = split(text)
    place, side = ([float(row[names.index(n)]) for row in rows] for n in ("Z_mm", "approach_Z"))
    numbers = {z: k for k, z in enumerate(sorted({round(z, 1) for z in place}))}
    rng = np.random.default_rng(17)
    dents = {
        s: rng.choice([-1.0, 1.0], len(numbers)) * rng.uniform(2.0, 9.0, len(numbers))
        for s in (-1.0, 1.0)
    }
    off = [dents[s][numbers[round(z, 1)]] for z, s in zip(place, side, strict=True)]
    return cells("reading_um", lambda v, k: f"{float(v) + off[k]:.3f}")(text)


def answer(text: str, folder: Path, *more: str) -> dict:
    file = folder / "r.csv"
    file.write_text(text)
    return diagnosed([str(file)], STUDER, folder / "a.json", *more)


def test_what_no_name_explains_is_mapped(plain, tmp_path):
    told = answer(strange(plain), tmp_path, "--write-machine", str(tmp_path / "found"))
    left = told["unknown"]
    assert told["verdict"] == "unknown"
    assert not [e for e in told["effects"] if e["status"] == "accepted"]
    assert (
        left["rms_um"] > 2.0
        and left["depends_on"] == ["position", "direction"]
        and left["along"] == "Z"
    )
    assert left["held_out_rms_after_um"] < 0.5 * left["held_out_rms_before_um"]
    assert {row["approach"] for row in left["table"]} == {-1, 1}
    assert all(row["from"] <= row["to"] and row["readings"] >= 2 for row in left["table"])
    assert 0.2 < left["share_left"] <= 1.0
    lines = (tmp_path / "found" / f"{left['map']}.csv").read_text().splitlines()
    assert (
        lines[0] == "Z_mm_from,Z_mm_to,approach,readings,residual_um,u_um"
        and len(lines) == len(left["table"]) + 1
    )


def test_a_map_is_no_effect_of_the_machine(plain, tmp_path):
    """What is written beside the machine is for people: the machine is as it was."""
    answer(strange(plain), tmp_path, "--write-machine", str(tmp_path / "found"))
    from postproc.machine.file import read_machine

    was, is_now = read_machine(ROOT / "machines" / "studer-s36"), read_machine(tmp_path / "found")
    place, side = np.array([[40.0, 90.0], [77.0, 303.0]]), np.array([[1.0, -1.0], [1.0, -1.0]])
    assert np.array_equal(was.deviation(place, side), is_now.deviation(place, side))
    assert not is_now.effects


@pytest.mark.parametrize("seed", range(4))
def test_noise_is_never_unknown(plain, tmp_path, seed):
    rng = np.random.default_rng(seed)
    told = answer(
        cells("reading_um", lambda v, k: f"{float(v) + rng.standard_t(4) * 0.7:.3f}")(plain),
        tmp_path,
    )
    assert told["unknown"] is None and told["verdict"] == "nothing-left-out"


def test_a_map_says_what_its_cells_say():
    way = np.repeat([-1, 1], 200)
    place = np.tile(np.linspace(0, 100, 200), 2)
    wanted = np.where(way > 0, 0.002 * np.sin(place / 12), -0.001)
    cells_ = unknown._cells(place, way, wanted)
    assert np.abs(unknown.predicted(cells_, place, way) - wanted).max() < 6e-4
    assert not unknown.predicted(cells_, place, np.zeros(400)).any()
