"""TinyG's side of the wire, in simulated time: JSON answers with footers, reports, a receive buffer
that says XOFF and drops.

From synthetos/TinyG: wiki "JSON Operation" (footer of revision 1 with its checksum: the documented
answers are reproduced by tests/streaming/test_tinyg.py), "Status Reports" (states, filtered
reports), firmware/tinyg/controller.c (a line is read when the planner has room; single characters
are taken out as they arrive), xio (254 bytes, XOFF at 80 %, XON at 20 %).
"""

from __future__ import annotations

import json
import re
from collections import deque

from tests.streaming.models_wire import NEVER, Moves, Receiver

WORD = re.compile(r"([A-Z])([-+]?\d*\.?\d*)")
KNOWN = {
    "G0",
    "G1",
    "G2",
    "G3",
    "G4",
    "G17",
    "G20",
    "G21",
    "G28.2",
    "G54",
    "G55",
    "G90",
    "G91",
    "G94",
    "M3",
    "M5",
    "M2",
    "M30",
    "M0",
}
PARSE, REPORT = 0.002, 0.25
READY = (
    '{"r":{"fv":0.970,"fb":440.20,"hp":1,"hv":8,"id":"3X3566-YMB","msg":"SYSTEM'
    ' READY"},"f":[1,0,0,%d]}'
)


def java_hash(text: str) -> int:
    value = 0
    for byte in text.encode("latin-1"):
        value = (value * 31 + byte) % (1 << 32)
    return value % 9999


class TinyGModel(Receiver):
    """`executed`: blocks in order. revision: of the footer (1 with a checksum, 2 without)."""

    def __init__(
        self,
        baud: int = 115200,
        rx: int = 254,
        verbosity: int = 3,
        revision: int = 1,
        flow: bool = True,
        blocks: int = 28,
        reports: bool = True,
        g2: bool = False,
    ):
        super().__init__(baud, rx)
        self.verbosity, self.revision, self.flow, self.reports, self.g2 = (
            verbosity,
            revision,
            flow,
            reports,
            g2,
        )
        self.blocks = blocks
        self.moves = Moves(blocks)
        self.work = {"g54": [0.0, 0.0, 0.0]}
        self.modes = {"unit": 1, "dist": 0, "plan": 0, "coor": 1}
        self.dwells: list[tuple[float, float]] = []
        self.most_lines = 0
        self._reset()
        self._ready()

    def _reset(self) -> None:
        self.rx.clear()
        self._line = bytearray()
        self._free = self.now
        self._off = self._hold = False
        self._said = -1
        self._report_at = NEVER
        self._pending: deque[str] = deque()

    def _ready(self) -> None:
        text = READY.rsplit(",", 1)[0]
        if self.g2:
            text = text.replace("440.20", "100.26")
        self.say(f"{text},{java_hash(text)}]}}\n")

    def restart(self) -> None:
        self.moves = Moves(self.blocks)
        self._reset()
        self._ready()

    @property
    def place(self) -> list[float]:
        return self.moves.place

    def state(self) -> int:
        self.moves.clear(self.now)
        return 6 if self._hold else 5 if self.moves.ends else 3 if self.executed else 1

    # -- time --------------------------------------------------------------------------------------

    def _arrive(self, value: int) -> None:
        if value in b"!~%\x04\x18":
            self._at_once(value)
            return
        self.keep(value)
        if self.flow and not self._off and len(self.rx) > 0.8 * self.rx_size:
            self._off = True
            self.say(b"\x13")

    def _at_once(self, value: int) -> None:
        if value == ord("!") and self.state() == 5:
            self._hold, self._left = True, [t - self.now for t in self.moves.ends]
        elif value == ord("~") and self._hold:
            self._hold = False
            self.moves.ends = deque(self.now + t for t in self._left)
            self.moves.last = max(self.moves.ends, default=self.now)
        elif value in b"%\x04" and (self._hold or value == 4):
            self._hold = False
            self.moves.ends.clear()
            self.moves.last = self.now
            self.rx.clear()
        elif value == 0x18:
            self.restart()

    def _next(self) -> float:
        times = [NEVER]
        if not self._hold:
            if self.rx:
                times.append(max(self._free, self.moves.room_at(self.now)))
            if self.moves.ends:
                times.append(self.moves.ends[-1])
        if self.reports and self.state() != self._said and self._report_at == NEVER:
            self._report_at = self.now
        times.append(self._report_at)
        return min(times)

    def _act(self) -> None:
        if self._report_at <= self.now and any(a < self.now < b for a, b in self.dwells):
            self._report_at = self.now + REPORT  # nothing changes: a filtered report is empty
            return
        if self._report_at <= self.now:
            state, self._said, self._report_at = self.state(), self.state(), NEVER
            self.say(
                json.dumps(
                    {
                        "sr": {
                            "posx": round(self.place[0], 3),
                            "vel": 0.0 if state in (1, 3) else 600.0,
                            "stat": state,
                        }
                    },
                    separators=(",", ":"),
                )
                + "\n"
            )
            if state == 5:
                self._said, self._report_at = -1, self.now + REPORT
            return
        if self.moves.ends and self.moves.ends[-1] <= self.now:
            self.moves.clear(self.now)
            self._report_at = self.now
            return
        if not self.rx:
            return
        value = self.rx.popleft()
        if self._off and len(self.rx) < 0.2 * self.rx_size:
            self._off = False
            self.say(b"\x11")
        if value not in b"\r\n":
            self._line.append(value)
            return
        raw, self._line = self._line.decode("latin-1"), bytearray()
        self._free = self.now + PARSE
        if raw.strip():
            self._dispatch(raw)

    # -- lines -------------------------------------------------------------------------------------

    def _answer(self, body: dict, status: int, size: int) -> None:
        text = (
            json.dumps({"r": body}, separators=(",", ":"))[:-1]
            + f',"f":[{self.revision if not self.g2 else 1},{status},{size}'
        )
        if self.revision == 1 and not self.g2:
            text += f",{java_hash(text)}"
        self.say(text + "]}\n")

    def _dispatch(self, raw: str) -> None:
        if raw.startswith("{"):
            try:
                name, value = next(iter(json.loads(raw).items()))
            except (ValueError, StopIteration, AttributeError):
                self._answer({"err": raw[:20]}, 48, len(raw) + 1)
                return
            self._answer(*self._setting(str(name), value), len(raw) + 1)
            return
        text = raw.replace(" ", "").upper()
        words = WORD.findall(text)
        codes = [k + (v.lstrip("0") or "0") for k, v in words if k in "GM"]
        status = 0
        if "".join(k + v for k, v in words) != text or any(v in ("", "-", ".") for _, v in words):
            status = 42
        elif any(code not in KNOWN for code in codes):
            status = 40
        if status == 0:
            self.executed.append(text)
            values = {k: float(v) for k, v in words if k in "XYZFP"}
            if "G90" in codes or "G91" in codes:
                self.moves.absolute = "G90" in codes
            if "G4" in codes:
                begin = self.moves.rest_at(self.now)
                self.moves.last = begin + values.get("P", 0.0)
                self.moves.ends.append(self.moves.last)
                self.dwells.append((begin, self.moves.last))
            else:
                self.moves.take(values, self.now)
        body = {"gc": raw} if self.verbosity == 5 else {}
        self._answer(body, status, len(raw) + 1)

    def _setting(self, name: str, value) -> tuple[dict, int]:
        p = [round(v, 3) for v in self.place]
        if name == "jv":
            self.verbosity = self.verbosity if value is None else int(value)
            return {"jv": self.verbosity}, 0
        if name == "sr":
            return {"sr": {"posx": p[0], "vel": 0.0, "stat": self.state()}}, 0
        if name == "mpo":
            return {"mpo": dict(zip("xyz", p, strict=True))}, 0
        if name in ("g54", "g55", "g56", "g57", "g58", "g59", "g92"):
            per = 1.0 if self.modes["unit"] else 25.4
            place = [round(v / per, 3) for v in self.work.get(name, [0.0] * 3)]
            return {name: dict(zip("xyz", place, strict=True))}, 0
        if name in self.modes:
            return {name: self.modes[name]}, 0
        if name == "sys":
            return {
                "sys": {
                    "fb": 100.26 if self.g2 else 440.20,
                    "fv": 0.99 if self.g2 else 0.97,
                    "hv": 8,
                }
            }, 0
        if name in ("ej", "fv", "fb"):
            return {name: {"ej": 1, "fv": 0.97, "fb": 100.26 if self.g2 else 440.20}[name]}, 0
        return {name: None}, 40
