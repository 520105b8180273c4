"""One order to a controller outside a job (reset, resume, unlock, home, jog, zero, a line), and
what a state of it asks for.

Bytes and time in, bytes out, like the sender. Rules of GRBL (gnea/grbl, doc/markdown/jogging.md,
commands.md): `~` goes on, Ctrl-X resets and keeps the position where nothing moved, $X unlocks, $H
homes, $J= jogs where it is idle, G10 L20 P0 makes the present place the zero of the work offset in
force.
"""

from __future__ import annotations

import re

from postproc.errors import UsageError
from postproc.streaming.events import Accepted, Alarm, Message, Rejected, Restarted, Status
from postproc.streaming.protocols import Protocol

RESET, RESUME, UNLOCK, HOME, JOG, ZERO, SEND = (
    "reset", "resume", "unlock", "home", "jog", "zero", "send",
)  # fmt: skip
WORDS = (RESET, RESUME, UNLOCK, HOME, JOG, ZERO, SEND)
JOG_FEED = 500.0  # mm/min
AXIS = re.compile(r"([XYZABCUVW])([-+]?[0-9]*\.?[0-9]+)", re.IGNORECASE)
POLL = 0.1  # s
REST = {"idle", "check"}
# What a state is, what leads out of it, and the orders that do.
STATES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "hold": (
        "it holds the feed",
        "resume goes on with what it has, reset drops it (the position stays, if it stands)",
        (RESUME, RESET),
    ),
    "door": (
        "its safety door is open, or was",
        "close the door, then resume; reset drops what it has",
        (RESUME, RESET),
    ),
    "alarm": (
        "it is locked after an alarm, or since it was switched on",
        "home it; or unlock, if its position is sure",
        (HOME, UNLOCK),
    ),
    "sleep": (
        "it sleeps",
        "reset wakes it; then home, or unlock if its position is sure",
        (RESET, HOME, UNLOCK),
    ),
    "check": ("it is in check mode", "reset ends that", (RESET,)),
    "run": (
        "it executes something",
        "wait; or reset stops it (in motion it then locks, and must be homed)",
        (RESET,),
    ),
    "jog": ("it jogs", "wait; reset stops it", (RESET,)),
    "home": ("it homes", "wait; reset stops that, and it must be homed anew", (RESET,)),
    "tool": ("it waits for a tool", "put it in, then resume", (RESUME,)),
    "off": (
        "it is switched off, or in emergency stop",
        "switch it on at its own panel, and home it",
        (),
    ),
    "unhomed": ("it is not homed", "home it at its own panel", ()),
}
STRANGE = ("that is not known here", "look at its manual, or reset it", (RESET,))


def fact(status: Status) -> str:
    """A state that is not idle, in words."""
    detail = f":{status.detail}" if status.detail else ""
    return f"{status.state}{detail}: {STATES.get(status.state, STRANGE)[0]}"


def way_out(status: Status, port: str) -> str:
    """What leads out of a state that is not idle, and the commands for it."""
    _, way, orders = STATES.get(status.state, STRANGE)
    does = f": gcomp control --port {port} {' | '.join(orders)}" if orders else ""
    return f"{way}{does}"


def in_words(status: Status, port: str) -> str:
    """A state in words, with the commands that help, where it is not idle."""
    if status.state == "idle":
        return "idle: it stands, and takes a job"
    way = way_out(status, port)
    return f"{fact(status)}. {way[0].upper()}{way[1:]}"


def line_of(order: str, words: list[str]) -> bytes:
    """The line of an order; b"": it is a single byte. Raises UsageError for words that it can not
    have."""
    if order == JOG:
        return _jog(words)
    if order == ZERO:
        return _zero(words)
    if order == SEND:
        text = " ".join(words).strip()
        if not text or any(ord(c) > 126 or c in "!~?\n\r" for c in text):
            raise UsageError(
                "send takes one line of plain text", "gcomp control --port P send '$$'"
            )
        return text.encode("ascii")
    if words:
        raise UsageError(f"{order} takes no words", f"gcomp control --port P {order}")
    return {UNLOCK: b"$X", HOME: b"$H"}.get(order, b"")


def _zero(words: list[str]) -> bytes:
    letters = [w.upper() for w in words]
    if not letters or any(not re.fullmatch("[XYZABCUVW]", w) for w in letters):
        raise UsageError(
            "zero takes letters of axes",
            "gcomp control --port P zero X Y: the work zero of X and Y is here",
        )
    return ("G10 L20 P0 " + " ".join(f"{w}0" for w in letters)).encode()


def _jog(words: list[str]) -> bytes:
    feed, moves = JOG_FEED, []
    for word in words:
        if word[:1] in "Ff" and re.fullmatch(r"[0-9]*\.?[0-9]+", word[1:]):
            feed = float(word[1:])
        elif AXIS.fullmatch(word):
            moves.append(word.upper())
        else:
            raise UsageError(
                f"jog does not know {word!r}",
                "gcomp control --port P jog X10 Y-5 F800: mm from here, mm/min",
            )
    if not moves or feed <= 0:
        raise UsageError(
            "jog needs an axis and a way", "gcomp control --port P jog Z5: 5 mm up from here"
        )
    # A jog has modes of its own, in its line alone: the program's stay as they are.
    return f"$J=G91 G21 {' '.join(moves)} F{feed:g}".encode()


class Order:
    """One order on one connection, to its end: done, with `status` as it is then, or `fault`. said:
    the controller's words.

        we       the controller
        $J=...   ok                 the answer: it has the order (homing answers at its end alone)
        ?        <Jog|...>          the first report may have been on its way before the answer, so
                                    it is not counted
        ?        <Jog|...>          it moves: wait
        ?        <Idle|...>         at rest
        ?        <Idle|...>         twice in a row: done
    """

    def __init__(
        self,
        protocol: Protocol,
        order: str,
        words: list[str],
        status: Status | None,
        port: str = "PORT",
    ):
        self.port = port
        self.protocol, self.order, self.line = protocol, order, line_of(order, words)
        self.status, self.said, self.fault, self.done = status, list[str](), "", False
        self._out = b""
        self._answered = self._fresh = False
        self._asked, self._started, self._rests = -1.0, -1.0, 0
        self._fits(status)

    def _fits(self, status: Status | None) -> None:
        """Raises UsageError where the controller would not take it now."""
        if status is None:  # it does not say it
            return
        state, what, way = status.state, fact(status), way_out(status, self.port)
        if self.order == RESUME and state not in ("hold", "door", "tool"):
            raise UsageError(
                f"there is nothing to resume: the controller is {state}",
                in_words(status, self.port),
            )
        if (
            self.order in (JOG, ZERO, SEND)
            and state not in REST | {"jog"}
            and not self.line.startswith(b"$")
        ):
            raise UsageError(f"the controller takes no line now. {what}", way)
        if self.order == JOG and state not in ("idle", "jog"):
            raise UsageError(f"a jog needs an idle controller. {what}", way)

    def begin(self, now: float) -> None:
        self._started = now
        if self.order in (RESET, RESUME):
            data = self.protocol.urgent("stop" if self.order == RESET else "resume")
            if not data:
                raise UsageError(
                    f"{self.protocol.controller.name} has no such order on the wire",
                    "use its own panel",
                )
            self._out, self._answered = data, True
            if self.order == RESET:
                self.protocol.forget()
        else:
            self._out = self.protocol.send(1, self.protocol.prepare(self.line) or self.line)
            if not self._out:
                raise UsageError(
                    f"{self.protocol.controller.name} has no such order on the wire",
                    "use its own panel",
                )

    def bytes_out(self) -> bytes:
        data, self._out = self._out, b""
        return data

    def receive(self, data: bytes, now: float) -> None:
        for event in self.protocol.receive(data):
            if isinstance(event, Accepted):
                self._answered = True
            elif isinstance(event, Rejected) or (isinstance(event, Alarm) and self.order != RESET):
                self.fault = f"{event.code}" + (f" ({event.meaning})" if event.meaning else "")
            elif isinstance(event, Message):
                self.said.append(event.text)
            elif isinstance(event, Restarted):
                self.said.append(event.text.strip())
            elif isinstance(event, Status):
                self._reported(event)

    def _reported(self, status: Status) -> None:
        self.status = status
        waits = self.order in (HOME, JOG, SEND) and status.state in ("run", "jog", "home")
        if self._answered and self._fresh:
            self._rests = 0 if waits else self._rests + 1
            self.done = self._rests >= 2
        # the report behind the next question was asked for after the answer
        self._fresh = self._answered

    def tick(self, now: float) -> None:
        """Ask for reports; two of the same kind behind the answer end it."""
        if not self.protocol.urgent("status"):
            self.done = self.done or self._answered
        elif now - self._asked >= POLL and not (self.order == HOME and not self._answered):
            self._asked = now
            self._out += self.protocol.urgent("status")
