"""An instrument that switches between levels is told from an axis that loses steps, and from
what turns do; and of a leaning slide that yaws as it turns the squareness has two values."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from postproc import effects
from postproc.cli import main
from postproc.effects import State

MACHINE = """format = "gcomp-machine/1"
name = "m"
control = "linuxcnc"
chain = "w-b-X-Y-t"
[axes.X]
least_increment = 0.0001
travel = [0.0, 400.0]
[axes.Y]
least_increment = 0.0001
travel = [0.0, 200.0]
"""
HEAD = (
    '# format = "gcomp-recording/1"\n# kind = "trace"\n# machine = "m"\n# instrument = "control"\n#'
    ' sees = "{}"\n'
)
TIME = np.arange(4000) * 0.01
PLACE = 200 + 40 * np.sin(2 * np.pi * TIME / 7.0)  # X to and fro, eleven turns
NOISE = np.random.default_rng(5).normal(0, 0.2, (2, len(TIME)))


def switched(at: list[float], size_um: float) -> np.ndarray:
    """um: two levels, from one to the other at each of these moments, s."""
    return size_um * (np.searchsorted(at, TIME) % 2)


def told(
    folder: Path, error_um: np.ndarray, sees: str = "scale", across_um: np.ndarray | float = 0.0
) -> list[dict]:
    """The accepted effects of a trace of X with an error, um, and Y at rest with another."""
    x, y = PLACE + (error_um + NOISE[0]) * 1e-3, 100 + (across_um + NOISE[1]) * 1e-3
    rows = [
        f"1,{t:.3f},{c:.6f},100.000000,{a:.6f},{b:.6f}"
        for t, c, a, b in zip(TIME, PLACE, x, y, strict=True)
    ]
    file = folder / "trace.csv"
    file.write_text(
        HEAD.format(sees) + "run,t_s,X_cmd_mm,Y_cmd_mm,X_act_mm,Y_act_mm\n" + "\n".join(rows) + "\n"
    )
    (folder / "machine").mkdir()
    (folder / "machine" / "machine.toml").write_text(MACHINE)
    main(
        [
            "diagnose",
            str(file),
            "--machine",
            str(folder / "machine"),
            "--json",
            str(folder / "a.json"),
            "--quiet",
        ]
    )
    answer = json.loads((folder / "a.json").read_text())
    return [f for f in answer["effects"] if f["status"] == "accepted"]


def test_there_and_back_several_times_is_the_instrument(tmp_path):
    assert not told(tmp_path, switched([3.1, 9.4, 13.0, 24.3, 31.7], 4.0))


def test_a_lost_step_beside_an_instrument_that_switches(tmp_path):
    """Y's reading switches, which is said; what X lost stays lost, and is told as a name that may
    be another: the same electronics read X."""
    at = [3.1, 9.4, 13.0, 24.3, 31.7]
    assert not told(tmp_path, switched([20.2], 4.0), across_um=switched(at, 4.0))
    answer = json.loads((tmp_path / "a.json").read_text())
    (found,) = answer["effects"]
    assert (found["effect"], found["axis"], found["status"]) == ("step_loss", "X", "tentative")
    assert found["parameters"]["t_s"]["value"] == pytest.approx(20.2, abs=0.02)
    assert any("switches between two levels, 5 times by about 4 um" in n for n in answer["notices"])


def test_a_jump_that_stays_is_a_lost_step(tmp_path):
    (found,) = told(tmp_path, switched([13.0], 4.0))
    assert found["effect"] == "step_loss" and found["axis"] == "X"
    assert found["parameters"]["jump_um"]["value"] == pytest.approx(4.0, abs=0.3)


def test_many_levels_are_the_instrument(tmp_path):
    """A level that is drawn anew whenever it pleases, six times in X, five in Y. One of the jumps
    alone would be a lost step."""
    x = np.array([0.0, 3.0, -2.0, 4.0, 1.0, -3.0, 2.0])
    y = np.array([0.0, -3.0, 1.0, -2.0, 2.0, -1.0])
    assert not told(
        tmp_path,
        x[np.searchsorted([3.1, 9.4, 13.0, 20.2, 24.3, 31.7], TIME)],
        across_um=y[np.searchsorted([5.2, 10.9, 16.1, 27.5, 34.0], TIME)],
    )
    answer = json.loads((tmp_path / "a.json").read_text())
    assert answer["verdict"] == "nothing-left-out"
    assert [n.split(" jumps ")[0] for n in answer["notices"] if "burst noise" in n] == [
        "trace.csv: X_act_mm",
        "trace.csv: Y_act_mm",
    ]


def test_steps_that_are_lost_to_one_side_are_no_levels(tmp_path):
    """Three times 4 um more, never back: a motor that loses steps."""
    found = told(tmp_path, 4.0 * np.searchsorted([9.4, 16.2, 26.4], TIME))
    assert [(f["effect"], f["axis"]) for f in found] == [("step_loss", "X")]


def test_what_one_signal_does_again_and_again_is_no_lost_step(tmp_path):
    """Pulses of 4 um, seven times, that fade within four seconds: each begins like a lost step."""
    starts = np.array([3.1, 9.4, 13.0, 20.2, 24.3, 31.7, 36.0])
    later = np.maximum(TIME[:, None] - starts, 0.0)
    assert not told(tmp_path, ((later > 0) * 4.0 * np.exp(-later / 4.0)).sum(axis=1))


def test_what_changes_with_every_turn_is_the_machine(tmp_path):
    """10 um of lost motion that the scale at the tool sees: two levels too, but the axis makes
    them."""
    names = [
        f["effect"]
        for f in told(tmp_path, -5.0 * np.sign(np.cos(2 * np.pi * TIME / 7.0)), sees="tool")
    ]
    assert names and names[0] in ("backlash", "windup", "coulomb_friction", "backlash_position")


def test_a_leaning_slide_that_yaws_as_it_turns(tmp_path):
    """60 urad, and 40 urad more or less about the zero of X: across, 200 mm from there, 4 um to
    either side."""
    side = np.sign(np.cos(2 * np.pi * TIME / 7.0))
    (found,) = told(
        tmp_path, np.zeros(len(TIME)), sees="tool", across_um=-(60 + 20 * side) * PLACE * 1e-3
    )
    assert found["effect"] == "squareness" and found["axis"] == "XY"
    assert found["parameters"]["urad"]["value"] == pytest.approx(60.0, abs=4.0)
    at_200 = (
        found["parameters"]["turn_um"]["value"] - 0.2 * found["parameters"]["turn_urad"]["value"]
    )
    assert at_200 == pytest.approx(-8.0, abs=0.3)


def test_a_slide_that_only_yaws_as_it_turns_has_no_name(tmp_path):
    """The angle between the axes is right in the mean: no word of the contract says it."""
    side = np.sign(np.cos(2 * np.pi * TIME / 7.0))
    across_um = -20.0 * side * PLACE * 1e-3
    assert told(tmp_path, np.zeros(len(TIME)), sees="tool", across_um=across_um) == []


def test_a_squareness_with_two_values_is_written_as_a_table_of_two_directions():
    module = effects.load("squareness")
    ((component, axis, nodes, forward, reverse),) = module.tables(
        "XY", (0.0, 400.0), urad=50.0, turn_urad=40.0, turn_um=3.0
    )
    for side, table in ((1.0, forward), (-1.0, reverse)):
        state = State(
            {"X": np.zeros(2), "Y": nodes},
            {"X": np.ones(2), "Y": np.full(2, side)},
            {"X": (0.0, 1.0)},
        )
        shown = effects.deviation(module, state, "XY", urad=50.0, turn_urad=40.0, turn_um=3.0)
        assert (component, axis) == ("EX", "Y") and shown[0] == pytest.approx(table, abs=1e-12)
