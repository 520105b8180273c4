"""Maps of readings all over the volume: intervals hold the errors that were drawn, what can not be
parted is said, and a corrected program is left with a small part of the deviation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from postproc import recordings
from postproc.machine.file import read_machine
from postproc.recordings import contract
from postproc.volumetric import identify, solve
from postproc.volumetric.observations import rows_of
from postproc.volumetric.rows import _turn
from tests.volumetric.readings import (
    MILL,
    ROOT,
    TOOLS,
    drawn,
    gcomp,
    held,
    lengths,
    recording,
    unknowns,
)


def one_fit(k: int, rng) -> list[bool]:
    """The k-th of fits of three clouds, or of four stations with three reflectors each, on three
    chains by turns: whether each value lies within 2 u."""
    chains = [
        MILL.chain,
        replace(MILL.chain, axes=("Y", "X", "Z"), workpiece_side=1),
        replace(MILL.chain, axes=("X", "Y", "Z"), workpiece_side=0),
    ]
    stations = [
        (-900.0, -700.0, 300.0),
        (1000.0, -600.0, 400.0),
        (0.0, 1100.0, 200.0),
        (100.0, 50.0, 1200.0),
    ]
    u = unknowns(replace(MILL, chain=chains[k % 3]), 4)
    truth = drawn(u, rng)
    read = [
        recording(u, truth, rng, "lengths", t, 120, station=s)
        if s
        else recording(u, truth, rng, "points", t)
        for t in TOOLS
        for s in (stations if k % 2 else [None])
    ]
    fit = solve.fit([r for one in read for r in rows_of(one, u.bare, {})], u)
    assert not identify.undetermined(fit), (k, identify.sentences(identify.undetermined(fit)))
    assert not fit.widened or fit.chi < 1.3
    return held(fit, u, truth)


def test_twenty_fits_hold_their_parameters_within_2_u():
    """95 % of all values within 2 u (`python benchmarks/measuring.py volumetric` prints them)."""
    rng = np.random.default_rng(5)
    found = [one_fit(k, rng) for k in range(20)]
    every = np.concatenate(found)
    assert 0.93 <= every.mean() <= 0.98, (every.mean(), len(every))
    assert min(map(np.mean, found)) > 0.75


def test_readings_that_state_no_uncertainty_get_their_own():
    rng = np.random.default_rng(8)
    u = unknowns(nodes=4)
    truth = drawn(u, rng)
    read = [recording(u, truth, rng, "points", t, noise=2e-3) for t in TOOLS]
    rows = [replace(r, u=float("nan")) for one in read for r in rows_of(one, u.bare, {})]
    fit = solve.fit(rows, u)
    assert [r.u for r in fit.rows] == pytest.approx([2e-3] * 3, rel=0.1)
    assert np.mean(held(fit, u, truth)) > 0.88


def test_lost_motion_is_told_where_both_directions_were_read():
    rng = np.random.default_rng(9)
    u = unknowns(nodes=3, two_way=frozenset("XY"))
    truth = drawn(u, rng)
    fit = solve.fit(
        [r for t in TOOLS for r in rows_of(recording(u, truth, rng, "points", t), u.bare, {})], u
    )
    for name in ("B:X", "B:Y"):
        k = [g.name for g in u.groups].index(name)
        value, s = fit.values(u.groups[k])
        assert abs(value[0] - truth[u.slices[k]][0]) < 3 * s[0] < 1e-3


def test_a_turn_about_the_line_through_two_reflectors_is_not_determined():
    """Two reflectors: what the Z slide turns about the line through both moves neither. By hand: a
    rotation r with r x (b - a) = 0."""
    rng = np.random.default_rng(1)
    u = unknowns(nodes=4)
    rows = [
        r
        for t in TOOLS[:2]
        for r in rows_of(recording(u, drawn(u, rng), rng, "points", t), u.bare, {})
    ]
    (names,) = identify.undetermined(solve.fit(rows, u))
    assert {"EAZ", "ECZ"} <= set(names) and "EBZ" not in names  # b - a is (60, 0, -80)
    three = [
        r for t in TOOLS for r in rows_of(recording(u, drawn(u, rng), rng, "points", t), u.bare, {})
    ]
    assert not identify.undetermined(solve.fit(three, u))


def test_from_clouds_to_a_corrected_program(tmp_path, capsys):
    """example-mill seen by a tracker with three reflectors: the map that comes out, held against
    the machine itself, leaves a small part of its deviation, and U holds it."""
    clouds = []
    for k, (x, y, z) in enumerate(TOOLS):
        clouds.append(tmp_path / f"c{k}.csv")
        words = (
            "--test",
            "volume:XYZ,number=100",
            "--noise",
            "1",
            "--seed",
            k,
            "--set",
            f"tool=X{x:g},Y{y:g},Z{z:g}",
            "-o",
            clouds[-1],
        )
        assert gcomp("simulate", "--machine", "example-mill", *words) == 0
    assert gcomp("volumetric", *clouds, "--like", "example-mill", "-o", tmp_path / "found") == 0
    said = capsys.readouterr().out
    assert "these readings can not" not in said and "not told" not in said
    # all places of such a test are approached in +
    assert "lost motion of X, Y, Z is not in these readings" in said
    text = (tmp_path / "found" / "machine.toml").read_text()
    assert "# Not in this map: lost motion of X, Y, Z." in text
    mine = read_machine(tmp_path / "found")
    assert mine.square_u and all(axis.uncertainty is not None for axis in mine.axes.values())
    rng = np.random.default_rng(1)
    q = np.array([rng.uniform(n[0], n[-1], 400) for n in (mine.tables[x].nodes for x in "XYZ")])
    up = np.ones_like(q)
    off, left = (
        MILL.deviation(q, up),
        MILL.deviation(q, up) - replace(mine, tool=MILL.tool).deviation(q, up),
    )
    left -= _rigid(q, left)
    assert np.sqrt((left**2).mean()) < 0.2 * np.sqrt((off**2).mean())


def _rigid(q, left):
    """(3, N): the turn and shift that lie nearest to a deviation: where a tracker stood."""
    n = q.shape[1]
    columns = [np.repeat(e, n) for e in np.eye(3)]
    columns += [np.cross(e, q.T).T.ravel() for e in np.eye(3)]
    a = np.array(columns).T
    return (a @ np.linalg.lstsq(a, left.ravel(), rcond=None)[0]).reshape(3, n)


@pytest.mark.parametrize("name", ["sphere_1", "tracker_1", "l"])
def test_recordings_without_a_clock_are_shown_and_written(name, tmp_path, capsys):
    """KeyError 't_s' before."""
    file = ROOT / "sample_recordings" / f"{name}.csv"
    if name == "l":
        file = tmp_path / "l.csv"
        file.write_text(contract.write(lengths([-200.0, -100.0], (900.0, -700.0, 300.0))))
    out = tmp_path / "again.csv"
    assert gcomp("recordings", file, "--as", out) == 0
    said = capsys.readouterr().out
    one, again = (recordings.read(recordings.Source("a", f.read_bytes())) for f in (file, out))
    assert f"rows        {len(one)}" in said and "commanded" not in said
    assert again.kind == one.kind and len(again) == len(one)


def test_a_rotation_vector_turns_by_its_length():
    """By hand: a third of a turn about the diagonal of a cube leads each edge to the next one."""
    turned = _turn(np.full(3, 2 * np.pi / 3 / np.sqrt(3)))
    assert turned == pytest.approx(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]), abs=1e-12)
    assert np.array_equal(_turn(np.zeros(3)), np.eye(3))
