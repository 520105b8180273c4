"""One program, tried as it is; where its error's own advice is to write it out, so; and hints,
before they are given.

What is done by itself is what a person would do who reads the advice, and only where that changes
nothing but the length of the program: docs/DESIGN.md.
"""

from __future__ import annotations

import argparse
import copy
import re
from collections.abc import Callable
from dataclasses import field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from postproc import intake, ports
from postproc.commands import expansion, reading
from postproc.errors import GcompError, ProgramError
from postproc.expressions import expression
from postproc.filter import Filter
from postproc.machine.model import Machine
from postproc.records import mutable

if TYPE_CHECKING:
    from postproc.pages.frame import Page
    from postproc.verify import Verifier

# A block that the operator's switch takes out, and that decides which text runs: a call, a jump, a
# loop, an end.
DECIDES = expression(
    rb"^[ \t]*(?:N[ \t]*[0-9]+[ \t]*)?/[^(;\n]*(?:GOTO|IF|WHILE|CALL|REPEAT|RET|M["
    rb" \t]*0*(?:2|17|30|9[789]|198)(?![0-9])|"
    rb"G[ \t]*6[56](?![0-9.])|(?<![A-Z])O[ \t]*[<0-9]|#|(?<![A-Z])R[0-9]+[ \t]*=)",
    re.IGNORECASE | re.MULTILINE,
)


@mutable
class Attempt:
    """One reading of the program. why: that it was written out without being asked for, and why;
    "": it was not."""

    filter: Filter
    verifier: Verifier | None = None
    why: str = ""
    lines: int = 0  # of the plain program, where it was written out
    spool: BinaryIO = field(default_factory=ports.spool)

    @property
    def summary(self) -> str:
        """What was done, in one line."""
        filter_, s = self.filter, self.filter.summary
        if filter_.machine.is_zero:
            return (
                f"{s.lines} lines, {s.motions} motions; the map of {filter_.machine.name} is zero:"
                " nothing to change"
            )
        return (
            f"{s.changed} of {s.motions} motions changed, {s.added} blocks added, largest"
            f" correction {s.largest * 1000:.1f} um, tolerance"
            f" {filter_.compensator.tolerance * 1000:g} um"
        )

    def page(self) -> Page:
        """Of an attempt that was verified, with a trace."""
        from postproc.pages import program

        assert self.verifier is not None
        return program.page(self.filter, self.verifier, self.why)

    @classmethod
    def fresh(
        cls, options: argparse.Namespace, machine: Machine, name: str, head: bytes = b""
    ) -> Attempt:
        """Nothing read yet."""
        filter_ = reading.filter_of(options, machine, head)
        filter_.name = name
        if not options.verify:
            return cls(filter_)
        from postproc.trace import Trace
        from postproc.verify import Verifier

        verifier = Verifier(filter_)
        if getattr(options, "report", None):
            verifier.trace = Trace(machine)
        return cls(filter_, verifier)


@mutable
class Tries:
    """Of one whole program."""

    options: argparse.Namespace
    machine: Machine
    source: ports.Kept
    name: str
    head: bytes
    step: Callable[[int], None]
    left: bool = False  # a file stands beside the program that would have to be read

    def best(self) -> Attempt:
        """Accepted. Raises GcompError with what a person must do, else."""
        try:
            return self._one_run(self.options)
        except ProgramError as error:
            dialect = reading.dialect_of(self.options, self.machine, self.head)
            raise reading.with_hint(error, dialect, self.head, self._tried) from None

    def _tried(self, name: str) -> ProgramError | None:
        """What is wrong with it in another dialect."""
        options = copy.copy(self.options)
        options.dialect, options.verify, self.step = name, False, lambda size: None
        if not self.source.again():
            raise GcompError("a pipe that is too long to be read twice")
        try:
            self._one_run(options).spool.close()
        except ProgramError as error:
            return error
        return None

    def _one_run(self, options: argparse.Namespace) -> Attempt:
        """As it is, or written out. Raises ProgramError."""
        try:
            # options.expand: True as it was asked for, False refuses, None is the rule
            # (docs/DESIGN.md, "a program that nothing else corrects is written out")
            return self._attempt(options, bool(options.expand))
        except ProgramError as error:
            if options.expand is not None or options.in_place or not expansion.is_way_out(error):
                raise
            # A pipe is read once; and text behind / runs or not as the operator's switch stands, so
            # that one writing out would be wrong for the other state.
            if not self.source.again() or not self._alone:
                raise
            first = error
        try:
            done = self._attempt(options, True)
        except ProgramError:
            if self.left:
                raise first from None  # with --expand a file beside it is read
            raise
        where = f"line {first.place.line}: " if first.place else ""
        done.why = (
            f"written out as plain blocks, {done.lines:,} lines, because nothing else corrects it"
            f" ({where}{first.message}); --no-expand: refuse it"
        )
        return done

    @cached_property
    def _alone(self) -> bool:
        """Whether nobody decides at the machine which of its text runs."""
        if self.options.block_delete is not None:
            return True
        found = DECIDES.search(self.source.read(intake.PROGRAM))
        return self.source.again() and found is None

    def _attempt(self, options: argparse.Namespace, expand: bool) -> Attempt:
        done = Attempt.fresh(options, self.machine, self.name, self.head)
        try:
            if expand:
                self._written_out(done, options)
            else:
                for data in ports.chunks(self.source, live=False):
                    done.spool.write(done.filter.feed(data))
                    self.step(len(data))
                done.spool.write(done.filter.finish())
            _keeps_its_tolerance(done)
        except BaseException:
            done.spool.close()
            raise
        return done

    def _written_out(self, done: Attempt, options: argparse.Namespace) -> None:
        if options.expand:
            written = expansion.written_out(done.filter, self.source, options)
        else:
            # Not asked for: no text is taken that was not named.
            here = Path(options.file).parent if options.file not in (None, "-") else Path()
            library = expansion.Library([*map(Path, options.library)], done.filter.notices, (here,))
            text = self.source.read(intake.PROGRAM)
            written = expansion.of_text(done.filter, text, self._watched(library), options)
        if done.verifier:
            done.verifier.source = written.source
        for data in expansion.through(done.filter, written, self.step):
            done.spool.write(data)
        done.lines = written.lines

    def _watched(self, library: expansion.Library) -> Callable[[str], bytes | None]:
        def text(name: str) -> bytes | None:
            found = library.text(name)
            self.left |= library.left
            return found

        return text


def _keeps_its_tolerance(done: Attempt) -> None:
    """Raises GcompError where the verifier finds that the output does not."""
    verifier = done.verifier
    if not verifier or verifier.passed:
        return
    if verifier.at_line(n.line for n in done.filter.notices if n.code == "unled"):
        raise GcompError(
            f"a thread begins where nothing was corrected before it: {verifier.report()}",
            "nothing was written; write a motion to the start of the thread before it",
        )
    if verifier.in_thread and any(n.code == "turned" for n in done.filter.notices):
        raise GcompError(
            f"an axis turns back where a thread begins: {verifier.report()}",
            "nothing was written; let each axis go on in its direction there, or begin the thread"
            " anew behind a rapid",
        )
    raise GcompError(
        f"verification failed: {verifier.report()}",
        "nothing was written; this is an error of gcomp: please report the program",
    )
