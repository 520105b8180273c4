"""Nodes of each component: where readings see it. Step diagonals (ISO 230-6) and a laser along each
axis, from readings to a program that is measured again."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from postproc import recordings
from postproc.machine import part
from postproc.machine.file import read_machine
from postproc.volumetric import nodes, solve, written
from postproc.volumetric.observations import rows_of
from postproc.volumetric.unknowns import Unknowns, components
from tests.volumetric.readings import MILL, TOOLS, drawn, gcomp, recording, unknowns
from tests.volumetric.test_step_diagonals import ANGLES
from tests.volumetric.test_volumetric import _rigid

KEPT = [n for n in part.names(MILL) if n not in ANGLES]  # example-mill whose slides do not turn
ON = ("--machine", "example-mill", "--only", ",".join(KEPT), "--noise", "0.2", "--quiet")
BARE = written.without_errors(MILL)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Four stairs, a laser along each axis: of the simulator."""
    folder = tmp_path_factory.mktemp("steps")
    found = []
    for k, turn in enumerate(("", ",down_X=1", ",down_Y=1", ",down_Z=1")):
        found.append(folder / f"steps_{k}.csv")
        lean = ("--set", "lean=X20,Y-30,Z10")
        test = ("--test", f"steps:XYZ,number=6{turn}", "--seed", k + 1, *lean)
        assert gcomp("simulate", *test, *ON, "-o", found[-1]) == 0
    for x in "XYZ":
        found.append(folder / f"laser_{x}.csv")
        test = ("--test", f"positioning:{x},runs=2", "--seed", 7)
        assert gcomp("simulate", *test, *ON, "-o", found[-1]) == 0
    return found


def rows(file):
    found = recordings.read(recordings.Source(file.name, file.read_bytes()))
    return rows_of(found, BARE, {})


def test_a_component_has_the_places_that_see_it(files):
    """Seven places of each stair by hand; the laser along X shows EXX at 17 others, and neither EYX
    nor EZX. Rotations act on the beam wherever the tool stands aside of it."""
    read = [r for f in files for r in rows(f)]
    axes = nodes.of_axes(read, MILL)
    assert [len(axes[x]) for x in "XYZ"] == [11, 11, 11]  # more than 15 places: even ones
    found = nodes.of_components(read, BARE, axes)
    assert {n for n in found if n not in ANGLES} == {"EYX", "EZX", "EXY", "EZY", "EXZ", "EYZ"}
    assert found["EYX"] == pytest.approx(np.linspace(-349, 349, 7), abs=1e-3)
    assert found["EXZ"] == pytest.approx(np.linspace(-399, -1, 7), abs=1e-3)


def test_what_every_reading_sees_has_the_nodes_of_its_axis():
    """A tracker shows all of it everywhere."""
    rng = np.random.default_rng(3)
    u = unknowns(nodes=4)
    truth = drawn(u, rng)
    read = [r for t in TOOLS for r in rows_of(recording(u, truth, rng, "points", t), BARE, {})]
    assert not nodes.of_components(read, BARE, nodes.of_axes(read, MILL))


def test_seen_on_a_part_of_an_axis_alone_is_not_held_on_beyond(files):
    """Stairs of half the travel: the axis' own ends, which only the laser reached, stay nodes."""
    (stair,) = rows(files[0])
    (laser,) = rows(files[4])
    half = replace(stair, q=stair.q / 2)
    read = [half, laser]
    found = nodes.of_components(read, BARE, nodes.of_axes(read, MILL))
    assert found["EYX"][[0, -1]] == pytest.approx([-349, 349], abs=0.01)
    assert found["EYX"][[1, -2]] == pytest.approx([-174.5, 174.5], abs=0.01)


def test_stairs_and_lasers_to_a_map_that_a_diagonal_proves(files, tmp_path, capsys):
    """Measured, corrected and measured again: the laser along a diagonal reads less than a tenth.
    (What is left, 4.6 of 76 um, lies between seven nodes: the machine has up to fifteen.) The
    deviation all over the volume is the machine's own, but for where the part lies."""
    zero = ("--zero", ",".join(sorted(ANGLES)))
    found = tmp_path / "found"
    assert gcomp("volumetric", *files, "--like", "example-mill", *zero, "-o", found) == 0
    said = capsys.readouterr().out
    assert "not told" not in said and "can not part" not in said

    assert "lost motion" not in said and "for each of" in said  # widened: kinks between nodes

    mine, true = read_machine(found), part.only(MILL, KEPT)
    rng = np.random.default_rng(1)
    q = np.array([rng.uniform(n[0], n[-1], 400) for n in (mine.tables[x].nodes for x in "XYZ")])
    way = rng.choice([-1.0, 1.0], q.shape)
    off = true.deviation(q, way)
    left = off - mine.deviation(q, way)
    left -= _rigid(q, left)
    assert np.sqrt((left**2).mean()) < 0.06 * np.sqrt((off**2).mean())

    # U in spite of what repeats at every place between the nodes: 68 % lay within 2 u where each
    # repeated reading counted for itself.
    every = [r for f in files for r in rows(f)]
    axes = nodes.of_axes(every, MILL)
    axes |= nodes.of_components(every, BARE, axes)
    groups = components(BARE, axes, ANGLES, frozenset("XYZ"))
    u = solve.fit(every, Unknowns(tuple(groups), BARE, BARE)).at(q, way, mine.tool)[1]
    assert (np.abs(left) <= 2 * u).mean() > 0.8

    nominal, better = tmp_path / "d.ngc", tmp_path / "d_corrected.ngc"
    before, after = tmp_path / "d1.csv", tmp_path / "d2.csv"
    test = ("--test", "diagonal:XYZ,number=9,runs=3,down_Y=1")
    assert gcomp("simulate", *test, *ON, "--program-out", nominal, "-o", before) == 0
    zero_of = ("--offset", "G54=X0,Y0,Z-250")
    assert gcomp(nominal, "--machine", found, "--outside", "clamp", *zero_of, "-o", better) == 0
    again = ("--nominal", nominal, "--instrument", "laser", "--seed", 3)
    assert gcomp("simulate", better, *again, *ON, "-o", after) == 0
    verdict = tmp_path / "accept.json"
    assert gcomp("accept", before, after, "--json", verdict) == 0
    (result,) = json.loads(verdict.read_text())["results"]
    e = result["parameters"]["E"]
    assert e["after"]["value"] < 0.1 * e["before"]["value"]
