"""Maps of readings all over the volume: intervals hold, what can not be parted is said, and physics
that is known by hand."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc import cli, recordings
from postproc.commands import volumetric as command
from postproc.machine.file import read_machine
from postproc.machine.poses import slides_at, tips
from postproc.recordings import Recording, contract
from postproc.volumetric import VolumetricError, identify, solve, written
from postproc.volumetric.observations import Rows, nominal_tip, rows_of
from postproc.volumetric.unknowns import ANGLE, LENGTH, SQUARE, Unknowns, components, locations
from tests.api import schemas

ROOT = Path(__file__).resolve().parents[2]
MILL = read_machine(ROOT / "machines" / "example-mill")
FIVE = read_machine(ROOT / "machines" / "example-five-axis")
TOOLS = (
    (0.0, 0.0, -100.0),
    (60.0, 0.0, -180.0),
    (0.0, 60.0, -140.0),
)  # not on one line: a turn about such a line moves none of them
SIZES = {LENGTH: 0.006, ANGLE: 25e-6, SQUARE: 60e-6}  # mm and rad: what is drawn
NONE = frozenset()


def gcomp(*words) -> int:
    return cli.main([*map(str, words)])


def unknowns(machine=MILL, nodes=5, zero=NONE, two_way=NONE) -> Unknowns:
    bare = written.without_errors(machine)
    at = {x: np.linspace(*machine.axes[x].travel, nodes) for x in "XYZ" if x in machine.axes}
    return Unknowns(tuple(components(machine, at, zero, two_way)), bare, bare)


def drawn(u: Unknowns, rng) -> np.ndarray:
    return rng.normal(size=u.number) * np.array([SIZES[p] for p in u.prior])


def places(machine, number: int, rng) -> tuple[np.ndarray, np.ndarray]:
    q = np.array([rng.uniform(*axis.travel, number) for axis in machine.axes.values()])
    return q, rng.choice([-1.0, 1.0], q.shape)


def recording(
    u: Unknowns, truth, rng, kind: str, tool, number=100, noise=1e-3, name="a.csv", station=None
) -> Recording:
    """A tracker's cloud in a frame of its own, or lengths from a station, of a machine with these
    errors."""
    q, approach = places(u.bare, number, rng)
    arm = u.bare.tool + np.array(tool)
    tip = nominal_tip(u.bare, q, arm) + np.einsum("p,pin->in", truth, u.columns(q, approach, arm))
    columns = {f"{x}_mm": q[i] for i, x in enumerate(u.bare.letters)}
    columns |= {f"approach_{x}": approach[i] for i, x in enumerate(u.bare.letters)}
    if kind == "points":
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        seen = (
            turn @ tip + rng.uniform(-1000, 1000, 3)[:, None] + noise * rng.normal(size=tip.shape)
        )
        columns |= {f"m{x}_mm": seen[i] for i, x in enumerate("xyz")}
    else:
        away = np.linalg.norm(tip - np.array(station)[:, None], axis=0)
        columns["length_mm"] = away - 77.0 + noise * rng.normal(size=number)
    head = {"tool": dict(zip("XYZ", tool, strict=True)), "u_um": noise / 1e-3}
    return Recording(kind, head, columns, name, np.arange(number) + 2)


def held(fit, u: Unknowns, truth) -> list[bool]:
    """Whether each value lies within 2 u, of errors that are told; values that are zero by
    definition left out."""
    found: list[bool] = []
    hidden = written.open_names(fit)
    for group, where in zip(u.groups, u.slices, strict=True):
        value, s = fit.values(group)
        off = np.abs(value - group.basis @ truth[where])
        if group.name not in hidden:
            found += (off <= 2 * s)[s > 1e-12].tolist()
    return found


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
    assert not identify.untold(fit), (k, identify.sentences(identify.untold(fit)))
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


def test_a_turn_about_the_line_through_two_reflectors_is_not_told():
    """Two reflectors: what the Z slide turns about the line through both moves neither. By hand: a
    rotation r with r x (b - a) = 0."""
    rng = np.random.default_rng(1)
    u = unknowns(nodes=4)
    rows = [
        r
        for t in TOOLS[:2]
        for r in rows_of(recording(u, drawn(u, rng), rng, "points", t), u.bare, {})
    ]
    (names,) = identify.untold(solve.fit(rows, u))
    assert {"EAZ", "ECZ"} <= set(names) and "EBZ" not in names  # b - a is (60, 0, -80)
    three = [
        r for t in TOOLS for r in rows_of(recording(u, drawn(u, rng), rng, "points", t), u.bare, {})
    ]
    assert not identify.untold(solve.fit(three, u))


def line(u: Unknowns, truth, rng, start, end, along, name: str) -> Rows:
    t = np.linspace(0, 1, 9)
    q = np.array(start)[:, None] + (np.array(end) - np.array(start))[:, None] * t
    off = np.einsum("p,pin->in", truth, u.columns(q, 0 * q, u.bare.tool))
    value = np.array(along) @ off + 2e-4 * rng.normal(size=9)
    return Rows("line", q, 0 * q, value, 2e-4, u.bare.tool, np.zeros(1), name, np.array(along))


def test_what_diagonals_tell_by_hand():
    """Two diagonals of the X Y plane, of a machine that has EXX, EYY and C0Y alone: along (1, 1)
    and (1, -1) the readings are (EXX + EYY -+ C0Y y) / sqrt(2): squareness is half of their
    difference, and EXX and EYY stand in both as a sum."""
    rng = np.random.default_rng(3)
    u = unknowns(nodes=3)
    names = [g.name for g in u.groups]
    zero = frozenset(n for n in names if n not in ("C0Y", "EXX", "EYY"))
    part = unknowns(nodes=3, zero=zero)
    truth = drawn(part, rng)
    low, high = -150.0, 150.0
    h = np.sqrt(0.5)
    two = [
        line(part, truth, rng, (low, low, -200), (high, high, -200), (h, h, 0), "d1"),
        line(part, truth, rng, (low, high, -200), (high, low, -200), (h, -h, 0), "d2"),
    ]
    fit = solve.fit(two, part)
    told = identify.untold(fit)
    assert ["EXX", "EYY"] in told  # their sum is told, by both diagonals alike
    assert not any("C0Y" in s for s in told)
    value, s = fit.values(next(g for g in part.groups if g.name == "C0Y"))
    k = [g.name for g in part.groups].index("C0Y")
    assert abs(value[0] - truth[part.slices[k]][0]) < 3 * s[0] < 1e-5
    # One diagonal alone parts nothing.
    one = identify.untold(solve.fit(two[:1], part))
    assert {"C0Y", "EXX", "EYY"} == {n for s in one for n in s}
    assert "these readings can not part" in identify.sentences(one)[0]


def test_the_shipped_diagonals_say_what_they_can_not_part(capsys):
    """Two diagonals of X and Y: straightness, angles and squareness act on them alike, and none of
    it is written."""
    files = [ROOT / "sample_recordings" / f"diagonal_xy_{k}.csv" for k in (1, 2)]
    assert gcomp("volumetric", *files, "--like", "example-mill") == 0
    said = capsys.readouterr().out
    (sentence,) = [line for line in said.splitlines() if "C0Y from each other" in line]
    assert all(name in sentence for name in ("EXX", "EYX", "EXY", "EYY", "C0Y"))
    assert (
        gcomp(
            "volumetric",
            *files,
            "--like",
            "example-mill",
            "--zero",
            "EAX,EBX,ECX,EAY,EBY,ECY,EYX,EXY,EZX,EZY",
        )
        == 0
    )
    assert "C0Y   not told" not in capsys.readouterr().out
    assert gcomp("volumetric", *files, "--like", "example-mill", "--zero", "EQX") == 2
    assert "there is no such error here" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["tracker_1", "sphere_1"])
@pytest.mark.parametrize(
    "words",
    [
        ("diagnose", "--machine", "example-five-axis"),
        ("iso",),
        ("calibrate", "--like", "example-five-axis"),
    ],
)
def test_other_commands_say_what_such_a_recording_is(name, words, capsys):
    assert gcomp(*words, ROOT / "sample_recordings" / f"{name}.csv") == 2
    said = capsys.readouterr().err
    assert "Traceback" not in said and ("points" in said or "sphere" in said)


def test_a_six_degree_of_freedom_file_is_six_recordings(tmp_path, capsys):
    """X of example-mill, all six read at once: the map holds each of them, straightness without its
    slope."""
    x = np.linspace(-300, 300, 13)
    q = np.zeros((3, 13))
    q[0] = x
    table = MILL.tables["X"]
    alone = replace(written.without_errors(MILL), tool=np.zeros(3))
    alone = replace(
        alone,
        axes={
            **alone.axes,
            "X": replace(alone.axes["X"], table=replace(table, reverse=table.forward)),
        },
    )
    six = np.array([np.interp(x, table.nodes, table.forward[k]) for k in range(6)])
    # lengths are read where the tool is: with the axis' own arm
    truth, six[:3] = six.copy(), alone.deviation(q, q * 0)
    head = "X_mm,EXX_um,EYX_um,EZX_um,EAX_urad,EBX_arcsec,ECX_urad,approach,Y_mm,Z_mm"
    unit = np.array([1e3, 1e3, 1e3, 1e6, 1e6 * 0.2062648, 1e6])
    rows = [",".join(f"{v:.6f}" for v in (x[i], *(six[:, i] * unit), 1, 0, 0)) for i in range(13)]
    (tmp_path / "x.csv").write_text("\n".join([head, *rows]) + "\n")
    read = recordings.read_all(recordings.Source("x.csv", (tmp_path / "x.csv").read_bytes()))
    assert [r.quantity for r in read] == [
        "displacement",
        "straightness",
        "straightness",
        "angle",
        "angle",
        "angle",
    ]
    assert read[4].reading == pytest.approx(six[4], abs=1e-11)
    words = (
        "--like",
        "example-mill",
        "--json",
        tmp_path / "j.json",
        "--head",
        "u_um=0.1",
        "--head",
        "tool={Z=60}",
    )
    assert gcomp("volumetric", tmp_path / "x.csv", *words) == 0
    document = json.loads((tmp_path / "j.json").read_text())
    schemas.held(document)
    found = document["errors"]
    for name, row in (("EXX", 0), ("EAX", 3), ("EBX", 4), ("ECX", 5)):
        wanted = (truth[row] - truth[row][6]) * (1e3 if row < 3 else 1e6)
        assert found[name]["value"] == pytest.approx(wanted, abs=0.05), name
    bent = truth[1] - np.polyval(np.polyfit(x, truth[1], 1), x)
    assert found["EYX"]["value"] == pytest.approx((bent - bent[6]) * 1e3, abs=0.05)
    capsys.readouterr()


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
        from postproc.volumetric.observations import to_machine

        read = (
            np.einsum("ijn,jn->in", to_machine(FIVE, q), off)
            + np.array([[0.3], [-0.2], [0.1]])
            + 3e-4 * rng.normal(size=(3, 60))
        )
        rows.append(Rows("shift", q, 0 * q, read, 3e-4, FIVE.tool, np.zeros(3), "r", np.zeros(3)))
    fit = solve.fit(rows, u)
    assert not identify.untold(fit)
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
    assert not identify.untold(fit)
    truth = {"Y0A": 9, "Z0A": -12, "X0C": 7, "Y0C": -6, "B0A": 14, "C0A": -9, "A0C": 11, "B0C": -16}
    for group in u.groups:
        value, s = fit.values(group)
        one = 1e-3 if group.row < 3 else 1e-6
        assert abs(value[0] / one - truth[group.name]) <= 3.5 * s[0] / one and s[0] / one < 5, (
            group.name
        )


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
    assert "these readings" not in said and "not told" not in said
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


@pytest.mark.parametrize(
    ("kind", "columns", "says"),
    [
        (
            "points",
            {"X_mm": [0, 1, 2], "Y_mm": [0, 1, 2], "Z_mm": [0, 0, 0]},
            "fewer than four points",
        ),
        (
            "lengths",
            {"X_mm": [0, 1, 2], "Y_mm": [0, 1, 2], "Z_mm": [0, 0, 0]},
            "five lengths at least",
        ),
        ("points", {"X_mm": [0, 1, 2, 3], "Y_mm": [0, 1, 2, 3]}, "where Z stood is not recorded"),
        (
            "ballbar",
            {"X_cmd_mm": [0, 1], "Y_cmd_mm": [0, 1], "Z_cmd_mm": [0, 1]},
            "a recording of ballbar tells nothing of the volume",
        ),
    ],
)
def test_what_is_refused(kind, columns, says):
    data = {name: np.array(v, float) for name, v in columns.items()}
    n = len(next(iter(data.values())))
    data |= {c: np.zeros(n) for c in ("mx_mm", "my_mm", "mz_mm", "length_mm")}
    with pytest.raises(VolumetricError, match=says):
        rows_of(Recording(kind, {}, data, "a.csv", np.arange(n)), written.without_errors(MILL), {})


def lengths(z, station, number=12, **columns) -> Recording:
    """Lengths without noise, at one height or between two, from a station."""
    t = np.linspace(0, 2 * np.pi, number, endpoint=False)
    q = np.array([150 * np.cos(t), 120 * np.sin(2 * t), np.resize(z, number)])
    tip = nominal_tip(MILL, q, MILL.tool)
    data = {f"{x}_mm": row for x, row in zip("XYZ", q, strict=True)}
    data["length_mm"] = np.linalg.norm(tip - np.array(station)[:, None], axis=0) + 5.0
    data |= {c: np.full(number, v) for c, v in columns.items()}
    return Recording("lengths", {"u_um": 0.5}, data, "l.csv", np.arange(number) + 2)


def fit_of(*read: Recording):
    u = unknowns(nodes=3)
    return solve.fit([r for one in read for r in rows_of(one, u.bare, {})], u)


def test_lengths_in_the_plane_of_their_station_do_not_tell_its_height(tmp_path, capsys):
    """dL/dz = (z - z of the station) / L is zero for all of them: the set-up is named. Another
    height, or the station's place, tells it."""
    height = float(nominal_tip(MILL, np.array([[0.0], [0.0], [-200.0]]), MILL.tool)[2, 0])
    place = (900.0, -700.0, height)
    with pytest.raises(VolumetricError, match="l.csv: a set-up of 12 readings") as error:
        fit_of(lengths(-200.0, place))
    assert "station_X_mm" in error.value.advice
    stated = {f"station_{x}_mm": v for x, v in zip("XYZ", place, strict=True)}
    for read in (lengths([-200.0, -100.0], place), lengths(-200.0, place, **stated)):
        assert np.isfinite(fit_of(read).covariance).all()
    file = tmp_path / "l.csv"
    file.write_text(contract.write(lengths(-200.0, place)))
    assert gcomp("volumetric", file, "--like", "example-mill") == 2
    assert "does not tell where it stands" in capsys.readouterr().err


@pytest.mark.parametrize("groups", [[1.0], [1.0, 1.0, 1.0, 1.0, 2.0], [1.0, 1.0, 2.0, 2.0]])
def test_a_straightness_of_one_or_two_places_is_refused(groups):
    """Two numbers of the set-up: two readings leave nothing, and one has no slope at all."""
    at = 10.0 * np.arange(len(groups))
    columns = {"X_mm": at, "Y_mm": 0 * at, "Z_mm": 0 * at, "setup": np.array(groups)}
    head = {"quantity": "straightness", "sensitive": {"Y": 1.0}, "u_um": 0.5}
    read = Recording("targets", head, columns | {"reading_um": at}, "s.csv", np.arange(len(at)) + 2)
    with pytest.raises(VolumetricError, match="a straightness of [12] places in one set-up"):
        fit_of(read)


def test_a_station_is_held_only_where_its_whole_place_is_said():
    """One column of three was enough to hold an estimated place to a millimetre."""
    place = (900.0, -700.0, 300.0)
    with pytest.raises(VolumetricError, match="said in part: no column station_Y_mm and no column"):
        fit_of(lengths([-200.0, -100.0], place, station_X_mm=900.0))
    (free,) = rows_of(lengths([-200.0, -100.0], place), written.without_errors(MILL), {})
    assert not free.loose.any() and free.start == pytest.approx([*place, 5.0], abs=1e-3)
    wanders = lengths([-200.0, -100.0], place, station_X_mm=900.0, station_Y_mm=0, station_Z_mm=0)
    wanders.columns["station_X_mm"][3] = 800.0
    with pytest.raises(VolumetricError, match="do not name one place"):
        fit_of(wanders)


@pytest.mark.parametrize("tool", ["5.0", '{ Z = "long" }', "{ Q = 1.0 }", "{ Z = nan }", "[1, 2]"])
def test_a_tool_that_is_no_place_is_refused(tool, tmp_path, capsys):
    text = contract.write(lengths([-200.0, -100.0], (900.0, -700.0, 300.0)))
    (tmp_path / "l.csv").write_text(f"# tool = {tool}\n{text}")
    assert gcomp("volumetric", tmp_path / "l.csv", "--like", "example-mill") == 2
    said = capsys.readouterr().err
    assert "tool = " in said and "like tool = { X = 0.0, Z = -100.0 }" in said


@pytest.mark.parametrize("command", ["volumetric", "calibrate"])
def test_a_machine_with_second_slides_is_refused(command, tmp_path, capsys):
    """W's own errors were gone from the machine that was written; calibrate ended in a
    ValueError."""
    folder = tmp_path / "quill"
    folder.mkdir()
    text = (ROOT / "machines" / "perfect" / "machine.toml").read_text()
    said = {f"{x}": f"[axes.{x}]\ntravel = [-300, 300]\nleast_increment = 0.001\n" for x in "XYZW"}
    head = [line for line in text.splitlines() if line.startswith(("format", "name", "control"))]
    head += ['title = "made up"', 'source = "made up"', 'chain = "w-X-Y-b-Z-W-t"']
    (folder / "machine.toml").write_text("\n".join([*head, *said.values()]) + 'table = "W.csv"\n')
    (folder / "W.csv").write_text("W_mm,EZW_um\n-300,0\n300,20\n")
    read_machine(folder)
    file = ROOT / "sample_recordings" / "tracker_1.csv"
    if command == "calibrate":
        file = tmp_path / "z.csv"
        at = np.linspace(-200, 200, 9)
        rows = [f"{r},{z:g},{a},{z / 100:.2f}" for r in (1, 2, 3) for a in (1, -1) for z in at]
        head = ['format = "gcomp-recording/1"', 'kind = "targets"', "sensitive = { Z = 1.0 }"]
        lines = [*(f"# {h}" for h in head), "run,Z_mm,approach_Z,reading_um", *rows]
        file.write_text("\n".join(lines) + "\n")
    assert gcomp(command, file, "--like", folder, "-o", tmp_path / "m") == 2
    assert "second slides too (W)" in capsys.readouterr().err
    assert not (tmp_path / "m").exists()


SIX = "X_mm,EXX_um,EYX_um,EZX_um"


@pytest.mark.parametrize(
    ("columns", "says", "line"),
    [
        (f"{SIX},EAX_deg,EBX_deg", "EAX_deg is no column of a six-degree-of-freedom table", 4),
        (f"{SIX},EZX_um", "the column 'EZX_um' stands twice", 4),
        (f"{SIX},EXY_um", "EXY_um is no error of X, which moves", 4),
        (f"{SIX},EAX", "EAX is no column", 4),
    ],
)
def test_a_column_that_would_be_lost_or_read_twice_is_refused(columns, says, line):
    """Comments below the head do not move the line that is named."""
    number = len(columns.split(","))
    rows = [",".join(["1"] * number), "# between", ",".join(["2"] * number)]
    text = "\n".join(["# a", "# b", "# c", columns, "# below", "# and below", *rows]) + "\n"
    with pytest.raises(recordings.RecordingError, match=says) as error:
        recordings.read_all(recordings.Source("x.csv", text.encode()))
    assert error.value.place.line == line


def test_a_column_that_nothing_reads_is_named():
    text = f"{SIX},humidity,T_air_C\n1,0,0,0,50,20\n2,0,0,0,50,20\n"
    for read in recordings.read_all(recordings.Source("x.csv", text.encode())):
        assert read.notices == ("columns that nothing here reads: humidity",)


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
