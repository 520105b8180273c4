"""Fanuc and Haas programs, written out: custom macro B, subprograms, macro calls.

Runs M98, M97 (Haas), M198, M99, G65, G66, G67, GOTO, IF, WHILE DO END and assignments; what is left
are plain blocks with numbers in the place of expressions. Programs are found by their O number in
the same text, then through the library.

Left out of what is given: lines for a printer (POPEN DPRNT BPRNT PCLOS) and SETVN, which move
nothing. #3006 leaves its comment; #3000 ends with its text as the reason. Not run: G66.1, codes
that parameters turn into macro calls, names of variables. Floats are compared as Series 30i does
it; a control with shorter numbers may run a loop once more or less that counts in fractions. Calls
are nested as deep as the limits say; the control itself allows 4 macros and 10 subprograms.

Sources: B-64304EN (0i) and B-64484EN (30i), "Custom macro", "Subprogram (M98, M99)"; order of
nested modal calls: "Modal call (G66)", sample program; Haas 96-8000 and 96-8210, "Macros", "M97".
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from postproc.errors import BlockFault
from postproc.nc.expand import Limits, Line, Program, Refusal
from postproc.nc.expand.fanuc_blocks import Block, BlockReader, Kind
from postproc.nc.expand.fanuc_calls import (
    Frame,
    Library,
    Modal,
    arguments,
    called,
    label_of,
    subprogram,
    text_of,
    times,
    word_of,
)
from postproc.nc.expand.fanuc_functions import Unknown, Value, index
from postproc.nc.expand.fanuc_names import numbered
from postproc.nc.expand.fanuc_programs import Section, Source
from postproc.nc.expand.fanuc_rounds import Rounds
from postproc.nc.expand.fanuc_variables import Variables
from postproc.nc.expand.fanuc_words import Word, rendered
from postproc.nc.expand.tracker import Tracker

DELETED = re.compile(rb"[ \t]*(?:[Nn][ \t0-9]*)?/")
VARIABLE, AGAIN = re.compile(rb"#"), re.compile(rb"[Mm][ \t0]*9[ \t]*9(?![ \t]*[0-9])")
NOT_AGAIN = "variables tell the times apart: M30 ends it after one piece"
RETURNS = (280, 300)  # G28 and G30 take their words away from the path, but move


def lines(program: Program, tracker: Tracker, limits: Limits) -> Iterator[Line]:
    """The plain lines of a program in the order of execution. Raises ProgramError where it can not
    be run, or runs beyond the limits."""
    return Runner(program, tracker, limits).run()


class Runner:
    """One program while it is executed."""

    def __init__(self, program: Program, tracker: Tracker, limits: Limits):
        self.program, self.tracker, self.limits = program, tracker, limits
        self.variables = Variables(tracker)
        tracker.rendered = self._rendered
        tracker.program = lambda n: text_of(n, self.frames[-1], self.library, self.source)
        self.semicolon = tracker.dialect.grammar.semicolon
        named = program if self.variables.haas else numbered(program, self.semicolon)
        self.source = Source(named, self.semicolon, self.variables.haas)
        self.library = Library(program, self.semicolon, self.variables.haas)
        self.variables.mentions = lambda what: any(
            s.mentions(what) for s in (self.source, *self.library.sources())
        )
        self.frames: list[Frame] = []
        self.rounds = Rounds()
        self.modal: list[Modal] = []
        self.steps, self.most = 0, max(limits.steps, len(self.source.texts))
        self.ended, self.place = False, (0, 0)
        # A program that begins again (M99) is run twice where variables could tell the times apart.
        self.seen: list[bytes] | None = (
            [] if self.source.mentions(AGAIN) and self.variables.mentions(VARIABLE) else None
        )
        self.second = -1  # lines of the second time, -1: the first

    def run(self) -> Iterator[Line]:
        """Execute it."""
        for line in self._lines():
            # M99 of the main program: written out is the first time, and the second must be the
            # same text
            if self.seen is None or (self.ended and self.second in (-1, len(self.seen))):
                yield line
            elif self.second < 0:
                self.seen.append(line.text)
                yield line
            elif self.second == len(self.seen) or self.seen[self.second] != line.text:
                wrong = Refusal(
                    "M99 in the main program: the second time it would be another program",
                    NOT_AGAIN,
                )
                raise self.source.fault(self.program.name, line.source - 1, wrong)
            else:
                self.second += 1

    def _lines(self) -> Iterator[Line]:
        #   O1       frames [O1]           A call puts a program on top; its M99 takes it off, or
        #   M98 P2   frames [O1, O2]       starts it again while `left` says so. #1 to #33 are its
        #   G65 P3   frames [O1, O2, O3]   own behind G65, the caller's behind M98.
        first = self.source.sections[0]
        self._enter(Frame(self.source, first, first.start, first.start, 0, {}))
        while not self.ended:
            frame = self.frames[-1]
            source, at, stop = frame.source, frame.at, frame.section.stop
            # entries that are plain blocks leave in one go; under G66 each may be a motion with a
            # call behind
            if not self.modal:
                special = source.special.find(1, at, stop)
                until = min(stop if special < 0 else special, at + self.most - self.steps)
                self.steps += until - at
                file = source.file
                for text, number in zip(
                    source.texts[at:until], source.numbers[at:until], strict=True
                ):
                    yield Line(text, number, file)
                frame.at = at = until
            if at >= stop:
                self._runs_out(frame)
                break
            plain = self._step(frame, at)
            if plain is not None:
                yield Line(plain, source.numbers[at], source.file)
        yield from self._tail()

    # -- one block ---------------------------------------------------------------------------------

    def _step(self, frame: Frame, at: int) -> bytes | None:
        """Execute an entry; the plain text that it leaves, if any."""
        frame.at = at + 1
        raw, self.place = frame.source.texts[at], (0, 0)
        try:
            if self.steps >= self.most:
                raise self.limits.endless(self.most)
            self.steps += 1
            if self.tracker.setup.block_delete and DELETED.match(raw):
                return raw
            block = frame.source.block(at)
            text = self._execute(frame, at, block)
            if frame is self.frames[-1] and frame.at <= at and not self.modal:
                self.rounds.back(at, self.frames, self.variables, self.second >= 0)
            return text
        except BlockFault as before:
            what = f"where the program stands can not be told: {before.message}"
            raise frame.source.fault(self.program.name, at, Refusal(what, before.advice)) from None
        except Refusal as wrong:
            wrong = wrong.placed(*self.place)
            raise frame.source.fault(self.program.name, at, wrong) from None

    # Whole: one branch to a kind of block.
    def _execute(self, frame: Frame, at: int, block: Block) -> bytes | None:
        variables, kind, self.place = self.variables, block.kind, block.place
        if kind in (Kind.PLAIN, Kind.WORDS):
            return self._plain(block)
        if kind is Kind.SET:
            return self._set(block)
        if kind is Kind.IF:
            assert block.formula and block.then
            if block.formula(variables):
                return self._execute(frame, at, block.then)
            frame.at = frame.source.behind(at)
            return None
        if kind is Kind.GOTO:
            assert block.target
            frame.at = frame.source.jump(
                frame.section, at, label_of(block.target(variables)), block.place
            )
        elif kind in (Kind.DO, Kind.END):
            partner = frame.source.partner(frame.section, at, block.place)
            if kind is Kind.END:
                frame.at = partner
            elif block.formula and not block.formula(variables):
                frame.at = partner + 1
        elif kind is Kind.CALL:
            return self._macro(block) if block.code == 65 else self._subprogram(frame, at, block)
        elif kind is Kind.MODAL:
            return self._macro(block)
        elif kind is Kind.CANCEL:
            self._set_modal(self.modal[:-1])
            return self._rest(block, [w for w in block.words if w.place == block.place])
        elif kind is Kind.RETURN:
            return self._return(frame, at, block)
        elif kind in (Kind.TAPE, Kind.HEAD) and len(self.frames) == 1:
            return block.raw
        return None

    def _plain(self, block: Block) -> bytes | None:
        first = block.behind if block.program >= 0 and len(self.frames) > 1 else block.first
        text, words = block.raw[first:], block.words
        if block.kind is Kind.WORDS:
            self.variables.spare = int(block.units == 2)  # an inch needs one decimal more
            text, words = rendered(block.raw, words, self.variables, first)
            if not words:
                return None
        if block.units:
            self.variables.forget_units()
        self.ended |= block.ends
        if self.modal and not block.ends and self._moves(words):
            # the macro runs with one modal call less in force, or its own motions would call it
            # without end
            modal, force = self.modal[-1], self.modal
            start = modal.section.start
            self._set_modal(force[:-1])
            self._enter(
                Frame(
                    modal.source, modal.section, start, start, modal.times - 1, modal.local, force
                ),
                block.place,
            )
        return text

    def _rendered(self, raw: bytes) -> bytes | None:
        """A block of words with numbers in place of its expressions; None: it is more than that."""
        try:
            block = BlockReader(raw, self.semicolon, self.variables.haas).block()
            if block.kind is not Kind.WORDS:
                return None
            return rendered(raw, block.words, self.variables, 0)[0]
        except Refusal:
            return None

    def _rest(self, block: Block, leave: Sequence[Word]) -> bytes | None:
        """The text of a call's block without the words of the call; None where nothing is left."""
        text, words = rendered(block.raw, block.words, self.variables, block.first, leave)
        if self.modal and self._moves(words):
            raise Refusal(
                "a call, or M99, and a motion in one block under G66",
                "give them a block each",
                *block.place,
            )
        if block.units:
            self.variables.forget_units()
        self.ended |= block.ends
        return text.strip() if words else None

    def _moves(self, words: list[Word]) -> bool:
        """Whether a block moves an axis."""
        dialect, axes = self.tracker.dialect, self.tracker.setup.axes
        codes = [round((w.worth(self.variables) or 0.0) * 10) for w in words if w.letter == "G"]
        known = [dialect.by_number.get(code) for code in codes]
        if 40 in codes or any(c and c.takes and c.number not in RETURNS for c in known):
            return False
        if any(w.letter in axes or w.letter in dialect.increments for w in words):
            return True
        arc = {20, 30} & {*codes, self.tracker.code("motion")}
        return bool(arc) and any(w.letter in "IJK" for w in words)

    def _set(self, block: Block) -> bytes | None:
        assert block.target and block.formula
        number = index(block.target(self.variables))
        value: Value | Unknown
        try:
            value = block.formula(self.variables)
        except Unknown as unknown:
            if number in (3000, 3006):
                raise
            # what only the machine knows may be stored; who asks for it later is refused
            value = unknown
        if number == 3000:
            assert not isinstance(value, Unknown)
            text = block.comment.strip(b"()").decode("latin-1")
            raise Refusal(
                f"the program stops itself with the alarm #3000={value or 0:g}:"
                f" {text or 'without a text'}",
                "it found something that is not as it expects: look at the condition before this"
                " block",
            )
        if number == 3006:
            return block.comment or None
        if data := self.variables.data_block(number, value):
            return data.encode()
        self.variables.write(number, value)
        return None

    # -- where control goes ------------------------------------------------------------------------

    def _subprogram(self, frame: Frame, at: int, block: Block) -> bytes | None:
        """M98, M198 and M97."""
        words, variables, place = block.words, self.variables, block.place
        what = f"M{block.code:g}"
        if block.code == 97:
            source, section, count = frame.source, frame.section, times(words, variables)
            label = called(words, "P", variables, what, place)
        else:
            number, count = subprogram(
                words, variables, what, place, lambda n: self._find(n, block.code) is not None
            )
            source, section = self._program(number, block)
            label = called(words, "Q", variables, what, place) if word_of(words, "Q") else -1
        start = (
            source.find(section, label, at if source is frame.source else -1)
            if label >= 0
            else section.start
        )
        if start < 0:
            raise Refusal(
                f"there is no N{label} in that program",
                "write it before the block to begin with",
                *place,
            )
        leave = [w for w in words if w.place == place or w.letter in "PQL"]
        text = self._rest(block, leave)
        self._enter(Frame(source, section, start, start, count - 1, frame.local), place)
        return text

    def _macro(self, block: Block) -> bytes | None:
        """G65 and G66."""
        words, variables, place = block.words, self.variables, block.place
        code = next(i for i, word in enumerate(words) if word.place == place)
        stray = next((word for word in words[:code] if word.letter != "G"), None)
        if stray:
            raise Refusal(
                f"{stray.letter} before G{block.code:g}",
                "what is handed over stands behind it",
                *stray.place,
            )
        behind = words[code + 1 :]
        source, section = self._program(
            called(behind, "P", variables, f"G{block.code:g}", place), block
        )
        count = times(behind, variables)
        local = arguments([word for word in behind if word.letter not in "PL"], variables)
        text = self._rest(block, words[code:])
        if block.kind is Kind.MODAL:
            self._set_modal([*self.modal, Modal(source, section, count, local)])
        else:
            self._enter(
                Frame(source, section, section.start, section.start, count - 1, local), place
            )
        return text

    def _return(self, frame: Frame, at: int, block: Block) -> bytes | None:
        """M99: again from the start, back to the caller, or with P to a block of the caller."""
        label = (
            called(block.words, "P", self.variables, "M99", block.place)
            if word_of(block.words, "P")
            else -1
        )
        text = self._rest(
            block, [w for w in block.words if w.place == block.place or w.letter in "PL"]
        )
        if len(self.frames) == 1:
            if label < 0 and self._ends_at(at):
                return frame.source.texts[at] if self.ended else None
            if label < 0:
                advice = "M30 ends it after one piece; / before M99 and block delete leave it out"
                raise Refusal(
                    "M99 in the main program: it would run from its top without end",
                    advice,
                    *block.place,
                )
            frame.at = frame.source.jump(frame.section, at, label, block.place)
        elif label < 0 and frame.left:
            frame.left, frame.at = frame.left - 1, frame.start
        else:
            self._leave()
            if label >= 0:
                caller = self.frames[-1]
                caller.at = caller.source.jump(caller.section, caller.at - 1, label, block.place)
        return text

    def _ends_at(self, at: int) -> bool:
        """Whether M99 in the main program can end what is written out, since the control begins
        that again as it stands: it may if the second time is the same text."""
        frame = self.frames[0]
        if DELETED.match(frame.source.texts[at]):
            return False
        if self.seen is None or self.second >= 0:
            self.ended = True
        else:
            self.second, frame.at = 0, frame.start
        return True

    # -- programs ----------------------------------------------------------------------------------

    def _enter(self, frame: Frame, place: tuple[int, int] = (0, 0)) -> None:
        if len(self.frames) > self.limits.depth:
            raise self.limits.too_deep().placed(*place)
        self.frames.append(frame)
        self._in_force()

    def _leave(self) -> None:
        frame = self.frames.pop()
        if frame.modal is not None:
            self._set_modal(frame.modal)
        self._in_force()

    def _in_force(self) -> None:
        frame = self.frames[-1]
        self.variables.local, self.variables.program = frame.local, max(frame.section.number, 0)

    def _set_modal(self, modal: list[Modal]) -> None:
        self.modal = modal
        self.variables.modal = bool(modal)

    def _find(self, number: int, code: float) -> tuple[Source, Section] | None:
        """A program by its O number; M198 looks in the library alone."""
        return self.library.find(
            number, *((self.frames[-1].source, self.source) if code != 198 else ())
        )

    def _program(self, number: int, block: Block) -> tuple[Source, Section]:
        found = self._find(number, block.code)
        if found is None:
            where = "in the library" if block.code == 198 else "in this text nor in the library"
            raise Refusal(
                f"there is no program O{number} {where}",
                f"add it: O{number} before its first block",
                *block.place,
            )
        return found

    # -- the end -----------------------------------------------------------------------------------

    def _runs_out(self, frame: Frame) -> None:
        """Behind the last block: the main program may end here, others may not."""
        source, stop, name = frame.source, frame.section.stop, self.program.name
        if len(self.frames) > 1:
            what = f"O{frame.section.number}" if frame.section.number >= 0 else "the subprogram"
            wrong = Refusal(
                f"{what} ends without M99", "M99 goes back to the program that called it"
            )
            raise source.fault(name, max(stop - 1, 0), wrong)
        if stop < len(source.texts) and stop != source.closing:
            number = next(section.number for section in source.sections if section.start == stop)
            what = f"the program runs into O{number} without M02, M30 or M99"
            raise source.fault(name, stop, Refusal(what, "M30 ends the main program"))

    def _tail(self) -> Iterator[Line]:
        """Blank lines and comments behind the end, and the "%"."""
        source, main = self.source, self.frames[0]
        at = main.at
        while (
            at < len(source.texts)
            and at != source.closing
            and len(self.frames) == 1
            and not source.code(at)
        ):
            yield Line(source.texts[at], source.numbers[at])
            at += 1
        if source.closing >= 0:
            yield Line(source.texts[source.closing], source.numbers[source.closing])
