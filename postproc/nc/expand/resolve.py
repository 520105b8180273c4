"""The last stage of expansion: canned cycles and turned, scaled or mirrored coordinates become plain blocks.

Lines come in the order in which the control executes them, with plain numbers. One that has nothing of all this passes by
a single search; the positions that cycles need are asked of the tracker, which hears every line that leaves.
"""

from __future__ import annotations

import re

from postproc.errors import BlockFault, ProgramError
from postproc.nc.codes import KEYWORD
from postproc.nc.cycles import Cycle, family
from postproc.nc.cycles.block import Block, blocks
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line, Program, fault
from postproc.nc.expand.tracker import Tracker

PLAIN_MOTIONS = (0, 10, 20, 30)
# Modal groups whose codes may stand in a cycle's own block; behind others the tracker is asked anew.
QUIET = ("motion", "cycle", "distance", "feed mode", "return", "plane", "spindle mode", "path", "arc centre", "")


class Resolver:
    """Writes cycles and frames out. `synchronised`: tapping is written as feeds, which is for tests alone."""

    def __init__(self, program: Program, tracker: Tracker, synchronised: bool = False):
        self.program, self.tracker = program, tracker
        self.scene = Scene(tracker)
        self.family = family(tracker.dialect, synchronised)
        self.active: Cycle | None = None
        self.code = 0  # of the active cycle
        self.before = 0  # the motion code in force before it
        self.restore: int | None = None  # a motion code that the next block without one needs
        self.line = Line(b"", 0)
        self.heard: list[Line] = []  # what the tracker was told since it was last asked
        self.scene.asked = self.heard.clear
        self.interest = _interest(self.family.cycles)

    def take(self, line: Line) -> list[Line]:
        """The plain lines that stand for this one; [line] itself when nothing in it concerns us. Raises ProgramError."""
        if self.active is None and self.restore is None and not self.interest.search(line.text):
            self.heard.append(line)
            self.tracker.take(line.text)
            self.scene.forget()
            return [line]
        self.line = line
        try:
            texts = [text for block in blocks(line.text, self.tracker.dialect.grammar) for text in self._block(block)]
        except BlockFault as error:  # the tracker's interpreter could not read what it was asked about
            at = self.heard[min(error.block, len(self.heard) - 1)] if self.heard else line
            raise fault(self.program.name, at.source, at.text, error.message, error.advice) from None
        if texts == [line.text]:
            return [line]
        return [line._replace(text=text) for text in texts]

    # -- one block -----------------------------------------------------------------------------------------------------

    def _block(self, text: bytes) -> list[bytes]:
        block = Block.of(text, self.tracker.dialect.grammar)
        scene = self.scene
        if not block.plain or (block.skip and self.tracker.setup.block_delete):
            return self._pass(text)
        codes = block.codes
        self._spindle(block)
        scene.block, scene.fault_at = block, self._fault
        own = [code for code in codes if code in self.family.cycles]
        if own and not self._overridden(codes, own[-1]):
            return self._cycle(block, own[-1], codes)
        if self.active is not None and self._ends(codes):
            self._end(codes)
        elif self.active is not None and not self._taken(codes) and self.active.wants(scene, block):
            return self._cycle(block, self.code, codes)
        if self.restore is not None:
            return self._restored(block, codes)
        return self._pass(text)

    def _overridden(self, codes: list[int], own: int) -> bool:
        """Fanuc: of a cycle and another motion code in one block, the last one holds."""
        later = codes[len(codes) - codes[::-1].index(own) :]
        return self.family.restores and any(c in PLAIN_MOTIONS for c in later)

    def _taken(self, codes: list[int]) -> bool:
        """Whether another code takes the axis words (G10 G28 G92), or changes what they mean (G53)."""
        return any(c == 530 or (c in self.scene.table and self.scene.table[c].takes) for c in codes)

    def _ends(self, codes: list[int]) -> bool:
        return any(c == 800 or c in PLAIN_MOTIONS or self.scene.group_of(c) == "motion" for c in codes)

    def _end(self, codes: list[int]) -> None:
        """G80 or another motion code: the cycle is over."""
        assert self.active is not None
        self.active.end()
        self.active = None
        if self.family.restores and not any(self.scene.group_of(c) == "motion" and c != 800 for c in codes):
            self.restore = self.before

    def _cycle(self, block: Block, code: int, codes: list[int]) -> list[bytes]:
        scene, cycle = self.scene, self.family.cycles[code]
        if self.active is None:
            self.before = scene.code("motion")
        elif self.active is not cycle:
            self.active.end()
        self.restore = None
        loud = any(scene.group_of(c) not in QUIET or c >= KEYWORD for c in codes) or (
            self.tracker.dialect.tool_offsets and block.get("T") is not None
        )
        lead: list[bytes] = []
        if loud:  # G54, G20, T0101: they hold first, and the tracker says what they do
            lead, block = self._apart(block, code)
        scene.note(block)
        scene.block = block
        outcome = cycle.run(scene, block, code)
        if cycle.modal:
            self.active, self.code = cycle, code
        for text in outcome.told if outcome.told is not None else outcome.lines:
            self._told(text)
        return lead + outcome.lines

    def _apart(self, block: Block, code: int) -> tuple[list[bytes], Block]:
        """The codes that change the coordinates in a line of their own, and the block without them."""
        scene = self.scene
        first = {
            i
            for i, w in enumerate(block.words)
            if (w.letter == "G" and scene.group_of(round((w.value or 0) * 10)) not in QUIET)
            or w.letter in "NTHD"
            or (w.letter == "P" and 541 in block.codes)
        }
        grammar = self.tracker.dialect.grammar
        words = [block.text[w.start : w.stop] for i, w in enumerate(block.words) if i in first]
        lead = (b"/" if block.skip else b"") + (b" " if block.spaced else b"").join(words)
        rest = Block.of(block.written(first), grammar)
        self._told(lead)
        scene.forget()
        return [lead], rest

    def _restored(self, block: Block, codes: list[int]) -> list[bytes]:
        """The motion code in force before the cycle, where a block relies on it."""
        moves = any(w.letter in (*self.tracker.setup.axes, *self.tracker.dialect.increments) for w in block.words)
        if any(self.scene.group_of(c) == "motion" for c in codes if c != 800):
            self.restore = None
            return self._pass(block.text)
        if not moves or any(self.scene.group_of(c) == "" for c in codes):
            return self._pass(block.text)
        code, self.restore = self.restore, None
        if code not in PLAIN_MOTIONS:
            return self._pass(block.text)
        at = next((i for i, w in enumerate(block.words) if w.letter not in "NG"), len(block.words))
        return self._pass(block.written(set(), f"G{code // 10}".encode(), at))

    def _pass(self, text: bytes) -> list[bytes]:
        self._told(text)
        self.scene.forget()
        return [text]

    def _told(self, text: bytes) -> None:
        self.heard.append(self.line._replace(text=text))
        self.tracker.take(text)

    def _spindle(self, block: Block) -> None:
        for m in block.m_codes():
            if m in (3, 4, 5):
                self.scene.spindle = m

    def _fault(self, message: str, advice: str, start: int = 0, stop: int = 0) -> ProgramError:
        return fault(self.program.name, self.line.source, self.line.text, message, advice, start, stop)


def _interest(cycles: dict[int, Cycle]) -> re.Pattern[bytes]:
    """Finds, in a line, a code of ours or a spindle code (G86 must know how it turned)."""
    codes = []
    for number in cycles:
        whole, tenth = divmod(number, 10)
        point = rf"\.0*{tenth}0*" if tenth else r"(?:\.0*)?"
        codes.append(r"[ \t]*".join(str(whole)) + point)
    if not codes:
        return re.compile(rb"(?!)")
    found = rf"[Gg][ \t]*0*[ \t]*(?:{'|'.join(codes)})(?![ \t]*[0-9.])|[Mm][ \t]*0*[ \t]*[345](?![ \t]*[0-9])"
    return re.compile(found.encode())
