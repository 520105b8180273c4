r"""G71 and G72 of Fanuc and Haas lathes: cuts parallel to Z or X over a shape, then one along it.

    X ^                              c   start point, moved by the allowances
      |     3 /. . . . . . . . . . . |   1  down to the next level, counted from c
      |      / <-------- 2 ----------+   2  along at F, to the shape
      |  ___/                            3  out at 45 degrees by the retract, back above the cut
      |     \_________                      and so on; the last cut runs along the shape itself
      |       shape   \______
      +--------------------------------> Z     (G71; in G72 X and Z change places)

What is followed, what is assumed, and where it comes from: turning_fanuc.py, and pockets_fanuc.py
for type II.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from postproc.nc.cycles.moves import Moves
from postproc.nc.cycles.pockets_fanuc import TypeTwo, quarters
from postproc.nc.cycles.profile import Element, Point, Step, TooMany
from postproc.nc.cycles.scene import CLOCKWISE, Scene

MOST_PASSES = 10_000
NEAR = 1e-9
# a quarter of a circle whose ends are rounded to the least increment goes beyond it by less
BACK = 1e-5
BOTH = "name X and Z in its first block: that chooses type II, with pockets"
BOTH_OR_START = (
    "stand on the side of the material before the cycle, from where it cuts towards that block; or"
    " name X and Z in its first block: that chooses type II, with pockets"
)
ONE_WAY = "no type of the cycle cuts that: divide the shape where it turns back"


@dataclass
class Pen:
    """Writes motions to (z, x radius)."""

    scene: Scene
    m: Moves

    @property
    def half(self) -> float:
        """Words along X for a radius: 2 for diameters, else 1."""
        return self.scene.double("X")

    def to(self, code: str, place: Point) -> None:
        """A motion of both axes, (z, x radius)."""
        self.m.move(code, {"X": place[1] * self.half, "Z": place[0]})

    def along(self, code: str, axis: int, value: float) -> None:
        """Along Z (0) or X (1) alone."""
        self.m.move(code, {"X": value * self.half} if axis else {"Z": value})

    def element(self, e: Element, nose: str = "") -> None:
        """A line or an arc of the shape, as it was written; `nose`: " G42" where it starts."""
        if not e.is_arc:
            self.to(("G0" if e.code == 0 else "G1") + nose, e.end)
            return
        to = {"X": e.end[1] * self.half, "Z": e.end[0]}
        self.m.move("G2" if e.code == CLOCKWISE else "G3", to, *e.words)

    def steps(self, way: Iterable[Step], infeed: str = "") -> None:
        """The motions of a roughing; `infeed`: the code of the way in."""
        for step in way:
            if step.centre is None:
                self.to(step.code or infeed, step.end)
            else:
                self.arc(step.code, step.end, step.centre)

    def centred(self, e: Element, code: str) -> None:
        """A line by this code, or an arc, its centre as I K."""
        if e.is_arc:
            self.arc("G2" if e.code == CLOCKWISE else "G3", e.end, e.centre)
        else:
            self.to(code, e.end)

    def arc(self, code: str, end: Point, centre: Point) -> None:
        """An arc from where the tool stands."""
        scene = self.scene
        words = [
            scene.text("I", centre[1] - scene.at("X") / self.half),
            scene.text("K", centre[0] - scene.at("Z")),
        ]
        self.m.move(code, {"X": end[1] * self.half, "Z": end[0]}, *words)


@dataclass
class Roughing:
    """One G71 (`deep` 1: down in X, along Z) or G72 (0). `first`: the way in, `rest`: the shape,
    both moved by the `allowance`; `nose`: what holds in the cut along the shape, " G42" or ""."""

    pen: Pen
    first: Element
    rest: list[Element]
    deep: int
    start: Point
    allowance: Point
    depth: float
    escape: float
    nose: str
    stops: bool = False  # at a shape that turns back, with an alarm

    @property
    def begin(self) -> Point:
        """The start point, moved as the shape is."""
        return self.start[0] + self.allowance[0], self.start[1] + self.allowance[1]

    @property
    def infeed(self) -> str:
        """The code of the way in, that of the first block: G0 or G1."""
        return "G0" if self.first.code == 0 else "G1"

    @property
    def turns(self) -> bool:
        """Whether the shape turns back in depth."""
        return _turns(ways(self.rest, self.deep))

    def write(self, second: bool) -> None:
        """The motions. `second`: type II is chosen. Raises ProgramError."""
        pockets = second and self.turns
        if not pockets:
            self._monotonic()
        if self.first.is_arc or self.first.start[self.deep] == self.first.end[self.deep]:
            raise self.pen.scene.fault(
                f"the first block of the shape does not go to its depth in {'ZX'[self.deep]}",
                "let it be G0 or G1 to the first point of the shape",
            )
        self.pen.to("G0", self.begin)
        if pockets:
            self._pockets()
        else:
            self._cuts()
        self.pen.to(self.infeed + self.nose, self.first.end)
        for e in self.rest:
            self.pen.element(e)
        self.pen.to("G0 G40" if self.nose else "G0", self.start)

    # -- type I ------------------------------------------------------------------------------------

    def _cuts(self) -> None:
        """Cuts from the start's side down to the first point of the shape."""
        deep, along, first, rest = self.deep, 1 - self.deep, self.first, self.rest
        fault, pen, c = self.pen.scene.fault, self.pen, self.begin
        # Type I works from the first point, the deepest of the shape, out to the last one: a shape
        # that dives on behind it would be cut into by levels that were never counted.
        behind = rest[-1].end[deep] - rest[0].start[deep]
        if behind * (first.end[deep] - first.start[deep]) > NEAR:
            raise fault(
                f"the shape goes deeper in {'ZX'[deep]} behind its first block", BOTH_OR_START
            )
        side = 1 if rest[-1].end[along] > c[along] else -1
        sense = 1 if rest[0].start[deep] > c[deep] else -1
        # G71, one cut (G72: the same, X and Z exchanged):
        #     begin  <------------- G0 --------------+
        #       | infeed, one depth deeper            \  G0, 45 degrees by the escape
        #     level  -------------- G1 --------------> stop, on the shape
        for level in self.levels():
            crossings = (e.crossing(deep, level) for e in rest)
            stop = next((v for v in crossings if v is not None), rest[-1].end[along])
            begin = self.entry(level)
            pen.to(self.infeed, (begin, level) if deep else (level, begin))
            pen.along("G1", along, stop)
            out = [0.0, 0.0]
            out[deep], out[along] = level - sense * self.escape, stop - side * self.escape
            pen.to("G0", (out[0], out[1]))
            pen.along("G0", along, begin)

    def entry(self, level: float) -> float:
        """Where the cut at a level begins: on the first block, where that moves both axes too."""
        begin = self.first.crossing(self.deep, level)
        assert begin is not None
        return begin

    def levels(self) -> Iterator[float]:
        """The depths of the cuts, one after the other: z, or x as a radius. Raises ProgramError."""
        target, here = self.rest[0].start[self.deep], self.begin[self.deep]
        sense = 1 if target > here else -1
        passes = int(abs(target - here) / self.depth) + 1
        if passes > MOST_PASSES:
            raise self.pen.scene.fault(
                f"{passes:,} cuts of {self.depth:g} (limit {MOST_PASSES:,})",
                "check the depth of cut",
            )
        for k in range(1, passes + 1):
            level = here + sense * k * self.depth
            # That depth is cut along the shape, as the last one.
            if (target - level) * sense <= NEAR:
                return
            yield level

    def _monotonic(self) -> None:
        """Type I: neither Z nor X turns back, also not in a last block that only draws the tool
        out."""
        fault, along = self.pen.scene.fault, 1 - self.deep
        for axis in (0, 1):
            if not _turns(ways(self.rest, axis)):
                continue
            # The last block alone turns back: it is meant to draw the tool out.
            if axis == along and not _turns(ways(self.rest[:-1], axis)):
                raise fault(
                    f"the last block of the shape takes {'ZX'[axis]} back{self._alarm(axis)}",
                    "that is no part of the contour: end the shape before it, the cycle goes back"
                    " by itself",
                )
            way_out = ONE_WAY if axis == along else BOTH
            raise fault(f"{'ZX'[axis]} turns back within the shape{self._alarm(axis)}", way_out)

    def _alarm(self, axis: int) -> str:
        """What a Fanuc says to an axis that turns back (B-64304EN-1, list of alarms)."""
        number = ("PS0064", "PS0329")[axis]
        return f": the control stops (alarm {number})" if self.stops else ""

    # -- type II -----------------------------------------------------------------------------------

    def _pockets(self) -> None:
        """Cuts with the shape behind each, pockets one after the other."""
        deep, fault, c = self.deep, self.pen.scene.fault, self.begin
        letter = "ZX"[deep]
        if _turns(ways(self.rest, 1 - deep)):
            said = f"{'XZ'[deep]} turns back within the shape{self._alarm(1 - deep)}"
            raise fault(said, ONE_WAY)
        depths = [e.end[deep] - c[deep] for e in [self.first, *self.rest[:-1]]]
        sense = 1 if max(depths, key=abs) > 0 else -1
        if any(depth * sense < -NEAR for depth in depths):
            raise fault(
                f"the shape goes beyond the start point in {letter}",
                "start outside of the shape, on the side of the stock",
            )
        if self.allowance[deep] * sense > NEAR:
            raise fault(
                f"the finishing allowance along {letter} lies in the part",
                "the start point, or the sign of the allowance, is on the wrong side",
            )
        try:
            # Arcs in quarters: TypeTwo asks of each piece only whether it falls or climbs.
            pieces = [self.first, *(part for e in self.rest for part in quarters(e))]
            way = TypeTwo(pieces, deep, sense, c[deep], self.depth, self.escape).way(c)
        except TooMany:
            raise fault(
                f"more than {MOST_PASSES:,} motions in cuts of {self.depth:g}",
                "check the depth of cut",
            ) from None
        self.pen.steps(way, self.infeed)


def ways(elements: list[Element], axis: int) -> list[float]:
    """How far each element goes along Z (0) or X (1), arcs in pieces that do not turn back."""
    return [part.end[axis] - part.start[axis] for e in elements for part in quarters(e)]


def _turns(found: list[float]) -> bool:
    return min(found, default=0.0) < -BACK and max(found, default=0.0) > BACK


def draws_out(rest: list[Element], along: int) -> bool:
    """Whether the last block of a shape rapids back along the cuts."""
    return len(rest) > 1 and rest[-1].code == 0 and _turns(ways(rest, along))
