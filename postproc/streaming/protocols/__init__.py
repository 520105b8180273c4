"""How controllers are talked to: one module a protocol, found by its name. Bytes in, events out; no
port, no clock.

A module holds

    TITLE                  what a person calls it
    POKE                   bytes that move nothing and make a silent controller say who it is (b"":
                           none)
    recognises(banner)     whether text that came from the wire (a greeting, the answer to POKE or
                           to $I) is this controller's; patterns of different modules must exclude
                           each other
    WHOLE                  where there is one: a pattern for a greeting behind which nothing more is
                           said
    PROTOCOL               a class; PROTOCOL(counting=True) gives one connection's state, an object
                           as Protocol says

Modules that begin with _ are what protocols share. A protocol decides by itself when a line may
leave and which line an answer is for, so that windows (GRBL), numbers with checksums and resends
(Marlin: send() frames and keeps the line, receive() answers a request with Write), primed lines
with JSON footers (TinyG), and links without any answer, where the receiver says stop and go (DNC:
release() is 0 after XOFF), all look alike to the sender.

    sender                      protocol                                      wire
    ready(text)                 is there room for it?
    send(7, text)               keeps line 7, frames it                  ->   N7 G1 X5*98
                                receive(data): whose answer is this?     <-   ok
    Accepted(7): next line
    patience(text) is over      overdue(): what may be said again        ->   N7 G1 X5*98
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import ModuleType
from typing import Protocol as Interface

from postproc.errors import UsageError
from postproc.streaming.events import Event
from postproc.units import MM_PER_INCH

LONGEST_ANSWER = 4096  # bytes without a line end that are no answer any more
UNLIMITED = 1 << 30


@dataclass
class Controller:
    """What a controller said of itself before the job.

    name, version: its own words. window: bytes of its receive buffer that may be used; line_limit:
    characters of a line;
    planner: motions that it may have accepted and not executed (130 where it does not say so:
    FluidNC's may be configured up to 120);
    segments: those that it may have taken out of its planner and not made. settings: number or name
    to value, its own text.
    offsets: its answer about zeros and tool length, for postproc.offsets. modal: words in force
    ("G54"). inches: whether it reports inches. homing: whether it can home, None: not said. flags:
    letters of what it was built with ($I). compensates: what it corrects by itself, in words.
    """

    name: str = ""
    version: str = ""
    window: int = 127
    line_limit: int = 79
    planner: int = 130
    segments: int = 0
    settings: dict[str, str] = field(default_factory=dict)
    offsets: list[str] = field(default_factory=list)
    modal: list[str] = field(default_factory=list)
    inches: bool = False
    homing: bool | None = None
    flags: str = ""
    compensates: list[str] = field(default_factory=list)

    @property
    def unit(self) -> float:
        """mm of a unit of length of its reports."""
        return MM_PER_INCH if self.inches else 1.0

    def setting(self, number: int, default: float = 0.0) -> float:
        """The number that it says of a setting of GRBL and its kin; default: it does not say it."""
        text = self.settings.get(str(number), "")
        return float(text) if re.fullmatch(r"[0-9]*\.?[0-9]+", text) else default

    @property
    def coarsest_step(self) -> float:
        """mm: of the motors, by $100 and on; 0 where it does not say so."""
        return max((1.0 / k for i in range(6) if (k := self.setting(100 + i)) > 0), default=0.0)


class Protocol(Interface):
    """One connection: what every protocol has, and what most of them do.

    does: what urgent("hold") and urgent("stop") really do there, and what follows from it, in words
    for a person.
    confirms: how the end of a job is known: "idle" (a Status says so), "answers" (the last answer
    is given when all is done; a controller that answers when it has taken a line gets a closing
    line that it answers at rest, such as a dwell), or "nothing" (what was written is all that is
    known). questions: lines to ask one by one before a job.

    A class may have besides: modal, True: it reads RS274/NGC, whose words hold from line to line,
    and numbers whose decimal point says nothing; used, how much of the receive buffer is taken;
    waits, why nothing may leave now, in words ("": it may); exact, True: it rounds no corner and
    says where it is while it moves; hails, the questions without which it answers nothing; handed,
    True: the program is put into a file that the controller opens; link, the frame of a serial line
    (dnc.Link).
    """

    controller: Controller
    does: Mapping[str, str]
    urgents: Mapping[str, bytes] = {}
    confirms: str
    questions: tuple[bytes, ...]
    opening: tuple[bytes, ...]  # lines to send before the program (M110 N0, %)
    closing: tuple[bytes, ...]  # and behind it (M400, %)

    def prepare(self, text: bytes) -> bytes:
        """A program line as it shall be sent, without line end; b"": nothing of it need be sent.
        Raises Unsendable."""

    def alone(self, text: bytes) -> bool:
        """Whether the line may be sent only when all before it are answered, and nothing behind it
        before its answer."""

    def ready(self, text: bytes) -> bool:
        """Whether this line may leave now."""

    def send(self, number: int, text: bytes) -> bytes:
        """Take a line as sent: the bytes for the wire, framed, numbered, with its line end."""

    def receive(self, data: bytes) -> list[Event]:
        """What the bytes mean, in order; they may be cut anywhere."""

    def release(self) -> int:
        """How many bytes may be written at once now; then look for input again."""
        return UNLIMITED

    def urgent(self, what: str) -> bytes:
        """Bytes that pass the queue: "status", "hold", "resume", "stop"; b"" where there are
        none."""
        return self.urgents.get(what, b"")

    def outstanding(self) -> list[int]:
        """Numbers of the lines that wait for an answer, oldest first."""
        return []

    def patience(self, text: bytes) -> float:
        """s that this line may take without any word from the controller."""

    def emptied(self, text: bytes) -> bool:
        """Whether the answer to this line is given only when all before it has been executed."""
        return False

    def overdue(self) -> bytes:
        """What to write when the oldest line has waited too long for its answer: only what the
        receiver can not execute twice (a numbered line, a question). b"": nothing, the job has
        stalled."""
        return b""

    def forget(self) -> None:
        """All that was sent is void: the controller has restarted, or the window was emptied."""

    def learn(self, question: bytes, answers: list[str]) -> None:
        """Take what was said in answer to a question into `controller`."""

    def check_mode(self) -> bytes:
        """The line that switches a dry run on and off; b"": there is none."""
        return b""


@functools.cache
def names() -> tuple[str, ...]:
    """Names of the protocols that there are, sorted: the folder is looked at once, for a greeting
    asks fifty times a second."""
    found = (m.name for m in pkgutil.iter_modules(__path__))
    return tuple(sorted(name.replace("_", "-") for name in found if not name.startswith("_")))


def load(name: str) -> ModuleType:
    """The protocol called `name`. Raises UsageError with the names that there are."""
    if name not in names():
        raise UsageError(f"there is no protocol {name!r}", f"protocols: auto, {', '.join(names())}")
    return importlib.import_module(f"{__name__}.{name.replace('-', '_')}")


def recognised(text: str) -> list[str]:
    """Names of the protocols that know this text as their controller's."""
    return [name for name in names() if load(name).recognises(text)]


def pokes() -> list[bytes]:
    """What makes silent controllers speak, each once, in the order of names."""
    return list(dict.fromkeys(load(name).POKE for name in names() if load(name).POKE))


def answers(rest: bytes, data: bytes) -> tuple[list[str], bytes]:
    """Of a controller that answers in lines: the answers that are whole, without line ends, blanks
    around them and empty ones, and what is left of the next. rest: what the last call left."""
    *lines, rest = (rest + data).split(b"\n")
    # a controller that never ends a line (another baud rate) must not fill the memory
    if len(rest) > LONGEST_ANSWER:
        lines, rest = [*lines, rest], b""
    texts = (line.strip(b"\r\0 \t").decode("latin-1") for line in lines)
    return [text for text in texts if text], rest
