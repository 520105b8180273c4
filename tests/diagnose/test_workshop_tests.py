"""Tests of workshops as they are made: a screw that warms up and cools down (ISO 230-3), one
that is worn on one flank, a part whose bores another tool made."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from postproc import effects
from postproc.cli import main
from postproc.effects import State, backlash_position, laser_air, screw_heat

MACHINE = """format = "gcomp-machine/1"
name = "mill"
control = "linuxcnc"
source = "made up"
"""
MILL, LATHE = 'chain = "w-X-Z-b-Y-t"\n', 'chain = "w-b-Z-X-t"\ndiameter = ["X"]\n'
LASER = 'kind = "targets"\ninstrument = "laser interferometer"\nsensitive = { X = 1 }\n'


def answered(
    folder: Path, kind: str, names: str, rows: list[str], *beside: str, kind_of: str = MILL
) -> dict:
    """The answer to a recording on a machine of 300 mm without errors, beside other files."""
    path, answer, machine = folder / "r.csv", folder / "a.json", folder / "mill"
    machine.mkdir()
    text = MACHINE + kind_of
    for x in [x for x in "XYZ" if f"-{x}-" in kind_of]:
        (machine / f"{x}.csv").write_text(f"{x}_mm,E{x}{x}_um\n0,0\n300,0\n")
        text += f'[axes.{x}]\ntravel = [0.0, 300.0]\nleast_increment = 0.0001\ntable = "{x}.csv"\n'
    (machine / "machine.toml").write_text(text)
    head = f'format = "gcomp-recording/1"\nmachine = "mill"\n{kind}'
    path.write_text("".join(f"# {x}\n" for x in head.splitlines()) + "\n".join([names, *rows, ""]))
    files = [str(path), *beside, "--machine", str(machine), "--json", str(answer)]
    main(["diagnose", *files, "--quiet"])
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
    shape = dict(b0_um=2.0, b1_um=0.0, worn_um=10.0, worn_mm=100.0, wide_mm=80.0, flank=1.0)
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


def test_a_screw_that_ran_warm_in_a_pause_is_named(tmp_path):
    """Read cold in three runs and warm in three: in between the axis ran for half an hour, of which
    nothing was recorded; 50 um/m were reached, and it cools with a time constant of 1500 s."""
    rng, rows = np.random.default_rng(11), []
    for run in range(6):
        for k, x in enumerate((20, 60, 100, 140, 180, 220, 260, 290)):
            t = 20.0 * (8 * run + k) + (1800.0 if run > 2 else 0.0)
            heat = 50.0 * np.exp(-(t - 2260.0) / 1500.0) if run > 2 else 0.0
            rows.append(f"{run + 1},{t:.1f},{x},1,{heat * x * 1e-3 + rng.normal(0, 0.3):.2f}")
    found = named(answered(tmp_path, LASER, "run,t_s,X_mm,approach_X,reading_um", rows))
    assert list(found) == ["screw_heat"]
    said = found["screw_heat"]
    assert said["from_s"] == pytest.approx(460.0) and said["to_s"] == pytest.approx(2280.0)
    reached = said["grown_ppm"] * -np.expm1((said["from_s"] - said["to_s"]) / said["tau_s"])
    assert reached == pytest.approx(50.0, rel=0.1)


def test_steps_behind_a_turn_name_what_winds_up(tmp_path):
    """Rows of ever larger steps behind a turn; what was travelled before each row was not recorded:
    the turn lies at its begin, though its first target can be reached without one."""
    rng, rows = np.random.default_rng(12), []
    steps = np.array([0.005, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 4, 8, 15, 30, 50])
    for run in range(3):
        for turn, way in ((180.0, -1), (180.0, 1), (120.0, 1), (120.0, -1)):
            for gone in steps:
                t = 3.0 * len(rows) + 40.0 * (len(rows) // len(steps))
                y = -way * (1 - 2 * np.exp(-gone / 4.0)) * 6.0 + rng.normal(0, 0.2)
                rows.append(f"{run + 1},{t:.1f},{turn + way * gone:.4f},{way},{y:.2f}")
    answer = answered(tmp_path, LASER, "run,t_s,X_mm,approach_X,reading_um", rows)
    assert list(named(answer)) == ["windup"]
    said = named(answer)["windup"]
    assert said["size_um"] == pytest.approx(12.0, rel=0.05)
    assert said["length_mm"] == pytest.approx(4.0, rel=0.1) and said["stairs"] == 1


def test_a_laser_left_at_20_degrees_reads_by_the_air_of_each_recording(tmp_path):
    """-0.93 um/(m K), air of 17, 21 and 26 degrees in three recordings, each of one temperature."""
    state = State(
        {"X": np.tile([0.0, 200.0], 3)},
        {"X": np.ones(6)},
        {"X": (0.0, 300.0)},
        time=np.arange(6.0),
        file=np.repeat([0.0, 1.0, 2.0], 2),
        beam=np.tile([0.0, 200.0], 3),
        channels={"T_air_C": np.repeat([17.0, 21.0, 26.0], 2)},
    )
    assert 2.0 in {shape["by"] for shape in laser_air.shapes(state, "")}
    found = laser_air.columns(state, "", by=2.0)[0] * -0.93 * 1e3
    air = np.array([-3.0, 1.0, 6.0])
    assert found[1::2] == pytest.approx(-0.93 * 0.2 * air) and found[::2] == pytest.approx(0.0)


def test_turned_diameters_beside_targets_are_diagnosed(tmp_path):
    """What is turned has no second wall at another place of the slide (was a traceback)."""
    rng, rows = np.random.default_rng(15), []
    for kind, size in (("boss_diameter", 28.0), ("bore_diameter", 36.0), ("bore_diameter", 17.0)):
        for part in (1, 2, 3):
            read = size + 1e-3 * rng.normal(0, 1.0)
            rows.append(f"{kind}{size:g},{kind},X,{size},{read:.4f},{part},1")
    parts, names = 'kind = "features"', "feature,kind,axis,nominal_mm,measured_mm,part,reading"
    head = f'format = "gcomp-recording/1"\nmachine = "mill"\n{parts}'.splitlines()
    features = tmp_path / "parts.csv"
    features.write_text("\n".join([*(f"# {line}" for line in head), names, *rows, ""]))
    places = np.linspace(10, 290, 12)
    targets = [
        f"{run},{100 * run + 5 * k}.0,{x:.2f},1,{rng.normal(0, 0.3):.2f}"
        for run in (1, 2, 3)
        for k, x in enumerate(places)
    ]
    names = "run,t_s,X_mm,approach_X,reading_um"
    answer = answered(tmp_path, LASER, names, targets, str(features), kind_of=LATHE)
    assert answer["verdict"] == "nothing-left-out" and len(answer["recordings"]) == 2


def test_bores_and_bosses_along_one_axis_are_first_of_all_a_tool(tmp_path):
    """A cutter 85 um too small, by a caliper of 10 um: lost motion of that axis would do it too."""
    rng, rows = np.random.default_rng(16), []
    for kind, size, off in (("bore", 46.7, -85.0), ("bore", 25.7, -85.0), ("boss", 25.2, 85.0)):
        for part in (1, 2, 3, 4, 5):
            read = size + 1e-3 * (off + rng.normal(0, 4.0))
            rows.append(f"{kind}{size:g},{kind}_diameter,Z,{size},{read:.2f},{part},1")
    names = "feature,kind,axis,nominal_mm,measured_mm,part,reading"
    answer = answered(tmp_path, 'kind = "features"\n', names, rows)
    assert list(named(answer)) == ["tool_size"]
    assert "backlash:Z" in answer["effects"][0]["equivalent"]
