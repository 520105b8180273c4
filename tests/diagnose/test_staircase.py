"""Where an axis turned, of readings at rest: a staircase of reversals turns at its targets, other
tests overrun them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from postproc import recordings
from postproc.cli import main
from postproc.diagnose import assembly
from postproc.diagnose.analysis import diagnose
from postproc.machine.file import read_machine

STUDER = Path(__file__).parents[2] / "machines" / "studer-s36"
MACHINE = read_machine(STUDER)


@pytest.fixture(scope="module")
def staircase(tmp_path_factory):
    out = tmp_path_factory.mktemp("stairs") / "a.csv"
    given = [
        "--with",
        "windup:X:size_um=9,length_mm=0.8",
        "--noise",
        "0.3",
        "-o",
        str(out),
        "--quiet",
    ]
    assert main(["simulate", "--test", "staircase:X", "--machine", str(STUDER), *given]) == 0
    return recordings.read(recordings.Source("a.csv", out.read_bytes()))


def test_the_test_that_is_for_windup_names_it(staircase):
    d = diagnose([staircase], MACHINE)
    (finding,) = d.findings
    assert finding.block.key == "windup:X" and finding.status == "accepted"
    assert finding.value["size_um"] == pytest.approx(9.0, rel=0.06)
    assert finding.value["length_mm"] == pytest.approx(0.8, rel=0.15)


def test_there_was_no_time_to_overrun_a_step(staircase):
    """Out by 0.01 to 5 mm, back from afar."""
    state = assembly.of([staircase], MACHINE).state
    place, side, way = state.position["X"], state.approach["X"], state.distance["X"]
    out = np.flatnonzero((side[1:] != side[:-1]) & (np.abs(np.diff(place)) > 1e-6)) + 1
    step = np.abs(place[out] - place[out - 1])
    there = np.abs(place[out] - 85.0) > 1e-6
    assert np.abs(way[out] - step)[there].max() < 0.15
    assert (way[out] - step)[~there] == pytest.approx(3.0)


def targets(feed: str, wait: float):
    """Two runs there and back of 5 mm, the ends read once."""
    head = [
        'format = "gcomp-recording/1"',
        'kind = "targets"',
        'instrument = "laser"',
        'quantity = "displacement"',
    ]
    lines = [f"# {line}" for line in [*head, "sensitive = { X = 1.0 }"]]
    lines.append("run,t_s,X_mm,approach_X,reading_um" + feed.partition("=")[0])
    t, last = 0.0, 50.0
    for k, place in enumerate([50.0, 55.0, 60.0, 55.0, 50.0, 55.0, 60.0]):
        t += 2.0 + abs(place - last) / 10.0 + wait * (k in (3, 5))
        last = place
        lines.append(f"1,{t},{place},{-1 if k in (3, 4) else 1},0.0{feed.partition('=')[2]}")
    read = recordings.read(recordings.Source("a.csv", "\n".join([*lines, ""]).encode()))
    return assembly.of([read], MACHINE).state.distance["X"][[3, 5]] - 5.0


def test_how_far_it_went_beyond_is_what_it_had_time_for():
    assert targets(",feed_mm_min=,600", 0.0) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert targets(",feed_mm_min=,600", 0.4) == pytest.approx([2.0, 2.0])
    # it waited: no more than usual
    assert targets(",feed_mm_min=,600", 9.0) == pytest.approx([3.0, 3.0])
    assert targets("", 0.0) == pytest.approx([3.0, 3.0])  # unknown
