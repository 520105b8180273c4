"""Tool changes of one job: the lines of the program leg by leg, between them the user's macros and
what the controller says of its zeros."""

from __future__ import annotations

import argparse
import threading
from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from postproc import intake, ports
from postproc.errors import GcompError, Place, ProgramError, UsageError
from postproc.streaming import changes, restart, resumable
from postproc.streaming import live as lives
from postproc.streaming.changes import Longer, Macro
from postproc.streaming.events import Status
from postproc.streaming.lines import Unsendable, WireLine
from postproc.streaming.precheck import M6
from postproc.streaming.protocols import Controller, Protocol
from postproc.streaming.protocols.grbl import Grbl

if TYPE_CHECKING:
    from postproc.commands.stream.job import Job
    from postproc.filter import Filter

CAN_NOT = "the job can not go on behind this tool change"


@dataclass(frozen=True)
class Macros:
    """park: sent before a tool change; touch: behind it."""

    park: Macro
    touch: Macro


def read(options: argparse.Namespace, protocol: Protocol) -> Macros | None:
    """The macros of the options; None: there are none. Raises UsageError, ProgramError."""
    if not (options.park or options.touch_off):
        return None
    if not isinstance(protocol, Grbl):
        raise UsageError(
            "--park and --touch-off are for GRBL and its kin, and this is"
            f" {protocol.controller.name}",
            "leave them out: it gets M6 as it stands, or --tool-change pause",
        )

    def of(path: str | None) -> Macro:
        if not path:
            return Macro()
        return changes.macro(ports.read_whole(Path(path), intake.MACRO), path, protocol.prepare)

    macros = Macros(of(options.park), of(options.touch_off))
    if options.resume_from and any(changes.LONGER in text for _, text in macros.touch.rows):
        raise UsageError(
            f"{options.touch_off} compares each tool with the first one of the job, and of a job"
            " that begins again that is not known",
            "touch off every tool by its own, with G10 L20; or write the rest of the program as one"
            " of its own",
        )
    return macros


class Answers:
    """What the controller says of its zeros in the middle of a job: from the loop, which hears it,
    to whoever prepares lines and waits.

    said: its words, by question."""

    def __init__(self, controller: Controller, letters: tuple[str, ...]):
        self.controller, self.letters = controller, letters
        self.said: dict[bytes, list[str]] = {}
        self._live: lives.Live | None = None
        self._fresh: lives.Live | None = None
        self._fault: GcompError | None = None
        self._texts: list[str] = []
        self._open = self._asked = self._closed = False
        self._news = threading.Condition()

    def expect(self) -> None:
        """Questions will leave."""
        with self._news:
            self._asked, self._live, self.said = True, None, {}

    def hears(self, kind: str, what: object) -> bool:
        """An entry of the sender's log; whether it is part of an answer."""
        if isinstance(what, WireLine) and what.text in changes.QUESTIONS:
            self._open = kind == "sent"
            if kind == "answered":
                self.said[what.text] = self._texts
            self._texts = []
        elif kind == "told" and self._open:
            self._texts.append(str(what))
            return True
        elif (
            isinstance(what, Status)
            and what.state == "idle"
            and self._asked
            and len(self.said) == len(changes.QUESTIONS)
        ):
            self._complete(what)
        return False

    def _complete(self, status: Status) -> None:
        modes = [word for text in self.said[changes.MODES] for word in text[4:].rstrip("]").split()]
        zeros = [
            text
            for text in self.said[changes.ZEROS]
            if text.startswith("[") and not text.startswith("[MSG")
        ]
        heard = replace(self.controller, offsets=zeros, modal=modes)
        with self._news:
            self._asked = False
            try:
                self._live = self._fresh = lives.read(heard, status, self.letters)
            except GcompError as error:
                self._fault = error
            self._news.notify_all()

    def fresh(self) -> lives.Live | None:
        """What was said since the last time."""
        live, self._fresh = self._fresh, None
        return live

    def wait(self) -> lives.Live:
        """Until it has said so. Raises UsageError where the job ends before."""
        with self._news:
            self._news.wait_for(lambda: self._live or self._closed or self._fault)
            if self._fault is not None:
                raise self._fault
            if self._live is None:
                raise UsageError("the job ended in a tool change")
            return self._live

    def close(self) -> None:
        """The job has ended."""
        with self._news:
            self._closed = True
            self._news.notify_all()


def answers(options: argparse.Namespace, job: Job, letters: tuple[str, ...]) -> Answers | None:
    """Who takes what the controller says behind each change; None: it is not asked."""
    if job.macros is None or options.check:
        return None
    return Answers(job.protocol.controller, letters)


def lines(job: Job, answers: Answers | None, bare: bool) -> Iterator[list[WireLine]]:
    """All of a job. answers: of the controller, None: before the job, with the zeros of now. bare:
    without macros and pauses, as in the controller's check mode. Raises ProgramError,
    UsageError."""
    number, begin, live = 1, job.begin, job.live
    preamble: tuple[bytes, ...] | None = tuple(M6.sub(b"M0", x) for x in job.preamble)
    longer = Longer(job.protocol.controller.unit)
    asks = None if bare else answers
    while preamble is not None:
        legs = job.leg(job.fresh(live), begin, preamble, number)
        change, number = yield from _until_change(legs, job, number)
        if change is None:
            return
        if not bare:
            for line in _changed(job, change, number, answers, longer):
                number = line.number + 1
                yield [line]
        live = asks.wait() if asks is not None else live
        begin = change.source + 1
        preamble = _behind(job, job.fresh(live), begin, live)
        if asks is not None and preamble is not None:
            job.look_again(live, begin, preamble)


def _until_change(
    legs: Iterator[list[WireLine]], job: Job, number: int
) -> Generator[list[WireLine], None, tuple[WireLine | None, int]]:
    """What comes before a tool change; returns its line, and the number of the next one."""
    for batch in legs:
        kept, change = _cut(batch, job)
        if kept:
            number = kept[-1].number + 1
            yield kept
        if change is not None:
            return change, number
    return None, number


def _cut(batch: list[WireLine], job: Job) -> tuple[list[WireLine], WireLine | None]:
    """What comes before a tool change, and its line."""
    at = next((i for i, line in enumerate(batch) if line.source and M6.search(line.text)), None)
    if at is None:
        return batch, None
    try:
        text = changes.split(batch[at].text)
    except Unsendable as error:
        place = Place(job.name, batch[at].source, batch[at].text.decode("latin-1"))
        raise ProgramError(error.message, error.advice, place) from None
    return batch[:at], replace(batch[at], text=text)


def _changed(
    job: Job, change: WireLine, number: int, answers: Answers | None, longer: Longer
) -> Iterator[WireLine]:
    """The lines of one tool change."""
    assert job.macros is not None
    for name, row, text in changes.steps(change.text, job.macros.park, job.macros.touch):
        if changes.LONGER in text:
            if answers is not None:
                answers.wait()
            text = longer.put(text, answers.said[changes.ZEROS] if answers is not None else None)
        if text == changes.SYNC and answers is not None:
            answers.expect()
        source = row if name else change.source if text == change.text else 0
        yield WireLine(number, source, 0, text, file=name)
        number += 1


def _behind(job: Job, filter_: Filter, begin: int, live: lives.Live) -> tuple[bytes, ...] | None:
    """The blocks that bring back what is in force and where the tool was, at a line behind a tool
    change; None: nothing comes any more."""
    assert job.copy is not None
    with job.copy.opened() as stream:
        if not any(number >= begin for number, _ in enumerate(stream, 1)):
            return None
    with job.copy.opened() as stream:
        before, rest = restart.read_before(filter_, stream, begin)
    stays = not before.moved
    if not stays:
        resumable.refuse(filter_, rest, begin, CAN_NOT)
    frame = filter_.modal.frame
    z = (
        frame.length[filter_.setup.axes.index("Z")]
        if frame is not None and "Z" in filter_.setup.axes
        else 0
    )
    if abs(z / lives.TICKS_PER_MM - live.length.get("Z", 0.0)) > lives.SAME_MM:
        raise UsageError(
            f"line {begin - 1} changes the tool, and the program has set a tool length before"
            " (G43.1, G49), which is not the new one's",
            "leave tool lengths to --touch-off, and take them out of the program",
        )
    before.loaded = ""
    return tuple(restart.preamble(filter_, before, job.safe(), live.place, stays))
