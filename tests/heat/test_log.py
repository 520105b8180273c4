"""What a log of temperatures may not say, at the start of a program and while a job runs."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest

from postproc.commands import reading, warming
from postproc.errors import GcompError
from postproc.heat import log
from postproc.machine import growth
from postproc.machine.file import read_machine
from tests.heat.test_heat import filter_of, gcomp, machine, options, written

W = """[axes.W]
travel = [-10.0, 410.0]
least_increment = 0.0001
heat = { scale_um_m_K = 10.0 }
"""
PROGRAM = b"G21 G90 G54\nG1 X0 Y0 Z0 F6000\nX600\nX500\n"


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ('t_s,T_a_C\n0,20\n1,"21\n2,22\n', 3, "no row of a table: unexpected end of data"),
        ('t_s,T_a_C\n0,20\n"1,21\n', 3, "no row of a table: unexpected end of data"),
        (f"t_s,T_a_C\n0,20\n1,{'2' * 140_000}\n", 3, "field larger than field limit"),
        ("# a\n\nt_s,T_a_C,T_a_C\n0,20,21\n1,20,21\n", 3, "2 columns are called T_a_C"),
    ],
)
def test_what_is_no_table_is_refused_with_its_line(text, line, says):
    with pytest.raises(log.LogError, match=says) as refused:
        log.read("l.csv", text.encode())
    assert refused.value.place.line == line


@pytest.mark.parametrize(
    "heading", ["t_min", "Time (min)", "minutes", "time_ms", "Zeit [h]", "days"]
)
def test_times_in_another_unit_are_refused(heading):
    """A day in minutes was read as 24 minutes."""
    with pytest.raises(log.LogError, match="seconds are read"):
        log.read("log.csv", f"{heading},T1\n0,20\n1440,21\n".encode())
    for name in ("t_s", "time", "Time (s)", "moment", "Uhrzeit"):
        assert list(log.read("log.csv", f"{name},T1\n0,20\n60,21\n".encode()).time) == [0, 60]
    dated = f"{heading},T1\n2026-11-23T08:00,20\n2026-11-23T09:00,21\n"
    assert list(log.read("log.csv", dated.encode()).time) == [0, 3600]


@pytest.mark.parametrize("heading", ["T1 (°F)", "T1_degF", "T1 [K]", "Fahrenheit"])
def test_degrees_that_are_not_Celsius_are_refused(heading):
    """68 F is a room, and 68 C a machine that is 0.2 mm longer in 400 mm of steel."""
    found = log.read("log.csv", f"t_s,{heading},T_F_C\n0,68,20\n60,68,20\n".encode())
    with pytest.raises(log.LogError, match="goes from 68"):
        log.check(found, [heading])
    log.check(found, ["T_F_C"])


def test_a_column_ends_with_its_own_last_reading(tmp_path, capsys):
    """The other column goes on for two hours: that does not make this one longer."""
    rows = ["t_s,T_scale_X_C,T_work_C", "0,20,20", "60,20.5,20", "3600,,20", "7200,,21"]
    record = written(tmp_path, *rows)
    program = tmp_path / "a.nc"
    program.write_bytes(PROGRAM.replace(b"F6000", b"F6"))
    words = (
        program,
        "--machine",
        machine(tmp_path),
        "--temperatures",
        record,
        "-o",
        tmp_path / "b",
    )
    assert gcomp(*words) == 2
    said = capsys.readouterr().err
    assert "T_scale_X_C of" in said and "ends 60 s after the program begins" in said
    assert gcomp(*words, "--hold-temperature") == 0
    assert "3600 s lie between two readings of T_work_C" in capsys.readouterr().err
    late = written(tmp_path, "t_s,T_scale_X_C", "0,", "60,20", "9999,20")
    assert gcomp(*words) == 2
    assert "T_scale_X_C of" in (said := capsys.readouterr().err) and "begins 60 s after" in said
    assert late == record


@pytest.mark.parametrize("value", ["85", "-127", "24.1"])
def test_a_reading_that_metal_can_not_reach_is_refused(tmp_path, value):
    """30 s: 0.8 K of noise and 6 K a minute are 3.8 K."""
    record = written(tmp_path, "t_s,T_scale_X_C", "0,20", "30,20.2", f"60,{value}")
    with pytest.raises(log.LogError, match="T_scale_X_C goes from") as refused:
        filter_of(machine(tmp_path), "--temperatures", record)
    assert refused.value.place.line in (1, 4) and refused.value.advice


def live(tmp_path, record):
    asked = options(machine(tmp_path), "--temperatures", record)
    asked.live_temperatures = True
    return reading.filter_of(asked, reading.machine_of(asked))


@pytest.mark.parametrize(
    ("then", "says"),
    [
        ("t_s,T_scale_X_C\n0,20\n10,20.1\n40,85\n", "goes from 20.1 to 85 C in 30 s"),
        ("t_s,T_scale_X_C\n0,20\n10,20.1\n40,-127\n", "goes from -127 to 20.1"),
        ("t_s,T_other_C\n0,20\n10,20.1\n40,20.1\n", "T_scale_X_C is no column of it any more"),
        ("t_s,T_scale_X_C\n0,27\n1,27.1\n", "goes from 20.1 to 27.1 C"),  # begun anew
        ("t_s,T_scale_X_C,T_b_C\n0,20,1\n10,20.1,1\n900,,1\n", "holds no number for 890 s"),
        ("t_s,T_scale_X_C\n", "needs a row of names and two rows of numbers"),
        (None, "can not be read any more: No such file"),
    ],
)
def test_every_reading_of_a_log_that_goes_on_is_looked_at(tmp_path, then, says):
    """A row appended in the middle of the job said 85 C, and the cut went 324 um aside."""
    record = written(tmp_path, "t_s,T_scale_X_C", "0,20", "10,20.1")
    f = live(tmp_path, record)
    assert b"X499.9" in f.feed(PROGRAM)
    if then is None:
        record.unlink()
    else:
        record.write_text(then)
    with pytest.raises(log.LogError, match=says) as stopped:
        f.feed(PROGRAM)
    assert stopped.value.advice


def test_a_log_that_is_just_written_anew_is_awaited(tmp_path):
    """Some loggers write the whole file each time: what is there meanwhile is its beginning."""
    head, rows = "t_s,T_scale_X_C\n", "0,20\n10,20.1\n"
    record = written(tmp_path, *(head + rows).split())
    f = live(tmp_path, record)
    assert b"X499.9" in f.feed(PROGRAM)
    for meanwhile in ("", head, head + "0,20\n"):
        record.write_text(meanwhile)
        done = threading.Timer(0.1, record.write_text, (head + rows + "20,20.2\n",))
        done.start()
        f.feed(PROGRAM)
        done.join()
        assert f.heat.log.fresh().columns["T_scale_X_C"][-1] == 20.2


def test_a_log_that_nobody_writes_any_more_is_not_believed(tmp_path, monkeypatch):
    record = written(tmp_path, "t_s,T_scale_X_C", "0,20", "10,20.1")
    now = [1000.0]
    monkeypatch.setattr(warming.time, "monotonic", lambda: now[0])
    f = live(tmp_path, record)
    f.feed(PROGRAM)
    now[0] += warming.GAP - 1
    f.feed(PROGRAM)
    os.utime(record)
    f.feed(PROGRAM)
    now[0] += warming.GAP + 1
    with pytest.raises(GcompError, match="was not written for 601 s"):
        f.feed(PROGRAM)


@pytest.mark.parametrize(
    "words", [("--pace", "2"), ("--log-begin", "5"), ("--hold-temperature",)], ids=lambda w: w[0]
)
def test_what_says_how_a_log_is_read_needs_one(tmp_path, capsys, words):
    (tmp_path / "a.nc").write_bytes(PROGRAM)
    assert gcomp(tmp_path / "a.nc", "--machine", machine(tmp_path), *words) == 2
    assert f"{words[0]} says how --temperatures is read" in capsys.readouterr().err


def test_a_second_slide_grows_as_the_first_ones_do(tmp_path):
    """W along Z: 10 um/m/K, 7 K, 300 mm from where it is held."""
    folder = machine(tmp_path)
    toml = folder / "machine.toml"
    text = toml.read_text().replace("b-Z-t", "b-Z-W-t").replace("[offsets]", W + "[offsets]")
    toml.write_text(text.replace("Z = 0.0 }", "Z = 0.0, W = 0.0 }"))
    m = read_machine(folder)
    found, _, out = growth.drivers(m, ["T_screw_W_C"], spindles=False)
    assert [(d.name, d.column) for d in found] == [("scale of W", "T_screw_W_C")]
    warm = growth.grown(growth.following(m, found), found, np.array([7.0]))
    q = np.zeros((4, 1))
    q[3] = 300.0
    stated = m.at_temperatures({"W": 27.0})
    assert warm.deviation(q, 0 * q)[2] == pytest.approx(10e-6 * 7 * 300, abs=1e-9)
    assert warm.deviation(q, 0 * q) == pytest.approx(stated.deviation(q, 0 * q), abs=1e-9)
    _, _, out = growth.drivers(m, ["T_scale_X_C"], spindles=False)
    assert "no column for the scale of W: it stays at 20 C" in out


def test_a_block_that_outlasts_its_temperature_is_said(tmp_path):
    """Of a job that lasts longer, only a block that does."""
    f = live(tmp_path, written(tmp_path, "t_s,T_scale_X_C", "0,20", "10,20.1"))
    f.feed(b"G21 G90 G54\nG0 X0 Y0 Z0\nG1 X400 F600\nX0\nX400\n")  # 40 s each
    assert not [n for n in f.notices if n.code == "heat later"]
    f.feed(b"X0 F300\n")
    (late,) = [n for n in f.notices if n.code == "heat later"]
    assert "this block lasts 80 s" in late.message and late.size == pytest.approx(80.0)
