"""The talk before a job: wait for the controller's greeting or make it speak, find its protocol,
ask what it is.

Bytes and time in, bytes out, like the sender. Nothing here moves an axis unless homing is asked
for.
"""

from __future__ import annotations

from collections.abc import Sequence

from postproc.errors import GcompError
from postproc.streaming import protocols
from postproc.streaming.events import Accepted, Alarm, Event, Message, Rejected, Restarted, Status
from postproc.streaming.orders import fact, way_out
from postproc.streaming.protocols import Protocol

AUTO = "auto"
LISTEN = 6.0  # s: a board that restarts when its port is opened greets within this
POKE_EVERY = 0.7  # s
QUIET = 0.3  # s without a byte: it has finished speaking
SETTLED = (
    # s, where its greeting is whole: time for what a board does behind it (startup blocks are read
    # from EEPROM)
    0.1
)
ANSWER = 4.0  # s for the answer to a question


class GreetingError(GcompError):
    """Nobody is there, or not one who can take a job."""


class Greeting:
    """name: a protocol or "auto"; first: lines to send before the questions ($H, $X). state_only:
    ask for its state and nothing else, which it answers whatever state it is in."""

    def __init__(
        self,
        name: str,
        counting: bool = True,
        first: tuple[bytes, ...] = (),
        listen: float = LISTEN,
        state_only: bool = False,
        port: str = "PORT",
    ):
        self.state_only, self.port = state_only, port
        self.counting, self.first, self.listen = counting, first, listen
        self.found = [] if name == AUTO else [name]
        self.auto = name == AUTO
        self.protocol: Protocol | None = None
        self.status: Status | None = None
        self.fault: GreetingError | None = None
        self.done = False
        self.banner = ""
        self.restarted = False  # it greeted as one that has just started
        self._out = b""
        self._started: float | None = None
        self._heard = 0.0
        self._pokes = (
            protocols.pokes()
            if self.auto
            else [protocols.load(name).POKE] * bool(protocols.load(name).POKE)
        )
        self._poked = 0.0
        self._asked: bytes | None = None
        self._deadline = 0.0
        self._answers: list[str] = []
        self._script: list[bytes] = []
        self._number = 0
        self._asks_status = self._settles = self._mute = False  # mute: a question was not answered

    @property
    def moves(self) -> bool:
        """Whether the machine moves by gcomp's order: it homes."""
        return (
            self._asked is not None and self._asked in self.first and self._asked.startswith(b"$H")
        )

    def bytes_out(self) -> bytes:
        data, self._out = self._out, b""
        return data

    def receive(self, data: bytes, now: float) -> None:
        if self.done or self.fault or not data:
            return
        self._heard = now
        if self.protocol is None:
            self.banner += data.decode("latin-1")
            self.banner = self.banner[-4000:]
            return
        for event in self.protocol.receive(data):
            self._take(event, self.protocol, now)

    def _reported(self, status: Status, protocol: Protocol) -> None:
        self.status = status
        if self._asks_status:
            self.done = True
        elif self._mute and (why := unfit(protocol, status, self.port)):
            self.fault = why

    def _take(self, event: Event, protocol: Protocol, now: float) -> None:
        if isinstance(event, Message):
            self._answers.append(event.text)
        elif isinstance(event, Status):
            self._reported(event, protocol)
        elif isinstance(event, Accepted):
            self._answered(now)
        elif isinstance(event, Rejected):
            self._refused(event, now)
        # it greets late: what was asked is lost, or its answer may still come
        elif isinstance(event, Restarted):
            protocol.forget()
            self.restarted = True
            self._asked, self._asks_status, self._settles = None, False, True
        elif isinstance(event, Alarm) and not self.state_only:
            self._fail(
                f"the controller is in alarm: {event.code} {event.meaning}",
                "clear its cause and start again",
            )

    def tick(self, now: float) -> None:
        if self.done or self.fault:
            return
        if self._started is None:
            self._started = self._heard = self._poked = now
        if self.protocol is None:
            self._listen(now)
        elif self._settles:
            if now - self._heard >= QUIET:
                self._settles = False
                self._begin(now)
        elif now > self._deadline:
            if self._asked in self.first:
                self._fail(
                    f"{self._asked.decode()} was not finished within {ANSWER * 75:.0f} s",
                    "look at the machine",
                )
            elif self._asks_status:
                self.done = True  # a link without reports
            else:
                self._unanswered(now)

    def _unanswered(self, now: float) -> None:
        """A GRBL that holds, or sleeps, answers no line, and says its state all the same."""
        assert self.protocol is not None
        request = self.protocol.urgent("status")
        if request and not self._mute:
            self._mute, self._out, self._deadline = True, self._out + request, now + ANSWER
            return
        asked = (self._asked or b"").decode()
        self._fail(
            f"the controller did not answer {asked} within {ANSWER:g} s",
            "is another program using the port?",
        )

    def _is_whole(self, known: Sequence[str]) -> bool:
        """Whether the banner of the likeliest protocol has come to its end."""
        pattern = getattr(protocols.load(known[0]), "WHOLE", None) if known else None
        return bool(pattern and pattern.search(self.banner))

    def _has_said_all(self, known: Sequence[str], now: float) -> bool:
        quiet = SETTLED if self._is_whole(known) else QUIET
        return bool(self.banner.strip()) and now - self._heard >= quiet

    def _listen(self, now: float) -> None:
        assert self._started is not None
        known = protocols.recognised(self.banner) if self.auto else self.found
        if known and (self._has_said_all(known, now) or not self._pokes):
            self.found = known
            self._choose(known[0], now)
        elif now - self._started > self.listen:
            heard = " ".join(self.banner.split())[:120]
            unknown = f"this is no controller that gcomp knows: {heard!r}"
            endless = f"this port sends without a pause: {heard!r}"
            way = "check --baud, and what else writes to the port"
            said = (unknown, "say --protocol, and check --baud") if self.auto else (endless, way)
            self._fail(*(said if heard else NO_ANSWER))
        elif self._pokes and now >= self._poked + POKE_EVERY:
            self._out += self._pokes[0]
            # by turns, one at a time: answers to two of them at once would be read as one
            self._pokes = [*self._pokes[1:], self._pokes[0]]
            self._poked = now

    def _choose(self, name: str, now: float) -> None:
        kind = protocols.load(name).PROTOCOL
        # A second object reads the greeting, so that what stands in it answers none of our
        # questions.
        heard = kind().receive(self.banner.encode("latin-1") + b"\n")
        self.restarted = self.restarted or any(isinstance(event, Restarted) for event in heard)
        self.protocol = kind(counting=self.counting)
        self._begin(now)

    def _begin(self, now: float) -> None:
        assert self.protocol is not None
        self.protocol.forget()
        hails = getattr(self.protocol, "hails", ())  # without which it answers nothing
        self._script = list(hails) if self.state_only else [*self.first, *self.protocol.questions]
        self._ask(now)

    def _ask(self, now: float) -> None:
        assert self.protocol is not None
        self._answers = []
        if self._script:
            self._asked = self._script.pop(0)
            self._number -= 1
            self._out += self.protocol.send(self._number, self._asked)
            self._deadline = now + (ANSWER * 75 if self._asked in self.first else ANSWER)
            return
        self._asked, self._asks_status = None, True
        self._out += self.protocol.urgent("status")
        self._deadline = now + (ANSWER if self.protocol.urgent("status") else 0.0)

    def _answered(self, now: float) -> None:
        assert self.protocol is not None
        if self._asked is None:
            return
        if self._asked == b"$I":
            text = "\n".join(self._answers)
            better = [n for n in protocols.recognised(text) if n not in self.found[:1]]
            if self.auto and better:  # a status report or an old greeting looked like another's
                self.found = better
                self._choose(better[0], now)
                return
        self.protocol.learn(self._asked, self._answers)
        self._ask(now)

    def _refused(self, event: Rejected, now: float) -> None:
        if self._asked in self.first:
            self._fail(
                f"{(self._asked or b'').decode()} was refused: {event.code} ({event.meaning})",
                "look at the machine",
            )
        elif self._asked == b"$+":  # an older build
            self._script.insert(0, b"$$")
            self._ask(now)
        else:
            self._ask(now)

    def _fail(self, message: str, advice: str = "") -> None:
        self.fault = GreetingError(message, advice)


NO_ANSWER = (
    "no answer on this port",
    (
        "is it the right port and --baud, is the controller on, and does no other program hold the"
        " port? --protocol says which it is"
    ),
)


def unfit(protocol: Protocol, status: Status | None, port: str = "PORT") -> GreetingError | None:
    """Why a job can not begin, if it can not. port: as a person names it."""
    if compensates := protocol.controller.compensates:
        return GreetingError(
            f"{protocol.controller.name} compensates by itself: {', '.join(compensates)}; with"
            " gcomp's map that would be done twice",
            "set these to zero at the controller, or leave them out of the machine's map and say"
            " --control-compensates",
        )
    if status is None or status.state == "idle":
        return None
    if status.state == "alarm":
        return GreetingError(
            "the controller is locked (alarm): where it stands is not certain",
            "home it (--home), or unlock it with --unlock if you are sure of its position",
        )
    return GreetingError(f"the controller is not idle. {fact(status)}", way_out(status, port))
