"""Step diagonals: what a plane mirror reads, by hand, and what the stair tells and can not tell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc import cli, recordings
from postproc.machine.tables import AxisTable
from postproc.volumetric import identify, solve, step_diagonals, written
from postproc.volumetric.observations import rows_of
from postproc.volumetric.unknowns import Unknowns
from tests.volumetric.readings import MILL, drawn, unknowns
from tests.volumetric.test_diagonals import line

ROOT = Path(__file__).resolve().parents[2]
ANGLES = frozenset(f"E{r}{x}" for r in "ABC" for x in "XYZ")
CORNERS = ((1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1))


def gcomp(*words) -> int:
    return cli.main([*map(str, words)])


def stair(corner, steps=4):
    """(3, N) slide positions, one axis after the other, and the direction of the diagonal."""
    low = np.array([MILL.axes[x].travel[s < 0] for x, s in zip("XYZ", corner, strict=True)])
    high = np.array([MILL.axes[x].travel[s > 0] for x, s in zip("XYZ", corner, strict=True)])
    q = [low.astype(float)]
    for k in range(steps):
        for i in range(3):
            q.append(q[-1].copy())
            q[-1][i] = low[i] + (high[i] - low[i]) * (k + 1) / steps
    return np.array(q).T, (high - low) / np.linalg.norm(high - low)


def read(u: Unknowns, truth, corner, rng, lean=(0.0, 0.0), noise=2e-4, **head) -> list:
    """The rows of a stair on a machine without rotations, by the displacement of the tool alone."""
    q, along = stair(corner)
    off = np.einsum("p,pin->in", truth, u.columns(q, 0 * q, u.bare.tool))
    aside = step_diagonals.aside(q, along)
    value = along @ off + np.array(lean) @ (step_diagonals.across(aside) @ aside)
    columns = {f"{x}_mm": q[i] for i, x in enumerate("XYZ")}
    columns |= {f"approach_{x}": 0 * q[i] for i, x in enumerate("XYZ")}
    columns |= {"run": 0 * q[0] + 1, "t_s": np.arange(q.shape[1])}
    columns["reading_um"] = (value + noise * rng.normal(size=q.shape[1])) * 1e3
    head |= {"quantity": "displacement", "u_um": noise * 1e3}
    head["sensitive"] = dict(zip("XYZ", along.tolist(), strict=True))
    recording = recordings.Recording("targets", head, columns, "s.csv", np.arange(q.shape[1]) + 2)
    return rows_of(recording, u.bare, {})


def test_the_place_on_the_mirror_by_hand():
    """X turns about Z by 20 urad wherever it stands. A step of 30 mm along Y, beside a beam along
    (1, 1, 0) / sqrt 2, puts the tool aside by (-15, 15) mm; the beam meets the mirror at the other
    side, (15, -15) from the tool. Turned by 20 urad this place moves by 20e-6 (15, 15) mm more than
    the tool: along the beam 20e-6 * 15 * sqrt 2 mm = 0.424 um."""
    q = np.array([[0.0, 0.0], [0.0, 30.0], [0.0, 0.0]])
    along = np.array([1.0, 1.0, 0.0]) / np.sqrt(2)
    aside = step_diagonals.aside(q, along)
    assert aside[:, 1] == pytest.approx([-15, 15, 0])
    both = np.zeros((6, 2))
    both[5] = 20e-6
    table = AxisTable("X", np.array([-1e3, 1e3]), both, both)
    bare = written.without_errors(MILL)
    turned = replace(bare, axes={**bare.axes, "X": replace(bare.axes["X"], table=table)})

    def effect(tool):
        return replace(turned, tool=tool).deviation(q, 0 * q)

    more = along @ (step_diagonals.on_the_beam(effect, bare.tool, aside) - effect(bare.tool))
    assert more * 1e3 == pytest.approx([0.0, 20e-6 * 15 * np.sqrt(2) * 1e3], abs=1e-9)


def test_what_four_stairs_tell():
    """Without rotations each step tells of one axis: straightness and squareness follow. What is
    linear in the steps is the mirror's too: of the twelve slopes of four stairs eight are leans,
    and the four that are left (the lengths of the diagonals) tell three squarenesses and one sum of
    the scales."""
    rng = np.random.default_rng(4)
    u = unknowns(nodes=5, zero=ANGLES)
    truth = drawn(u, rng)
    leans = 200e-6 * rng.normal(size=(4, 2))
    rows = [r for c, lean in zip(CORNERS, leans, strict=True) for r in read(u, truth, c, rng, lean)]
    assert {r.kind for r in rows} == {"stair"} and {len(r.start) for r in rows} == {3}
    fit = solve.fit(rows, u)
    assert identify.undetermined(fit) == [["EXX", "EYY", "EZZ"]]
    _held(fit, truth)
    # What the mirror does is its own, whatever it is.
    still = np.random.default_rng(4)
    drawn(u, still), still.normal(size=(4, 2))
    again = solve.fit([r for c in CORNERS for r in read(u, truth, c, still)], u)
    told = [k for k, g in enumerate(u.groups) if g.name not in ("EXX", "EYY", "EZZ")]
    for k in told:
        assert again.values(u.groups[k])[0] == pytest.approx(fit.values(u.groups[k])[0], abs=1e-7)


def test_scales_part_by_a_laser_along_each_axis_or_a_mirror_that_is_known():
    rng = np.random.default_rng(6)
    u = unknowns(nodes=5, zero=ANGLES)
    truth = drawn(u, rng)
    rows = [r for c in CORNERS for r in read(u, truth, c, rng, (50e-6, -80e-6))]
    for i, x in enumerate("XYZ"):
        ends = np.array([[a.travel[0], a.travel[1]] for a in (MILL.axes[v] for v in "XYZ")])
        start = ends.mean(axis=1)
        end = start.copy()
        start[i], end[i] = ends[i]
        rows.append(line(u, truth, rng, start, end, np.eye(3)[i], x))
    fit = solve.fit(rows, u)
    assert not identify.undetermined(fit)
    _held(fit, truth)
    known = [r for c in CORNERS for r in read(u, truth, c, rng, mirror_u_urad=1.0)]
    fit = solve.fit(known, u)
    assert not identify.undetermined(fit)
    _held(fit, truth)


def _held(fit, truth) -> None:
    """All numbers at once, by their covariance: chi-squared of as many degrees of freedom; less
    where the prior holds what the readings do not tell."""
    off = fit.numbers - truth
    chi = float(off @ np.linalg.solve(fit.covariance, off)) / len(off)
    assert 0.4 < chi < 1 + 4 * np.sqrt(2 / len(off)), chi


def test_the_shipped_stairs(capsys):
    """example-mill, whose slides turn: nothing of it is written that the stairs can not tell."""
    files = sorted((ROOT / "sample_recordings").glob("steps_?.csv"))
    assert len(files) == 4
    zero = ",".join(sorted(ANGLES))
    assert gcomp("volumetric", *files, "--like", "example-mill", "--zero", zero) == 0
    said = capsys.readouterr().out
    assert "stair, 38 readings" in said and "can not part EXX, EYY and EZZ from each other" in said
    assert "times the stated u" in said  # rotations are not zero there, and that is seen
    assert gcomp("volumetric", *files, "--like", "example-mill") == 0
    (sentence,) = [
        x for x in capsys.readouterr().out.splitlines() if "and B0Z from each other" in x
    ]
    assert all(name in sentence for name in ("EXX", "EYX", "EAX", "ECZ", "C0Y"))


def test_a_stair_in_a_plane_has_one_lean_and_a_diagonal_none(tmp_path, capsys):
    words = ("--machine", "example-mill", "--quiet", "-o", tmp_path / "s.csv")
    assert gcomp("simulate", "--test", "steps:XY,number=4", *words) == 0
    found = recordings.read(recordings.Source("s.csv", (tmp_path / "s.csv").read_bytes()))
    (row,) = rows_of(found, written.without_errors(MILL), {})
    assert row.kind == "stair" and len(row.start) == 2
    straight = ROOT / "sample_recordings" / "diagonal_xy_1.csv"
    found = recordings.read(recordings.Source("d.csv", straight.read_bytes()))
    assert [r.kind for r in rows_of(found, written.without_errors(MILL), {})] == ["line"]


def test_the_simulated_mirror_is_the_model_of_the_fit(tmp_path):
    """example-mill with all its rotations, without noise: the fit's model of the same errors, at
    the place where the beam meets the mirror, gives what the simulator's instrument reads, but for
    zero and leans."""
    for lean in ("X0", "X300,Y-200,Z100"):
        words = ("--machine", "example-mill", "--quiet", "-o", tmp_path / "s.csv")
        test = ("--test", "steps:XYZ,number=5,down_Y=1", "--set", f"lean={lean}")
        assert gcomp("simulate", *test, *words) == 0
        found = recordings.read(recordings.Source("s.csv", (tmp_path / "s.csv").read_bytes()))
        (row,) = rows_of(found, written.without_errors(MILL), {})

        def effect(tool):
            return replace(MILL, tool=tool).deviation(row.q, row.approach)

        said = row.along @ step_diagonals.on_the_beam(effect, row.tool, row.aside)
        nuisances = np.vstack([np.ones(len(said)), step_diagonals.across(row.aside) @ row.aside]).T
        left = row.value - said
        own = np.linalg.lstsq(nuisances, left, rcond=None)[0]
        assert (
            np.abs(left - nuisances @ own).max() < 1e-6
        )  # mm; the recording has six decimals of um


def test_each_set_up_is_a_stair_or_a_straight_diagonal_by_itself():
    q, along = stair((1, 1, 1))
    straight = q[:, :1] + (q[:, -1:] - q[:, :1]) * np.linspace(0, 1, 5)
    places = np.hstack([q, straight])
    columns = {f"{x}_mm": places[i] for i, x in enumerate("XYZ")}
    columns |= {f"approach_{x}": 0 * places[i] for i, x in enumerate("XYZ")}
    setup = np.repeat([1.0, 2.0], [q.shape[1], 5])
    columns |= {"run": 0 * setup + 1, "setup": setup, "reading_um": 0 * setup}
    head = {"quantity": "displacement", "sensitive": dict(zip("XYZ", along.tolist(), strict=True))}
    recording = recordings.Recording("targets", head, columns, "s.csv", np.arange(len(setup)) + 2)
    rows = rows_of(recording, written.without_errors(MILL), {})
    assert [(r.kind, len(r), len(r.start)) for r in rows] == [("stair", 13, 3), ("line", 5, 1)]


@pytest.mark.parametrize("said", ['"fifty"', "-20", "0", "nan", "true"])
def test_how_well_the_mirror_stands_is_an_angle_above_zero(said, tmp_path, capsys):
    text = (ROOT / "sample_recordings" / "steps_1.csv").read_text()
    (tmp_path / "s.csv").write_text(text.replace("# u_um", f"# mirror_u_urad = {said}\n# u_um", 1))
    assert gcomp("volumetric", tmp_path / "s.csv", "--like", "example-mill") == 2
    err = capsys.readouterr().err
    assert "mirror_u_urad = " in err and "is no angle above zero" in err
