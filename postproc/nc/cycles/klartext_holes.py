"""Drilling cycles of Heidenhain Klartext, written out as L.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, cycle programming: cycles 200 (drilling), 201
(reaming), 203 (universal drilling), 205 (universal pecking) and 240 (centring). From the surface
Q203: FMAX to the set-up clearance Q200, pecks of Q202 at Q206 down to Q201, each but the last drawn
out to the clearance, where it waits Q210, and back to the clearance (205: Q258, the last one Q259)
above what is drilled; at the bottom it waits Q211; then FMAX (201, 203: at Q208) to the clearance,
and to the second one, Q204, if it lies higher. Q212 makes each peck smaller than the one before,
down to Q205. Chips break by Q256: in cycle 203 after Q213 pecks out of Q213 + 1, in cycle 205 every
Q257 within a peck. With Q201 0 the control does nothing. What goes by the spindle stays, called at
the set-up clearance by CYCL CALL, and ends at the higher clearance: taps (206, 207, 209), boring
that stops at an angle of the spindle (202, 204), one lip that drills at speeds of its own (241),
and threads that are milled on ways that the manual leaves open (262 to 265, 267); the old taps (2,
17) where they are called. How fast the tool is
drawn back within the hole the manuals leave open in places: here FMAX; its line is the hole's axis
either way.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from postproc.nc.cycles.klartext_lines import signed
from postproc.nc.cycles.klartext_patterns import NUMBER, PECKING, pecks
from postproc.nc.cycles.scene import Scene
from postproc.nc.klartext import STAY

NEAR = 1e-9
MOST_PECKS = 10_000
DATUM = re.compile(rb"^[ \t]*Q([0-9]+)[ \t]*=[ \t]*([-+]?[0-9]*\.?[0-9]+|AUTO|MAX)", re.MULTILINE)
DRILLING = (200, 201, 203, 205, 240)
IN_PECKS = (200, 203, 205)
AT_OWN_FEED = (201, 203, 205)  # come out at Q208
NOT_FOLLOWED = (343, 379, 395)  # a diameter, a deeper start, another reference
OLD_TAPS = (2, 17)
TAPS = (*OLD_TAPS, 206, 207, 209)
HELP = "let the CAM program write its motions out as L"


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

    def part(self, number: int, part: int, text: bytes) -> None:
        """CYCL DEF 1.2 DEPTH -10 and its kin."""
        found = NUMBER.search(text.rstrip())
        if number == self.cycle and found:
            self.data[part] = found[1]

    def lines(self) -> list[bytes]:
        """The cycle where the tool stands. Raises ProgramError."""
        if self.cycle == PECKING:
            return self._pecking()
        self._known()
        depth, clear, top = self.value(201), self.value(200), self.value(203)
        if depth == 0:
            return []
        if depth > 0 or clear < 0:
            raise self.scene.fault(f"Q201 above 0 or Q200 below in cycle {self.cycle}", HELP)
        #  Q200  -.  .----.  .-    FMAX to the clearance
        #  Q203  =|==|====|==|=
        #         v  ^    v  ^     pecks of Q202 at Q206, out behind each
        #  Q201   '--'    '--'     then to the second clearance, if it lies higher
        feed = self.feed(206)
        lines = [self._to(top + clear, b" FMAX"), *self._pecked(depth, clear, top, feed)]
        lines += [*self._dwell(211), self._to(top + clear, self._out(feed))]
        second = self.value(204, clear)
        return [*lines, self._to(top + second, b" FMAX")] if second > clear else lines

    def _pecking(self) -> list[bytes]:
        """Cycle 1."""
        data = {n: float(raw) for n, raw in self.data.items() if n < 10}
        ways = pecks(self.scene, data)
        feed = b" F" + self.data[5].lstrip(b"+")
        lines = [self._to(z, feed if slow else b" FMAX") for z, slow in ways]
        return [*lines, *self._dwell(4), self._to(self.scene.at("Z"), b" FMAX")]

    @property
    def stays(self) -> bool:
        """Whether the cycle goes by the spindle."""
        return self.cycle in STAY

    def kept(self) -> list[bytes]:
        """A call that stays, with places in front and behind at which the tool axis is known."""
        if self.cycle in OLD_TAPS:  # they come back to where they are called
            return [b"CYCL CALL", self._to(self.scene.at("Z"), b" FMAX")]
        top, clear = self.value(203), self.value(200)
        # The depth and the way back are the control's; a line in front and one behind put the tool
        # axis where gcomp knows it again.
        high = max(clear, self.value(204, clear))
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
        odd = [n for n in NOT_FOLLOWED if n in self.data and self.value(n)]
        if odd:
            raise self.scene.fault(f"Q{odd[0]} of cycle {self.cycle} is not followed", HELP)

    def _infeeds(self, depth: float) -> Iterator[float]:
        """How deep each peck goes, from the surface down to `depth` (both above 0)."""
        step = abs(self.value(202, 0.0)) if self.cycle in IN_PECKS else 0.0
        less, least = abs(self.value(212, 0.0)), abs(self.value(205, 0.0))
        reached, count = 0.0, 0
        while reached < depth - NEAR:
            size = max(step - count * less, least) if less else step
            # A first peck of 0, or of the whole depth and more, is one stroke.
            reached = min(reached + size, depth) if count or 0 < size < depth else depth
            count += 1
            if size < NEAR < depth - reached or count > MOST_PECKS:
                raise self.scene.fault(
                    f"more than {MOST_PECKS:,} pecks", "check Q201, Q202, Q212 and Q205"
                )
            yield reached

    def _pecked(self, depth: float, clear: float, top: float, feed: bytes) -> list[bytes]:
        """Down to the bottom."""
        lines, last, breaks = [], 0.0, 0
        back = abs(self.value(256, 0.0))
        ends = list(self._infeeds(-depth))
        for k, reached in enumerate(ends):
            lines += self._broken(last, reached, back, top, feed)
            last = reached
            if reached >= -depth - NEAR:
                break
            # Q213 breaks of chips (back by Q256 alone), and behind them one way out; 205 breaks
            # them within a peck and is drawn out behind every one.
            if self.cycle == 203 and breaks < self.value(213, 0.0):
                breaks += 1
                lines.append(self._to(top - reached + back, b" FMAX"))
                continue
            breaks = 0
            lines += [self._to(top + clear, b" FMAX"), *self._dwell(210)]
            lines.append(self._to(top - reached + self._stop(k, len(ends), clear), b" FMAX"))
        return lines

    def _broken(
        self, last: float, reached: float, back: float, top: float, feed: bytes
    ) -> list[bytes]:
        """One peck; in cycle 205 chips break every Q257."""
        step, lines = abs(self.value(257, 0.0)) if self.cycle == 205 else 0.0, []
        if step and (reached - last) / step > MOST_PECKS:
            raise self.scene.fault("too many breaks of chips", "check Q202 and Q257")
        while step and last + step < reached - NEAR:
            last += step
            lines += [self._to(top - last, feed), self._to(top - last + back, b" FMAX")]
        return [*lines, self._to(top - reached, feed)]

    def _stop(self, k: int, count: int, clear: float) -> float:
        """How far above what is drilled FMAX ends behind peck k."""
        if self.cycle != 205 or not self.value(258, 0.0):
            return clear
        # From Q258 above what is drilled behind the first peck to Q259 behind the last but one,
        # evenly.
        first = self.value(258)
        last = self.value(259, first) or first
        return first + (last - first) * (k / (count - 2) if count > 2 else 0.0)

    def _out(self, feed: bytes) -> bytes:
        """The feed with which it comes out."""
        # Q208 0: cycle 201 comes out at the feed of the way in, 203 and 205 in rapid.
        if self.cycle not in AT_OWN_FEED or self.data.get(208) == b"MAX":
            return b" FMAX"
        if 208 in self.data and (self.data[208] == b"AUTO" or self.value(208)):
            return self.feed(208)
        return feed if self.cycle == 201 else b" FMAX"

    def value(self, number: int, default: float | None = None) -> float:
        """A datum. Raises ProgramError where it has no number and no default."""
        raw = self.data.get(number)
        if raw is None and default is not None:
            return default
        if raw is None or raw in (b"AUTO", b"MAX"):
            raise self.scene.fault(f"cycle {self.cycle} without a number in Q{number}", HELP)
        return float(raw)

    def feed(self, number: int) -> bytes:
        """The feed in a datum, as words (" F250"). Raises ProgramError where it has none."""
        raw = self.data.get(number)
        if raw is None:
            raise self.scene.fault(f"cycle {self.cycle} without Q{number}, its feed", HELP)
        return b" F AUTO" if raw == b"AUTO" else b" F" + raw.lstrip(b"+")

    def _to(self, z: float, feed: bytes) -> bytes:
        return b"L " + signed(self.scene, "Z", z) + feed

    def _dwell(self, number: int) -> list[bytes]:
        """Cycle 9, which acts where it is defined."""
        if self.value(number, 0.0) <= 0:
            return []
        time = self.data[number].lstrip(b"+")
        return [b"CYCL DEF 9.0 DWELL TIME", b"CYCL DEF 9.1 DWELL " + time]
