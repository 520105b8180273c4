"""Many programs: all are done, once, whatever ends; one that can not be corrected stops no other;
what is done stays done."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import gcomp
from postproc.batch import pool
from postproc.batch.ledger import NAME
from postproc.cli import main
from tests.batch import killers

ROOT = Path(__file__).resolve().parents[2]
COUNT = 8


def programs(folder: Path, count: int = COUNT) -> Path:
    """So many different programs, two of them in a folder below."""
    (folder / "below").mkdir(parents=True)
    for k in range(count):
        name = folder / ("below" if k in (1, 2) else "") / f"p{k:02}.nc"
        name.write_text(f"G90 G21 G18\nG0 X20. Z{k}.\nG1 X40. Z{50 + k}. F100\nM30\n")
    return folder


def run(*words: object) -> int:
    return main(["batch", *map(str, words)])


def results(out: Path) -> dict[str, bytes]:
    return {str(p.relative_to(out)): p.read_bytes() for p in sorted(out.rglob("*.nc"))}


def ledger(out: Path) -> list[dict]:
    """Lines that tell what came of a job."""
    lines = [
        json.loads(line) for line in (out / NAME).read_text().splitlines() if line.endswith("}")
    ]
    return [line for line in lines if line["status"] != "begun"]


@pytest.fixture
def place(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    programs(tmp_path / "in")
    return tmp_path


@pytest.mark.parametrize("processes", [1, 2])
def test_every_program_gives_the_bytes_of_gcomp_alone(place, capfd, processes):
    assert (
        run(
            "in",
            "--machine",
            "studer-s36",
            "-o",
            "out",
            "-j",
            processes,
            "--verify",
            "--json",
            "all.json",
        )
        == 0
    )
    machine = gcomp.load_machine("studer-s36")
    expected = {
        str(p.relative_to("in")): gcomp.compensate(p, machine).program
        for p in Path("in").rglob("*.nc")
    }
    assert results(place / "out") == expected and len(expected) == COUNT
    assert f"{COUNT} of {COUNT} corrected" in capfd.readouterr().out
    with open("out/gcomp-batch.csv") as table:
        rows = list(csv.DictReader(table))
    assert [r["program"] for r in rows] == [str(p) for p in sorted(Path("in").rglob("*.nc"))]
    assert all(float(r["after_um"]) < 0.6 < float(r["before_um"]) for r in rows)
    told = json.loads(Path("all.json").read_text())
    assert told["counts"] == {"done": COUNT, "refused": 0, "failed": 0}
    assert told["programs"][0]["result"]["format"] == "gcomp-program/1"


def test_what_is_done_is_not_done_again_and_what_changed_is(place, capfd):
    line = ("in", "--machine", "studer-s36", "-o", "out", "-j", 1)
    assert run(*line) == 0
    stamps = {p: p.stat().st_mtime_ns for p in Path("out").rglob("*.nc")}
    Path("in/p05.nc").write_text("G90 G21 G18\nG0 X20. Z0.\nG1 X30. F100\n")
    Path("out/p06.nc").write_text("damaged")
    Path("in/p08.nc").write_text("G90 G21 G18\nG0 X20. Z0.\n")
    assert run(*line) == 0
    assert (
        f"{COUNT + 1} of {COUNT + 1} corrected ({COUNT - 2} of them in an earlier run)"
        in capfd.readouterr().out
    )
    again = {p.name for p, stamp in stamps.items() if p.stat().st_mtime_ns != stamp}
    assert again == {"p05.nc", "p06.nc"}
    assert b"damaged" not in Path("out/p06.nc").read_bytes()
    assert run(*line, "--tolerance", "2um") == 0  # other options: all are done again
    assert "earlier run" not in capfd.readouterr().out


def test_one_bad_program_stops_nothing_and_says_where(place, capfd):
    Path("in/bad.nc").write_text("G90 G21 G18 G0 X20. Z0.\nG1 X900. F100\n")
    Path("in/worse.nc").write_bytes(b"\x00\xff\x00")
    assert run("in", "--machine", "studer-s36", "-o", "out", "-j", 2) == 2
    out, err = capfd.readouterr()
    assert f"{COUNT} of {COUNT + 2} corrected, 2 refused" in out
    assert "in/bad.nc:2: X = 450.0000 mm lies outside" in err and "in/worse.nc:1:" in err
    assert set(results(place / "out")) == {
        str(p.relative_to("in")) for p in Path("in").rglob("p*.nc")
    }


def test_several_machines_have_folders_of_their_own(place):
    assert run(
        "in",
        "--machine",
        "studer-s36",
        "--machine",
        "perfect",
        "-o",
        "out",
        "-j",
        2,
        "--quiet",
        "--dialect",
        "fanuc-lathe",
    ) in (0, 2)
    assert {p.name for p in Path("out").iterdir() if p.is_dir()} == {"studer-s36", "perfect"}
    assert results(place / "out" / "perfect") == results(place / "in")


@pytest.mark.parametrize("kills, status", [(killers.dies_once, 0), (killers.dies_always, 1)])
def test_a_worker_that_is_killed_loses_no_job(place, capfd, monkeypatch, kills, status):
    monkeypatch.setattr(pool, "work", kills)
    assert run("in", "--machine", "studer-s36", "-o", "out", "-j", 2, "--retries", 1) == status
    done = results(place / "out")
    assert len(done) == COUNT - status
    outputs = [entry["output"] for entry in ledger(place / "out")]
    assert len(outputs) == len(set(outputs)) == COUNT
    if status:
        assert "p03.nc: the process that corrected it ended 2 times" in capfd.readouterr().err


def test_a_run_that_is_killed_goes_on_where_it_was(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    programs(tmp_path / "in", 60)
    command = [
        sys.executable,
        "-m",
        "postproc",
        "batch",
        "in",
        "--machine",
        "studer-s36",
        "-o",
        "out",
        "-j",
        "2",
        "--quiet",
    ]
    first = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": str(ROOT)})
    try:
        limit = time.monotonic() + 60
        book = tmp_path / "out" / NAME
        while time.monotonic() < limit and not (
            book.exists() and book.read_bytes().count(b"sha256") >= 5
        ):
            time.sleep(0.005)
    finally:
        first.send_signal(signal.SIGKILL)
        first.wait()
    before = {
        entry["output"]: Path(entry["output"]).stat().st_mtime_ns
        for entry in ledger(tmp_path / "out")
    }
    assert 5 <= len(before) < 60
    time.sleep(0.1)  # its workers have ended with it, and let go of the folder
    assert run("in", "--machine", "studer-s36", "-o", "out", "-j", 2, "--quiet") == 0
    assert len(results(tmp_path / "out")) == 60
    outputs = [entry["output"] for entry in ledger(tmp_path / "out")]
    assert len(outputs) == len(set(outputs)) == 60
    assert {name: Path(name).stat().st_mtime_ns for name in before} == before


def test_a_line_that_was_cut_off_is_a_job_done_again(place):
    line = ("in", "--machine", "studer-s36", "-o", "out", "-j", 1, "--quiet")
    assert run(*line) == 0
    book = Path("out") / NAME
    book.write_bytes(book.read_bytes()[:-20])
    stamps = {p: p.stat().st_mtime_ns for p in Path("out").rglob("*.nc")}
    assert run(*line) == 0
    assert sum(p.stat().st_mtime_ns != stamp for p, stamp in stamps.items()) == 1
    assert len({entry["output"] for entry in ledger(Path("out"))}) == COUNT


@pytest.mark.parametrize(
    "words, says",
    [
        (["in", "-o", "out"], "--machine is missing"),
        (["none", "--machine", "perfect", "-o", "out"], "there is no program none"),
        (["in", "--machine", "no-such", "-o", "out"], "there is no machine 'no-such'"),
        (["in", "--machine", "perfect", "-o", "in"], "would be written among the programs in in"),
        (
            ["in/p00.nc", "same/p00.nc", "--machine", "perfect", "-o", "out"],
            "would both be written to",
        ),
        (["empty", "--machine", "perfect", "-o", "out"], "there is no program in empty"),
        (["empty", "--machine", "perfect", "-o", "out"], "*.iso *.eia *.pim\n"),
        (["in", "--machine", "perfect", "-o", "out", "-j", "0"], "not a number of processes"),
        (
            ["in", "--machine", "perfect", "-o", "out", "--scheduler", "tcp://127.0.0.1:9"],
            "no Dask scheduler answers",
        ),
    ],
)
def test_what_can_not_be_is_refused_before_anything_is_written(
    place, capfd, monkeypatch, words, says
):
    Path("same").mkdir()
    Path("same/p00.nc").write_text("G0 X1\n")
    Path("empty").mkdir()
    if "--scheduler" in words:
        pytest.importorskip("distributed")
        monkeypatch.setattr(pool, "ANSWERS", 1)
    assert run(*words) == 2
    assert says in capfd.readouterr().err
    assert not list(Path("out").rglob("*.nc"))


def test_a_file_that_batch_did_not_write_stays(place, capfd):
    Path("out").mkdir()
    Path("out/p00.nc").write_text("mine")
    assert run("in", "--machine", "studer-s36", "-o", "out", "-j", 1) == 2
    assert "out/p00.nc exists, and gcomp batch did not write it" in capfd.readouterr().err
    assert Path("out/p00.nc").read_text() == "mine"
    assert run("in", "--machine", "studer-s36", "-o", "out", "-j", 1, "--force", "--quiet") == 0
    assert Path("out/p00.nc").read_text() != "mine"


def test_two_runs_do_not_write_to_one_folder(place, capfd):
    from postproc.batch.ledger import Ledger

    first = Ledger(Path("out"))
    assert run("in", "--machine", "perfect", "-o", "out") == 2
    assert "another gcomp batch is writing" in capfd.readouterr().err
    first.close()


def test_options_that_change_the_machine_reach_every_process(place):
    assert (
        run("in", "--machine", "studer-s36", "--only", "EZZ", "-o", "out", "-j", 2, "--quiet") == 0
    )
    part = gcomp.load_machine("studer-s36", only=["EZZ"])
    assert (place / "out" / "p00.nc").read_bytes() == gcomp.compensate(
        Path("in/p00.nc"), part
    ).program


def test_pages_beside_the_results(place):
    assert (
        run("in/p00.nc", "--machine", "studer-s36", "-o", "out", "-j", 1, "--report", "--quiet")
        == 0
    )
    assert "p00.nc on studer-s36" in Path("out/p00.nc.html").read_text("utf-8")


def test_of_a_program_of_which_nothing_was_compared_no_deviation_stands_in_the_table(capfd, place):
    """Z is nowhere stated: 0.00 um stood there."""
    Path("flat").mkdir()
    Path("flat/a.nc").write_text("G90 G21\nG1 X100. Y100. F500\nX200.\n")
    words = ("flat", "--machine", "example-router", "--dialect", "linuxcnc", "--verify")
    assert run(*words, "-o", "out") == 0
    with open("out/gcomp-batch.csv", newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["status"], row["before_um"], row["after_um"]) == ("done", "", "")
