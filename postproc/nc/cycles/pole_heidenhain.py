"""G02 and G03 of Heidenhain's DIN/ISO: arcs about the pole that I J K set for all blocks behind, as
straight lines; G10 and G11: a rapid and a feed to the radius R and the angle H about it; G12 and
G13: with and against the clock to the angle H, as far from the pole as the tool stands.

HEIDENHAIN user's manuals, ISO programming, "Circular path G02/G03 around circle centre I, J" and
"Circular path with defined radius": in G90 the pole is a place, in G91 it counts from where the
tool stands; G29 puts it there (the geometry of arcs: pole_arc.py). Angles count from the first
axis of the plane ("Working plane and angle reference axis"). G12 and G13 with an incremental H
("Circular path G12/G13/G15 around pole I, J", "Helical interpolation") go on by that angle, whose
sign is that of the turn, over any number of revolutions; an axis across the plane makes a helix of
it. Lines leave the circle by the
tolerance at most: an arc could not be written back, for its pole would move all behind it.
"""

from __future__ import annotations

import math
import re

from postproc.nc.codes import Code
from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.pole_arc import Arc, Point, by_radius, ends
from postproc.nc.cycles.scene import CENTRES, CLOCKWISE, COUNTER, Scene
from postproc.nc.expand import Line

AT_LAST_PLACE, LABEL, SHIFT = 290, 980, 540
POLAR = {100: "G00", 110: "G01"}
ROUND = {120: -1, 130: 1}  # G12 and G13, 1: against the clock
FULL_TURN = 1e-6  # degrees: an end at the start is a full circle
# The language writes whole numbers without a point.
POINT = re.compile(rb"(?<=\d)\.(?!\d)")


class PoleArcs(Before):
    """Follows pole and motion code, and writes arcs out."""

    codes = (CLOCKWISE, COUNTER, *POLAR, *ROUND)

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.pole: dict[str, float] = {}
        self.motion = -1
        self.called = False

    def take(self, line: Line) -> list[Line]:
        """The line, or the lines that its arc becomes. Raises ProgramError."""
        scene = self.scene
        scene.forget()
        if scene.passes(line.text):
            return [line]
        body, star, rest = line.text.partition(b"*")
        block = Block.of(body, scene.dialect.grammar)
        scene.block = block
        if not block.plain:
            if self.motion in self.codes and re.search(rb"[XYZ][ \t]*[-+]?Q", body):
                raise scene.fault(
                    "an arc to a place that Q parameters say",
                    "they are not followed: write the numbers",
                )
            return [line]
        return self._plain(line, block, star + rest)

    def _plain(self, line: Line, block: Block, end: bytes) -> list[Line]:
        """A block of words: its modes and its pole hold, then its motion is written out."""
        scene = self.scene
        scene.note(block)
        self.motion = [self.motion, *scene.own_codes(block, "motion")][-1]
        self.called = self.called or (block.word("L") is not None and LABEL not in block.codes)
        rows = [scene.table[c] for c in block.codes if c in scene.table]
        taken = any(row.takes for row in rows)
        if AT_LAST_PLACE in block.codes:
            self.pole = {CENTRES[x]: scene.at(x) for x in scene.plane[:2]}
        elif SHIFT in block.codes:  # whether the pole goes along is not said
            self.pole = {}
        elif not taken:
            self._set(block)
        return [line] if taken else self._written(line, block, rows, end)

    # Whole: the kinds of motion in their order of precedence.
    def _written(self, line: Line, block: Block, rows: list[Code], end: bytes) -> list[Line]:
        """The block without words of a pole. rows: of its codes."""
        placed = any(block.word(x) for x in "XYZ")
        if self.motion not in self.codes:
            plain = placed and self.motion in (0, 10) and not any(row.refuses for row in rows)
            out = own_words(block, "IJK" * plain)
            return [line._replace(text=block.written(out) + end) if out else line]
        if self.motion in POLAR:
            return [line._replace(text=text) for text in self._polar(block, end)]
        if self.motion in ROUND and (block.word("H") or block.word("R") or placed):
            return [line._replace(text=text) for text in self._round(block, end)]
        if not placed:
            return self._bare(line, block, end)
        return [line._replace(text=text) for text in self._arc(block, end)]

    def _set(self, block: Block) -> None:
        """I J K in a block."""
        if not any(block.word(letter) for letter in CENTRES.values()):
            return
        incremental = self.scene.incremental
        for axis, letter in CENTRES.items():
            value = block.get(letter)
            if value is not None:
                self.pole[letter] = value + (self.scene.at(axis) if incremental else 0.0)

    def _bare(self, line: Line, block: Block, end: bytes) -> list[Line]:
        """A block without a place: its code is not the control's own business any more."""
        # G02 alone would leave the control in an arc, and lines named G01 alone follow: it goes
        # out.
        out = own_words(block, "", {CLOCKWISE, COUNTER, *ROUND})
        text = block.written(out) if out else block.text
        return [line._replace(text=text + end)] if text.strip(b" \t\r") else []

    # Whole: a list of refusals before one place is written.
    def _polar(self, block: Block, end: bytes) -> list[bytes]:
        """G10 and G11: to a radius and an angle. Raises ProgramError."""
        scene, radius, angle = self.scene, block.get("R"), block.get("H")
        first, second, _ = scene.plane
        own = own_words(block, "RHIJK", set(POLAR))
        if radius is None and angle is None and not any(block.word(x) for x in "XYZ"):
            text = block.written(own) if own else block.text
            return [text + end] if text.strip(b" \t\r") else []
        if radius is None or angle is None or block.word(first) or block.word(second):
            raise scene.fault(
                "polar words without R and H, or beside X and Y",
                "name the radius R and the angle H",
            )
        if scene.incremental:
            raise scene.fault("polar words in G91", "write R and H in G90")
        names = [CENTRES[x] for x in (first, second)]
        if any(x not in self.pole for x in names):
            raise scene.fault(
                "polar words, and no pole is set", f"write {' and '.join(names)} before"
            )
        turn = math.radians(angle)
        m = Moves(scene, own)
        place = (
            self.pole[names[0]] + radius * math.cos(turn),
            self.pole[names[1]] + radius * math.sin(turn),
        )
        words = [m.word(axis, value) for axis, value in zip((first, second), place, strict=True)]
        m.words(POLAR[self.motion], *words)
        return [POINT.sub(b"", text) + end for text in m.finish()]

    def _round(self, block: Block, end: bytes) -> list[bytes]:
        """G12 and G13: about the pole to an angle. Raises ProgramError."""
        scene, angle, turn = self.scene, block.get("H"), ROUND[self.motion]
        first, second, across = scene.plane
        if self.called:
            raise scene.fault(
                "an arc in a program that calls labels", "write the program out without L first"
            )
        if angle is None or block.word("R") or block.word(first) or block.word(second):
            raise scene.fault(
                "G12 or G13 without H, or with R, X or Y",
                "name the angle H alone: the radius is that of its start",
            )
        names = [CENTRES[x] for x in (first, second)]
        if any(x not in self.pole for x in names):
            raise scene.fault("an arc, and no pole is set", f"write {' and '.join(names)} before")
        centre = self.pole[names[0]], self.pole[names[1]]
        at = scene.at(first), scene.at(second)
        begin = math.degrees(math.atan2(at[1] - centre[1], at[0] - centre[0]))
        if scene.incremental:
            by, angle = angle * turn, angle + begin
            if by <= 0:
                raise scene.fault(
                    "H in G91 turns the other way than its G12 or G13",
                    "G13 with H above 0, G12 with H below",
                )
        else:  # above 0 and up to 360: an end at the start is all the way round
            # An end at the start, but for a rounding to either side (FULL_TURN), is all the way
            # round.
            by = ((angle - begin) * turn - FULL_TURN) % 360.0 + FULL_TURN
        away = math.dist(at, centre)
        to = (
            centre[0] + away * math.cos(math.radians(angle)),
            centre[1] + away * math.sin(math.radians(angle)),
        )
        # A helix: the axis across the plane goes in proportion, and over all revolutions of `by`.
        low, height = self._height(block, across)
        places = ends(scene, Arc(at, to, centre, turn, math.radians(by)))
        m = Moves(scene, own_words(block, f"{across}HIJK", set(ROUND)))
        for k, place in enumerate(places, 1):
            along = {across: low + height * k / len(places)} if height else {}
            m.move("G01", dict(zip((first, second), place, strict=True)) | along)
        return [POINT.sub(b"", text) + end for text in m.finish()]

    def _height(self, block: Block, across: str) -> tuple[float, float]:
        """Where the axis across the plane stands, and how far a helix takes it."""
        value = block.get(across)
        if value is None:
            return 0.0, 0.0
        low = self.scene.at(across)
        return low, value - (0.0 if self.scene.incremental else low)

    # -- the arc -----------------------------------------------------------------------------------

    def _arc(self, block: Block, end: bytes) -> list[bytes]:
        scene = self.scene
        first, second, across = scene.plane
        if self.called:
            raise scene.fault(
                "an arc in a program that calls labels", "write the program out without L first"
            )
        if block.word(across):
            raise scene.fault(
                f"{across} in an arc",
                "a helix is written in polar words here: write it as straight lines",
            )
        at = scene.at(first), scene.at(second)
        to = self._end(block, (first, second), at)
        m = Moves(scene, own_words(block, "XYZIJKR", {CLOCKWISE, COUNTER}))
        for place in ends(scene, self._about(block, at, to)):
            m.move("G01", dict(zip((first, second), place, strict=True)))
        return [POINT.sub(b"", line) + end for line in m.finish()]

    def _end(self, block: Block, names: tuple[str, str], at: Point) -> Point:
        scene = self.scene
        incremental, place = scene.incremental, []
        for axis, here in zip(names, at, strict=True):
            value = block.get(axis)
            place.append(here if value is None else here + value if incremental else value)
        return place[0], place[1]

    def _about(self, block: Block, at: Point, to: Point) -> Arc:
        """The arc about the pole, or of the radius R. Raises ProgramError."""
        scene, radius, turn = self.scene, block.get("R"), 1 if self.motion == COUNTER else -1
        if radius is not None:
            return by_radius(scene, at, to, radius, turn)
        names = [CENTRES[x] for x in scene.plane[:2]]
        missing = [x for x in names if x not in self.pole]
        if missing:
            raise scene.fault("an arc, and no pole is set", f"write {' and '.join(names)} before")
        return Arc(at, to, (self.pole[names[0]], self.pole[names[1]]), turn)
