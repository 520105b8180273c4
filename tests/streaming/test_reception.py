"""Programs that a control sends: whole or not at all, every byte's parity looked at."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from postproc.cli import main
from postproc.streaming.reception import ODD, Reception
from tests.api.schemas import held

tty = pytest.importorskip("tty", reason="pseudo-terminals as POSIX has them")

ROOT = Path(__file__).resolve().parents[2]
PART = "%\nO0012 (SHAFT)\nN10 G0 X10. Z5.\nN20 G1 Z-3. F0.2\nM30\n%\n"


def even(text: str) -> bytes:
    """Seven bits and even parity, as they come to a port of eight bits."""
    return bytes(v | 0x80 * ODD[v] for v in text.encode())


def taken(data: bytes, cut: int = 7, **how) -> Reception:
    reception = Reception(**how)
    for i in range(0, len(data), cut):
        reception.receive(data[i : i + cut])
    return reception


@pytest.mark.parametrize("cut", [1, 7, 1000])
@pytest.mark.parametrize("before, behind", [("", ""), ("\0\0\0\x12\r\n", "\x14\0\0")])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\n\r\r"])
def test_what_stands_between_the_marks(cut, before, behind, end):
    data = even(before + PART.replace("\n", end) + behind)
    reception = taken(data, cut, parity="E")
    assert reception.done and not reception.fault and reception.text.decode() == PART


def test_every_single_flipped_bit_is_found():
    """In 7E: a parity is wrong. Before the program begins it is noise; then its first % is missing,
    and that is told too."""
    whole = even(PART)
    for i in range(len(whole) - 1):
        for bit in range(8):
            data = bytearray(whole)
            data[i] ^= 1 << bit
            reception = taken(bytes(data), parity="E")
            assert reception.fault and not reception.done, (i, bit)
    assert "wrong parity" in taken(whole[:9] + b"\x01" + whole[10:], parity="E").fault
    assert "line 2" in taken(whole[:9] + b"\x01" + whole[10:], parity="E").fault
    assert "is missing" in taken(b"\xa4" + whole[1:], parity="E").fault


def test_the_wrong_frame_is_no_program():
    assert "is no letter of a program" in taken(even(PART), seven=False).fault
    assert taken(PART.encode(), seven=False).done


def test_an_end_that_is_missing():
    cut = taken(even(PART)[:-9], parity="E")
    cut.silent(False)
    assert "no % or DC4 has ended the program" in cut.fault and "after 3 lines" in cut.fault
    stopped = taken(even(PART[:-9] + "\x14"), parity="E")
    assert "the control has stopped (DC4)" in stopped.fault
    siemens = taken(b"%MPF100\nN10 G0 X1\nM30", seven=False)
    assert not siemens.done
    siemens.silent(True)
    assert siemens.done and siemens.text == b"%MPF100\nN10 G0 X1\nM30\n"
    empty = Reception()
    empty.silent(False)
    assert not empty.fault


def receive(folder, data: bytes, *options: str, stop: bool = False):
    """gcomp receive, and a control that sends `data` when it is waited for; stop: then somebody
    presses Ctrl-C."""
    master, slave = os.openpty()
    tty.setraw(slave)
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "postproc",
            "receive",
            "--port",
            os.ttyname(slave),
            "-o",
            "part.nc",
            *options,
        ],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        # a shell starts what runs in the background with Ctrl-C ignored
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stderr is not None and process.stdout is not None
    first = process.stderr.readline()
    if "waiting" in first:
        for i in range(0, len(data), 32):
            os.write(master, data[i : i + 32])
            time.sleep(0.02)
    if stop:
        while f'"bytes": {len(data)}' not in process.stdout.readline():
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    os.close(master)
    os.close(slave)
    assert "Traceback" not in err, err
    return process.returncode, out, first + err


def test_a_program_from_a_control(tmp_path):
    status, out, err = receive(tmp_path, even(PART.replace("\n", "\r\n")), "--json", "part.json")
    assert status == 0, err
    found = json.loads((tmp_path / "part.json").read_text())
    held(found)
    assert (found["lines"], found["written"], found["fault"]) == (6, "part.nc", None)
    assert (
        (tmp_path / "part.nc").read_text() == PART
        and "6 lines" in err
        and "waiting for the control" in err
    )
    told = json.loads(out.splitlines()[0])
    assert told["event"] == "progress" and told["state"] == (
        "receiving" if told["bytes"] else "waiting"
    )
    status, _, err = receive(tmp_path, b"")
    assert status == 2 and "is there already" in err


def test_nothing_is_written_of_a_damaged_program(tmp_path):
    data = bytearray(even(PART))
    data[20] ^= 4
    status, out, err = receive(tmp_path, bytes(data), "--json", "-")
    found = json.loads(out)
    held(found)
    assert found["written"] is None and "line 3" in found["fault"]
    assert status == 16 and "nothing was written: line 3 of what came in" in err, err
    status, _, err = receive(tmp_path, even(PART[:30]), stop=True)
    assert status == 130 and "interrupted" in err and "30 bytes" in err, err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("nosuch/a.nc", "there is no folder"),
        (".", "is a folder"),
        ("/proc/a.nc", "can not be written"),
    ],
)
def test_a_place_that_takes_no_file_is_refused_before_the_control_sends(
    tmp_path, monkeypatch, capfd, name, says
):
    """Before the port is opened, too: a program that has come in can not be asked for again."""
    monkeypatch.chdir(tmp_path)
    assert main(["receive", "--port", "/dev/nosuch", "-o", name, "--force"]) == 2
    assert says in capfd.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_link_stays_one(tmp_path):
    (tmp_path / "part.nc").symlink_to(tmp_path / "there.nc")
    (tmp_path / "there.nc").write_text("old")
    status, _, err = receive(tmp_path, even(PART), "--force")
    assert status == 0, err
    assert (tmp_path / "part.nc").is_symlink() and (tmp_path / "there.nc").read_text() == PART
