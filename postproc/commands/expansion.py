"""--expand: the program is read whole, written out as plain blocks, and errors name the line that
was written by hand."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from postproc import intake, ports
from postproc.compensate.splines import WRITE_OUT
from postproc.errors import GcompError, Notice, Place, ProgramError, UsageError
from postproc.nc.codes import IF_IT_IS

if TYPE_CHECKING:
    from postproc.filter import Filter
    from postproc.nc.expand.written import Written

ENDINGS = (
    "", ".ngc", ".nc", ".NC", ".NGC", ".tap", ".TAP", ".spf", ".SPF", ".mpf", ".MPF", ".cnc",
    ".CNC", ".txt", ".TXT", ".SUB", ".sub", ".SSB", ".ssb", ".MIN", ".min",
)  # fmt: skip


def whole(source) -> bytes:
    """The text of a program that is to be written out. Raises UsageError where it is too long."""
    text = source.read(intake.PROGRAM + 1)
    if len(text) > intake.PROGRAM:
        raise UsageError(
            f"a program of more than {intake.PROGRAM:,} bytes is not read whole",
            "without --expand any length passes",
        )
    return text


def written_out(
    filter_: Filter, source, options: argparse.Namespace, keeps: bool = True
) -> Written:
    """The program of the stream, ready to be written out. keeps: drilling cycles stay where their
    holes bend by less than the tolerance of holes. Raises UsageError where its control has nothing
    to write out."""
    text = whole(source)
    here = Path(options.file).parent if options.file not in (None, "-") else Path()
    library = Library([here, *map(Path, options.library)], filter_.notices)
    return of_text(filter_, text, library.text, options, keeps)


def of_text(
    filter_: Filter, text: bytes, library, options: argparse.Namespace, keeps: bool = True
) -> Written:
    """The same for a text, with what finds subprograms."""
    from postproc.nc.checksums import bare
    from postproc.nc.expand import Limits, Program
    from postproc.nc.expand.written import Written
    from postproc.nc.interpreter import Interpreter

    program = Program(
        filter_.name, bare(text) if filter_.dialect.grammar.checksums else text, library
    )
    # The tracker follows everything that is written out; what it can not follow matters only to the
    # filter behind it.
    tracked = Interpreter(filter_.dialect, filter_.setup)
    limits = Limits(options.max_steps, options.max_depth)
    compensator = filter_.compensator
    return Written(
        program, tracked, limits, compensator.keeps if keeps else None, compensator.tolerance
    )


def is_way_out(error: GcompError) -> bool:
    """Whether the error's own advice is to write the program out, and nothing else."""
    return "--expand" in error.advice and IF_IT_IS not in error.advice


def through(filter_: Filter, written: Written, step) -> Iterator[bytes]:
    """The corrected text of the plain blocks, in portions; errors and notices name the program's
    own lines."""
    count = len(filter_.notices)
    try:
        for portion in _portions(written):
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
        # the filter counts lines of the plain text; a person has the program that was written by
        # hand
        filter_.notices[count:] = [
            replace(n, line=written.source(n.line)[0]) if n.line else n
            for n in filter_.notices[count:]
        ]
        # of a block that stays a cycle both tell the same
        known = {notice.code for notice in filter_.notices}
        filter_.notices += [notice for notice in written.notices if notice.code not in known]


def _portions(written: Written) -> Iterator[bytes]:
    """The plain text; what can not be written out is told at the line that was written by hand."""
    try:
        yield from written
    except ProgramError as error:
        place = error.place
        if place is not None and place.line:
            _at(
                error, written, place.line, "" if place.file == written.program.name else place.file
            )
        raise


def _by_source(error: ProgramError, written: Written) -> ProgramError:
    """The same error at the line that was written by hand, and of a B-spline that was not written
    out, why."""
    if error.place is not None and error.place.line:
        line, file = written.source(error.place.line)
        unsure = written.splines.kept.get((file, line))
        if unsure and WRITE_OUT in error.advice:
            why, way = error.message.partition(": ")[2], error.advice.removeprefix(f"{WRITE_OUT}; ")
            error = ProgramError(
                f"a B-spline that is not written out, because {unsure.why}, and not corrected as"
                f" it is, because {why}",
                f"{unsure.out}; {way}",
                error.place,
            )
        _at(error, written, line, file)
    return error


def _at(error: ProgramError, written: Written, line: int, file: str) -> None:
    """Put the error at a line of the program, or of a file that it calls ("": the program). Columns
    stay where the line is the one that was looked at; else the block that was made of it is
    told."""
    assert error.place is not None
    place, own = error.place, written.own_line(line, file)
    name = file or written.program.name
    if own is None or own.rstrip()[: len(place.text.rstrip())] == place.text.rstrip():
        error.place = Place(name, line, place.text, place.start, place.stop)
        return
    error.message += f" (in the block that was written out: {place.text.strip()[:80]})"
    error.args = (error.message,)
    error.place = Place(name, line, own[:1000])


def _paths(folder: Path, name: str) -> Iterator[Path]:
    """Where in a folder a subprogram of this name or number may be, the likeliest first."""
    number = name.zfill(4)
    written = (
        (name, f"O{number}", f"o{number}", number)
        if name.isdigit()
        else (name, name.lower(), name.upper())
    )
    return (folder / (stem + ending) for stem in dict.fromkeys(written) for ending in ENDINGS)


class Library:
    """Subprograms in files: beside the program, then in the folders of --library. `unasked`:
    folders in which is looked, but from which nothing is taken; `left`: whether something would
    have been."""

    def __init__(self, folders: list[Path], notices: list[Notice], unasked: tuple[Path, ...] = ()):
        self.folders, self.notices, self.unasked = folders, notices, unasked
        self.left = False

    def text(self, name: str) -> bytes | None:
        """The text of a subprogram by its name or number, None if there is none. A name with a path
        in it is none."""
        # a program must not name files elsewhere: ../../secret is no subprogram
        if not re.fullmatch(r"[A-Za-z0-9_.-]{1,200}", name) or name.startswith("."):
            return None
        for folder in (*self.folders, *self.unasked):
            path = next((p for p in _paths(folder, name) if p.is_file()), None)
            if path is not None and folder in self.unasked:
                self.left = True
            elif path is not None:
                notice = Notice(f"library {name}", f"subprogram {name} is read from {path}")
                if notice not in self.notices:
                    self.notices.append(notice)
                return ports.read_whole(path, intake.PROGRAM)
        return None
