"""--expand: the program is read whole, written out as plain blocks, and errors name the line that was written by hand."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from postproc import ports
from postproc.errors import Notice, Place, ProgramError, UsageError

if TYPE_CHECKING:
    from postproc.filter import Filter
    from postproc.nc.expand.written import Written

LARGEST = 100_000_000  # bytes of a program that is read whole
ENDINGS = (
    "",
    ".ngc",
    ".nc",
    ".NC",
    ".NGC",
    ".tap",
    ".TAP",
    ".spf",
    ".SPF",
    ".mpf",
    ".MPF",
    ".cnc",
    ".CNC",
    ".txt",
    ".TXT",
)


def written_out(filter_: Filter, source, options: argparse.Namespace, keeps: bool = True) -> Written:
    """The program of the stream, ready to be written out. keeps: drilling cycles stay where their holes bend by less than
    the tolerance of holes. Raises UsageError where its control has nothing to write out."""
    from postproc.nc.expand import Limits, Program
    from postproc.nc.expand.written import Written
    from postproc.nc.interpreter import Interpreter

    text = source.read(LARGEST + 1)
    if len(text) > LARGEST:
        raise UsageError(
            f"a program of more than {LARGEST:,} bytes is not read whole", "without --expand any length passes"
        )
    here = Path(options.file).parent if options.file not in (None, "-") else Path()
    folders = [here, *map(Path, options.library)]
    program = Program(filter_.name, text, Library(folders, filter_.notices).text)
    # The tracker follows everything that is written out; what it can not follow matters only to the filter behind it.
    tracked, limits = Interpreter(filter_.dialect, filter_.setup), Limits(options.max_steps, options.max_depth)
    compensator = filter_.compensator
    return Written(program, tracked, limits, compensator.keeps if keeps else None, compensator.tolerance)


def through(filter_: Filter, written: Written, step) -> Iterator[bytes]:
    """The corrected text of the plain blocks, in portions; errors and notices name the program's own lines."""
    told = len(filter_.notices)
    try:
        for portion in written:
            try:
                text = filter_.feed(portion)
            except ProgramError as error:
                raise _by_source(error, written) from None
            yield text
            step(len(portion))
        try:
            text = filter_.finish()
        except ProgramError as error:
            raise _by_source(error, written) from None
        yield text
    finally:
        filter_.notices[told:] = [
            replace(n, line=written.source(n.line)[0]) if n.line else n for n in filter_.notices[told:]
        ] + written.notices


def _by_source(error: ProgramError, written: Written) -> ProgramError:
    """The same error at the line that was written by hand."""
    place = error.place
    if place is None or not place.line:
        return error
    line, file = written.source(place.line)
    own = written.program.lines()[line - 1].decode("latin-1") if not file else ""
    if own.rstrip() == place.text.rstrip():
        error.place = Place(place.file, line, place.text, place.start, place.stop)
        return error
    other = ProgramError(
        f"{error.message} (in the block that was written out: {place.text.strip()[:80]})", error.advice,
        Place(file or place.file, line),
    )  # fmt: skip
    other.delivered = error.delivered
    return other


class Library:
    """Subprograms in files: beside the program, then in the folders of --library."""

    def __init__(self, folders: list[Path], notices: list[Notice]):
        self.folders, self.notices = folders, notices

    def text(self, name: str) -> bytes | None:
        """The text of a subprogram by its name or number, None if there is none. A name with a path in it is none."""
        if not re.fullmatch(r"[A-Za-z0-9_.-]{1,200}", name) or name.startswith("."):
            return None
        stems = (
            [name, f"O{name.zfill(4)}", f"o{name.zfill(4)}", name.zfill(4)]
            if name.isdigit()
            else [name, name.lower(), name.upper()]
        )
        for folder in self.folders:
            for stem in dict.fromkeys(stems):
                for ending in ENDINGS:
                    path = folder / (stem + ending)
                    if path.is_file():
                        self.notices.append(Notice(f"library {name}", f"subprogram {name} is read from {path}"))
                        return ports.read_whole(path, LARGEST)
        return None
