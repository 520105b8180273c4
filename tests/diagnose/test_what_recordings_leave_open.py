"""Cells that are empty, times that are coarse, parts with names, axes that turn, a spindle that
turns the other way: what recordings hold is used, whichever way it is written."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc import effects, recordings
from postproc.diagnose import (
    assembly,
    drive,
    experiments,
    machine_effects,
    plausibility,
    report,
)
from postproc.diagnose.analysis import diagnose
from postproc.effects import State
from postproc.machine.file import read_machine

MACHINES = Path(__file__).parents[2] / "machines"
MILL = read_machine(MACHINES / "example-mill")


def recording(kind: str, columns: dict[str, list], *head: str, machine: str = "example-mill"):
    """From columns of cells as they are written."""
    lines = [f'# format = "gcomp-recording/1"\n# kind = "{kind}"\n# machine = "{machine}"']
    lines += [f"# {line}" for line in head] + [",".join(columns)]
    lines += [",".join(str(c) for c in row) for row in zip(*columns.values(), strict=True)]
    return recordings.read(recordings.Source("a.csv", "\n".join([*lines, ""]).encode()))


def trace(n: int, step: float, decimals: int = 4, lag_s: float = 0.0, **more: list):
    """X to and fro over 40 mm, late by so much."""
    t = np.arange(n) * step
    x, v = 50 + 20 * np.sin(4 * t), 80 * np.cos(4 * t)
    noise = np.random.default_rng(0).normal(0, 1e-4, n)
    columns = {
        "run": [1] * n,
        "t_s": [f"{a:.{decimals}f}" for a in t],
        "X_cmd_mm": [f"{a:.5f}" for a in x],
        "X_act_mm": [f"{a:.5f}" for a in x - lag_s * v + noise],
    }
    return recording("trace", columns | more)


def test_a_temperature_that_is_read_once_in_a_hundred_samples_is_known_in_a_long_trace():
    n = 12000
    warm = [f"{20 + 5 * k / n:.3f}" if k % 100 == 0 else "" for k in range(n)]
    found = assembly.of([trace(n, 0.01, T_screw_X_C=warm)], MILL).state
    assert found.channels["T_screw_X_C"].max() == pytest.approx(25.0, abs=0.1)
    assert found.channels["T_screw_X_C"].min() == pytest.approx(20.0, abs=0.1)


def test_times_with_two_decimals_tell_the_lag_of_a_log_of_a_kilohertz():
    d = diagnose([trace(3000, 0.001, decimals=2, lag_s=0.002)], MILL)
    (finding,) = d.findings
    assert finding.block.key == "servo_lag:X"
    assert finding.value["tau_ms"] == pytest.approx(2.0, abs=0.05)
    assert any("at even distances" in said for said in d.notices)


def test_times_with_a_pause_are_spread_on_either_side_of_it():
    moved = trace(1000, 0.001, decimals=2)
    times = moved.columns["t_s"] + np.where(np.arange(1000) < 500, 0.0, 3.0)
    late = replace(moved, columns=moved.columns | {"t_s": times})
    steps = np.diff(plausibility.checked([late], MILL).recordings[0].columns["t_s"])
    assert np.median(steps) == pytest.approx(0.001) and steps.min() > 0
    assert np.flatnonzero(steps > 0.1).tolist() == [499]


def test_an_empty_cell_costs_a_force_one_sample():
    t = np.arange(6000) * 0.002
    force = 30 * np.sign(np.cos(4 * t)) + np.random.default_rng(1).normal(0, 1, 6000)
    cells = ["" if k == 3210 else f"{f:.3f}" for k, f in enumerate(force)]
    (found,) = drive.drives([trace(6000, 0.002, force_X_N=cells)])
    assert [f.term.name for f in found.fitted] == ["coulomb_friction"]


@pytest.mark.parametrize(
    ("names", "numbers"),
    [
        (["3", "4", "5"], [3.0, 4.0, 5.0]),
        (["3", "", "5"], [3.0, 0.0, 5.0]),
        (["A1", "A2", "A3"], [1.0, 2.0, 3.0]),
        (["1.2.3", "1.2.4", "x"], [1.0, 2.0, 3.0]),
        (["2", "2b", "\N{SUPERSCRIPT TWO}"], [1.0, 2.0, 3.0]),
    ],
)
def test_parts_have_numbers_or_are_counted(names, numbers):
    n = len(names)
    columns = {
        "feature": ["F"] * n, "kind": ["pocket_size"] * n, "axis": ["X"] * n,
        "nominal_mm": [40] * n, "measured_mm": [40.01] * n, "part": names, "reading": [1] * n,
    }  # fmt: skip
    usable = plausibility.checked([recording("features", columns)], MILL)
    assert assembly.of(usable.recordings, MILL).state.channels["part"].tolist() == numbers
    counted = numbers == [1.0, 2.0, 3.0]
    assert any("parts have names" in said for said in usable.notices) is counted


@pytest.mark.parametrize("angle", [0.0, 90.0])
def test_a_machine_says_what_readings_are_where_its_rotary_axes_stand(angle):
    machine = read_machine(MACHINES / "example-five-axis")
    n = 11
    columns = {
        "run": [1] * n, "t_s": [5 * k for k in range(n)], "X_mm": [10 * k for k in range(n)],
        "Y_mm": [30.0] * n, "Z_mm": [0.0] * n, "A_deg": [angle] * n, "approach_X": [1] * n,
        "approach_Y": [1] * n, "approach_Z": [1] * n, "reading_um": [0.1] * n,
    }  # fmt: skip
    head = ('instrument = "laser"', 'quantity = "displacement"', "sensitive = { X = 1.0 }")
    found = assembly.of([recording("targets", columns, *head, machine=machine.name)], machine)
    place, side = np.zeros((5, n)), np.zeros((5, n))
    place[0], place[1], place[3] = 10 * np.arange(n), 30.0, angle
    side[:3] = 1.0
    assert found.known == pytest.approx(machine.deviation(place, side)[0])


def state(**channels: np.ndarray) -> State:
    n = 20
    return State(
        position={"Z": np.linspace(0, 500, n)},
        approach={"Z": np.ones(n)},
        travel={"Z": (0.0, 500.0)},
        time=60.0 * np.arange(n),
        run=np.ones(n),
        file=np.zeros(n),
        passage=-np.ones(n),
        channels=channels,
    )


def test_a_spindle_that_turns_the_other_way_grows_as_much():
    module = effects.load("spindle_growth")
    rpm = np.where(np.arange(20) > 3, 3000.0, 0.0)
    here, there = state(spindle_rpm=rpm), state(spindle_rpm=-rpm)
    shapes = module.shapes(here, "Z")
    assert module.shapes(there, "Z") == shapes
    for shape in shapes:
        assert module.columns(there, "Z", **shape) == pytest.approx(
            module.columns(here, "Z", **shape)
        )


def test_a_screw_whose_temperature_nobody_recorded_does_not_grow_by_it():
    module = effects.load("screw_heat")
    grown = {"alpha_ppm_K": 11.0, "held_at_mm": 0.0, "tau_s": 0.0}
    assert not effects.deviation(module, state(), "Z", **grown).any()
    warm = state(T_screw_Z_C=20.0 + np.arange(20) / 19)
    assert effects.deviation(module, warm, "Z", **grown)[2, -1] == pytest.approx(5.5e-3)


def test_a_third_jump_without_a_second_is_as_large_as_stated():
    module = effects.load("step_loss")
    off = effects.deviation(module, state(), "Z", jump_um=3.0, t_s=5.0, third_um=7.0, third_s=300.0)
    assert off[2, [0, 1, 6]] * 1e3 == pytest.approx([0.0, 3.0, 10.0])


def test_a_comma_in_the_name_of_a_feature_is_no_new_column():
    sizes, noise = [20.0, 30.0, 40.0], np.random.default_rng(2)
    rows = [(size, part, k) for part in (1, 2, 3) for size in sizes for k in (1, 2, 3)]
    n = len(rows)
    columns = {
        "feature": [f'"hole, left {size:g}"' for size, _, _ in rows],
        "kind": ["pocket_size"] * n, "axis": ["X"] * n, "nominal_mm": [r[0] for r in rows],
        "measured_mm": [f"{r[0] + noise.normal(0, 3e-4):.4f}" for r in rows],
        "part": [r[1] for r in rows], "reading": [r[2] for r in rows],
    }  # fmt: skip
    head, *table = csv.reader(
        report.residual_rows(diagnose([recording("features", columns)], MILL))
    )
    assert {len(row) for row in table} == {len(head)}
    assert table[0][2] == "measured_mm hole, left 20 pocket_size"


def test_a_machine_with_one_axis_is_asked_for_no_circle(tmp_path):
    (tmp_path / "machine.toml").write_text(
        'format = "gcomp-machine/1"\nname = "one"\ncontrol = "linuxcnc"\nchain = "w-b-X-t"\n'
        'source = "t"\n[axes.X]\ntravel = [0.0, 500.0]\nleast_increment = 0.001\n'
    )
    one = read_machine(tmp_path)
    for effect in ("reversal_spike", "friction_asymmetry"):
        assert "--test feeds:X " in experiments.showing(effect, "X", one)
        assert "--test ballbar:XY" in experiments.showing(effect, "X", MILL)


@pytest.mark.parametrize(
    ("instrument", "gauged"),
    [
        ("in-process gauge", 1.0),
        ("dial gauge", 1.0),
        ("step gauge", 0.0),
        ("Step-Gauge 500 mm", 0.0),
        ("gauge block comparator", 0.0),
        ("laser gauge", 0.0),
        ("", 0.0),
    ],
)
def test_no_tool_wears_between_two_readings_of_a_standard(instrument, gauged):
    n = 8
    columns = {
        "run": [1] * n, "t_s": [5 * k for k in range(n)], "X_mm": [10 * k for k in range(n)],
        "Y_mm": [0.0] * n, "Z_mm": [0.0] * n, "approach_X": [1] * n, "approach_Y": [1] * n,
        "approach_Z": [1] * n, "reading_um": [0.1] * n,
    }  # fmt: skip
    head = (f'instrument = "{instrument}"', 'quantity = "displacement"', "sensitive = { X = 1.0 }")
    found = assembly.of([recording("targets", columns, *head)], MILL).state
    assert np.unique(found.channels["gauged"]).tolist() == [gauged]


def soak(drift_um: float, start_s: float):
    """Two hours at one place, a reading each minute."""
    n = 120
    noise = np.random.default_rng(int(start_s) + 1).normal(0, 0.2, n)
    columns = {
        "run": [1] * n, "t_s": [start_s + 60 * k for k in range(n)], "X_mm": [0.0] * n,
        "Y_mm": [0.0] * n, "Z_mm": [0.0] * n, "approach_X": [1] * n, "approach_Y": [1] * n,
        "approach_Z": [1] * n, "reading_um": np.round(drift_um * np.arange(n) / n + noise, 2),
    }  # fmt: skip
    head = ('instrument = "dial gauge"', 'quantity = "displacement"', "sensitive = { X = 1.0 }")
    return recording("targets", columns, *head)


def test_a_drift_of_one_recording_goes_into_no_machine():
    """Its number there is another recording's in the next experiment, or nobody's."""
    d = diagnose([soak(12.0, 0.0), soak(0.0, 9000.0)], MILL)
    (finding,) = d.findings
    assert finding.block.key == "structure_drift:X" and finding.value["file"] == 0.0
    (said,) = machine_effects.not_told_apart(d, ())
    assert "NOT written: it happened in these recordings" in said
    assert not machine_effects.with_effects(d, ()).effects
    accepted = machine_effects.with_effects(d, ("structure_drift:X",))
    assert len(accepted.effects) == 1


def test_a_drift_of_a_recording_that_is_not_there_is_none():
    module = effects.load("structure_drift")
    drift = {"size_um": 5.0, "tau_s": 1e6, "file": 1.0}
    assert not effects.deviation(module, state(), "Z", **drift).any()
    assert effects.deviation(module, state(), "Z", **drift | {"file": 0.0}).any()


def test_a_jump_that_happened_goes_into_no_machine():
    """The next recording would be told that it jumps at the same second."""
    n = 180
    place, noise = np.tile(np.arange(-9, 9) * 38.0, 10), np.random.default_rng(5).normal(0, 0.3, n)
    off = np.array(
        [MILL.deviation(np.array([[p], [0], [0]]), np.ones((3, 1)))[0, 0] for p in place]
    )
    columns = {
        "run": np.repeat(np.arange(1, 11), 18), "t_s": 5 * np.arange(n), "X_mm": place,
        "Y_mm": [0.0] * n, "Z_mm": [0.0] * n, "approach_X": [1] * n, "approach_Y": [1] * n,
        "approach_Z": [1] * n,
        "reading_um": np.round(off * 1e3 + 8.0 * (np.arange(n) > 80) + noise, 2),
    }  # fmt: skip
    head = ('instrument = "laser"', 'quantity = "displacement"', "sensitive = { X = 1.0 }")
    d = diagnose([recording("targets", columns, *head)], MILL)
    (finding,) = d.findings
    assert finding.block.key == "step_loss:X" and finding.status == "accepted"
    assert not machine_effects.with_effects(d, ()).effects


@pytest.mark.parametrize("anew", [True, False])
def test_a_clock_that_begins_anew_with_each_run_is_told(anew):
    moved = trace(600, 0.01)
    k = np.arange(600)
    columns = moved.columns | {"run": 1 + k // 200, "t_s": 0.01 * (k % 200 if anew else k)}
    said = plausibility.checked([replace(moved, columns=columns)], MILL).notices
    assert any("t_s begins anew in run 2 and 1 more" in one for one in said) is anew


@pytest.mark.parametrize("empty", [(), (1500,), range(3000)])
def test_where_a_recorded_speed_is_empty_the_places_say_it(empty):
    t = np.arange(3000) * 0.002
    speed = [f"{v:.4f}" for v in 80 * np.cos(4 * t)]
    for k in empty:
        speed[k] = ""
    force = 30 * np.sign(np.cos(4 * t)) + np.random.default_rng(1).normal(0, 1, 3000)
    moved = trace(
        3000, 0.002, X_cmd_velocity_mm_s=speed, X_act_velocity_mm_s=speed,
        force_X_N=[f"{f:.3f}" for f in force],
    )  # fmt: skip
    state = assembly.of([moved], MILL).state
    assert np.isfinite(state.velocity["X"]).all() and np.isfinite(state.acceleration["X"]).all()
    assert np.abs(state.velocity["X"]).max() == pytest.approx(80.0, abs=0.5)
    (found,) = drive.drives([moved])
    assert [f.term.name for f in found.fitted] == ["coulomb_friction"]


@pytest.mark.parametrize(
    ("speeds", "powers"),
    [((0, 3000), {1.0}), ((0, 2998, 3001), {1.0}), ((0, 1500, 3000), {1.0, 5 / 3})],
)
def test_one_speed_does_not_tell_by_which_power_it_heats(speeds, powers):
    found = state(spindle_rpm=np.resize(np.array(speeds, float), 20))
    assert {s["power"] for s in effects.load("spindle_growth").shapes(found, "Z")} == powers


def test_rows_by_targets_are_put_in_the_order_of_time():
    """Three runs to and fro, written target by target: each run changes from row to row, so that no
    run alone runs backwards."""
    place = np.tile(np.concatenate([np.arange(10.0), np.arange(10.0)[::-1]]), 3) * 30
    n = len(place)
    columns = {
        "run": np.repeat([1, 2, 3], 20), "t_s": 5 * np.arange(n), "X_mm": place, "Y_mm": [0.0] * n,
        "Z_mm": [0.0] * n, "approach_X": np.tile(np.repeat([1, -1], 10), 3), "approach_Y": [1] * n,
        "approach_Z": [1] * n, "reading_um": np.random.default_rng(0).normal(0, 0.3, n).round(2),
    }  # fmt: skip
    head = ('instrument = "laser"', 'quantity = "displacement"', "sensitive = { X = 1.0 }")
    straight = recording("targets", columns, *head)
    by_target = straight.pick(np.lexsort((columns["run"], columns["approach_X"], place)))
    found = plausibility.checked([by_target], MILL)
    assert found.recordings[0].columns["t_s"].tolist() == columns["t_s"].tolist()
    (said,) = found.notices
    assert "they were put in order" in said and "anew" not in said


def test_a_line_of_the_program_that_is_not_written_is_not_the_mean_of_others():
    """A log that writes the line when it changes; 5 um that are there in its first tenth alone."""
    n = 4000
    moved = trace(n, 0.005, lag_s=0.0, line=[k // 50 if k % 50 == 0 else "" for k in range(n)])
    off = np.where(np.arange(n) < 400, 5e-3, 0.0)
    columns = moved.columns | {"X_act_mm": moved.columns["X_act_mm"] + off}
    d = diagnose([replace(moved, columns=columns)], MILL)
    early = [p for p in d.places if p.timed and p.times[1] < 2.5]
    assert early and all(p.program[1] <= 10 for p in early)


@pytest.mark.parametrize(("period", "left"), [(10.0, 0.01), (0.1, 0.02), (0.02, 0.4), (0.004, 1.0)])
def test_a_table_never_adds_to_a_wave(period, left):
    """Of a grating of 4 um over 1 m 200,000 nodes are less than one a period: between them lay
    another wave, and 0.71 um rms became 0.88."""
    wave = {"period_mm": period, "amplitude_um": 1.0, "phase_deg": 0.0}
    place = np.random.default_rng(0).uniform(0.0, 1000.0, 2000)
    off = np.cos(2 * np.pi * place / period)
    rest = off.copy()
    for _, _, nodes, forward, _ in effects.load("cyclic").tables("X", (0.0, 1000.0), **wave):
        rest -= np.interp(place, nodes, forward) * 1e3
    assert np.std(rest) <= left * np.std(off)
