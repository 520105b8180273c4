"""Tool changes of a job: the user's macros, and what the controller says of its zeros."""

from __future__ import annotations

import argparse
import threading
from dataclasses import dataclass, replace
from pathlib import Path

from postproc import intake, ports
from postproc.errors import GcompError, UsageError
from postproc.streaming import changes
from postproc.streaming import live as lives
from postproc.streaming.changes import Macro
from postproc.streaming.events import Status
from postproc.streaming.lines import WireLine
from postproc.streaming.protocols import Controller, Protocol
from postproc.streaming.protocols.grbl import Grbl


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
            # between a question's leaving and its answer, what the controller says is its words
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
        # a copy: the controller as it was before the job stays what the first leg went by
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
