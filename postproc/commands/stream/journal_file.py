"""The journal on the disk: every record is the system's at once, and on the disk soon after, without the sender waiting for it."""

from __future__ import annotations

import os
import threading
from pathlib import Path

from postproc.errors import UsageError

SYNC = 0.5  # s between two fsync


class JournalFile:
    """Appends. What write() has taken survives a killed process: it is the system's. A thread of its own puts it on the disk
    every SYNC seconds, because an fsync may take longer than the controller's buffer lasts. A journal that stood there before
    is kept as .old.

    fault: why nothing more is written (a full disk), or "": the job goes on without, for stopping it would spoil the part.
    """

    def __init__(self, path: Path, head: bytes):
        self.fault = ""
        try:
            if path.exists():
                os.replace(path, path.with_name(path.name + ".old"))
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_EXCL, 0o644)
            os.write(self._file, head)
            os.fsync(self._file)
        except OSError as error:
            raise UsageError(
                f"the journal {path} can not be written: {error.strerror}", "--journal FILE, or --no-journal"
            ) from None
        self._dirty = False
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._sync, daemon=True)
        self._thread.start()

    def write(self, data: bytes) -> None:
        """Take records. Never waits for the disk."""
        try:
            while data and not self.fault:
                data = data[os.write(self._file, data) :]
                self._dirty = True
        except OSError as error:
            self.fault = error.strerror or str(error)

    def close(self) -> None:
        """All of it is on the disk when this returns, unless there is a fault."""
        self._closing.set()
        self._thread.join()
        os.close(self._file)

    def _sync(self) -> None:
        closing = False
        while not closing:
            closing = self._closing.wait(SYNC)
            if not self._dirty:
                continue
            self._dirty = False
            try:
                os.fsync(self._file)
            except OSError as error:
                self.fault = error.strerror or str(error)
