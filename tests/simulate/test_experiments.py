"""Programs of tests: read by their control, inside the travel, and such that their instrument finds
what it needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

from postproc.errors import UsageError
from postproc.machine.file import read_machine
from postproc.simulate import asked, experiments
from postproc.simulate.timeline import Conditions

from .samples import MILL, ROOT, STUDER, read, real, timed

LATHE = read_machine(ROOT / "machines" / "example-lathe")
EVERY = [
    "positioning:{0}",
    "period:{0},way=20,runs=1",
    "arms:{0},runs=1",
    "straightness:{0}",
    "angle:{0}",
    "diagonal:{0}{1}",
    "ballbar:{0}{1},runs=1",
    "staircase:{0},runs=1",
    "feeds:{0},runs=1",
    "soak:{0},hours=0.2",
]
CONTROLS = (
    ["linuxcnc", "fanuc-mill", "haas", "grbl"],
    ["linuxcnc", "fanuc-lathe", "fanuc-lathe-a", "fanuc-lathe-c", "haas-lathe"],
)


@pytest.mark.parametrize("test", EVERY)
@pytest.mark.parametrize(
    ("machine", "axes", "controls"),
    [
        (MILL, "ZX", CONTROLS[0]),
        (MILL, "YZ", CONTROLS[0]),
        (LATHE, "ZX", CONTROLS[1]),
        (STUDER, "XZ", CONTROLS[1]),
    ],
)
def test_every_control_runs_every_test_alike_and_inside_the_travel(test, machine, axes, controls):
    test, length = test.format(*axes), None
    for control in controls:
        site = replace(machine, control=control)
        if control == "linuxcnc":
            site = replace(site, diameter=())  # G8 or G7 is what its operator sets
        own = experiments.write(test, site, control)
        t = timed(own.text, site, Conditions())
        assert t.outside() is None
        found = read(
            own.instrument,
            real(t),
            **(own.settings | ({"rate": "20"} if own.instrument in ("log", "ballbar") else {})),
        )
        assert len(found) > 5
        length = length or t.path.length.sum()
        assert t.path.length.sum() == approx(length, abs=0.01)  # to the rounding of the words


def test_positioning_takes_all_targets_from_both_sides_in_every_run():
    own = experiments.write("positioning:Z,runs=3,dwell=2", STUDER, "fanuc-lathe")
    found = read("laser", real(timed(own.text, STUDER, Conditions())), **own.settings)
    for run in (1, 2, 3):
        up, down = (
            found.position("Z")[(found.columns["run"] == run) & (found.approach("Z") == s)]
            for s in (1, -1)
        )
        assert up == approx(down[::-1]) and len(up) == 17 and (np.diff(up) > 0).all()
        assert up[0] == 0.0 and up[-1] == 510.0
    assert set(found.approach("X")) == {1.0}  # the resting axis has come from one side


def test_targets_are_no_multiples_of_a_pitch_unless_even_steps_are_wanted():
    loose, even = (
        asked.targets(0.0, 500.0, 25.0, False),
        asked.targets(0.0, 500.0, 25.0, True),
    )
    assert even.tolist() == list(np.arange(0.0, 501.0, 25.0))
    assert len(loose) == 21 and np.ptp(loose % 10.0) > 8.0
    assert np.abs(loose - even).max() <= 25 / 4 and (np.diff(loose) > 25 / 2 - 1e-9).all()


def test_a_ballbar_goes_round_in_both_senses():
    own = experiments.write("ballbar:XY,radius=100,feed=1500,runs=2", MILL, "linuxcnc")
    found = read("ballbar", real(timed(own.text, MILL, Conditions())), **own.settings)
    assert [int(found.columns["sense"][found.columns["run"] == r][0]) for r in (1, 2, 3, 4)] == [
        1,
        -1,
        1,
        -1,
    ]
    assert found.head["radius_mm"] == 100 and found.head["feed_mm_min"] == 1500


def test_a_staircase_turns_back_by_ways_that_double():
    own = experiments.write("staircase:Z,runs=1", STUDER, "fanuc-lathe")
    t = timed(own.text, STUDER, Conditions())
    found = read("laser", real(t), **own.settings)
    place, side = found.position("Z"), found.approach("Z")
    ways = np.abs(place - 255.0)[(side == -1) & (place < 255.0 - 1e-9)]
    assert ways == approx([0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.56, 5.0])


@pytest.mark.parametrize(
    ("test", "message"),
    [
        ("circle:XY", "no test 'circle'"),
        ("positioning:Q", "names no axis"),
        ("positioning", "names no axis"),
        ("positioning:XZ", "names no axis"),
        ("ballbar:X", "names no 2 axes"),
        ("ballbar:XX", "names no 2 axes"),
        ("positioning:Z,step=x", "not one of"),
        ("positioning:Z,radius=3", "not one of"),
        ("positioning:Z,dwell=-1", "not above zero"),
        ("positioning:Z,runs=0", "no number of 1"),
        ("ballbar:XZ,radius=900", "does not fit"),
        ("positioning:X,overrun=200", "no room"),
    ],
)
def test_what_can_not_be_run_is_said(test, message):
    with pytest.raises(UsageError, match=message):
        experiments.write(test, STUDER, "fanuc-lathe")


def test_a_control_whose_circles_can_not_be_read_back_gets_none():
    with pytest.raises(UsageError, match="pole"):
        experiments.write("ballbar:XZ", STUDER, "heidenhain-iso")
