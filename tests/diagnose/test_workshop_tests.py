"""Tests of workshops as they are made: a screw that warms up and cools down (ISO 230-3), one
that is worn on one flank, a part whose bores another tool made."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from postproc import effects
from postproc.cli import main
from postproc.effects import State, backlash_position, screw_heat

MACHINE = """format = "gcomp-machine/1"
name = "mill"
chain = "w-X-Z-b-Y-t"
control = "linuxcnc"
source = "made up"
"""
LASER = 'kind = "targets"\ninstrument = "laser interferometer"\nsensitive = { X = 1 }\n'


def answered(folder: Path, kind: str, names: str, rows: list[str]) -> dict:
    """The answer to a recording on a mill of 300 mm without errors."""
    path, answer, machine = folder / "r.csv", folder / "a.json", folder / "mill"
    machine.mkdir()
    text = MACHINE
    for x in "XYZ":
        (machine / f"{x}.csv").write_text(f"{x}_mm,E{x}{x}_um\n0,0\n300,0\n")
        text += f'[axes.{x}]\ntravel = [0.0, 300.0]\nleast_increment = 0.0001\ntable = "{x}.csv"\n'
    (machine / "machine.toml").write_text(text)
    head = f'format = "gcomp-recording/1"\nmachine = "mill"\n{kind}'
    path.write_text("".join(f"# {x}\n" for x in head.splitlines()) + "\n".join([names, *rows, ""]))
    main(["diagnose", str(path), "--machine", str(machine), "--json", str(answer), "--quiet"])
    return json.loads(answer.read_text())


def named(answer: dict) -> dict[str, dict]:
    return {
        e["effect"]: {k: v["value"] for k, v in e["parameters"].items()}
        for e in answer["effects"]
        if e["status"] == "accepted"
    }


def state(time: list[float]) -> State:
    n = len(time)
    at = {"X": np.full(n, 100.0)}
    return State(at, {"X": np.ones(n)}, {"X": (0.0, 400.0)}, time=np.array(time))


def test_a_screw_cools_with_the_time_constant_with_which_it_was_heated():
    """50 um/m at 100 mm from where it is held, heated for 600 s with a time constant of 600 s:
    5 (1 - 1/e) um then, 1/e of that 600 s later."""
    heat = dict(grown_ppm=50.0, tau_s=600.0, free=0.0, until_s=600.0)
    found = effects.deviation(screw_heat, state([60.0, 660.0, 1260.0]), "X", **heat)[0] * 1e3
    assert found == pytest.approx([0.0, 5 * (1 - np.exp(-1)), 5 * (np.exp(-1) - np.exp(-2))])


@pytest.mark.parametrize("held_mm", [0.0, 150.0])
def test_a_test_of_warming_up_and_cooling_down_names_the_screw(tmp_path, held_mm):
    """ISO 230-3: between its readings the axis runs to and fro for 50 min, then it rests."""
    rng, rows = np.random.default_rng(4), []
    for run in range(21):
        for k, x in enumerate((20, 90, 160, 250, 250, 160, 90, 20)):
            t = 270.0 * run + 4.0 * k
            rise = 1 - np.exp(-min(t, 3000.0) / 1200.0)
            heat = 60.0 * rise * np.exp(-max(t - 3000.0, 0.0) / 1200.0)
            y = heat * (x - held_mm) * 1e-3 + rng.normal(0, 0.2)
            rows.append(f"{run + 1},{t:.1f},{x},{1 if k < 4 else -1},{y:.2f}")
    found = named(answered(tmp_path, LASER, "run,t_s,X_mm,approach_X,reading_um", rows))
    assert list(found) == ["screw_heat"]
    said = found["screw_heat"]
    assert said["grown_ppm"] == pytest.approx(60.0, rel=0.1)
    assert said["tau_s"] == pytest.approx(1200.0, rel=0.15)
    assert said["until_s"] == pytest.approx(3000.0, abs=270.0)


@pytest.mark.parametrize("flank", [1, -1])
def test_a_flank_that_is_worn_shows_where_the_axis_comes_from_its_side(tmp_path, flank):
    """3 um lost, and 12 um more between 110 and 210 mm by readings of one direction."""
    rng, rows = np.random.default_rng(6), []
    places = np.round(np.linspace(10, 290, 29) + rng.uniform(-2, 2, 29), 1)
    for run in range(5):
        for way in (1, -1):
            for x in places[::way]:
                inside = np.clip((50 - abs(x - 160)) / 15, 0, 1)
                y = -way * (1.5 + 12.0 * inside * (way == flank)) + rng.normal(0, 0.15)
                rows.append(f"{run + 1},{10.0 * len(rows)},{x},{way},{y:.2f}")
    answer = answered(tmp_path, LASER, "run,t_s,X_mm,approach_X,reading_um", rows)
    assert list(named(answer)) == ["backlash_position"]
    said = named(answer)["backlash_position"]
    assert said["flank"] == flank and said["worn_um"] == pytest.approx(12.0, abs=2.0)
    assert said["worn_mm"] == pytest.approx(160.0, abs=5.0)


def test_a_worn_flank_is_in_the_table_of_its_direction_alone():
    """2 um all along, and 10 um more where readings stand: -1 - 10 um where the axis comes in +, 1
    where it comes in -, by table as by reading."""
    shape = dict(b0_um=2.0, worn_um=10.0, worn_mm=100.0, wide_mm=80.0, flank=1.0)
    ((_, _, nodes, forward, reverse),) = backlash_position.tables("X", (0.0, 400.0), **shape)
    there = int(np.argmin(np.abs(nodes - 100.0)))
    assert forward[there] * 1e3 == pytest.approx(-11.0, abs=0.01)
    assert reverse * 1e3 == pytest.approx(1.0)
    two = state([60.0, 90.0])
    two.approach["X"][1] = -1.0
    found = effects.deviation(backlash_position, two, "X", **shape)[0] * 1e3
    assert found == pytest.approx([-11.0, 1.0])


@pytest.mark.parametrize("bored_um, bores", [(0.0, 0.0), (-12.0, 1.0)])
def test_bores_of_another_tool_are_no_lost_motion(tmp_path, bored_um, bores):
    """A cutter 12 um too small: pockets are 12 um too small, bosses as much too large, bores too if
    it makes them; what is between two walls of the same side is right."""
    rng, rows = np.random.default_rng(8), []
    of_kind = {
        "pocket_size": (-12.0, (84, 76, 46)),
        "boss_diameter": (12.0, (63, 40, 30)),
        "bore_diameter": (bored_um, (23, 18, 12)),
        "centre_distance": (0.0, (110, 100, 60)),
    }
    for kind, (off, sizes) in of_kind.items():
        for size in sizes:
            for axis in "XZ" if kind in ("pocket_size", "centre_distance") else "X":
                for part in (1, 2, 3):
                    read = size + 1e-3 * (off + rng.normal(0, 1.0))
                    rows.append(f"{kind[:2]}{axis}{size},{kind},{axis},{size},{read:.6f},{part},1")
    names = "feature,kind,axis,nominal_mm,measured_mm,part,reading"
    found = named(answered(tmp_path, 'kind = "features"\n', names, rows))
    assert list(found) == ["tool_size"]
    assert found["tool_size"]["diameter_um"] == pytest.approx(-12.0, abs=1.0)
    assert found["tool_size"]["bores"] == bores
