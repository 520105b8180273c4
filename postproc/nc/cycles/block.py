"""One block as words with their places, so that some can be taken out or changed and all other text
stays as it stood."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

from postproc.nc.codes import code_number
from postproc.nc.grammar import Grammar

# Blanks may stand within a number (X1 2. 5 is X12.5): NIST RS274/NGC 3.3.
_DIGITS = rb"[0-9](?:[ \t]*[0-9])*"
_NUMBER = (
    rb"[+-]?[ \t]*(?:"
    + _DIGITS
    + rb"(?:[ \t]*\.(?:[ \t]*"
    + _DIGITS
    + rb")?)?|\.[ \t]*"
    + _DIGITS
    + rb")"
)
_ARGUMENTS = rb"(?:[ \t]*\((?:\"[^\"\n]*\"|[^()\"\n]|\([^()\n]*\))*\))?"
_STRING = re.compile(rb"(?<![A-Za-z0-9_])[A-Za-z][0-9]?[ \t]*=[ \t]*\"[^\"\n]*\"")  # T="MILL 8"
_HIDDEN = b"\x01"  # in place of a comment's characters: no number goes on behind it
_HELD = rb"(?P<held>AC|IC)[ \t]*\([ \t]*(?P<inner>" + _NUMBER + rb")[ \t]*\)"
_BLANK = b" \t\r"
_BETWEEN = _BLANK + _HIDDEN  # words
LARGEST = 1e9  # a greater number is none that a control reads
LONGEST_WORD = 100  # characters; a longer one is no number that a control reads


class Word(NamedTuple):
    """`letter` in capitals (a whole name for CR=, AP=; a keyword such as ROT has no `value`), the
    number as it is written (`raw`), its place in the text, and for X=IC(5) the mode "IC" or
    "AC"."""

    letter: str
    value: float | None
    raw: str
    start: int
    stop: int
    mode: str = ""


class _Patterns(NamedTuple):
    """What a comment is, a word, and what holds no words of a motion, though it looks like
    some."""

    comment: re.Pattern[bytes]
    word: re.Pattern[bytes]
    ignored: tuple[re.Pattern[bytes], ...]


@lru_cache
def _patterns(grammar: Grammar) -> _Patterns:
    comments = [rb"\([^()\n]*\)"] if grammar.parentheses else []
    if grammar.semicolon == "comment":
        comments.append(rb";[^\n]*")
    # No letter, digit or = may follow, or a variable that begins like a keyword would be one.
    names = [re.escape(name.encode()) for name in sorted(grammar.keywords, key=len, reverse=True)]
    keyword = rb"(?P<keyword>(?:" + b"|".join(names) + rb"))(?![A-Za-z0-9_=])" + _ARGUMENTS + b"|"
    if not names:
        keyword = rb"(?P<keyword>(?!))|"
    name = (
        rb"(?P<name>[A-Za-z]+[0-9]?)[ \t]*=[ \t]*(?:"
        + _HELD
        + rb"|(?P<assigned>"
        + _NUMBER
        + rb"))|"
    )
    if not grammar.assigns:
        name = rb"(?P<name>(?!))(?P<held>(?!))(?P<inner>(?!))(?P<assigned>(?!))|"
    word = rb"(?P<letter>[A-Za-z])[ \t]*(?P<number>" + _NUMBER + rb")"
    ignored = [re.compile(text.encode(), re.IGNORECASE) for text in grammar.ignores]
    return _Patterns(
        re.compile(b"|".join(comments) or rb"(?!)"),
        re.compile(keyword + name + word, re.IGNORECASE),
        (*ignored, _STRING) if grammar.assigns else tuple(ignored),
    )


def blocks(text: bytes, grammar: Grammar) -> list[bytes]:
    """The blocks of a line: one, or several where the semicolon ends them."""
    if grammar.semicolon != "end of block" or b";" not in text:
        return [text]
    hidden = _patterns(grammar).comment.sub(lambda m: _HIDDEN * len(m[0]), text)
    cuts = [i for i, c in enumerate(hidden) if c == ord(";")]
    parts = [
        text[a:b] for a, b in zip([0, *(c + 1 for c in cuts)], [*cuts, len(text)], strict=True)
    ]
    return [part for part in parts if part.strip()] or [b""]


@dataclass(frozen=True)
class Block:
    """A block cut into words. `plain`: whether words, blanks and comments are all there is; `skip`:
    begins with "/"."""

    text: bytes
    words: tuple[Word, ...]
    plain: bool
    skip: bool

    @staticmethod
    def of(text: bytes, grammar: Grammar) -> Block:
        """Cut a block into words. Never raises."""
        comment, word, ignored = _patterns(grammar)
        # As long as the comment was: places in the hidden text are places in the text itself.
        hidden = comment.sub(lambda m: _HIDDEN * len(m[0]), text)
        for pattern in ignored:
            hidden = pattern.sub(lambda m: _HIDDEN * len(m[0]), hidden)
        words, at, plain = [], 0, True
        # A comment may stand before the slash, and is hidden by now.
        skip = hidden.lstrip(_BETWEEN).startswith(b"/")
        if skip:
            at = hidden.index(b"/") + 1
        while at < len(hidden):
            if hidden[at] in _BETWEEN:
                at += 1
                continue
            found = word.match(hidden, at)
            one = _word(found) if found and len(found[0]) <= LONGEST_WORD else None
            # What is no word may be anything (a variable, a call): the words up to there are kept,
            # but the block is not plain, and nobody rewrites it.
            if found is None or one is None or abs(one.value or 0.0) > LARGEST:
                plain = False
                break
            words.append(one)
            at = found.end()
        return Block(text, tuple(words), plain, skip)

    def get(self, letter: str) -> float | None:
        """The value of the first word with this letter."""
        return next((w.value for w in self.words if w.letter == letter), None)

    def word(self, letter: str) -> Word | None:
        """The first word with this letter."""
        return next((w for w in self.words if w.letter == letter), None)

    @property
    def codes(self) -> list[int]:
        """Ten times each G number, and the numbers of keywords, in the order of the block."""
        return [number for w in self.words if (number := number_of(w)) is not None]

    def m_codes(self) -> list[int]:
        """The numbers of all M words, in the order of the block."""
        return [
            int(w.value)
            for w in self.words
            if w.letter == "M" and w.value is not None and w.value == int(w.value)
        ]

    @property
    def spaced(self) -> bool:
        """Whether words stand apart."""
        return any(self.text[b.start - 1] in _BLANK for b in self.words[1:]) or len(self.words) < 2

    def written(
        self,
        out: set[int],
        new: bytes = b"",
        at: int | None = None,
        changed: dict[int, bytes] | None = None,
    ) -> bytes:
        """The text without the words numbered in `out`, words in `changed` written anew, and `new`
        put in before word `at` (None: where the first word that goes out stood, else behind the
        last word)."""
        changed = changed or {}
        if at is None:
            at = min(out) if out else len(self.words)
        pieces: list[bytes] = []
        last, put = 0, not new
        # The gap before a word goes out with it where it is blank; a comment in the gap stays, as
        # do all other bytes between words.
        for i, w in enumerate(self.words):
            gap = self.text[last : w.start]
            last = w.stop
            if i == at and not put:
                pieces += [gap, self._apart(pieces, gap), new]
                put, gap = True, b" " if self.spaced else b""
                if i in out:
                    continue
            if i in out:
                pieces.append(b"" if not gap.strip(_BLANK) and i else gap)
                continue
            pieces += [gap, changed.get(i, self.text[w.start : w.stop])]
        if not put:
            pieces += [self._apart(pieces, b""), new]
        text = b"".join([*pieces, self.text[last:]])
        lead = len(self.text) - len(self.text.lstrip(_BLANK))
        return (self.text[:lead] + text.lstrip(_BLANK)).rstrip(_BLANK)

    def _apart(self, pieces: list[bytes], gap: bytes) -> bytes:
        """A blank, where words stand apart and none ends the text so far."""
        before = b"".join(pieces) + gap
        blank = not before.strip(_BLANK + b"/") or before[-1:] in (b" ", b"\t")
        return b"" if blank or not self.spaced else b" "


def number_of(word: Word) -> int | None:
    """Ten times the number of a G word, or the number of a keyword; None for other words, -1 for
    what no code can be."""
    if word.letter == "G" and word.value is not None:
        # More than one decimal (G54.15), below 0 or from G1000 on: no code, so it must match no
        # table.
        tenfold = round(word.value * 10)
        return tenfold if abs(tenfold - word.value * 10) < 1e-9 and 0 <= tenfold < 10_000 else -1
    return code_number(word.letter) if word.value is None else None


def without(block: Block, letters: str) -> Block:
    """The block as if words with these letters were not there."""
    return replace(block, words=tuple(w for w in block.words if w.letter not in letters))


def _word(found: re.Match[bytes]) -> Word:
    keyword, name, held, inner, assigned, letter, number = found.groups()
    if keyword:
        return Word(keyword.decode().upper(), None, "", *found.span())
    raw: bytes = (number or inner or assigned).translate(None, _BLANK)
    mode = held.decode().upper() if held else ""
    return Word((name or letter).decode().upper(), float(raw), raw.decode(), *found.span(), mode)
