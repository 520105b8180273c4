"""Sinumerik's cycles for holes in which the spindle stops or turns back: CYCLE84 (rigid tapping),
CYCLE86 (boring, the tool lifted off), CYCLE87 and CYCLE88 (out by hand), CYCLE89 (boring).

Source: Siemens "SINUMERIK 840D/840Di/810D", Programming Guide Cycles (PGZ), chapter 2.1, the
sequence of operations of each, from general knowledge of that guide and unverified on a control;
G331 and G332 are what CYCLE84 itself is made of. MPIT is the size
of a metric thread, 3 to 48: its lead is that of the coarse series, ISO 261.

VARI of CYCLE84 is 1 to break chips and 2 to bring them out: it goes DAM deeper each time, counted
from RFP, and back by VRT (1 mm where it is 0) or to RFP + SDIS, dwelling DTB before. All of it is
on the one helix of G331 and G332: how often the tap turns back leaves the thread as it is. PITA
says what PIT counts: 1 mm, 3 inches (Autodesk's siemens-840d.cps); what its newer values ask for
else (TECHNO, PTAB) is refused.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_drilling import CHIP, MOST_STROKES, Drilling
from postproc.nc.expand.tracker import Tracker, number

MODES = " GMODE DMODE AMODE"
COARSE = {  # mm, ISO 261
    3: 0.5, 4: 0.7, 5: 0.8, 6: 1.0, 7: 1.0, 8: 1.25, 9: 1.25, 10: 1.5, 11: 1.5, 12: 1.75, 14: 2.0,
    16: 2.0, 18: 2.5, 20: 2.5, 22: 2.5, 24: 3.0, 27: 3.0, 30: 3.5, 33: 3.5, 36: 4.0, 39: 4.0,
    42: 4.5, 45: 4.5, 48: 5.0,
}  # fmt: skip
LEAD = {"Z": "K", "Y": "J", "X": "I"}
PLANE = {"Z": "XY", "Y": "ZX", "X": "YZ"}
LEFT_HANDED = 1002002  # AMODE of CYCLE84
PECKS = (0, 1, 2)  # VARI of CYCLE84


class Hole(NamedTuple):
    """Where one is bored: its axis, how a place along it is written, the level before it, and its
    bottom."""

    tracker: Tracker
    axis: str
    to: Callable[[float], bytes]
    level: float
    bottom: float


NAMES = {
    "CYCLE84": (
        "RTP RFP SDIS DP DPR DTB SDAC MPIT PIT POSS SST SST1 AXN PITA TECHNO VARI DAM VRT PITM PTAB"
        " PTABA" + MODES
    ),
    "CYCLE86": "RTP RFP SDIS DP DPR DTB SDIR RPA RPO RPAP POSS" + MODES,
    "CYCLE87": "RTP RFP SDIS DP DPR SDIR" + MODES,
    "CYCLE88": "RTP RFP SDIS DP DPR DTB SDIR" + MODES,
    "CYCLE89": "RTP RFP SDIS DP DPR DTB" + MODES,
}


class Boring(Drilling):
    """A call with its values."""

    words = NAMES

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        axis = self.axis(tracker)
        self._check(axis)
        hole = Hole(tracker, axis, self._to(tracker, axis), *self._levels())
        found = {
            "CYCLE84": self._tap,
            "CYCLE86": self._lift,
            "CYCLE87": self._by_hand,
            "CYCLE88": self._by_hand,
            "CYCLE89": self._bore,
        }[self.name](hole)
        lines = [b"G0 " + hole.to(hole.level), *found]
        if self.name == "CYCLE84":
            lines.append(self._restart_spindle(speed))
        return [*lines, *tracker.motion_code()]

    def _wait(self) -> list[bytes]:
        return [self._dwell(self.given["DTB"])] if self.given.get("DTB") else []

    def _turn(self, word: str) -> list[bytes]:
        """The spindle's direction, where a value says it."""
        value = self.given.get(word, 0.0)
        if value not in (0, 3, 4, 5):
            raise Refusal(
                f"{self.name} turns the spindle by {word} = {value:g}",
                "3, 4 or 5: as M3, M4 and M5",
            )
        return [b"M%d" % value] if value else []

    def _lead(self, unit: float) -> float:
        """Of the thread of CYCLE84, below 0 of a left-handed one. unit: of the program, mm. Raises
        Refusal."""
        g = self.given
        lead = g.get("PIT") or 0.0
        if g.get("MPIT"):
            size = abs(g["MPIT"])
            if size not in COARSE or lead:
                raise Refusal("MPIT of CYCLE84 is no metric thread alone", "write PIT, the lead")
            lead = math.copysign(COARSE[int(size)] / unit, g["MPIT"])
        if not lead or not g.get("SST"):
            raise Refusal("CYCLE84 without PIT or SST", "write its lead and its speed")
        if g.get("AMODE", 0) >= 1000:
            lead = abs(lead) * (-1 if g["AMODE"] == LEFT_HANDED else 1)
        return lead

    def _tap(self, hole: Hole) -> list[bytes]:
        g, (tracker, axis, to, level, bottom) = self.given, hole
        if (
            g.get("TECHNO")
            or g.get("VARI", 0) not in PECKS
            or g.get("PITA", 0) not in (0, 3 if tracker.inch else 1)
        ):
            raise self._odd()
        unit = 25.4 if tracker.inch else 1.0
        pitch = f" {LEAD[axis]}{number(self._lead(unit), 5)} S".encode()
        into, out = (number(x, 3).encode() for x in (g["SST"], g.get("SST1") or g["SST"]))
        found = [b"SPOS=" + number(g.get("POSS", 0.0), 3).encode()]
        for deep, back in self._turns(level, bottom, CHIP / unit):
            # G331 K1 goes down one turn of the spindle for each mm, G332 back on the same helix
            # with the spindle turned round
            found += [
                b"G331 " + to(deep) + pitch + into,
                *self._wait(),
                b"G332 " + to(back) + pitch + out,
            ]
        return [*found, b"G0 " + to(g["RTP"])]

    def _turns(self, level: float, bottom: float, chip: float) -> Iterator[tuple[float, float]]:
        """Where the tap turns back, and how far back it goes."""
        g = self.given
        step, depth = abs(g.get("DAM", 0.0)), abs(g["RFP"] - bottom)
        up = 1.0 if level > bottom else -1.0
        if g.get("VARI") and step:
            if depth > step * MOST_STROKES:
                raise Refusal(f"CYCLE84 takes more than {MOST_STROKES} strokes", "correct DAM")
            back = abs(g.get("VRT", 0.0)) or chip
            # all turns but the last one, which is at the bottom; the small part keeps a depth that
            # is a multiple of DAM from one turn more
            for n in range(1, math.ceil(depth / step - 1e-9)):
                place = g["RFP"] - up * n * step
                raised = place + up * back
                yield place, level if g["VARI"] == 2 or (raised - level) * up > 0 else raised
        yield bottom, level

    def _restart_spindle(self, speed: bytes) -> bytes:
        """The spindle as it turned before, the way of SDAC."""
        turn = self._turn("SDAC")
        if not turn:
            raise Refusal("CYCLE84 without SDAC", "write 3, 4 or 5: how the spindle turns then")
        if not speed and turn != [b"M5"]:
            raise Refusal("no S is in force behind CYCLE84", "write S before it")
        return turn[0] if turn == [b"M5"] else b"S" + speed + b" " + turn[0]

    def _lift(self, hole: Hole) -> list[bytes]:
        g, turn, (tracker, axis, to, level, bottom) = self.given, self._turn("SDIR"), hole
        sides = [(x, g.get(word, 0.0)) for x, word in zip(PLANE[axis], ("RPA", "RPO"), strict=True)]
        by = [(x, value) for x, value in [*sides, (axis, g.get("RPAP", 0.0))] if value]
        off = b"".join(b" %s=IC(%s)" % (x.encode(), self._text(tracker, x, v)) for x, v in by)
        back = b"".join(
            b" %s=IC(%s)" % (x.encode(), self._text(tracker, x, -v)) for x, v in by if x != axis
        )
        return [
            *turn,
            b"G1 " + to(bottom),
            *self._wait(),
            b"SPOS=" + number(g.get("POSS", 0.0), 3).encode(),
            *([b"G0" + off] if off else []),
            b"G0 " + to(level),
            b"G0" + back + b" " + to(g["RTP"]),
        ]

    def _by_hand(self, hole: Hole) -> list[bytes]:
        turn, up = self._turn("SDIR"), b"G0 " + hole.to(self.given["RTP"])
        return [*turn, b"G1 " + hole.to(hole.bottom), *self._wait(), b"M5", b"M0", up]

    def _bore(self, hole: Hole) -> list[bytes]:
        ways = (b"G1 " + hole.to(hole.level), b"G0 " + hole.to(self.given["RTP"]))
        return [b"G1 " + hole.to(hole.bottom), *self._wait(), *ways]

    @staticmethod
    def _text(tracker: Tracker, letter: str, value: float) -> bytes:
        value *= 2 if tracker.is_diameter(letter, distance=True) else 1
        return number(value, tracker.decimals(letter)).encode()
