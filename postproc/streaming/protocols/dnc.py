"""Drip feed over RS-232 without answers: the control says go and stop, and nothing else. Fanuc's
way; others are data.

What is known: when bytes left, and that the control let them. What is not: whether they arrived,
were read, or were executed. So a job on this link ends as "sent" and never as "done". Rules
(Fanuc's tape reader interface, ISO code: general knowledge, unverified on hardware; Haas, mill
operator's manual 1999, RS-232 and Setting 14; CIMCO DNC-Max manual, serial port and
troubleshooting): DC1 go, DC3 stop, DC2 and DC4 before and after where they are wanted; `%` opens
and closes the program; a block ends with LF or CR LF. After DC3 a control takes only so many more
bytes before it raises an alarm (Fanuc 087: its buffer has overflowed), so few bytes leave at once,
and input is looked at between: no driver and no FIFO is trusted.

    control   DC1 .......................... DC3 ............ DC1 ..............
    gcomp         16 bytes, 16 bytes, 16 bytes, (at most 16)      16 bytes, ...
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from postproc.streaming.events import Alarm, Event, Message
from postproc.streaming.lines import Unsendable
from postproc.streaming.protocols import Controller, Protocol

TITLE = "DNC, Fanuc"
POKE = b""
DC1, DC2, DC3, DC4 = 0x11, 0x12, 0x13, 0x14
ENDS = b"%"  # stands before and behind a program
# bytes: what a UART of the 16550 kind holds; a control that says stop gets these and no more
AT_ONCE = 16
COMMENT = re.compile(rb"\([^()\n]*\)")
UNCLOSED = re.compile(rb"\([^()\n]*$")
EOB = re.compile(rb";[^\n]*")
FOREIGN = re.compile(rb"[^\x20-\x7e]|%")
LONGEST = 255
DOES = {
    "hold": (
        "this link has no feed hold: no further line was sent, and the control executes what it has"
    ),
    "stop": (
        "this link has no stop: no further line was sent, and the control executes what it has;"
        " stop it at its panel"
    ),
}


@dataclass(frozen=True)
class Link:
    """A control's habits. bits, parity (E, O, N), stop: the line's frame; end: of a block; leader:
    before the first %, trailer: behind the last; waits: for DC1 before the first byte."""

    bits: int = 7
    parity: str = "E"
    stop: int = 2
    baud: int = 4800
    end: bytes = b"\n"
    leader: bytes = b""
    trailer: bytes = b""
    waits: bool = True


FANUC = Link()


def recognises(banner: str) -> bool:
    """A control that is fed says nothing of itself."""
    return False


class Dnc(Protocol):
    """One connection. `counting` means nothing here."""

    title = TITLE
    link = FANUC
    confirms = "nothing"
    does: Mapping[str, str] = DOES
    questions: tuple[bytes, ...] = ()
    opening: tuple[bytes, ...] = (ENDS,)
    closing: tuple[bytes, ...] = (ENDS,)

    def __init__(self, counting: bool = True):
        self.controller = Controller(self.title, window=AT_ONCE, line_limit=LONGEST, planner=0)
        self.stopped = self.link.waits
        self.stops = 0
        self._opened = self._closed = False

    # -- lines out ---------------------------------------------------------------------------------

    def prepare(self, text: bytes) -> bytes:
        """In capital letters of 7 bits; comments stay where every byte of them is one, others
        go."""
        text = text.strip()
        if not text or text.startswith(b"%"):
            return b""
        text = UNCLOSED.sub(b"", EOB.sub(b"", text))
        text = COMMENT.sub(lambda found: b"" if FOREIGN.search(found[0]) else found[0], text)
        text = text.upper().strip()
        if found := FOREIGN.search(text):
            raise Unsendable(
                f"the line has byte {found[0][0]} in it, which is none of the control's code or"
                " means something else on this link",
                "take it out; in comments it does no harm",
            )
        if len(text) > LONGEST:
            raise Unsendable(
                f"the line has {len(text)} characters", f"controls take about {LONGEST}: split it"
            )
        return text

    def alone(self, text: bytes) -> bool:
        return False

    def ready(self, text: bytes) -> bool:
        return True

    def send(self, number: int, text: bytes) -> bytes:
        link = self.link
        if text == ENDS and not self._opened:
            self._opened = True
            return link.leader + text + link.end
        if text == ENDS:
            self._closed = True
            return text + link.end + link.trailer
        return text + link.end

    def release(self) -> int:
        return 0 if self.stopped else AT_ONCE

    def patience(self, text: bytes) -> float:
        return float("inf")

    @property
    def waits(self) -> str:
        """Why nothing may leave, in words; ""."""
        if not self.stopped:
            return ""
        return "stopped by the control (DC3)" if self.stops else "waiting for DC1"

    # -- what the control says ---------------------------------------------------------------------

    def receive(self, data: bytes) -> list[Event]:
        """Go and stop; DC4 before the end is the control's end of it. Parity that the port has left
        in is taken off."""
        events: list[Event] = []
        words = bytearray()
        for byte in data:
            # 7E2 read as 8N1: the eighth bit is parity, and DC1 (0x11, even) and DC3 (0x13, odd)
            # differ in it
            byte &= 0x7F
            if byte == DC1:
                self.stopped = False
            elif byte == DC3:
                self.stops += not self.stopped
                self.stopped = True
            elif byte == DC4 and not self._closed:
                events.append(
                    Alarm("DC4", "the control has ended the reception: look at its screen")
                )
            elif byte >= 0x20:
                words.append(byte)
        return [Message(words.decode()), *events] if words else events


PROTOCOL = Dnc
