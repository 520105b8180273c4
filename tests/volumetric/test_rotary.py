"""Spheres, R-tests and ballbars at rotary axes: how the axes of a table lie (ISO 10791-6), held
against the errors that were drawn."""

from __future__ import annotations

import json

import numpy as np
import pytest

from postproc.commands import volumetric as command
from postproc.machine.file import read_machine
from postproc.machine.poses import slides_at, tips
from postproc.recordings import Recording, contract
from postproc.volumetric import identify, solve, written
from postproc.volumetric.observations import rows_of
from postproc.volumetric.rows import Rows
from postproc.volumetric.unknowns import Unknowns, locations
from tests.api import schemas
from tests.volumetric.readings import FIVE, NONE, ROOT, gcomp


def poses(number, rng):
    q = np.zeros((5, number))
    q[3] = rng.uniform(-90, 90, number)
    q[4] = rng.uniform(0, 360, number)
    return q


def slides_of(machine, place, q):
    """Where the slides stand when the tip of the real machine is at a place of the table."""
    tip = np.repeat(np.array(place)[:, None], q.shape[1], axis=1)
    found = slides_at(machine, tip, q)
    for _ in range(4):
        found = slides_at(machine, tip - machine.carried(found, 0 * found)[0], q)
    assert np.abs(tips(machine, found) + machine.carried(found, 0 * found)[0] - tip).max() < 1e-9
    return found


@pytest.mark.parametrize("seed", range(4))
def test_a_sphere_tells_how_rotary_axes_lie(seed, tmp_path, capsys):
    """Two spheres on the table, probed at 40 poses each with 0.5 um: the eight numbers of A and C
    (ISO 10791-6), those of example-five-axis within 3 u, on the machine with all its other
    errors."""
    rng = np.random.default_rng(seed)
    files = []
    for k, place in enumerate(((120.0, 30.0, -330.0), (-40.0, 90.0, -300.0))):
        q = slides_of(FIVE, place, poses(40, rng))
        q[:3] += 5e-4 * rng.normal(size=(3, 40))
        columns = {f"{x}_{'mm' if x in 'XYZ' else 'deg'}": q[i] for i, x in enumerate(FIVE.letters)}
        files.append(tmp_path / f"s{k}.csv")
        files[-1].write_text(contract.write(Recording("sphere", {"u_um": 0.5}, columns)))
    assert (
        gcomp(
            "volumetric",
            *files,
            "--like",
            ROOT / "machines" / "example-five-axis",
            "--json",
            tmp_path / "j.json",
        )
        == 0
    )
    document = json.loads((tmp_path / "j.json").read_text())
    schemas.held(document)
    found = document["errors"]
    truth = {"Y0A": 9, "Z0A": -12, "X0C": 7, "Y0C": -6, "B0A": 14, "C0A": -9, "A0C": 11, "B0C": -16}
    assert set(found) == set(truth)
    for name, value in truth.items():
        one = found[name]
        assert (
            one["told"] and abs(one["value"][0] - value) <= 3 * one["u"][0] and one["u"][0] < 5
        ), (name, one)
    capsys.readouterr()
    assert (
        gcomp(
            "volumetric",
            *files,
            "--like",
            ROOT / "machines" / "example-five-axis",
            "-o",
            tmp_path / "m",
        )
        == 0
    )
    mine, rows = read_machine(tmp_path / "m"), poses(50, rng)
    rows[:3] = rng.uniform(-100, 0, (3, 50))
    assert (
        np.abs(mine.carried(rows, 0 * rows)[0] - FIVE.carried(rows, 0 * rows)[0]).max() < 2e-3
    )  # its slides' map is kept
    assert mine.square_u["A0C"] > 0
    capsys.readouterr()


def test_an_r_test_tells_the_same():
    """The tool follows a ball while A and C turn: what it reads along the machine's axes is the
    deviation, but for its zero."""
    rng = np.random.default_rng(2)
    base = command._slides(FIVE)
    u = Unknowns(tuple(locations(FIVE, NONE)), written.without_errors(FIVE), base)
    rows = []
    for place in ((120.0, 30.0, -330.0), (-40.0, 90.0, -300.0)):
        q = slides_at(FIVE, np.repeat(np.array(place)[:, None], 60, axis=1), poses(60, rng))
        off = FIVE.carried(q, 0 * q)[0]
        from postproc.volumetric.rows import to_machine

        read = (
            np.einsum("ijn,jn->in", to_machine(FIVE, q), off)
            + np.array([[0.3], [-0.2], [0.1]])
            + 3e-4 * rng.normal(size=(3, 60))
        )
        rows.append(Rows("shift", q, 0 * q, read, 3e-4, FIVE.tool, np.zeros(3), "r", np.zeros(3)))
    fit = solve.fit(rows, u)
    assert not identify.undetermined(fit)
    truth = {"Y0A": 9, "Z0A": -12, "X0C": 7, "Y0C": -6, "B0A": 14, "C0A": -9, "A0C": 11, "B0C": -16}
    for group in u.groups:
        value, s = fit.values(group)
        one = 1e-3 if group.row < 3 else 1e-6
        assert abs(value[0] / one - truth[group.name]) <= 3.5 * s[0] / one, group.name


def test_a_ballbar_beside_a_turning_table_tells_the_same():
    """ISO 10791-6: one ball on the table, the other in the spindle, which follows it; the bar lies
    along X, Y and Z of the table, so that it reads radially and along the axis. 100 mm, 0.3 um; the
    ball's place is stated to a millimetre."""
    rng = np.random.default_rng(4)
    u = Unknowns(tuple(locations(FIVE, NONE)), written.without_errors(FIVE), command._slides(FIVE))
    rows = []
    for ball in ((120.0, 30.0, -330.0), (-40.0, 90.0, -300.0)):
        for way in np.eye(3):
            place = np.array(ball) + 100 * way
            q = slides_at(FIVE, np.repeat(place[:, None], 60, axis=1), poses(60, rng))
            tip = tips(FIVE, q) + FIVE.carried(q, 0 * q)[0]
            columns = {
                f"{x}_{'mm' if x in 'XYZ' else 'deg'}": q[i] for i, x in enumerate(FIVE.letters)
            }
            columns["length_mm"] = (
                np.linalg.norm(tip - np.array(ball)[:, None], axis=0)
                + 0.05
                + 3e-4 * rng.normal(size=60)
            )
            columns |= {
                f"station_{x}_mm": np.full(60, v + rng.normal() * 0.3)
                for x, v in zip("XYZ", ball, strict=True)
            }
            rows += rows_of(
                Recording("lengths", {"u_um": 0.3}, columns, "b.csv", np.arange(60)), u.bare, {}
            )
    fit = solve.fit(rows, u)
    assert not identify.undetermined(fit)
    truth = {"Y0A": 9, "Z0A": -12, "X0C": 7, "Y0C": -6, "B0A": 14, "C0A": -9, "A0C": 11, "B0C": -16}
    for group in u.groups:
        value, s = fit.values(group)
        one = 1e-3 if group.row < 3 else 1e-6
        assert abs(value[0] / one - truth[group.name]) <= 3.5 * s[0] / one and s[0] / one < 5, (
            group.name
        )
