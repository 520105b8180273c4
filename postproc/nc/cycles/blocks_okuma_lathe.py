"""Blocks of Okuma lathes as plain ones: lines that go on behind `$` are joined, names of blocks
(NLAP1) are taken off, arcs by their radius L get I and K, and the calls of shapes (LAP) are written
out: lap_okuma.py.

Okuma OSP-P200L / P20L programming manual 5238-E, P-175 to P-218. A shape stands between G81 (G82)
and G80, under the name of its first block; where the program comes to it the control steps over it.
In its blocks F is the finishing's, E the roughing's along the shape. In it and elsewhere G75 and
G76 with L make a chamfer or an arc of L at the end of their block, and A is the angle of a line one
of whose ends is not said, from +Z towards +X: so A135 and A315 make the chamfers that shops write
with them. Its numbers may be worked out (X=V1) where the program comes to it before the call
(expand/okuma.py). Corners and angles of plain blocks are handed on as those of Fanuc
(corners_fanuc.py). Refused in a shape: what is none of G0 to G3, G40 to G42, G90, G91, G75,
G76; a blank's shape (G83), which is the control's extra (LAP4).
"""

from __future__ import annotations

import math
import re

from postproc.nc.cycles import drawing_fanuc
from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.grooving_okuma import without_offset
from postproc.nc.cycles.lap_okuma import Call, Change, Lap, Shape
from postproc.nc.cycles.pole_arc import centre_of
from postproc.nc.cycles.profile import Point, Profile, shape
from postproc.nc.cycles.scene import CENTRES, CLOCKWISE, COUNTER, Scene
from postproc.nc.expand import Line

COMMENT = re.compile(rb"\([^()\n]*\)")
HEAD = re.compile(rb"[ \t]*(/[ \t]*)?(?:N[ \t]*([A-Z0-9]+)(?=[ \t(\r]|$))?[ \t]*", re.IGNORECASE)
# not the name of the program file, $PART1.MIN%, which begins such a file
GOES_ON = re.compile(rb"[ \t]*\$(?![-A-Z0-9._]*%)", re.IGNORECASE)
CALLED = re.compile(rb"G[ \t]*(8[5-7])[ \t]*N([A-Z0-9]+)", re.IGNORECASE)
BEGINS = re.compile(rb"(?<![A-Z])G[ \t]*(8[12])(?![0-9])", re.IGNORECASE)
ENDS = re.compile(rb"(?<![A-Z])G[ \t]*80(?![0-9])", re.IGNORECASE)
WORDS = re.compile(rb"([A-Z]{1,2})[ \t]*=?[ \t]*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))", re.IGNORECASE)
CORNERS = {750: b",C", 760: b",R"}
NOSE = (40, 41, 42)
OWN = "XZIKGRA"  # words of a shape's block that its element is made of
BESIDE = "FSEN"
LENGTHS = ("D", "DA", "DB", "U", "XA", "XB")  # diameters
LENGTHS_Z = ("W", "ZA", "ZB")
NAME = re.compile(rb"(/?[ \t]*)N[A-Z][A-Z0-9]{0,3}(?=[ \t(\r]|$)[ \t]*", re.IGNORECASE)


class LatheBlocks(Before):
    """Reads the program line by line, and further on where a line calls for it."""

    codes = (800, 810, 820, 840, 850, 860, 870)

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.lap = Lap(scene)
        self.motion = 0
        self.within = False  # a shape that the control steps over
        # file and line of its blocks, with the numbers that were worked out
        self.passed: dict[tuple[str, int], bytes] = {}

    # Whole: the kinds of lines in their order of precedence.
    def take(self, line: Line) -> list[Line]:
        """The lines that stand for one. Raises ProgramError."""
        # A line that goes on was joined to the one before (`_whole`) and leaves nothing here.
        if GOES_ON.match(line.text) or self.scene.passes(line.text):
            return [] if GOES_ON.match(line.text) else [line]
        #  N10 NLAP1 G81 .. G80    a shape: stepped over, its numbers kept (`passed`)
        #  G85 NLAP1 D4 U.4        its call: what LAP makes of the shape under that name
        #  NAT01 G2 X50 L10        a name is taken off, L becomes I and K
        text = self._whole(line)
        code = _code(text)
        if self.within or BEGINS.search(code):
            self._steps_over(line, code)
            # Not the source text: variables have their numbers where the program comes to the
            # shape.
            self.passed[line.file, line.source] = line.text
            return []
        called = CALLED.search(code)
        if called:
            self.scene.block = Block.of(b"", self.scene.dialect.grammar)
            self.scene.forget()
            return [line._replace(text=t) for t in self._called(code, called, line.file)]
        text = NAME.sub(rb"\1", text, count=1) if NAME.match(text) else text
        block = Block.of(text, self.scene.dialect.grammar)
        self._note(block)
        alone = next((c // 10 for c in block.codes if c in self.codes), None)
        if alone is not None:
            raise self.scene.fault(
                f"G{alone} without the name of a shape",
                "write the name that the first block of the shape has behind it: G85 NLAP1",
            )
        text = (
            self._centred(block)
            or self._cornered(block)
            or without_offset(self.scene, block)
            or text
        )
        return [line] if text == line.text else [line._replace(text=text)]

    def _steps_over(self, line: Line, code: bytes) -> None:
        """A block of a shape where the program comes to it."""
        if not self.within:
            head = HEAD.match(line.text)
            if head is None or head[2] is None:
                raise self.scene.fault(
                    "a shape without a name",
                    "G81 and G82 begin a shape here, which is called by the name of its first"
                    " block: write one (NLAP1 G81), or choose the right --dialect",
                )
            # Without this, all that stands behind an open shape would leave the program in silence.
            if not any(ENDS.search(_code(x)) for x in self.scene.lines()[line.source - 1 :]):
                raise self.scene.fault("a shape without an end", "write G80 behind its last block")
        self.within = not ENDS.search(code)

    def _note(self, block: Block) -> None:
        for code in block.codes:
            if self.scene.group_of(code) == "motion":
                self.motion = code

    def _whole(self, line: Line) -> bytes:
        """A line with those that go on behind it."""
        lines, text = self.scene.lines(), line.text.rstrip(b"\r")
        for more in lines[line.source :]:
            if not GOES_ON.match(more):
                break
            text += b" " + more.rstrip(b"\r").strip(b" \t")[1:].strip(b" \t")
        return text if text != line.text.rstrip(b"\r") else line.text

    def _cornered(self, block: Block) -> bytes | None:
        """G75 or G76 of a straight block as the corner of Fanuc's that it is."""
        if not block.plain or not any(c in CORNERS for c in block.codes):
            return None
        text, corner = self._corner(block)
        return text + corner

    def _corner(self, block: Block) -> tuple[bytes, bytes]:
        """A block without its G75 or G76 and the L of it, and the ",C" or ",R" that it means."""
        own = next(c for c in block.codes if c in CORNERS)
        size = block.word("L")
        if size is None:
            raise self.scene.fault("G75 or G76 without L", "write the size of the corner")
        out = {i for i, w in enumerate(block.words) if w is size or _number(w) == own}
        return block.written(out), CORNERS[own] + size.raw.encode()

    # -- arcs --------------------------------------------------------------------------------------

    def _centred(self, block: Block) -> bytes | None:
        """An arc by L with I and K in its place."""
        radius = block.word("L")
        if radius is None or self.motion not in (CLOCKWISE, COUNTER) or not block.plain:
            return None
        scene = self.scene
        scene.block = block
        scene.forget()
        scene.note(block)
        axes = scene.plane[:2]
        a, b = (scene.at(x) / scene.double(x) for x in axes)
        start = a, b
        a, b = (
            scene.goes(block.word(x), x, here, scene.incremental)
            for x, here in zip(axes, start, strict=True)
        )
        centre = _centre(scene, self.motion, start, (a, b), radius)
        words = b" ".join(
            scene.text(CENTRES[x], c - s) for x, c, s in zip(axes, centre, start, strict=True)
        )
        at = block.words.index(radius)
        return block.written(set(), changed={at: words})

    # -- shapes ------------------------------------------------------------------------------------

    def _called(self, code: bytes, called: re.Match[bytes], file: str) -> list[bytes]:
        number = int(called[1])
        values = {}
        for found in WORDS.finditer(code, called.end()):
            letter, raw = found[1].decode(), found[2].decode()
            word = Word(letter, float(raw), raw, *found.span())
            along_x = letter in LENGTHS
            length = along_x or letter in LENGTHS_Z
            values[letter] = (
                self.scene.length(word, "X" if along_x else "Z") if length else float(raw)
            )
        made = self._shape(called[2], file)
        return self.lap.lines(10 * number, made, self._call(values, code))

    def _call(self, values: dict[str, float], code: bytes) -> Call:
        """The words of a call, lengths along X as radii."""
        half = self.scene.double("X")
        strange = set(values) - {*LENGTHS, *LENGTHS_Z, "G", "F", "FA", "FB", "M"}
        if strange:
            raise self.scene.fault(
                f"{min(strange)} in the call of a shape: that is no word of it",
                "take it out, or write it in another block",
            )
        across = "ZA" in values or "ZB" in values
        own = "Z" if across else "X"
        changes = []
        for letter in "AB":
            if own + letter in values:
                # DB left out is DA, and DA left out D.
                depth = values.get("D" + letter, values.get("DA", values.get("D", 0.0))) / half
                feed = values.get("F" + letter)
                changes.append(
                    Change(
                        values[own + letter] / (1.0 if across else half),
                        depth,
                        b"" if feed is None else self.scene.text("F", feed),
                    )
                )
        feed = values.get("F")
        return Call(
            values.get("D", 0.0) / half,
            (abs(values.get("W", 0.0)), abs(values.get("U", 0.0)) / half),
            b"" if feed is None else self.scene.text("F", feed),
            re.search(rb"M[ \t]*85(?![0-9])", code) is not None,
            changes,
        )

    def _shape(self, name: bytes, file: str) -> Shape:
        """The blocks under a name, up to G80."""
        scene, beside = self.scene, []
        texts: list[Block] = []
        corners: dict[int, re.Match[bytes]] = {}
        across = found = False
        for line, written in enumerate(scene.lines(), 1):
            raw = self.passed.get((file, line), written)
            code = _code(raw)
            head = HEAD.match(raw)
            if not found:
                begins = BEGINS.search(code)
                if head is None or (head[2] or b"").upper() != name.upper() or not begins:
                    continue
                found, across = True, begins[1] == b"82"
                code = BEGINS.sub(b"", code)
            if ENDS.search(code):
                break
            block, corner = self._element(code, line)
            if corner is not None:
                corners[len(texts)] = corner
            texts.append(Block.of(_only(block, OWN), scene.dialect.grammar))
            beside.append(_beside(block))
        if not found:
            raise scene.fault(
                f"there is no shape N{name.decode()} in the program",
                "its first block has this name and G81 or G82",
            )
        start = (scene.at("Z"), scene.at("X") / scene.double("X"))
        elements = shape(scene, Profile(texts, 0, 0, corners), start, 0)
        return Shape(elements, beside, across)

    def _element(self, code: bytes, line: int) -> tuple[Block, re.Match[bytes] | None]:
        """A block of a shape, its radius as R, and the corner at its end."""
        scene = self.scene
        block = Block.of(code, scene.dialect.grammar)
        if not block.plain:
            raise scene.fault(
                f"the shape's line {line} is more than words and numbers:"
                f" {code[:40].decode('latin-1')!r}",
                "let the program come to it, with its variables set, before it is called",
            )
        strange = next((w for w in block.words if w.letter not in OWN + BESIDE + "L"), None)
        if strange is not None:
            raise scene.fault(
                f"{strange.letter}{strange.raw} in the shape's line {line}: that is no word of it",
                "take it out, or write it in another block",
            )
        if not any(c in CORNERS for c in block.codes):
            radius = block.word("L")
            text = code if radius is None else b"".join(
                (code[: radius.start], b"R", code[radius.start + 1 :])
            )  # fmt: skip
            return Block.of(text, scene.dialect.grammar), None
        text, made = self._corner(block)
        _, corner = drawing_fanuc.split(text + made)
        return Block.of(text, scene.dialect.grammar), corner


def _code(text: bytes) -> bytes:
    """A block without its slash, its name or number, and its comments, in capitals."""
    head = HEAD.match(text)
    assert head is not None
    return COMMENT.sub(b" ", text[head.end() :]).strip(b" \t\r").upper()


def _number(word: Word) -> int:
    return round(10 * (word.value or 0)) if word.letter == "G" else -1


def _only(block: Block, letters: str) -> bytes:
    """The block without the nose, and with these letters alone."""
    keep = [w for w in block.words if w.letter in letters and _number(w) // 10 not in NOSE]
    if any(_number(w) == 400 for w in block.words):  # I K of G40 say a direction, and no place
        keep = [w for w in keep if w.letter not in "IK"]
    return b" ".join(block.text[w.start : w.stop] for w in keep)


def _beside(block: Block) -> bytes:
    """G40 to G42, F and S of a block."""
    return b" ".join(
        block.text[w.start : w.stop]
        for w in block.words
        if w.letter in "FS" or _number(w) // 10 in NOSE
    )


def _centre(scene: Scene, motion: int, start: Point, end: Point, word: Word) -> Point:
    """Of the arc below a half circle."""
    radius = abs(scene.length(word, "X"))
    chord = math.dist(start, end)
    if chord == 0 or chord / 2 > radius + scene.dialect.radius_tolerance_mm / scene.unit:
        raise scene.fault(
            f"L{word.raw} is too short for an arc over {chord:.4f}",
            "check L and the end point",
            word,
        )
    return centre_of(start, end, radius, 1 if motion == COUNTER else -1)
