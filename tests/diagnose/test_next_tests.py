"""What is asked for next can be run, and parts the names that it is asked for."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from postproc import effects
from postproc.diagnose.experiments import NO_CIRCLES, separating, showing
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.simulate import experiments

MILL = read_machine(Path(__file__).parents[2] / "machines" / "example-mill")
TEST = re.compile(r"gcomp simulate --test (\S+)")


def test_the_controls_without_circles_are_those_whose_circles_can_not_be_read_back():
    refused = {
        n
        for n in dialects.names()
        if (g2 := dialects.load(n).by_number.get(20)) is not None and g2.refuses
    }
    assert set(NO_CIRCLES) == refused


@pytest.mark.parametrize("control", ["linuxcnc", "siemens", "heidenhain-iso"])
@pytest.mark.parametrize("name", effects.names())
def test_every_test_that_is_asked_for_can_be_written(name, control):
    machine = replace(MILL, control=control)
    axis = {"axis": "Y", "pair": "XY", "all": ""}[effects.load(name).PER]
    asked = TEST.search(showing(name, axis, machine))
    assert asked is None or experiments.write(asked[1], machine, control).text


@pytest.mark.parametrize(
    ("key", "others", "test"),
    [
        ("servo_lag:X", ["servo_mismatch:XY", "squareness:XY"], "ballbar:XY,feed=3000,slow=500"),
        ("squareness:XY", ["servo_lag:Y"], "ballbar:XY,feed=3000,slow=500"),
        ("scale:Y", ["abbe:Y", "cosine:Y"], "arms:Y"), ("backlash:X", ["windup:X"], "staircase:X"),
        ("cyclic:X", ["vibration:X"], "feeds:X"),
    ],
)  # fmt: skip
def test_a_set_of_names_asks_for_what_parts_them(key, others, test):
    assert TEST.search(separating(key, others, MILL))[1] == test
