"""From options and a controller that has answered to what shall be sent: filter, lines, checks
before the first byte."""

from __future__ import annotations

import argparse
import contextlib
import copy as copies
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from postproc import intake, ports
from postproc.commands import expansion, reading
from postproc.commands.stream import tools
from postproc.errors import Notice, ProgramError, UsageError
from postproc.streaming import journal as journals
from postproc.streaming import live as lives
from postproc.streaming import restart, resumable, zero
from postproc.streaming.compact import Compact
from postproc.streaming.lines import WireLine
from postproc.streaming.pace import Pace
from postproc.streaming.precheck import NOTHING, REFUSE, Precheck, tool_change
from postproc.streaming.protocols import Protocol
from postproc.streaming.protocols.grbl import Grbl
from postproc.streaming.source import RAPID_MM_MIN, Source
from postproc.streaming.trace import CHORD

if TYPE_CHECKING:
    from postproc.commands.stream.tools import Macros
    from postproc.filter import Filter
    from postproc.machine.model import Machine

CHUNK = 1 << 13  # bytes of the program at a time: small, so that little is ahead of the link
CHORD_SEEN = 0.005  # mm
NO_AXIS = 1000  # of which no setting tells


def is_file(path: str | None) -> bool:
    """Whether the program can be read twice."""
    return path not in (None, "-") and Path(str(path)).is_file()


@dataclass
class Job:
    """What was asked for, with the filter's maker. begin: the source line to begin with; preamble:
    blocks before it; copy: the program as it was at first, None of a pipe; whole: its text, where
    it is written out; library: texts of its subprograms. macros: of its tool changes. start: axis
    to mm, where the machine stood when the program began, as far as that is known."""

    options: argparse.Namespace
    fresh: Callable[..., Filter]
    protocol: Protocol
    live: lives.Live
    notices: list[Notice]
    name: str
    begin: int = 1
    preamble: tuple[bytes, ...] = ()
    copy: ports.Copy | None = None
    whole: bytes | None = None
    library: dict[str, bytes | None] = field(default_factory=dict)
    macros: Macros | None = None
    sources: list[Source] = field(default_factory=list)
    known: Precheck | None = None
    pace: Pace | None = None
    start: dict[str, float] = field(default_factory=dict)

    def as_begun(self, live: lives.Live, start: dict[str, float]) -> Filter:
        """A filter that reads the program from its beginning, with the zeros of `live`. An axis
        that the program does not name stands at `start`, and not where it was jogged or parked
        since."""
        return self.fresh(replace(live, place=start))

    def leg(
        self, filter_: Filter, begin: int, preamble: tuple[bytes, ...], number: int = 1
    ) -> Iterator[list[WireLine]]:
        """Wire lines from a source line on. number: of the first."""
        absolute = "G90" in self.live.modal
        shorten = Compact(absolute, "G94" in self.live.modal).line if self.options.compact else None
        how = "" if self.macros is not None else self.changes()
        prepare = tool_change(how, self.protocol.prepare) if how else self.protocol.prepare
        source = Source(filter_, prepare, shorten, self._rapid(), sampled=self._sampled())
        source.number = number
        self.sources.append(source)
        if preamble:
            yield [
                replace(line, source=0)
                for line in source.feed(b"".join(x + b"\n" for x in preamble))
            ]
        if self.whole is not None:
            from postproc.commands.stream import expanded

            yield from expanded.lines(source, self.whole, self.options, self.library)
            return
        # lines are counted on from there, so that errors and the journal name the program's own
        filter_.summary.lines = begin - 1
        try:
            for data in self._text(begin):
                yield source.feed(data)
            yield source.finish()
        except ProgramError:
            # what came before the faulty block is good, and has its place before the error
            yield source.delivered
            raise

    def changes(self) -> str:
        """What becomes of M6: as was said, else refused by GRBL itself, which has none; "": it is
        sent."""
        return self.options.tool_change or (REFUSE if self.is_grbl else "")

    @property
    def is_grbl(self) -> bool:
        """Whether it is GRBL itself, and no relative."""
        return isinstance(self.protocol, Grbl) and type(self.protocol) is Grbl

    def _sampled(self) -> float:
        """mm by which an arc's chords may miss it: of a recording, of the watch over the path."""
        return CHORD if self.options.record else CHORD_SEEN if self.watched() else 0.0

    def watched(self) -> bool:
        """Whether reports tell that the machine leaves the path."""
        o = self.options
        return getattr(self.protocol, "exact", False) and not (
            o.check or o.control_compensates or o.no_watch
        )

    def _rapid(self) -> float:
        """mm/min of rapids, as the controller's settings say ($110 and on in GRBL and its kin)."""
        rates = [self.protocol.controller.setting(110 + i) for i in range(3)]
        return min((rate for rate in rates if rate > 0), default=RAPID_MM_MIN)

    def _text(self, begin: int) -> Iterator[bytes]:
        if self.copy is None:
            with ports.opened(self.options.file) as (stream, _, _):
                yield from ports.chunks(stream, live=True)
            return
        skip = begin - 1
        with self.copy.opened() as stream:
            for _ in range(skip):
                stream.readline()
            while data := stream.read(CHUNK):
                yield data

    @property
    def letters(self) -> tuple[str, ...]:
        """The machine's axes."""
        return tuple(self.fresh().setup.axes)

    def order(self) -> tuple[int, ...]:
        """Where each axis stands in the controller's settings. A printer's E is none of the axes of
        which they tell."""
        return tuple(
            lives.CONTROLLER_AXES.index(x) if x in lives.CONTROLLER_AXES else NO_AXIS
            for x in self.letters
        )

    def safe(self) -> dict[str, float]:
        """mm, machine coordinates: where the user says that the tool is clear of the part."""
        options = self.options
        return {x: v for x, v in (("Z", options.safe_z), ("X", options.safe_x)) if v is not None}

    def checks(self, sent: str = NOTHING) -> Precheck:
        """What each line is checked for before the first byte leaves."""
        controller, order = self.protocol.controller, self.order()
        return Precheck(controller, self.letters, order, self.name, self.is_grbl, sent)


def prepare(
    options: argparse.Namespace,
    machine: Machine,
    protocol: Protocol,
    live: lives.Live,
    copy: ports.Copy | None,
) -> Job:
    """The job, with the controller's zeros in the filter. Raises UsageError where they are not the
    stated ones."""
    from postproc.filter import Filter

    base = reading.filter_of(options, machine, copy.head() if copy else b"")
    explicit = {name for name, _ in options.offset}
    assumed = base.machine.offsets
    # Offsets that were said (--offset, files) must be the controller's own, or the job is refused;
    # those that machine.toml assumes give way to the controller's, with a notice.
    stated = {n: p for n, p in base.setup.offsets.items() if n in explicit or assumed.get(n) != p}
    lives.conflicts(live, stated, options.start)
    offsets, notices = lives.merged(live, {n: p for n, p in assumed.items() if n not in stated})
    setup = replace(base.setup, offsets={**stated, **offsets})
    name = options.file if is_file(options.file) else "<stdin>"

    def fresh(now: lives.Live = live) -> Filter:
        """now: with zeros that were set in the middle of the job."""
        zeros = setup if now is live else replace(setup, offsets={**setup.offsets, **now.work})
        filter_ = Filter(base.machine, base.dialect, zeros, base.options, name, heat=base.heat)
        lives.stand(filter_, now)
        return filter_

    if options.compact and not getattr(protocol, "modal", False):
        raise UsageError(
            f"--compact leaves out points and words that hold in RS274/NGC, and"
            f" {protocol.controller.name} may read the rest otherwise (X10. without its point)",
            "leave --compact out",
        )
    macros = tools.read(options, protocol)
    job = Job(
        options, fresh, protocol, live, [*base.notices, *notices], name, copy=copy, macros=macros,
        start=live.place,
    )  # fmt: skip
    if options.expand:
        job.whole = _whole(options, copy)
    return job


def _whole(options: argparse.Namespace, copy: ports.Copy | None) -> bytes:
    with copy.opened() if copy else _piped(options.file) as stream:
        return expansion.whole(stream)


@contextlib.contextmanager
def _piped(path: str | None) -> Iterator[BinaryIO]:
    with ports.opened(path) as (stream, _, _):
        yield stream


def resumed(
    options: argparse.Namespace, machine: Machine, copy: ports.Copy
) -> tuple[int, journals.Past | None]:
    """The source line that --resume-from names, by number or by a journal, and what the journal
    says; None: there is none of this program. Raises UsageError."""
    text = options.resume_from
    if text.isdigit():
        if int(text) < 1:
            raise UsageError("--resume-from counts lines from 1")
        return int(text), _past_of(options, copy)
    past = journals.read(ports.read_whole(Path(text), intake.JOURNAL), text)
    if past.head.get("sha256") != copy.digest:
        raise UsageError(
            f"{text} is the journal of another program, or {options.file} was changed since",
            "name the line by its number if you are sure",
        )
    if past.head.get("map") != machine.digest:
        raise UsageError(
            f"{text} was written with another map of {machine.name}",
            "the part would get a step; name the line by its number if you are sure",
        )
    if past.head.get("expanded"):
        raise UsageError(
            f"{text} is the journal of a program that was written out: its lines may have been"
            " executed more than once",
            "write it out first (gcomp --expand -o plain.nc), find the place there, and begin with"
            " that line",
        )
    if past.outcome == "done":
        raise UsageError(f"{text} says that the job was done", "there is nothing to resume")
    return past.certain, past


def _past_of(options: argparse.Namespace, copy: ports.Copy) -> journals.Past | None:
    """The journal that lies where this job's would, if it is one of this program."""
    place = journal_path(options)
    if place is None or not place.exists():
        return None
    try:
        past = journals.read(ports.read_whole(place, intake.JOURNAL), str(place))
    except UsageError:
        return None
    return past if past.head.get("sha256") == copy.digest else None


def zero_done(options: argparse.Namespace) -> str:
    """What was done in this session for the machine's zero."""
    return zero.HOMED if options.home else zero.UNLOCKED if options.unlock else ""


def zero_is_certain(job: Job, line: int, past: journals.Past | None, restarted: bool) -> int:
    """The line to begin with, which may be a later one where the controller still stands where the
    job stopped. Raises UsageError where the zero may not be where the job had it, and nobody says
    that it was looked after."""
    if job.options.zero_is_right:
        return line
    letters, controller = job.fresh().machine.letters, job.protocol.controller
    zero.refuse(
        zero.zero_lost(past, job.live, letters, controller, restarted, zero_done(job.options)),
        controller,
    )
    if past is None or zero_done(job.options) or job.options.resume_from.isdigit():
        return line
    return zero.certain(past, job.live, letters, controller)


def _began(past: journals.Past | None, letters: tuple[str, ...]) -> dict[str, float]:
    """Axis to mm: where the machine stood when the program began, by the journal of a job that
    began with its first line."""
    if past is None or past.head["begin"] != 1:
        return {}
    return {x: v for x, v in zip(letters, past.place, strict=False) if v is not None}


def restarted(job: Job, line: int, past: journals.Past | None = None) -> None:
    """Let the job begin with a line: the blocks that bring back what is in force are shown, and
    agreed to. past: what its journal says. Raises."""
    options = job.options
    if line > 1:
        job.start = _began(past, job.letters)
        filter_ = job.as_begun(job.live, job.start)
        assert job.copy is not None
        with job.copy.opened() as stream:
            before, rest = restart.read_before(filter_, stream, line)
        resumable.refuse(filter_, rest, line)
        job.preamble = tuple(restart.preamble(filter_, before, job.safe(), job.live.place))
    job.begin = line
    shown = "".join(f"\n    {x.decode()}" for x in job.preamble)
    ahead = (
        f"; sent before it:{shown}" if shown else ", the whole program: nothing is sent before it"
    )
    print(f"gcomp: beginning again with line {line}{ahead}", file=sys.stderr)
    if options.yes:
        return
    if sys.stdin is None or not sys.stdin.isatty():
        raise UsageError(
            "nothing was sent: there is no terminal to ask at", "look at it, then say --yes"
        )
    print("gcomp: send this? [y/N] ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() not in ("y", "yes"):
        raise UsageError("nothing was sent")


def with_hint(error: ProgramError, job: Job) -> ProgramError:
    """The error, with the control that the program looks written for."""
    whole = job.copy
    if whole is None:
        return error

    def tried(name: str) -> ProgramError | None:
        options, mine = copies.copy(job.options), job.fresh()
        options.dialect = name
        other = reading.filter_of(options, mine.machine)
        setup = replace(other.setup, offsets=mine.setup.offsets)
        filter_ = type(mine)(
            other.machine, other.dialect, setup, other.options, mine.name, heat=other.heat
        )
        lives.stand(filter_, job.live)
        with whole.opened() as stream:
            try:
                if options.expand:
                    written = expansion.written_out(filter_, stream, options)
                    for _ in expansion.through(filter_, written, lambda size: None):
                        pass
                else:
                    for data in ports.chunks(stream, live=False):
                        filter_.feed(data)
                    filter_.finish()
            except ProgramError as wrong:
                return wrong
        return None

    return reading.with_hint(error, job.fresh().dialect, whole.head(), tried)


def journal_path(options: argparse.Namespace) -> Path | None:
    """Where the journal goes: --journal, else beside the program's name in the working folder."""
    if options.no_journal:
        return None
    if options.journal:
        return Path(options.journal)
    return (
        Path(os.path.basename(options.file) + ".journal")
        if is_file(options.file)
        else Path("stream.journal")
    )
