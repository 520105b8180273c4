"""The journal on the disk: every record is the system's before its line leaves, and on the disk
soon after; nobody waits for a disk that hangs.
"""

from __future__ import annotations

import contextlib
import os
import threading
from pathlib import Path

from postproc.errors import UsageError

SYNC = 0.5  # s between two fsync, and between two tries to write on a full disk
TAKEN = 0.01  # s that a record's line waits at most for the system to take the record
MOST = 1 << 26  # bytes that wait for a disk with room
CLOSING = 5.0  # s that the end of a job waits for it


class JournalFile:
    """Appends. write() hands records to a thread of its own and waits until the system has them, so
    that they survive a killed process; but never longer than TAKEN, for a disk may hang while the
    machine moves. Another thread puts them on the disk every SYNC seconds, because an fsync may
    take longer than the controller's buffer lasts. A journal that stood there before is kept as
    .old.

    fault: why nothing is written at present (a full disk), or "": the job goes on without, for
    stopping it would spoil the part. The file ends with a whole record then, and what came since is
    written when there is room again.
    """

    def __init__(self, path: Path, head: bytes):
        self.fault = ""
        if path.exists() and not path.is_file():
            raise UsageError(f"the journal {path} is no file", "--journal FILE, or --no-journal")
        try:
            if path.exists():
                os.replace(path, path.with_name(path.name + ".old"))
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_EXCL, 0o644)
            os.write(self._file, head)
            os.fsync(self._file)
        except OSError as error:
            raise UsageError(
                f"the journal {path} can not be written: {error.strerror}",
                "--journal FILE, or --no-journal",
            ) from None
        self._size = len(head)
        self._waiting = bytearray()
        self._dirty = self._lost = False
        self._news = threading.Condition()
        self._closing = threading.Event()
        self._threads = [
            threading.Thread(target=run, daemon=True) for run in (self._write, self._sync)
        ]
        for thread in self._threads:
            thread.start()

    def write(self, data: bytes) -> None:
        """Take whole records."""
        if not data or self._lost:
            return
        with self._news:
            self._waiting += data
            self._lost = len(self._waiting) > MOST
            self._news.notify_all()
            if not self.fault:
                self._news.wait_for(lambda: not self._waiting, TAKEN)

    def close(self) -> None:
        """All of it is on the disk when this returns, unless there is a fault, or the disk hangs
        for CLOSING seconds."""
        self._closing.set()
        with self._news:
            self._news.notify_all()
        for thread in self._threads:
            thread.join(CLOSING)
        if not any(thread.is_alive() for thread in self._threads):
            os.close(self._file)

    def _write(self) -> None:
        """The one thread that writes."""
        while not (self._closing.is_set() and (self.fault or not self._waiting)):
            with self._news:
                self._news.wait_for(lambda: self._waiting or self._closing.is_set(), SYNC)
                data = bytes(self._waiting)
            n = self._append(data) if data else 0
            with self._news:
                del self._waiting[:n]
                self._news.notify_all()
            if self.fault:
                self._closing.wait(SYNC)

    def _append(self, data: bytes) -> int:
        """Write whole records; how many bytes of them are in the file now."""
        done = 0
        try:
            while done < len(data):
                done += os.write(self._file, data[done:])
            self.fault = ""
        except OSError as error:
            self.fault = error.strerror or str(error)
            # back to the last whole record: half of one would be no line of a journal
            done = data.rfind(b"\n", 0, done) + 1
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self._size + done)
        self._size += done
        self._dirty = self._dirty or done > 0
        return done

    def _sync(self) -> None:
        closing = False
        while not closing:
            closing = self._closing.wait(SYNC)
            if closing:
                self._threads[0].join(CLOSING)
            if not self._dirty:
                continue
            self._dirty = False
            try:
                os.fsync(self._file)
            except OSError as error:
                self.fault = error.strerror or str(error)
