"""RND=, CHF=, CHR= and RNDM= of Sinumerik: the corner behind a straight line, written out as an arc
or a line.

Siemens, SINUMERIK NC Programming Manual, "Chamfer, rounding (CHF, CHR, RND, RNDM, FRC, FRCM)": RND
is the radius of an arc that touches both lines, RNDM the same for all corners until RNDM=0; CHR is
how far a chamfer begins before the corner, CHF how long it is, and it stands alike on both. ANG is
the angle of a line of which one end is not said ("Contour definition programming: one straight
line"). The corner lies in the plane in force, behind the block that names it.

Followed between two straight feeds in the plane. Refused: corners at arcs and rapids, beside polar
words, with a feed of their own (FRC), longer than their lines. None is made at the end of the
program or where both lines go on straight.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import ClassVar

from postproc.nc.cycles.before import Before
from postproc.nc.cycles.bend import NEAR, bent
from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.drawing_fanuc import on_line
from postproc.nc.cycles.frames import CORNERS
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import CENTRES, Scene
from postproc.nc.expand import Line
from postproc.nc.expand.tracker import number

FOUND = re.compile(rb"(?<![A-Za-z0-9_$])(?:RNDM?|CHF|CHR|ANG)[ \t]*=", re.IGNORECASE)
FEED = 10
ENDS = (2, 17, 30)
IDLE = "NMFSTHD"  # letters of blocks between the lines of a corner
WRITE = "write the corner out"
ROUND, CHAMFER, LENGTH = "radius", "way to the corner", "length of the chamfer"


@dataclass
class Held:
    """A straight line whose end waits for the next one. `start` and `end`: along the plane's two
    axes, X as a radius;
    `word`: what makes the corner, its `size`; `between`: lines that only
    switch something; `modal`: whether RNDM says it."""

    line: Line
    block: Block
    start: tuple[float, float]
    end: tuple[float, float]
    word: str
    size: float
    between: list[Line]
    modal: bool


class Corners(Before):
    """Holds a line back until the next one says which corner it makes. `kinds`: what each word of a
    corner is; `sign`: what stands between it and its size."""

    # Its size is written into the lines as it stands, and a frame behind would scale it with them:
    # the resolver refuses that.
    rigid = True
    kinds: ClassVar[dict[str, str]] = {"RND": ROUND, "CHR": CHAMFER, "CHF": LENGTH}
    sign = "="

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.held: Held | None = None
        self.modal = 0.0  # of RNDM

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        if self.held is not None or self.modal > 0:
            return True
        return b"=" in line.text and bool(FOUND.search(line.text))

    def finish(self) -> list[Line]:
        """What is still held when the program ends: no corner is made behind it."""
        held, self.held = self.held, None
        return [] if held is None else [held.line, *held.between]

    # Whole: the kinds of lines in their order of precedence.
    def take(self, line: Line) -> list[Line]:
        """Lines that can be followed now, without the words of corners. Raises ProgramError."""
        scene = self.scene
        if scene.passes(line.text):
            if self.held is None:
                return [line]
            self.held.between.append(line)
            return []
        scene.block = block = self._read(line)
        if not block.plain:
            if self.held is not None:
                raise scene.fault("a corner, and then more than words and numbers", WRITE)
            return [line]
        #   G1 X50 RND=5    held
        #   M8              between: it waits too, or it would come before the line it stands behind
        #   G1 Y40          all three are known
        if self.held is not None and self._switches(block):
            if any(m in ENDS for m in block.m_codes()):
                return [*self.finish(), line]
            self.held.between.append(line)
            return []
        rndm, own, plain = self._words(block)
        if self.held is not None and own is None and self._switches(plain):  # RNDM alone
            if self.held.modal:
                raise scene.fault(
                    "RNDM changes behind a line that it rounds",
                    "write it into the block of that line",
                )
            self.modal = rndm or 0.0
            self.held.between += _unless_empty(line, plain)
            return []
        # RNDM of this block rounds its own end, not the corner before it, which `held` knows
        # already.
        modal, self.modal = self.modal, self.modal if rndm is None else rndm
        if self.held is None and own is None and not (modal or self.modal):
            return _unless_empty(line, plain)
        return self._line(line, plain, own)

    def _read(self, line: Line) -> Block:
        """The block of a line, with both ends of a line that its angle says."""
        block = Block.of(line.text, self.scene.dialect.grammar)
        return block if block.get("ANG") is None else self._angled(block)

    def _angled(self, block: Block) -> Block:
        """ANG: the angle of a straight line with the first axis of the plane, one of whose ends is
        not said."""
        scene, names = self.scene, self.scene.plane[:2]
        word = block.word("ANG")
        missing = [x for x in names if block.word(x) is None]
        if len(missing) != 1 or self._motion(block) not in (0, FEED):
            raise scene.fault(
                "ANG elsewhere than at a straight line with one of the plane's axes",
                f"write {names[0]} and {names[1]} of its end",
                word,
            )
        start = self.held.end if self.held else self._here(names)
        end, (axis,) = self._end(block, names, start), missing
        place = [None if x == axis else end[k] for k, x in enumerate(names)]
        k = names.index(axis)
        at = on_line(scene, start, block.get("ANG") or 0.0, place[0], place[1])[k]
        new = scene.text(axis, (at - start[k] * self._distances(block)) * scene.double(axis))
        out = own_words(block, ("ANG",))
        return Block.of(block.written(out, new), scene.dialect.grammar)

    def _switches(self, block: Block) -> bool:
        return all(w.letter in IDLE for w in block.words)

    def _words(self, block: Block) -> tuple[float | None, Word | None, Block]:
        """The value of RNDM, the word of this block's own corner, and the block without them."""
        scene = self.scene
        strange = next((w for w in block.words if w.letter in ("FRC", "FRCM", "ANG")), None)
        if strange:
            raise scene.fault(
                f"{strange.letter} beside corners",
                "it is not followed: write the corner out",
                strange,
            )
        found = [w for w in block.words if w.letter in CORNERS and w.letter != "RNDM"]
        if len(found) > 1:
            raise scene.fault(
                f"{found[0].letter} and {found[1].letter} in one block", "keep one", found[1]
            )
        out = own_words(block, CORNERS)
        rndm = block.get("RNDM")
        plain = Block.of(block.written(out), scene.dialect.grammar) if out else block
        return rndm, self._sized(found[0] if found else None), plain

    def _sized(self, word: Word | None) -> Word | None:
        """The word of a corner, if its size is above 0. Raises ProgramError."""
        if word is not None and (word.value or 0.0) <= 0:
            raise self.scene.fault(
                f"{word.letter}{self.sign}{word.raw}", "a corner has a size above 0", word
            )
        return word

    # -- lines -------------------------------------------------------------------------------------

    def _line(self, line: Line, block: Block, own: Word | None) -> list[Line]:
        """A block that moves, or means to: the end of a corner, and perhaps the beginning of the
        next one."""
        scene, held = self.scene, self.held
        names = scene.plane[:2]
        moves = any(w.letter in names for w in block.words)
        if held is None and own is None and not (moves and self._motion(block) == FEED):
            return [line._replace(text=block.text)]  # under RNDM: nothing that could be rounded
        named = own.letter if own else held.word if held else "RNDM"
        self._check(block, named, moves)
        start = held.end if held else self._here(names)
        end = self._end(block, names, start)
        lines: list[Line] = []
        if held is not None:
            start, block, lines = self._corner(held, block, names, start, end)
        self.held = None
        size = (own.value or 0.0) if own else self.modal
        if not size:
            return [*lines, line._replace(text=block.text)]
        word = own.letter if own else "RND"
        self.held = Held(
            line._replace(text=block.text), block, start, end, word, size, [], own is None
        )
        return lines

    def _motion(self, block: Block) -> int:
        scene = self.scene
        own = scene.own_codes(block, "motion")
        # A line that is held is a G1 which the scene has not heard of yet; so are its G90 and G91
        # below.
        return own[-1] if own else FEED if self.held else scene.code("motion")

    def _check(self, block: Block, word: str, moves: bool) -> None:
        scene = self.scene
        if any(w.letter in ("AP", "RP") for w in block.words):
            raise scene.fault(f"{word} beside polar words", WRITE)
        if self._motion(block) != FEED or not moves:
            raise scene.fault(
                (
                    f"{word} between this block and another one that is no straight feed (G1) in"
                    " the plane"
                    if not moves
                    else f"{word} at a motion that is no straight feed (G1)"
                ),
                WRITE,
            )
        if any(w.letter in "ABCUVW" or w.letter == scene.plane[2] for w in block.words):
            raise scene.fault(f"{word} at a line that leaves the plane", WRITE)
        known = (900, 910, FEED)
        strange = next((c for c in block.codes if c not in known), None)
        if strange is not None:
            name = scene.table[strange].word if strange in scene.table else f"G{strange / 10:g}"
            raise scene.fault(
                f"{name} at a line with {word}", "write it in a block before the corner"
            )
        if scene.diameter_in_g90:
            raise scene.fault(f"{word} under DIAM90", "write DIAMON or DIAMOF")

    def _here(self, names: tuple[str, ...]) -> tuple[float, float]:
        a, b = (self.scene.at(x) / self.scene.double(x) for x in names)
        return a, b

    def _distances(self, block: Block) -> bool:
        """Whether plain words of a block are distances."""
        own = next((c for c in reversed(block.codes) if c in (900, 910)), None)
        return own == 910 if own is not None else self._incremental

    def _relative(self, block: Block, word: Word) -> bool:
        return word.mode == "IC" or (self._distances(block) and word.mode != "AC")

    @property
    def _incremental(self) -> bool:
        codes = [c for c in self.held.block.codes if c in (900, 910)] if self.held else []
        return codes[-1] == 910 if codes else self.scene.incremental

    def _end(
        self, block: Block, names: tuple[str, ...], start: tuple[float, float]
    ) -> tuple[float, float]:
        by = self._distances(block)
        x, y = (self.scene.goes(block.word(a), a, s, by) for a, s in zip(names, start, strict=True))
        return x, y

    def _moved(
        self,
        block: Block,
        names: tuple[str, ...],
        start: tuple[float, float],
        end: tuple[float, float],
        head: bytes = b"",
    ) -> Block:
        """The block with other ends: from `start` to `end`."""
        scene, changed = self.scene, {}
        for i, word in enumerate(block.words):
            if word.letter not in names:
                continue
            k = names.index(word.letter)
            value = (
                end[k] - start[k] if self._relative(block, word) else end[k]
            ) * self.scene.double(word.letter)
            text = number(scene.rounded(word.letter, value), scene.decimals(word.letter)).encode()
            written = block.text[word.start : word.stop]
            # IC( ) and AC( ) stay as the program has them, with another number.
            if word.mode:
                changed[i] = b"%s=%s(%s)" % (word.letter.encode(), word.mode.encode(), text)
            else:
                changed[i] = word.letter.encode() + (b"=" if b"=" in written else b"") + text
        if head:
            first = min(changed)
            changed[first] = head + b" " + changed[first]
        return Block.of(block.written(set(), changed=changed), scene.dialect.grammar)

    # -- the corner --------------------------------------------------------------------------------

    def _corner(
        self,
        held: Held,
        block: Block,
        names: tuple[str, ...],
        corner: tuple[float, float],
        end: tuple[float, float],
    ) -> tuple[tuple[float, float], Block, list[Line]]:
        """Where the next line begins then, its block, and the lines up to there."""
        scene = self.scene
        bend = bent(held.start, corner, end)
        if bend.length < NEAR:
            raise scene.fault(f"{held.word} at a line without length", WRITE)
        if bend.straight:
            return corner, block, [held.line, *held.between]
        if bend.back:
            raise scene.fault(f"{held.word} where the line runs back", WRITE)
        #   held     away
        #   --------o---+ corner    RND   an arc of radius R:       away = R / tan(angle / 2)
        #            \ /            CHR   a chamfer begins there:   away = CHR
        #             o             CHF   it has this length:       CHF = 2 away sin(angle / 2)
        #            /
        away = {
            ROUND: bend.away(held.size), CHAMFER: held.size,
            LENGTH: held.size / 2 / math.sin(bend.angle / 2),
        }[self.kinds[held.word]]  # fmt: skip
        if away > bend.length + NEAR:
            raise scene.fault(
                f"{held.word}{self.sign}{held.size:g} begins {away:.4g} before the corner, and a"
                f" line there has {bend.length:.4g}",
                "the control makes it smaller then: write the corner out",
            )
        first, second = bend.ends(away)
        line = self._moved(held.block, names, held.start, first)
        incremental = self._incremental
        words = []
        for k, axis in enumerate(names):
            value = (second[k] - first[k] if incremental else second[k]) * self.scene.double(axis)
            words.append(scene.text(axis, value))
        code = b"G1"
        if self.kinds[held.word] == ROUND:
            code = b"G3" if bend.left else b"G2"
            middle = bend.centre(held.size)
            words += [scene.text(CENTRES[x], middle[k] - first[k]) for k, x in enumerate(names)]
        skip = b"/" if held.block.skip else b""
        own = any(c == FEED for c in block.codes)
        # Behind G2 or G3 the next line has to name G1, which it may have left out.
        block = self._moved(block, names, second, end, b"" if own or code == b"G1" else b"G1")
        made = held.line._replace(text=skip + b" ".join([code, *words]))
        return second, block, [held.line._replace(text=line.text), made, *held.between]


def _unless_empty(line: Line, block: Block) -> list[Line]:
    return [line._replace(text=block.text)] if block.text.strip(b" \t\r/") else []
