"""G24 and G25 of Heidenhain's DIN/ISO: a chamfer and a rounding between two straight lines, written
out as G01.

HEIDENHAIN iTNC 530, TNC 320 (34055x), TNC 407 user's manuals, ISO programming, "Inserting a chamfer
between two straight lines", "Corner rounding G25": in a block of its own behind the line whose end
is the corner; R of G24 is how far the chamfer begins and ends from the corner on both lines, R of
G25 the radius of the arc that touches both; F beside R holds in the corner alone. The geometry:
klartext_corners.py.

Refused: G91, corners at arcs, at rapids, and at lines that leave the plane XY, a corner that is
longer than its lines, programs that call labels.
"""

from __future__ import annotations

import re

from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.klartext_corners import Corners, Held
from postproc.nc.cycles.klartext_lines import without_own_feed
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.pole_arc import Point
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line

CHAMFER, ROUNDING, FEED, DWELL, CALLED = 240, 250, 10, 40, 99
NAMES = {CHAMFER: "G24", ROUNDING: "G25"}
ACROSS = "ZABCUVWIJKHRLQ"  # in a line that leaves the plane, or is none
CORNER = re.compile(rb"(?<![A-Z])G[ \t]*0*2[45](?![0-9.])", re.IGNORECASE)
LABEL = re.compile(rb"(?<![A-Z;])L[ \t]*[0-9]+[ \t]*,", re.IGNORECASE)
WRITE = "write the corner out as G01"


class IsoCorners(Before):
    """Holds a straight feed with a corner back until the next block is known. `corner`: its name,
    size and feed; `start`: where the line begins; `feed`, `motion`: in force."""

    codes = (CHAMFER, ROUNDING)

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.corners = Corners(scene)
        self.held: tuple[Line, Block] | None = None
        self.corner: tuple[str, float, bytes] | None = None
        self.start: Point = (0.0, 0.0)
        self.feed, self.motion = b"", -1
        self.before: set[int] | None = None  # source lines with a corner behind them

    def finish(self) -> list[Line]:
        """A line that has no next one."""
        held, self.held, self.corner = self.held, None, None
        return [held[0]] if held else []

    def take(self, line: Line) -> list[Line]:
        """The lines that are known now. Raises ProgramError."""
        scene = self.scene
        scene.forget()
        body = line.text.partition(b"*")[0]
        block = scene.block = Block.of(body, scene.dialect.grammar)
        if scene.passes(line.text) or not body.partition(b";")[0].strip():
            return [line]
        names = [NAMES[c] for c in block.codes if c in NAMES]
        #   N10 G01 X+50 Y+0 F200 *    held: where it ends the corner and the next line say
        #   N20 G25 R5 F50 *           the corner, which leaves with them
        #   N30 G01 X+50 Y+40 *        N10 up to the arc, the arc at F50, N30 with F200 again
        if names:
            self._define(block, names[0])
            return []
        straight, feed = self._straight(block), self._feed(block)
        if self.corner is None:
            lines = self.finish()
        elif straight:
            own = self.corner[2]
            lines = self._cornered(block)
            # F of the corner holds in the corner alone, but as a written-out word it would go on.
            if own and not feed:
                line = line._replace(text=self._fed(block) + b"*")
        else:
            raise self._beside(self.corner[0])
        self.feed = feed or self.feed
        scene.block = block
        if not (straight and self._has_corner()):
            return [*lines, line]
        self.held = line, block
        return lines

    def _feed(self, block: Block) -> bytes:
        """The feed that a block names, b"": none, or the time of a dwell."""
        code = without_own_feed(block.text)
        word = block.word("F")
        named = word is not None and word.start < len(code) and DWELL not in block.codes
        return word.raw.encode() if word and named else b""

    def _fed(self, block: Block) -> bytes:
        """A block with the feed in force, in front of M103, which has an F of its own behind it."""
        machine = (i for i, w in enumerate(block.words) if w.letter == "M")
        return block.written(set(), b"F" + self.feed, next(machine, len(block.words)))

    def _has_corner(self) -> bool:
        """Whether a corner stands behind the line at hand."""
        if self.before is None:
            self.before, last = set(), 0
            for number, text in enumerate(self.scene.lines(), 1):
                code = text.partition(b"*")[0].partition(b";")[0]
                if CORNER.search(code):
                    self.before.add(last)
                last = number if code.strip() else last
        # Looked for in the whole text, so that only lines with a corner are held back and all
        # others leave at once.
        return self.scene.source in self.before

    def _straight(self, block: Block) -> bool:
        """Whether a block is a feed in the plane to a place."""
        scene = self.scene
        self.motion = [self.motion, *scene.own_codes(block, "motion")][-1]
        if not block.plain or any(w.letter in ACROSS for w in block.words):
            return False
        rows = [scene.table[c] for c in block.codes if c in scene.table]
        if CALLED in block.m_codes() or any(row.takes or row.refuses for row in rows):
            return False
        return self.motion == FEED and any(w.letter in "XY" for w in block.words)

    def _beside(self, name: str) -> Exception:
        return self.scene.fault(f"{name} beside something else than a straight feed in XY", WRITE)

    # Whole: a list of refusals, a condition to each.
    def _define(self, block: Block, name: str) -> None:
        scene, size, feed = self.scene, block.get("R"), block.word("F")
        odd = [w for w in block.words if w.letter not in "NGRF"]
        if size is None or size <= 0 or odd or len(block.codes) > 1:
            raise scene.fault(f"{name} with more than its size R, or without it", WRITE)
        if self.held is None or self.corner is not None:
            raise self._beside(name)
        if any(LABEL.search(text.partition(b";")[0]) for text in scene.lines()):
            raise scene.fault(
                "a corner in a program that calls labels", "write the program out without L first"
            )
        if scene.code_of(self.held[1], "distance") == 910 or scene.plane[2] != "Z":
            raise scene.fault(f"{name} in G91, or in another plane than XY", WRITE)
        if feed is not None and not self.feed:
            raise scene.fault(f"the feed behind {name} is not known", "write F before it")
        self.corner = name, size, feed.raw.encode() if feed else b""
        # The line is held, so the tracker still stands where it begins.
        self.start = scene.at("X"), scene.at("Y")

    def _end(self, block: Block, start: Point) -> Point:
        x, y = block.get("X"), block.get("Y")
        return start[0] if x is None else x, start[1] if y is None else y

    def _cornered(self, block: Block) -> list[Line]:
        """The line with a corner, up to where the next one begins."""
        assert self.held is not None and self.corner is not None
        (line, before), (name, size, feed) = self.held, self.corner
        kind = "CHF" if name == NAMES[CHAMFER] else "RND"
        corner = self._end(before, self.start)
        held = Held(b"", self.start, corner, kind, size, b"")
        end, points = self.corners.cut(held, self._end(block, corner), name)
        self.held = self.corner = None
        if not points:
            return [line]
        star = line.text.partition(b"*")[1:]
        texts = [before.written(own_words(before, "XY"), self._words(end)) + b"".join(star)]
        for k, point in enumerate(points):
            own = b" F" + feed if feed and not k else b""
            texts.append(b"G01 " + self._words(point) + own + b"*")
        return [line._replace(text=text) for text in texts]

    def _words(self, place: Point) -> bytes:
        texts = (self.scene.text(x, v) for x, v in zip("XY", place, strict=True))
        return b" ".join(text.rstrip(b".") for text in texts)
