"""Loads that a recording of targets holds: they bend the axis as forces do, and a beam in
proportion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc import effects, recordings
from postproc.diagnose import assembly, library
from postproc.diagnose.analysis import diagnose
from postproc.effects import State, force_compliance, sag
from postproc.machine.file import read_machine

MILL = read_machine(Path(__file__).parents[2] / "machines" / "example-mill")


def recording(column: str = "load_X_N"):
    """Four runs over 15 targets, two of them under 500 N, by which X gives 0.02 um a newton."""
    head = [
        'format = "gcomp-recording/1"',
        'kind = "targets"',
        'machine = "example-mill"',
        'instrument = "laser"',
    ]
    head += ['quantity = "displacement"', "sensitive = { X = 1.0 }"]
    lines = [f"# {line}" for line in head]
    lines.append(f"run,t_s,X_mm,Y_mm,Z_mm,approach_X,approach_Y,approach_Z,reading_um,{column}")
    noise, t = np.random.default_rng(4), 0.0
    for run in (1, 2, 3, 4):
        load = 500.0 * (run % 2)
        for way in (1, -1):
            for k in range(-7, 8)[::way]:
                t += 5.0
                place = np.array([[30.0 * k], [0.0], [0.0]])
                off = MILL.deviation(place, np.array([[way], [1.0], [1.0]]))[0, 0] * 1e3
                value = off + 0.02 * load + noise.normal(0, 0.3)
                lines.append(f"{run},{t},{30 * k},0,0,{way},1,1,{value:.2f},{load}")
    return recordings.read(recordings.Source("a.csv", "\n".join([*lines, ""]).encode()))


@pytest.mark.parametrize("column", ["load_X_N", "force_X_N"])
def test_a_load_is_a_driver_as_a_force_is(column):
    d = diagnose([recording(column)], MILL)
    (finding,) = d.findings
    assert finding.block.key == "force_compliance:X"
    assert finding.value["um_per_N"] == pytest.approx(0.02, rel=0.1)


def test_any_load_is_a_channel():
    found = assembly.of([recording("load_table_N")], MILL)
    assert "load_table_N" in found.state.channels
    assert not library.needed(found, effects.load("force_compliance"), "X")


def state(**channels: np.ndarray) -> State:
    n = len(next(iter(channels.values())))
    place = {x: np.linspace(0.0, 100.0, n) for x in "XYZ"}
    return State(
        place, {x: np.ones(n) for x in "XYZ"}, dict.fromkeys("XYZ", (0.0, 100.0)), channels=channels
    )


def test_where_both_were_recorded_either_or_their_sum_may_bend_it():
    force, load = np.array([0.0, 10.0, 20.0]), np.array([100.0, 50.0, 0.0])
    both = state(force_X_N=force, load_X_N=load)
    for by, wanted in ((0.0, force), (1.0, load), (2.0, force + load)):
        assert force_compliance.columns(both, "X", by=by)[0, 0] * 1e3 == pytest.approx(wanted)
    assert {s["by"] for s in force_compliance.shapes(both, "X")} == {0.0, 1.0, 2.0}
    one = replace(both, channels={"load_X_N": load})
    assert force_compliance.columns(one, "X")[0, 0] * 1e3 == pytest.approx(load)
    assert {s["by"] for s in force_compliance.shapes(one, "X")} == {0.0}


def test_a_mass_that_was_weighed_sags_in_proportion():
    load = np.array([100.0, 200.0, 200.0])
    at = state(load_X_N=load)
    heavy = [s for s in sag.shapes(at, "X") if s["usual_N"]]
    assert heavy and all(s["usual_N"] == 200.0 for s in heavy)
    plain = {**heavy[0], "usual_N": 0.0}
    assert sag.columns(at, "X", **heavy[0]) == pytest.approx(
        sag.columns(at, "X", **plain) * load / 200.0
    )
    assert not any(s["usual_N"] for s in sag.shapes(state(load_X_N=np.full(3, 200.0)), "X"))


@pytest.mark.parametrize(
    ("loads", "powers"),
    [
        ((0.0, 500.0, 505.0), {1.0}),
        ((0.0, 500.0, -500.0), {1.0}),
        ((0.0, 250.0, 500.0), {1.0, 0.8, 2 / 3}),
    ],
)
def test_one_load_does_not_tell_by_which_power_it_bends(loads, powers):
    """Of 500 N and none 2/3 and 0.8 say the same: which of them was named was a matter of
    rounding, and at 250 N they are 26 % apart from a spring."""
    found = state(force_X_N=np.array(loads))
    assert {s["power"] for s in force_compliance.shapes(found, "X")} == powers
