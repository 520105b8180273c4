"""Fanuc's numbers: the manual's own example, the seed's Table 7.2 there and back, carry,
magnification, both directions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import models
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from postproc.control_tables import ErrorTable, ExportOptions, TableError, fanuc
from postproc.recordings import Source
from postproc.units import UM

SEED = Path(__file__).resolve().parents[2].parent / "shared" / "seed"
PITCH, SETTINGS = (
    SEED / "table_7_2_mv1060_fanuc_pitch.csv",
    SEED / "table_7_2_mv1060_fanuc_settings.csv",
)
HOME = ExportOptions(reference={x: 0.0 for x in "XYZ"})
seed = pytest.mark.skipif(not PITCH.exists(), reason="the seed's tables are not here")

MANUAL = dict(
    zip(range(33, 50), (2, 1, 1, -2, 0, -1, 0, -1, 2, 1, 0, -1, -1, -2, 0, 1, 2), strict=True)
)  # B-63980EN page 100: reference 40, interval 50 mm


def manual_csv() -> bytes:
    rows = [f"X,{n},{v}" for n, v in MANUAL.items()]
    head = [
        "axis,parameter_no,value",
        "X,3620,40",
        "X,3621,33",
        "X,3622,49",
        "X,3623,1",
        "X,3624,50000",
    ]
    return "\n".join([*head, *rows, ""]).encode()


def test_the_manuals_example_gives_the_sums_that_follow_by_hand():
    """0 at the reference; up from there +2 +3 +3 +2 +1 -1 -1 0 +2, down +1 +1 +2 +2 +4 +3 +2 0 (its
    figure spans 4)."""
    (table,) = fanuc.read(Source("manual.csv", manual_csv()), HOME)
    np.testing.assert_allclose(table.nodes, np.arange(-400, 500, 50))
    up = [0, 2, 3, 3, 2, 1, -1, -1, 0, 2]
    down = [0, 1, 1, 2, 2, 4, 3, 2, 0]
    np.testing.assert_allclose(-table.forward / UM, [*down[:0:-1], *up], atol=1e-9)
    assert not table.two_way


@seed
def test_table_7_2_is_read_and_written_back_to_the_same_82_numbers_and_settings():
    told = replace(HOME, extra={"settings": SETTINGS.read_text()})
    tables = fanuc.read(Source(PITCH.name, PITCH.read_bytes()), told)
    assert [t.name for t in tables] == ["EXX", "EYY", "EZZ"]
    extra = {
        "form": "csv",
        "span": "map",
        "range_X": "1:101",
        "range_Y": "102:201",
        "range_Z": "202:301",
    }
    back = replace(
        HOME,
        spacing=20.0,
        two_way=False,
        first={"X": 100, "Y": 200, "Z": 300},
        program="t",
        extra=extra,
    )
    files = fanuc.write(tables, back).files
    assert files["t_pitch.csv"] == PITCH.read_bytes()
    assert files["t_settings.csv"] == SETTINGS.read_bytes()
    assert files["t_pitch.csv"].count(b"\n") == 83  # a heading and 82 numbers


@seed
def test_table_7_2_takes_out_what_its_sums_say():
    """X: 51 to 101 add up to 36 um, all but the last of them (0) below the reference: at -1000 the
    axis was 36 um too far in +.
    Y: 171 to 201 add up to 12 um from -600 to +20; backlash of 2 um."""
    told = replace(HOME, extra={"settings": SETTINGS.read_text()})
    x, y, z = fanuc.read(Source(PITCH.name, PITCH.read_bytes()), told)
    assert (x.nodes[0], x.nodes[-1]) == (-1000.0, 20.0)
    assert x.at(np.array([-1000.0, 0.0, 20.0])) / UM == approx([36.0, 0.0, 0.0])
    assert (y.nodes[0], y.nodes[-1]) == (-600.0, 20.0)
    assert y.at(np.array([-600.0, 0.0])) / UM == approx([12.0, 0.0])
    assert (y.reverse - y.forward) / UM == approx(np.full(len(y.nodes), 2.0))
    assert (z.reverse - z.forward) / UM == approx([1.0])


@pytest.mark.parametrize("form", ["l50", "l52", "records", "csv"])
def test_every_form_holds_the_same_numbers(form):
    nodes = np.arange(-200.0, 1.0, 20.0)
    table = ErrorTable("Y", "Y", nodes, nodes * 1e-5, nodes * 1e-5 - 0.003)
    options = replace(HOME, extra={"form": form}, first={"Y": 60})
    export = fanuc.write([table], options)
    name = next(n for n in export.files if "settings" not in n)
    extra = dict(options.extra)
    if form == "csv":
        extra["settings"] = export.files["gcomp_settings.csv"].decode()
    (back,) = fanuc.read(Source(name, export.files[name]), replace(options, extra=extra))
    moved = table.at(np.zeros(1), 1.0)[0]
    for way in (1.0, -1.0):
        np.testing.assert_allclose(
            back.at(nodes, way), table.at(nodes, way) - moved, atol=0.0005 + 1e-9
        )
    assert (form in ("l50", "l52")) == any(
        "G10" in n for n in export.notices if n.startswith("unverified")
    )


@settings(max_examples=200, deadline=None)
@given(
    values=st.lists(st.floats(-0.05, 0.05), min_size=2, max_size=60),
    step=st.sampled_from([0.001, 0.0001, 0.0005]),
)
def test_carry_keeps_the_running_sum_within_half_a_unit(values, step):
    nodes = 10.0 * np.arange(len(values))
    column = np.array(values)
    options = replace(HOME, step=step, spacing=10.0, extra={"largest": "127"})
    export = fanuc.write([ErrorTable("X", "X", nodes, column, column)], options)
    text = export.files["gcomp_fanuc.nc"].decode()
    magnification = int(text.split("N3623 P1 R")[1].split()[0])
    sums = models.fanuc(text, {}, step, 0.001, "XYZ")("X", "X", nodes, 1.0)
    assert np.abs(sums + column - column[0]).max() <= magnification * step / 2 + 1e-9


def test_an_increment_beyond_seven_halves_the_spacing_and_then_raises_the_magnification():
    nodes = np.array([0.0, 10.0, 20.0])
    table = ErrorTable(
        "X", "X", nodes, np.array([0.0, 0.012, 0.012]), np.array([0.0, 0.012, 0.012])
    )
    finer = fanuc.write([table], HOME)
    assert (
        b"N3624 P1 R5000\n" in finer.files["gcomp_fanuc.nc"]
        and b"N3623 P1 R1\n" in finer.files["gcomp_fanuc.nc"]
    )
    raised = fanuc.write([table], replace(HOME, spacing=10.0))
    assert b"N3623 P1 R2\n" in raised.files["gcomp_fanuc.nc"]
    assert any("3623 = 2" in n for n in raised.notices)
    wide = fanuc.write([table], replace(HOME, spacing=10.0, extra={"largest": "127"}))
    assert (
        b"N3623 P1 R1\n" in wide.files["gcomp_fanuc.nc"]
        and b"R-12\n" in wide.files["gcomp_fanuc.nc"]
    )


def test_tables_by_direction_begin_at_3626_and_3627_is_added_at_the_reference():
    nodes = np.array([-40.0, -20.0, 0.0, 20.0])
    table = ErrorTable("X", "X", nodes, np.array([4, 2, 1, 0]) * UM, np.array([9, 7, 6, 3]) * UM)
    text = fanuc.write([table], replace(HOME, first={"X": 30})).files["gcomp_fanuc.nc"].decode()
    for line in (
        "N3620 P1 R30",
        "N3621 P1 R29",
        "N3622 P1 R31",
        "N3626 P1 R32",
        "N3627 P1 R-5",
        "N1851 P1 R0",
    ):
        assert f"\n{line}\n" in text
    numbers = [int(line.split("R")[1]) for line in text.splitlines() if line.startswith("N100")]
    assert numbers == [2, 1, 1, 2, 1, 3]  # falling deviation: more travel in +
    assert "N3605" not in text  # its other bits would be overwritten


def test_straightness_is_written_apart_unverified_and_read_back():
    nodes = np.arange(0.0, 101.0, 20.0)
    table = ErrorTable("Z", "X", nodes, nodes * 1e-4, nodes * 1e-4)
    export = fanuc.write([table], HOME)
    assert list(export.files) == ["gcomp_straightness.csv"]
    assert any(n.startswith("unverified: straightness") for n in export.notices)
    (back,) = fanuc.read(Source("s.csv", export.files["gcomp_straightness.csv"]), HOME)
    assert (back.moving, back.along) == ("Z", "X")
    np.testing.assert_allclose(back.at(nodes), nodes * 1e-4, atol=0.0005)


def test_numbers_that_do_not_fit_are_refused():
    nodes = np.arange(0.0, 2001.0, 10.0)
    long = ErrorTable("X", "X", nodes, nodes * 1e-6, nodes * 1e-6)
    with pytest.raises(TableError, match="201 points, and the control has 129"):
        fanuc.write([long], replace(HOME, spacing=10.0))
    with pytest.raises(TableError, match="needs the numbers 1001 to 1040"):
        fanuc.write([long], replace(HOME, spacing=50.0, first={"X": 1000}))
    with pytest.raises(TableError, match="range_X is 1 to 10"):
        fanuc.write([long], replace(HOME, spacing=50.0, first={"X": 0}, extra={"range_X": "1:10"}))
    jump = ErrorTable("X", "X", np.array([0.0, 10.0]), np.array([0.0, 5.0]), np.array([0.0, 5.0]))
    with pytest.raises(TableError, match="more than 7 x 100 detection units"):
        fanuc.write([jump], replace(HOME, spacing=10.0))


@pytest.mark.parametrize("form", ["csv", "records", "l50"])
def test_an_interval_of_seven_digits_is_written_whole(form):
    """123.4567 mm are 1234567 least increments of 0.1 um: 1.23457e+06 was written."""
    nodes = np.array([0.0, 123.4567, 246.9134])
    table = ErrorTable("X", "X", nodes, *(np.array([0.0, 0.005, 0.002]),) * 2)
    extra = {"increment_mm": "0.0001", "form": form}
    options = ExportOptions(reference={"X": 0.0}, spacing=123.4567, extra=extra)
    export = fanuc.write([table], options)
    assert b"1234567" in b"".join(export.files.values()) and export.remainder["EXX"] < 1e-9
