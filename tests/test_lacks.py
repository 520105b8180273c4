"""What a map lacks, told from what its folder states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from postproc import cli
from postproc.machine import overshoot, places
from postproc.machine.lacks import lacks, sentence
from postproc.units import UM


def test_the_shipped_machines():
    """studer-s36: no yaw of X (its README says so); mv-1060: positioning of X and Y, reversal of Z,
    nothing else."""
    assert lacks(places.load("studer-s36"))[0] == "EBX: never measured"
    mill = lacks(places.load("mv-1060"))
    # 1020, 1020, 620 mm
    assert mill[0].startswith("squareness of XY, XZ, YZ") and "102.0, 102.0, 62.0 um" in mill[0]
    assert mill[1].count("E") == 15 and "EXX" not in mill[1] and len(mill) == 2
    for name in ("perfect", "example-mill", "example-lathe", "example-five-axis"):
        assert sentence(places.load(name)) == "", name


def test_how_a_rotary_axis_lies_is_no_squareness_of_slides():
    five = places.load("example-five-axis")
    bare = replace(
        five,
        square_stated=("A0C", "B0C"),
        axes={x: replace(a, location=0 * a.location) for x, a in five.axes.items()},
    )
    found = lacks(bare)
    assert found[0].startswith("squareness of XY, XZ, YZ")
    assert found[1] == "how the line of A lies, which was not measured" and len(found) == 2


@pytest.mark.parametrize(
    "stated, missing", [(("C0X", "A0Y"), "XZ"), (("B0X", "A0Z"), "XY"), (("C0Y", "B0Z"), "YZ")]
)
def test_a_pair_is_known_by_any_of_its_names(stated, missing):
    found = lacks(replace(places.load("example-mill"), square_stated=stated))
    assert len(found) == 1 and f"squareness of {missing}," in found[0]


def test_travel_beyond_the_table_says_what_becomes_of_it():
    grinder = places.load("studer-s36")
    assert any(
        "Z beyond 0 to 510 mm" in t and "10 mm beyond it: places there are refused" in t
        for t in lacks(grinder)
    )
    held = replace(grinder, limits=replace(grinder.limits, outside="clamp"))
    assert any("its end values hold there" in t for t in lacks(held))
    near = replace(grinder, limits=replace(grinder.limits, max_correction=20.0))
    assert not any("beyond" in t for t in lacks(near))


def test_a_machine_that_nobody_measured_yet_lacks_everything(tmp_path):
    """gcomp machines new with empty answers: it looked as perfect as `perfect`."""
    new = ("machines", "new", "m", "--kind", "mill", "--control", "linuxcnc", "-o", tmp_path / "m")
    travel = (w for x in ("X=0,600", "Y=0,400", "Z=-80,0") for w in ("--travel", x))
    assert cli.main([*map(str, new), *travel]) == 0
    found = lacks(places.load(str(tmp_path / "m")))
    assert "60.0, 60.0, 40.0 um" in found[0]
    assert found[1] == "all of X, all of Y, all of Z: never measured"


def test_a_squareness_is_reported_over_the_whole_travel():
    """A mill whose axes go from -100 to 300 mm: 100 urad over 400 mm are 40 um."""
    mill = places.load("example-mill")
    axes = {x: replace(a, travel=(-100.0, 300.0)) for x, a in mill.axes.items()}
    found = lacks(replace(mill, axes=axes, square_stated=("C0Y", "B0Z")))
    assert "squareness of YZ, not measured: 100 urad would be 40.0 um" in found[0]


def test_targets_without_lost_motion_are_not_below_zero():
    said = overshoot.sentence("EXX", np.array([-5.0, -4.0, 0.0, np.nan, -6.0]) * UM)
    assert "-6.0 to +0.0 um, -4.5 in the median, below zero at 3 of 4 targets" in said


def test_what_holds_no_machine_is_no_machine(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    own = tmp_path / "gcomp" / "machines"
    (own / "notes").mkdir(parents=True)
    (own / "mine").mkdir()
    (own / "mine" / "machine.toml").touch()
    (own / "perfect.txt").touch()
    found = places.every()
    assert "mine" in found and "perfect" in found
    assert not {"notes", "perfect.txt", "README.md"} & set(found)
