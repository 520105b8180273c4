"""GRBL 1.1: one answer a line, a receive buffer that drops what does not fit, realtime bytes that
pass it.

Rules: gnea/grbl, doc/markdown/interface.md (streaming, EEPROM, status reports), grbl/serial.c and
protocol.c (every line end is answered; realtime bytes are taken out wherever they stand; control
characters and blanks do not count towards the 79 characters of a line, but all bytes towards the
128 of the buffer), grbl/report.c (formats).

Character counting. Lines that no answer came for yet may all be in the buffer, with their ends; a
line leaves while they and it fit the window (127, or what [OPT: says):

    leaves   G1X10.5F600   G1X11   G1X12      used 12, 18, 24, with their line ends
    comes    ok                               used 12: the oldest line is out of the buffer
    leaves   the next line, as soon as used + its length + 1 <= 127
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Mapping

from postproc.streaming.events import (
    Accepted,
    Alarm,
    Altered,
    Event,
    Message,
    Rejected,
    Restarted,
    Status,
    Stray,
)
from postproc.streaming.lines import Unsendable
from postproc.streaming.protocols import LONGEST_ANSWER, Controller, Protocol
from postproc.streaming.protocols._grbl_meanings import ALARMS, ERRORS

TITLE = "GRBL 1.1"
POKE = b"?"
COMMENT = re.compile(rb"\([^()\n]*\)|;[^\n]*|\([^()\n]*$")
BLANKS = re.compile(rb"[\x00-\x17\x19-\x20]+")
REALTIME = re.compile(rb"[!?~\x18\x80-\xff]")
ERROR = re.compile(r"error:\s*(\S.*)")
ALARM = re.compile(r"ALARM:\s*(\d+)")
BANNER = re.compile(r"Grbl \d[^\n]*\[")
WHOLE = re.compile(r"Grbl[^\n]*\[[^\n]*\]\r?\n(?:\[MSG:[^\n]*\]\r?\n)?\Z", re.IGNORECASE)
STATUS = re.compile(r"<([A-Za-z]+)(?::(\d+))?\|([^<>]*)>")
ECHO = re.compile(r"\[echo:\s*(.*)\]")
OPTIONS = re.compile(r"\[OPT:([^,\]]*)(?:,(\d+),(\d+))?[^\]]*\]")
VERSION = re.compile(r"\[VER:([^\]]*)\]")
SETTING = re.compile(r"\$(\d+)=([^ (]*)")
# EEPROM is written (interrupts are off: bytes are lost) or read; $ lines answer at length or change
# the state.
ALONE = re.compile(
    rb"\$|G0*10(?![0-9])|G0*(?:28|30)(?![0-9])|G0*5[4-9](?![0-9])|M0*(?:2|30)(?![0-9])",
    re.IGNORECASE,
)
DWELL = re.compile(rb"G0*4(?![0-9.]).*?P([0-9]+\.?[0-9]*|\.[0-9]+)", re.IGNORECASE)
SLOW = 300.0  # s: homing
# Its seconds of a dwell are a counted loop (nuts_bolts.c, delay_sec), which every report and
# interrupt makes longer: G4 P60 took 60.4 s on its real image; a ceramic resonator is off by 0.5 %
# besides.
DWELLS = 1.05
# mc_dwell and the program's stop and end wait for the planner to run empty (motion_control.c,
# gcode.c), also behind other words.
EMPTIED = re.compile(rb"G0*4(?![0-9.])|M0*(?:0|2|30)(?![0-9])", re.IGNORECASE)
URGENT = {
    "status": b"?", "hold": b"!", "resume": b"~", "stop": b"\x18", "feed 100": b"\x90",
    "feed+": b"\x91", "feed-": b"\x92", "rapid 100": b"\x95", "rapid 50": b"\x96",
    "rapid 25": b"\x97", "spindle 100": b"\x99", "spindle+": b"\x9a", "spindle-": b"\x9b",
    "spindle stop": b"\x9e", "jog cancel": b"\x85",
}  # fmt: skip
DOES = {
    "hold": "it was told to hold (!): resume (~) executes what it has, a reset (Ctrl-X) drops it",
    "stop": (
        "a reset (Ctrl-X) was sent, which drops what was not executed: home it if it moved when it"
        " was stopped"
    ),
}
FIELDS = {"MPos", "WPos", "WCO", "F", "FS", "Bf", "Ln", "Ov"}  # of a report, that are read
STATES = {"idle", "run", "hold", "jog", "alarm", "door", "check", "home", "sleep", "tool"}


def recognises(banner: str) -> bool:
    """Whether it is GRBL itself; a status report alone is taken for GRBL until $I says more."""
    if re.search(r"fluidnc|grblhal|smoothie", banner, re.IGNORECASE) or re.search(
        r"MPos:[^<>]*WPos:", banner
    ):
        return False
    return bool(BANNER.search(banner) or STATUS.search(banner) or re.search(r"\[VER:1\.1", banner))


def _fields(text: str) -> dict[str, list[float]]:
    """Numbers of a report by name; {} of one that was cut or damaged on the way."""
    parts = (part.partition(":") for part in text.split("|"))
    try:
        return {n: [float(v) for v in s.split(",")] for n, _, s in parts if n in FIELDS}
    except ValueError:
        return {}


class Grbl(Protocol):
    """One connection. `counting`: keep the receive buffer full; else one line at a time."""

    title = TITLE
    confirms = "idle"
    modal = True
    exact = True  # it rounds no corner, and says where it is while it moves
    does: Mapping[str, str] = DOES
    urgents: Mapping[str, bytes] = URGENT
    questions: tuple[bytes, ...] = (b"$I", b"$$", b"$#", b"$G")
    opening: tuple[bytes, ...] = ()
    closing: tuple[bytes, ...] = ()
    default_window, default_line = 127, 79
    banner = BANNER
    segments = 5  # stepper.h: a ring of 6
    keep = 0  # bytes of the announced buffer that can not be used
    errors, alarms = ERRORS, ALARMS

    def __init__(self, counting: bool = True):
        self.counting = counting
        self.controller = Controller(
            self.title,
            window=self.default_window,
            line_limit=self.default_line,
            segments=self.segments,
        )
        self._waiting: deque[tuple[int, int, bytes]] = deque()  # number, bytes on the wire, text
        self._used = 0
        self._alone = False
        self._rest = b""
        # whether it echoes lines at all, and has echoed the oldest one
        self._echoes = self._echoed = False
        # work coordinate offset, for reports of work positions
        self._shift: tuple[float, ...] | None = None

    # -- lines out ---------------------------------------------------------------------------------

    def prepare(self, text: bytes) -> bytes:
        """Without comments, block delete and blanks at the ends; without any blanks where it would
        be too long."""
        text = text.strip()
        if text[:1] in (b"", b"%"):
            return b""
        if not text.startswith(b"$") and (b"(" in text or b";" in text):
            text = COMMENT.sub(b"", text).strip()
        text = text.lstrip(b"/").strip()
        if found := REALTIME.search(text):
            byte = found[0][0]
            what = f"byte {byte}" if byte >= 127 or byte < 32 else repr(chr(byte))
            raise Unsendable(
                f"the line has {what} in it, which {self.controller.name} would obey at once"
                " wherever it stands",
                "take it out; in comments it does no harm",
            )
        limit = self.controller.line_limit
        most = min(limit, self.controller.window - 1)
        if len(text) <= most:
            return text
        bare = BLANKS.sub(b"", text)
        if len(bare) > most:
            raise Unsendable(
                f"the line has {len(bare)} characters, and {self.controller.name} takes {limit}",
                "shorten it: drop N words and digits beyond the machine's resolution, or split it",
            )
        return bare

    def alone(self, text: bytes) -> bool:
        return bool(ALONE.search(BLANKS.sub(b"", text)))

    def ready(self, text: bytes) -> bool:
        if not self._waiting:
            return True
        if self._alone or not self.counting or self.alone(text):
            return False
        return self._used + len(text) + 1 <= self.controller.window

    def send(self, number: int, text: bytes) -> bytes:
        data = text + b"\n"
        self._waiting.append((number, len(data), text))
        self._used += len(data)
        self._alone = self.alone(text)
        return data

    def outstanding(self) -> list[int]:
        return [number for number, _, _ in self._waiting]

    @property
    def used(self) -> int:
        """Bytes that may be in the controller's buffer."""
        return self._used

    def patience(self, text: bytes) -> float:
        if text.upper().startswith(b"$H"):
            return SLOW
        dwell = DWELL.search(BLANKS.sub(b"", text))
        return 2.0 + (DWELLS * float(dwell[1]) if dwell else 0.0)  # while it dwells it reports Idle

    def emptied(self, text: bytes) -> bool:
        return bool(EMPTIED.search(BLANKS.sub(b"", text)))

    def forget(self) -> None:
        self._waiting.clear()
        self._used, self._alone, self._echoed = 0, False, False

    def check_mode(self) -> bytes:
        return b"$C"

    # -- answers in --------------------------------------------------------------------------------

    def receive(self, data: bytes) -> list[Event]:
        *lines, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > LONGEST_ANSWER:
            lines, self._rest = [*lines, self._rest], b""
        events = []
        for line in lines:
            text = line.strip(b"\r\0").decode("latin-1")
            if text.strip():
                events.append(self._meaning(text))
        return events

    def _meaning(self, text: str) -> Event:
        if text == "ok":
            said = self._echoed
            number = self._answered()
            if number is not None and self._echoes and not said:
                return Altered(number, "")
            return Stray(text) if number is None else Accepted(number)
        for pattern, reader in self._readers():
            if found := pattern.fullmatch(text):
                return reader(text, found)
        if self.banner.match(text):
            self.forget()
            return Restarted(text)
        return Message(text)

    def _readers(self) -> list[tuple[re.Pattern[str], Callable[[str, re.Match[str]], Event]]]:
        return [
            (STATUS, self._status),
            (ERROR, self._error),
            (ALARM, self._alarm),
            (ECHO, self._echo),
        ]

    def _answered(self) -> int | None:
        if not self._waiting:
            return None
        # An answer names no line. They come in the order of the lines, so it is the oldest one's:
        # that line has left the buffer, and its bytes are free.
        number, size, _ = self._waiting.popleft()
        self._echoed = False
        self._used -= size
        self._alone = self._alone and bool(self._waiting)
        return number

    def _error(self, text: str, found: re.Match[str]) -> Event:
        number = self._answered()
        if number is None:
            return Stray(text)
        code = found[1].strip()
        return Rejected(number, text, self.errors.get(int(code), "") if code.isdigit() else "")

    def _alarm(self, text: str, found: re.Match[str]) -> Event:
        return Alarm(text, self.alarms.get(int(found[1]), ""))

    def _echo(self, text: str, found: re.Match[str]) -> Event:
        """The line as the controller read it (a build with REPORT_ECHO_LINE_RECEIVED), said before
        it is executed: the oldest one that waits. One that echoes does so for every line, so that
        an answer without an echo tells of a loss."""
        self._echoes = True
        if self._waiting:
            number, _, sent = self._waiting[0]
            self._echoed = True
            if found[1].strip() != BLANKS.sub(b"", sent).decode("latin-1").upper():
                return Altered(number, found[1].strip())
        return Message(text)

    def _status(self, text: str, found: re.Match[str]) -> Event:
        state, fields = found[1].lower(), _fields(found[3])
        if state not in STATES or fields.keys().isdisjoint(("MPos", "WPos")):
            return Message(text)
        per = self.controller.unit
        # Only some reports say it (report.c counts down between two), so the last one holds.
        if "WCO" in fields:
            self._shift = tuple(v * per for v in fields["WCO"])
        feed, speed = (*fields.get("FS", fields.get("F", ())), None, None)[:2]
        planner, room = ([int(v) for v in fields.get("Bf", ())] + [0, 0])[:2]
        return Status(
            state, found[2] or "", self._machine_place(fields, per),
            None if feed is None else feed * per, speed,
            (planner, room) if len(fields.get("Bf", ())) == 2 else None,
            int(fields["Ln"][0]) if "Ln" in fields else None, tuple(fields.get("Ov", ())),
            self._shift,
        )  # fmt: skip

    def _machine_place(
        self, fields: dict[str, list[float]], per: float
    ) -> tuple[float, ...] | None:
        """Machine coordinates of a report, mm; None where it has those of the work alone, and how
        far these are shifted is not known."""
        if "MPos" in fields:
            return tuple(v * per for v in fields["MPos"])
        if self._shift is None or len(self._shift) != len(fields["WPos"]):
            return None
        return tuple(v * per + s for v, s in zip(fields["WPos"], self._shift, strict=True))

    # -- what it says of itself --------------------------------------------------------------------

    def _learn_build(self, answers: list[str]) -> None:
        """Version, options, and the sizes of planner and receive buffer."""
        c = self.controller
        for text in answers:
            if version := VERSION.match(text):
                c.version = version[1].rstrip(":")
            if options := OPTIONS.match(text):
                c.flags = options[1]
                if options[3]:
                    # [OPT:V,15,128]: 15 blocks, and one more that is just being taken (account.py)
                    c.planner = int(options[2]) + 1
                    c.window = max(16, int(options[3]) - self.keep)

    def _learn_settings(self, answers: list[str]) -> None:
        c = self.controller
        found = filter(None, map(SETTING.match, answers))
        c.settings |= {setting[1]: setting[2].strip() for setting in found}
        c.inches = c.settings.get("13", "0").split(".")[0] == "1"
        if "22" in c.settings:
            c.homing = c.settings["22"].split(".")[0] not in ("0", "")
        c.compensates = self.compensates(c.settings)

    def learn(self, question: bytes, answers: list[str]) -> None:
        c = self.controller
        if question == b"$I":
            self._learn_build(answers)
        elif question in (b"$$", b"$+"):
            self._learn_settings(answers)
        elif question == b"$#":
            c.offsets = [a for a in answers if a.startswith("[") and not a.startswith("[MSG")]
        elif question == b"$G":
            for text in answers:
                if text.startswith("[GC:"):
                    c.modal = text[4:].rstrip("]").split()

    def compensates(self, settings: dict[str, str]) -> list[str]:
        """What the control corrects by itself, in words; GRBL nothing."""
        return []


PROTOCOL = Grbl
