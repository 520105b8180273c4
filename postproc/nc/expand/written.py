"""The whole of an expansion: a program in, plain text out in portions, and for every plain line
where it came from."""

from __future__ import annotations

import importlib
from array import array
from collections.abc import Callable, Iterator

from postproc.errors import Notice
from postproc.motions import Motions
from postproc.nc.cycles.scene import CHORD_MM
from postproc.nc.expand import Limits, Line, Program
from postproc.nc.expand.knots_siemens import WORD, KnownKnots
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter

LINES_AT_ONCE = 4000


def lines_of(language: str, program: Program, tracker: Tracker, limits: Limits) -> Iterator[Line]:
    """The plain lines of a program. Raises ProgramError where it can not be run, or runs beyond the
    limits."""
    module = importlib.import_module(f"postproc.nc.expand.{language}")
    lines: Iterator[Line] = module.lines(program, tracker, limits)
    return lines


class Written:
    """A program written out for one dialect and set-up. Iterate over it once; `source(n)` then
    tells of plain line n (from 1) the line and file that it came from. `keeps`: whether a drilling
    cycle's block can stay, by what it drills (None: every one is written out); `tolerance`: mm, by
    which the lines of a spline may leave it."""

    def __init__(
        self,
        program: Program,
        interpreter: Interpreter,
        limits: Limits,
        keeps: Callable[[Motions], bool] | None = None,
        tolerance: float = CHORD_MM,
    ):
        self.program, self.limits, self.keeps, self.tolerance = program, limits, keeps, tolerance
        self.tracker = Tracker(interpreter)
        self.splines = KnownKnots(Tracker(interpreter), tolerance)
        self.notices: list[Notice] = []  # by the lines that were written by hand
        self.newline = b"\r\n" if b"\r\n" in program.text[:10_000] else b"\n"
        # of lines that may be millions: lists of numbers would take several times the memory
        self._sources, self._files = array("L"), array("H")
        self._names: list[str] = [""]
        self._texts: dict[str, list[bytes]] = {}

    def __iter__(self) -> Iterator[bytes]:
        waiting: list[bytes] = []
        for line in self._without_splines():
            self._note(line)
            waiting.append(line.text)
            if len(waiting) >= LINES_AT_ONCE:
                yield self.newline.join(waiting) + self.newline
                waiting.clear()
        if waiting:
            yield self.newline.join(waiting) + (
                self.newline if self.program.text.endswith(b"\n") else b""
            )

    def _without_splines(self) -> Iterator[Line]:
        """The plain lines, in which B-splines whose knots are known are straight lines."""
        if not any(code.word == WORD for code in self.tracker.dialect.codes):
            yield from self._resolved()
            return
        # Splines come last and have a tracker of their own: what is held back until its spline ends
        # has been heard by the other one already.
        splines, word = self.splines, WORD.encode()
        follow = splines.tracker.take
        for line in self._resolved():
            if splines.held or word in line.text.upper():
                yield from splines.take(line)
            else:
                follow(line.text, line)
                yield line
        yield from self.splines.finish()

    def _resolved(self) -> Iterator[Line]:
        """The plain lines without cycles and frames."""
        resolver = Resolver(self.program, self.tracker, keeps=self.keeps, tolerance=self.tolerance)
        resolver.scene.notices = self.notices
        language = self.tracker.dialect.language
        source = (
            lines_of(language, self.program, self.tracker, self.limits)
            if language
            else self._plain()
        )
        for line in source:
            yield from resolver.take(line)
        yield from resolver.finish()

    def _plain(self) -> Iterator[Line]:
        """The lines of a program whose control has no language."""
        for number, text in enumerate(self.program.whole_lines(), 1):
            yield Line(text, number)

    def _note(self, line: Line) -> None:
        if line.file not in self._names:
            self._names.append(line.file)
        self._sources.append(line.source)
        self._files.append(self._names.index(line.file))

    @property
    def lines(self) -> int:
        """Plain lines so far."""
        return len(self._sources)

    def own_line(self, line: int, file: str) -> str | None:
        """A line (from 1) of the program, or of the file that it calls, as it was written by hand;
        None where there is none."""
        if file not in self._texts:
            text = self.program.text
            if file:
                text = self.program.library(file) or self.program.library(file.lstrip("Oo0")) or b""
            self._texts[file] = Program(file, text).lines()
        lines = self._texts[file]
        return lines[line - 1].decode("latin-1") if 0 < line <= len(lines) else None

    def source(self, line: int) -> tuple[int, str]:
        """Line and file ("": the main program) of the plain line with this number."""
        if not 0 < line <= len(self._sources):
            return line, ""
        return self._sources[line - 1], self._names[self._files[line - 1]]
