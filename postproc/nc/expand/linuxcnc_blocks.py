"""A line of RS274/NGC: either a control (an O-word, M98, M99), or a block of words and assignments.

    control = [ "/" ] [ N number ] ( O label keyword values | O label | M98 P value [ L value ] | M99 )
    block   = [ "/" ] [ N number ] { letter value | "#" parameter "=" value | comment }

Values read by a block are those before it; its assignments hold behind it. Text that is no
expression stays as it is.

Sources: LinuxCNC documentation, "O codes" and "G-code overview"; measured on LinuxCNC 2.9
(tests/expand/test_linuxcnc.py).
"""  # noqa: E501

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from postproc.nc.expand import Refusal
from postproc.nc.expand.linuxcnc_expressions import (
    NUMBER,
    Code,
    Node,
    Reader,
    Scope,
    compact,
    whole,
)
from postproc.nc.expand.linuxcnc_parameters import LOCAL, Memory
from postproc.nc.expand.tracker import number

# What makes a line more than plain words: expressions, signs in a row, the end, M70-M73 M98 M99,
# what parameters and written numbers depend on (M61, G10, G20, G28.1, cycles), comments that act;
# at the start of a line, an O-word or "%".
SPECIAL = re.compile(
    rb"[\[#@^+\-MmGg(;](?:(?<=[\[#@^])|(?<=[+-])[ \t]*[+-]|(?<=\()["
    rb" \t]*(?:[Aa][Bb]|[Pp][Yy])|(?<=;)[Pp][Yy],"
    rb"|(?<=[Mm])[ \t0]*(?:2|3[ \t]*0|6[ \t]*1|7[ \t]*[0-3]|9[ \t]*[89])(?![ \t]*\d)|(?<=[Gg])["
    rb" \t0]*"
    rb"(?:(?:1[ \t]*0|2[ \t]*[01]|7[ \t]*[346]|8[ \t]*[1-9])(?![ \t]*\d)|(?:2[ \t]*8|3[ \t]*0)["
    rb" \t]*\.))"
)
SPECIAL_START = re.compile(rb"\n[ \t]*/?[ \t]*(?:[Nn][ \t\d.]+)?[Oo%]")
KEYWORD = re.compile(
    # in LinuxCNC's order
    "sub|endsub|call|do|while|repeat|if|elseif|else|endif|break|continue|endwhile|endrepeat|return"
)
SEQUENCE = re.compile(r"n\d+(?:\.\d+)?", re.ASCII)
FANUC = re.compile(r"m9[89](?![\d.])", re.ASCII)
LETTERS = "abcdefghijklmpqrstuvwxyz@^$"
WHOLE_WORDS, WHOLE_IF_WHOLE = "mthl$", "dp"
LEAST_WHOLE = 1e-6
MOST_DIGITS = 17
# comments that do something
ACTIVE = re.compile(rb"\(\s*(?:msg|print|debug|log\w*|probe(?:open|close))\s*[,)]")
STOPS = re.compile(rb"\(\s*abort\s*,\s*([^)]*)\)")
PYTHON = re.compile(rb"\(\s*py(?:run|reload)?\s*[,)]|;py,")


def special_lines(text: bytes, lines: int) -> bytearray:
    """For each line of a program, 1 where it may be more than plain words."""
    special = bytearray(lines + 1)
    for pattern, code in ((SPECIAL, text), (SPECIAL_START, b"\n" + text)):
        line, counted = 0, 0
        for found in pattern.finditer(code):
            line += code.count(b"\n", counted, found.start())
            counted = found.start()
            special[line] = 1
    return special[:lines]


class Edit(NamedTuple):
    """A piece of a line that does not stay: bytes start to stop. letter: of the word whose value it
    is, "": an assignment to the parameter `target` (a name, or what gives its number)."""

    start: int
    stop: int
    letter: str
    value: Node
    target: str | Node = ""


class Outcome(NamedTuple):
    """What a block leaves: its plain text, None if nothing; the numbers of its G and M words; its
    letters."""

    text: bytes | None
    g: list[float]
    m: list[float]
    letters: str


@dataclass
class Block:
    """A line of words and assignments. codes: letter and value of each G and M word; letters: of
    all words."""

    line: bytes
    edits: list[Edit] = field(default_factory=list)
    codes: list[tuple[str, Node]] = field(default_factory=list)
    letters: str = ""
    active: bool = False

    # Whole: assignments hold at once, behind all that they are read from.
    def run(self, memory: Memory) -> Outcome:
        """Evaluate it, and let its assignments hold. Raises Refusal."""
        line, at, pieces = self.line, 0, []
        #   #1=5 X#1 #2=[#1+1]     X and #2 read the #1 from before the line; 5 holds behind it
        named: list[tuple[str, float]] = []
        numbered: list[tuple[int, float]] = []
        for start, stop, letter, value, target in self.edits:
            pieces.append(line[at:start])
            at = stop
            try:
                if letter:
                    pieces.append(written(letter, value(memory), memory).encode())
                    continue
                if isinstance(target, str):
                    # a name that the line itself sets is worth 0 in it before: #<new>=[#<new>+1] is
                    # 1
                    memory.declare(target)
                    named.append((target, value(memory)))
                else:
                    index = whole(target(memory), "the number of a parameter")
                    memory.check_writable(index)
                    numbered.append((index, value(memory)))
            except Refusal as e:
                # F[#<_hal[feed]>] moves nothing: it stays as it stands, and the machine reads it
                if letter in "fs" and letter and only_of_the_machine(line[start:stop]):
                    pieces.append(line[start:stop])
                    continue
                raise e.placed(start, stop) from None
            while line[at : at + 1] in (b" ", b"\t"):
                at += 1
            if at == len(line):
                pieces = [b"".join(pieces).rstrip(b" \t")]
        pieces.append(line[at:])
        codes: dict[str, list[float]] = {"g": [], "m": []}
        for letter, value in self.codes:
            codes[letter].append(value(memory))
        for name, value_ in named:
            memory.set_named(name, value_)
        for index, value_ in numbered:
            memory.numbers[index] = value_
        # a line of assignments alone leaves nothing, but for a comment that acts: (DEBUG,#1)
        gone = not self.letters and not self.active and (named or numbered)
        return Outcome(None if gone else b"".join(pieces), codes["g"], codes["m"], self.letters)


def only_of_the_machine(value: bytes) -> bool:
    """Whether all that an expression reads are HAL pins and settings of the machine: it can stand
    in a plain line then, as value of an F or an S, which move nothing."""
    read = re.findall(rb"#\s*(<\s*_\s*(?:[Hh]\s*[Aa]\s*[Ll]|[Ii]\s*[Nn]\s*[Ii])\s*\[)?", value)
    return bool(read) and all(read)


def written(letter: str, value: float, memory: Memory) -> str:
    """A word's value as a plain number. Raises Refusal where it is none that the word can have."""
    upper = letter.upper()
    if letter == "g":
        # a G number has one decimal, and a value of 54.09999 is taken as 54.1
        tenths = math.floor(10.0 * value)
        if 10.0 * value - tenths > 0.999:
            tenths += 1
        elif 10.0 * value - tenths > 0.001 or not 0 <= tenths <= 999:
            raise Refusal(
                f"G{value:.10g} is no G code", "correct the expression or the values in it"
            )
        return f"{tenths // 10}.{tenths % 10}" if tenths % 10 else str(tenths // 10)
    if letter in WHOLE_WORDS:
        return str(whole(value, upper))
    if letter in WHOLE_IF_WHOLE and abs(value - round(value)) < LEAST_WHOLE:
        return str(round(value))
    decimals = memory.decimals(upper)
    if abs(value) >= 10.0 ** (MOST_DIGITS - decimals):
        raise Refusal(
            f"{upper} would be {value:.10g}",
            "no control holds that: correct the expression or its values",
        )
    return number(value, decimals)


@dataclass
class Control:
    """A line that says what runs next. kind: its keyword, "m98", "m99", or "" for an O number
    alone; plain: it is only that; label: what gives its name. What follows is read when it is asked
    for: of what is skipped, nothing is."""

    kind: str
    code: Code
    at: int
    label: Callable[[Scope], str] = lambda scope: ""
    plain: bool = False
    _values: list[Node] | None = None

    def values(self) -> list[Node]:
        """What stands behind the keyword: the condition, the arguments, the value to return; M98: P
        and L."""
        if self._values is None:
            self._values = self._called() if self.kind == "m98" else self._bracketed()
        return self._values

    def _bracketed(self) -> list[Node]:
        """The values in brackets behind a keyword: one condition, one value to return, or up to 30
        arguments of a call. Raises Refusal."""
        reader = Reader(self.code, self.at)
        needs = self.kind in ("while", "repeat", "if", "elseif")
        most = (
            1
            if needs or self.kind in ("return", "endsub")
            else len(LOCAL)
            if self.kind == "call"
            else 0
        )
        found: list[Node] = []
        if needs and reader.next != "[":
            raise reader.wrong(
                f"'[' is missing behind {self.kind}",
                "a condition stands in brackets: o1 if [#1 GT 0]",
            )
        while reader.next == "[" and len(found) < most:
            found.append(reader.expression())
            # a comment may stand behind each argument
            while self.kind == "call" and reader.taken("("):
                pass
        while reader.taken("("):
            pass
        if reader.next:
            if reader.next == "[" and self.kind == "call":
                raise reader.wrong(
                    f"more than {len(LOCAL)} arguments", "hand the others over in #31 and on"
                )
            raise reader.wrong(
                f"{self.kind or 'an O number'} is followed by more than a comment",
                "give it its own line",
            )
        return found

    def _called(self) -> list[Node]:
        reader, found = Reader(self.code, self.at), {}
        while reader.next:
            if reader.taken("("):
                continue
            letter = reader.next
            if letter not in "pl" or letter in found:
                raise reader.wrong(
                    "M98 is followed by more than P and L",
                    "LinuxCNC ignores it: give it a line of its own",
                )
            reader.at += 1
            found[letter] = reader.value()
        if "p" not in found:
            raise Refusal(
                "M98 without P",
                "P says which program is called",
                *self.code.span(0, len(self.code.text)),
            )
        return [found[letter] for letter in "pl" if letter in found]


def read(line: bytes) -> Block | Control:
    """What a line is. Raises Refusal where it is neither."""
    code = compact(line)
    reader = Reader(code)
    reader.taken("/")
    sequence = SEQUENCE.match(code.text, reader.at)
    if sequence:
        reader.at = sequence.end()
    fanuc = FANUC.match(code.text, reader.at)
    if fanuc:
        return Control(fanuc[0], code, fanuc.end())
    if reader.next == "o":
        return _o_word(reader)
    return _block(line, reader)


def _o_word(reader: Reader) -> Control:
    """An O line: its number (also an expression) or <name>, and its keyword. Raises Refusal."""
    start = reader.at
    reader.at += 1
    plain = False
    if reader.next == "<":
        name = reader.name()
        label: Callable[[Scope], str] = lambda scope: name  # noqa: E731
    else:
        literal = NUMBER.match(reader.text, reader.at)
        plain = bool(literal)
        value = reader.value()
        label = lambda scope: str(whole(value(scope), "an O number"))  # noqa: E731
    found = KEYWORD.match(reader.text, reader.at)
    if found:
        return Control(found[0], reader.code, found.end(), label)
    # O100 alone is the begin of a Fanuc-style program; anything else behind it is a slip
    if reader.next not in ("", "("):
        raise Refusal(
            "this O-word has no keyword that LinuxCNC knows",
            "they are sub endsub call return if elseif else endif while endwhile do repeat"
            " endrepeat break continue",
            *reader.code.span(start, reader.at + 1),
        )
    return Control("", reader.code, reader.at, label, plain)


def _block(line: bytes, reader: Reader) -> Block:
    """A line of words, comments and assignments: what of it must be worked out or taken out. Raises
    Refusal."""
    code = reader.code
    block = Block(line)
    for start, stop in code.comments:
        comment = line[start:stop].lower()
        block.active |= bool(ACTIVE.match(comment))
        if STOPS.match(comment):
            reason = line[start:stop].strip(b"()").split(b",", 1)[1].strip().decode("latin-1")
            raise Refusal(
                f"the program ends itself here: {reason}",
                "it found something wrong in its values",
                start,
                stop,
            )
        if PYTHON.match(comment) and (comment[:1] == b"(" or not start):
            raise Refusal(
                "this comment runs Python in the control",
                "gcomp can not: write out what it does",
                start,
                stop,
            )
    while reader.next:
        start = reader.at
        letter = reader.next
        if reader.taken("("):
            continue
        if letter == "#":
            block.edits.append(_assignment(reader))
            continue
        if letter not in LETTERS:
            raise reader.wrong(
                f"{letter!r} begins no word", "LinuxCNC reads a letter and its value, or #..=.."
            )
        reader.at += 1
        first = reader.at
        literal = NUMBER.match(reader.text, first)
        value = reader.value()
        block.letters += letter
        if letter in "gm":
            block.codes.append((letter, value))
        # a number as it is written keeps its bytes; only what was worked out is an edit
        if not literal:
            block.edits.append(Edit(*code.span(first, reader.at), letter, value))
    return block


def _assignment(reader: Reader) -> Edit:
    """#..=..; reading has come to the #."""
    start = reader.at
    reader.at += 1
    target: str | Node = reader.name() if reader.next == "<" else reader.value()
    reader.need("=", "behind the parameter: a line sets it with #..=..")
    value = reader.value()
    return Edit(*reader.code.span(start, reader.at), "", value, target)
