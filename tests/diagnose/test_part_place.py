"""Where the steps of a part were cut is not recorded: the map says it, or nothing does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc import recordings
from postproc.diagnose import assembly, held_out, library, part_place
from postproc.machine.file import read_machine

STUDER = read_machine(Path(__file__).parents[2] / "machines" / "studer-s36")
MILL = read_machine(Path(__file__).parents[2] / "machines" / "example-mill")
STEPS = (60.0, 110.0, 170.0)  # mm
HEAD = (
    '# format = "gcomp-recording/1"\n# kind = "features"\n# machine = "studer-s36"\n# instrument ='
    ' "coordinate measuring machine"\nfeature,kind,axis,nominal_mm,measured_mm,part,reading\n'
)


MACHINE = """format = "gcomp-machine/1"
name = "m"
control = "linuxcnc"
chain = "w-b-X-Z-t"
diameter = ["X"]
[axes.X]
least_increment = 0.0001
travel = [0.0, 200.0]
[axes.Z]
least_increment = 0.0001
travel = [0.0, 450.0]
table = "Z.csv"
"""


@pytest.fixture(scope="module")
def lathe(tmp_path_factory):
    """Its Z is up to 40 um off, in two unequal waves."""
    folder = tmp_path_factory.mktemp("m")
    (folder / "machine.toml").write_text(MACHINE)
    nodes = np.linspace(0.0, 450.0, 46)
    error = 30.0 * np.sin(nodes / 60.0) + 10.0 * np.sin(nodes / 23.0)
    table = "".join(f"{z:.1f},{e:.3f}\n" for z, e in zip(nodes, error, strict=True))
    (folder / "Z.csv").write_text("Z_mm,EZZ_um\n" + table)
    return read_machine(folder)


def positioning(machine, z: float) -> float:
    """mm, the deviation of Z by its table."""
    place = np.zeros((len(machine.letters), 1))
    place[machine.letters.index("Z")] = z
    return float(machine.deviation(place, np.zeros_like(place))[machine.letters.index("Z")][0])


def steps(machine, begin: float | None, kind: str = "step", off: float = 0.0):
    """Rows of three lengths along Z, cut from `begin` mm on (None: about the middle of the
    travel), each larger by `off` mm than the map says."""
    low, high = machine.axes["Z"].travel
    lines = []
    for k, size in enumerate(STEPS):
        at = (low + high - size) / 2 if begin is None else begin
        error = positioning(machine, at + size) - positioning(machine, at) + off
        lines.append(f"S{k},{kind},Z,{size},{size + error:.5f},1,1\n")
    read = recordings.read(recordings.Source("parts.csv", (HEAD + "".join(lines)).encode()))
    return assembly.of([read], machine)


def test_steps_begin_where_the_map_says(lathe):
    rows, said = part_place.placed(steps(lathe, 45.0), lathe)
    assert rows.other["Z"] == pytest.approx(45.0, abs=3.0)
    assert rows.state.position["Z"] - rows.other["Z"] == pytest.approx(STEPS)
    assert np.abs(rows.residual).max() < 1.5e-3
    assert len(said) == 1 and "Z = " in said[0] and "parts.csv" in said[0]


@pytest.mark.parametrize(
    ("begin", "kind", "off", "why"),
    [
        (None, "step", 0.0, "they fit the middle"),
        (45.0, "centre_distance", 0.0, "distances of holes lie about the middle"),
        (None, "step", 0.09, "no place fits: something else is wrong"),
    ],
)
def test_nothing_is_moved_without_need(lathe, begin, kind, off, why):
    rows = steps(lathe, begin, kind, off)
    moved, said = part_place.placed(rows, lathe)
    assert moved is rows and not said, why


def test_a_flat_map_does_not_say_where_steps_begin():
    rows = steps(STUDER, 20.0)
    assert part_place.placed(rows, STUDER) == (rows, [])


def test_a_run_under_a_load_of_its_own_is_not_held_out():
    """Nothing else predicts what that load does; the run beside it is held out."""
    lines = [
        f"{run},{60 * run + k},{50 * k},0,0,1,1,1,{run * 0.1},{400.0 if run == 2 else 0.0}\n"
        for run in (1, 2, 3)
        for k in range(4)
    ]
    text = (
        '# format = "gcomp-recording/1"\n# kind = "targets"\n# machine = "example-mill"\n#'
        ' instrument = "laser interferometer"\n# quantity = "displacement"\n# sensitive = { X ='
        " 1.0, Y = 0.0, Z = 0.0 }\n"
        "run,t_s,X_mm,Y_mm,Z_mm,approach_X,approach_Y,approach_Z,reading_um,force_X_N\n"
    )
    read = recordings.read(recordings.Source("r.csv", (text + "".join(lines)).encode()))
    rows = assembly.of([read], MILL)
    held, _ = held_out.of(rows, "", [read])
    assert set(rows.run[held]) == {1}
    bare = replace(rows, state=replace(rows.state, channels={}))
    assert set(rows.run[held_out.of(bare, "", [read])[0]]) == {2}


def test_wear_that_shows_on_diameters_alone_is_of_their_axis():
    """Of no axis it says the same: it stands in the dictionary once."""
    lines = "".join(
        f"D{d},boss_diameter,X,{size},{size},{part},1\n"
        for part in (1, 2, 3)
        for d, size in enumerate((40.0, 80.0))
    )
    rows = assembly.of(
        [recordings.read(recordings.Source("parts.csv", (HEAD + lines).encode()))], STUDER
    )
    axes = {b.axis for b in library.blocks(rows) if b.name == "tool_wear"}
    assert axes == {"X"}
