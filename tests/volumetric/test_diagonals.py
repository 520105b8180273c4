"""Diagonals and lengths: what they tell and what they can not, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.recordings import contract
from postproc.volumetric import VolumetricError, identify, solve, written
from postproc.volumetric.observations import rows_of
from postproc.volumetric.rows import Rows, nominal_tip
from postproc.volumetric.unknowns import Unknowns
from tests.volumetric.readings import MILL, ROOT, drawn, fit_of, gcomp, lengths, unknowns


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
    told = identify.undetermined(fit)
    assert ["EXX", "EYY"] in told  # their sum is told, by both diagonals alike
    assert not any("C0Y" in s for s in told)
    value, s = fit.values(next(g for g in part.groups if g.name == "C0Y"))
    k = [g.name for g in part.groups].index("C0Y")
    assert abs(value[0] - truth[part.slices[k]][0]) < 3 * s[0] < 1e-5
    # One diagonal alone parts nothing.
    one = identify.undetermined(solve.fit(two[:1], part))
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
