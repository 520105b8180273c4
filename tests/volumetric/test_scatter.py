"""Readings that state no uncertainty: what their scatter makes of it holds with few readings too,
or is refused. Truth and noise are drawn; nothing of the fit's own u is taken for granted."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.recordings import Recording, contract
from postproc.volumetric import VolumetricError, identify, solve, written
from postproc.volumetric.observations import rows_of
from postproc.volumetric.unknowns import Unknowns, components
from tests.volumetric.readings import MILL, NONE, TOOLS, drawn, gcomp, held, recording
from tests.volumetric.readings import unknowns as all_errors

BARE = written.without_errors(MILL)
SILENT = float("nan")


def line(at, reading, name="a.csv", quantity="displacement", along="X", **head) -> Recording:
    """Readings along X, mm or rad, while nothing else moves; `setup` may stand in the head."""
    unit, size = ("urad", 1e6) if quantity == "angle" else ("um", 1e3)
    columns = {"X_mm": at, "Y_mm": 0 * at, "Z_mm": 0 * at, f"reading_{unit}": reading * size}
    columns |= {"setup": head.pop("setup")} if "setup" in head else {}
    said = {"quantity": quantity, "sensitive": {along: 1.0}} | head
    return Recording("targets", said, columns, name, np.arange(len(at)) + 2)


def alone(name: str, at) -> Unknowns:
    """One error of X as the only unknown, with a node at every place."""
    every = {g.name for g in components(BARE, {"X": at}, NONE, NONE)}
    groups = components(BARE, {"X": at}, frozenset(every - {name}), NONE)
    return Unknowns(tuple(groups), BARE, BARE)


def fitted(read: list[Recording], u: Unknowns) -> solve.Fit:
    return solve.fit([r for one in read for r in rows_of(one, BARE, {})], u)


@pytest.mark.parametrize(("runs", "number"), [(3, 5), (2, 7)])
def test_two_u_hold_95_percent_with_few_runs(runs, number):
    """8 and 6 degrees of freedom, 2 um of noise, every run with a zero of its own; 62 and 91 % with
    a u for each run and 2 for Student's t."""
    rng, at = np.random.default_rng(number), np.linspace(-200, 200, number)
    u, inside, scatter = alone("EXX", at), [], []
    for _ in range(60):
        truth = 6e-3 * rng.normal(size=number)
        truth -= truth[number // 2]
        read = [
            line(at, truth + 5e-3 * rng.normal() + 2e-3 * rng.normal(size=number))
            for _ in range(runs)
        ]
        fit = fitted(read, u)
        value, s = fit.values(u.groups[0])
        inside += (np.abs(value - truth) <= 2 * s)[at != 0].tolist()
        scatter.append(fit.rows[0].u)
    assert 0.93 <= np.mean(inside) <= 0.985
    assert np.sqrt(np.mean(np.square(scatter))) == pytest.approx(2e-3, rel=0.1)


def test_small_clouds_share_one_u():
    """24 clouds of 5 points: nine of their fifteen readings are left to each, fewer than the map
    takes in all."""
    rng, u = np.random.default_rng(3), all_errors(nodes=3)
    truth = drawn(u, rng)
    read = [recording(u, truth, rng, "points", TOOLS[k % 3], 5, 2e-3) for k in range(24)]
    fit = solve.fit([replace(r, u=SILENT) for one in read for r in rows_of(one, u.bare, {})], u)
    assert len({r.u for r in fit.rows}) == 1
    assert fit.rows[0].u == pytest.approx(2e-3, rel=0.15)
    assert np.mean(held(fit, u, truth)) >= 0.93


def test_one_run_with_a_node_at_each_place_tells_no_uncertainty(tmp_path, capsys):
    """13 readings, 12 nodes that are free and a zero: nothing is left over. With u stated it is
    read, and U is 2 u of a difference of two readings: 2 sqrt(2) 0.5 um."""
    rng, at = np.random.default_rng(1), np.linspace(-300, 300, 13)
    (tmp_path / "x.csv").write_text(contract.write(line(at, 2e-3 * rng.normal(size=13))))
    words = ("volumetric", tmp_path / "x.csv", "--like", "example-mill", "-o", tmp_path / "m")
    words += ("--zero", "EYX,EZX,EAX,EBX,ECX")
    assert gcomp(*words) == 2
    said = capsys.readouterr().err
    assert "states no uncertainty" in said and "--head u_um=" in said
    assert not (tmp_path / "m").exists()
    assert gcomp(*words, "--head", "u_um=0.5") == 0
    table = (tmp_path / "m" / "X_uncertainty.csv").read_text().splitlines()
    assert "X_mm,EXX_um" in table
    found = np.array([float(row.split(",")[1]) for row in table[table.index("X_mm,EXX_um") + 1 :]])
    assert found[at != 0] == pytest.approx(2 * np.sqrt(2) * 0.5, rel=0.01)
    capsys.readouterr()


def test_readings_that_repeat_to_the_last_digit_tell_no_uncertainty():
    at = np.linspace(-200, 200, 5)
    with pytest.raises(VolumetricError, match="repeat to their last digit") as error:
        fitted([line(at, 1e-3 * np.array([0, 1, 0, 2, 1.0])) for _ in range(4)], alone("EXX", at))
    assert "--head u_um=" in error.value.advice


def test_a_u_that_is_far_too_small_is_seen_beside_a_file_that_states_none():
    """Two clouds state 0.1 um and have 2, the third states nothing: 16 % within 2 u before."""
    rng, u = np.random.default_rng(6), all_errors(nodes=3)
    truth = drawn(u, rng)
    rows = [
        replace(r, u=1e-4 if k < 2 else SILENT)
        for k, t in enumerate(TOOLS)
        for r in rows_of(recording(u, truth, rng, "points", t, 60, 2e-3), u.bare, {})
    ]
    fit = solve.fit(rows, u)
    assert fit.widened and fit.chi == pytest.approx(400, rel=0.3)
    assert np.mean(held(fit, u, truth)) > 0.9
    assert "times the stated u" in written.report(fit, MILL.tool, NONE)


def test_angles_of_two_set_ups_have_a_zero_each(tmp_path):
    """EBX read twice, the instrument set up anew between, 100 urad apart: as in two files."""
    rng, at = np.random.default_rng(2), np.linspace(-300, 300, 7)
    truth = 1e-5 * rng.normal(size=7)
    truth -= truth[3]
    twice = [truth + z + 1e-6 * rng.normal(size=7) for z in (0.0, 1e-4)]
    u = alone("EBX", at)
    head = {"quantity": "angle", "along": "B", "u_um": 1.0}
    one = line(np.tile(at, 2), np.concatenate(twice), setup=np.repeat([1.0, 2.0], 7), **head)
    together, apart = fitted([one], u), fitted([line(at, r, **head) for r in twice], u)
    value, s = together.values(u.groups[0])
    assert value == pytest.approx(apart.values(u.groups[0])[0], abs=1e-12)
    assert np.abs(value - truth).max() < 3e-6 and s.max() < 1.5e-6
    assert not identify.undetermined(together)


def test_the_standard_uncertainty_at_a_place_is_that_of_its_numbers():
    """A squareness of 5 urad with 2 urad, at an arm of 300 mm: 1.5 um with 0.6."""
    found = SimpleNamespace(
        unknowns=SimpleNamespace(columns=lambda *_: np.array([[[300.0], [0.0], [0.0]]])),
        numbers=np.array([5e-6]),
        covariance=np.array([[(2e-6) ** 2]]),
    )
    none = np.zeros((3, 1))
    off, u = solve.Fit.at(cast(Any, found), none, none, none)
    assert off[:, 0] == pytest.approx([1.5e-3, 0.0, 0.0])
    assert u[:, 0] == pytest.approx([0.6e-3, 0.0, 0.0])
