"""Renishaw's text and dynamic files: whatever order, encoding or decimal sign, the same readings at
the same targets."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from postproc.recordings import RecordingError
from tests.recordings import samples
from tests.recordings.samples import as_table, taken

TABLE = samples.readings(6)


def test_every_reading_stands_at_its_run_and_target():
    recording = taken("z.rtl", samples.renishaw(TABLE))
    targets, table = as_table(recording)
    assert_allclose(targets, samples.TARGETS)
    assert_allclose(table, TABLE, atol=1e-9)
    assert (
        recording.kind == "targets"
        and recording.quantity == "displacement"
        and recording.sensitive == {"Z": 1.0}
    )
    assert recording.machine == "mill-7" and "Renishaw" in recording.instrument
    assert recording.head["date"] == "2024-05-17" and recording.head["serial_number"] == "4711"


@pytest.mark.parametrize("n", [1, 4, 5, 6, 10, 11, 15])
def test_any_number_of_targets(n):
    """Where five divide it, readers that count lines fail."""
    targets = np.arange(n) * 25.0
    table = samples.readings(2, targets)
    got, values = as_table(taken("z.rtl", samples.renishaw(table, targets)))
    assert_allclose(got, targets)
    assert_allclose(values, table, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_the_rows_says_nothing(seed):
    plain = taken("z.rtl", samples.renishaw(TABLE))
    mixed = taken("z.rtl", samples.renishaw(TABLE, shuffle=seed))
    for name, column in plain.columns.items():
        assert_allclose(mixed.columns[name], column)


def test_decimal_commas_and_bare_line_feeds():
    for text in (
        samples.renishaw(TABLE, comma=True),
        samples.renishaw(TABLE, end="\n"),
        samples.renishaw(TABLE, end="\r"),
    ):
        assert_allclose(as_table(taken("z.rtl", text))[1], TABLE, atol=1e-9)


@pytest.mark.parametrize(
    ("machine", "encoding", "told"),
    [
        ("Fräse 7", "utf-8", ""),
        ("Fräse 7", "utf-8-sig", ""),
        ("铣床七号", "gbk", "gbk"),
        ("Fr\xe4se \x80 7", "cp1252", "cp1252"),
    ],
)
def test_encodings_are_tried_in_turn(machine, encoding, told):
    machine = machine.replace("\x80", "€")
    recording = taken("z.rtl", samples.renishaw(TABLE, machine=machine).encode(encoding))
    assert_allclose(as_table(recording)[1], TABLE, atol=1e-9)
    assert any(told in text for text in recording.notices) if told else recording.machine == machine
    if told == "gbk":
        assert recording.machine == machine


def test_odd_runs_go_one_way_even_runs_back():
    recording = taken("z.rtl", samples.renishaw(TABLE))
    assert_allclose(recording.approach("Z"), np.where(recording.columns["run"] % 2 == 1, 1, -1))
    assert any("odd runs are taken as +" in text for text in recording.notices)
    # the other way round
    turned = taken("z.rtl", samples.renishaw(TABLE), first=-1, bidirectional=True)
    assert_allclose(turned.approach("Z"), np.where(turned.columns["run"] % 2 == 1, -1, 1))
    assert not any("odd runs" in text for text in turned.notices)
    # targets that are listed from the far end begin towards minus
    down = taken("z.rtl", samples.renishaw(TABLE[:, ::-1], samples.TARGETS[::-1]))
    assert_allclose(down.approach("Z"), np.where(down.columns["run"] % 2 == 1, -1, 1))
    one_way = taken("z.rtl", samples.renishaw(TABLE), bidirectional=False, first=1)
    assert np.all(one_way.approach("Z") == 1)


def test_rows_come_in_the_order_of_the_travel():
    recording = taken("z.rtl", samples.renishaw(TABLE, shuffle=3))
    assert np.all(np.diff(recording.columns["t_s"]) > 0) and np.all(
        np.diff(recording.columns["run"]) >= 0
    )
    step, same = np.diff(recording.position("Z")), np.diff(recording.columns["run"]) == 0
    assert np.all(step[same] * recording.approach("Z")[1:][same] > 0)
    assert any("t_s is made up" in text for text in recording.notices)


def test_missing_readings_are_listed_and_the_others_kept():
    recording = taken("z.rtl", samples.renishaw(TABLE, skip=((2, 3), (4, 10))))
    assert len(recording) == TABLE.size - 2
    assert sorted(f.column for f in recording.faults) == ["run 2 target 3", "run 4 target 10"]
    assert any("2 of 6 x 10 readings are missing" in text for text in recording.notices)
    table = as_table(recording)[1]
    assert np.isnan(table[1, 2]) and np.isnan(table[3, 9]) and np.isnan(table).sum() == 2


def test_linear_in_um_angular_in_mm_per_m_and_both_said():
    """1 mm/m is 1 mrad (compensation notes, section 2)."""
    assert_allclose(as_table(taken("z.rtl", samples.renishaw(TABLE)))[1], TABLE, atol=1e-9)
    angle = taken("z.rta", samples.renishaw(TABLE / 1000), component="EBZ")
    assert (
        angle.quantity == "angle"
        and angle.sensitive == {"Y": 1.0}
        and "reading_urad" in angle.columns
    )
    assert_allclose(as_table(angle)[1], np.round(TABLE / 1000, 2) * 1000, atol=1e-6)
    assert any("taken as mm/m" in text for text in angle.notices)
    arcsec = taken("z.rta", samples.renishaw(TABLE), component="EAZ", unit="arcsec")
    assert arcsec.sensitive == {"X": 1.0}
    assert_allclose(as_table(arcsec)[1], TABLE * 4.848136811, rtol=1e-9)  # pi / 648000 rad
    rotary = taken("c.rta", samples.renishaw(TABLE / 100, axis="C"), unit="mm/m")
    assert (
        rotary.axes == ("C",)
        and rotary.sensitive == {"Z": 1.0}
        and rotary.head["component"] == "ECC"
    )


def test_straightness_needs_its_direction_and_its_unit():
    text = samples.renishaw(TABLE)
    with pytest.raises(RecordingError, match="in which direction") as caught:
        taken("z.rts", text)
    assert "EXZ or EYZ" in caught.value.advice
    with pytest.raises(RecordingError, match="unit") as caught:
        taken("z.rts", text, component="EXZ")
    assert "--unit" in caught.value.advice
    recording = taken("z.rts", text, component="EXZ", unit="mm")
    assert recording.quantity == "straightness" and recording.sensitive == {"X": 1.0}
    assert_allclose(as_table(recording)[1], TABLE * 1000, rtol=1e-12)
    assert any(
        "um read as nm?" in t for t in taken("z.rts", text, component="EXZ", unit="nm").notices
    )


def test_the_air_becomes_a_column():
    environment = (
        "Air temp   : 20.41",
        "Mat temp 1 : 21.5 C",
        "Mat temp 2 : 70.7",
        "Exp coeff  : 11.7",
        "Air Press  : 1013",
    )
    recording = taken("z.rtl", samples.renishaw(TABLE, environment=environment))
    assert_allclose(recording.columns["T_air_C"], 20.41)
    assert_allclose(recording.columns["T_material_1_C"], 21.5)
    assert "T_material_2_C" not in recording.columns and any(
        "Mat temp 2" in t and "left out" in t for t in recording.notices
    )
    assert recording.head["environment"]["Air Press"] == "1013"
    assert any("do not take it out twice" in t for t in recording.notices)


def test_a_run_of_zeros_and_the_flag_of_one_direction_are_named():
    table = TABLE.copy()
    table[1::2] = 0.0  # as a writer fills the return runs that were not measured
    recording = taken("z.rtl", samples.renishaw(table, flags="0 1 2 0"))
    assert any("run 2, 4, 6 are 0" in t for t in recording.notices)
    assert any("Flags: 0 1 2 0" in t for t in recording.notices)


def test_without_strict_bad_rows_are_listed():
    text = samples.renishaw(TABLE).replace(f"2   5      {TABLE[1, 4]:.2f}", "2   5      n/a")
    with pytest.raises(RecordingError, match="'2   5      n/a' is not a run"):
        taken("z.rtl", text)
    recording = taken("z.rtl", text, strict=False)
    assert len(recording) == TABLE.size - 1 and any("n/a" in f.message for f in recording.faults)


def test_a_dynamic_record_is_a_trace():
    samples_ = 100 + 0.05 * np.arange(400) + 0.002 * np.sin(np.arange(400) / 5)
    recording = taken("x.rtx", samples.dynamic(samples_), unit="mm", extra={"command": "line"})
    assert (
        recording.kind == "trace"
        and recording.head["sees"] == "tool"
        and recording.machine == "mill-7"
    )
    assert_allclose(recording.columns["X_act_mm"], samples_)
    assert_allclose(recording.columns["t_s"], np.arange(400) / 1000)
    off = recording.columns["X_act_mm"] - recording.columns["X_cmd_mm"]
    assert abs(off.mean()) < 1e-9 and np.abs(off).max() < 0.0025
    still = taken(
        "x.rtx", samples.dynamic(samples_, axis=""), unit="um", axis="Y", extra={"command": "still"}
    )
    assert_allclose(still.columns["Y_act_mm"], samples_ / 1000)
    assert np.ptp(still.columns["Y_cmd_mm"]) == 0


def test_samples_may_contain_the_end_mark():
    """EOF:: and a line end are bytes that a number may have."""
    odd = np.frombuffer(b"EOF::\r\n\x40" * 3, "<f8")
    recording = taken(
        "x.rtx",
        samples.dynamic(np.concatenate([odd, [1.0]])),
        unit="nm",
        extra={"command": "still"},
    )
    assert len(recording) == 4


@pytest.mark.parametrize(
    ("options", "advice"),
    [
        ({"unit": "mm", "extra": {"command": "still"}}, "--axis"),
        ({"axis": "X", "extra": {"command": "still"}}, "--unit"),
        ({"axis": "X", "unit": "mm"}, "--set command"),
    ],
)
def test_a_dynamic_record_asks_for_what_it_does_not_say(options, advice):
    with pytest.raises(RecordingError) as caught:
        taken("x.rtx", samples.dynamic(np.arange(9.0), axis=""), **options)
    assert advice in caught.value.advice


def test_both_are_recognised_by_their_content():
    assert taken("upload.txt", samples.renishaw(TABLE), component="EZZ").head["component"] == "EZZ"
    assert (
        taken(
            "upload.bin", samples.dynamic(np.arange(9.0)), unit="mm", extra={"command": "line"}
        ).kind
        == "trace"
    )
