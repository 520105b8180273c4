"""Circles of a ballbar in a map of the volume: by hand, one alone, and several to a machine."""

from __future__ import annotations

import numpy as np
import pytest

from postproc import recordings
from postproc.machine import part
from postproc.machine.file import read_machine
from postproc.volumetric import VolumetricError, identify, nodes, solve, written
from postproc.volumetric.observations import rows_of
from postproc.volumetric.unknowns import Unknowns, components
from tests.volumetric.readings import MILL, gcomp
from tests.volumetric.test_step_diagonals import ANGLES
from tests.volumetric.test_volumetric import _rigid

R = 150.0
BARE = written.without_errors(MILL)
PLANE = ("EXX", "EYX", "EXY", "EYY", "C0Y")
ASIDE = ANGLES | {"EZX", "EZY"}


def circle(error, senses=(1, -1), zero=2.0, centre=(0.0, 0.0), off=(3.0, -2.0), u_um=0.1):
    """A ballbar's recording of a machine with errors error(x, y, way_x, way_y) -> (e_x, e_y) in um,
    by the geometry of ISO 230-4; the ball on the table stands `off` um beside the centre."""
    columns = {n: [] for n in ("run", "t_s", "X_cmd_mm", "Y_cmd_mm", "Z_cmd_mm", "sense")}
    columns["radial_um"] = []
    for run, sense in enumerate(senses, 1):
        t = sense * (np.arange(720) + 0.5) / 720 * 2 * np.pi
        x, y = centre[0] + R * np.cos(t), centre[1] + R * np.sin(t)
        e = error(x, y, -sense * np.sign(np.sin(t)), sense * np.sign(np.cos(t)))
        far = np.hypot(x + e[0] / 1e3 - centre[0] - off[0] / 1e3, y + e[1] / 1e3 - centre[1]
                       - off[1] / 1e3)  # fmt: skip
        columns["radial_um"] += list((far - R) * 1e3 + zero)
        for name, values in (("X_cmd_mm", x), ("Y_cmd_mm", y), ("Z_cmd_mm", 0 * x - 200.0)):
            columns[name] += list(values)
        columns["run"] += [run] * len(t)
        columns["t_s"] += list(1000.0 * run + np.arange(len(t)))
        columns["sense"] += [sense] * len(t)
    head = {"centre": dict(zip("XY", centre, strict=True)), "radius_mm": R, "u_um": u_um}
    data = {k: np.array(v, float) for k, v in columns.items()}
    return recordings.Recording("ballbar", head, data, "c.csv", np.arange(len(data["run"])) + 2)


def fit_of(*circles, keep=PLANE, number=5):
    at = {x: np.linspace(-R, R, number) for x in "XY"}
    every = components(BARE, at, frozenset(), frozenset("XY"))
    groups = [g for g in every if g.name in (*keep, "B:X", "B:Y")]
    unknowns = Unknowns(tuple(groups), BARE, BARE)
    return solve.fit([r for c in circles for r in rows_of(c, BARE, {})], unknowns)


def value(fit, name):
    group = next(g for g in fit.unknowns.groups if g.name == name)
    return fit.values(group)[0]


def test_squareness_and_lost_motion_by_hand():
    """Y leans towards -X by 80 urad (C0Y = +80): e_x = -80e-6 y. X lags by 6 um, so it is 3 um
    behind on either side: forward less reverse is -6 um. Neither the bar's length nor the centre's
    place is of the machine."""
    error = circle(lambda x, y, a, b: (-80e-3 * y - 3.0 * a, -1.0 * b))
    fit = fit_of(error, keep=("C0Y",))
    assert value(fit, "C0Y")[0] * 1e6 == pytest.approx(80.0, abs=0.05)
    assert value(fit, "B:X")[0] * 1e3 == pytest.approx(-6.0, abs=0.02)
    assert value(fit, "B:Y")[0] * 1e3 == pytest.approx(-2.0, abs=0.02)
    assert fit.rows[0].kind == "length" and len(fit.rows[0]) == 2 * 180


def test_a_straightness_by_hand():
    """Y strays by a bow of 8 um where X runs: EYX = 8 (1 - x^2 / R^2), with the positioning of both
    axes known (taken as zero). Its value at X = 0 is its zero: -8 um at both ends, and a line of a
    straightness, even here, is none."""
    fit = fit_of(circle(lambda x, y, a, b: (0 * x, 8.0 * (1 - x**2 / R**2))), keep=("EYX", "C0Y"))
    found = value(fit, "EYX") * 1e3
    assert found[[0, 2, 4]] == pytest.approx([-8.0, 0.0, -8.0], abs=0.25)
    assert value(fit, "C0Y")[0] * 1e6 == pytest.approx(0.0, abs=0.2)


def test_one_circle_does_not_part_scales_from_the_bars_length():
    """Both scales and a longer bar make the same circle larger; where only one of them is asked
    for, that is told."""
    error = circle(lambda x, y, a, b: (20e-3 * x, 0 * y))
    assert {"EXX", "EYY"} <= set(identify.undetermined(fit_of(error))[0])
    fit = fit_of(error, keep=("EXX",))
    assert value(fit, "EXX") * 1e3 == pytest.approx(20e-3 * np.linspace(-R, R, 5), abs=0.02)


def test_what_is_no_circle_in_both_senses_is_refused():
    def nothing(x, y, a, b):
        return 0 * x, 0 * y

    with pytest.raises(VolumetricError, match="one way only"):
        rows_of(circle(nothing, senses=(1, 1)), BARE, {})
    other = circle(nothing)
    other.head["centre"] = {"X": 0.0, "Y": 0.0, "Z": 0.0}
    with pytest.raises(VolumetricError, match="names no two slides"):
        rows_of(other, BARE, {})


def test_circles_at_several_places_are_a_map(tmp_path, capsys):
    """Five circles and one laser on example-mill whose slides do not turn, by the simulator: the
    plane's whole map, held against the machine itself but for where the part lies."""
    on = ("--machine", "example-mill", "--only", ",".join(PLANE), "--noise", "0.3", "--quiet")
    files = []
    for k, place in enumerate(
        (
            "at_X=-160,radius=180",
            "at_X=0,radius=180",
            "at_X=160,radius=180",
            "at_X=-200,at_Y=60,radius=100",
            "at_X=200,at_Y=-60,radius=100",
        )
    ):
        files.append(tmp_path / f"c{k}.csv")
        test = ("--test", f"ballbar:XY,feed=400,{place}", "--set", "rate=20", "--seed", k)
        assert gcomp("simulate", *test, *on, "-o", files[-1]) == 0
    zero = ("--zero", ",".join(sorted(ASIDE - {"EAZ", "EBZ", "ECZ"})), "--like", "example-mill")
    assert gcomp("volumetric", *files, *zero) == 0
    assert "can not part EXX from EYY;" in capsys.readouterr().out  # the bar's length is unknown
    laser = tmp_path / "x.csv"
    assert gcomp("simulate", "--test", "positioning:X,runs=2", *on, "-o", laser) == 0
    assert gcomp("volumetric", *files, laser, *zero, "-o", tmp_path / "found") == 0
    assert "not told" not in capsys.readouterr().out

    mine, true = read_machine(tmp_path / "found"), part.only(MILL, PLANE)
    rng = np.random.default_rng(1)
    q = np.array([rng.uniform(-340, 340, 400), rng.uniform(-175, 175, 400), np.full(400, -200.0)])
    way = rng.choice([-1.0, 1.0], q.shape)
    off = true.deviation(q, way)
    left = off - mine.deviation(q, way)
    left -= _rigid(q, left)
    assert np.sqrt((left[:2] ** 2).mean()) < 0.06 * np.sqrt((off[:2] ** 2).mean())

    # U holds what lies between the nodes too: each sector counted as a reading of its own, 36 %.
    rows = [
        r
        for f in (*files, laser)
        for r in rows_of(recordings.read(recordings.Source(f.name, f.read_bytes())), BARE, {})
    ]
    every = components(BARE, nodes.of_axes(rows, MILL), frozenset(), frozenset("XY"))
    groups = [g for g in every if g.name in (*PLANE, "B:X", "B:Y")]
    u = solve.fit(rows, Unknowns(tuple(groups), BARE, BARE)).at(q, way, MILL.tool)[1]
    assert (np.abs(left[:2]) <= 2 * u[:2]).mean() > 0.8


def test_senses_may_be_told_from_behind_and_runs_may_have_no_number():
    """Which way a run turns is in its samples; a file without `run` has one run in each sense."""
    for change in ("sense", "run"):
        error = circle(lambda x, y, a, b: (-80e-3 * y - 3.0 * a, -1.0 * b))
        if change == "sense":
            error.columns["sense"] = -error.columns["sense"]
        else:
            del error.columns["run"]
        fit = fit_of(error, keep=("C0Y",))
        assert value(fit, "C0Y")[0] * 1e6 == pytest.approx(80.0, abs=0.05)
        assert value(fit, "B:X")[0] * 1e3 == pytest.approx(-6.0, abs=0.02)
        assert len(fit.rows[0]) == 2 * 180
