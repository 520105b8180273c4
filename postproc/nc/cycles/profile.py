"""The finished shape of a lathe's cycle: lines and arcs from one numbered block to another, in the ZX plane.

Lengths are in the program's unit, X as a radius whatever its words are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from postproc.nc.cycles.block import Block, Word, blocks
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER, Scene

NOSE = (
    400,
    410,
    420,
)  # compensation of the nose radius: what it does to a roughing, the caller says
IGNORED = (
    *NOSE,
    960,
    970,
)  # of a shape, where a roughing has its own: B-64304EN-1, "Multiple repetitive cycle"
ANYWHERE, ARCS = "NGXZFST", "IKR"  # letters of a shape, and of its arcs; F S T are the finishing's
NEAR = 1e-9


@dataclass(frozen=True)
class Element:
    """A line (`code` 0 or 10) or an arc from `start` to `end`, (z, x radius); the words of its `centre` as written, and
    where that lies."""

    code: int
    start: tuple[float, float]
    end: tuple[float, float]
    words: tuple[bytes, ...] = ()
    centre: tuple[float, float] = (0.0, 0.0)

    def moved(self, by: tuple[float, float]) -> Element:
        shift = lambda p: (p[0] + by[0], p[1] + by[1])  # noqa: E731
        return replace(
            self, start=shift(self.start), end=shift(self.end), centre=shift(self.centre)
        )

    @property
    def is_arc(self) -> bool:
        return self.code in (CLOCKWISE, COUNTER)

    @property
    def monotonic(self) -> bool:
        """Whether neither coordinate turns back within: an arc within one quadrant."""
        if not self.is_arc:
            return True
        arms = [(p[0] - self.centre[0], p[1] - self.centre[1]) for p in (self.start, self.end)]
        (z0, x0), (z1, x1) = arms
        near = 1e-6 * max(1.0, math.hypot(z0, x0))
        same = not (z0 * z1 < -(near**2) or x0 * x1 < -(near**2) or min(z0 * z1, x0 * x1) < -near)
        turn = math.atan2(z0 * x1 - x0 * z1, z0 * z1 + x0 * x1)  # from Z towards X
        return same and (turn > -NEAR if self.code == COUNTER else turn < NEAR)

    def crossing(self, axis: int, value: float) -> float | None:
        """The other coordinate where coordinate `axis` (0: z, 1: x) has this value; None: nowhere. Monotonic ones
        only."""
        low, high = sorted((self.start[axis], self.end[axis]))
        other = 1 - axis
        if not low - NEAR <= value <= high + NEAR:
            return None
        if not self.is_arc:
            span = self.end[axis] - self.start[axis]
            if abs(span) < NEAR:
                return self.start[other]
            share = (value - self.start[axis]) / span
            return self.start[other] + share * (self.end[other] - self.start[other])
        radius = math.dist(self.start, self.centre)
        along = math.sqrt(max(radius**2 - (value - self.centre[axis]) ** 2, 0.0))
        found = [self.centre[other] + along, self.centre[other] - along]
        low, high = sorted((self.start[other], self.end[other]))
        return min(found, key=lambda v: max(low - v, v - high, 0.0))


@dataclass(frozen=True)
class Profile:
    """The blocks from P to Q: their texts, the source lines (from 1) they take, and, read from a start point, the
    shape."""

    texts: list[Block]
    first: int
    last: int


def find(scene: Scene, lines: list[bytes], begin: int, end: int, after: int = 0) -> Profile:
    """The blocks N`begin` to N`end`, behind source line `after` if that is not 0. Raises ProgramError."""
    rows = _numbered(scene, lines)
    starts = [i for i, (line, _, n) in enumerate(rows) if n == begin and line > after]
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
    stop = next((i for i in range(starts[0], len(rows)) if rows[i][2] == end), None)
    if stop is None:
        raise scene.fault(
            f"there is no block N{end} behind N{begin}", "Q names the last block of the shape"
        )
    chosen = rows[starts[0] : stop + 1]
    for line, block, _ in chosen:
        if not block.plain:
            raise scene.fault(
                f"the shape's line {line} is more than words and numbers: {block.text[:40].decode('latin-1')!r}",
                "variables, chamfers and corner radii must be written out in it",
            )
    return Profile([block for _, block, _ in chosen], chosen[0][0], chosen[-1][0])


def _numbered(scene: Scene, lines: list[bytes]) -> list[tuple[int, Block, int]]:
    """All blocks with their source line and N number (-1: none)."""
    rows = []
    for line, text in enumerate(lines, 1):
        for part in blocks(text, scene.dialect.grammar):
            block = Block.of(part, scene.dialect.grammar)
            number = block.get("N")
            rows.append((line, block, int(number) if number is not None else -1))
    return rows


def shape(scene: Scene, profile: Profile, start: tuple[float, float], motion: int) -> list[Element]:
    """The elements of a profile, from a start point (z, x radius). Raises ProgramError."""
    here, incremental, elements = start, scene.incremental, []
    half = 2.0 if scene.is_diameter("X") else 1.0
    for block in profile.texts:
        text = block.text.strip().decode("latin-1")
        for code in block.codes:
            if code in (900, 910) and scene.group_of(code) == "distance":
                incremental = code == 910
            elif code in (0, 10, CLOCKWISE, COUNTER):
                motion = code
            elif code not in IGNORED:
                raise scene.fault(
                    f"G{code / 10:g} in the shape of a cycle, in {text!r}",
                    "only G0 G1 G2 G3 can be followed there",
                )
        arc = motion in (CLOCKWISE, COUNTER)
        increments = [u for u, axis in scene.dialect.increments.items() if axis in "XZ"]
        known = ANYWHERE + ARCS * arc + "".join(increments)
        strange = next((w for w in block.words if w.letter not in known), None)
        if strange:
            raise scene.fault(
                f"{strange.letter}{strange.raw} in the shape of a cycle, in {text!r}, can not be followed",
                "write it before the cycle; chamfers and corner radii as blocks of their own",
            )
        z = _coordinate(scene, block, "Z", here[0], 1.0, incremental)
        x = _coordinate(scene, block, "X", here[1], half, incremental)
        if (z, x) == here:
            continue
        element = Element(motion, here, (z, x))
        if element.is_arc:
            element = _arc(scene, block, element)
        elements.append(element)
        here = (z, x)
    if not elements:
        raise scene.fault("the shape of the cycle moves nothing", "check P and Q")
    return elements


def _coordinate(
    scene: Scene, block: Block, axis: str, here: float, half: float, incremental: bool
) -> float:
    increment = {x: u for u, x in scene.dialect.increments.items()}.get(axis, "")
    absolute, by = block.word(axis), block.word(increment) if increment else None
    if by is not None:
        return here + scene.length(by, axis) / half
    if absolute is None:
        return here
    value = scene.length(absolute, axis) / half
    return here + value if incremental else value


def _arc(scene: Scene, block: Block, element: Element) -> Element:
    """With its centre."""
    radius, i, k = block.word("R"), block.word("I"), block.word("K")
    words = tuple(block.text[w.start : w.stop] for w in (radius, i, k) if w is not None)
    (z0, x0), (z1, x1) = element.start, element.end
    if radius is None:
        if i is None and k is None:
            raise scene.fault(
                "an arc of the shape has no I, K or R", "write its centre or its radius"
            )
        centre = (z0 + _length(scene, k, "Z"), x0 + _length(scene, i, "X"))
        return replace(element, words=words, centre=centre)
    r, chord = scene.length(radius, "X"), math.dist(element.start, element.end)
    if chord / 2 > abs(r) + 1e-3:
        raise scene.fault(
            f"R{radius.raw} is too short for an arc of the shape over {chord:.4f}",
            "check R and the end point",
        )
    height = math.sqrt(max(r * r - chord * chord / 4, 0.0)) * (
        1 if (element.code == COUNTER) == (r > 0) else -1
    )
    normal = (-(x1 - x0) / chord, (z1 - z0) / chord)
    centre = ((z0 + z1) / 2 + normal[0] * height, (x0 + x1) / 2 + normal[1] * height)
    return replace(element, words=words, centre=centre)


def _length(scene: Scene, word: Word | None, axis: str) -> float:
    return scene.length(word, axis) if word is not None else 0.0
