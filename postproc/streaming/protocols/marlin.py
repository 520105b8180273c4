"""Marlin 1.1 and 2: numbered lines with checksums, resends, busy, temperature reports in between;
no realtime bytes.

Formats: MarlinFirmware/Marlin, Marlin/src/core/language.h (Error:, echo:, busy:, Resend:, start),
gcode/queue.cpp (ok N P B of ADVANCED_OK, wait of NO_TIMEOUTS, a line of 95 characters),
gcode/host/M114.cpp and module/motion.cpp (place in the program's coordinates, then the steppers'
counts), gcode/host/M115.cpp. The window is one line; with ADVANCED_OK it is the number of command
slots that it reports, and never more than 127 bytes (receive buffer of 128, which drops what does
not fit: MarlinFirmware issue 20367). There is no feed hold: a hold sends nothing more, and what is
planned is executed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from postproc.streaming.events import Alarm, Busy, Event, Message
from postproc.streaming.protocols import Controller
from postproc.streaming.protocols._numbered import NUDGES, TEMPERATURE, Numbered

TITLE = "Marlin"
POKE = b"\nM115\n"
NAME = re.compile(
    r"FIRMWARE_NAME:\s*((?:Virtual )?\S*Marlin\S*)\s*([0-9][^\s(]*|bugfix\S*)?", re.IGNORECASE
)
SETTING = re.compile(r"(?:echo:)?\s*M(\d+)((?: +[A-Z]-?\d+(?:\.\d+)?)+)")
INCHES = re.compile(r"(?:echo:)?\s*G20\b")
WORD = re.compile(r"([A-Z])(-?\d+(?:\.\d+)?)")
COUNT = re.compile(r"Count:? +X: *(-?\d+) +Y: *(-?\d+) +Z: *(-?\d+)")
SLOW = re.compile(
    rb"(?:G(?:28|29|30|33|34|76|425)|M(?:0|1|109|190|191|192|226|303|400|600))(?![0-9])"
)
DWELL = re.compile(rb"G0*4(?![0-9.]).*?([PS]) *([0-9]+\.?[0-9]*)")
QUIET = 30.0  # s that a line may take where it does not say that it is busy
KEEPALIVE = 8.0  # and where it does: every 2 s (Configuration_adv.h)
LONG = 600.0  # and what takes its time; until then it is sent again every QUIET, which does no harm
DOES = {
    "hold": "it has no feed hold: no further line was sent, and what it has it executes",
    "stop": (
        "M410 was sent: the steppers stop without slowing down, so that steps may be lost, and a"
        " build without EMERGENCY_PARSER first executes the lines that it has; home it before the"
        " next job"
    ),
}


def recognises(banner: str) -> bool:
    """Its answer to M115, or the name it starts with."""
    if re.search(
        r"smoothie|FIRMWARE_NAME:\s*(?:Repetier|RepRapFirmware|Klipper)", banner, re.IGNORECASE
    ):
        return False
    return bool(NAME.search(banner) or re.search(r"^(?:echo:\s*)?Marlin[ :]", banner, re.MULTILINE))


class Marlin(Numbered):
    """One connection. `counting`: fill its command slots where it reports them."""

    title = TITLE
    does: Mapping[str, str] = DOES
    questions = (b"M115", b"M113", b"M503 S0", b"M114")

    def __init__(self, counting: bool = True):
        super().__init__(counting, Controller(self.title, window=1, line_limit=80, planner=20))
        self._alive = self._paused = False
        self._steps: tuple[float, ...] = ()
        self._zero: tuple[float, ...] = ()

    def patience(self, text: bytes) -> float:
        if self._alive:
            return KEEPALIVE
        if dwell := DWELL.match(text):
            return QUIET + float(dwell[2]) / (1000.0 if dwell[1] == b"P" else 1.0)
        return QUIET

    def nudges(self, text: bytes) -> int:
        return int(LONG / QUIET) if SLOW.match(text) else NUDGES

    def urgent(self, what: str) -> bytes:
        """Marlin looks for these as they come in (EMERGENCY_PARSER), else as soon as it reads
        them."""
        if what == "stop":
            return b"\nM410\nM410\n"
        if what == "resume" and self._paused:
            self._paused = False
            self._spare += not self._numbers
            self._bare += self._numbers
            return b"M108\n"
        return b""

    def _other(self, text: str) -> list[Event]:
        if "busy:" in text:
            self._alive = True
            self._paused = "paused for" in text
            return [Busy(text)]
        if text == "start":
            return self.restarted(text)
        if re.match(r"error:", text, re.IGNORECASE):
            return (
                [Message(text)]
                if "RX BUF overflow" in text
                else [Alarm(text, "the firmware has stopped")]
            )
        if text.startswith("!!"):
            return [Alarm(text, "the firmware has stopped")]
        return [] if TEMPERATURE.match(text) else [Message(text)]

    def place(self, logical: tuple[float, ...], rest: str) -> tuple[float, ...] | None:
        """From the steppers' counts: of Cartesian machines whose steps per mm are known."""
        count = COUNT.search(rest)
        if not count or not self._steps:
            return None
        # steps over steps per mm (M92): where the motors are, in machine coordinates; what stands
        # before Count is the program's place, and the difference of both its zero
        place = tuple(int(count[i + 1]) / self._steps[i] for i in range(3))
        self._zero = tuple(round(m - w, 3) for m, w in zip(place, logical, strict=True))
        return place

    def _learn_settings(self, answers: list[str]) -> None:
        c = self.controller
        for found in filter(None, map(SETTING.match, answers)):
            c.settings.setdefault("M" + found[1], found[2].strip())
        values = {k: {a: float(v) for a, v in WORD.findall(text)} for k, text in c.settings.items()}
        steps = tuple(values.get("M92", {}).get(x, 0.0) for x in "XYZ")
        if any(map(INCHES.match, answers)):
            # M503 divides its lengths by 25.4 then, and the steps too (LINEAR_UNIT): where it
            # stands is not told by them
            c.modal = ["G20"]
        elif min(steps) > 0:
            self._steps = steps
        c.compensates = compensates(values)

    def learn(self, question: bytes, answers: list[str]) -> None:
        c = self.controller
        if question == b"M115":
            for found in filter(None, map(NAME.search, answers)):
                c.name, c.version = found[1], found[2] or ""
        elif question == b"M113":
            self._alive = any(re.match(r"(?:echo:)?M113 S[1-9]", text) for text in answers)
        elif question == b"M503 S0":
            self._learn_settings(answers)
        elif question == b"M114" and self._zero:
            c.offsets = [f"[G54:{','.join(f'{v:.3f}' for v in self._zero)}]"]


def compensates(settings: dict[str, dict[str, float]]) -> list[str]:
    """What the firmware corrects by itself, in words, from the report of M503."""
    found = []
    if settings.get("M420", {}).get("S", 0.0):
        found.append("levelling of the bed (M420 S1)")
    backlash = settings.get("M425", {})
    if backlash.get("F", 0.0):
        found += [
            f"backlash of {x}, {backlash[x] * 1000:g} um (M425)" for x in "XYZ" if backlash.get(x)
        ]
    skew = settings.get("M852", {})
    if any(skew.get(k) for k in "IJK"):
        found.append("axes that are not square (M852)")
    return found


PROTOCOL = Marlin
