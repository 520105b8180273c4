"""G85, G86 and G87 of Okuma lathes: a shape between G81 (G82) and G80 roughed, copied, finished.

Okuma OSP-P200L / P20L programming manual 5238-E, section 8, LAP. D, U and the changes XA= are
diameters, all without a sign (P-175); a roughing infeeds by D from the AP starting point, cuts in
G01 to where the line parallel to Z (G82: X) meets the shape moved by U and W, and is drawn off by
the relieving amount (0.1 mm, an optional parameter, P-175); the last cut goes along the moved shape
(P-194, P-205). Copying (P-195): the N-th cut is the shape moved by
Xp = Xs - N D, Zp = Za + W + (Zs - Za - W) (1 - N D / (Xs - Xa - U)), less Xa + U and Za + W, until
the infeed reaches Xa + U; the last one lies at U and W. Behind it Z goes back to the AP starting
point, then X; M85 leaves that out (P-204).

        X ^            .   start (Zs, Xs)      G86: every cut is the whole shape, moved towards the
          |     _    _/                        start on the line between both; D is the depth along
          |   _/   _/   shape of cut N         X, and Z goes along in proportion
          |  /    /
          |  shape at U, W (Za, Xa)
          +----------------------> Z

Assumed: the way back of a roughing and of a finishing is that of copying; each cut begins at the
AP starting point's Z (G82: X); DA= and FA= of G84 hold from the first cut beyond XA= on. RELIEF
stands for the optional parameter. Nose radius compensation in the shape holds along the whole
shape: the cuts before it end on the shape as programmed, which a notice says. Rapids at the end of
a shape that draw the tool back along it, on the starting point's side of all of it, are no part of
what is roughed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from postproc.errors import ProgramError
from postproc.nc.cycles.moves import Moves
from postproc.nc.cycles.profile import Element, Point
from postproc.nc.cycles.roughing_fanuc import MOST_PASSES, NEAR, Pen, Roughing
from postproc.nc.cycles.scene import Scene

RELIEF = 0.1  # mm
WRITE = "let the CAM program write it out as G0, G1, G2 and G3"


@dataclass(frozen=True)
class Change:
    """DA= and FA= from XA= (ZA=) on: a place (x radius, z), a depth (x: radius), an F word."""

    at: float
    depth: float
    feed: bytes


@dataclass(frozen=True)
class Shape:
    """The elements of a shape, each with what its block says beside its end (G41, F): by block.
    `across`: G82."""

    elements: list[Element]
    beside: list[bytes]
    across: bool


@dataclass
class Call:
    """The words of G85, G86 or G87: radii, and the F word."""

    depth: float = 0.0
    allowance: Point = (0.0, 0.0)  # z, x radius; no signs
    feed: bytes = b""
    stays: bool = False  # M85
    changes: list[Change] = field(default_factory=list)


@dataclass
class BarTurning(Roughing):
    """One G85."""

    changes: tuple[Change, ...] = ()

    @property
    def begin(self) -> Point:
        return self.start

    def entry(self, level: float) -> float:
        return self.start[1 - self.deep]

    def levels(self) -> Iterator[float]:
        """Down by the depth in force, which changes, with the feed, beyond a place."""
        # The infeed depth changes on the way down: D up to XA, DA from the first cut beyond it on.
        target, level = self.rest[0].start[self.deep], self.start[self.deep]
        sense = 1 if target > level else -1
        depth, waiting = self.depth, list(self.changes)
        for _ in range(MOST_PASSES):
            while waiting and (level - waiting[0].at) * sense >= -NEAR:
                change = waiting.pop(0)
                depth = change.depth
                if change.feed:
                    self.pen.m.line(change.feed)
            level += sense * depth
            if (target - level) * sense <= NEAR:
                return
            yield level
        raise _too_many(self.pen.scene, MOST_PASSES + 1, self.depth)

    def cuts(self) -> None:
        """All but the one along the shape. Raises ProgramError where the shape turns back."""
        self._monotonic()
        self.pen.to("G0", self.begin)
        self._cuts()


class Lap:
    """Writes the calls out."""

    def __init__(self, scene: Scene):
        self.scene = scene

    def lines(self, code: int, shape: Shape, call: Call) -> list[bytes]:
        """The plain lines of G85 (850), G86 or G87. Raises ProgramError."""
        scene = self.scene
        if scene.code("cutter") in (410, 420):
            raise scene.fault(
                f"G{code // 10} with nose radius compensation on",
                "the control stops there: write G40 before it",
            )
        m = Moves(scene, set())
        pen = Pen(scene, m)
        start = (scene.at("Z"), scene.at("X") / scene.double("X"))
        by = self._allowance(shape, call, start)
        if call.feed:
            m.line(call.feed)
        if code == 850:
            self._rough(pen, shape, call, start, by)
        elif code == 860:
            self._copy(pen, shape, call, start, by)
        self._along(pen, shape, by)
        if not call.stays:
            pen.along("G0", 0, start[0])
            pen.along("G0", 1, start[1])
        return m.finish()

    @staticmethod
    def _allowance(shape: Shape, call: Call, start: Point) -> Point:
        """U and W towards the starting point: away from the part, outside and inside."""
        first = shape.elements[0].end
        return (
            call.allowance[0] * (1 if start[0] >= first[0] else -1),
            call.allowance[1] * (1 if start[1] >= first[1] else -1),
        )

    def _depth(self, call: Call, code: int) -> None:
        if call.depth <= 0:
            raise self.scene.fault(
                f"G{code} without a depth of cut above 0", "write D, a diameter, above 0"
            )

    def _rough(self, pen: Pen, shape: Shape, call: Call, start: Point, by: Point) -> None:
        """G85: cuts along the bar down to the shape."""
        scene = self.scene
        self._depth(call, 85)
        first, *rest = (e.moved(by) for e in shape.elements)
        if not rest or first.is_arc:
            raise scene.fault(
                "the shape has no straight way to its first point, or nothing behind it",
                "let its first block be G0 or G1 to its first point",
            )
        if any(word.startswith(b"G4") for word in b" ".join(shape.beside).split()):
            said = (
                "nose radius compensation holds in the cut along the shape: those before it end on"
                " the shape as programmed, by as much as the nose differs"
            )
            scene.tell("nose 850", said)
        relief = RELIEF / scene.unit
        deep = 0 if shape.across else 1
        rest = _cut_part(first, rest, deep, start)
        cut = BarTurning(
            pen, first, rest, deep, start, by, call.depth, relief, "", changes=tuple(call.changes)
        )
        try:
            cut.cuts()
        except ProgramError as error:
            if "the shape" in error.message:
                error.advice = WRITE
            raise

    def _copy(self, pen: Pen, shape: Shape, call: Call, start: Point, by: Point) -> None:
        """The shape, nearer each time: P-195."""
        self._depth(call, 86)
        first = shape.elements[0].end
        way = (start[0] - first[0] - by[0], start[1] - first[1] - by[1])
        deep = 0 if shape.across else 1
        if abs(way[deep]) < NEAR:
            raise self.scene.fault(
                "the starting point of G86 is as deep as the shape", "start outside of the part"
            )
        # The last copy lies at U and W and is the way along the shape, which follows: 1e-9 keeps a
        # whole number of cuts from making it twice.
        cuts = int(abs(way[deep]) / call.depth - 1e-9)
        if cuts > MOST_PASSES:
            raise _too_many(self.scene, cuts, call.depth)
        for n in range(1, cuts + 1):
            left = 1 - n * call.depth / abs(way[deep])
            self._along(pen, shape, (by[0] + left * way[0], by[1] + left * way[1]))
            pen.along("G0", 0, start[0])

    @staticmethod
    def _along(pen: Pen, shape: Shape, by: Point) -> None:
        """The whole shape, with what stands in its blocks."""
        said: set[int] = set()
        for e in shape.elements:
            # Once for a block, though a corner or an angle has made several elements of it.
            beside = shape.beside[e.row] if e.row not in said else b""
            said.add(e.row)
            if beside:
                pen.m.line(beside)
            pen.centred(e.moved(by), "G0" if e.code == 0 else "G1")
        # G40 in a block that moves nothing holds all the same.
        for row, beside in enumerate(shape.beside):
            if beside and row not in said:
                pen.m.line(beside)


def _cut_part(first: Element, rest: list[Element], deep: int, start: Point) -> list[Element]:
    """The shape without the rapids at its end, where they draw the tool back along the cuts on the
    starting point's side of all of it: they cut nothing, and the last cut goes along them."""
    ways = [e.end[1 - deep] - e.start[1 - deep] for e in rest]
    #          start o       A shape whose last block is a rapid out: roughing would find it turning
    #  ___    ___    :       back along the cuts, where the tool only leaves.
    #     \__/   \___: G0
    kept = list(rest)
    while len(kept) > 1 and kept[-1].code == 0:
        kept.pop()
    sense = 1 if first.end[deep] > start[deep] else -1
    nearest = min(sense * e.end[deep] for e in [first, *kept])
    aside = all(sense * e.end[deep] <= nearest + NEAR for e in rest[len(kept) :])
    return kept if aside and min(ways) < -NEAR and max(ways) > NEAR else rest


def _too_many(scene: Scene, passes: int, depth: float) -> ProgramError:
    return scene.fault(
        f"{passes:,} cuts of {depth:g} (limit {MOST_PASSES:,})", "check the depth of cut"
    )
