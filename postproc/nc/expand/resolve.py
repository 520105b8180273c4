"""The last stage of expansion: canned cycles and turned, scaled or mirrored coordinates become
plain blocks.

Lines come in the order in which the control executes them, with plain numbers. One that has nothing
of all this passes by a single search; the positions that cycles need are asked of the tracker,
which hears every line that leaves. A cycle is written out first, in the coordinates of the program;
then the frame turns its lines.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from postproc.errors import BlockFault, ProgramError
from postproc.motions import Motions
from postproc.nc.codes import FRAME_KEYS, KEYWORD, KEYWORDS, spindle_codes
from postproc.nc.cycles import family
from postproc.nc.cycles.affine import AXES
from postproc.nc.cycles.block import Block, blocks
from postproc.nc.cycles.cycle import UNDEFINED, Cycle
from postproc.nc.cycles.scene import CHORD_MM, Scene
from postproc.nc.cycles.words import form_of
from postproc.nc.expand import Line, Program, fault
from postproc.nc.expand.tracker import Tracker

PLAIN_MOTIONS = (0, 10, 20, 30)
REFERENCES = (280, 300)  # from any place, the ways to it do not lead the path on
# Modal groups whose codes may stand in a cycle's own block; behind others the tracker is asked
# anew.
QUIET = (
    "motion", "cycle", "distance", "feed mode", "return", "plane", "spindle mode", "path",
    "arc centre", "cutter",
)  # fmt: skip
# no motion: a tape mark, a program number
READABLE = re.compile(rb"[ \t\r]*(%.*|:?[0-9]*|[oO][0-9]+[ \t\r]*)")


class Resolver:
    """Writes cycles and frames out. `synchronised`: tapping is written as feeds, which is for tests
    alone. `keeps`: whether a drilling cycle's block can stay, by what it drills (None: never).
    `tolerance`: mm, by which the lines of a spline may leave it."""

    def __init__(
        self,
        program: Program,
        tracker: Tracker,
        synchronised: bool = False,
        keeps: Callable[[Motions], bool] | None = None,
        tolerance: float = CHORD_MM,
    ):
        self.program, self.tracker, self.grammar = program, tracker, tracker.dialect.grammar
        self.scene, self.keeps = Scene(tracker), keeps
        self.scene.tolerance = tolerance
        self.turns = spindle_codes(tracker.dialect.m_codes)
        self.family = family(tracker.dialect, synchronised)
        self.control = self.family.control(self.scene) if self.family.control else None
        self.before_it = self.family.before(self.scene)
        if self.control:
            self.scene.frame = self.control.known
        self.active: Cycle | None = None
        self.code = 0  # of the active cycle
        self.before = 0  # the motion code in force before it
        self.missing: int | None = None  # a motion code that the next block without one relies on
        self.loose = ""  # an axis that the control may have left elsewhere behind a cycle
        self.skip: tuple[str, int, int] | None = None  # file and lines that the control steps over
        self.texts: dict[str, list[bytes]] = {}  # of the files that cycles read further in
        self.line = Line(b"", 0)
        self.scene.fault_at, self.scene.lines = self._fault, self._lines
        table = self.scene.table
        self.shifts = {
            n
            for n, c in table.items()
            if (c.group == "work offset" or c.does in FRAME_KEYS) and n < KEYWORD
        }
        ours = {*self.family.cycles, *(self.control.codes if self.control else ())}
        self.interest = _interest(
            sorted(ours | self.shifts) if ours else [], tracker.dialect.tool_offsets
        )

    def take(self, line: Line) -> list[Line]:
        """The plain lines that stand for this one; [line] itself when nothing in it concerns us.
        Raises ProgramError."""
        #   line -> corners (before_it) -> cycle, in the coordinates of the program -> frame, which
        #   turns words into those beneath -> the tracker hears it -> it leaves
        if self.before_it is None or self._over(line) or not self.before_it.wants(line):
            return self._take(line)
        self.line, self.scene.source = line, line.source
        self.scene.turned = self._turned
        try:
            whole = self.before_it.take(line)
        except BlockFault as error:
            raise self._unread(error) from None
        if self.before_it.rigid:
            self._sized(line)
        return [plain for one in whole for plain in self._take(one)]

    def finish(self) -> list[Line]:
        """The plain lines that are still to come where the program ends."""
        rest = self.before_it.finish() if self.before_it else []
        return [plain for one in rest for plain in self._take(one)]

    def _sized(self, line: Line) -> None:
        """A corner does not keep its size where lengths are scaled. Raises ProgramError."""
        if self.control is not None and self.control.frames.factor() not in (1.0, -1.0):
            self.scene.block = Block.of(line.text, self.grammar)
            raise self.scene.fault(
                f"a rounded or chamfered corner within {self.control.frames.why}",
                "a corner does not keep its size: write it out",
            )

    def _unread(self, error: BlockFault) -> ProgramError:
        """The tracker's interpreter could not read what it was asked about."""
        at = self.tracker.unread or self.line
        return fault(at.file or self.program.name, at.source, at.text, error.message, error.advice)

    def _over(self, line: Line) -> bool:
        """Whether the control steps over a line."""
        if self.skip is None:
            return False
        file, first, last = self.skip
        return line.file == file and first <= line.source <= last

    # Whole: the hot loop: what concerns no cycle passes first.
    def _take(self, line: Line) -> list[Line]:
        """A line without corners."""
        if self.skip is not None:
            if self._over(line):
                return []
            file, _, last = self.skip
            if line.file != file or line.source > last:
                self.skip = None
        # Nearly every line: no cycle is active, nothing is owed to the next block, and it has no
        # code of ours. All other lines are cut into blocks and words.
        idle = not (
            self.active
            or self.missing is not None
            or self.scene.unsure
            or self._turned
            or self.loose
        )
        if idle and not self.interest.search(line.text):
            self.tracker.take(line.text, line)
            self.scene.forget()
            return [line]
        self.line, self.scene.source = line, line.source
        try:
            texts = [
                text for block in blocks(line.text, self.grammar) for text in self._block(block)
            ]
        except BlockFault as error:
            raise self._unread(error) from None
        return [line] if texts == [line.text] else [line._replace(text=text) for text in texts]

    @property
    def _turned(self) -> bool:
        return self.control is not None and self.control.active

    # -- one block ---------------------------------------------------------------------------------

    def _block(self, text: bytes) -> list[bytes]:
        block = Block.of(text, self.grammar)
        scene = self.scene
        scene.block = block
        if block.skip and self.tracker.setup.block_delete:
            return self._tell([text], True)
        if not block.plain:
            if (self.active or self._turned) and not READABLE.fullmatch(text):
                raise self.scene.fault(
                    "within a cycle or a frame, and this block is more than words and numbers",
                    "it could move an axis: write it as plain words",
                )
            return self._tell([text], True)
        self._spindle(block)
        return self._plain(block, block.codes)

    def _plain(self, block: Block, codes: list[int]) -> list[bytes]:
        """A block of words and numbers: a cycle's, or one that passes."""
        scene = self.scene
        own = [code for code in codes if code in self.family.cycles]
        if own and not self._overridden(codes, own[-1]):
            return self._cycle(block, own[-1], codes)
        if self.active is not None:
            if self._ends(codes):
                self._end(codes)
            elif not self._taken(codes) and self.active.wants(scene, block):
                return self._cycle(block, self.code, codes)
            elif not codes:
                self._idle(block)
        return self._passed_on(block, codes)

    def _passed_on(self, block: Block, codes: list[int]) -> list[bytes]:
        """A block of no cycle, with the motion code that a cycle before it has replaced."""
        scene = self.scene
        if self.loose:
            self._counted(block, codes)
        if self.scene.unsure and not self._taken(codes):
            scene.note(block)
            scene.named({w.letter for w in block.words})
        if self.missing is not None:
            block = self._completed(block, codes)
        lead: list[bytes] = []
        offset = scene.own_codes(block, "work offset") and not self._taken(codes)
        if offset and self._turned and any(w.letter in AXES for w in block.words):
            # where the axes stand in the new coordinates, only the tracker knows
            lead, block = self._apart(block)
            scene.block = block
        return lead + self._out([block.text], self._loud(block, codes))

    def _counted(self, block: Block, codes: list[int]) -> None:
        """Nothing may count from where a cycle may have left an axis, but to a reference point by
        no way at all (G28 U0 W0), which begins wherever it stands. Raises ProgramError."""
        by = next(
            (w for w in block.words if self.tracker.dialect.increments.get(w.letter) == self.loose),
            None,
        )
        if by is not None and not (by.value == 0 and any(c in REFERENCES for c in codes)):
            raise self.scene.fault(
                f"{by.letter}{by.raw} counts from where the cycle left {self.loose}, and that is"
                " not certain",
                f"write {self.loose} as a place",
                by,
            )
        if by is not None or block.word(self.loose) is not None:
            self.loose = ""

    def _overridden(self, codes: list[int], own: int) -> bool:
        """Fanuc: of a cycle and another motion code in one block, the last one holds."""
        # those behind the last `own` of the block
        later = codes[len(codes) - codes[::-1].index(own) :]
        return self.family.restores and any(c in PLAIN_MOTIONS for c in later)

    def _taken(self, codes: list[int]) -> bool:
        """Whether another code takes the axis words (G10 G28 G68 G92), or changes what they mean
        (G53)."""
        takers = self.control.takers if self.control else ()
        return any(c == 530 or c in takers or self._takes(c) for c in codes)

    def _takes(self, code: int) -> bool:
        return code in self.scene.table and self.scene.table[code].takes

    def _idle(self, block: Block) -> None:
        """A block in a cycle that runs nothing must hold none of the cycle's words. Raises
        ProgramError."""
        assert self.active is not None
        own = form_of(self.active.forms(self.code), block)
        letters = {
            *own.takes,
            *own.keeps,
            *self.tracker.setup.axes,
            *self.tracker.dialect.increments,
        }
        word = next((w for w in block.words if w.letter in letters), None)
        if word is not None and not own.stays and not any(w.letter == "M" for w in block.words):
            raise self.scene.fault(
                f"{word.letter} in a block within G{self.code / 10:g} that runs it not",
                "controls differ on what holds then: write it beside a place, or behind G80", word,
            )  # fmt: skip

    def _ends(self, codes: list[int]) -> bool:
        return any(
            c == 800 or c in PLAIN_MOTIONS or self.scene.group_of(c) == "motion" for c in codes
        )

    def _end(self, codes: list[int]) -> None:
        """G80 or another motion code: the cycle is over."""
        assert self.active is not None
        self.active.end()
        self.active = None
        if self.family.until_g80 and 800 not in codes:
            raise self.scene.fault(
                "a motion code within a cycle",
                "this control goes on with the cycle there: write G80 before it",
            )
        if not any(self.scene.group_of(c) == "motion" and c != 800 for c in codes):
            if self.family.restores:
                self.missing = self.before
            elif self.family.forgets:
                self.missing = UNDEFINED

    def _completed(self, block: Block, codes: list[int]) -> Block:
        """Fanuc: with the motion code in force before the cycle, where the block relies on it."""
        if any(self.scene.group_of(c) == "motion" and c != 800 for c in codes):
            self.missing = None
            return block
        axes = (*self.tracker.setup.axes, *self.tracker.dialect.increments, *"IJK")
        if not any(w.letter in axes for w in block.words) or self._taken(codes) or 40 in codes:
            return block
        if self._stands(block):
            return block
        code, self.missing = self.missing, None
        if code == UNDEFINED:
            raise self.scene.fault(
                "no motion code is named behind the cycle",
                "which one holds there differs: name G0 or G1",
            )
        if code not in PLAIN_MOTIONS:
            return block
        at = next((i for i, w in enumerate(block.words) if w.letter not in "NG"), len(block.words))
        return Block.of(block.written(set(), f"G{code // 10}".encode(), at), self.grammar)

    def _stands(self, block: Block) -> bool:
        """Whether its axis words are distances of 0 (W0): no motion, whatever the motion code."""
        increments, axes = self.tracker.dialect.increments, self.tracker.setup.axes
        words = [w for w in block.words if w.letter in (*axes, *increments, *"IJKR")]
        return all(w.letter in increments and w.value == 0 for w in words)

    # -- a block of a cycle ------------------------------------------------------------------------

    # Whole: the order of one cycle: before, words, run, what holds behind it.
    def _cycle(self, block: Block, code: int, codes: list[int]) -> list[bytes]:
        """The plain lines of a block of a cycle, and what holds behind it."""
        scene, cycle = self.scene, self.family.cycles[code]
        self._check_alone(code, [c for c in codes if c != code])
        if self.active is None:
            self.before = scene.code("motion") if self.missing is None else self.missing
        elif self.active is not cycle:
            self.active.end()
        self.missing = None
        lead: list[bytes] = []
        # G54, G20, T0101: they hold first, and the tracker says what they do
        if self._loud(block, codes):
            lead, block = self._apart(block)
        scene.note(block)
        scene.block = block
        turned = self.control is not None and not self.control.frames.map.identity
        # the frame rounds anew what it makes of the cycle's words: up to there they have more
        # decimals
        scene.extra_decimals = 4 if turned else 0
        scene.keeps, scene.turned = None if self._turned else self.keeps, self._turned
        form_of(cycle.forms(code), block).check(scene, block, code)
        outcome = cycle.run(scene, block, code)
        scene.extra_decimals = 0
        scene.lose_code("motion")
        if cycle.modal:
            self.active, self.code = cycle, code
        else:
            self.active = None
            if self.family.restores or outcome.then is not None:
                self.missing = self.before if outcome.then is None else outcome.then
        self.loose = outcome.loose
        if outcome.skip:
            self.skip = (self.line.file, *outcome.skip)
        if outcome.stays:
            scene.settle()
            return lead + self._tell(outcome.lines, False)
        if outcome.heard is None:
            return lead + self._out(outcome.lines, False, places=True)
        return lead + self._tapping(outcome.lines, outcome.heard)

    def _check_alone(self, code: int, others: list[int]) -> None:
        also = [c for c in others if self._taken([c])]
        also += [c for c in others if c in self.family.cycles]
        if also:
            raise self.scene.fault(
                f"G{also[0] / 10:g} and G{code / 10:g} in one block",
                "write each in a block of its own",
            )

    def _tapping(self, lines: list[bytes], heard: list[bytes]) -> list[bytes]:
        """A cycle that stays in the program, while the tracker reads what it does."""
        if self.control is None or not self.control.active:
            self._tell(heard, False)
            return lines
        if not self.control.frames.map.leaves(self.scene.plane[2]):
            raise self.scene.fault(
                f"tapping within {self.control.frames.why}", "write the holes in plain coordinates"
            )
        # the text that stays and the lines that are heard are the same motions: the frame takes
        # them once
        kept = self.control.snapshot()
        texts = [self.control.take(Block.of(text, self.grammar)) for text in lines]
        self.control.restore(kept)
        self._out(heard, False, places=True)
        return [text for part in texts for text in part]

    def _loud(self, block: Block, codes: list[int]) -> bool:
        """Whether a block changes more than modes that are known here."""
        table = self.scene.table
        return (
            any(
                c >= KEYWORD
                or c not in table
                or (table[c].group not in QUIET and c not in (40, 90))
                for c in codes
                if c not in self.family.cycles
            )
            or (self.tracker.dialect.tool_offsets and block.get("T") is not None)
        ) and not (self.control is not None and all(c in self.control.codes for c in codes))

    def _apart(self, block: Block) -> tuple[list[bytes], Block]:
        """The codes that change the coordinates in a line of their own, and the block without
        them."""
        scene = self.scene
        first = {
            i
            for i, w in enumerate(block.words)
            if (
                w.letter == "G"
                and scene.group_of(round((w.value or 0) * 10)) not in QUIET
                and not self._ours(w.value)
            )
            or w.letter in "NTHD"
            or (w.letter == "P" and 541 in block.codes)
        }
        words = [block.text[w.start : w.stop] for i, w in enumerate(block.words) if i in first]
        lead = (b"/" if block.skip else b"") + (b" " if block.spaced else b"").join(words)
        return self._out([lead], True), Block.of(block.written(first), self.grammar)

    def _ours(self, value: float | None) -> bool:
        code = round((value or 0.0) * 10)
        return code in self.family.cycles or (
            self.control is not None and code in self.control.codes
        )

    # -- what leaves -------------------------------------------------------------------------------

    def _out(self, texts: list[bytes], loud: bool, places: bool = False) -> list[bytes]:
        """Lines in the coordinates of the program, in those beneath. `loud`: the tracker must be
        asked anew behind them; `places`: the scene has been told where the axes stand."""
        control, lines = self.control, []
        for text in texts:
            block = Block.of(text, self.grammar)
            if not places:
                self.scene.note(block)
            framed = control is not None and (
                control.active or any(c in control.codes for c in block.codes) or _polar(block)
            )
            lines += self._tell(control.take(block) if control and framed else [text], False)
        if loud:
            self.scene.forget()
            if control is not None:
                control.frames.forget()
            self._shifted(texts)
        elif not places:
            self.scene.settle()
        return lines

    def _shifted(self, texts: list[bytes]) -> None:
        """Tell the scene of shifts that came into force."""
        for block in (Block.of(text, self.grammar) for text in texts):
            tool = self.tracker.dialect.tool_offsets and block.get("T") is not None
            if tool or any(c in self.shifts for c in block.codes):
                taken = any(self._takes(c) for c in block.codes)
                self.scene.shifted(set() if taken else {w.letter for w in block.words})

    def _tell(self, texts: list[bytes], loud: bool) -> list[bytes]:
        for text in texts:
            self.tracker.take(text, self.line._replace(text=text))
        if loud:
            self.scene.forget()
        return texts

    def _spindle(self, block: Block) -> None:
        for m in block.m_codes():
            self.scene.spindle = self.turns.get(m, self.scene.spindle)

    def _lines(self) -> list[bytes]:
        """The source text that the line at hand stands in."""
        name = self.line.file
        if name not in self.texts:
            text = self.program.text if not name else self.program.library(name) or b""
            self.texts[name] = Program(name, text).lines()
        return self.texts[name]

    def _fault(self, message: str, advice: str, mark: bytes = b"") -> ProgramError:
        start = self.line.text.find(mark) if mark else -1
        start, stop = (start, start + len(mark)) if start >= 0 else (0, 0)
        name = self.line.file or self.program.name
        return fault(name, self.line.source, self.line.text, message, advice, start, stop)


def _polar(block: Block) -> bool:
    """Whether a block has polar words of their own (Sinumerik)."""
    return any(w.letter in ("AP", "RP") for w in block.words)


def _interest(numbers: list[int], tools: bool) -> re.Pattern[bytes]:
    """Finds, in a line, a code of ours or of a shift, a spindle code (G86 must know how it turned),
    a tool's offset."""
    codes = []
    names = [
        rf"(?<![A-Za-z_]){KEYWORDS[n - KEYWORD]}(?![A-Za-z0-9_])" for n in numbers if n >= KEYWORD
    ]
    names += [r"[AR]P[ \t]*="] if names else []
    for number in (n for n in numbers if n < KEYWORD):
        whole, tenth = divmod(number, 10)
        point = rf"\.0*{tenth}0*" if tenth else r"(?:\.0*)?"
        codes.append(r"[ \t]*".join(str(whole)) + point)
    if not codes:
        return re.compile(rb"(?!)")
    found = (
        rf"G[ \t]*0*[ \t]*(?:{'|'.join(codes)})(?![ \t]*[0-9.])"
        r"|M[ \t]*0*[ \t]*(?:[345]|1[ \t]*[34])(?![ \t]*[0-9])"
    )
    found = "|".join([found, *names, *([r"T[ \t]*[0-9]"] if tools else [])])
    return re.compile(found.encode(), re.IGNORECASE)
