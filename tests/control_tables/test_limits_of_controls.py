"""What each control can not hold is refused or said: entries, spacings, directions, templates, zero
at the reference."""

from __future__ import annotations

import re
from dataclasses import replace

import models
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from postproc.control_tables import (
    ErrorTable,
    ExportOptions,
    TableError,
    fagor,
    haas,
    heidenhain,
    linuxcnc,
    siemens_cec,
    siemens_enc_comp,
)
from postproc.control_tables._common import checked
from postproc.control_tables._thinning import thinned
from postproc.errors import UsageError
from postproc.recordings import Source
from postproc.units import UM

HOME = ExportOptions(reference={x: 0.0 for x in "XYZ"})


def table(
    values, step: float = 10.0, moving: str = "X", along: str = "X", reverse=None
) -> ErrorTable:
    up = np.array(values, float) * UM
    return ErrorTable(
        moving,
        along,
        step * np.arange(len(up)),
        up,
        up if reverse is None else np.array(reverse, float) * UM,
    )


# -- LinuxCNC --------------------------------------------------------------------------------------


def test_linuxcnc_gets_three_bare_numbers_a_line_of_actual_positions_or_of_trims():
    one = table([0.0, 3.0], reverse=[-1.0, 2.0])
    assert (
        linuxcnc.write([one], HOME).files["X.comp"]
        == b"0.000000 0.000000 -0.001000\n10.000000 10.003000 10.002000\n"
    )
    trims = linuxcnc.write([one], replace(HOME, extra={"type": "1"})).files["X.comp"]
    assert trims == b"0.000000 0.000000 0.001000\n10.000000 -0.003000 -0.002000\n"
    inch = linuxcnc.write([one], replace(HOME, unit="inch")).files["X.comp"].decode()
    assert [float(w) for w in inch.split()[3:]] == approx(
        [10 / 25.4, 10.003 / 25.4, 10.002 / 25.4], abs=1e-8
    )


def test_linuxcnc_holds_256_entries_and_the_rest_is_thinned_out_within_a_bound_or_refused():
    x = np.linspace(0, 1, 600)
    smooth = ErrorTable("X", "X", 1000 * x, 0.02 * np.sin(3 * x), 0.02 * np.sin(3 * x))
    export = linuxcnc.write([smooth], HOME)
    assert export.files["X.comp"].count(b"\n") <= 256
    (notice,) = (n for n in export.notices if "thinned out" in n)
    said = float(re.search(r"loses ([\d.]+) um", notice)[1]) * UM
    got = models.linuxcnc(export.files, "0")("X", "X", smooth.nodes, 1.0)
    assert np.abs(got + smooth.forward).max() <= said + 1e-6 and said < 1 * UM
    rough = np.random.default_rng(3).normal(0, 0.005, 600)
    with pytest.raises(
        TableError, match="has 600 entries, LinuxCNC holds 256, and thinning them out loses"
    ):
        linuxcnc.write([ErrorTable("X", "X", 1000 * x, rough, rough)], HOME)


@settings(max_examples=100, deadline=None)
@given(values=st.lists(st.floats(-0.05, 0.05), min_size=3, max_size=80), most=st.integers(2, 40))
def test_thinning_keeps_the_ends_holds_its_bound_and_never_has_more_than_asked(values, most):
    full = ErrorTable(
        "X", "X", np.arange(len(values), dtype=float), np.array(values), np.array(values[::-1])
    )
    thin, lost = thinned(full, most)
    assert len(thin.nodes) <= most and {thin.nodes[0], thin.nodes[-1]} == {0.0, len(values) - 1.0}
    there = np.linspace(-1, len(values), 511)
    off = max(np.abs(full.at(there, w) - thin.at(there, w)).max() for w in (1.0, -1.0))
    assert off <= lost + 1e-12


def test_backlash_is_said_to_be_ignored():
    assert any("ignores BACKLASH" in n for n in linuxcnc.write([table([1.0, 2.0])], HOME).notices)


# -- Siemens ---------------------------------------------------------------------------------------


def test_enc_comp_is_written_as_the_manual_prints_it_with_the_deviation_positive():
    """K3 page 242: a positive value moves the axis in -, so an axis that goes 3 um too far gets
    +0.003."""
    text = siemens_enc_comp.write([table([0.0, 3.0, 5.0])], HOME).files["AX_EEC.INI"].decode()
    assert text.splitlines() == [
        "%_N_AX_EEC_INI",
        "CHANDATA(1)",
        "$AA_ENC_COMP[0,0,X1]=0.00000",
        "$AA_ENC_COMP[0,1,X1]=0.00300",
        "$AA_ENC_COMP[0,2,X1]=0.00500",
        "$AA_ENC_COMP_STEP[0,X1]=10",
        "$AA_ENC_COMP_MIN[0,X1]=0",
        "$AA_ENC_COMP_MAX[0,X1]=20",
        "$AA_ENC_COMP_IS_MODULO[0,X1]=0",
        "M17",
    ]


def test_enc_comp_states_the_backlash_that_leaves_least():
    """Reversal 2 to 6 um: MD32450 = 4 um leaves 1 um each way, none leaves 3."""
    export = siemens_enc_comp.write([table([0, 0, 0], reverse=[2, 4, 6])], HOME)
    (notice,) = (n for n in export.notices if "MD32450" in n)
    assert "= 0.00400 mm: without it up to 3.00 um stay, with it 1.00 um" in notice
    assert export.remainder["EXX"] == approx(1 * UM, abs=1e-6)


def test_points_that_do_not_suffice_are_refused_with_the_spacing_that_does():
    with pytest.raises(TableError, match="401 points, and the control has 200"):
        siemens_enc_comp.write([table(np.zeros(401))], replace(HOME, spacing=10.0))
    export = siemens_enc_comp.write([table(np.linspace(0, 40, 401))], HOME)
    assert int(re.search(r"at least (\d+)", " ".join(export.notices))[1]) <= 200
    with pytest.raises(UsageError, match="not a multiple"):
        siemens_enc_comp.write([table([0, 1])], replace(HOME, spacing=0.00003))


def test_cec_writes_a_pair_by_direction_and_counts_its_tables():
    both = [table([0, 4], reverse=[2, 6]), table([0, 9], along="Z")]
    text = (
        siemens_cec.write(both, replace(HOME, extra={"cec_sign": "-"})).files["NC_CEC.INI"].decode()
    )
    assert re.findall(r"DIRECTION\[(\d)\]=(-?\d)", text) == [("0", "1"), ("1", "-1"), ("2", "0")]
    assert "$AN_CEC_INPUT_AXIS[2]=(AX1)\n$AN_CEC_OUTPUT_AXIS[2]=(AX3)" in text
    assert "; unverified" in text and text.endswith("M17\n")
    with pytest.raises(TableError, match="3 tables are needed, and the control has 2"):
        siemens_cec.write(both, replace(HOME, extra={"cec_sign": "-", "tables": "2"}))


def test_the_dial_gauge_test_tells_the_right_sign_from_the_wrong_one():
    one = table([0.0, 5.0, 20.0])
    for said, other in ("-+", "+-"):
        told = siemens_cec.write([one], replace(HOME, extra={"cec_sign": said})).notices
        assert f"(then --set cec_sign={other})" in " ".join(told)
    with pytest.raises(UsageError, match="cec_sign is not said"):
        siemens_cec.write([one], HOME)
    export = siemens_cec.write([one], replace(HOME, extra={"cec_sign": "-"}))
    (notice,) = (n for n in export.notices if n.startswith("dial-gauge"))
    bare, right, wrong = (float(v) for v in re.findall(r"([+-][\d.]+) um", notice))
    for turn, said in ((1.0, right), (-1.0, wrong)):
        added = models.cec(export.files, turn=turn)("X", "X", np.array([0.0, 20.0]), 1.0)
        shown = bare + 0.1 * (added[1] - added[0]) / UM
        assert shown == approx(said, abs=0.06)


# -- Heidenhain ------------------------------------------------------------------------------------

TEMPLATE = (
    "BEGIN ACHSE.COM MM\r\nNR      AXISPOS    X          Y          Z         "
    " BACKLASH\r\n[END]\r\n"
)


def test_a_template_keeps_its_frame_its_columns_and_its_line_ends():
    one, cross = table([1.0, 2.0], reverse=[3.0, 4.0]), table([5.0, 6.0], along="Z")
    export = heidenhain.write([one, cross], replace(HOME, extra={"template": TEMPLATE}))
    assert export.files["AXIS_X.COM"].decode().split("\r\n") == [
        "BEGIN ACHSE.COM MM",
        "NR      AXISPOS    X          Y          Z          BACKLASH",
        "0       0.00000    0.00100               0.00500    0.00300",
        "1       10.00000   0.00200               0.00600    0.00400",
        "[END]",
        "",
    ]
    assert not any("frame" in n for n in export.notices if n.startswith("unverified"))
    back = heidenhain.read(Source("AXIS_X.COM", export.files["AXIS_X.COM"]), HOME)
    assert [t.name for t in back] == ["EXX", "EZX"]
    np.testing.assert_allclose(back[0].reverse, one.reverse, atol=1e-9)


def test_without_a_template_the_frame_is_called_unverified():
    export = heidenhain.write([table([1.0, 2.0])], HOME)
    assert any("frame" in n for n in export.notices if n.startswith("unverified"))
    assert set(export.files) == {"AXIS_X.COM", "config.CMA"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (TEMPLATE.replace("BACKLASH", ""), "no column BACKLASH"),
        (TEMPLATE.replace("Z  ", "  W"), "no column Z"),
        (TEMPLATE.replace("[END]\r\n", ""), r"no line \[END\]"),
        (TEMPLATE.replace("AXISPOS    X", "AXISPOS X"), "does not fit the column AXISPOS"),
        (TEMPLATE.replace("MM", "INCH"), "is in INCH, and the unit is mm"),
        ("nothing", "begins with NR"),
    ],
)
def test_a_template_that_can_not_hold_the_table_is_refused(text, words):
    group = [table([1.0, 2.0], reverse=[3.0, 4.0]), table([5.0, 6.0], along="Z")]
    with pytest.raises((TableError, UsageError), match=words):
        heidenhain.write(group, replace(HOME, extra={"template": text}))


def test_the_legacy_form_has_a_spacing_of_a_power_of_two_and_gentle_neighbours():
    """TNC 407 page 153: 500 mm, 7 mm wanted, 2^16 x 0.1 um = 6.5536 mm, 77 points."""
    long = ErrorTable(
        "Y", "Y", np.array([-90.0, 410.0]), np.array([0.0, 0.04]), np.array([0.0, 0.04])
    )
    export = heidenhain.write([long], replace(HOME, spacing=6.5536, extra={"form": "legacy"}))
    rows = export.files["AXIS_Y.COM"].decode().splitlines()[2:-1]
    positions = [float(row.split()[1]) for row in rows]
    # 77 intervals
    assert positions[:4] == [-90.0, -83.4464, -76.8928, -70.3392] and len(rows) == 78
    assert any("2^16 x 0.1 um" in n for n in export.notices)
    with pytest.raises(
        UsageError, match=r"7 mm is not a power of two x 0.1 um\n +--spacing 6.5536 or 13.1072"
    ):
        heidenhain.write([long], replace(HOME, spacing=7.0, extra={"form": "legacy"}))
    steep = table([0.0, 200.0])  # 20 um/mm, and spacing / 64 is 15.6 um/mm
    with pytest.raises(TableError, match="is the limit"):
        heidenhain.write([steep], replace(HOME, extra={"form": "legacy"}))


# -- Haas, Fagor -----------------------------------------------------------------------------------


def test_haas_goes_down_from_machine_zero_every_half_inch():
    one = ErrorTable(
        "X", "X", np.array([-25.4, 0.0]), np.array([0.00508, 0.0]), np.array([0.00508, 0.0])
    )
    rows = haas.write([one], HOME).files["gcomp_haas.csv"].decode().splitlines()[2:]
    assert rows == ["X,0,0.0,0.0000", "X,1,-0.5,-0.0001", "X,2,-1.0,-0.0002"]
    with pytest.raises(TableError, match="entries only go down from there"):
        haas.write([table([0, 5])], HOME)
    with pytest.raises(TableError, match="more than 127 encoder steps"):
        haas.write([one], replace(HOME, extra={"encoder_step_mm": "0.00001"}))
    with pytest.raises(TableError, match="there are 256"):
        haas.write([ErrorTable("X", "X", np.array([-4000.0, 0.0]), np.zeros(2), np.zeros(2))], HOME)


def test_fagor_reads_all_zero_in_minus_as_like_plus_so_one_value_is_not_zero():
    one = table([0.0, 5.0, 7.0], reverse=[0.0, 0.0, 0.0])
    export = fagor.write([one], HOME)
    added = models.fagor(export.files["gcomp_fagor.csv"])("X", "X", one.nodes, -1.0)
    assert np.abs(added + one.reverse).max() <= 0.0001 + 1e-12
    assert any("all zero" in n for n in export.notices)


def test_nothing_to_write_twice_the_same_and_values_that_are_none_are_refused():
    for group, words in (
        ([], "nothing to write"),
        ([table([1, 2]), table([1, 2])], "given twice"),
        ([table([1, np.nan])], "not finite"),
        ([table([1, 2], along="Z")], "none among EZX"),
    ):
        with pytest.raises(TableError, match=words):
            linuxcnc.write(group, HOME)


@pytest.mark.parametrize("step", [1.0, 0.05, 1e-6])
def test_nodes_ascend_by_any_step(step):
    made = table([0.0, 1.0, 2.0], step=step)
    assert checked([made]) == [made]
    for nodes in (made.nodes * 0, -made.nodes, made.nodes[:0]):
        with pytest.raises(TableError, match="the nodes of EXX do not ascend"):
            checked([replace(made, nodes=nodes)])
