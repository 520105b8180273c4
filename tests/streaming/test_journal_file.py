"""The journal on the disk: a slow disk holds nobody up, a killed process loses nothing, a full disk
is told (A10, A17)."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from postproc.commands.stream import journal_file
from postproc.commands.stream.journal_file import JournalFile
from postproc.errors import UsageError

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def slow(monkeypatch):
    """An fsync that waits until it is allowed to; which threads called it."""

    class Slow:
        go, entered, by = threading.Event(), threading.Event(), []

    real = os.fsync

    def fsync(file):
        Slow.by.append(threading.current_thread())
        if threading.current_thread() is not threading.main_thread():
            Slow.entered.set()
            assert Slow.go.wait(60)
        real(file)

    monkeypatch.setattr(journal_file.os, "fsync", fsync)
    monkeypatch.setattr(journal_file, "SYNC", 0.001)
    return Slow


def test_A10_the_sender_does_not_wait_for_a_slow_disk(tmp_path, slow):
    journal = JournalFile(tmp_path / "j", b"head\n")
    journal.write(b"0\n")
    assert slow.entered.wait(60)
    for i in range(1, 1000):  # while the fsync hangs
        journal.write(b"%d\n" % i)
    assert not slow.go.is_set()
    assert (tmp_path / "j").read_bytes() == b"head\n" + b"".join(b"%d\n" % i for i in range(1000))
    slow.go.set()
    journal.close()
    assert slow.by[-1] is not threading.main_thread() and not journal.fault


def test_A10_what_was_written_last_is_synced_at_the_end(tmp_path, slow):
    slow.go.set()
    journal = JournalFile(tmp_path / "j", b"head\n")
    synced = []
    journal_file.os.fsync, old = (
        lambda file: synced.append((tmp_path / "j").read_bytes()),
        journal_file.os.fsync,
    )
    try:
        journal.write(b"last\n")
        journal.close()
    finally:
        journal_file.os.fsync = old
    assert synced[-1] == b"head\nlast\n"


def test_A10_a_killed_process_with_a_disk_that_hangs_loses_no_record(tmp_path):
    code = f"""
import os, sys, threading
sys.path.insert(0, {str(ROOT)!r})
from pathlib import Path
from postproc.commands.stream import journal_file
journal = journal_file.JournalFile(Path("j"), b"head\\n")
journal_file.os.fsync = lambda file: threading.Event().wait()
for i in range(500):
    journal.write(b"%d\\n" % i)
os.kill(os.getpid(), 9)
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, timeout=60)
    assert done.returncode == -signal.SIGKILL
    assert (tmp_path / "j").read_bytes() == b"head\n" + b"".join(b"%d\n" % i for i in range(500))


def test_a_full_disk_is_a_fault_and_not_the_end(tmp_path, monkeypatch):
    """What could be written ends with a whole record; what came since is written when there is room
    again, in order."""
    monkeypatch.setattr(journal_file, "SYNC", 0.01)
    journal = JournalFile(tmp_path / "j", b"head\n")
    real = os.write

    def full(file, data):
        if len(data) < 3:
            raise OSError(28, "No space left on device")
        return real(file, data[:3])  # a part of it still fits

    with monkeypatch.context() as patch:
        patch.setattr(journal_file.os, "write", full)
        journal.write(b"0\n1\n")
        deadline = time.monotonic() + 30
        while not journal.fault:
            assert time.monotonic() < deadline
        assert journal.fault == "No space left on device"
        journal.write(b"2\n")
        assert (tmp_path / "j").read_bytes() in (b"head\n0\n", b"head\n0\n1\n", b"head\n0\n1\n2\n")
    while journal.fault:
        assert time.monotonic() < deadline
    journal.close()
    assert (tmp_path / "j").read_bytes() == b"head\n0\n1\n2\n"


def test_nobody_waits_for_a_disk_that_hangs_in_a_write(tmp_path, monkeypatch):
    """As it may be on a network, or a stick: 20 records take no longer than one wait each."""
    go, real = threading.Event(), os.write
    journal = JournalFile(tmp_path / "j", b"head\n")
    monkeypatch.setattr(
        journal_file.os, "write", lambda file, data: go.wait(60) and real(file, data)
    )
    started = time.monotonic()
    for i in range(20):
        journal.write(b"%d\n" % i)
    assert time.monotonic() - started < 20 * journal_file.TAKEN + 5.0
    go.set()
    journal.close()
    assert (tmp_path / "j").read_bytes() == b"head\n" + b"".join(b"%d\n" % i for i in range(20))


def test_a_journal_that_can_not_be_begun_is_refused_and_an_old_one_kept(tmp_path):
    with pytest.raises(UsageError, match="can not be written"):
        JournalFile(tmp_path / "no" / "j", b"")
    with pytest.raises(UsageError, match="is no file"):  # a device is not put aside
        JournalFile(Path(os.devnull), b"")
    for text in (b"a\n", b"b\n"):
        JournalFile(tmp_path / "j", text).close()
    assert ((tmp_path / "j").read_bytes(), (tmp_path / "j.old").read_bytes()) == (b"b\n", b"a\n")
