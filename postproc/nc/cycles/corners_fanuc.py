"""Corners of Fanuc and Haas: `,C` and `,R` behind a straight line, written out as a line or an arc.

Fanuc B-64484EN, "Optional chamfering and corner R", and Haas, mill operator's manual, "Corner
Rounding and Chamfering": `,C` is the distance from the corner at which a chamfer begins and ends,
`,R` the radius of an arc that touches both lines. On lathes both stand without a comma too, and A
is a line's angle (drawing_fanuc.py), where the machine has no axis of that letter. I behind a line
along Z, K behind one along X: a chamfer of 45 degrees to a line across, the way that its sign says
(Fanuc B-63944EN-1, 4.5 "Chamfering and corner R"; Haas, lathe operator's manual, the same). What is
followed and what is refused: corners_siemens.py; A alone, whose end lies on the next line, is
refused here.
"""

from __future__ import annotations

import re
from typing import ClassVar

from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.corners_siemens import CHAMFER, FEED, ROUND, Corners, Held
from postproc.nc.cycles.drawing_fanuc import (
    ACROSS,
    COMMENT,
    WRITE,
    bare,
    elsewhere,
    on_line,
    one_way,
    split,
    without_comma,
)
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line

BARE = re.compile(rb"[CRA][ \t]*[-+]?[0-9.]", re.IGNORECASE)
ONE_WAY = re.compile(rb"[IK][ \t]*[-+]?[0-9.]", re.IGNORECASE)
ARC = re.compile(rb"G[ \t]*0*[23](?![0-9.])", re.IGNORECASE)  # whose I and K are its centre
QUIET = (FEED, 900, 910)


class FanucCorners(Corners):
    """Holds a line back until the next one says which corner it makes."""

    kinds: ClassVar[dict[str, str]] = {
        ",C": CHAMFER,
        ",R": ROUND,
        **dict.fromkeys(("I", "I-", "K", "K-"), CHAMFER),
    }
    sign = ""

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.own: Word | None = None
        self.letters = bare(scene, "CRAIK")

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        if self.held is not None or split(line.text)[1] is not None:
            return True
        if not self.letters:
            return False
        text = COMMENT.sub(b"", line.text)
        return bool(BARE.search(text) or (ONE_WAY.search(text) and not ARC.search(text)))

    def _read(self, line: Line) -> Block:
        """The block without its corner, which is kept, and with both ends of its line."""
        # The comma of ,A says nothing where A is an angle; ,C and ,R go out of the text, since C
        # and R without a comma may be an axis and a radius.
        text = without_comma(line.text) if "A" in self.letters else line.text
        text, found = split(text)
        block = Block.of(text, self.scene.dialect.grammar)
        self.own = None
        if found is not None:
            raw = found[2].decode()
            self.own = self._corner_word(found[1].decode().upper(), float(raw), raw)
        names = self.scene.plane[:2]
        if not self.letters or not any(w.letter in self._ends(names) for w in block.words):
            return block
        if any(c not in QUIET for c in block.codes) or self._motion(block) != FEED:
            return block
        return self._drawn(block, names)

    def _ends(self, names: tuple[str, ...]) -> str:
        return "".join(map(self._own, names))

    def _drawn(self, block: Block, names: tuple[str, ...]) -> Block:
        """A straight feed without the words that only a drawing has. Raises ProgramError."""
        scene = self.scene
        out = own_words(block, self.letters)
        if not out:
            return block
        corners = [block.words[i] for i in out if block.words[i].letter in "CRIK"]
        if len(corners) + (self.own is not None) > 1:
            raise scene.fault("two corners in one block", "keep one", corners[-1])
        for word in corners:
            self.own = self._corner_word(word.letter, word.value or 0.0, word.raw)
            if word.letter in "IK":
                one_way(scene, word, [w.letter for w in block.words])
                sign = "-" * word.raw.startswith("-")
                self.own = self.own._replace(letter=word.letter + sign)
        return Block.of(block.written(out, self._by_angle(block, names)), scene.dialect.grammar)

    def _by_angle(self, block: Block, names: tuple[str, ...]) -> bytes:
        """The word of the coordinate that an angle A stands for, or none. Raises ProgramError."""
        word = block.word("A") if "A" in self.letters else None
        missing = [x for x in names if not any(w.letter in self._own(x) for w in block.words)]
        if word is None or not missing:
            return b""
        # A line that is held back has not left yet: the tracker still stands at its start.
        scene, start = self.scene, self.held.end if self.held else self._here(names)
        end = self._end(block, names, start)
        (axis,) = missing
        place = [None if x == axis else end[k] for k, x in enumerate(names)]
        at = on_line(scene, start, scene.angle(word), place[0], place[1])[names.index(axis)]
        if self._distances(block):
            at -= start[names.index(axis)]
        return scene.text(axis, at * scene.double(axis))

    def _corner_word(self, letter: str, value: float, raw: str) -> Word:
        """The word of a corner, its size as the control counts it."""
        # The sign of I and K is kept beside their letter (`_drawn`): C and R go by their size
        # alone.
        size = self.scene.length(Word(letter, value, raw, 0, 0), "Z")
        return Word(f",{letter}", abs(size) if self.letters else size, raw, 0, 0)

    def _corner(
        self,
        held: Held,
        block: Block,
        names: tuple[str, ...],
        corner: tuple[float, float],
        end: tuple[float, float],
    ) -> tuple[tuple[float, float], Block, list[Line]]:
        #      ^       I+ behind a line along Z ends up along X+, K- behind one along X along Z-.
        #     /  X+    The next line must go just there, or the drawing means another corner.
        #  --'
        if held.word[0] in "IK":
            along = names.index(ACROSS[held.word[0]])
            behind = end[along] - corner[along]
            if end[1 - along] != corner[1 - along] or (behind < 0) != (held.word[1:] == "-"):
                raise elsewhere(self.scene, held.word[0])
        return super()._corner(held, block, names, corner, end)

    def _check(self, block: Block, word: str, moves: bool) -> None:
        names = self.scene.plane[:2]
        by = next(
            (w for w in block.words if self.scene.dialect.increments.get(w.letter) in names), None
        )
        if by is not None:
            raise self.scene.fault(f"{by.letter} at a line with {word}", "write X and Z there", by)
        super()._check(block, word, moves)

    def _own(self, axis: str) -> str:
        """The letters that say where an axis goes."""
        return axis + self.scene.increment(axis)

    def _words(self, block: Block) -> tuple[float | None, Word | None, Block]:
        """Nothing modal, the block's own corner, and the block without it."""
        alone = self.letters and "A" in self.letters and block.get("A") is not None
        if alone and not self.own and not block.codes and len(block.words) == 1:
            raise self.scene.fault("A alone", WRITE)
        return None, self._sized(self.own), block
