"""CYCLE95 of Sinumerik: a contour roughed in cuts along an axis, and finished along it.

CYCLE95(NPP, MID, FALZ, FALX, FAL, FF1, FF2, FF3, VARI, DT, DAM, _VRT). Siemens "SINUMERIK 808D
ADVANCED", Programming and Operating Manual (Turning), CYCLE95, and "SINUMERIK 840D/840Di/810D",
Programming Guide Cycles, "Stock removal cycle", the sequence of operations of each:

- The allowances FALZ and FALX, and FAL along both axes, move the contour. The start of the cycle
  lies _VRT (1 mm where it is 0) outside of the contour, on the axis of the infeed outside of its
  outermost place, on the other one in front of its start.
- Roughing: the depth is shared out evenly, MID at most. Each cut goes in rapid traverse to its
  depth, at FF1 along the axis to the contour, along the contour up to the cut before (the first
  one, which has none, to its end), and draws off by _VRT in each axis; back in rapid traverse.
  Behind the last one axis by axis to the start.
- Finishing: axis by axis to the start, that of the infeed first; in rapid traverse to the start of
  the contour, along it at FF3, in rapid traverse back to the start. G41 or G42 is on meanwhile;
  roughing is done without (_ZSD[13] = 1, which the 808D is delivered with).
- VARI: 1 to 4 roughing, 5 to 8 finishing, 9 to 12 both; of each the first and third along Z, the
  others along X; the first two outside, the others inside. Anything else stops the control (alarm
  61002).

Refused: contours that turn back (relief cuts), cuts that are interrupted (DAM), G91.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from postproc.nc.cycles.profile import Element, Point
from postproc.nc.cycles.scene import CLOCKWISE as G2
from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_contour import elements
from postproc.nc.expand.siemens_cycle import by_name, in_diameters
from postproc.nc.expand.siemens_values import Value
from postproc.nc.expand.tracker import Tracker, number

NAME = "CYCLE95"
WORDS = ("MID", "FALZ", "FALX", "FAL", "FF1", "FF2", "FF3", "VARI", "DT", "DAM", "_VRT")
MOST_CUTS = 10_000
NEAR = 1e-9
WRITE_OUT = "let the CAM program write it out as G0, G1, G2 and G3"


@dataclass
class Removal:
    """A call with its values; `contour`: the plain lines that NPP names."""

    given: dict[str, float]
    contour: list[bytes]

    @classmethod
    def of(cls, values: Sequence[Value | None], contour: Callable[[str], list[bytes]]) -> Removal:
        """contour: the lines of one by its name. Raises Refusal for values that are none of the
        cycle."""
        given = by_name(NAME, WORDS, values[1:], "correct the call")
        kind = given.get("VARI", 0.0)
        if kind != int(kind) or not 1 <= kind <= 12:
            raise Refusal(
                f"VARI of CYCLE95 is {kind:g}, and the control stops (alarm 61002)",
                "VARI is its ninth value, 1 to 12",
            )
        for word in ("MID", "FF1") if not 4 < kind < 9 else ():
            if given.get(word, 0.0) <= 0:
                raise Refusal(f"CYCLE95 without {word}", "write its value, above 0")
        name = values[0]
        if not isinstance(name, str) or not name:
            raise Refusal("CYCLE95 without a contour", "write its name as the first value")
        return cls(given, contour(name))

    @property
    def _kind(self) -> int:
        return int(self.given["VARI"]) - 1

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """The plain lines; feed: the F word in force. Raises Refusal."""
        self._check(tracker)
        shape = elements(tracker, self.contour)
        deep, sense = (1, 0)[self._kind % 2], (1.0, -1.0)[self._kind // 2 % 2]
        cut = Cut(tracker, shape, deep, sense, self.given)
        beside = tracker.code("cutter") in (410, 420)
        if self._kind // 4 != 1:
            if beside:
                raise Refusal("CYCLE95 roughs while G41 or G42 is in force", "write G40 before it")
            cut.rough()
        if self._kind // 4 != 0:
            cut.finish(tracker.code("cutter") if beside else 0)
        last = tracker.motion_code()
        return [*cut.lines, b" ".join([*last, *([b"F" + feed] if feed else [])])]

    def _check(self, tracker: Tracker) -> None:
        if tracker.code("plane") != 180:
            raise Refusal("CYCLE95 in another plane than ZX", "write G18 before it")
        if tracker.code("distance") == 910:
            raise Refusal("CYCLE95 in G91", "write G90 before it")
        if self.given.get("DAM", 0.0):
            raise Refusal("CYCLE95 with DAM, cuts that are interrupted", WRITE_OUT)


class Cut:
    """Writes the cuts of one contour. `deep`: the axis of the infeed, 0 Z, 1 X; `sense`: 1 where
    the tool lies on its + side."""

    def __init__(
        self,
        tracker: Tracker,
        shape: list[Element],
        deep: int,
        sense: float,
        given: dict[str, float],
    ):
        self.tracker, self.shape, self.deep, self.sense = tracker, shape, deep, sense
        self.given, self.lines = given, list[bytes]()
        self.along = 1 - deep
        way = shape[-1].end[self.along] - shape[0].start[self.along]
        self.ahead = 1.0 if way > 0 else -1.0  # the way of the cuts
        more = given.get("FAL", 0.0)
        allowance = [given.get("FALZ", 0.0) + more, given.get("FALX", 0.0) + more]
        # away from the part: to the tool's side of it, and against the way of the cuts
        allowance[deep] *= sense
        allowance[self.along] *= -self.ahead
        self.moved = [e.moved((allowance[0], allowance[1])) for e in shape]
        self.off = given.get("_VRT", 0.0) or 1.0 / (25.4 if tracker.inch else 1.0)
        places = [e.end[deep] for e in self.moved] + [self.moved[0].start[deep]]
        self.top = max(places) if sense > 0 else min(places)
        self.begin = self.moved[0].start[self.along] - self.ahead * self.off
        self.here: list[float | None] = [None, None]  # z, x as they were written last

    # -- roughing ----------------------------------------------------------------------------------

    def rough(self) -> None:
        """All cuts. Raises Refusal."""
        #   deep ^                              Each cut: in rapid traverse to its level at `begin`,
        #   outside  b                          at FF1 along to the contour and up along it to the
        #   before   b----------------.'        level of the cut before, off by _VRT in both axes,
        #   level    b------------->./          and back in rapid traverse.
        #            :        __.--'            The contour rises in the way of the cuts, or it is
        #          begin   contour   along ->   a relief cut (_monotonic).
        self._monotonic()
        feed = f" F{number(self.given['FF1'], 4)}"
        outside = self.top + self.sense * self.off
        self._to("G0", self._place(outside, self.begin))
        before = self.sense * math.inf  # the first one goes on to the contour's end
        for level in self._levels():
            self._to("G0", self._place(level, self.begin))
            pieces = list(self._pieces(level, before))
            self._to("G1", pieces[0].start, feed)
            for piece in pieces:
                self._element(piece, "")
            last = pieces[-1].end
            stop = last[self.along] - self.ahead * self.off
            self._to("G0", self._place(last[self.deep] + self.sense * self.off, stop))
            self._to("G0", self._place(last[self.deep] + self.sense * self.off, self.begin))
            before = level
        self._to("G0", self._place(outside, self.begin))

    def _levels(self) -> Iterator[float]:
        low = self.moved[0].start[self.deep]
        total = abs(self.top - low)
        count = math.ceil(total / self.given["MID"] - NEAR)
        if count > MOST_CUTS:
            raise Refusal(f"CYCLE95 takes more than {MOST_CUTS:,} cuts", "correct MID")
        for k in range(1, count + 1):
            yield low if k == count else self.top - self.sense * total * k / count

    def _pieces(self, level: float, before: float) -> Iterator[Element]:
        """The contour from a depth to the one of the cut before."""
        deep, sense = self.deep, self.sense
        for e in self.moved:
            begin, end = e.start[deep] * sense, e.end[deep] * sense
            if end < level * sense - NEAR or begin > before * sense - NEAR:
                continue
            start, stop = e.start, e.end
            if begin < level * sense - NEAR:
                start = self._at(e, level)
            if end > before * sense + NEAR:
                stop = self._at(e, before)
            if math.dist(start, stop) > NEAR:
                yield Element(e.code, start, stop, (), e.centre)

    def _at(self, e: Element, level: float) -> Point:
        other = e.crossing(self.deep, level)
        assert other is not None
        return self._place(level, other)

    def _monotonic(self) -> None:
        for axis, sense in ((self.deep, self.sense), (self.along, self.ahead)):
            ways = [(e.end[axis] - e.start[axis]) * sense for e in self.moved]
            if min(ways) < -NEAR or not all(e.monotonic for e in self.moved):
                raise Refusal(
                    f"the contour of CYCLE95 turns back in {'ZX'[axis]} (a relief cut), or begins"
                    " at its outer end",
                    WRITE_OUT,
                )

    # -- finishing ---------------------------------------------------------------------------------

    def finish(self, beside: int) -> None:
        """One cut along the contour; beside: the code of the compensation in force, 0: none."""
        feed = self.given.get("FF3", 0.0)
        if feed <= 0:
            raise Refusal("CYCLE95 without FF3", "write its value, above 0")
        outside = self._place(self.top + self.sense * self.off, self.begin)
        first, last = self.shape[0].start, self.shape[-1].end
        # the tool lies to the left where the way turned left points out of the part
        left = (first[1] - last[1], last[0] - first[0])[self.deep] * self.sense > 0
        side = 410 if left else 420
        if beside and beside != side:
            raise Refusal(
                "CYCLE95 while the compensation of the other side is in force",
                "write G40 before it",
            )
        part = [0, 1] if self.deep == 0 else [1, 0]
        for axis in part:
            self._to("G0", (outside[0], outside[1]), only=axis)
        self._to("G0" if beside else f"G0 G{side // 10}", first)
        for k, e in enumerate(self.shape):
            self._element(e, f" F{number(feed, 4)}" if not k else "")
        self._to("G0" if beside else "G0 G40", outside)

    # -- lines -------------------------------------------------------------------------------------

    def _place(self, deep: float, along: float) -> Point:
        return (along, deep) if self.deep else (deep, along)

    def _words(self, place: Point, only: int | None = None) -> str:
        words = []
        for axis, value in ((1, place[1]), (0, place[0])):
            if only in (None, axis) and self.here[axis] != value:
                letter = "ZX"[axis]
                double = 2 if axis and in_diameters(self.tracker, "X") else 1
                words.append(letter + number(value * double, self.tracker.decimals(letter)))
                self.here[axis] = value
        return " ".join(words)

    def _to(self, code: str, place: Point, more: str = "", only: int | None = None) -> None:
        words = self._words(place, only)
        if words or "G4" in code or more:
            self.lines.append(f"{code} {words}{more}".replace("  ", " ").rstrip().encode())

    def _element(self, e: Element, more: str) -> None:
        if not e.is_arc:
            self._to("G1", e.end, more)
            return
        self.here = [None, None]
        radius = number(math.dist(e.start, e.centre), self.tracker.decimals("X"))
        code = "G2" if e.code == G2 else "G3"
        self.lines.append(f"{code} {self._words(e.end)} CR={radius}{more}".encode())
