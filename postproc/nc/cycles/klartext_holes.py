"""Drilling cycles of Heidenhain Klartext, written out as L.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, cycle programming: cycles 200 (drilling), 201
(reaming), 203 (universal drilling, without chip breaking and decrement) and 240 (centring). From
the surface Q203: FMAX to the set-up clearance Q200, pecks of Q202 at Q206 down to Q201, each but
the last drawn out to the clearance, where it waits Q210, and back to the clearance above what is
drilled; at the bottom it waits Q211; then FMAX (201, 203: at Q208) to the clearance, and to the
second one, Q204, if it lies higher. With Q201 0 the control does nothing. Taps (206, 207, 209)
stay, called at the set-up clearance by CYCL CALL.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from postproc.nc.cycles.scene import Scene

NEAR = 1e-9
MOST_PECKS = 10_000
DATUM = re.compile(rb"^[ \t]*Q([0-9]+)[ \t]*=[ \t]*([-+]?[0-9]*\.?[0-9]+|AUTO|MAX)", re.MULTILINE)
DRILLING = {200: "drilling", 201: "reaming", 203: "universal drilling", 240: "centring"}
PECKING = (200, 203)
AT_OWN_FEED = (201, 203)  # come out at Q208
NOT_FOLLOWED = (212, 213, 343, 395)  # decrement, chip breaking, a diameter, another reference
TAPS = (206, 207, 209)
HELP = "let the CAM program write this hole out as L"


@dataclass
class Holes:
    """The cycle that is defined, its data as written, and whether it has changed the feed."""

    scene: Scene
    cycle: int = 0
    data: dict[int, bytes] = field(default_factory=dict)

    def define(self, number: int) -> None:
        """CYCL DEF."""
        self.cycle, self.data = number, {}

    def datum(self, code: bytes) -> None:
        """Q200=+2 and its kin, in lines of their own."""
        for found in DATUM.finditer(code):
            self.data[int(found[1])] = found[2]

    def lines(self) -> list[bytes]:
        """The cycle where the tool stands. Raises ProgramError."""
        self._known()
        depth, clear, top = self._value(201), self._value(200), self._value(203)
        if depth == 0:
            return []
        if depth > 0 or clear < 0:
            raise self.scene.fault(f"Q201 above 0 or Q200 below in cycle {self.cycle}", HELP)
        feed = self._feed(206)
        lines = [self._to(top + clear, b" FMAX"), *self._pecks(depth, clear, top, feed)]
        lines += [*self._dwell(211), self._to(top + clear, self._out(feed))]
        second = self._value(204, clear)
        return [*lines, self._to(top + second, b" FMAX")] if second > clear else lines

    @property
    def taps(self) -> bool:
        """Whether the cycle goes in step with the spindle."""
        return self.cycle in TAPS

    def tapped(self) -> list[bytes]:
        """A call that stays, with places in front and behind at which the tool axis is known."""
        top, clear = self._value(203), self._value(200)
        high = max(clear, self._value(204, clear))
        places = [self._to(top + z, b" FMAX") for z in (clear, high)]
        return [places[0], b"CYCL CALL", places[1]]

    def _known(self) -> None:
        if self.cycle not in DRILLING:
            raise self.scene.fault(
                f"cycle {self.cycle} is called, and is not written out"
                if self.cycle
                else "a cycle is called, and none is defined",
                HELP,
            )
        odd = [n for n in NOT_FOLLOWED if n in self.data and self._value(n)]
        if odd:
            raise self.scene.fault(f"Q{odd[0]} of cycle {self.cycle} is not followed", HELP)

    def _pecks(self, depth: float, clear: float, top: float, feed: bytes) -> list[bytes]:
        step = abs(self._value(202, 0.0)) if self.cycle in PECKING else 0.0
        step = step if 0 < step < -depth else -depth
        count = math.ceil(-depth / step - NEAR)
        if count > MOST_PECKS:
            raise self.scene.fault(f"{count:,} pecks", "check Q201 and Q202")
        lines = []
        for k in range(1, count):
            lines += [self._to(top - k * step, feed), self._to(top + clear, b" FMAX")]
            lines += [*self._dwell(210), self._to(top - k * step + clear, b" FMAX")]
        return [*lines, self._to(top + depth, feed)]

    def _out(self, feed: bytes) -> bytes:
        """The feed with which it comes out."""
        if self.cycle not in AT_OWN_FEED or self.data.get(208) == b"MAX":
            return b" FMAX"
        if 208 in self.data and (self.data[208] == b"AUTO" or self._value(208)):
            return self._feed(208)
        return feed if self.cycle == 201 else b" FMAX"

    def _value(self, number: int, default: float | None = None) -> float:
        raw = self.data.get(number)
        if raw is None and default is not None:
            return default
        if raw is None or raw in (b"AUTO", b"MAX"):
            raise self.scene.fault(f"cycle {self.cycle} without a number in Q{number}", HELP)
        return float(raw)

    def _feed(self, number: int) -> bytes:
        raw = self.data.get(number)
        if raw is None:
            raise self.scene.fault(f"cycle {self.cycle} without Q{number}, its feed", HELP)
        return b" F AUTO" if raw == b"AUTO" else b" F" + raw.lstrip(b"+")

    def _to(self, z: float, feed: bytes) -> bytes:
        return b"L " + signed(self.scene, "Z", z) + feed

    def _dwell(self, number: int) -> list[bytes]:
        """Cycle 9, which acts where it is defined."""
        if self._value(number, 0.0) <= 0:
            return []
        time = self.data[number].lstrip(b"+")
        return [b"CYCL DEF 9.0 DWELL TIME", b"CYCL DEF 9.1 DWELL " + time]


def signed(scene: Scene, axis: str, value: float) -> bytes:
    """X+10.5."""
    text = scene.text(axis, value).rstrip(b".")
    return text if text[1:2] == b"-" else text[:1] + b"+" + text[1:]
