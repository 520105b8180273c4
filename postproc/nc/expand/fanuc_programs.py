"""The programs that a Fanuc text holds, and where control goes within each.

A text holds one program or several, each begun by its O number; GOTO finds N numbers within a
program, DO and END are paired by it. Sources: B-64304EN and B-64484EN, "Custom macro", "Branch and
repetition"; "Subprogram (M98, M99)".
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from postproc.errors import ProgramError
from postproc.nc.comments import COMMENTS
from postproc.nc.expand import Program, Refusal, fault
from postproc.nc.expand.fanuc_blocks import DRAWS, LOOP, SPECIAL, Block, BlockReader, bare
from postproc.nc.expand.fanuc_statements import parts

# what makes a text one that must be executed: not O numbers, and not the end of the program
MACRO = re.compile(
    rb"[#\[MmGgDdOoEe](?:(?<=[#\[])|(?<=[Mm])[ \t0]*(?:9[ \t]*[789]|1[ \t]*9[ \t]*8)(?!["
    rb" \t]*[0-9])|"
    rb"(?<=[Gg])(?:[ \t0]*6[ \t]*[567]|[ \t]*[Oo])|(?<=[Dd])[ \t]*[Oo]|(?<=[Oo])(?!["
    rb" \t]*[0-9])|(?<=[Ee])[ \t]*[Nn])"
)
MODAL = re.compile(rb"[Gg][ \t0]*6[ \t]*6")
PROGRAM_HEAD = re.compile(rb"[ \t]*(?:/[1-9]?[ \t]*)?[Oo:][ \t]*([0-9][0-9 \t]*)")
LABEL_HEAD = re.compile(rb"(?:[ \t]|\([^()]*\)|/[1-9]?)*[Nn][ \t]*([0-9][0-9 \t]*)")
SECOND_LABEL = re.compile(rb";(?:[ \t]|/[1-9]?)*[Nn][ \t]*[0-9]")


@dataclass
class Section:
    """One program of a text: entries start to stop - 1. number: its O number, -1: none. labels: N
    number to entries; partner: entry of a DO to that of its END and back; broken: entries of DO and
    END that are not paired, and why."""

    start: int
    stop: int
    number: int = -1
    labels: dict[int, list[int]] | None = None
    partner: dict[int, int] | None = None
    broken: dict[int, tuple[str, str]] = field(default_factory=dict)


class Source:
    """A text cut into entries: lines, or blocks where several stand in a line and one must be met
    alone.

    file: "" for the main program. special: whether an entry may be more than a plain block;
    closing: the entry of the "%" that ends it, -1: none."""

    def __init__(self, program: Program, semicolon: str, haas: bool, file: str = ""):
        self.program, self.semicolon, self.haas, self.file = program, semicolon, haas, file
        self.mentioned: dict[re.Pattern[bytes], bool] = {}
        self.texts: Sequence[bytes] = program.whole_lines()
        self.numbers: Sequence[int] = range(1, len(self.texts) + 1)
        code = (
            COMMENTS[semicolon].sub(b" ", program.text)
            if b"(" in program.text or b";" in program.text
            else program.text
        )
        #   N1 G0 X1; #1=2; M98 P3;    one line, and three entries where one of its blocks must be
        #                              met alone; all have the line's number. Entries without a
        #                              mark in `special` leave without being read.
        self.special = _special(code, len(self.texts))
        self.expands = bool(file) or MACRO.search(code) is not None
        if semicolon != "comment" and self.expands:
            self._cut(MODAL.search(code) is not None, SECOND_LABEL.search(program.text) is not None)
        self.continues: set[int] = set()  # entries that go on with the block of the one before
        if haas and self.expands:
            self._take_apart()
        self.closing = self._tapes()
        self.blocks: dict[int, Block] = {}
        self.sections = self._sections()

    def mentions(self, what: re.Pattern[bytes]) -> bool:
        """Whether a block of it matches."""
        if what not in self.mentioned:
            self.mentioned[what] = (
                what.search(COMMENTS[self.semicolon].sub(b" ", self.program.text)) is not None
            )
        return self.mentioned[what]

    def _flagged(self) -> Iterator[int]:
        """The special entries."""
        at = self.special.find(1)
        while at >= 0:
            yield at
            at = self.special.find(1, at + 1)

    def _cut(self, all_of_them: bool, labels: bool) -> None:
        """Take lines of several blocks apart, where a block of them is special or may be jumped
        to."""
        apart = set(self._flagged())
        if all_of_them or labels:
            apart |= {
                i for i, text in enumerate(self.texts) if all_of_them or SECOND_LABEL.search(text)
            }
        self._put((i, _pieces(self.texts[i])) for i in sorted(apart) if b";" in self.texts[i])

    def _take_apart(self) -> None:
        """Cut blocks of several statements, which a Haas has."""
        cut = ((i, parts(self.texts[i], self.semicolon)) for i in self._flagged())
        for behind, number in self._put((i, pieces) for i, pieces in cut if len(pieces) > 1):
            self.continues |= set(range(behind - number + 1, behind))

    def _put(self, cut: Iterable[tuple[int, list[bytes]]]) -> list[tuple[int, int]]:
        """Put pieces in the place of entries, in order; of each: where it ends now, and the number
        of its pieces."""
        texts: list[bytes] = []
        numbers: list[int] = []
        special, at, ends = bytearray(), 0, []
        for i, pieces in cut:
            texts += [*self.texts[at:i], *pieces]
            numbers += [*self.numbers[at:i], *[self.numbers[i]] * len(pieces)]
            special += self.special[at:i] + bytes([self.special[i]]) * len(pieces)
            ends.append((len(texts), len(pieces)))
            at = i + 1
        if at:
            self.texts, self.numbers = [*texts, *self.texts[at:]], [*numbers, *self.numbers[at:]]
            self.special = special + self.special[at:]
        return ends

    def behind(self, entry: int) -> int:
        """The first entry of the next block."""
        entry += 1
        while entry in self.continues:
            entry += 1
        return entry

    def _tapes(self) -> int:
        """The first "%" opens the program if no code stands before it; the next one ends it, and
        all behind is cut off."""
        tapes = [i for i in self._flagged() if self.texts[i].lstrip().startswith(b"%")][:2]
        if tapes and not any(self.code(i) for i in range(tapes[0])):
            tapes.pop(0)
        if not tapes:
            return -1
        stop = tapes[0] + 1
        self.texts = self.texts[:stop]
        self.numbers = self.numbers[:stop]
        self.special = self.special[:stop]
        return tapes[0]

    def _sections(self) -> list[Section]:
        stop = self.closing if self.closing >= 0 else len(self.texts)
        heads = []
        for i in self._flagged() if self.expands else ():
            found = PROGRAM_HEAD.match(self.texts[i])
            if found:
                digits = re.sub(rb"[ \t]", b"", found[1])
                heads.append((i, int(digits) if len(digits) < 10 else -1))
        # blocks before the first O number are a program of their own, the main one
        before = (self.code(i) for i in range(heads[0][0] if heads else 0))
        if not heads or any(code not in ("", "%") and not DRAWS.match(code) for code in before):
            heads.insert(0, (0, -1))
        # what stands before the first O number (%, comments) belongs to that program
        starts = [0, *(i for i, _ in heads[1:]), stop]
        return [Section(starts[k], starts[k + 1], number) for k, (_, number) in enumerate(heads)]

    def code(self, entry: int) -> str:
        """The code of an entry without blanks and comments."""
        return bare(self.texts[entry], self.semicolon)[0]

    def block(self, entry: int) -> Block:
        """An entry, read once."""
        block = self.blocks.get(entry)
        if block is None:
            block = self.blocks[entry] = BlockReader(
                self.texts[entry], self.semicolon, self.haas
            ).block()
        return block

    def section(self, number: int) -> Section | None:
        """The program with this O number."""
        return next((section for section in self.sections if section.number == number), None)

    # -- where control goes ------------------------------------------------------------------------

    def find(self, section: Section, label: int, behind: int) -> int:
        """The entry of an N number: searched from the entry behind `behind` to the end, then from
        the top; -1: none."""
        # all of a program at the first jump in it; many have none
        if section.labels is None:
            section.labels = {}
            for i in range(section.start, section.stop):
                found = LABEL_HEAD.match(self.texts[i])
                if found and len(digits := re.sub(rb"[ \t]", b"", found[1])) < 10:
                    section.labels.setdefault(int(digits), []).append(i)
        places = section.labels.get(label)
        if not places:
            return -1
        # the first one behind; where none is, the rest of the division is 0, the first of all
        return places[bisect_right(places, behind) % len(places)]

    def loops(self, section: Section) -> dict[int, int]:
        """Entry of each DO to that of its END, and back."""
        if section.partner is None:
            section.partner = {}
            open_: list[tuple[int, int]] = []
            for i in range(section.start, section.stop):
                found = LOOP.search(self.code(i)) if self.special[i] else None
                if found:
                    _pair(section, open_, i, found[1] == "DO", int(found[2]))
            for i, loop in open_:
                section.broken[i] = (
                    f"DO{loop} without END{loop}",
                    f"END{loop} closes it, in the same program",
                )
        return section.partner

    def partner(self, section: Section, at: int, place: tuple[int, int]) -> int:
        """The END of a DO, or the DO of an END. Raises Refusal where there is none."""
        found = self.loops(section).get(at)
        if found is None:
            raise Refusal(
                *section.broken.get(at, ("a loop that is not closed", "DO1 ... END1")), *place
            )
        return found

    def jump(self, section: Section, source: int, label: int, place: tuple[int, int]) -> int:
        """The entry to which a jump from `source` to an N number leads. Raises Refusal where it
        must not, or there is none."""
        target = self.find(section, label, source)
        if target < 0:
            raise Refusal(
                f"there is no N{label} in this program",
                f"write N{label} before the block to go to",
                *place,
            )
        for start, end in self.loops(section).items():
            if start < target <= end and not start <= source <= end:
                what = f"N{label} lies inside the loop of line {self.numbers[start]}"
                raise Refusal(what, "a jump may leave a loop but not enter it", *place)
        return target

    def fault(self, name: str, at: int, wrong: Refusal) -> ProgramError:
        """What is wrong at an entry, as an error with its place; name: of the main program."""
        if at >= len(self.texts):
            return fault(self.file or name, 1, b"", wrong.message, wrong.advice)
        raw, start, stop = self.texts[at], 0, 0
        place = bare(raw, self.semicolon)[1]
        if wrong.stop and place:
            start = place[min(wrong.start, len(place) - 1)]
            stop = place[min(max(wrong.stop, wrong.start + 1), len(place)) - 1] + 1
        return fault(
            self.file or name, self.numbers[at], raw, wrong.message, wrong.advice, start, stop
        )


def _special(code: bytes, lines: int) -> bytearray:
    """1 for each line of a text without comments that may be more than a plain block."""
    flags, line, at = bytearray(lines), 0, 0
    while found := SPECIAL.search(code, at):
        line += code.count(b"\n", at, found.start())
        flags[line] = 1
        # one mark a line is enough: the search goes on in the next
        at = code.find(b"\n", found.end())
        if at < 0:
            break
    return flags


def _pieces(text: bytes) -> list[bytes]:
    """The blocks of a line, each with its end of block; what holds no code stays with the one
    before."""
    masked = COMMENTS["end of block"].sub(lambda found: b" " * len(found[0]), text)
    pieces, at = [], 0
    while (stop := masked.find(b";", at) + 1) and masked[stop:].strip(b" \t\r;"):
        pieces.append(text[at:stop])
        at = stop
    return [*pieces, text[at:]]


def _pair(section: Section, open_: list[tuple[int, int]], i: int, opens: bool, loop: int) -> None:
    """Pairs a DO or END with its other one, or notes why it has none; said only when it is
    executed. open_: places and numbers of the loops that are open there."""
    assert section.partner is not None
    if not 1 <= loop <= 3:
        section.broken[i] = (
            f"{'DO' if opens else 'END'}{loop}: loops are numbered 1 to 3",
            "three loops may be nested",
        )
    elif opens and any(loop == other for _, other in open_):
        section.broken[i] = (
            f"DO{loop} inside DO{loop}",
            "nested loops need different numbers, 1 to 3",
        )
    elif opens:
        open_.append((i, loop))
    elif not any(loop == other for _, other in open_):
        section.broken[i] = (
            f"END{loop} without DO{loop}",
            f"WHILE[..]DO{loop} opens the loop, in the same program",
        )
    else:
        # DO1 DO2 END1 END2: END1 closes DO1 and cuts DO2, so that END2 is left without one
        while open_[-1][1] != loop:
            start, other = open_.pop()
            section.broken[start] = (
                f"DO{other} is cut by END{loop}",
                "loops may be nested but not overlap",
            )
        start, _ = open_.pop()
        section.partner[start], section.partner[i] = i, start
