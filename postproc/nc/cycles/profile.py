"""The finished shape of a lathe's cycle: lines and arcs from one numbered block to another, in the
ZX plane.

Lengths are in the program's unit, X as a radius whatever its words are.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from postproc.nc.cycles import drawing_fanuc
from postproc.nc.cycles.block import Block, blocks
from postproc.nc.cycles.drawing_fanuc import WRITE as WRITE_END
from postproc.nc.cycles.drawing_fanuc import Corner
from postproc.nc.cycles.pocket_path import Piece
from postproc.nc.cycles.pole_arc import centre_of
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER, Scene

# compensation of the nose radius: what it does to a roughing, the caller says
NOSE = (400, 410, 420)
# of a shape, where a roughing has its own: B-64304EN-1, "Multiple repetitive cycle"
IGNORED = (*NOSE, 960, 970)
ANYWHERE, ARCS = "NGXZFST", "IKR"  # letters of a shape, and of its arcs; F S T are the finishing's
MOTIONS = (0, 10, CLOCKWISE, COUNTER)
NEAR = 1e-9
Point = tuple[float, float]  # z, x radius
Row = tuple[int, Block, int]  # source line, block, its N


@dataclass(frozen=True)
class Element:
    """A line (`code` 0 or 10) or an arc from `start` to `end`, (z, x radius); the words of its
    `centre` as written, and where that lies."""

    code: int
    start: tuple[float, float]
    end: tuple[float, float]
    words: tuple[bytes, ...] = ()
    centre: tuple[float, float] = (0.0, 0.0)
    row: int = -1

    def moved(self, by: tuple[float, float]) -> Element:
        """The same, shifted by (z, x radius); its centre words are distances and stay."""

        def shift(p: Point) -> Point:
            return p[0] + by[0], p[1] + by[1]

        return replace(
            self, start=shift(self.start), end=shift(self.end), centre=shift(self.centre)
        )

    @property
    def is_arc(self) -> bool:
        return self.code in (CLOCKWISE, COUNTER)

    @property
    def piece(self) -> Piece:
        """Its geometry."""
        turn = {CLOCKWISE: -1, COUNTER: 1}.get(self.code, 0)
        return Piece(turn, self.start, self.end, self.centre)

    @property
    def monotonic(self) -> bool:
        """Whether neither coordinate turns back within: an arc within one quadrant."""
        if not self.is_arc:
            return True
        arms = [(p[0] - self.centre[0], p[1] - self.centre[1]) for p in (self.start, self.end)]
        (z0, x0), (z1, x1) = arms
        # Within a quadrant no coordinate of the arms at both ends changes its sign; a rounding
        # beyond an axis of the circle is let through.
        near = 1e-6 * max(1.0, math.hypot(z0, x0))
        same = not (z0 * z1 < -(near**2) or x0 * x1 < -(near**2) or min(z0 * z1, x0 * x1) < -near)
        turn = math.atan2(z0 * x1 - x0 * z1, z0 * z1 + x0 * x1)  # from Z towards X
        return same and (turn > -NEAR if self.code == COUNTER else turn < NEAR)

    def crossing(self, axis: int, value: float) -> float | None:
        """The other coordinate where coordinate `axis` (0: z, 1: x) has this value; None: nowhere.
        Monotonic ones only."""
        low, high = sorted((self.start[axis], self.end[axis]))
        other = 1 - axis
        if not low - NEAR <= value <= high + NEAR:
            return None
        if not self.is_arc:
            span = self.end[axis] - self.start[axis]
            # A cut along an element that lies at its level ends where the element begins.
            if abs(span) < NEAR:
                return self.start[other]
            share = (value - self.start[axis]) / span
            return self.start[other] + share * (self.end[other] - self.start[other])
        radius = math.dist(self.start, self.centre)
        along = math.sqrt(max(radius**2 - (value - self.centre[axis]) ** 2, 0.0))
        # Of both sides of the circle the one within the arc's own ends, or the least beyond them:
        # on an arc that turns back in no coordinate that is the one on it.
        found = [self.centre[other] + along, self.centre[other] - along]
        low, high = sorted((self.start[other], self.end[other]))
        return min(found, key=lambda v: max(low - v, v - high, 0.0))


class TooMany(Exception):
    """More cuts of a roughing than anybody means, or without an end."""


class Step(NamedTuple):
    """A motion of a roughing: "G0", "G1", "G2", "G3" or "" (the way in of the cycle); its end, and
    the centre of an arc, (z, x radius)."""

    code: str
    end: Point
    centre: Point | None = None


@dataclass(frozen=True)
class Profile:
    """The blocks from P to Q: their texts, the source lines (from 1) they take; `corners`: the
    ",C" and ",R" that stood in them, by number of the block."""

    texts: list[Block]
    first: int
    last: int
    corners: dict[int, re.Match[bytes]] = field(default_factory=dict)

    def drawn(self, scene: Scene) -> bool:
        """Whether corners or angles stand in it."""
        letters, motion = drawing_fanuc.bare(scene, "CRAIK"), 0
        for block in self.texts:
            motion = next((c for c in reversed(block.codes) if c in MOTIONS), motion)
            straight = motion not in (CLOCKWISE, COUNTER)
            if straight and any(w.letter in letters for w in block.words):
                return True
        return bool(self.corners)


def find(
    scene: Scene, lines: list[bytes], begin: int, end: int, after: int = 0, kept: int = 0
) -> Profile:
    """The blocks N`begin` to N`end`, behind source line `after` if that is not 0: the first ones,
    which a notice says where the number stands in other lines too. `kept`: the line in which a
    roughing with the same numbers found the first one (0: none did). Raises ProgramError."""
    rows = _numbered(scene, lines)
    first = _first(scene, rows, begin, after, kept)
    stop = next((i for i in range(first, len(rows)) if rows[i][2] == end), None)
    if stop is None:
        raise scene.fault(
            f"there is no block N{end} behind N{begin}", "Q names the last block of the shape"
        )
    chosen = rows[first : stop + 1]
    corners = {}
    for k, (line, block, number) in enumerate(chosen):
        text, corner = drawing_fanuc.split(block.text)
        if corner is not None and scene.dialect.language == "fanuc":
            corners[k], block = corner, Block.of(text, scene.dialect.grammar)
        if not block.plain and drawing_fanuc.bare(scene, "A"):
            block = Block.of(drawing_fanuc.without_comma(block.text), scene.dialect.grammar)
        # Variables, as they are where the cycle stands.
        if not block.plain and (worked := scene.tracker.rendered(block.text)) is not None:
            block = Block.of(worked, scene.dialect.grammar)
        chosen[k] = line, block, number
        if not block.plain:
            raise scene.fault(
                f"the shape's line {line} is more than words and numbers:"
                f" {block.text[:40].decode('latin-1')!r}",
                "variables must be written out in it",
            )
    return Profile([block for _, block, _ in chosen], chosen[0][0], chosen[-1][0], corners)


# Whole: the cases of a number that stands there never, once or more often.
def _first(scene: Scene, rows: list[Row], begin: int, after: int, kept: int) -> int:
    """The row of the shape's first block."""
    starts = [i for i, (line, _, n) in enumerate(rows) if n == begin and line > after]
    # A roughing takes the first P behind it; G70, which asks for no line (`after` 0), the one that
    # a roughing with the same numbers took before.
    if after and starts:
        line = rows[starts[0]][0]
        if others := [str(other) for other, _, n in rows if n == begin and other != line]:
            said = (
                f"N{begin} stands in line {', '.join(others)} too: the shape is the one behind the"
                f" cycle, in line {line}"
            )
            scene.tell(f"shape {begin}", said)
        return starts[0]
    if kept:
        starts = [i for i in starts if rows[i][0] == kept] or starts
    if not starts:
        where = f"behind line {after}" if after else "in the program"
        raise scene.fault(
            f"there is no block N{begin} {where}",
            "P and Q name the first and last block of the shape",
        )
    if len(starts) > 1:
        places = " and ".join(str(rows[i][0]) for i in starts[:2])
        raise scene.fault(
            f"N{begin} stands in lines {places}", "number the blocks of the shape once"
        )
    return starts[0]


def _numbered(scene: Scene, lines: list[bytes]) -> list[Row]:
    """All blocks that run, with their source line and N number (-1: none)."""
    rows = []
    for line, text in enumerate(lines, 1):
        if scene.passes(text):
            continue
        for part in blocks(text, scene.dialect.grammar):
            block = Block.of(part, scene.dialect.grammar)
            number = block.get("N")
            rows.append((line, block, int(number) if number is not None else -1))
    return rows


# Whole: one pass over the blocks, whose place and open line go on.
def shape(scene: Scene, profile: Profile, start: tuple[float, float], motion: int) -> list[Element]:
    """The elements of a profile, from a start point (z, x radius). Raises ProgramError."""
    here, incremental = start, scene.incremental
    elements: list[Element] = []
    corners: dict[int, Corner] = {}
    open_line: tuple[float, int] | None = None  # angle and block of a line whose end is not said
    for row, block in enumerate(profile.texts):
        motion, incremental = _modes(scene, block, motion, incremental)
        arc, angle, corner = motion in (CLOCKWISE, COUNTER), None, None
        _known(scene, block, arc)
        if not arc:
            word = block.word("A") if drawing_fanuc.bare(scene, "A") else None
            angle = None if word is None else scene.angle(word)
            corner = drawing_fanuc.corner_of(scene, block, profile.corners.get(row))
        place = _place(scene, block, here, incremental)
        # Of two lines by two angles the first has no end of its own: it waits for the second.
        if angle is not None and place == (None, None):
            if open_line is not None:
                raise scene.fault("two lines of the shape with A alone", drawing_fanuc.WRITE)
            open_line = angle, row
            if corner:
                corners[len(elements)] = corner
            continue
        z, x = (old if new is None else new for old, new in zip(here, place, strict=True))
        if open_line is not None:
            if angle is None or None in place:
                raise scene.fault("A alone, and the next line without A, X and Z", WRITE_END)
            meets = drawing_fanuc.meeting(scene, here, open_line[0], (z, x), angle)
            elements.append(Element(motion, here, meets, row=open_line[1]))
            here, open_line = meets, None
        elif angle is not None and None in place:
            z, x = drawing_fanuc.on_line(scene, here, angle, *place)
        # F or S alone in a shape, or a number: no element.
        if (z, x) == here:
            continue
        element = _arc(scene, block, Element(motion, here, (z, x), row=row))
        if corner:
            corners[len(elements)] = corner
        elements.append(element)
        here = (z, x)
    if open_line is not None:
        raise scene.fault("A alone in the last line of the shape", WRITE_END)
    if not elements:
        raise scene.fault("the shape of the cycle moves nothing", "check P and Q")
    return drawing_fanuc.rounded(scene, elements, corners) if corners else elements


def _modes(scene: Scene, block: Block, motion: int, incremental: bool) -> tuple[int, bool]:
    """The motion code, and whether words are distances, in a block."""
    for code in block.codes:
        if code in (900, 910) and scene.group_of(code) == "distance":
            incremental = code == 910
        elif code in (0, 10, CLOCKWISE, COUNTER):
            motion = code
        elif code not in IGNORED:
            text = block.text.strip().decode("latin-1")
            raise scene.fault(
                f"G{code / 10:g} in the shape of a cycle, in {text!r}",
                "only G0 G1 G2 G3 can be followed there",
            )
    return motion, incremental


def _known(scene: Scene, block: Block, arc: bool) -> None:
    """Raises ProgramError at a word that is none of a shape."""
    increments = [u for u, axis in scene.dialect.increments.items() if axis in "XZ"]
    drawn = ARCS if arc else drawing_fanuc.bare(scene, "CRAIK")
    known = ANYWHERE + drawn + "".join(increments)
    nothing = "J" * (arc and scene.dialect.skips_centre)
    strange = next(
        (w for w in block.words if w.letter not in known and (w.value or w.letter not in nothing)),
        None,
    )
    if strange:
        text = block.text.strip().decode("latin-1")
        raise scene.fault(
            f"{strange.letter}{strange.raw} in the shape of a cycle, in {text!r}, can not be"
            " followed",
            "write it before the cycle; chamfers and corner radii as blocks of their own",
        )


def _place(
    scene: Scene, block: Block, here: Point, incremental: bool
) -> tuple[float | None, float | None]:
    """The end of a block, None: it is not named."""
    place: list[float | None] = []
    for axis, start in zip("ZX", here, strict=True):
        increment, word = block.word(scene.increment(axis)), block.word(axis)
        named = increment or word
        by = increment is not None or incremental
        place.append(None if named is None else scene.goes(named, axis, start, by))
    return place[0], place[1]


def _arc(scene: Scene, block: Block, element: Element) -> Element:
    """With its centre, where it is an arc."""
    if not element.is_arc:
        return element
    radius, i, k = block.word("R"), block.word("I"), block.word("K")
    words = tuple(block.text[w.start : w.stop] for w in (radius, i, k) if w is not None)
    if radius is None:
        if i is None and k is None:
            raise scene.fault(
                "an arc of the shape has no I, K or R", "write its centre or its radius"
            )
        z0, x0 = element.start
        # I and K are distances from the start, I a radius even where X is a diameter.
        centre = (z0 + scene.length_in(block, "K", "Z"), x0 + scene.length_in(block, "I", "X"))
        return replace(element, words=words, centre=centre)
    r, chord = scene.length(radius, "X"), math.dist(element.start, element.end)
    if chord / 2 > abs(r) + scene.dialect.radius_tolerance_mm / scene.unit:
        raise scene.fault(
            f"a radius of {radius.raw} is too short for an arc of the shape over {chord:.4f}",
            "check the radius and the end point",
        )
    centre = centre_of(element.start, element.end, r, element.piece.turn)
    return replace(element, words=words, centre=centre)
