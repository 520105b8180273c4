"""Any table by a mapping: one reading a row, several, positions instead of deviations, and the
other kinds."""

from __future__ import annotations

import pytest
from numpy.testing import assert_allclose

from postproc.errors import UsageError
from postproc.recordings import RecordingError
from tests.recordings.samples import as_table, taken

LONG = "Nr;Pos;Lauf;Richtung;Abw\n1;0,0;1;+;1,5\n2;10,0;1;+;2,5\n3;10,0;2;-;-0,5\n4;0,0;2;-;-1,5\n"
MAPPING = {"Z_mm": "Pos", "run": "Lauf", "direction": "Richtung", "reading_um": "Abw"}
EXPECTED = [[1.5, 2.5], [-1.5, -0.5]]


def test_one_reading_a_row():
    recording = taken("a.csv", LONG, columns=MAPPING)
    assert_allclose(as_table(recording)[1], EXPECTED)
    assert_allclose(recording.approach("Z"), [1, 1, -1, -1])
    assert recording.lines.tolist() == [2, 3, 4, 5]


@pytest.mark.parametrize(
    ("columns", "options"),
    [
        ({"Z_mm": "2", "run": "3", "direction": "4", "reading_um": "5"}, {}),
        ({"Z_mm": "POS", "run": "lauf", "direction": "Richtung", "reading": "Abw"}, {"unit": "um"}),
        ({"Z_mm": "Pos", "run": "Lauf", "reading_um": "Abw"}, {}),
    ],
)
def test_columns_by_number_in_any_case_and_without_direction(columns, options):
    assert_allclose(as_table(taken("a.csv", LONG, columns=columns, **options))[1], EXPECTED)


def test_a_table_without_headings():
    text = "\n".join(line for line in LONG.splitlines()[1:])
    columns = {"Z_mm": "2", "run": "3", "direction": "4", "reading_um": "5"}
    assert_allclose(as_table(taken("a.csv", text, columns=columns))[1], EXPECTED)


def test_the_unit_is_demanded():
    with pytest.raises(RecordingError, match="unit") as caught:
        taken(
            "a.csv",
            LONG,
            columns={**{k: v for k, v in MAPPING.items() if k != "reading_um"}, "reading": "Abw"},
        )
    assert "--unit" in caught.value.advice
    with pytest.raises(UsageError, match="in um, and --unit says mm"):
        taken("a.csv", LONG, columns=MAPPING, unit="mm")


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ({"Z_mm": "Pos (in)", "reading_um": "Dev (um)"}, "says inch, and Z_mm is mm"),
        ({"Z_in": "Pos (in)", "reading_um": "Err (mm)"}, "says mm, and reading_um is um"),
        ({"Z_in": "1", "reading_um": "3"}, "says mm, and reading_um is um"),
        ({"Z_in": "Pos (in)", "reading_um": "Dev (um)", "t_s": "t (ms)"}, "says ms"),
        ({"t_s": "t (ms)", "X_cmd_mm": "Pos (in)", "X_act_mm": "Err (mm)"}, "says ms"),
    ],
)
def test_a_heading_of_another_unit_is_refused(columns, says):
    """Inches read as mm, mm as um and ms as s were taken without a word."""
    text = "Pos (in),Dev (um),Err (mm),t (ms)\n0,1,0.001,0\n1,2,0.002,100\n2,4,0.004,200\n"
    with pytest.raises(UsageError, match=says):
        taken("a.csv", text, columns=columns)
    right = taken("a.csv", text, columns={"Z_in": "Pos (in)", "reading": "Err (mm)"})
    assert_allclose(right.position("Z"), [0, 25.4, 50.8])
    assert_allclose(right.columns["reading_um"], [1, 2, 4])


def test_positions_for_deviations():
    """actual - commanded: 10.0025 - 10 mm is 2.5 um."""
    text = "pos,act,run\n0,0.0015,1\n10,10.0025,1\n10,9.9995,2\n0,-0.0015,2\n"
    recording = taken("a.csv", text, columns={"Z_mm": "pos", "run": "run", "actual_mm": "act"})
    assert_allclose(as_table(recording)[1], EXPECTED, atol=1e-9)
    wrong = taken("a.csv", text, columns={"Z_mm": "pos", "run": "run", "reading_mm": "act"})
    assert any("look like positions, not deviations" in t for t in wrong.notices)


def test_several_runs_across():
    text = "z_in|f1|b1|f2|b2\n0|1|2|3|4\n1|5|6|7|8\n"
    columns = {
        "Z_in": "z_in",
        "forward1_um": "f1",
        "reverse1_um": "b1",
        "forward2_um": "f2",
        "reverse2_um": "b2",
    }
    recording = taken("a.csv", text, columns=columns)
    targets, table = as_table(recording)
    assert_allclose(targets, [0, 25.4])
    assert_allclose(table, [[1, 5], [2, 6], [3, 7], [4, 8]])


def test_further_columns_come_along():
    text = "t,x,z,d,air\n0,5,0,1,20.1\n4,5,10,2,20.2\n"
    columns = {"t_s": "t", "X_mm": "x", "Z_mm": "z", "reading_um": "d", "T_air_C": "air"}
    recording = taken("a.csv", text, columns=columns, axis="Z")
    assert_allclose(recording.columns["T_air_C"], [20.1, 20.2])
    assert_allclose(recording.columns["X_mm"], 5)
    assert_allclose(recording.columns["t_s"], [0, 4])
    assert not any("made up" in t for t in recording.notices)
    with pytest.raises(UsageError, match="which axis moved|positions of X, Z"):
        taken("a.csv", text, columns=columns)


def test_a_trace_a_circle_and_features():
    trace = taken(
        "t.csv",
        "t;c;a\n0;1,0;1,001\n0,1;2,0;2,002\n",
        columns={"t_s": "t", "X_cmd_mm": "c", "X_act_mm": "a"},
    )
    assert trace.kind == "trace" and trace.axes == ("X",)
    assert_allclose(trace.columns["X_act_mm"], [1.001, 2.002])

    text = "angle;dev;dir\n0;1,5;CCW\n90;-2,5;CCW\n180;0;CW\n"
    columns = {"angle_deg": "angle", "radial_um": "dev", "sense": "dir"}
    head = {"radius_mm": 150.0, "centre": {"X": 400.0, "Y": 300.0}}
    circle = taken("c.csv", text, columns=columns, head=head)
    assert circle.kind == "ballbar"
    assert_allclose(circle.position("X"), [550, 400, 250])
    assert_allclose(circle.position("Y"), [300, 450, 300])
    assert_allclose(circle.reading, [0.0015, -0.0025, 0.0])
    assert_allclose(circle.columns["sense"], [1, 1, -1])
    text_mm = text.replace("1,5", "0,0015").replace("-2,5", "-0,0025")
    columns_mm = {"angle_deg": "angle", "radial_mm": "dev", "sense": "dir"}
    same = taken("c.csv", text_mm, columns=columns_mm, head=head)
    assert_allclose(same.reading, [0.0015, -0.0025, 0.0])
    with pytest.raises(UsageError, match="a ballbar needs radius_mm"):
        taken("c.csv", text, columns=columns)

    text = "name,what,ax,nom,meas\nX1,centre_distance,X,80,79.983\n"
    columns = {
        "feature": "name",
        "kind": "what",
        "axis": "ax",
        "nominal_mm": "nom",
        "measured_mm": "meas",
    }
    features = taken("f.csv", text, columns=columns)
    assert features.kind == "features" and features.columns["feature"].tolist() == ["X1"]
    assert_allclose(features.columns["measured_mm"], 79.983)
    with pytest.raises(UsageError, match="column nominal_mm is missing"):
        taken("f.csv", text, columns={k: v for k, v in columns.items() if k != "nominal_mm"})


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"Z_mm": "Pos", "reading_um": "Abweichung"}, "no column is called 'Abweichung'"),
        ({"Z_mm": "9", "reading_um": "5"}, "the table has 5 columns"),
        ({"reading_um": "Abw"}, "names no position"),
        ({"Z_mm": "Pos"}, "must name one column of readings"),
        (
            {"Z_mm": "Pos", "reading_um": "Abw", "reading_mm": "Abw"},
            "must name one column of readings",
        ),
        ({"Z_mm": "Pos", "reading_furlong": "Abw"}, "furlong: this is no unit"),
        (
            {"Z_mm": "Pos", "reading_um": "Abw", "colour": "Nr"},
            "colour=... is no column of a recording",
        ),
        ({"Z_mm": "Pos", "forward_um": "Abw", "run": "Lauf"}, "say run and direction already"),
        ({"Z_mm": "Pos", "forward_um": "Abw", "reverse_mm": "Nr"}, "in mm and in um"),
        ({"Z_mm": "Pos", "reading_urad": "Abw"}, "about which axis the rotation of Z"),
    ],
)
def test_a_mapping_that_does_not_fit(columns, message):
    with pytest.raises((UsageError, RecordingError), match=message):
        taken("a.csv", LONG, columns=columns)
