"""Waves at targets at even distances: other periods look the same there, and none of them goes
into a machine unasked. The readings are written out here by hand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from postproc.cli import main
from tests.diagnose.test_workshop import HEAD, MACHINE

PERIOD = 6.2832  # mm: a rack's teeth of module 2
EVEN = 20.0 + 9.0 * np.arange(40)
UNEVEN = 20.0 + np.cumsum(np.random.default_rng(4).uniform(6.0, 12.0, 40))


def recording(places: np.ndarray) -> str:
    """A laser along X there and back, three times: 8 um of a wave, 0.3 um of noise."""
    rng = np.random.default_rng(2)
    rows, t = [], 0
    for run in (1, 2, 3):
        for side, there in ((1, places), (-1, places[::-1])):
            for p in there:
                t += 6
                y = 8.0 * np.cos(2 * np.pi * p / PERIOD + 0.5) + 0.3 * rng.standard_normal()
                rows.append(f"{run},{t},{p:.4f},{side},{y:.2f}")
    head = HEAD.format("targets", "laser") + '# quantity = "displacement"\n'
    head += "# sensitive = { X = 1.0 }\n"
    return head + "run,t_s,X_mm,approach_X,reading_um\n" + "\n".join(rows) + "\n"


def told(folder: Path, places: np.ndarray, capsys, *more: str) -> tuple[str, dict, str]:
    """What is said, the wave's finding, and the machine that was written."""
    (folder / "machine").mkdir()
    (folder / "machine" / "machine.toml").write_text(MACHINE)
    (folder / "r.csv").write_text(recording(places))
    words = [str(folder / "r.csv"), "--machine", str(folder / "machine")]
    made = ["--json", str(folder / "a.json"), "--write-machine", str(folder / "new"), *more]
    assert main(["diagnose", *words, *made]) == 0
    (wave,) = json.loads((folder / "a.json").read_text())["effects"]
    assert wave["effect"] == "cyclic" and wave["axis"] == "X"
    whole = capsys.readouterr()
    return whole.out + whole.err, wave, (folder / "new" / "machine.toml").read_text()


def holds(wave: dict, period: float) -> bool:
    low, high = wave["parameters"]["period_mm"]["ci95"]
    return low <= period <= high


def test_even_targets_show_several_periods_alike(tmp_path, capsys):
    """9 mm: 1/6.2832 = 0.1592 per mm looks like 1/9 - 0.1592 = -0.0480, which is 20.8 mm, and like
    2/9 - 0.1592 = 0.0631, 15.9 mm."""
    said, wave, machine = told(tmp_path, EVEN, capsys)
    periods = [wave["parameters"]["period_mm"]["value"], *wave["aliases_mm"]]
    for period in (20.82, 15.86, PERIOD):
        assert any(p == pytest.approx(period, rel=2e-3) for p in periods)
    # a period may have any scale: of those that fit alike a long one
    assert wave["parameters"]["period_mm"]["value"] > 15.0
    assert holds(wave, PERIOD)
    assert main(["diagnose", str(tmp_path / "r.csv"), "--machine", str(tmp_path / "machine")]) == 0
    text = capsys.readouterr().out
    assert (
        "The targets stand at even distances and show these periods alike: " in text
        and "20.82 mm" in text
    )
    assert "cyclic:X is NOT written: its period is one of" in said
    assert "[[effect]]" not in machine


def test_it_is_written_where_it_is_asked_for(tmp_path, capsys):
    *_, machine = told(tmp_path, EVEN, capsys, "--accept", "cyclic:X")
    assert "[[effect]]" in machine and "cyclic" in machine


def test_uneven_targets_tell_the_period(tmp_path, capsys):
    _, wave, machine = told(tmp_path, UNEVEN, capsys)
    assert "aliases_mm" not in wave
    assert wave["parameters"]["period_mm"]["value"] == pytest.approx(PERIOD, abs=0.02)
    assert holds(wave, PERIOD) and "period_mm" in machine
