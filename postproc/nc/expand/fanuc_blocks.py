"""Blocks of Fanuc's custom macro B: what one says, ready to be executed as often as control comes
by.

    block     = { "/" [ digit ] | "N" number | "O" number } ( statement | { word } )
    statement = variable "=" expression | "GOTO" number | "IF" condition ( "GOTO" number | "THEN" statement )
              | [ "WHILE" condition ] "DO" digit | "END" digit
    word      = letter [ sign ] ( number | variable | "[" expression "]" )

Blanks may stand anywhere, as in the lexer. A block is cut only where something must be calculated;
all between stays as it is. Lines for a printer (POPEN DPRNT BPRNT PCLOS) and names of variables
(SETVN) move nothing: they are left out.
"""  # noqa: E501

from __future__ import annotations

import re
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any

from postproc.nc.comments import COMMENTS
from postproc.nc.expand import Refusal
from postproc.nc.expand.fanuc_expressions import NUMBER, Formula, Reader
from postproc.nc.expand.fanuc_words import Word

# What a block must have to be more than a plain one. E N for END; O for GOTO, DO and O numbers; G20
# and G21 change how numbers are written. It begins with one set of characters, because such a
# search is three times as fast.
SPECIAL = re.compile(
    rb"[#\[%:OoEeGgMm](?:(?<=[#\[%:Oo])|(?<=[Ee])[ \t]*[Nn]|"
    rb"(?<=[Gg])[ \t0]*(?:6[ \t]*[567]|2[ \t]*[01](?![ \t]*[0-9]))|"
    rb"(?<=[Mm])[ \t0]*(?:2|3[ \t]*0|9[ \t]*[789]|1[ \t]*9[ \t]*8)(?![ \t]*[0-9]))"
)
HEAD = re.compile(r"(/[1-9]?|N\d+|[O:]\d+)*", re.ASCII)
PROGRAM = re.compile(r"[O:](\d+)", re.ASCII)
LABEL = re.compile(r"N(\d+)", re.ASCII)
PRINT = re.compile(r"POPEN|PCLOS|BPRNT|DPRNT|SETVN")
DRAWS = re.compile(r"\[(?:BILLET|TOOLDEF|EDGEMOVE)")  # rows.DRAWS: no words of a motion
KEYWORD = re.compile(r"GOTO|WHILE|THEN|DO\d|END\d", re.ASCII)
LOOP = re.compile(r"(DO|END?)(\d{1,9})$", re.ASCII)
END_OF_PROGRAM = (2, 30)


class Kind(Enum):
    """What a block does when it is executed."""

    PLAIN = auto()  # passes as it stands
    WORDS = auto()  # passes with numbers in it
    TAPE = auto()  # %
    HEAD = auto()  # nothing but an O number
    NOTHING = auto()  # left out
    SET = auto()
    GOTO = auto()
    IF = auto()
    DO = auto()
    END = auto()
    CALL = auto()  # M98 M97 M198 G65
    MODAL = auto()  # G66
    CANCEL = auto()  # G67
    RETURN = auto()  # M99


@dataclass
class Block:
    """A block. at: offsets into `raw` of each character of its code; first: where its text begins,
    behind: where what stands behind N and O numbers begins; code: the G or M number of a call;
    label, program: its N and O number, -1: none;
    ends: whether the program ends here; units: whether it
    changes them or may: 2 for G20; place: what to show of it where it is wrong, offsets into the
    code."""

    kind: Kind
    raw: bytes
    at: list[int]
    first: int = 0
    behind: int = 0
    label: int = -1
    program: int = -1
    words: list[Word] = field(default_factory=list)
    formula: Formula | None = None
    target: Formula | None = None
    then: Block | None = None
    code: float = 0
    ends: bool = False
    units: int = 0
    place: tuple[int, int] = (0, 0)

    @property
    def comment(self) -> bytes:
        """Its first comment, with the parentheses."""
        found = COMMENTS["end of block"].search(self.raw)
        return found[0] if found else b""


def bare(raw: bytes, semicolon: str) -> tuple[str, list[int]]:
    """The code of a block without blanks, comments and the end of block, in upper case, and the
    offset of each character."""
    # blanks for comments, byte for byte, so that `at` leads from the code back into the line
    text = (
        COMMENTS[semicolon].sub(lambda found: b" " * len(found[0]), raw)
        if b"(" in raw or b";" in raw
        else raw
    )
    if semicolon != "comment":
        text = text.replace(b";", b" ")
    at = [i for i, character in enumerate(text) if character not in b" \t\r"]
    return bytes(text[i] for i in at).upper().decode("latin-1"), at


class BlockReader:
    """Reads one block. Raises Refusal where it is none."""

    def __init__(self, raw: bytes, semicolon: str, haas: bool):
        self.raw, self.haas = raw, haas
        self.code, self.at = bare(raw, semicolon)

    def block(self) -> Block:
        """The whole block."""
        code = self.code
        if code.startswith("%"):
            return Block(Kind.TAPE, self.raw, self.at)
        head = HEAD.match(code)
        stop = head.end() if head else 0
        label, program = LABEL.search(code[:stop]), PROGRAM.search(code[:stop])
        block = self.statement(stop)
        if block.kind is Kind.PLAIN and stop == len(code) and program:
            block.kind = Kind.HEAD
        block.first, block.behind = 0, self.at[stop] if stop < len(code) else len(self.raw)
        block.label = int(label[1]) if label and len(label[1]) < 10 else -1
        block.program = int(program[1]) if program and len(program[1]) < 10 else -1
        return block

    def statement(self, start: int) -> Block:
        """What stands from `start` on."""
        code = self.code
        rest = code[start:]
        if rest.startswith("#"):
            return self._set(start)
        if rest.startswith(("GOTO", "GO")):
            return self._goto(start)
        if rest.startswith("IF["):
            return self._condition(start + 2, start)
        if rest.startswith(("WHILE[", "WH[")):
            return self._while(code.index("[", start), start)
        if rest.startswith("[") and self.haas:
            return self._condition(start, start)
        if found := LOOP.match(rest):
            kind = Kind.DO if found[1] == "DO" else Kind.END
            return self._made(kind, start)
        if PRINT.match(rest):
            return self._made(Kind.NOTHING, start)
        if DRAWS.match(rest):
            return self._made(Kind.PLAIN, start)
        return self._words(start)

    def _made(self, kind: Kind, start: int, **more: Any) -> Block:
        first = self.at[start] if 0 < start < len(self.at) else 0
        return Block(kind, self.raw, self.at, first, place=(start, len(self.code)), **more)

    def _end(self, reader: Reader) -> None:
        if reader.at < len(self.code):
            raise reader.fault(
                f"{self.code[reader.at :][:20]!r} behind the statement", "one statement to a block"
            )

    def _set(self, start: int) -> Block:
        reader = Reader(self.code, start, haas=self.haas)
        target = reader.number_of_variable()
        if self.code[reader.at : reader.at + 1] != "=":
            raise reader.fault(
                "a variable alone says nothing", "#100=5 sets it, X#100 uses it", start
            )
        reader.at += 1
        value = reader.expression()
        self._end(reader)
        return self._made(Kind.SET, start, target=target, formula=value)

    def _goto(self, start: int) -> Block:
        at = start + (4 if self.code.startswith("GOTO", start) else 2)
        at += self.code[at : at + 1] == "N"
        reader = Reader(self.code, at, haas=self.haas)
        digits = re.compile(r"\d{1,9}", re.ASCII).match(self.code, at)
        if digits:
            value = float(digits[0])
            reader.at = digits.end()
        target = reader.value() if not digits else lambda m: value
        self._end(reader)
        return self._made(Kind.GOTO, start, target=target)

    def _condition(self, at: int, start: int) -> Block:
        reader = Reader(self.code, at, haas=self.haas)
        condition = reader.bracketed()
        rest = self.code[reader.at :]
        if rest.startswith("TH"):
            reader.at += 4 if rest.startswith("THEN") else 2
        elif not rest.startswith("GO") and not (self.haas and self.code[start] == "["):
            raise reader.fault(
                "a condition without GOTO or THEN", "IF[#1 EQ 0]GOTO 10, or IF[#1 EQ 0]THEN #2=5"
            )
        if reader.at >= len(self.code):
            raise reader.fault("nothing to do behind THEN", "IF[#1 EQ 0]THEN #2=5")
        return self._made(Kind.IF, start, formula=condition, then=self.statement(reader.at))

    def _while(self, at: int, start: int) -> Block:
        reader = Reader(self.code, at, haas=self.haas)
        condition = reader.bracketed()
        found = LOOP.match(self.code[reader.at :])
        if not found or found[1] != "DO":
            if found := re.match(r"DO[1-9]", self.code[reader.at :]):
                raise reader.fault(
                    f"more than {found[0]} behind WHILE", "write it in a block of its own"
                )
            raise reader.fault("WHILE without DO1, DO2 or DO3", "WHILE[#1 LE 10]DO1 ... END1")
        return self._made(Kind.DO, start, formula=condition)

    # -- words -------------------------------------------------------------------------------------

    def _words(self, start: int) -> Block:
        calculated = "#" in self.code or "[" in self.code
        try:
            words = self._scan(start)
        except Refusal:
            # what has nothing to calculate passes as it stands: what is wrong with it the lexer
            # says
            if calculated or KEYWORD.search(self.code) or (self.haas and "/" in self.code[start:]):
                raise
            return self._made(Kind.PLAIN, start)
        block = self._made(
            Kind.WORDS if any(not w.digits for w in words) else Kind.PLAIN, start, words=words
        )
        for word in words:
            self._classify(block, word)
            if block.kind in (Kind.CALL, Kind.MODAL) and block.code < 90:
                break  # all behind G65 and G66 is handed over
        return block

    # Whole: one branch to a code of the language.
    def _classify(self, block: Block, word: Word) -> None:
        """What a code of the language makes of its block. Raises Refusal."""
        value = float(word.digits) if word.digits else -1.0
        kind = None
        if word.letter == "M" and value in END_OF_PROGRAM:
            block.ends = True
        elif word.letter == "G" and (value in (20, 21) or not word.digits):
            block.units = 2 if value == 20 else 1
        elif word.letter == "M" and (value in (98, 198) or (value == 97 and self.haas)):
            kind = Kind.CALL
        elif word.letter == "M" and value == 99:
            kind = Kind.RETURN
        elif word.letter == "G" and value in (65, 66, 66.1, 67):
            kind = {65: Kind.CALL, 67: Kind.CANCEL}.get(int(value), Kind.MODAL)
            if value == 66.1:
                raise Refusal(
                    "G66.1 calls a macro in every block",
                    "write G65 in the blocks that shall call it",
                    *word.place,
                )
        if kind:
            if block.kind not in (Kind.PLAIN, Kind.WORDS):
                raise Refusal("two calls or returns in one block", "one to a block", *word.place)
            block.kind, block.code, block.place = kind, value, word.place

    def _scan(self, start: int) -> list[Word]:
        code, at, i, words = self.code, self.at, start, []
        while i < len(code):
            begin, letter = i, code[i]
            if letter == "," and code[i + 1 : i + 2].isalpha():
                i, letter = i + 1, code[i + 1]
            if not "A" <= letter <= "Z":
                what = (
                    "expressions stand behind an address: X#1, X[#1+2]"
                    if letter in "#["
                    else "one statement to a block"
                )
                raise Refusal(f"{letter!r} can not be read here", what, i, i + 1)
            i += 1
            from_ = i
            if code[i : i + 1] in ("+", "-"):
                i += 1
            found = NUMBER.match(code, i)
            digits, value = "", None
            if found:
                i, digits = found.end(), code[from_ : found.end()]
            elif code[i : i + 1] in ("#", "["):
                reader = Reader(code, i, letter, self.haas)
                value = reader.value()
                i = reader.at
            else:
                raise Refusal(f"the letter {letter} has no number", "give it one", begin, i)
            negative = code[from_] == "-"
            words.append(
                Word(
                    letter, at[begin], at[from_], at[i - 1] + 1, digits, value, negative, (begin, i)
                )
            )
        return words
