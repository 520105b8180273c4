"""Sinumerik's drilling cycles, called alone or behind every motion by MCALL: CYCLE81, CYCLE82,
CYCLE83, CYCLE85.

Source: Siemens "SINUMERIK 840D sl / 828D", Programming Guide Cycles, "Drilling cycles" (sequence of
operations, and for CYCLE83 "first drilling depth, degression": DAM below 0 is a factor down to
MDEP, which counts beside such a factor alone; FRF is a part of the feed for the first stroke), and
Programming Manual Job Planning, "Modal subroutine call (MCALL)". The G codes that were in force
before a cycle hold behind it. Those in which the spindle takes part: siemens_boring.py.

The longer AMODE are those that Autodesk's Sinumerik posts write (siemens-840d.cps, "Extended
cycles", and beside which values): CYCLE83 has DP and FDEP as places and dwells in seconds; what
MDEP means beside DAM there it leaves open, so DAM is 0. CYCLE84 has DP as a place, and the hand of
the thread. CYCLE81 has 10 as its eighth value, the AMODE of seconds in the place of DMODE: read as
either, the hole goes to DP without a dwell.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_cycle import Cycle, in_diameters
from postproc.nc.expand.tracker import Tracker, number

AXIS = {170: "Z", 180: "Y", 190: "X"}
LONGER = {"CYCLE83": (1001110,), "CYCLE84": (1001002, 1002002)}  # AMODE
DIGIT = {"Z": 1, "Y": 2, "X": 3}  # of DMODE: the plane across the axis of the hole
GEOMETRY = {"X": 1, "Y": 2, "Z": 3}  # of AXN: the number of that geometry axis
# mm: how far CYCLE83 keeps off the bottom that it has reached
SHALLOW, AHEAD, PART, MOST_AHEAD = 30.0, 0.6, 50.0, 7.0
NEAR = 1e-9  # of a length: the same depth
CHIP = 1.0  # mm, by which it goes back to break chips
MOST_STROKES = 10_000
WRITE_OUT = "let the CAM program write this hole out as G0 and G1"
# A line whose words of axes, poles or centres are a motion of its own; behind others MCALL calls
# nothing.
MOVES = re.compile(
    rb"(?<![A-Z_0-9])(?:[XYZABCUVWIJK][ \t]*(?:=|[-+.0-9])|(?:AP|AR|RP)[ \t]*=)", re.IGNORECASE
)
STILL = re.compile(
    rb"(?<![A-Z_])(?:A?TRANS|[AC]?ROTS?|A?SCALE|A?MIRROR|G0*(?:4|25|26|58|59|11[0-2]|7[45]))"
    rb"(?![A-Z0-9])",
    re.IGNORECASE,
)


def moves(code: bytes) -> bool:
    """Whether a plain line, without comments and strings, moves an axis by its own words."""
    return bool(MOVES.search(code)) and not STILL.search(code)


NAMES = {
    "CYCLE81": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
    "CYCLE82": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
    "CYCLE83": (
        "RTP RFP SDIS DP DPR FDEP FDPR DAM DTB DTS FRF VARI AXN MDEP VRT DTD DIS1 GMODE DMODE AMODE"
    ),
    "CYCLE85": "RTP RFP SDIS DP DPR DTB FFR RFF GMODE DMODE AMODE",
}


class Drilling(Cycle):
    """A call with its values."""

    words = NAMES

    def axis(self, tracker: Tracker) -> str:
        """The axis of the hole. Raises Refusal where its places are diameters: whether the cycle's
        planes and clearances are then is in no manual that was found."""
        axis = AXIS[tracker.code("plane")]
        if in_diameters(tracker, axis):
            raise Refusal(f"{self.name} along {axis} in diameters", "write DIAMOF before it")
        return axis

    @staticmethod
    def _to(tracker: Tracker, axis: str) -> Callable[[float], bytes]:
        """The word of a place along the hole."""
        decimals, relative = tracker.decimals(axis), tracker.code("distance") == 910

        def word(place: float) -> bytes:
            text = number(place, decimals)
            return f"{axis}=AC({text})".encode() if relative else f"{axis}{text}".encode()

        return word

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """The plain lines of one hole, from where the axis stands. feed, speed: the F and S words
        in force."""
        axis = self.axis(tracker)
        self._check(axis)
        inch, to = tracker.inch, self._to(tracker, axis)

        def move(code: str, place: float) -> bytes:
            return code.encode() + b" " + to(place)

        level, bottom = self._levels()
        found = [move("G0", level)]
        if self.name == "CYCLE83":
            slower = self._slower(feed)
            for code, place in self._pecks(inch):
                if code == "G1" and slower:
                    found += [move("G1" + slower, place), b"F" + feed]
                    slower = ""  # the first stroke alone
                else:
                    found.append(move(code, place) if code else self._dwell(place))
        else:
            found.append(move("G1" + self._feed("FFR"), bottom))
            if self.given.get("DTB"):
                found.append(self._dwell(self.given["DTB"]))
        if self.name == "CYCLE85":
            if not feed and (self.given.get("FFR") or self.given.get("RFF")):
                raise Refusal("no F is in force behind CYCLE85", "write F before it")
            found.append(move("G1" + self._feed("RFF"), level))
        found.append(move("G0", self.given["RTP"]))
        back = tracker.motion_code()
        back += [b"F" + feed] if self.given.get("FFR") or self.given.get("RFF") else []
        return [*found, b" ".join(back)] if back else found

    def _slower(self, feed: bytes) -> str:
        """The F word of the first stroke of CYCLE83, "": that in force."""
        part = self.given.get("FRF", 0.0)
        if part in (0, 1):
            return ""
        if not 0 < part < 1 or not feed:
            raise Refusal(
                "FRF of CYCLE83 without an F in force, or beyond 0.001 to 1", "correct the call"
            )
        return f" F{number(float(feed) * part, 4)}"

    def _feed(self, word: str) -> str:
        value = self.given.get(word, 0.0)
        return f" F{number(value, 3)}" if value else ""

    def _dwell(self, seconds: float) -> bytes:
        return (
            f"G4 F{number(seconds, 3)}" if seconds > 0 else f"G4 S{number(-seconds, 3)}"
        ).encode()

    def _check(self, axis: str) -> None:
        """Values that ask for something else than what is written out. Raises Refusal."""
        g = self.given
        self.needs("RTP RFP")
        mode = int(g.get("AMODE", 0))
        longer = mode in LONGER.get(self.name, ()) and not (self.name == "CYCLE83" and g.get("DAM"))
        planes = (0, DIGIT[axis], *((10,) if self.name == "CYCLE81" and "AMODE" not in g else ()))
        wrong = (
            g.get("GMODE", 0) % 10 == 1
            or mode % 10 > 2
            or mode // 10 % 10 > 1
            or (mode >= 100 and not longer)
            or g.get("DMODE", 0) not in planes
            or g.get("AXN", 0) not in (0, GEOMETRY[axis])
        )
        if wrong:
            raise self._odd()

    def _odd(self) -> Refusal:
        values = ",".join(f"{k}={v:g}" for k, v in self.given.items())
        return Refusal(f"{self.name} in a way that is not written out ({values})", WRITE_OUT)

    def _levels(self) -> tuple[float, float]:
        """The level before the hole, and its bottom. A depth from the reference plane goes before
        one that is a place."""
        g = self.given
        up = 1.0 if g["RTP"] >= g["RFP"] else -1.0
        by = int(g.get("AMODE", 0)) % 10
        if "DP" not in g and "DPR" not in g:
            raise Refusal(f"{self.name} without DP and DPR", "write its depth")
        incremental = by == 1 or (by == 0 and bool(g.get("DPR")))
        bottom = (
            g["RFP"] - up * abs(g.get("DPR") or g.get("DP", 0.0))
            if incremental
            else g.get("DP", 0.0)
        )
        level = g["RFP"] + up * abs(g.get("SDIS", 0.0))
        if (level - bottom) * up <= 0 or (g["RTP"] - level) * up < 0:
            raise Refusal(
                f"the planes of {self.name} are not in order",
                "RTP, RFP + SDIS and DP in this order",
            )
        return level, bottom

    def _strokes(self, bottom: float) -> Iterator[float]:
        """The places that the strokes of CYCLE83 reach."""
        g = self.given
        up = 1.0 if g["RTP"] >= g["RFP"] else -1.0
        depth = abs(g["RFP"] - bottom)
        first = (
            abs(g["FDPR"]) if g.get("FDPR") else abs(g["RFP"] - g["FDEP"]) if "FDEP" in g else depth
        )
        less, least = abs(g.get("DAM", 0.0)), abs(g.get("MDEP", 0.0))
        factor = -g["DAM"] if g.get("DAM", 0.0) < 0 else 0.0
        if factor > 1 or (factor and not least and factor < 1):
            raise Refusal(
                "the factor DAM of CYCLE83 is beyond 0.001 to 1, or without MDEP",
                "correct DAM, and write MDEP, the least stroke",
            )
        if first > depth or first <= 0:
            raise Refusal(
                "the first drilling depth of CYCLE83 is not within the hole", "correct FDEP or FDPR"
            )
        for reached in _reached(depth, first, less, least, factor):
            yield bottom if reached >= depth - NEAR else g["RFP"] - up * reached

    def _pecks(self, inch: bool) -> Iterator[tuple[str, float]]:
        """Code and place of what CYCLE83 does behind the rapid to the level; "" and seconds for a
        dwell."""
        #   VARI 1   level  --.   .--.   .--     out of the hole with the chips, and in rapid
        #                     |   |  :   |       traverse back to `ahead` above what is drilled
        #                     v---'  v   |
        #                            |---'
        #   VARI 0   back by VRT alone at the feed, which breaks the chips
        g, (level, bottom) = self.given, self._levels()
        up = 1.0 if g["RTP"] >= g["RFP"] else -1.0
        unit = 25.4 if inch else 1.0
        deep = abs(g["RFP"] - bottom) * unit
        ahead = g.get("DIS1") or (AHEAD if deep <= SHALLOW else min(deep / PART, MOST_AHEAD)) / unit
        for place in self._strokes(bottom):
            yield "G1", place
            waits = g.get("DTD") if place == bottom else 0.0  # 0: as DTB
            if waits or g.get("DTB"):
                yield "", waits or g["DTB"]
            if place == bottom:
                return
            if g.get("VARI", 0):
                yield "G0", level
                if g.get("DTS"):
                    yield "", g["DTS"]
                yield "G0", place + up * ahead
            else:
                yield "G1", place + up * (g.get("VRT") or CHIP / unit)


def _reached(
    depth: float, first: float, less: float, least: float, factor: float
) -> Iterator[float]:
    """How deep each stroke ends, the hole's depth at last: strokes get shorter by `less`, or by
    `factor` down to `least`. Raises Refusal."""
    #   40 deep, first 20, DAM 5     20, 15, 5 (the rest)
    #   40 deep, first 20, DAM -0.5, MDEP 4     20, 10, 5, 4, 1 (the rest)
    reached = stroke = first
    for _ in range(MOST_STROKES):
        yield reached
        if reached >= depth - NEAR:
            return
        if factor:
            stroke = max(stroke * factor, least)
        else:
            left = depth - reached
            stroke = stroke - less if stroke - less > less else max(less, 0.0) or stroke
            if less and left < 2 * less and left > stroke:
                stroke = left / 2
        reached = min(reached + stroke, depth)
    raise Refusal(f"CYCLE83 takes more than {MOST_STROKES} strokes", "correct FDPR and DAM")
