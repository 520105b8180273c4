"""Which control a program is written for, told by what its text requires and by what it excludes.

Every dialect says what its programs show and others do not (`signs`, `remarks`): what the text
*requires*. It *excludes* a dialect by codes that the control has not, by letters that mean nothing
to it, by how `;` and ( ) are used, and by what its file lists (`excludes`). Programs of plain G0
and G1 fit many dialects, and then many names come back, with nothing for any of them. `better` is
what a hint needs: another dialect, and what it reads that the one in use does not.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache

from postproc.nc import dialects
from postproc.nc.codes import code_number
from postproc.nc.dialects import Dialect

HEAD = 65_536  # bytes that are looked at
LONGEST = 2_000  # characters of a line that are looked at: no control reads as many
MOST = 60  # characters of evidence shown
COMMENT = re.compile(r"\([^()\n]*\)|;[^\n]*")
CODE = re.compile(r"(?<![A-Z_$#<\"])([GM])[ \t]*(\d{1,4}(?:\.\d)?)(?![\d.]*[A-Z_]{2})")
# What stands before a code that no blank sets apart: N4T006M06, X0.0Y0.G00, whole words each.
BEFORE = re.compile(r"(?<![A-Z0-9_$#<.\"])(?:[A-Z][-+]?[0-9.]+)*\Z")
EXTRUDES = re.compile(r"^[ \t]*(?:N\d+[ \t]*)?G0?[01]\b[^\n]*(?<![A-Z0-9._])E-?\.?\d", re.MULTILINE)
BLOCK_ENDS = re.compile(r";[ \t\r]*$", re.MULTILINE)
REMARK = re.compile(
    r";[ \t]*[A-Z][A-Z]+\b(?![ \t]*[=(])|;[ \t]*[-=*#_]{3}|^[ \t]*;[ \t]*\S", re.MULTILINE
)
ROUND = re.compile(r"(?:^|[ \t])\([^()\nA-Z]*[A-Z][^()\n]*\)", re.MULTILINE)
BARE = re.compile(r"^[ \t]*(?:N\d+[ \t]*)?[XYZ][ \t]*[-+]?\.?\d", re.MULTILINE)
ACROSS = re.compile(r"(?<![A-Z0-9_])Y[ \t]*[-+]?\.?\d|(?<=\d|\.)Y[ \t]*[-+]?\.?\d")
# What is left of the last word that a pattern found: of X=IC(5) behind X=I, of P200 behind P2.
ASSIGNED, VALUE = re.compile(r"=[ \t]*[^\s=]?\Z"), re.compile(r"[-+A-Z0-9.]*(?:\([^()\n]*\))?")
NUMBER = re.compile(
    r"(?<=[A-Z])[ \t]*[-+]?[0-9][0-9.]*|(?<=[A-Z])[ \t]*[-+]?\.[0-9]+|(?<=[0-9.])[0-9.]+"
)
# M codes that a machine's builder may have added; unknown ones that are named
FEW, MOST_NAMED = 2, 5
MANY = 0.5  # share of lines that end in ; where it is the end of a block


class Text:
    """A program's first part, upper case, and without its comments."""

    def __init__(self, text: bytes):
        written = text[:HEAD].decode("latin-1").replace("\r", "")
        # the last line may be cut in the middle of a word
        if len(text) > HEAD:
            written = written[: written.rfind("\n") + 1]
        written = "\n".join(line[:LONGEST] for line in written.split("\n"))
        head = written.upper()
        self.whole, self.written = head, written.split("\n")
        self.code = COMMENT.sub(" ", COMMENT.sub(_blank, head))
        self.remarks = "\n".join(COMMENT.findall(head))
        self.lines = max(1, sum(1 for line in head.split("\n") if line.strip()))
        self.codes: dict[str, list[tuple[int, int, str]]] = {"G": [], "M": []}
        self.found: dict[tuple[str, str], re.Match[str] | None] = {}
        seen: set[tuple[str, int]] = set()
        for match in CODE.finditer(self.code):
            letter, number = match[1], code_number("G" + match[2])
            if (letter, number) not in seen and self._apart(match.start()):
                seen.add((letter, number))
                self.codes[letter].append((number, match.start(), f"{letter}{match[2]}"))

    def _apart(self, at: int) -> bool:
        """Whether a code begins a word: behind a blank, or behind the words of a block."""
        if at == 0 or self.code[at - 1] not in "0123456789.":
            return True
        return bool(BEFORE.search(self.code, self.code.rfind("\n", 0, at) + 1, at))

    def search(self, pattern: re.Pattern[str], part: str = "code") -> re.Match[str] | None:
        """The first place of a pattern; several dialects ask for the same one."""
        key = (part, pattern.pattern)
        if key not in self.found:
            self.found[key] = pattern.search(getattr(self, part))
        return self.found[key]

    def quoted(self, match: re.Match[str], line: int) -> str:
        """What a pattern found, to the end of its last word, and in the case in which it stands in
        its line."""
        found, own = match[0].strip(), self.written[line - 1]
        at = own.upper().find(found)
        if at < 0:
            return _short(found)
        rest = (VALUE if ASSIGNED.search(found) else NUMBER).match(own.upper(), at + len(found))
        return _short(own[at : rest.end() if rest else at + len(found)])

    def line(self, offset: int, text: str = "") -> int:
        """The number of the line, from 1, at an offset into a text."""
        return (text or self.whole).count("\n", 0, offset) + 1


def _blank(comment: re.Match[str]) -> str:
    return " " if comment[0].startswith("(") else ""


def recognise(text: bytes) -> list[tuple[str, list[str]]]:
    """Names of the dialects that a program may be written in, most likely first, with the evidence
    for each. Several with as much evidence as the first can not be told apart. Empty: this shows no
    program of any."""
    shown = Text(text)
    coded = bool(shown.codes["G"] or shown.codes["M"])
    if not coded and b"\0" in text[:HEAD]:
        return []
    found = []
    for name in dialects.names():
        dialect = dialects.load(name)
        # One point for each sign, one less for each thing that speaks against it: a program that
        # breaks one rule of its own control is still known by the others.
        evidence = [*_signs(shown, dialect), *_layout(shown, dialect)]
        found.append((len(evidence) - len(list(against(shown, dialect))), name, evidence))
    best = max(score for score, _, _ in found)
    winners = sorted(
        ((name, evidence) for score, name, evidence in found if score == best),
        key=lambda row: (-len(row[1]), row[0]),
    )
    most = len(winners[0][1])
    if best <= 0 and not most and not coded:
        return []
    found.sort(key=lambda row: (-row[0], row[1]))
    # Behind those that fit best the ones that fit less, but only with less evidence than these
    # have: one with as much, and more against it, would be counted as not to be told apart
    # (between).
    return winners + [
        (name, evidence)
        for score, name, evidence in found
        if 0 < score < best and len(evidence) < most
    ]


def between(text: bytes) -> list[str]:
    """The dialects that a program fits equally well: one name where it is clear, several where it
    can not be told."""
    found = recognise(text)
    return [name for name, evidence in found if len(evidence) == len(found[0][1])]


def better(text: bytes, name: str) -> tuple[str, str] | None:
    """Another dialect than `name` that the text is clearly of, and what it requires that `name` has
    not; None where there is none, or several."""
    found = recognise(text)
    if not found or name in (n for n, evidence in found if len(evidence) >= len(found[0][1])):
        return None
    first, evidence = found[0]
    if sum(len(e) == len(evidence) for _, e in found) > 1:
        return None
    shown = Text(text)
    own = {*_signs(shown, dialects.load(name)), *_layout(shown, dialects.load(name))}
    reason = next((e for e in evidence if e not in own), None)
    return None if reason is None else (first, reason)


def only_passed(text: bytes, dialect: Dialect, other: Dialect) -> bool:
    """Whether the text has an M code that `dialect` refuses and `other` does not know: there it
    passes, with a notice, though it may move an axis or run other text."""
    return any(
        number // 10 in dialect.m_refuses
        and number // 10 not in other.m_codes
        and number // 10 not in other.m_refuses
        for number, _, _ in Text(text).codes["M"]
    )


def against(shown: Text, dialect: Dialect) -> Iterator[str]:
    """What speaks against a dialect."""
    has = _spelled(dialect.name)
    for number, at, word in shown.codes["G"]:
        if number not in has:
            yield f"it has no {word} (line {shown.line(at, shown.code)})"
    known = {*dialect.m_codes, *dialect.m_refuses}
    # a machine's builder adds M codes of his own: a few unknown ones say nothing
    strange = [word for number, _, word in shown.codes["M"] if number // 10 not in known]
    if len(strange) > FEW:
        yield f"it knows no {', '.join(strange[:MOST_NAMED])}"
    for pattern, what, speaks in (
        (EXTRUDES, "E in a motion", not dialect.carried),
        (BARE, "a motion without its code", not dialect.modal_motion),
        (ACROSS, "Y", dialect.plane == 180),
    ):
        match = shown.search(pattern) if speaks else None
        if match:
            yield f"{what} (line {shown.line(match.start(), shown.code)})"
    for pattern in _patterns(dialect.excludes):
        match = shown.search(pattern)
        if match:
            line = shown.line(match.start(), shown.code)
            yield f"{shown.quoted(match, line)} (line {line})"
    yield from _against_grammar(shown, dialect)


def _against_grammar(shown: Text, dialect: Dialect) -> Iterator[str]:
    """Block ends and comments that are not the dialect's."""
    if dialect.block_end and not re.search(
        rf"{re.escape(dialect.block_end)}[ \t]*$", shown.code, re.MULTILINE
    ):
        yield f"no block ends in {dialect.block_end}"
    if dialect.grammar.semicolon != "comment":
        remark = shown.search(REMARK, "whole")
        if remark:
            yield f"; begins a remark (line {shown.line(remark.start())})"
    if not dialect.grammar.parentheses and shown.search(ROUND, "whole"):
        yield "( ) are comments"


def _signs(shown: Text, dialect: Dialect) -> Iterator[str]:
    for pattern in _patterns(dialect.signs):
        match = shown.search(pattern)
        if match:
            line = shown.line(match.start(), shown.code)
            yield f"{shown.quoted(match, line)} in line {line}"
    for pattern in _patterns(dialect.remarks):
        match = shown.search(pattern, "remarks")
        if match:
            yield f"{_short(match[0])} in a remark"


def _layout(shown: Text, dialect: Dialect) -> Iterator[str]:
    if (
        dialect.grammar.semicolon != "comment"
        and len(BLOCK_ENDS.findall(shown.whole)) > MANY * shown.lines
    ):
        yield "lines end in ;"


def _short(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= MOST else text[: MOST - 3] + "..."


@lru_cache
def _patterns(texts: tuple[str, ...]) -> tuple[re.Pattern[str], ...]:
    return tuple(re.compile(text, re.MULTILINE) for text in texts)


@lru_cache
def _spelled(name: str) -> frozenset[int]:
    """Ten times the G numbers that a dialect has, as written."""
    return frozenset(code_number(code.word) for code in dialects.load(name).codes)
