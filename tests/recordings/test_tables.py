"""Sheets, laser tables, the long table and LinuxCNC's file: the same readings come out of every
layout."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from postproc.errors import UsageError
from postproc.recordings import ReadingOptions, RecordingError, read_all
from tests.recordings import samples
from tests.recordings.samples import as_table, source, taken

TABLE = samples.readings(6)
MM = 1e-3


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (samples.interleaved(TABLE), {}),
        (samples.interleaved(TABLE, sign="\t"), {}),
        (samples.interleaved(TABLE, sign=",", comma=False), {}),
        (samples.interleaved(TABLE, unit="um"), {"unit": "um"}),
        (samples.interleaved(TABLE), {"layout": "interleaved"}),
        (samples.blocks(TABLE), {"axis": "Z", "unit": "um"}),
        (samples.blocks(TABLE), {"axis": "Z", "unit": "um", "layout": "blocks"}),
        (samples.blocks(TABLE, headed=False), {"axis": "Z", "unit": "um", "layout": "blocks"}),
        (samples.long(TABLE), {"axis": "Z"}),
        (samples.long(TABLE), {"axis": "Z", "layout": "long"}),
        (samples.laser_table(TABLE), {}),
        (samples.laser_table(TABLE), {"component": "EZZ", "unit": "um"}),
        (samples.canonical({"EZZ": (TABLE, "um")}), {}),
    ],
    ids=lambda v: "" if isinstance(v, dict) else v[:12].split("\n")[0],
)
def test_the_same_readings_come_out_of_every_layout(text, options):
    recording = taken("sheet.csv", text, **options)
    targets, table = as_table(recording)
    assert_allclose(targets, samples.TARGETS)
    assert_allclose(table, TABLE, atol=1e-9)
    assert recording.quantity == "displacement" and recording.sensitive == {"Z": 1.0}
    assert_allclose(recording.approach("Z"), np.where(recording.columns["run"] % 2 == 1, 1, -1))
    assert not recording.faults


def test_units_of_headings_are_heeded():
    for unit, factor in (("mm", 1000.0), ("nm", 0.001), ("micron", 1.0), ("inch", 25400.0)):
        assert_allclose(
            as_table(taken("s.csv", samples.interleaved(TABLE, unit=unit)))[1],
            TABLE * factor,
            rtol=1e-9,
        )
    with pytest.raises(UsageError, match="readings are in um, and --unit says mm"):
        taken("s.csv", samples.interleaved(TABLE), unit="mm")


def test_a_sheet_from_a_spreadsheet_in_the_windows_code_page():
    recording = taken("s.csv", samples.interleaved(TABLE).encode("cp1252"))
    assert_allclose(as_table(recording)[1], TABLE, atol=1e-9)
    assert any("cp1252" in text for text in recording.notices)
    assert_allclose(
        as_table(taken("s.csv", samples.interleaved(TABLE).encode("utf-16")))[1], TABLE, atol=1e-9
    )


def test_headings_over_pairs_of_columns_and_arrows():
    text = "Position (mm),Run 1,,Run 2,\n,↑,↓,↑,↓\n0,1.5,2.5,1.6,2.6\n10,3,4,3.1,4.1\n"
    recording = taken("s.csv", text, axis="X", unit="um")
    assert_allclose(as_table(recording, "X")[1], [[1.5, 3], [2.5, 4], [1.6, 3.1], [2.6, 4.1]])
    assert_allclose(recording.approach("X")[recording.columns["run"] == 2], -1)


def test_forward_follows_the_first_run_and_up_does_not():
    text = "Target (mm);Forward 1 (um);Reverse 1 (um)\n0;1;2\n10;3;4\n"
    turned = taken("s.csv", text, axis="X", first=-1)
    assert_allclose(turned.approach("X")[turned.columns["run"] == 1], -1)
    assert any(
        "first direction is not in the file" in t for t in taken("s.csv", text, axis="X").notices
    )
    fixed = taken(
        "s.csv", text.replace("Forward", "Up").replace("Reverse", "Down"), axis="X", first=-1
    )
    assert_allclose(fixed.approach("X")[fixed.columns["run"] == 1], 1)
    assert any("--first and --bidirectional are not used" in t for t in fixed.notices)


def test_a_layout_that_is_open_is_asked_for():
    text = samples.blocks(TABLE, headed=False)
    with pytest.raises(RecordingError, match="do not say the direction of the 6 columns") as caught:
        taken("s.csv", text, "iso-spreadsheet", axis="Z", unit="um")
    assert "--layout interleaved" in caught.value.advice and "blocks" in caught.value.advice
    one_way = taken("s.csv", text, "iso-spreadsheet", axis="Z", unit="um", bidirectional=False)
    assert np.all(one_way.approach("Z") == 1) and one_way.columns["run"].max() == 6
    with pytest.raises(RecordingError, match="--layout blocks does not agree"):
        taken("s.csv", samples.interleaved(TABLE), layout="blocks")


def test_an_empty_cell_is_a_missing_reading():
    text = samples.interleaved(TABLE).split("\n")
    cells = text[6].split(";")
    cells[3] = ""
    text[6] = ";".join(cells)
    recording = taken("s.csv", "\n".join(text))
    assert len(recording) == TABLE.size - 1
    assert [(f.line, f.column, f.message) for f in recording.faults] == [
        (7, "Up 2 (µm)", "the reading is missing")
    ]


def test_thousands_are_distinguished_from_decimal_commas():
    """1,234 alone may be either: it is read with a decimal comma, and said; with a point beside it
    the file is refused."""
    recording = taken(
        "s.csv", "Target (mm);Up 1 (um);Down 1 (um)\n0;1,234;2,345\n10;3,456;4,567\n", axis="X"
    )
    assert_allclose(as_table(recording, "X")[1], [[1.234, 3.456], [2.345, 4.567]])
    assert any("1,234 is read as 1.234" in t for t in recording.notices)
    with pytest.raises(RecordingError, match="decimal commas and points are mixed"):
        taken(
            "s.csv",
            "Target (mm);Up 1 (um);Down 1 (um)\n0.5;1,234;2,345\n",
            "iso-spreadsheet",
            axis="X",
        )


def test_positions_in_inch():
    text = "Target (inch);Up 1 (um);Down 1 (um)\n0;1;2\n10;3;4\n"
    assert_allclose(as_table(taken("s.csv", text, axis="X"), "X")[0], [0.0, 254.0])


def test_the_air_and_the_averages_of_a_laser_table():
    recording = taken("z.txt", samples.laser_table(TABLE))
    assert_allclose(recording.columns["T_air_C"], 20.12)
    assert_allclose(recording.columns["T_material_1_C"], 20.0)  # 68 F by hand
    assert any("Expansion Coefficient is 11.70" in t for t in recording.notices)
    wrong = TABLE.mean(axis=0)
    wrong[4] += 2.0
    notices = taken("z.txt", samples.laser_table(TABLE, average=wrong)).notices
    assert sum("is a number mistyped?" in t for t in notices) == 1
    assert any(t.startswith("line 12: the average stands as") for t in notices)


def test_a_laser_table_needs_no_averages():
    text = "Comments: [Z Axis]\nTarget Position\tRUN 1 (um)\tRUN 2 (um)\n0\t1\t2\n10\t3\t4\n"
    assert_allclose(as_table(taken("z.txt", text))[1], [[1, 3], [2, 4]])


def test_a_laser_table_of_averages_alone_has_no_readings():
    text = "Comments: [Z Axis]\nTarget Position\tRUN 1 (um)\tRUN 2 (um)\tAverage\n"
    with pytest.raises(RecordingError, match="there are no readings"):
        taken("z.txt", text + "0\t\t\t1.0\n10\t\t\t2.0\n")


def test_a_rotary_axis_in_arcsec():
    text = samples.laser_table(TABLE, unit="arcsec").replace("Z Axis", "Theta")
    recording = taken("c.txt", text, axis="C")
    assert (
        recording.axes == ("C",)
        and recording.head["component"] == "ECC"
        and recording.sensitive == {"Z": 1.0}
    )
    assert_allclose(as_table(recording, "C")[1], TABLE * np.pi / 0.648, rtol=1e-9)
    with pytest.raises(RecordingError, match="about which axis"):
        taken("z.txt", samples.laser_table(TABLE, unit="arcsec"))
    assert taken("z.txt", samples.laser_table(TABLE, unit="arcsec"), component="EBZ").sensitive == {
        "Y": 1.0
    }


def test_several_components_in_one_file():
    yaw = samples.readings(4, seed=2)
    data = source(
        "set.csv",
        samples.canonical({"EZZ": (TABLE, "um"), "EBZ": (yaw, "arcsec"), "EXZ": (yaw, "mm")}),
    )
    every = read_all(data)
    assert [r.head["component"] for r in every] == ["EZZ", "EBZ", "EXZ"]
    assert_allclose(as_table(every[0])[1], TABLE, atol=1e-9)
    assert_allclose(as_table(every[1])[1], yaw * np.pi / 0.648, rtol=1e-9)
    assert every[1].sensitive == {"Y": 1.0} and every[2].quantity == "straightness"
    with pytest.raises(RecordingError, match="3 components: EZZ, EBZ, EXZ") as caught:
        taken("set.csv", data.data)
    assert "--component" in caught.value.advice
    one = taken("set.csv", data.data, component="EXZ")
    assert one.head["component"] == "EXZ"
    assert len(read_all(data, "", ReadingOptions(component="EXZ"))) == 1
    # times, places and temperatures are the file's
    assert_allclose(every[0].columns["t_s"], 7.0 * np.arange(TABLE.size))
    assert_allclose(every[0].columns["X_mm"], 10)
    assert_allclose(every[0].columns["Y_mm"], 20)
    assert_allclose(every[0].columns["T_machine_C"], 20.5)
    assert not any("made up" in t for t in every[0].notices)


def test_dates_become_seconds():
    text = "component,axis,target,run,dir,value,unit,time\n"
    text += "EZZ,Z,0,1,+,1,um,2024-05-17T10:00:00\nEZZ,Z,10,1,+,2,um,2024-05-17T10:00:30\n"
    assert_allclose(taken("a.csv", text).columns["t_s"], [0, 30])


def test_seconds_may_have_a_decimal_comma():
    head = "component;axis;target;run;dir;value;unit;time\n"
    rows = "EZZ;Z;0,0;1;+;0,7;um;0,5\nEZZ;Z;50,0;1;+;3,1;um;12,5\n"
    assert taken("a.csv", head + rows).columns["t_s"].tolist() == [0.5, 12.5]


@pytest.mark.parametrize("kind", [0, 1])
def test_linuxcnc_files_become_the_deviation_of_the_axis(kind):
    nominal = np.array([-10.0, 0.0, 40.0, 100.0])
    forward, reverse = np.array([3.0, 0.0, -2.5, 7.0]) * MM, np.array([1.0, -2.0, -4.5, 6.0]) * MM
    text = samples.compensation(nominal, forward, reverse, kind)
    recording = taken("Z.comp", text, unit="mm", extra={"type": str(kind)})
    targets, table = as_table(recording)
    assert_allclose(targets, nominal)
    assert_allclose(table, [forward / MM, reverse / MM], atol=1e-9)
    assert_allclose(recording.approach("Z"), np.where(recording.columns["run"] == 1, 1, -1))
    inch = taken("Z.comp", text, unit="inch", extra={"type": str(kind)})
    assert_allclose(as_table(inch)[0], nominal * 25.4)
    assert_allclose(as_table(inch)[1], table * 25.4, rtol=1e-9, atol=1e-9)


def test_linuxcnc_files_do_not_say_their_type():
    text = samples.compensation(np.array([0.0, 50.0, 100.0]), np.zeros(3), np.ones(3) * MM, 0)
    with pytest.raises(RecordingError, match="of which type") as caught:
        taken("Z.comp", text, unit="mm")
    assert "look like type 0" in caught.value.advice
    with pytest.raises(RecordingError, match="its unit") as caught:
        taken("Z.comp", text, extra={"type": "0"})
    assert "--unit" in caught.value.advice


@pytest.mark.parametrize("word", ["+", "forward"])
def test_a_long_table_that_says_its_directions_does_not_take_first(word):
    rows = [f"EXX,X,{q},1,{way},1,um" for way in (word, "-" if word == "+" else "reverse")
            for q in (0, 100)]  # fmt: skip
    text = "\n".join(["component,axis,target,run,dir,value,unit", *rows]) + "\n"
    plain, turned = (taken("l.csv", text, first=f) for f in (0, -1))
    same = (plain.approach("X") == turned.approach("X")).all()
    assert same == (word == "+")
    assert any("--first is not used" in t for t in turned.notices) == (word == "+")
