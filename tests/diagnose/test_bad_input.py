"""Bad recordings end in one sentence with file, line and a way out, or in an answer that says its
limit: never in a name that is not true.

The good ones are of a machine with 7 um of backlash of Z (targets, circle) and of an axis that lags
(log).
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from postproc.cli import main

from .damage import all_of, backwards, cells, head, one, rows, shuffled, split, times, without

ROOT = Path(__file__).resolve().parents[2]
STUDER = str(ROOT / "machines" / "studer-s36")
TRUE = {
    "backlash:Z",
    "backlash_position:Z",
    "windup:Z",
    "coulomb_friction:Z",
    "servo_lag:X",
    "delay:",
    "viscous_friction:X",
}  # and what is as good a name
PROGRAM = "G0 X0 Z0\nG4 P0.5\nG1 X100 Z80 F3000\nG1 X0 Z0\nG4 P0.5\nM2\n"


@pytest.fixture(scope="module")
def good(tmp_path_factory) -> dict[str, str]:
    """Texts of good recordings: targets, null (without any effect), circle, log."""
    folder = tmp_path_factory.mktemp("good")
    (folder / "p.nc").write_text(PROGRAM)
    play = ["--with", "backlash:Z:size_um=7"]
    made = {
        "targets": ["--test", "positioning:Z", *play],
        "null": ["--test", "positioning:Z"],
        "circle": ["--test", "ballbar:XZ", "--set", "rate=25", *play],
        "log": [str(folder / "p.nc"), "--instrument", "log", "--with", "servo_lag:X:tau_ms=2"],
    }
    texts = {}
    for name, more in made.items():
        file = folder / f"{name}.csv"
        assert (
            main(
                [
                    "simulate",
                    *more,
                    "--machine",
                    STUDER,
                    "--noise",
                    "0.4",
                    "--seed",
                    "3",
                    "-o",
                    str(file),
                    "--quiet",
                ]
            )
            == 0
        )
        texts[name] = file.read_text()
    return texts


def ask(files: list[str], *more: str, machine: str = STUDER) -> int:
    return main(["diagnose", *files, "--machine", machine, "--quiet", *more])


REFUSED = {  # what was done: (which, how, what is said, line or 0)
    "every reading NaN": (
        "targets",
        all_of("nan", "reading_um"),
        "no row can be used: reading_um = 'nan' is not a number",
        16,
    ),
    "every reading huge": (
        "targets",
        all_of("1e300", "reading_um"),
        "1e+300, beyond 100000 um",
        16,
    ),
    "decimal commas": (
        "targets",
        cells("reading_um", lambda v, k: f'"{v.replace(".", ",")}"'),
        "is not a number",
        16,
    ),
    "runs that are words": ("targets", all_of("one", "run"), "run = 'one' is not a number", 16),
    "runs that are halves": ("targets", all_of("1.5", "run"), "run is no whole number", 16),
    "runs beyond counting": ("targets", all_of("1e30", "run"), "run is no whole number", 16),
    "sides mixed up": ("targets", shuffled("approach_Z"), "approach_Z = ", 0),
    "sides turned round": ("targets", times(-1, "approach_Z"), "160 of 160 rows are so", 0),
    "sides of 3": ("targets", all_of("3", "approach_Z"), "approach_Z = 3", 16),
    "readings in mm": ("targets", times(1e-3, "reading_um"), "as if they were in mm", 16),
    "readings in nm": ("null", times(1e3, "reading_um"), "as if they were in nm", 15),
    "readings turned round": (
        "targets",
        times(-1, "reading_um"),
        "as if they had the other sign",
        16,
    ),
    "readings along -Z": (
        "targets",
        head("sensitive", "{ X = 0.0, Z = -1.0 }"),
        "the other sign",
        16,
    ),
    "readings all alike": (
        "targets",
        all_of("1.5", "reading_um"),
        "reading_um = 1.5 in all 170 rows",
        16,
    ),
    "readings cut off": (
        "targets",
        cells("reading_um", lambda v, k: str(min(max(float(v), -1), 1))),
        "the end of what the instrument can read",
        0,
    ),
    "places in metres": (
        "targets",
        times(1e-3, "X_mm", "Z_mm"),
        "fit the map of studer-s36 as m,",
        16,
    ),
    "places in inches": (
        "targets",
        times(1 / 25.4, "X_mm", "Z_mm"),
        "fit the map of studer-s36 as inch,",
        16,
    ),
    "places in um": ("targets", times(1e3, "X_mm", "Z_mm"), "beyond 100000 mm", 0),
    "places beyond the travel": (
        "targets",
        cells("Z_mm", lambda v, k: f"{float(v) + 200:g}"),
        "lies outside the travel of studer-s36, -5 to 520 mm",
        0,
    ),
    "places turned round": ("targets", times(-1, "Z_mm"), "these places fit as the other sign", 0),
    "one place from one side at one time": (
        "targets",
        lambda t: all_of("1", "t_s", "approach_Z")(all_of("100", "Z_mm")(t)),
        "no axis moves",
        0,
    ),
    "time backwards": ("targets", backwards("t_s"), "t_s runs backwards", 17),
    "time below zero": ("targets", times(-1, "t_s"), "t_s runs backwards", 17),
    "one row": ("targets", rows(lambda r: r[:1]), "1 row can be used, and 8 at least", 16),
    "five rows": ("targets", rows(lambda r: r[:5]), "5 rows can be used, and 8 at least", 16),
    "no rows": ("targets", rows(lambda r: []), "there are no rows", 15),
    "no header row": ("targets", lambda t: t.split("run,")[0], "no header row", 14),
    "empty": ("targets", lambda t: "", "the file is empty", 1),
    "blank lines": ("targets", lambda t: "\n \n", "the file is empty", 1),
    "no reading": ("targets", without("reading_um"), "the column reading_um is missing", 15),
    "no axes": ("targets", without("X_mm", "Z_mm"), "no column X_mm, Y_mm or Z_mm", 15),
    "the axis that moved": (
        "targets",
        without("Z_mm", "approach_Z"),
        "taken along Z, and Z_mm is not recorded",
        1,
    ),
    "an axis that is none": (
        "targets",
        head("sensitive", "{ Y = 1.0 }"),
        "along Y, which is no axis of studer-s36",
        1,
    ),
    "a column twice": (
        "targets",
        lambda t: t.replace("T_air_C", "t_s"),
        "the column 't_s' stands twice",
        15,
    ),
    "rows cut short": (
        "targets",
        rows(lambda r: [row[:4] for row in r]),
        "4 values under 13 columns",
        16,
    ),
    "two in one file": (
        "targets",
        lambda t: t + t,
        "the header row stands here a second time",
        200,
    ),
    "a head that is no TOML": (
        "targets",
        head("machine", "studer"),
        "the head is not valid TOML",
        6,
    ),
    "no kind": ("targets", head("kind", None), "the head does not say kind", 1),
    "another kind": ("targets", head("kind", '"trace"'), "no column X_cmd_mm", 15),
    "a vector of 2": (
        "targets",
        head("sensitive", "{ Z = 2.0 }"),
        "sensitive has the length 2.0000",
        5,
    ),
    "a log that stands": ("log", all_of("5", "X_act_mm"), "moves 0 mm for every mm of X_cmd_mm", 0),
    "a log in um": ("log", times(1e3, "X_act_mm"), "X_act_mm moves 1000 mm for every mm", 0),
    "a log mixed up": ("log", shuffled("X_act_mm"), "does not follow it", 0),
    "a log of one moment": ("log", all_of("1", "t_s"), "t_s = 1 in all", 0),
    "a log that runs back": ("log", backwards("t_s"), "t_s runs backwards", 0),
    "a log of ten": ("log", rows(lambda r: r[:10]), "10 rows can be used, and 32 at least", 0),
    "half a log hangs": (
        "log",
        cells("X_act_mm", lambda v, k: v if k < 1500 else "20"),
        "X_act_mm",
        0,
    ),
    "a circle of zeros": ("circle", all_of("0", "radial_um"), "radial_um = 0 in all", 0),
    "a circle in nm": ("circle", times(1e3, "radial_um"), "as if they were in nm", 0),
    "another radius": (
        "circle",
        head("radius_mm", "750"),
        "75 mm from the centre, and radius_mm = 750",
        0,
    ),
    "another centre": (
        "circle",
        head("centre", "{ X = 0.0, Z = 0.0 }"),
        "from the centre, and radius_mm = 75",
        0,
    ),
    "half a centre": (
        "circle",
        head("centre", "{ X = 85.0 }"),
        "the centre is stated in 1 axis",
        1,
    ),
    "a sense of 0": ("circle", all_of("0", "sense"), "sense = 0", 0),
}


@pytest.mark.parametrize("name", REFUSED)
def test_is_refused_in_one_sentence(good, tmp_path, capsys, name):
    which, change, said, line = REFUSED[name]
    file = tmp_path / "bad.csv"
    file.write_text(change(good[which]))
    assert ask([str(file)]) == 2
    told = capsys.readouterr()
    assert not told.out and "Traceback" not in told.err
    assert said in told.err and "bad.csv" in told.err
    if line:
        assert f"bad.csv:{line}: " in told.err
    assert told.err.count("gcomp:") == 1 and len(told.err.strip().splitlines()) <= 3
    assert not re.search(r"[a-z_]+\(|<[a-z]|\bNone\b|array", told.err.splitlines()[0])


STATED = {  # what was done: (which, how, what the answer states)
    "a reading NaN": ("targets", one("reading_um", "nan"), "reading_um = 'nan' is not a number"),
    "a reading infinite": (
        "targets",
        one("reading_um", "inf"),
        "reading_um = 'inf' is not a number",
    ),
    "a reading huge": ("targets", one("reading_um", "1e300"), "1e+300, beyond 100000 um"),
    "a word": ("targets", one("reading_um", "broken"), "reading_um = 'broken' is not a number"),
    "a time huge": ("targets", one("t_s", "1e300"), "t_s = 1e+300, beyond 1e+09 s"),
    "a place huge": ("targets", one("Z_mm", "1e300"), "Z_mm = 1e+300"),
    "a row cut short": (
        "targets",
        rows(lambda r: [row[:4] if k == 7 else row for k, row in enumerate(r)]),
        "4 values under 13 columns",
    ),
    "rows mixed up": ("targets", shuffled(), "rows are not in the order of t_s"),
    "rows of nothing mixed up": ("null", shuffled(), "rows are not in the order of t_s"),
    "rows twice": (
        "targets",
        rows(lambda r: [row for row in r for _ in (0, 1)]),
        "a copy of the row before",
    ),
    "rows of nothing ten times": (
        "null",
        rows(lambda r: [row for row in r for _ in range(10)]),
        "a copy of the row before",
    ),
    "readings mixed up": ("targets", shuffled("reading_um"), "Rows mixed up, or another machine"),
    "readings of another axis": ("targets", head("sensitive", "{ X = 1.0 }"), ""),
    "noise for readings": (
        "targets",
        cells("reading_um", lambda v, k: f"{1e6 * np.sin(k * k + 1):.0f}e-3"),
        "no measurement of a machine",
    ),
    "no approach": ("targets", without("approach_X", "approach_Z"), "approach_Z was not recorded"),
    "no approach of nothing": (
        "null",
        without("approach_X", "approach_Z"),
        "approach_Z was not recorded",
    ),
    "one side for all": ("targets", all_of("1", "approach_Z"), "the targets go both ways"),
    "no times": ("targets", without("t_s"), ""),
    "times NaN": ("targets", all_of("nan", "t_s"), "t_s is empty"),
    "one time": ("targets", all_of("100", "t_s"), "t_s = 100 in all rows"),
    "another machine's name": (
        "targets",
        head("machine", '"mv-1060"'),
        "it was recorded on mv-1060",
    ),
    "one run": ("targets", rows(lambda r: [row for row in r if row[0] == "1"]), ""),
    "one run of nothing": ("null", rows(lambda r: [row for row in r if row[0] == "1"]), ""),
    "a step of 10 um": ("null", cells("reading_um", lambda v, k: f"{round(float(v), -1):g}"), ""),
    "kelvins between": (
        "targets",
        cells("T_screw_Z_C", lambda v, k: str(float(v) + 273.15) if k % 2 else v),
        "which no sensor reads",
    ),
    "a broken sensor": ("targets", all_of("-999", "T_screw_Z_C"), "which no sensor reads"),
    "a log mixed up": ("log", shuffled(), "rows are not in the order of t_s"),
    "a log with a huge sample": ("log", one("X_act_mm", "1e300", 500), "X_act_mm = 1e+300"),
    "a circle mixed up": ("circle", shuffled(), "rows are not in the order of t_s"),
    "a circle of noise": ("circle", shuffled("radial_um"), ""),
    "line ends of Windows": ("targets", lambda t: t.replace("\n", "\r\n"), ""),
}


@pytest.mark.parametrize("name", STATED)
def test_is_answered_with_its_limit(good, tmp_path, name):
    which, change, said = STATED[name]
    file, out = tmp_path / "bad.csv", tmp_path / "answer.json"
    file.write_bytes(change(good[which]).encode())
    assert ask([str(file)], "--json", str(out)) == 0
    told = json.loads(out.read_text())
    accepted = {
        f"{e['effect']}:{e['axis'] or ''}" for e in told["effects"] if e["status"] == "accepted"
    }
    assert accepted <= (set() if which == "null" else TRUE)
    if said:
        assert said in json.dumps([told["data_faults"], told["doubts"], told["notices"]])
    if told["doubts"]:
        assert told["verdict"] == "unknown" and not accepted


@pytest.mark.parametrize(
    "data",
    [
        bytes(range(256)) * 20,
        b"PK\x03\x04" + bytes(900),
        b"\x89PNG\r\n\x1a\n" + bytes(500),
        b'{"a": 1}',
        b"G0 X0\nG1 X100 F500\nM2\n",
    ],
    ids=["bytes", "archive", "picture", "json", "program"],
)
def test_what_is_no_recording(tmp_path, capsys, data):
    file = tmp_path / "bad.csv"
    file.write_bytes(data)
    assert ask([str(file)]) == 2
    says = "this is an archive" if data.startswith(b"PK") else "looks like no recording"
    assert says in capsys.readouterr().err


def test_other_encodings(good, tmp_path, capsys):
    file = tmp_path / "bad.csv"
    file.write_bytes(good["targets"].replace("laser", "l\u00e4ser").encode("latin-1"))
    assert ask([str(file)]) == 2
    assert "bad.csv:3: byte 228 is not UTF-8 text" in capsys.readouterr().err
    file.write_bytes(good["targets"].encode("utf-16"))
    assert ask([str(file)]) == 2


def test_folders_missing_files_and_machines(good, tmp_path, capsys):
    file = tmp_path / "r.csv"
    file.write_text(good["targets"])
    for files, more, machine, said in (
        ([str(tmp_path)], (), STUDER, "is a folder"),
        ([str(tmp_path / "none.csv")], (), STUDER, "there is no recording"),
        ([str(file)], (), "studder", "there is no machine 'studder'"),
        (
            [str(file)],
            (),
            str(ROOT / "machines" / "example-mill"),
            "lies outside the travel of example-mill",
        ),
        ([str(file)], ("--holdout", "3"), STUDER, "--holdout 3 is not understood"),
        ([str(file)], ("--holdout", "run=9"), STUDER, "nothing run=9"),
        ([str(file)], ("--json", str(tmp_path / "no" / "a.json")), STUDER, "there is no folder"),
        ([str(file)], ("--write-machine", STUDER), STUDER, "--force writes over it"),
    ):
        assert ask(files, *more, machine=machine) == 2
        told = capsys.readouterr()
        assert said in told.err and "Traceback" not in told.err


def test_the_same_twice_and_two_that_contradict(good, tmp_path, capsys):
    a, b, c = (tmp_path / name for name in ("a.csv", "b.csv", "c.csv"))
    a.write_text(good["targets"])
    b.write_text(good["targets"])
    c.write_text(good["null"])
    assert ask([str(a), str(b)]) == 2
    assert "holds the same 170 rows as" in capsys.readouterr().err
    out = tmp_path / "answer.json"
    assert ask([str(a), str(c)], "--json", str(out)) == 0
    told = json.loads(out.read_text())
    # it says that more is there than it names
    assert told["unknown"]["rms_um"] > 0.8 or told["doubts"]
    assert not [
        e for e in told["effects"] if e["effect"] == "backlash" and e["status"] == "accepted"
    ]


def test_a_file_that_may_not_be_read(good, tmp_path, capsys, monkeypatch):
    file = tmp_path / "r.csv"
    file.write_text(good["targets"])

    plain = open

    def refuse(name, *words, **more):
        if str(name) == str(file):
            raise PermissionError(13, "Permission denied", str(name))
        return plain(name, *words, **more)

    monkeypatch.setattr("builtins.open", refuse)
    assert ask([str(file)]) == 2
    assert "r.csv can not be read: Permission denied" in capsys.readouterr().err


def test_the_good_ones_are_answered_without_a_word_of_doubt(good, tmp_path):
    for which in good:
        file, out = tmp_path / f"{which}.csv", tmp_path / f"{which}.json"
        file.write_text(good[which])
        assert ask([str(file)], "--json", str(out)) == 0
        told = json.loads(out.read_text())
        assert not told["doubts"] and not told["notices"] and not told["data_faults"]
        assert (told["verdict"] == "nothing-left-out") == (which == "null")
        assert len(split(good[which])[2]) == told["recordings"][0]["rows"]


def test_one_dead_instrument_of_two_is_left_out_and_said(tmp_path, good):
    """A column of 1.5 beside a recording that reads: the other one is diagnosed."""
    reads, dead, out = tmp_path / "good.csv", tmp_path / "dead.csv", tmp_path / "a.json"
    reads.write_text(good["targets"])
    dead.write_text(all_of("1.5", "reading_um")(good["targets"]))
    assert ask([str(dead), str(reads)], "--json", str(out)) == 0
    answer = json.loads(out.read_text())
    assert [Path(r["file"]).name for r in answer["recordings"]] == ["good.csv"]
    assert any(
        "dead.csv is left out: reading_um = 1.5 in all 170 rows" in n for n in answer["notices"]
    )
