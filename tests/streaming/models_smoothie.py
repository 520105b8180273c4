"""Smoothieware's side of the wire, as src/modules/communication/GcodeDispatch.cpp has it (2019), in
simulated time.

A line is taken when the one before is done; N, checksum and `rs N<n>` without an ok; an ok for each
code up to a G1, or one a line; `?` is taken out as it arrives. Not simulated: acceleration, arcs.
"""

from __future__ import annotations

import re
from collections import deque

from tests.streaming.models_wire import NEVER, Moves, Receiver

WORD = re.compile(r"([A-Z])(-?\d*\.?\d*)")


class SmoothieModel(Receiver):
    def __init__(
        self, baud: int = 115200, rx: int = 256, per_line: bool = True, glued: bool = False
    ):
        super().__init__(baud, rx)
        self.per_line, self.glued = per_line, glued
        self.moves = Moves(32)
        self.zero = [0.0, 0.0, 0.0]  # mm
        self.inches, self.says_modes = False, True
        self._reset()
        self.say("Smoothie\r\nok\r\n")

    def _reset(self) -> None:
        self.rx.clear()
        self._line = bytearray()
        self._free = self.now
        self.current = -1
        self.halted = self._hold = False
        self._wait = ""

    def restart(self) -> None:
        self.moves = Moves(32)
        self._reset()
        self.say("Smoothie Running @120MHz\r\n")

    @property
    def place(self) -> list[float]:
        return self.moves.place

    def _arrive(self, value: int) -> None:
        if value == ord("?"):
            self.moves.clear(self.now)
            state = (
                "Alarm"
                if self.halted
                else "Hold"
                if self._hold
                else "Run"
                if self.moves.ends
                else "Idle"
            )
            per = 25.4 if self.inches else 1.0
            p = [v / per for v in self.place]
            machine = ",".join(f"{v:.4f}" for v in p)
            work = ",".join(f"{v - z / per:.4f}" for v, z in zip(p, self.zero, strict=True))
            self.say(
                f"<{state}|MPos:{machine}|WPos:{work}|F:4000.0,100.0>"
                + ("" if self.glued and self.rx else "\r\n")
            )
        elif value == ord("!") and not self._hold:
            self.moves.clear(self.now)
            self._hold, self._left = True, [t - self.now for t in self.moves.ends]
        elif value == ord("~") and self._hold:
            self._hold = False
            self.moves.ends = deque(self.now + t for t in self._left)
            self.moves.last = max(self.moves.ends, default=self.now)
        elif value == 0x18:
            self.halted, self._hold = True, False
            self.moves.ends.clear()
            self.say("HALTED, M999 or $X to exit HALT state\r\n")
        elif value not in b"!~":
            self.keep(value)

    def _next(self) -> float:
        if self._hold or not self.rx:
            return NEVER
        if self._wait == "rest":
            return max(self._free, self.moves.rest_at(self.now))
        return max(self._free, self.moves.room_at(self.now))

    def _act(self) -> None:
        value = self.rx.popleft()
        if value not in b"\r\n":
            self._line.append(value)
            return
        raw, self._line = self._line.decode("latin-1"), bytearray()
        self._free = self.now + 0.001
        self._take(raw)

    def _take(self, text: str) -> None:
        if not text:
            self.say("ok\r\n")
        elif text[0] == "$" or text[0].islower():
            if text == "version":
                self.say(
                    "Build version: edge-abc123, Build date: Jan 1 2020, MCU: LPC1769, System"
                    " Clock: 120MHz\r\n"
                )
            elif text == "$G" and self.says_modes:
                unit = "G20" if self.inches else "G21"
                self.say(f"[GC:G0 G54 G17 {unit} G90 G94 M0 M5 M9 T0 F4000.0 S0.8]\r\nok\r\n")
            else:
                self.say(f"error:Unsupported command - {text}\r\n")
        elif text[0] in "GMTSN":
            self._codes(text)
        else:
            self.say("ok - ignored\r\n")

    def _codes(self, text: str) -> None:
        numbered = text[0] == "N"
        if numbered:
            found = re.match(r"N(-?\d+)", text)
            n = int(found[1]) if found else 0
            if re.search(r"M110(?!\d)", text):
                self.current = n
                self.say("ok\r\n")
                return
            star, value = text.find("*"), 0
            good = True
            if star >= 0:
                for byte in text[:star].encode("latin-1"):
                    value ^= byte
                said = re.match(r"\d+", text[star + 1 :])
                good = bool(said) and int(said[0]) == value
                text = text[:star]
            text = text.lstrip("N0123456789.,- ")
            if not good or n != self.current + 1:
                self.say(f"rs N{self.current + 1}\r\n")
                return
            self.current = n
        self.executed.append(
            "".join(k + v for k, v in re.findall(r"([A-Z]) *([-\d.]*)", text)) if numbered else text
        )
        sent = False
        while text:
            nexts = [i for i in (text.find("G", 2), text.find("M", 2)) if i > 0]
            one, text = (text[: min(nexts)], text[min(nexts) :]) if nexts else (text, "")
            sent = self._one(one, text, sent)

    def _one(self, text: str, rest: str, sent: bool) -> bool:
        words = [(k, float(v)) for k, v in WORD.findall(text.replace(" ", "")) if v.strip("-.")]
        values = dict(words[1:])
        code = f"{words[0][0]}{int(words[0][1])}" if words else ""
        if self.halted:
            self.say("!!\r\n")
            return True
        if code == "G1" and not sent:
            self.say("ok\r\n")
            sent = True
        if code in ("G0", "G1", "G2", "G3"):
            per = 25.4 if self.inches else 1.0
            self.moves.take({k: v * per for k, v in values.items()}, self.now)
        elif code in ("G20", "G21"):
            self.inches = code == "G20"
        elif code in ("G90", "G91"):
            self.moves.absolute = code == "G90"
        elif code in ("M400", "G4"):
            self._free = self.moves.rest_at(self.now) + values.get("P", 0.0) / 1000
        elif code == "M115":
            self.say(
                "FIRMWARE_NAME:Smoothieware, FIRMWARE_URL:http%3A//smoothieware.org,"
                " FIRMWARE_VERSION:edge-abc123, X-AXES:3\nok\n"
            )
            return True
        elif code == "M114":
            self.say("ok C: X:0.0000 Y:0.0000 Z:0.0000\r\n")
            return True
        elif code == "G77":
            self.say("Error: unknown\r\nEntering Alarm/Halt state\n")
            self.halted = True
            return True
        if not sent and (not self.per_line or not rest):
            self._tx_free = max(self._tx_free, self._free)
            self.say("ok\r\n")
        return sent
