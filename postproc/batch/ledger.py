"""What is done, line by line in a file beside the results: a run that was stopped goes on where it
was.

One JSON object a line, written when a result stands on the disk. A line that was cut off is a job
that is done again.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from postproc import intake, ports
from postproc.errors import UsageError

NAME = ".gcomp-batch.jsonl"
FORMAT = "gcomp-batch/1"


class Ledger:
    """One run's book, in the folder of results; while it is open no other run may write there.
    Results are named by their path below that folder, so that it may be moved, or named otherwise
    from elsewhere."""

    def __init__(self, folder: Path):
        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self.path = folder, folder / NAME
        self.known: dict[str, dict[str, Any]] = {}
        #     {"result_of": "a.nc", "status": "begun"}
        #     {"format": ..., "result_of": "a.nc", "key": ..., "status": "done", "sha256": ..., ...}
        # Appended only; of one result the last line counts.
        self._file = open(self.path, "ab+")  # noqa: SIM115
        self._lock()
        if self._file.seek(0, os.SEEK_END) > intake.JOURNAL:
            raise UsageError(
                f"{self.path} has more than {intake.JOURNAL:,} bytes", "name another folder"
            )
        self._file.seek(0)
        for line in self._file.read().splitlines():
            try:
                entry = json.loads(line)
                self.known[entry["result_of"]] = entry
            except (ValueError, KeyError, TypeError, RecursionError):
                continue
        self._file.seek(0, os.SEEK_END)
        if self._file.tell():
            self._file.seek(-1, os.SEEK_END)
            if self._file.read(1) != b"\n":  # the last line was cut off
                self._file.write(b"\n")

    def _lock(self) -> None:
        try:
            import fcntl
        # Windows has none; there a second run finds its outputs done or standing
        except ImportError:
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise UsageError(
                f"another gcomp batch is writing to {self.path.parent}",
                "wait for it, or name another folder",
            ) from None

    def done(self, output: str, key: str) -> dict[str, Any] | None:
        """What was told of a job, if it is done: under the same key, and its result stands there as
        it was written."""
        entry = self.known.get(self._name(output))
        if (
            entry is None
            or entry.get("key") != key
            or entry.get("status") != "done"
            or not Path(output).is_file()
        ):
            return None
        # A result that a person has changed since is no result of ours: it is made again.
        same = hashlib.sha256(
            ports.read_whole(Path(output), 4 * intake.PROGRAM)
        ).hexdigest() == entry.get("sha256")
        return entry if same else None

    def wrote(self, output: str) -> bool:
        """Whether a file that stands there is a result of an earlier run, which may be written
        over."""
        return self._name(output) in self.known

    def begin(self, output: str) -> None:
        """Say that a result will come: what stands there when the run is ended before it is told is
        one of this run."""
        self._put({"result_of": self._name(output), "status": "begun"})

    def write(self, key: str, result: dict[str, Any]) -> None:
        """Remember a job; on the disk when this returns."""
        self._put(
            {"format": FORMAT, "result_of": self._name(result["output"]), "key": key, **result}
        )
        os.fsync(self._file.fileno())

    def _name(self, output: str) -> str:
        return os.path.relpath(output, self.folder)

    def _put(self, entry: dict[str, Any]) -> None:
        self.known[entry["result_of"]] = entry
        self._file.write(json.dumps(entry, separators=(",", ":")).encode() + b"\n")
        self._file.flush()

    def close(self) -> None:
        self._file.close()
