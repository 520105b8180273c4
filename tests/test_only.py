"""`--only EXX,C0Y`: a part of the map. A part and the rest of it are the whole; all of it changes
no byte but the mark."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from postproc import cli
from postproc.machine import part
from postproc.machine.file import read_machine

ROOT = Path(__file__).resolve().parents[1]
MACHINES = ("example-mill", "example-lathe", "example-router", "example-five-axis", "studer-s36")
PROGRAM = "G21 G90 G54\nG0 X-300 Y-150 Z100\nG1 Z50 F1000\nG1 X300 Y150\nG1 X-300\nM2\n"


def gcomp(*words) -> int:
    return cli.main([*map(str, words)])


@pytest.mark.parametrize("name", MACHINES)
def test_a_part_and_the_rest_are_the_whole(name):
    machine = read_machine(ROOT / "machines" / name)
    every = part.names(machine)
    rng = np.random.default_rng(3)
    q = np.stack([rng.uniform(*machine.axes[x].travel, 200) for x in machine.letters])
    way = rng.choice([-1.0, 1.0], q.shape)
    along = [n for n in every if re.fullmatch(r"E([XYZ])\1|backlash:.", n)]
    for chosen in (along, every[::2] + along, every):
        rest = [n for n in every if n not in chosen]
        one, other = (part.only(machine, names) for names in (chosen, rest))
        # Lines of rotary axes that lie beside their places are no names: they stay in both.
        bare = part.only(machine, [])
        both = one.deviation(q, way) + other.deviation(q, way) - bare.deviation(q, way)
        assert np.abs(both - machine.deviation(q, way)).max() < 1e-9
    assert part.largest_left(machine, machine) == 0.0


def test_by_hand(tmp_path, capsys):
    """example-router: only lost motion of X (0.06): a motion towards + aims 30 um farther,
    squareness stays."""
    (tmp_path / "a.nc").write_text("G21 G90 G54\nG0 X100 Y100 Z-5\nG1 X400 F1000\nG1 Y300\n")
    assert (
        gcomp(
            tmp_path / "a.nc",
            "--machine",
            "example-router",
            "--only",
            "backlash:X",
            "-o",
            tmp_path / "b.nc",
        )
        == 0
    )
    assert "G1 X400.030 F1000\nG1 Y300\n" in (tmp_path / "b.nc").read_text()
    err = capsys.readouterr().err
    assert (
        "only backlash:X of the map is corrected (--only); C0Y, backlash:Y stays, up to 417.2 um"
        in err
    )


def test_all_of_it_changes_no_byte_but_the_mark(tmp_path, capsys):
    (tmp_path / "a.nc").write_text(PROGRAM)
    names = ",".join(part.names(read_machine(ROOT / "machines" / "example-mill")))
    for out, more in (("b.nc", ()), ("c.nc", ("--only", names))):
        assert (
            gcomp(tmp_path / "a.nc", "--machine", "example-mill", "-o", tmp_path / out, *more) == 0
        )
    one, other = ((tmp_path / n).read_text().splitlines() for n in ("b.nc", "c.nc"))
    assert [k for k, (a, b) in enumerate(zip(one, other, strict=True)) if a != b] == [1]
    assert one[1].split("MAP ")[1] != other[1].split("MAP ")[1]  # another map has another mark
    capsys.readouterr()


def test_a_name_that_the_map_has_not_is_refused(tmp_path, capsys):
    (tmp_path / "a.nc").write_text(PROGRAM)
    assert (
        gcomp(
            tmp_path / "a.nc", "--machine", "example-mill", "--only", "EXQ", "-o", tmp_path / "b.nc"
        )
        == 2
    )
    assert "the map of example-mill has no EXQ" in capsys.readouterr().err
    assert not (tmp_path / "b.nc").exists()


def test_what_is_not_wanted_is_not_called_unmeasured(tmp_path, capsys):
    (tmp_path / "a.nc").write_text(PROGRAM)
    words = ("--machine", "example-mill", "--only", "EXX,EYY", "--verify", "-o", tmp_path / "b.nc")
    assert gcomp(tmp_path / "a.nc", *words) == 0
    err = capsys.readouterr().err
    assert "verified for EXX, EYY alone: largest" in err  # what stays is not in the figure
    assert "never measured" not in err and "not measured" not in err


def test_export_takes_several_components_by_one_option(tmp_path, capsys):
    words = ("--machine", "example-mill", "--control", "linuxcnc")
    assert gcomp("export", *words, "--only", "EXX,EZZ", "-o", f"{tmp_path}/t/") == 0
    assert sorted(p.name for p in (tmp_path / "t").iterdir()) == ["X.comp", "Z.comp"]
    capsys.readouterr()
