"""Smoothieware: numbered lines with checksums as Marlin, one at a time; status, hold and stop by
single bytes as GRBL.

From Smoothieware/Smoothieware, src/modules/communication/GcodeDispatch.cpp: "rs N<n>" asks for a
line and has no ok behind it; a line with several G and M codes gets one ok (grbl_mode, ok_per_line)
or one for each code up to a G1, which is asked for before the job; an empty line gets an ok, so
none is sent; an error halts it ("!!", "error:Alarm lock"). src/libs/Kernel.cpp:
`<Idle|MPos:..|WPos:..>`, earlier with commas. An ok may stand behind a report without a line end
between (its issue 1453). Places are reported in the unit in force (from_millimeters there), which
`$G` says (src/modules/utils/simpleshell). `!` and `~` work where feed hold is built in (unverified
on hardware); ^X halts until M999.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from postproc.streaming.events import Alarm, Event, Message, Rejected, Status
from postproc.streaming.protocols import Controller
from postproc.streaming.protocols._numbered import Frame, Numbered

TITLE = "Smoothieware"
POKE = b"version\n"
REPORT = re.compile(r"<([A-Za-z]+)[|,]([^<>]*)>")
PLACE = re.compile(r"MPos:(-?\d+\.\d+),(-?\d+\.\d+),(-?\d+\.\d+)(?![\d.])")
WORK = re.compile(r"WPos:(-?\d+\.\d+),(-?\d+\.\d+),(-?\d+\.\d+)(?![\d.])")
HALT = re.compile(
    r"!!|ALARM|error:|.*(?:Entering Alarm/Halt|HALTED|Emergency Stop|Kill button|Limit switch)",
    re.IGNORECASE,
)
URGENT = {"status": b"?", "hold": b"!", "resume": b"~", "stop": b"\x18"}
DOES = {
    "hold": (
        "it was told to hold (!), where feed hold is built in: ~ executes what it has, Ctrl-X"
        " halts it"
    ),
    "stop": (
        "Ctrl-X was sent, which halts it and drops what was not executed: M999 clears that; home it"
        " first"
    ),
}
ASKS_MODES = b"$G"
MODES = re.compile(r"\[(?:GC:)?(G[^\]]*)\]")
UNITS = re.compile(rb"G2([01])(?![0-9.])")
DWELL = re.compile(rb"G0*4(?![0-9.]).*?([PS]) *([0-9]+\.?[0-9]*)")
PROBE = b"G4 P0 G4 P0"  # two codes that do nothing: how many oks come?


def recognises(banner: str) -> bool:
    """Its name, its build, or a report with both positions, as GRBL never makes it."""
    return bool(re.search(r"smoothie|Build version:.*Build date:", banner, re.IGNORECASE)) or any(
        "MPos:" in found[2] and "WPos:" in found[2] for found in REPORT.finditer(banner)
    )


class Smoothieware(Numbered):
    """One connection; `counting` changes nothing: it loses lines that come before it has
    answered."""

    confirms = "idle"
    does: Mapping[str, str] = DOES
    urgents: Mapping[str, bytes] = URGENT
    questions = (PROBE, b"M115", b"M114", ASKS_MODES)
    closing = (b"M400",)
    forbidden = re.compile(rb"M(?:110|112|28|29|1000)(?![0-9])", re.IGNORECASE)
    own_ok = False
    # without its star a line would pass unchecked, and its checksum be read into its last number
    gap = b" "
    # no checksum is 999: what may be left of a line is refused, where a mere line end would have it
    # executed
    anew = b"*999\n"

    def __init__(self, counting: bool = True):
        super().__init__(False, Controller(TITLE, window=1, line_limit=110, planner=32))
        self._each = False  # it answers every code of a line
        self._named = False
        self._fragments = 0  # answers to come for what is no line

    def prepare(self, text: bytes) -> bytes:
        text = super().prepare(text)
        return (
            text.replace(b"!", b"").replace(b"?", b"").replace(b"~", b"")
            if text.startswith(b"M117")
            else text
        )

    def patience(self, text: bytes) -> float:
        # while it dwells it reports Idle; P is ms, in grbl_mode seconds
        dwell = DWELL.search(text)
        return super().patience(text) + (float(dwell[2]) if dwell and dwell[1] == b"S" else 0.0)

    def overdue(self) -> bytes:
        data = super().overdue()
        self._fragments += bool(data)
        return data

    def answers(self, text: bytes) -> int:
        if not self._each:
            return 1
        n = 0
        while text:
            # as it goes through a line, code by code; behind G1 and G53 it looks for none
            code = re.match(rb"G0*(\d+)", text)
            n += 1
            if code and code[1] in (b"1", b"53"):
                break
            nexts = [i for i in (text.find(b"G", 2), text.find(b"M", 2)) if i > 0]
            text = text[min(nexts) :] if nexts else b""
        return max(1, n)

    def _probed_twice(self) -> bool:
        """Whether an ok is the second one of PROBE: that of M115 comes behind its name."""
        asked = self._waiting[0].text if self._waiting else b"M115"
        probed = any(x.text == PROBE for x in self._known)
        return asked == b"M115" and not self._named and probed

    def _meaning(self, text: str) -> list[Event]:
        events: list[Event] = []
        if found := REPORT.match(text):
            events = [self._report(text, found)]
            text = text[found.end() :].strip()
            if not text:
                return events
        if text == "ok" and self._probed_twice():
            self._each = True
            return events
        # no line of ours, for ours begin with N: the rest of one that was cut, or `anew`
        if text == "ok - ignored":
            self._fragments -= 1
            cut = self._fragments < 0 and self._started
            return [
                *events,
                *(self._fault(f"{text}: it has read a line as two") if cut else [Message(text)]),
            ]
        if text.startswith("ok - "):
            text = "ok"
        return events + super()._meaning(text)

    def _taken(self, frame: Frame) -> list[Event]:
        if units := UNITS.findall(frame.text):
            self.controller.inches = units[-1] == b"0"
        return super()._taken(frame)

    def _other(self, text: str) -> list[Event]:
        if text.startswith("error:") and self._waiting and self._waiting[0].text == ASKS_MODES:
            return [Rejected(self._waiting.popleft().number, text)]  # an older build
        self._named = self._named or "FIRMWARE_NAME" in text
        if HALT.match(text):
            return [Alarm(text, "it has halted: M999 clears it, home it first")]
        if re.match(r"Smoothie(?:$| Running| command| ok)", text):
            return self.restarted(text)
        return super()._other(text)

    def _report(self, text: str, found: re.Match[str]) -> Event:
        place = PLACE.search(found[2])
        if not place:
            return Message(text)
        work = WORK.search(found[2])
        machine = [float(place[i]) for i in (1, 2, 3)]
        if work:
            zero = [m - float(work[i + 1]) for i, m in enumerate(machine)]
            digits = 4 if self.controller.inches else 3
            self.controller.offsets = [f"[G54:{','.join(f'{v:.{digits}f}' for v in zero)}]"]
        per = self.controller.unit
        return Status(found[1].lower(), place=tuple(v * per for v in machine))

    def placed(self, text: str, logical: tuple[float, ...], rest: str) -> list[Event]:
        return [Message(text)]  # the place is taken from `?`

    def learn(self, question: bytes, answers: list[str]) -> None:
        for text in answers:
            if question == ASKS_MODES and (modes := MODES.match(text)):
                self.controller.modal = modes[1].split()
                self.controller.inches = "G20" in self.controller.modal
            if found := re.search(r"FIRMWARE_VERSION:\s*([^,]+)", text):
                self.controller.version = found[1].strip()


PROTOCOL = Smoothieware
