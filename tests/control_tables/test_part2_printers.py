"""Skew factors and lost motion of Marlin, Klipper and RepRapFirmware, by models from the firmwares'
sources."""

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
    klipper,
    marlin,
    reprapfirmware,
)
from postproc.recordings import Source

FIRMWARES = [(marlin, models.Marlin), (klipper, models.Klipper), (reprapfirmware, models.RepRap)]
NODES = np.array([-10.0, 0.0, 120.0, 250.0])
NANOMETRE = 1e-6  # mm
slopes = st.floats(-0.01, 0.01)
losts = st.floats(0.0, 0.3).map(lambda v: round(v, 6))


def leaning(moving: str, along: str, slope: float) -> ErrorTable:
    return ErrorTable(moving, along, NODES, slope * NODES, slope * NODES)


def machine(xy: float, xz: float, yz: float, lost=(0.0, 0.0, 0.0)) -> list[ErrorTable]:
    own = [
        ErrorTable(x, x, NODES, np.zeros(4), np.full(4, b))
        for x, b in zip("XYZ", lost, strict=True)
    ]
    return [leaning("Y", "X", xy), leaning("Z", "X", xz), leaning("Z", "Y", yz), *own]


def actual(slide, way, xy, xz, yz, lost=(0.0, 0.0, 0.0)):
    """Where the tool is: the slides lean, and stay behind in -."""
    x, y, z = slide
    behind = [b if w < 0 else 0.0 for b, w in zip(lost, way, strict=True)]
    return np.array([x + xy * y + xz * z, y + yz * z, z]) + behind


def text_of(form, tables, **options) -> str:
    (data,) = form.write(tables, ExportOptions(**options)).files.values()
    return data.decode()


@pytest.mark.parametrize("form, model", FIRMWARES)
@given(xy=slopes, xz=slopes, yz=slopes, place=st.tuples(*[st.floats(0, 250)] * 3))
def test_the_firmware_reaches_the_command(form, model, xy, xz, yz, place):
    """Also the product of two slopes, up to 25 um here, is taken out; with the sign turned the
    error is twice as large."""
    control = model(text_of(form, machine(xy, xz, yz)))
    way = (1, 1, 1)
    slide = control.sent(place, way)
    assert actual(slide, way, xy, xz, yz) == approx(np.array(place), abs=NANOMETRE)
    plain = actual(place, way, xy, xz, yz) - place
    turned = actual(2 * np.array(place) - slide, way, xy, xz, yz) - place
    assert np.abs(turned - 2 * plain).max() <= 0.03 * np.abs(plain).max() + 3 * 0.01 * 0.01 * 250


@pytest.mark.parametrize("form, model", [(marlin, models.Marlin), (reprapfirmware, models.RepRap)])
@given(lost=st.tuples(losts, losts, losts), way=st.tuples(*[st.sampled_from([1, -1])] * 3))
def test_lost_motion_is_taken_up(form, model, lost, way):
    control = model(text_of(form, machine(0.001, 0.0, 0.0, lost)))
    place = np.array([100.0, 50.0, 20.0])
    slide = control.sent(place, way)
    assert actual(slide, way, 0.001, 0.0, 0.0, lost) == approx(place, abs=0.001 * 0.3 + NANOMETRE)
    turned = actual(2 * place - slide, way, 0.001, 0.0, 0.0, lost) - place
    plain = actual(place, way, 0.001, 0.0, 0.0, lost) - place
    assert turned == approx(2 * plain, abs=0.001 * 0.6)


@pytest.mark.parametrize("form, model", FIRMWARES)
@given(xy=slopes, xz=slopes, yz=slopes)
def test_what_is_read_writes_the_same_file(form, model, xy, xz, yz):
    text = text_of(form, machine(xy, xz, yz))
    tables = form.read(Source("f", text.encode()), ExportOptions())
    slope = {t.name: t.forward[-1] / t.nodes[-1] for t in tables}
    assert [slope.get(n, 0.0) for n in ("EXY", "EXZ", "EYZ")] == approx([xy, xz, yz], abs=2e-9)
    if tables:
        written = model(text_of(form, tables))
        place = (200.0, 150.0, 100.0)
        assert written.sent(place, (1, 1, 1)) == approx(
            model(text).sent(place, (1, 1, 1)), abs=NANOMETRE
        )


@pytest.mark.parametrize("form, model", FIRMWARES)
@pytest.mark.parametrize(
    "along, moving, plane", [("Y", "X", (0, 1)), ("Z", "X", (0, 2)), ("Z", "Y", (1, 2))]
)
def test_an_axis_that_leans_the_other_way_round_makes_the_same_angle(
    form, model, along, moving, plane
):
    """X leaning towards +Y by 1 mrad closes the angle as Y leaning towards +X would: the part comes
    out square, turned."""
    export = form.write([leaning(moving, along, 1e-3)], ExportOptions())
    (data,) = export.files.values()
    control = model(data.decode())
    first, second = plane
    corner = []
    for place in np.eye(3)[list(plane)] * 100.0:
        slide = control.sent(place, (1, 1, 1))
        slide["XYZ".index(along)] += 1e-3 * slide["XYZ".index(moving)]
        corner.append(slide)
    assert corner[0] @ corner[1] / 1e4 == approx(0.0, abs=2e-6), "square to the second order"
    assert any("the part lies turned" in notice for notice in export.notices)


def test_the_example_of_klippers_manual():
    """docs/Skew_Correction.md: XY=140.4,142.8,99.8; by hand, side = sqrt(2*140.4^2 + 2*142.8^2 -
    4*99.8^2)/2 = 100.4587, cos = (140.4^2 - 142.8^2)/(4*99.8*100.4587) = -0.016948: the factor is
    -0.016951."""
    (table,) = klipper.read(Source("f", b"SET_SKEW XY=140.4,142.8,99.8\n"), ExportOptions())
    assert table.name == "EXY" and table.forward[-1] / table.nodes[-1] == approx(
        -0.016951, abs=1e-6
    )


def test_marlins_report_is_read():
    text = "G21\nM852 S0.001 J0 K-0.002 ; skew\nM425 F0.5 S3 X0.2 Y0 Z0\nM500\n"
    tables = {t.name: t for t in marlin.read(Source("f", text.encode()), ExportOptions())}
    assert sorted(tables) == ["EXX", "EXY", "EYZ"]
    assert tables["EXX"].reverse == approx([0.1, 0.1]), "F is a share of the lost motion"
    assert tables["EYZ"].at(np.array([500.0])) == approx(-1.0)


@pytest.mark.parametrize("form, model", FIRMWARES)
def test_what_no_factor_holds_is_reported(form, model):
    bent = ErrorTable(
        "Y",
        "X",
        np.array([0.0, 100.0, 200.0]),
        np.array([0.0, 0.03, 0.0]),
        np.array([0.0, 0.03, 0.0]),
    )
    screw = ErrorTable(
        "X", "X", np.array([0.0, 200.0]), np.array([0.0, 0.05]), np.array([0.02, 0.07])
    )
    export = form.write([bent, screw], ExportOptions())
    lost = 0.0 if form is klipper else 0.02
    assert export.remainder["EXX"] == approx(0.07 - lost) and export.remainder["EXY"] == approx(
        0.03
    )
    assert any("it leaves: EXX" in notice for notice in export.notices)
    if form is klipper:
        assert any("no lost motion" in notice for notice in export.notices)
    (data,) = export.files.values()
    slide = model(data.decode()).sent((150.0, 100.0, 0.0), (-1, 1, 1))
    assert abs(slide[0] + np.interp(slide[0], [0, 200], [0.02, 0.07]) + 0.03 - 150.0) <= sum(
        export.remainder.values()
    )


def test_slips_are_refused():
    with pytest.raises(TableError, match="mm per mm"):
        marlin.write([leaning("Y", "X", 0.2)], ExportOptions())
    ahead = ErrorTable("X", "X", NODES, np.full(4, 0.01), np.zeros(4))
    export = reprapfirmware.write([ahead], ExportOptions())
    assert b"M425" not in next(iter(export.files.values()))
    assert any("the opposite of lost motion" in notice for notice in export.notices)
    assert export.remainder["EXX"] == approx(0.01)


def test_lost_motion_of_reprapfirmware_is_marked():
    export = reprapfirmware.write(machine(0.001, 0, 0, (0.02, 0, 0)), ExportOptions())
    assert (
        export.notices[0].startswith("unverified: ")
        and b"; unverified: " in export.files["gcomp.g"]
    )
