"""One place, told in numbers, gives what it gives among others in columns."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc.machine import model
from postproc.machine.axis import Expansion
from postproc.machine.cells import Cells
from postproc.machine.file import read_machine
from tests.small_machines import write_mill
from tests.test_cuts import BY, by_two, machine

ROOT = Path(__file__).resolve().parents[1]
UNEVEN = "X_mm,EXX_um_fwd,EXX_um_rev,EBX_urad\n-10,0,3,-50\n1,2,2,3\n40,7,5,9\n400,5,5,2000\n"


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cells")
    found = {x: read_machine(ROOT / "machines" / x) for x in ("studer-s36", "example-five-axis")}
    found["mill"] = read_machine(write_mill(folder / "mill", False))
    found["two-way"] = read_machine(write_mill(folder / "two-way", True))
    found["by two"] = read_machine(by_two(folder / "by", BY))
    found["uneven"] = read_machine(machine(folder / "uneven", UNEVEN))
    axes = dict(found["two-way"].axes)
    axes["Y"] = replace(axes["Y"], expansion=Expansion(scale=1e-5, scale_at=23.0, fixed=7.0))
    return found | {"warm": replace(found["two-way"], axes=axes)}


def places(m, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """(A, N) mm, at nodes and beyond the tables too, and sides, not only whole ones."""
    position, near = rng.uniform(-450, 450, (len(m.letters), 400)), []
    for x, row in zip(m.letters, position, strict=True):
        nodes = np.concatenate(m.knots.get(x, [np.zeros(1)]))
        row[:200] = rng.choice(nodes, 200) + rng.choice([0.0, 0.0, 1e-9, -1e-9, 0.3], 200)
        near.append(rng.integers(-2, 3, 400) / 2)
    return position, np.array(near)


@pytest.mark.parametrize("direction", [None, 0, 1, 2])
@pytest.mark.parametrize(
    "name", ["studer-s36", "example-five-axis", "mill", "two-way", "by two", "uneven", "warm"]
)
def test_a_place_alone_is_off_as_it_is_among_others(machines, name, direction):
    m = machines[name]
    position, side = places(m, np.random.default_rng(1))
    rows = np.array(m.corrected)
    off, play = m.deviation(position, side, direction), m.lost_motion(position, rows)
    for few in range(1, model.FEW + 2):
        for k in range(0, 400 - few, few):
            at = slice(k, k + few)
            assert (m.deviation(position[:, at], side[:, at], direction) == off[:, at]).all()
            assert (m.lost_motion(position[:, at], rows) == play[:, at]).all()
    assert off.any() or (direction == 1 and "Y" not in m.letters)


def test_a_place_alone_is_looked_up_in_numbers(machines, monkeypatch):
    """Not by columns, which take three times as long."""
    asked = []
    values = Cells.values
    monkeypatch.setattr(Cells, "values", lambda *of: asked.append(of[1]) or values(*of))
    m = machines["mill"]
    position, side = places(m, np.random.default_rng(1))
    for n, number in ((1, 3), (model.FEW, 3 * model.FEW), (model.FEW + 1, 0)):
        asked.clear()
        m.deviation(position[:, :n], side[:, :n])
        assert len(asked) == number


def test_no_place_is_off_by_nothing(machines):
    for m in machines.values():
        none = np.zeros((len(m.letters), 0))
        assert m.deviation(none, none).shape == none.shape
        assert m.lost_motion(none, np.array(m.corrected)).shape == (len(m.corrected), 0)
