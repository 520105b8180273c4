"""Lines with a number and a checksum, answered by ok, asked for again when they arrive damaged:
Marlin's way, and Smoothieware's.

The receiver takes line n only behind line n - 1 and with its checksum, so a line that is sent again
is never executed twice: what it has, it refuses. Therefore, and only therefore, a line may be sent
again here. From MarlinFirmware/Marlin, Marlin/src/gcode/queue.cpp: checks (get_serial_commands),
requests (gcode_line_error, flush_and_request_resend: the rest of the receive buffer is thrown
away), answers (ok_to_send). What the checks do not see: a line that has lost exactly its number
("N5 " and nothing else) is executed unchecked; the request for the number that follows shows it,
and ends the job. And XOR is blind to two equal bytes lost or doubled in one line: no sender can see
that.
"""

from __future__ import annotations

import re
from collections import deque
from dataclasses import dataclass

from postproc.streaming.events import (
    Accepted,
    Altered,
    Busy,
    Event,
    Message,
    Rejected,
    Restarted,
    Status,
    Stray,
    Write,
)
from postproc.streaming.lines import Unsendable
from postproc.streaming.protocols import Controller, Protocol, answers

COMMENT = re.compile(rb"\([^()\n]*\)|;[^\n]*|\([^()\n]*$")
BAD = re.compile(rb"[^\x20-\x7e]|[*\\]")
TEXTS = re.compile(rb"M(?:117|118|16|20|23|28|30|32|33|928)(?![0-9])", re.IGNORECASE)
OK = re.compile(r"ok(?: N(-?\d+))?(?: P(\d+))?(?: B(\d+))?(?:\s+(\S.*))?")
RESEND = re.compile(r"(?:resend|rs)\s*:?\s*N?(\d+)", re.IGNORECASE)
LINE_ERROR = re.compile(
    r"error:.*(?:checksum|line number|last line|expected line|lineno)", re.IGNORECASE
)
LAST_LINE = re.compile(r"last line:\s*(\d+)", re.IGNORECASE)
EXPECTED = re.compile(r"expected line (\d+)", re.IGNORECASE)
UNKNOWN = re.compile(r"unknown command:?\s*\"?([^\"]*)\"?", re.IGNORECASE)
PLACE = re.compile(
    r"(?:[A-Z]+: )?X:\s*(-?\d+(?:\.\d+)?) +Y:\s*(-?\d+(?:\.\d+)?) +Z:\s*(-?\d+(?:\.\d+)?)(.*)"
)
TEMPERATURE = re.compile(r"[TBC]\d?:\s*-?\d")
HISTORY = 64  # numbers whose lines are known when they are asked for
PATIENCE_RESENDS = 10  # requests for one line, one after the other
NUDGES = 3  # times that a line without an answer is sent again


def checksum(data: bytes) -> int:
    """XOR of all bytes."""
    value = 0
    for byte in data:
        value ^= byte
    return value


def _line_asked_for(text: str) -> int | None:
    """The line that an error's text names as the next one."""
    if last := LAST_LINE.search(text):
        return int(last[1]) + 1
    expected = EXPECTED.search(text)
    return int(expected[1]) if expected else None


@dataclass
class Frame:
    """A line on its way. n: its number, None: it has none; oks: answers that it still gets; unread:
    refused, or not read as a numbered line, as far as was heard; nudges: times sent again without
    being asked for; resent: whether it is on its way (not so those that were lost behind one that
    was asked for, until their turn comes); seen: its report was heard."""

    number: int
    n: int | None
    text: bytes
    data: bytes
    oks: int = 1
    unread: str = ""
    nudges: int = 0
    resent: bool = True
    seen: bool = False


@dataclass
class Requests:
    """Requests for one line: how often in a row; late: those for lines that were behind it when it
    was lost; said: what the error before the request said is the next number."""

    n: int = -1
    count: int = 0
    late: int = 0
    said: int | None = None
    strange: int = 0


class Numbered(Protocol):
    """What Marlin and Smoothieware share."""

    confirms = "answers"
    questions: tuple[bytes, ...] = ()
    opening: tuple[bytes, ...] = (b"M110 N0",)
    closing: tuple[bytes, ...] = (b"M400", b"M114")
    forbidden = re.compile(rb"M(?:110|112|28|29|108|410)(?![0-9])", re.IGNORECASE)
    room = 127  # bytes that may be on the way
    own_ok = True  # a request is followed by an ok of its own
    gap = b""  # before the star
    # ends what may be left of a line, so that its rest and a line sent again are never read as one
    anew = b"\n"

    def __init__(self, counting: bool, controller: Controller):
        self.counting, self.controller = counting, controller
        self._rest = b""
        self.forget()

    # -- lines out ---------------------------------------------------------------------------------

    def prepare(self, text: bytes) -> bytes:
        """Without comments and line numbers, upper case; nothing that the receiver takes out before
        it adds up."""
        text = text.strip()
        if not text or text.startswith(b"%"):
            return b""
        text = COMMENT.sub(b"", text).strip().lstrip(b"/").strip()
        text = re.sub(rb"^N[0-9]+ *", b"", text)
        if not TEXTS.match(text):
            text = text.upper()
        if found := BAD.search(text):
            raise Unsendable(
                f"the line has byte {found[0][0]} in it, which upsets the receiver's checksums",
                "take it out; in comments it does no harm",
            )
        if self.forbidden.match(text):
            raise Unsendable(
                f"{text[:5].decode().strip()} would change how the lines behind it are received",
                "take it out of the program",
            )
        limit = self.controller.line_limit
        if len(text) > limit:
            raise Unsendable(
                f"the line has {len(text)} characters, and {self.controller.name} takes {limit}"
                " beside number and checksum",
                "shorten it: drop digits beyond the machine's resolution",
            )
        return text

    def alone(self, text: bytes) -> bool:
        return text in self.opening or text in self.closing

    def ready(self, text: bytes) -> bool:
        if not self._waiting:
            return True
        if (
            not self.counting
            or self._slots <= 1
            or self._resends
            or self.alone(text)
            or self.alone(self._waiting[-1].text)
        ):
            return False
        used = sum(len(frame.data) for frame in self._waiting)  # 14: number and sum
        return len(self._waiting) < self._slots and used + len(text) + 14 <= self.room

    def send(self, number: int, text: bytes) -> bytes:
        if text == b"M110 N0":
            self._n, self._started = 0, True
        elif self._started:
            self._n += 1
        body = b"N%d %s%s" % (self._n, text, self.gap)  # N7 G1 X5*98: all before the star
        data = body + b"*%d\n" % checksum(body) if self._started else text + b"\n"
        frame = Frame(number, self._n if self._started else None, text, data, self.answers(text))
        self._waiting.append(frame)
        self._known.append(frame)
        return data

    def answers(self, text: bytes) -> int:
        """How many oks the line gets."""
        return 1

    def outstanding(self) -> list[int]:
        return [frame.number for frame in self._waiting]

    @property
    def used(self) -> int:
        """Lines that may be in the receiver's buffer."""
        return len(self._waiting)

    def patience(self, text: bytes) -> float:
        return 30.0

    def nudges(self, text: bytes) -> int:
        """How often a line is sent again without being asked for."""
        return NUDGES

    def overdue(self) -> bytes:
        """The oldest line again, when nothing was heard of it for too long: if the receiver has it,
        it says so by asking for the next one. b"": that was done often enough."""
        frame = self._waiting[0] if self._waiting else None
        if frame is None or frame.n is None or frame.nudges >= self.nudges(frame.text):
            return b""
        frame.nudges += 1
        self._idle = 0
        return self.anew + frame.data

    def forget(self) -> None:
        self._waiting: deque[Frame] = deque()
        self._known: deque[Frame] = deque(maxlen=HISTORY)
        self._resends: deque[Frame] = deque()
        self._ask = Requests()
        self._n, self._started = 0, False
        self._spare = 0  # oks to come that answer no line
        self._bare = 0  # and those among them that come for lines without a number
        self._slots = 1
        self._numbers = False  # its oks say numbers
        self._idle = 0
        self._missed = 0  # lines in a row that it had, and whose answer was not understood

    # -- answers in --------------------------------------------------------------------------------

    def receive(self, data: bytes) -> list[Event]:
        texts, self._rest = answers(self._rest, data)
        events: list[Event] = []
        # one after the other: what an answer means may follow from the one before
        for text in texts:
            events += self._meaning(text)
        return events

    def _meaning(self, text: str) -> list[Event]:
        if text != "wait":
            self._idle = 0
        found = OK.fullmatch(text)
        if found:
            return self._ok(text, found)
        found = RESEND.fullmatch(text)
        if found:
            return self._request(text, int(found[1]))
        if LINE_ERROR.match(text):
            self._ask.said = _line_asked_for(text)
            return [Message(text)]
        found = UNKNOWN.search(text)
        if found and self._waiting:
            return self._unknown(text, found[1])
        if PLACE.match(text):
            return self._place(text)
        if text == "wait":
            return self._waits(text)
        return self._other(text)

    def _other(self, text: str) -> list[Event]:
        """What only one of the controllers says."""
        return [] if TEMPERATURE.match(text) else [Message(text)]

    @staticmethod
    def _has_all_oks(frame: Frame) -> bool:
        """One ok more has come: is it the last one, and the report that M114 needs there?"""
        frame.oks -= 1
        return frame.oks <= 0 and (frame.seen or frame.text != b"M114")

    def _ok_of_bare(self, text: str) -> list[Event]:
        """The ok of a line without a number."""
        if not self._bare:
            return self._fault(f"{text}: it has executed a line that had lost its number")
        self._bare -= 1
        return [Message(text)]

    def _ok(self, text: str, found: re.Match[str]) -> list[Event]:
        events = self._place(found[4]) if found[4] and PLACE.match(found[4]) else []
        self._slots = max(self._slots, int(found[3] or 0))
        if found[1] is not None and self._started:
            self._numbers = True
            return events + self._ok_of(int(found[1]), text)
        if self._numbers and self._started and found[2] is not None:
            return [*events, *self._ok_of_bare(text)]
        return self._ok_without_number(text, events)

    def _ok_without_number(self, text: str, events: list[Event]) -> list[Event]:
        answers = [*events, Message(text)]
        frame = self._waiting[0] if self._waiting else None
        if self._numbers and frame is not None and frame.n is not None:
            return answers  # it belongs to a request
        if self._spare:
            self._spare -= 1
            return answers
        if frame is None:
            return [*events, Stray(text)]
        self._missed = 0
        return events + self._taken(frame) if self._has_all_oks(frame) else answers

    def _ok_of(self, n: int, text: str) -> list[Event]:
        """An ok that names its line: those before it were taken too."""
        if not any(frame.n == n for frame in self._waiting):
            return [Message(text)]
        events: list[Event] = []
        while self._waiting:
            frame = self._waiting[0]
            events += self._taken(frame)
            if frame.n == n:
                break
        return events

    def _taken(self, frame: Frame) -> list[Event]:
        self._waiting.remove(frame)
        self._ask.strange = 0
        if self._resends and self._resends[0] is frame:
            self._resends.popleft()
        if frame.unread:
            return [Rejected(frame.number, frame.unread), *self._next()]
        return [Accepted(frame.number), *self._next()]

    def _next(self) -> list[Event]:
        """The next of the lines that were lost behind one that was asked for."""
        if self._resends and self._resends[0] is self._waiting[0] and not self._resends[0].resent:
            self._resends[0].resent = True
            return [Write(self._resends[0].data)]
        return []

    def _has_all(self, text: str) -> list[Event]:
        """It asks for the line that has not been sent yet."""
        self._resends.clear()
        self._missed += bool(self._waiting)
        # twice the ok of a line was taken for a request's own: this build gives requests none
        if self._missed >= 2:
            self.own_ok, self._spare = False, 0
        self._spare += self.own_ok and not self._numbers
        return [event for frame in list(self._waiting) for event in self._taken(frame)] or [
            Message(text)
        ]

    def _request(self, text: str, n: int) -> list[Event]:
        said, self._ask.said = self._ask.said, None
        if not self._started or said not in (None, n):
            return self._strange(text)
        if n == self._n + 1:
            return self._has_all(text)
        if n in [frame.n for frame in self._waiting]:
            self._spare += self.own_ok and not self._numbers
            return self._resend(text, n)
        if n <= self._n and n in [frame.n for frame in self._known]:
            return self._fault(f"{text}: it asks for a line that it has already answered")
        return self._strange(text)

    def _resend(self, text: str, n: int) -> list[Event]:
        events: list[Event] = []
        if self._waiting[0].n != n:
            self._resends.clear()
        while self._waiting[0].n != n:  # it has those before, and their answer was lost
            events += self._taken(self._waiting[0])
        if n == self._ask.n and self._ask.late > 0:
            self._ask.late -= 1
            return [*events, Message(text)]
        if n != self._ask.n:
            self._ask.n, self._ask.count = n, 0
        self._ask.count += 1
        if self._ask.count > PATIENCE_RESENDS:
            return [*events, *self._fault(f"{text}, {PATIENCE_RESENDS} times in a row")]
        #   sent    N7  N8  N9  N10      N8 arrives damaged; what is behind it does not follow N7
        #   heard   ok  Resend: 8  ok    of N7; and its own ok, of builds that send one (own_ok)
        #   sent    N8                   alone: N9 follows behind its ok (_next)
        #   heard   Resend: 8  ...       once more for N9 and N10 if they were still on the wire:
        #                                these requests are late ones, and no fault of the line
        self._ask.late = len(self._waiting) - 1
        self._resends = deque(self._waiting)
        for frame in self._resends:
            frame.resent = False
        first = self._resends[0]
        first.resent, first.unread, first.oks = True, "", self.answers(first.text)
        return [*events, Busy(text), Write(first.data)]

    def _strange(self, text: str) -> list[Event]:
        """A request that can not be meant: damaged on its way, most likely. The line will be asked
        for again."""
        self._ask.strange += 1
        self._spare += self.own_ok and self._started and not self._numbers
        if self._ask.strange > PATIENCE_RESENDS:
            return self._fault(f"{text}: it asks for lines that were never sent")
        return [Message(text)]

    def _fault(self, heard: str) -> list[Event]:
        return [Altered(self._waiting[0].number if self._waiting else 0, heard)]

    def _unknown(self, text: str, heard: str) -> list[Event]:
        """It refuses a command; or it read another one than was sent, and without its number."""
        frame = self._waiting[0]
        bare = re.sub(r"\*\d*$", "", heard).replace(" ", "")
        if not heard or bare == frame.text.decode().replace(" ", ""):
            frame.unread = text
            return [Message(text)]
        if frame.n is None:
            return [Message(text)]
        self._spare += not self._numbers
        self._bare += self._numbers
        return [Message(text), *([] if self._ask.late else self._resend(text, frame.n))]

    def _waits(self, text: str) -> list[Event]:
        """It says that it has nothing to do: what is unanswered was lost, or its answer was."""
        self._idle += 1
        if self._idle < 2:
            return [Message(text)] if not self._waiting else []
        data = self.overdue()
        return [Write(data)] if data else []

    def _place(self, text: str) -> list[Event]:
        found = PLACE.match(text)
        assert found is not None
        events = self.placed(text, tuple(float(found[i]) for i in (1, 2, 3)), found[4])
        frame = next((frame for frame in self._waiting if frame.text == b"M114"), None)
        if frame is not None:
            frame.seen = True
            if frame.oks <= 0:  # its ok came first
                events += self._taken(frame)
        return events

    def placed(self, text: str, logical: tuple[float, ...], rest: str) -> list[Event]:
        """A report of the place was heard."""
        return [Message(text), Status("idle", place=self.place(logical, rest))]

    def place(self, logical: tuple[float, ...], rest: str) -> tuple[float, ...] | None:
        """mm, machine coordinates, from a report's own numbers and what follows them; None: it does
        not say."""
        return None

    def restarted(self, text: str) -> list[Event]:
        """It has just started."""
        self.forget()
        self._rest = b""
        return [Restarted(text)]
