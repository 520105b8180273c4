"""How type II of G71 and G72 of Fanuc and Haas lathes roughs a shape with pockets: the way of the
tool, cut by cut.

Haas, lathe operator's manual, "G71 O.D./I.D. Stock Removal Cycle", "Type 2 Details" and "Troughs":
a first block in X and Z chooses type II; X of the shape may turn back then, Z may not, and but for
the last block the shape stays within the start point. All material above the troughs is roughed
first, then the troughs follow in the direction of the cuts. Behind each cut the tool goes along the
shape, as far as the cut before, and retracts parallel to X.

Assumed: it retracts to the level of the cut before and an escape more, at most to the start
point's; it enters a trough along the shape, from the level of the cut before or the ridge below
that; all but the first way in is fed. Fanuc's B-64304EN-1 chooses type II in the same way; the
order is taken from Haas there too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

from postproc.nc.cycles.profile import Element, Point, Step, TooMany
from postproc.nc.cycles.scene import COUNTER

NEAR = 1e-9
MOST_CUTS = 10_000


class Cut(NamedTuple):
    """Where a level lies above the shape: from place `begin` along the cuts, on piece `enter`, to
    `end`, on piece `leave` (None: to the end of the shape)."""

    begin: float
    enter: int
    end: float
    leave: int | None


def quarters(e: Element) -> list[Element]:
    """An arc cut where it turns back in Z or in X."""
    if not e.is_arc:
        return [e]

    def arm(p: Point) -> float:
        return math.atan2(p[1] - e.centre[1], p[0] - e.centre[0])

    # An arc turns back in Z or X where its arm lies along an axis: at 0, 90, 180 and 270 degrees.
    first, sign = arm(e.start), 1 if e.code == COUNTER else -1
    sweep = (sign * (arm(e.end) - first)) % math.tau
    radius, ends = math.dist(e.start, e.centre), []
    for k in range(4):
        turn = k * math.pi / 2
        way = (sign * (turn - first)) % math.tau
        if 1e-6 < way < sweep - 1e-6:
            place = (e.centre[0] + radius * math.cos(turn), e.centre[1] + radius * math.sin(turn))
            ends.append((way, place))
    places = [e.start, *(place for _, place in sorted(ends)), e.end]
    return [replace(e, start=a, end=b) for a, b in pairwise(places)]


@dataclass
class TypeTwo:
    """Roughs `pieces`, the way in first, all monotonic in depth. `deep`: 1 for cuts along Z, 0
    along X; `sense`: +1 where deeper is more; `top`: the start point's depth."""

    pieces: list[Element]
    deep: int
    sense: int
    top: float
    depth: float
    escape: float
    steps: list[Step] = field(default_factory=list)
    at: Point = (0.0, 0.0)

    def way(self, begin: Point) -> list[Step]:
        """The motions from the start point, and back to it. Raises TooMany."""
        self.at = begin
        self._region()
        self._up(0)
        self._along(begin[1 - self.deep])
        return self.steps

    # -- levels ------------------------------------------------------------------------------------

    def _level(self, k: int) -> float:
        """The coordinate of cut k."""
        return self.top + self.sense * k * self.depth

    def _deeper(self, p: Point, level: float) -> bool:
        return (p[self.deep] - level) * self.sense > NEAR

    def _cuts(self, level: float) -> list[Cut]:
        """All cuts at a level."""
        #  level  -cut-   -cut-     A cut lies where the shape is deeper than the level: it begins
        #  shape \     / \     /    on the piece that goes down through it (`enter`) and ends on the
        #         '---'   '---'     next one that comes up (`leave`).
        along, found = 1 - self.deep, []
        begin, enter = 0.0, -1
        for i, e in enumerate(self.pieces):
            before, behind = self._deeper(e.start, level), self._deeper(e.end, level)
            if not before and behind:
                begin, enter = self._where(i, level), i
            elif before and not behind and enter >= 0:
                found.append(Cut(begin, enter, self._where(i, level), i))
                enter = -1
        if enter >= 0:
            found.append(Cut(begin, enter, self.pieces[-1].end[along], None))
        return found

    def _where(self, i: int, level: float) -> float:
        """Along the cuts: where a piece meets a level that it goes through."""
        place = self.pieces[i].crossing(self.deep, level)
        assert place is not None
        return place

    # -- motions -----------------------------------------------------------------------------------

    def _region(self) -> None:
        """All cuts: those that lie below another one behind it, before the next beside it."""
        #   level 1   ------------ 1 ------------      what lies below a cut follows it at once, one
        #   level 2   -- 2 --.         .-- 4 --        trough to its bottom before the next
        #   level 3    - 3 -  `-------'  - 5 -
        left = [(1, cut) for cut in reversed(self._cuts(self._level(1)))]
        while left:
            k, cut = left.pop()
            self._one(k, cut)
            below = self._cuts(self._level(k + 1))
            within = [c for c in below if cut.enter <= c.enter <= self._last(cut)]
            left += [(k + 1, c) for c in reversed(within)]

    def _last(self, cut: Cut) -> int:
        return len(self.pieces) if cut.leave is None else cut.leave

    def _one(self, k: int, cut: Cut) -> None:
        """One cut, along the shape behind it, and out."""
        level = self._level(k)
        if cut.enter == 0:
            self._up(k)
            self._along(cut.begin)
            self._go("", self._place(cut.begin, level))
        else:
            self._enter(k, cut)
        self._go("G1", self._place(cut.end, level))
        if cut.leave is not None:
            self._climb(k, cut.leave)
        self._up(k)

    def _enter(self, k: int, cut: Cut) -> None:
        """Down into a trough, along the shape."""
        above, i = self._level(k - 1), cut.enter
        # Up the slope to the level of the cut before, or to the ridge: material above is gone
        # there.
        while i > 1 and self._deeper(self.pieces[i].start, above) and self._falls(i - 1):
            i -= 1
        e = self.pieces[i]
        head = e.start
        if not self._deeper(e.start, above):
            head = self._place(self._where(i, above), above)
        self._up(k)
        self._along(head[1 - self.deep])
        self._go("G1", head)
        for n in range(i, cut.enter):
            self._follow(n, self.pieces[n].end)
        self._follow(cut.enter, self._place(cut.begin, self._level(k)))

    def _falls(self, i: int) -> bool:
        e = self.pieces[i]
        return (e.end[self.deep] - e.start[self.deep]) * self.sense > NEAR

    def _climb(self, k: int, i: int) -> None:
        """Up along the shape, to the level of the cut before at most."""
        above = self._level(k - 1)
        for n in range(i, len(self.pieces)):
            e = self.pieces[n]
            if self._falls(n):
                return
            if self._deeper(e.end, above):
                self._follow(n, e.end)
                continue
            self._follow(n, self._place(self._where(n, above), above))
            return

    def _follow(self, n: int, to: Point) -> None:
        e = self.pieces[n]
        if e.is_arc:
            self._go("G3" if e.code == COUNTER else "G2", to, e.centre)
        else:
            self._go("G1", to)

    def _up(self, k: int) -> None:
        """Out to the level of the cut before and an escape more, if the tool is deeper."""
        # Cut k lies k depths below the start point; the one before it and an escape more is this
        # much below.
        over = (k - 1) * self.depth - self.escape
        # Never beyond the start point, where the stock is not known to end.
        height = self.top + self.sense * max(over, 0.0)
        if (self.at[self.deep] - height) * self.sense > NEAR:
            self._go("G0", self._place(self.at[1 - self.deep], height))

    def _along(self, place: float) -> None:
        self._go("G0", self._place(place, self.at[self.deep]))

    def _place(self, along: float, deep: float) -> Point:
        return (along, deep) if self.deep == 1 else (deep, along)

    def _go(self, code: str, to: Point, centre: Point | None = None) -> None:
        if math.dist(self.at, to) > NEAR or centre is not None:
            self.steps.append(Step(code, to, centre))
        if len(self.steps) > MOST_CUTS:
            raise TooMany
        self.at = to
