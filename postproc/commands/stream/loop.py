"""The clock and the loop: bytes between port and sender, signals and keys to it, its log to journal and recording."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator

from postproc.commands.stream.journal_file import JournalFile
from postproc.commands.stream.port import Lost, Port
from postproc.commands.stream.prefetch import Prefetch
from postproc.commands.stream.show import Show
from postproc.errors import UsageError
from postproc.streaming import endings
from postproc.streaming import journal as journals
from postproc.streaming.events import Status
from postproc.streaming.greeting import Greeting
from postproc.streaming.lines import WireLine
from postproc.streaming.outcome import Outcome
from postproc.streaming.protocols import UNLIMITED
from postproc.streaming.sender import HELD, Sender
from postproc.streaming.trace import Trace

WAIT = 0.02  # s at most between two looks at signals and clock
HUNGRY = 0.002  # s while lines are missing
QUEUE = 256  # lines that the sender has ready
TERM_HOLD = 2.0  # s from SIGTERM's hold to its stop


def greet(port: Port, greeting: Greeting) -> None:
    """Carry the talk before the job. Raises what it found wrong, and UsageError where the port goes away."""
    try:
        while not greeting.done and greeting.fault is None:
            now = time.monotonic()
            greeting.tick(now)
            data = greeting.bytes_out()
            while data:
                data = data[port.write(data) :]
            greeting.receive(port.read(WAIT), time.monotonic())
    except Lost as error:
        raise UsageError(f"the port {port.url} was closed: {error}", "is the controller still plugged in?") from None
    if greeting.fault:
        raise greeting.fault


class Signals:
    """Ctrl-C, SIGTERM and SIGUSR1 as counts, while a job runs."""

    def __init__(self) -> None:
        self.presses = self.terms = self.resumes = 0

    @contextlib.contextmanager
    def caught(self) -> Iterator[Signals]:
        def on(name: str) -> Callable:
            def handler(number, frame) -> None:
                setattr(self, name, getattr(self, name) + 1)

            return handler

        wanted = {"SIGINT": "presses", "SIGTERM": "terms", "SIGUSR1": "resumes"}
        old = {}
        for name, count in wanted.items():
            number = getattr(signal, name, None)
            if number is not None:
                with contextlib.suppress(ValueError):
                    old[number] = signal.signal(number, on(count))
        try:
            yield self
        finally:
            for number, handler in old.items():
                signal.signal(number, handler)


class Run:
    """One job to its outcome."""

    def __init__(
        self, port: Port, sender: Sender, prefetch: Prefetch, show: Show, journal: JournalFile | None = None,
        trace: Trace | None = None, record=None, keys: bool = False,
    ):  # fmt: skip
        self.port, self.sender, self.prefetch, self.show = port, sender, prefetch, show
        self.journal, self.trace, self.record, self.keys = journal, trace, record, keys
        self.begun = time.monotonic()
        self._pressed = self._resumed = 0
        self._asked = 0  # refused lines that were shown
        self._term: float | None = None

    def to_the_end(self) -> Outcome:
        sender = self.sender
        with Signals().caught() as signals:
            while sender.outcome is None:
                now = time.monotonic()
                self._feed()
                self._obey(signals, now)
                sender.tick(now)
                self._log(
                    now
                )  # before it is written: after a crash nothing is on the wire that the journal does not say
                try:
                    self._write()
                    hungry = sender.queued < QUEUE // 4 and not self.prefetch.finished
                    dripping = sender.queued and 0 < sender.protocol.release() < UNLIMITED
                    data = self.port.read(0.0 if dripping else HUNGRY if hungry else WAIT)
                except Lost as error:
                    sender.lost(str(error), time.monotonic())
                    data = b""
                now = time.monotonic()
                sender.receive(data, now)
                self._urge()
                self.show(now)
            # The stop that an outcome orders may still have to leave.
            with contextlib.suppress(Lost):
                self._write()
            self._log(time.monotonic())
        if self.journal is not None:
            self.journal.write(journals.end(sender.outcome, time.monotonic() - self.begun))
            self.journal.close()
            self._journal_fault()
        return sender.outcome

    def _feed(self) -> None:
        while self.sender.queued < QUEUE and not self.prefetch.finished:
            lines = self.prefetch.take()
            if not lines:
                break
            self.sender.give(lines)
        if self.prefetch.finished:
            self.sender.end()

    def _write(self) -> None:
        while data := self.sender.bytes_out():
            n = self.port.write(data)
            if n < len(data):
                self.sender.unwritten(data[n:])
                return
            if self.sender.protocol.release() < UNLIMITED:  # few at a time, and look for a stop in between
                self.port.drain()
                return

    def _urge(self) -> None:
        """What can not wait leaves before anything is told: a terminal may stall."""
        with contextlib.suppress(Lost):  # which the next read finds, too
            data = self.sender.urgent_out()
            n = self.port.write(data) if data else 0
            if n < len(data):
                self.sender.unwritten(data[n:])

    def _obey(self, signals: Signals, now: float) -> None:
        """First Ctrl-C holds, the second stops; SIGTERM does both; Enter or SIGUSR1 goes on."""
        while self._pressed < signals.presses:
            self._pressed += 1
            if self.sender.state == HELD:
                self.sender.stop(now)
            else:
                self.sender.hold(now)
                self._urge()
                what = "feed hold" if self.sender.protocol.urgent("hold") else self.sender.protocol.does["hold"]
                self._tell(f"{what}; Ctrl-C again stops the job, Enter (or SIGUSR1) goes on")
        if signals.terms and self._term is None:
            self._term = now
            self.sender.hold(now)
        status = self.sender.status
        if self._term is not None and (
            now - self._term > TERM_HOLD or (status and status.state == "hold" and status.detail == "0")
        ):
            self.sender.stop(now, "stopped by SIGTERM")
        said = self._said()
        if self.sender.asks:
            self._ask(said, now)
            said = None
        if signals.resumes > self._resumed or said is not None:
            self._resumed = signals.resumes
            self.sender.resume(now)
        self._asked = min(self._asked, len(self.sender.asks))

    def _ask(self, said: str | None, now: float) -> None:
        """Show a refused line, and obey the answer. A keyboard that is gone stops the job."""
        for line, words in self.sender.asks[self._asked :]:
            rest = len(self.sender.waiting)
            self._tell(
                f"{endings.fact_of_refusal(line, words)}\n    {endings.behind(rest)}{self.sender.protocol.does['hold']}"
            )
        if len(self.sender.asks) > self._asked or (said is not None and said[:1] not in ("c", "s")):
            self._tell("c and Enter: go on without it; s and Enter: stop here")
        elif said is not None or not self.keys:
            self.sender.decide(said is not None and said[:1] == "c", now)
        self._asked = len(self.sender.asks)

    def _said(self) -> str | None:
        """A line from the keyboard, where there is one; None: nothing was typed."""
        if not self.keys or not select.select([sys.stdin], [], [], 0)[0]:
            return None
        with contextlib.suppress(OSError):  # the terminal was closed
            data = os.read(sys.stdin.fileno(), 1024)
            if data:
                return data.decode("utf-8", "replace").strip().lower()
        self.keys = False
        return None

    @staticmethod
    def _tell(message: str) -> None:
        print(f"gcomp: {message}", file=sys.stderr, flush=True)

    def _log(self, now: float) -> None:
        entries, self.sender.log = self.sender.log, []
        out = []
        for kind, what, t in entries:
            if self.journal is not None:
                out.append(journals.record(kind, what, t - self.begun, self.sender.account.executed))
            if self.trace is not None:
                if kind == "sent" and isinstance(what, WireLine):
                    self.trace.sent(what)
                elif isinstance(what, Status) and what.place:
                    order = self.sender.order
                    place = tuple(what.place[i] for i in order) if order else what.place
                    self.record.write(self.trace.row(place, t - self.begun))
            if kind in ("hold", "resumed"):
                self._tell(str(what))
                self.show.event(kind, str(what))
            if kind == "told" and isinstance(what, str) and "echo" not in what:
                self._tell(f"the controller says: {what}")
        if self.journal is not None:
            self.journal.write(b"".join(out))
            self._journal_fault()

    def _journal_fault(self) -> None:
        """Told once."""
        if self.journal is not None and self.journal.fault:
            self._tell(
                f"the journal can not be written any more: {self.journal.fault}; the job goes on, --resume-from LINE needs none"
            )
            self.journal = None
