"""One rule for files that are there already: gcomp replaces what it made and can make again, and
nothing else.

Its own corrected programs, pages, figures, JSON and simulated recordings say in themselves that
they are gcomp's. All else (programs, recordings, machines, tables of a control, hooks) a person has
measured, set up or written: that is written over with --force alone, where a command has it.
"""

from __future__ import annotations

import argparse
import os
import re
from pathlib import Path

from postproc import marks
from postproc.errors import UsageError

CHUNK = 1 << 20
# Options that name one file of a kind, whatever the command.
OPTIONS = {
    "json": marks.JSON,
    "report": marks.PAGE,
    "page": marks.PAGE,
    "figure": marks.FIGURE,
    "residuals": marks.RESIDUALS,
}
PLACES = ("file", "output", "program_out")


def options(asked: argparse.Namespace) -> None:
    """Raises UsageError where an option names a file that gcomp did not make, or two one file."""
    for name, kind in OPTIONS.items() if getattr(asked, "force", False) is not True else ():
        path = getattr(asked, name, None)
        if isinstance(path, str) and path:
            # gcomp stream --report job.json
            result(path, marks.JSON if path.lower().endswith(".json") else kind, "another name")
    _once(asked)


def _once(asked: argparse.Namespace) -> None:
    """What is told of a program goes neither over it nor to one file with something else."""
    seen: set[str] = set()
    for option in (*PLACES, *OPTIONS):
        name = getattr(asked, option, None)
        if not isinstance(name, str) or not name or (name == "-" and option in PLACES):
            continue
        # two names of one file, by a link, are one place
        place = name if name == "-" else os.path.realpath(name)
        if place in seen and option not in PLACES:
            raise UsageError(f"two things are to be written to {name}", "name two files")
        seen.add(place)


def result(path: str | Path, kind: marks.Mark, way: str) -> None:
    """Raises UsageError where a file stands at `path` that is not gcomp's own of this kind. way:
    the way out.

    What is no file (a device, a pipe, -) and what is empty can not be lost."""
    path = Path(path)
    if not path.is_file() or _nothing(path) or _made(path, *kind):
        return
    raise UsageError(f"{path} is there already, and nothing in it says that gcomp made it", way)


def kept(path: str | Path, force: bool, way: str = "--force writes over it") -> None:
    """Raises UsageError where something stands at `path` that can be lost. For what people measure
    and set up."""
    if not force and os.path.lexists(path) and not _nothing(Path(path)):
        raise UsageError(f"{path} is there already", way)


def _nothing(path: Path) -> bool:
    """Whether what stands there holds nothing: standard output, a device, a pipe, an empty file."""
    if str(path) == "-":
        return True
    return path.exists() and not path.is_dir() and not (path.is_file() and path.stat().st_size)


def same(path: str | Path, other: str | Path) -> bool:
    """Whether two names are of one file."""
    try:
        return os.path.samefile(path, other) and Path(path).is_file()
    except OSError:
        return False


def copy(path: str | Path, other: str | Path) -> bool:
    """Whether two files hold the same bytes: then one of them is not lost."""
    if not os.path.exists(path):
        return False
    import filecmp  # a new file needs none of it

    try:
        return filecmp.cmp(path, other, shallow=False)
    except OSError:
        return False


def _made(path: Path, mark: re.Pattern[bytes], within: int) -> bool:
    """Whether the mark stands in the file."""
    seen, rest = 0, b""
    try:
        with open(path, "rb") as file:
            while data := file.read(min(CHUNK, within - seen) if within else CHUNK):
                if mark.search(rest + data):
                    return True
                # a mark may lie across two chunks: the end of one is looked at again with the next
                seen, rest = seen + len(data), data[-marks.LONGEST :]
    except OSError:
        return False
    return False
