"""A case of `proof/strangers` as the tool finds it: its files in a folder, read into one table."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from postproc import recordings
from postproc.diagnose import assembly, plausibility, rows
from postproc.machine.file import read_machine


@contextmanager
def folder(case: Any) -> Iterator[Path]:
    """The files of a case in a folder that lasts for the block."""
    with TemporaryDirectory() as name:
        place = Path(name)
        for path, text in case.files.items():
            (place / path).parent.mkdir(parents=True, exist_ok=True)
            (place / path).write_text(text)
        yield place


def files(place: Path) -> list[Path]:
    """The recordings in the folder of a case."""
    return sorted(place.glob("r*.csv"))


def table(place: Path) -> rows.Rows | None:
    """What the tool reads there; None where it refuses."""
    lenient = recordings.ReadingOptions(strict=False)
    try:
        machine = read_machine(place / "machine")
        read = [
            recordings.read(recordings.Source(p.name, p.read_bytes()), options=lenient)
            for p in files(place)
        ]
        return assembly.of(plausibility.checked(read, machine).recordings, machine)
    except recordings.RecordingError:
        return None
