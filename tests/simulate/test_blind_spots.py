"""Programs of tests that show what the usual ones hide: periods of a screw, rotations on one line,
circles at one feed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

from postproc.errors import UsageError
from postproc.simulate import experiments
from postproc.simulate.timeline import Conditions

from .samples import MILL, STUDER, exact, read, real, timed


def found(test: str, machine, dialect: str, **more: str):
    own = experiments.write(test, replace(machine, control=dialect), dialect)
    return read(
        own.instrument,
        real(timed(own.text, replace(machine, control=dialect), Conditions())),
        **own.settings | more,
    )


@pytest.mark.parametrize("lead", [2.0, 4.0, 5.0, 6.0, 10.0, 12.0, 16.0, 20.0])
def test_close_targets_come_to_every_phase_of_any_screw_over_three_turns(lead):
    place = found("period:Z,runs=1", STUDER, "fanuc-lathe").position("Z")
    phase = np.unique(np.round(place % lead, 6)) / lead
    assert np.ptp(place) >= 3 * lead - 1e-6
    assert np.diff(np.r_[phase, phase[0] + 1]).max() < 0.3


def test_every_target_of_every_line_is_taken_at_both_ends_of_every_other_axis():
    rows = found("arms:Y,runs=2", MILL, "linuxcnc")
    lines = {
        (x, z)
        for x, z in zip(rows.position("X").tolist(), rows.position("Z").tolist(), strict=True)
    }
    ends = [sorted({line[i] for line in lines}) for i in (0, 1)]
    assert len(lines) == 3 and all(len(e) == 2 and e[1] - e[0] > 20 for e in ends)
    targets = {
        line: np.unique(
            rows.position("Y")[(rows.position("X") == line[0]) & (rows.position("Z") == line[1])]
        )
        for line in lines
    }
    assert all(t == approx(next(iter(targets.values()))) for t in targets.values())
    assert sorted(set(rows.columns["run"])) == [1, 2, 3, 4, 5, 6]
    assert set(rows.approach("Y")) == {1.0, -1.0}


def test_one_slide_alone_has_no_second_line():
    alone = replace(exact(), axes={"X": exact().axes["X"]})
    with pytest.raises(UsageError, match="no second line"):
        experiments.write("arms:X", alone, "linuxcnc")


def test_a_ballbar_may_go_at_a_second_feed():
    rows = found("ballbar:XY,radius=50,feed=3000,slow=600,runs=1", MILL, "linuxcnc", rate="50")
    run, time = rows.columns["run"], rows.columns["t_s"]
    turns = [float(np.ptp(time[run == k])) for k in (1, 2, 3, 4)]
    assert turns[2] / turns[0] == approx(5.0, rel=0.02) and turns[0] == approx(2 * np.pi, rel=0.02)
    assert [int(rows.columns["sense"][run == k][0]) for k in (1, 2, 3, 4)] == [1, -1, 1, -1]


@pytest.mark.parametrize("dialect", ["siemens", "heidenhain-iso", "marlin", "reprap"])
def test_controls_that_wait_and_remark_in_their_own_way_stop_at_the_same_targets(dialect):
    machine = replace(MILL, offsets={})
    wanted = found("positioning:Y,runs=1", machine, "linuxcnc")
    assert found("positioning:Y,runs=1", machine, dialect).position("Y") == approx(
        wanted.position("Y"), abs=1e-3
    )
