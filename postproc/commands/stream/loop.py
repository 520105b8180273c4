"""The clock and the loop: bytes between port and sender, signals and keys to it, its log to
journal, recording and outlets.

Nothing here waits for anybody but the port: what is told, kept and recorded has threads of its own.
"""

from __future__ import annotations

import contextlib
import math
import time
import traceback
from dataclasses import replace

from postproc.commands.stream import keys as keyboard
from postproc.commands.stream.journal_file import JournalFile
from postproc.commands.stream.keys import Keys
from postproc.commands.stream.outlets import Outlet
from postproc.commands.stream.port import Lost, Port
from postproc.commands.stream.prefetch import Prefetch
from postproc.commands.stream.show import Show
from postproc.commands.stream.signals import Interrupted, Signals
from postproc.commands.stream.tools import Answers
from postproc.errors import UsageError
from postproc.heat.log import LogError
from postproc.streaming import endings
from postproc.streaming import journal as journals
from postproc.streaming import outcome as ends
from postproc.streaming.events import Status
from postproc.streaming.greeting import Greeting
from postproc.streaming.lines import WireLine
from postproc.streaming.orders import Order
from postproc.streaming.outcome import Outcome
from postproc.streaming.protocols import UNLIMITED
from postproc.streaming.sender import Sender
from postproc.streaming.trace import Trace

WAIT = 0.02  # s at most between two looks at signals and clock
HUNGRY = 0.002  # s while lines are missing
QUEUE = 256  # lines that the sender has ready
# s from a hold to the stop behind it, where the controller does not say that it stands
STANDS = 2.0
RELEASE = "gcomp control resume releases it"
CHECK_WORDS = {"[MSG:Enabled]", "[MSG:Disabled]", "[MSG:Pgm End]"}
CLOSED = "the reader of standard output is gone: the pipe was closed"


def interrupt(port: Port, greeting: Greeting, name: str) -> None:
    """Somebody stops gcomp before the job: hold at once; homing ends by a reset alone (GRBL's
    limits.c looks at nothing else). Raises Interrupted."""
    protocol = greeting.protocol
    hold = protocol.urgent("hold") if protocol else b""
    stop = protocol.urgent("stop") if protocol and greeting.moves else b""
    with contextlib.suppress(Lost):
        for data in (hold, stop):
            port.write(data)
    if stop:
        raise Interrupted(
            f"interrupted ({name}) while the machine was homing: it was told to hold and to stop;"
            " home it again"
        )
    does = f"; the controller was told to hold: {RELEASE}" if hold else ""
    raise Interrupted(f"interrupted ({name}): nothing of the program was sent{does}")


def carry(port: Port, talk: Greeting | Order, longest: float = math.inf) -> None:
    """Carry bytes until a talk is done or has a fault. Raises UsageError where the port goes away,
    or after `longest` s."""
    started = time.monotonic()
    try:
        while not talk.done and not talk.fault:
            now = time.monotonic()
            talk.tick(now)
            data = talk.bytes_out()
            while data:
                data = data[port.write(data) :]
            talk.receive(port.read(WAIT), time.monotonic())
            if now - started > longest:
                raise UsageError(
                    f"the controller has not finished within {longest:g} s", "look at the machine"
                )
    except Lost as error:
        still = " nothing that moves it was sent" * isinstance(talk, Greeting)
        raise UsageError(
            f"the port {port.url} was closed: {error}",
            f"is the controller still plugged in?{still}",
        ) from None


def greet(port: Port, greeting: Greeting) -> None:
    """Carry the talk before the job. Raises what it found wrong, and as `carry`."""
    carry(port, greeting)
    if greeting.fault:
        raise greeting.fault


class Run:
    """One job to its outcome. keys: a person's; record: where the trace is written; answers: who
    waits for what the controller says."""

    def __init__(
        self,
        port: Port,
        sender: Sender,
        prefetch: Prefetch,
        show: Show,
        signals: Signals,
        journal: JournalFile | None = None,
        trace: Trace | None = None,
        record: Outlet | None = None,
        keys: Keys | None = None,
        answers: Answers | None = None,
    ):
        self.answers = answers
        self.port = port
        self.sender = sender
        self.prefetch = prefetch
        self.show = show
        self.signals = signals
        self.journal, self.trace, self.record, self.keys = journal, trace, record, keys
        self.started = time.monotonic()
        self._pressed = signals.presses
        self._resumed = signals.resumes
        self._stopped = signals.holds
        self._asked = 0  # refused lines that were shown
        # why the job ends when the machine stands, and since when
        self._ending: tuple[str, float] | None = None
        self._closed = False
        self._faults: set[str] = set()

    def to_the_end(self) -> Outcome:
        with self.keys or contextlib.nullcontext():
            try:
                while self.sender.outcome is None:
                    self._turn()
            # whatever it is, the machine must not run on with nobody at its wire
            except BaseException as error:
                self._failed(error)
        assert self.sender.outcome is not None
        # The stop that an outcome orders may still have to leave.
        with contextlib.suppress(Lost):
            self._write()
        self._log()
        if self.journal is not None:
            outcome, fault = self.sender.outcome, self.prefetch.fault
            if fault is not None and outcome.kind in (ends.DONE, ends.SENT):  # of what there was
                outcome = replace(
                    outcome,
                    kind=ends.ERROR,
                    message=f"the program ended there, because of: {fault}",
                )
            self.journal.write(journals.end(outcome, time.monotonic() - self.started))
            self.journal.close()
            self._fault("journal", self.journal.fault)
        return self.sender.outcome

    def _turn(self) -> None:
        """One look at signals, keys, clock and port."""
        sender = self.sender
        now = time.monotonic()
        self._obey(now)
        self._urge()
        self._feed()
        sender.tick(now)
        self._urge()
        # before it is written: after a crash nothing is on the wire that the journal does not say
        self._log()
        try:
            self._write()
            hungry = sender.queued < QUEUE // 4 and not self.prefetch.finished and not sender.held
            dripping = sender.queued and 0 < sender.protocol.release() < UNLIMITED
            data = self.port.read(0.0 if dripping else HUNGRY if hungry else WAIT)
        except Lost as error:
            sender.lost(str(error), time.monotonic())
            data = b""
        now = time.monotonic()
        sender.receive(data, now)
        self._urge()
        self.show(now)

    def _failed(self, error: BaseException) -> None:
        """gcomp itself has failed: hold first, then everything else."""
        protocol = self.sender.protocol
        with contextlib.suppress(Lost):
            self.port.write(protocol.urgent("hold"))
        for line in traceback.format_exception(error)[-3:]:
            self.show.tell(line.rstrip())
        self.sender.outcome = endings.failed(error, self.sender.waiting, protocol)

    def _feed(self) -> None:
        while self.sender.queued < QUEUE and not self.prefetch.finished:
            lines = self.prefetch.take()
            if not lines:
                break
            self.sender.give(lines)
        fault = self.prefetch.fault
        if isinstance(fault, LogError):  # what was prepared by it is not to be cut either
            self.sender.give_up(str(fault), time.monotonic())
        elif self.prefetch.finished:
            self.sender.end()

    def _write(self) -> None:
        while data := self.sender.bytes_out():
            n = self.port.write(data)
            if n < len(data):
                self.sender.unwritten(data[n:])
                return
            # few at a time, and look for a stop in between
            if self.sender.protocol.release() < UNLIMITED:
                self.port.drain()
                return

    def _urge(self) -> None:
        """What can not wait leaves before anything is told or kept."""
        with contextlib.suppress(Lost):  # which the next read finds, too
            data = self.sender.urgent_out()
            n = self.port.write(data) if data else 0
            if n < len(data):
                self.sender.unwritten(data[n:])

    # -- what a person, or the system, wants -------------------------------------------------------

    def _obey(self, now: float) -> None:
        """First Ctrl-C holds, the second stops; Ctrl-Z holds; SIGTERM, SIGHUP and a closed pipe
        hold, then stop."""
        signals = self.signals
        while self._pressed < signals.presses:
            self._pressed += 1
            if self.sender.held:
                self.sender.stop(now)
            else:
                self._hold(now)
        if self._stopped < signals.holds:
            self._stopped = signals.holds
            self._hold(now)
        if signals.ends and self._ending is None:
            self._end(f"stopped by {signals.ends}", now)
        if not self._closed and self.show.unread():
            self._closed = True
            self._when_closed(now)
        self._when_still(now)
        self._obey_keys(now)
        if signals.resumes > self._resumed:
            self._resumed = signals.resumes
            self.sender.resume(now)
        self._asked = min(self._asked, len(self.sender.asks))

    def _hold(self, now: float) -> None:
        """Hold the feed, and say what can be done then."""
        self.sender.hold(now)
        self._urge()
        does = self.sender.protocol
        what = "feed hold" if does.urgent("hold") else does.does["hold"]
        how = (
            f"{keyboard.IN_HOLD}; {keyboard.OVER}"
            if self.keys
            else "Ctrl-C again stops the job, SIGUSR1 goes on"
        )
        self.show.tell(f"{what}; {how}")

    def _end(self, why: str, now: float) -> None:
        """Hold, and stop when the machine stands."""
        self._ending = (why, now)
        if not self.sender.held:
            self.sender.hold(now)
            self._urge()

    def _when_closed(self, now: float) -> None:
        """The program that read the job's events is gone: nobody watches any more."""
        if self.keys:
            self._hold(now)
            self.show.tell(CLOSED)
        elif self._ending is None:
            self._end(CLOSED, now)

    def _when_still(self, now: float) -> None:
        if self._ending is None:
            return
        why, since = self._ending
        status = self.sender.status
        # A reset while it moves would lose steps; Hold:0 says that it stands.
        if now - since > STANDS or (status and status.state == "hold" and status.detail == "0"):
            self.sender.stop(now, why)

    def _obey_keys(self, now: float) -> None:
        pressed = self.keys.pressed() if self.keys else None
        if pressed is None:
            self.keys = None
        if self.sender.asks:
            self._ask(pressed, now)
            return
        for key in pressed or "":
            self._key(key, now)

    def _key(self, key: str, now: float) -> None:
        """One key. What was typed by mistake does nothing."""
        sender = self.sender
        if key in keyboard.OVERRIDES:
            what = keyboard.OVERRIDES[key]
            self.show.tell(
                f"override: {what}"
                if sender.override(what)
                else "this controller takes no such override"
            )
        elif key == keyboard.RESET:
            sender.stop(now, "reset by the user")
        elif not sender.held:
            if key in (keyboard.HOLD, " "):
                self._hold(now)
            elif key == keyboard.HELP:
                self.show.tell(f"h holds the feed, x resets at once; {keyboard.OVER}")
        elif key == keyboard.RESUME:
            sender.resume(now)
        elif key == keyboard.STOP:
            self._end("stopped by the user", now)
        else:
            self.show.tell(f"{keyboard.IN_HOLD}; {keyboard.OVER}")

    @staticmethod
    def _answer_of(pressed: str) -> str:
        """The first key that answers; "": none."""
        known = (keyboard.SKIP, keyboard.STOP, keyboard.RESET)
        return next((key for key in pressed if key in known), "")

    def _ask(self, pressed: str | None, now: float) -> None:
        """Show a refused line, and obey the answer. A keyboard that is gone stops the job."""
        for line, words in self.sender.asks[self._asked :]:
            rest = len(self.sender.waiting)
            self.show.tell(
                f"{endings.fact_of_refusal(line, words)}\n   "
                f" {endings.behind(rest)}{self.sender.protocol.does['hold']}"
            )
        answer = self._answer_of(pressed or "")
        if len(self.sender.asks) > self._asked or (pressed and not answer):
            self.show.tell(keyboard.IN_REFUSAL)
        elif answer == keyboard.RESET:
            self.sender.stop(now, "reset by the user")
        elif answer or pressed is None:
            self.sender.decide(answer == keyboard.SKIP, now)
        self._asked = len(self.sender.asks)

    # -- what is kept and told ---------------------------------------------------------------------

    def _shown(self, kind: str, what, answer: bool) -> None:
        """Holds, and what the controller says by itself. answer: it was asked for it."""
        if kind in ("hold", "resumed"):
            self.show.tell(str(what))
            self.show.event(kind, str(what))
        elif kind == "told" and isinstance(what, str) and not answer and self._is_news(what):
            self.show.tell(f"the controller says: {what}")

    def _log(self) -> None:
        entries, self.sender.log = self.sender.log, []
        out = []
        for kind, what, t in entries:
            answer = self.answers is not None and self.answers.hears(kind, what)
            if self.journal is not None:
                out.append(
                    journals.record(kind, what, t - self.started, self.sender.account.executed)
                )
            if self.trace is not None:
                self._traced(kind, what, t)
            self._shown(kind, what, answer)
        live = self.answers.fresh() if self.answers is not None else None
        if self.journal is not None:
            if live is not None:
                out.append(journals.zeros(live.work))
            self.journal.write(b"".join(out))
            self._fault("journal", self.journal.fault)
        if self.record is not None:
            self._fault("recording", self.record.gone)

    def _is_news(self, text: str) -> bool:
        """Whether it is worth telling: no echo, and none of the words that belong to check mode."""
        return "echo" not in text and not (self.sender.check and text in CHECK_WORDS)

    def _traced(self, kind: str, what: object, t: float) -> None:
        """A line, or a report, for the recording."""
        if self.trace is None or self.record is None:
            return
        if kind == "sent" and isinstance(what, WireLine):
            self.trace.sent(what)
        elif isinstance(what, Status) and what.place:
            order = self.sender.order
            place = tuple(what.place[i] for i in order) if order else what.place
            if row := self.trace.row(place, t - self.started):
                self.record.say(row.rstrip("\n"))

    def _fault(self, which: str, why: str) -> None:
        """Of a file that can not be written: told once, and when that is over."""
        if why and which not in self._faults:
            self._faults.add(which)
            rest = "; --resume-from LINE needs none" if which == "journal" else ""
            self.show.tell(f"the {which} can not be written: {why}; the job goes on{rest}")
        elif not why and which in self._faults:
            self._faults.discard(which)
            self.show.tell(f"the {which} is written again, and nothing of it is missing")
