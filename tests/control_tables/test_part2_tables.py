"""Tables along one axis: Beckhoff's list, Mach4, Centroid, NcStudio. The control with the table
loaded reaches the command."""

from __future__ import annotations

import models_part2 as models
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from postproc.control_tables import (
    ErrorTable,
    ExportOptions,
    TableError,
    beckhoff_lsec,
    centroid,
    load,
    mach4,
    nc_studio,
)
from postproc.errors import UsageError
from postproc.recordings import Source

COUNTS = 1574.803  # per mm: 40,000 per inch
# mm: how much a deviation of 40 um changes over itself, at the slopes used here (2.5 um/mm)
SELF = 1e-4


@st.composite
def error_tables(draw, even: bool = False, axis: str = "Y", home: bool = False):
    """A random table: up to 40 um and 2.5 um/mm; even: 10 mm apart; home: from -250 to 0."""
    n = draw(st.integers(3, 12))
    gaps = (
        [10.0] * (n - 1)
        if even
        else draw(
            st.lists(st.integers(160, 900).map(lambda v: v / 10), min_size=n - 1, max_size=n - 1)
        )
    )
    start = -10.0 * (n - 1) if home else draw(st.integers(-3000, 3000)) / 10
    nodes = start + np.concatenate([[0.0], np.cumsum(gaps)])
    limit = 125 if even else 200  # 0.1 um
    values = st.lists(st.integers(-limit, limit).map(lambda v: v * 1e-4), min_size=n, max_size=n)
    forward, reverse = (np.array(draw(values)) for _ in range(2))
    return ErrorTable(axis, axis, nodes, forward, forward if draw(st.booleans()) else reverse)


def places(table: ErrorTable) -> np.ndarray:
    """Nodes, places between, and places beyond the ends."""
    return np.concatenate([table.nodes, np.linspace(table.nodes[0] - 5, table.nodes[-1] + 5, 101)])


def reaches(table: ErrorTable, sent, bound: float) -> None:
    """Sent there, the tool stands at the command within the bound; with the sign turned it is off
    twice as far."""
    p = places(table)
    for way in (1.0, -1.0):
        own = table.at(p, way)
        slide = sent(p, way)
        assert np.abs(slide + table.at(slide, way) - p).max() <= bound
        turned = 2 * p - slide
        assert (
            np.abs(turned + table.at(turned, way) - p - 2 * own).max()
            <= bound + np.abs(slide - p + own).max()
        )


# -- Beckhoff --------------------------------------------------------------------------------------


@given(error_tables())
def test_beckhoff_reaches_the_command(table):
    export = beckhoff_lsec.write([table], ExportOptions())
    reaches(
        table, models.lsec(export.files["achskw_Y.lis"].decode()), export.remainder["EYY"] + SELF
    )
    assert export.remainder["EYY"] <= 1.01e-4 / 2 + 3e-7, "half a tenth of a micrometre"


@given(error_tables())
def test_beckhoff_is_read_as_written(table):
    data = beckhoff_lsec.write([table], ExportOptions()).files["achskw_Y.lis"]
    (found,) = beckhoff_lsec.read(Source("f", data), ExportOptions())
    assert (found.moving, found.along) == ("Y", "Y")
    assert found.nodes == approx(table.nodes, abs=1e-9)
    assert found.forward == approx(table.forward, abs=1e-9) and found.reverse == approx(
        table.reverse, abs=1e-9
    )


@given(error_tables(even=True))
def test_beckhoff_with_even_points_needs_no_setpoints(table):
    export = beckhoff_lsec.write([table], ExportOptions(spacing=5.0))
    text = export.files["achskw_Y.lis"].decode()
    assert "].setpoint" not in text and "kw.ssfk.interval 50000" in text
    reaches(table, models.lsec(text), export.remainder["EYY"] + SELF)
    (found,) = beckhoff_lsec.read(Source("f", text.encode()), ExportOptions())
    assert found.at(table.nodes, 1.0) == approx(table.forward, abs=6e-5)


def test_beckhoff_computes_the_value_as_its_manual_does():
    """TF5200, "Example - Non-equidistant bilateral SSFK": -102 and 80 tenths where 19856.5 and
    19874.7 um are reached for 19866.7 um."""
    nodes, actual = np.array([19.8, 19.8667]), np.array([[19.8, 19.8565], [19.8, 19.8747]])
    table = ErrorTable("Y", "Y", nodes, *(actual - nodes))
    text = beckhoff_lsec.write([table], ExportOptions()).files["achskw_Y.lis"].decode()
    assert "kw.ssfk.table[1].pos -102\n" in text and "kw.ssfk.table[1].neg 80\n" in text


def test_beckhoff_reads_the_layout_of_the_manual():
    text = """kopf.achs_nr                        2
kopf.log_achs_name                    Y AXIS   /* comment */
# another
kw.ssfk.interval                    0
kw.ssfk.kw_startpos                 -200000
kw.ssfk.kw_nr_max                   2
kw.ssfk.unit                        1
kw.ssfk.bilateral                   0
kw.ssfk.table[ 0].setpoint           -200000
kw.ssfk.table[ 1].setpoint           -199306
kw.ssfk.table[ 0].pos                0
kw.ssfk.table[ 1].pos                24
End
"""
    (found,) = beckhoff_lsec.read(Source("f", text.encode()), ExportOptions())
    assert (
        found.name == "EYY"
        and found.nodes == approx([-20.0, -19.9306])
        and found.reverse == approx([0, 0.0024])
    )


def test_beckhoff_refuses_what_it_can_not_hold():
    many = ErrorTable("X", "X", np.arange(1501.0), np.zeros(1501), np.zeros(1501))
    with pytest.raises(TableError, match="1501 points, the list holds 1500"):
        beckhoff_lsec.write([many], ExportOptions())
    near = ErrorTable("X", "X", np.array([0.0, 0.00001]), np.zeros(2), np.zeros(2))
    with pytest.raises(TableError, match="closer than"):
        beckhoff_lsec.write([near], ExportOptions())
    with pytest.raises(TableError, match="along the moving axis"):
        beckhoff_lsec.write(
            [ErrorTable("X", "Z", np.arange(3.0), np.zeros(3), np.zeros(3))], ExportOptions()
        )


# -- NcStudio --------------------------------------------------------------------------------------


@given(error_tables(), error_tables(axis="X"))
def test_nc_studio_reaches_the_command(one, two):
    export = nc_studio.write([one, two], ExportOptions(reference={"X": 10.0, "Y": -20.0}))
    sent = models.nc_studio(export.files["axeserr.dat"].decode())
    for table, home in ((one, -20.0), (two, 10.0)):
        bound = export.remainder[table.name] + SELF
        reaches(table, lambda p, way, t=table, h=home: sent(t.moving, p - h, way) + h, bound)
    found = {
        t.name: t
        for t in nc_studio.read(
            Source("f", export.files["axeserr.dat"]),
            ExportOptions(reference={"X": 10.0, "Y": -20.0}),
        )
    }
    assert found["EYY"].nodes == approx(one.nodes) and found["EYY"].reverse == approx(
        one.reverse, abs=1e-9
    )
    assert found["EXX"].forward == approx(two.forward, abs=1e-9)


def test_nc_studio_reads_the_example_of_its_manual():
    """NK200, table 3-2; and an axis with backlash only, which is what a tool that stays behind in -
    looks like."""
    text = (
        ";unit=mm\r\n[X]\r\n-570.025, 0.027, 0.083\r\n-450.020, 0.025,"
        " 0.077\r\n[y]\r\n0.000,\t0.000, 0.030\r\n1000.00, 0.000, 0.030\r\n"
    )
    x, y = nc_studio.read(Source("axeserr.dat", text.encode()), ExportOptions())
    assert x.forward == approx([0.027, 0.025]) and x.reverse == approx([0.083, 0.077])
    behind = ErrorTable("Y", "Y", np.array([0.0, 1000.0]), np.zeros(2), np.full(2, 0.03))
    assert (
        y.reverse == approx(behind.reverse)
        and "1000.0000, 0.0000, 0.0300"
        in nc_studio.write([behind], ExportOptions()).files["axeserr.dat"].decode()
    )


# -- sheets ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("form, turn, other", [(mach4, 1.0, "-"), (centroid, -1.0, "+")])
@given(table=error_tables(even=True), unit=st.sampled_from(["mm", "inch"]))
def test_a_sheet_that_is_typed_in_reaches_the_command(form, turn, other, table, unit):
    """Mach4 subtracts the error, Centroid adds the correction; with the sign turned by the option
    it is twice the error."""
    export = form.write([table], ExportOptions(unit=unit))
    (data,) = export.files.values()
    nodes, up, down = models.typed(data.decode())
    reaches(
        table,
        lambda p, way: p - turn * np.interp(p, nodes, up if way > 0 else down),
        export.remainder["EYY"] + SELF,
    )
    assert (
        export.remainder["EYY"] < 1e-5
        and export.notices[0].startswith("unverified: ")
        and b"# unverified: " in data
    )
    (found,) = form.read(Source("f", data), ExportOptions())
    assert found.nodes == approx(table.nodes, abs=1e-5) and found.reverse == approx(
        table.reverse, abs=1e-5
    )
    turned = form.write([table], ExportOptions(unit=unit, extra={"sign": other}))
    assert models.typed(next(iter(turned.files.values())).decode())[1] == approx(-up, abs=1e-9)


@given(error_tables(even=True, home=True))
def test_centroid_version_one_reaches_the_command(table):
    """One value for both directions, in counts: half the reversal stays, and half a count (0.32
    um); what is off at home, where the table must be zero, is told and stays as well."""
    options = ExportOptions(
        extra={"version": "1", "counts_per_mm": str(COUNTS), "axis": "Y"}, reference={"Y": 0.0}
    )
    export = centroid.write([table], options)
    sent = models.centroid_one(export.files["cnc7y.tab"].decode(), COUNTS)
    at_home = float(table.at(np.zeros(1))[0])
    half = np.abs(table.forward - table.reverse).max() / 2
    p = places(table)
    for way in (1.0, -1.0):
        slide = sent(p)
        assert (
            np.abs(slide + table.at(slide, way) - p - at_home).max() <= half + 0.5 / COUNTS + 2e-4
        )
    (found,) = centroid.read(Source("f", export.files["cnc7y.tab"]), options)
    mean = (table.forward + table.reverse) / 2 - at_home
    assert found.nodes == approx(table.nodes, abs=1e-3) and found.forward == approx(
        mean, abs=0.51 / COUNTS
    )


def test_centroid_version_one_is_the_example_that_is_published():
    """cncsnw, "Laser Compensation": header 24 -1448819, and corrections 0 -32 -38 ...; 920 mm, 40
    mm apart, to minus."""
    values = [
        0,
        -32,
        -38,
        -47,
        -54,
        -57,
        -63,
        -69,
        -76,
        -82,
        -88,
        -98,
        -101,
        -110,
        -113,
        -120,
        -123,
        -129,
        -132,
        -135,
        -139,
        -142,
        -145,
        -148,
    ]
    text = "24 -1448819\n" + "\n".join(map(str, values))
    options = ExportOptions(
        extra={"version": "1", "counts_per_mm": str(40000 / 25.4), "axis": "x"},
        reference={"X": 0.0},
    )
    (found,) = centroid.read(Source("cnc7x.tab", text.encode()), options)
    assert np.diff(found.nodes) == approx(np.full(23, 40.0), abs=1e-4) and found.nodes[0] == approx(
        -920.0, abs=1e-4
    )
    assert found.forward[0] == approx(148 / 40000 * 25.4), (
        "the control adds -0.094 mm: the tool stood that much too far in +"
    )
    written = centroid.write([found], options).files["cnc7x.tab"].decode().split()
    assert (
        written[0] == "24"
        and [int(v) for v in written[2:]] == values
        and abs(int(written[1]) + 1448819) <= 1
    )


def test_what_a_table_of_version_one_needs_must_be_told():
    table = ErrorTable("X", "X", np.array([-10.0, 0.0, 10.0]), np.zeros(3), np.zeros(3))
    with pytest.raises(UsageError, match="encoder counts"):
        centroid.write([table], ExportOptions(extra={"version": "1"}))
    told = {"version": "1", "counts_per_mm": "1000"}
    with pytest.raises(TableError, match="both sides of home"):
        centroid.write([table], ExportOptions(extra=told))
    with pytest.raises(UsageError, match="which axis"):
        centroid.read(Source("cnc7x.tab", b"2 10\n0\n0\n"), ExportOptions(extra=told))


@pytest.mark.parametrize(
    "name",
    [
        "beckhoff-lsec",
        "centroid",
        "etalon",
        "isg-csv",
        "klipper",
        "mach4",
        "marlin",
        "nc-studio",
        "reprapfirmware",
    ],
)
def test_every_control_says_what_it_is_and_how_it_signs(name):
    module = load(name)
    assert module.TITLE and module.SIGN and isinstance(module.VERIFIED, bool)
    if not module.VERIFIED:
        assert "unverified" in module.__doc__.lower() and "unverified" in module.SIGN


@pytest.mark.parametrize("form", [beckhoff_lsec, nc_studio, mach4, centroid])
def test_one_map_for_both_directions_says_what_it_leaves(form):
    table = ErrorTable("X", "X", np.array([0.0, 100.0]), np.zeros(2), np.full(2, 0.03))
    export = form.write([table], ExportOptions(two_way=False))
    assert export.remainder["EXX"] == approx(0.015, abs=1e-4)
    assert any("backlash" in notice for notice in export.notices)
