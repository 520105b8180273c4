"""TinyG: lines in, one JSON answer each with a footer; reports in between; every line is echoed and
compared.

Rules: synthetos/TinyG, wiki (JSON Operation, Status Reports, TinyG Alarms, Sending Data using RX
Packet Mode) and firmware/tinyg/json_parser.c, util.c (compute_checksum):
`{"r":{..},"f":[revision,status,bytes,checksum]}`, bytes taken out of the receive buffer, checksum
of the text up to the last comma (revision 1). The receive buffer holds 254 bytes, and at 80 % of it
the board says XOFF. Verbosity 5 ($jv) echoes each block, so that a byte lost on the way shows; it
is put back at the end. An answer says that a line was taken, not that it was executed: the end of
motion is a report of state 3 or 4. `!` `~` `%` and ^X are obeyed wherever they stand. `?` and `$`
would switch to text mode, so they are never sent.

    leaves   G1X10F600
    comes    {"r":{"gc":"G1X10F600"},"f":[1,0,10,4321]}     as it was read; status 0, 10 bytes
    comes    {"sr":{"stat":5}}   {"sr":{"stat":3}}          it moves; it stands
"""

from __future__ import annotations

import json
import re
from collections import deque
from collections.abc import Mapping
from typing import Any

from postproc.streaming.events import (
    Accepted,
    Alarm,
    Altered,
    Busy,
    Event,
    Message,
    Rejected,
    Restarted,
    Status,
    Stray,
)
from postproc.streaming.lines import Unsendable
from postproc.streaming.protocols import UNLIMITED, Controller, Protocol, answers

TITLE = "TinyG"
POKE = b'{"fv":null}\n'
COMMENT = re.compile(rb"\([^()\n]*\)|;[^\n]*|\([^()\n]*$")
BLANKS = re.compile(rb"[\x00-\x20]+")
REALTIME = re.compile(rb"[!~%\x18]|[^\x20-\x7e]")
XON, XOFF = 0x11, 0x13
STATES = {
    0: "start", 1: "idle", 2: "alarm", 3: "idle", 4: "idle", 5: "run", 6: "hold", 7: "run",
    8: "run", 9: "home", 10: "jog", 11: "door", 12: "alarm", 13: "alarm",
}  # fmt: skip
TAKEN = {0, 60, 61, 201, 202}  # ok, and moves too short to make
MEANINGS = {
    5: "terminated",
    40: "unrecognised command",
    41: "command letter expected",
    42: "bad number",
    43: "too long",
    44: "too small",
    45: "too large",
    46: "out of range",
    47: "not supported",
    48: "no JSON",
    50: "out of buffer space",
    62: "bad block",
    63: "no feed rate",
    64: "axis word missing",
    65: "two codes of one modal group",
    66: "homing failed",
    67: "beyond the travel",
    68: "spindle too fast",
    69: "bad arc",
    100: "unrecognised command",
    108: "not supported",
    111: "no JSON",
    130: "bad block",
    203: "limit switch",
    204: "locked by an alarm",
    205: "shut down",
    206: "panic",
    220: "beyond the travel",
}
FILL = 200  # bytes: below the 80 % of 254 at which it says XOFF
AXES = "xyzabc"
WORK = ("g54", "g55", "g56", "g57", "g58", "g59", "g92")
# What is in force, by number (canonical_machine.h). Offsets come in the unit in force, the place in
# mm whatever it is (config_app.c: g54x has the flag c, and mpox has not).
MODES = {
    "unit": ("G20", "G21"),
    "dist": ("G90", "G91"),
    "plan": ("G17", "G18", "G19"),
    "coor": ("", "G54", "G55", "G56", "G57", "G58", "G59"),
}
STAND = b'{"sr":null}'  # asked at the end, answered for us when the machine stands
PLACE = b'{"mpo":null}'
DOES = {
    "hold": "it was told to hold (!): ~ executes what it has, % behind the hold drops it",
    "stop": (
        "a hold and a flush (!%) were sent: it slows down, drops what was not executed, and keeps"
        " its position"
    ),
}
DWELL = re.compile(rb"G0*4(?![0-9.]).*?P([0-9]+\.?[0-9]*|\.[0-9]+)")
SLOW = re.compile(rb"G28\.[234]|G30\.[234]|G38")


def checksum(text: str) -> int:
    """Java's hash of strings, 32 bits, modulo 9999."""
    value = 0
    for byte in text.encode("latin-1"):
        value = (31 * value + byte) & 0xFFFFFFFF
    return value % 9999


def recognises(banner: str) -> bool:
    """Its JSON: a footer, a report, its name; not g2core, which says so by its version of 100 and
    above."""
    if re.search(r"g2core|\"fb\":1[0-9]{2}\.", banner):
        return False
    return bool(re.search(r"\"f\":\[\d+,\d+,\d+|\{\"sr\":\{|tinyg \[(?:mm|inch)\]", banner))


class TinyG(Protocol):
    """One connection. `counting`: keep its receive buffer filled; else one line at a time."""

    title = TITLE
    confirms = "answers"
    modal = True
    questions: tuple[bytes, ...] = (
        b'{"ej":1}', b'{"jv":null}', b'{"jv":5}', b'{"sys":null}',
        *(b'{"%s":null}' % n.encode() for n in MODES),
        *(b'{"%s":null}' % n.encode() for n in WORK), STAND, PLACE,
    )  # fmt: skip
    opening: tuple[bytes, ...] = ()
    lines = 1 << 20  # that may wait for an answer
    fill = FILL
    counts = True  # its footers say how many bytes it took
    does: Mapping[str, str] = DOES
    urgents: Mapping[str, bytes] = {"hold": b"!", "resume": b"~", "stop": b"!%"}

    def __init__(self, counting: bool = True):
        self.counting = counting
        self.controller = Controller(self.title, window=self.fill, line_limit=200, planner=28)
        self._verbosity: int | None = None
        self._rest = b""
        self._held = False  # it has said XOFF
        self._state: dict[str, Any] = {}
        # s of dwells among the lines that its planner and its buffer may hold: it reports nothing
        # while it dwells, and answers no line behind the planner's last
        self._dwells: deque[float] = deque(maxlen=self.controller.planner + self.fill // 2)
        self.forget()

    @property
    def closing(self) -> tuple[bytes, ...]:  # type: ignore[override]
        back = () if self._verbosity in (None, 5) else (b'{"jv":%d}' % (self._verbosity or 0),)
        return (STAND, PLACE, *back)

    # -- lines out ---------------------------------------------------------------------------------

    def prepare(self, text: bytes) -> bytes:
        """Without comments and blanks, upper case: as it will be echoed."""
        text = text.strip()
        if not text or text.startswith(b"%"):
            return b""
        text = BLANKS.sub(b"", COMMENT.sub(b"", text)).lstrip(b"/").upper()
        if found := REALTIME.search(text):
            raise Unsendable(
                f"the line has {found[0]!r} in it, which {self.controller.name} would obey at once"
                " wherever it stands",
                "take it out; in comments it does no harm",
            )
        if text[:1] in (b"$", b"?", b"H", b"{"):
            raise Unsendable(
                "the line is a setting and no block", "set it before the job, and take the line out"
            )
        if len(text) > self.controller.line_limit:
            raise Unsendable(
                f"the line has {len(text)} characters, and {self.controller.name} takes"
                f" {self.controller.line_limit}",
                "shorten it: drop digits beyond the machine's resolution",
            )
        return text

    def alone(self, text: bytes) -> bool:
        return text.startswith(b"{") or bool(
            re.search(rb"M(?:2|30|0|1|60)(?![0-9])|G10(?![0-9])", text)
        )

    def ready(self, text: bytes) -> bool:
        if not self._waiting:
            return True
        if not self.counting or self.alone(text) or self.alone(self._waiting[-1][1]):
            return False
        return (
            len(self._waiting) < self.lines and self.used + len(text) + 1 <= self.controller.window
        )

    def send(self, number: int, text: bytes) -> bytes:
        self._waiting.append((number, text))
        dwell = DWELL.search(text)
        self._dwells.append(float(dwell[1]) if dwell else 0.0)
        return text + b"\n"

    def release(self) -> int:
        return 0 if self._held else UNLIMITED

    def outstanding(self) -> list[int]:
        return [number for number, _ in self._waiting]

    @property
    def used(self) -> int:
        """Bytes that may be in the controller's buffer."""
        return sum(len(text) + 1 for _, text in self._waiting)

    def patience(self, text: bytes) -> float:
        return (300.0 if SLOW.search(text) else 10.0) + sum(self._dwells)

    def overdue(self) -> bytes:
        """A question may be asked again; a block never."""
        if not self._waiting or not self._waiting[0][1].startswith(b"{") or self._repeats >= 5:
            return b""
        self._repeats += 1
        # a line end first: what may be left of the question as it was sent ends there
        return b"\n" + self._waiting[0][1] + b"\n"

    def forget(self) -> None:
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._stands_asked = False
        self._repeats = 0

    # -- answers in --------------------------------------------------------------------------------

    def receive(self, data: bytes) -> list[Event]:
        # XON and XOFF may stand anywhere, in the middle of an answer too: they are taken out first.
        for byte in data:
            if byte in (XON, XOFF):
                self._held = byte == XOFF
        data = data.translate(None, bytes((XON, XOFF)))
        texts, self._rest = answers(self._rest, data)
        events: list[Event] = []
        # one after the other: what an answer means may follow from the one before
        for text in texts:
            events += self._meaning(text)
        return events

    def _meaning(self, text: str) -> list[Event]:
        try:
            value = json.loads(text)
        except (ValueError, RecursionError):
            value = None
        match value:
            case {"r": said}:
                body = said if isinstance(said, dict) else {}
                footer = value.get("f", body.pop("f", None))
                if footer_is_good(footer, text):
                    return self._answer(text, body, footer)
            case {"sr": dict(report)}:
                return self._report(report)
            case {"er": said}:
                return [Alarm(text, str(said.get("msg", "")) if isinstance(said, dict) else "")]
            case {"qr": _}:
                return [Busy(text)] if self._stands_asked else []
        return [Message(text)]

    def _answer(self, text: str, body: dict[str, Any], footer: list[int]) -> list[Event]:
        if "SYSTEM READY" in str(body.get("msg", "")):
            self.forget()
            self._held = False
            return [Restarted(text)]
        if not self._waiting:
            return [Stray(text)]
        number, sent = self._waiting[0]
        wrong = self._differs(sent, body, footer)
        if wrong == "repeated":
            return [Message(text)]
        if wrong:
            return [Altered(number, wrong)]
        if footer[1] not in TAKEN:
            self._waiting.popleft()
            return [
                Rejected(
                    number, f"status {footer[1]}", MEANINGS.get(footer[1], str(body.get("msg", "")))
                )
            ]
        events: list[Event] = [Message(text)] if sent.startswith(b"{") else []
        if sent == STAND:
            self._stands_asked = True
            return events + self._report(body["sr"])
        self._waiting.popleft()
        if sent == PLACE and (place := numbers(body["mpo"])):
            events.append(Status("idle", place=place))
        self._repeats = 0
        return [*events, Accepted(number)]

    def _differs(self, sent: bytes, body: dict[str, Any], footer: list[int]) -> str:
        """What was read that was not sent, in words; "": nothing; "repeated": an answer to a
        question asked before."""
        block = body.get("gc")
        if sent.startswith(b"{"):
            if next(iter(json.loads(sent))) in body:
                return ""
            return str(block) if "gc" in body else "repeated"
        return self._differs_from_block(sent, body, footer)

    def _differs_from_block(self, sent: bytes, body: dict[str, Any], footer: list[int]) -> str:
        block, counted = body.get("gc"), len(sent) + 1
        if block is None:
            if not body.keys().isdisjoint(("sr", "mpo", "jv", *MODES, *WORK)):
                return "repeated"
            whole = footer[0] == 3 or footer[2] == counted
            return "" if whole or not self.counts else f"{footer[2]} bytes"
        if BLANKS.sub(b"", str(block).encode("latin-1", "replace")).upper() != sent:
            return str(block)
        whole = footer[0] != 1 or footer[2] in (0, counted)
        return "" if whole or not self.counts else f"{block}, {footer[2]} bytes"

    def _report(self, report: dict[str, Any]) -> list[Event]:
        self._state |= report
        known = self._state.get("stat")
        state = STATES.get(known, str(known)) if isinstance(known, int) else ""
        if state == "alarm":
            return [Alarm(f"state {known}", "it has locked itself")]
        events: list[Event] = []
        if state:
            feed = self._state.get("vel")
            events.append(Status(state, feed=feed if isinstance(feed, int | float) else None))
        if self._stands_asked and self._waiting and self._waiting[0][1] == STAND:
            if state == "idle":
                self._stands_asked = False
                events.append(Accepted(self._waiting.popleft()[0]))
            else:
                events.append(Busy(state))
        elif state in ("run", "hold", "home"):
            events.append(Busy(state))
        return events

    def learn(self, question: bytes, answers: list[str]) -> None:
        for text in answers:
            try:
                body = json.loads(text).get("r", {})
            except (ValueError, AttributeError, RecursionError):
                continue
            verbosity, system = body.get("jv"), body.get("sys")
            if question == b'{"jv":null}' and isinstance(verbosity, int):
                self._verbosity = verbosity if self._verbosity is None else self._verbosity
            if isinstance(system, dict):
                self.controller.version = f"{system.get('fv', '')} build {system.get('fb', '')}"
                self.controller.settings |= {k: str(v) for k, v in system.items()}
            self._learn_modes(body)
            self._learn_offsets(body)

    def _learn_modes(self, body: dict[str, Any]) -> None:
        c = self.controller
        for name, words in MODES.items():
            value = body.get(name)
            if isinstance(value, int | float) and 0 <= int(value) < len(words):
                c.modal.append(words[int(value)])
                c.inches = c.inches or words[int(value)] == "G20"

    def _learn_offsets(self, body: dict[str, Any]) -> None:
        for name in WORK:
            if place := ",".join(
                f"{v:.{4 if self.controller.inches else 3}f}" for v in numbers(body.get(name))
            ):
                self.controller.offsets.append(f"[{name.upper()}:{place}]")


def footer_is_good(footer: Any, text: str) -> bool:
    """Whether it is one, and its checksum, where it has one, is that of the text before it."""
    if not isinstance(footer, list) or len(footer) < 3:
        return False
    if not all(isinstance(v, int) for v in footer):
        return False
    return len(footer) < 4 or checksum(text[: text.rindex(",")]) == footer[3]


def numbers(group: Any) -> tuple[float, ...]:
    """The values of a group in the order of axes; (): it is no group of numbers."""
    if not isinstance(group, dict) or not all(
        isinstance(group.get(x, 0), int | float) for x in AXES
    ):
        return ()
    return tuple(float(group[x]) for x in AXES if x in group)


PROTOCOL = TinyG
