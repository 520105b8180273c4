"""Other spellings of a word, brought to the one that the lexer reads: a letter, then a number, at
the same places.

X=5 is X5, X=IC(5) a distance whatever G90 G91 say, X=AC(5) a place; CR=5 is R5; TRANS is a code
that is a word by itself. Every byte keeps its place, so what is written back lands where it was
read. Sources: Siemens 840D Programming Guide Fundamentals, "Extended address" and "AC, IC"; Marlin
and RepRap G-code documentation.
"""

from __future__ import annotations

import re
from functools import lru_cache, partial

from postproc.expressions import expression
from postproc.nc import checksums
from postproc.nc.grammar import (
    ABSOLUTE,
    AXES,
    HOMING,
    KEYWORD_LETTER,
    MACRO,
    PARAMETER,
    RELATIVE,
    UNKNOWN_FEED,
    Grammar,
)
from postproc.nc.grammar import BARE as ALONE

NUMBER = rb"[ \t]*[+-]?[ \t]*(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
#   G1 X=IC(5) CR=7.5 Y=AC(-3)
#   G1 r    5  R  7.5 a    -3      r and a: one byte each, RELATIVE of X and ABSOLUTE of Y
#
# Not behind a letter, a digit or a bracket: the X of MAX=5 and of AX[X]=5 is no axis word.
ASSIGNED = expression(
    rb"(?<![A-Za-z0-9_$\].])([A-Za-z])[ \t]*=(?:[ \t]*(IC|AC|DC|ACP|ACN)[ \t]*\(("
    + NUMBER
    + rb")[ \t]*(\))|("
    + NUMBER
    + rb"))",
    re.IGNORECASE,
)
# T="MILL 8": a name, no number
NAMED = expression(rb"(?<![A-Za-z0-9_$\]])[A-Za-z][0-9]?[ \t]*=[ \t]*\"[^\"\n]*\"")
ARGUMENTS = rb"(?![A-Za-z0-9_=])(?:[ \t]*\((?:\"[^\"\n]*\"|[^()\"\n]|\([^()\n]*\))*\))?"
MOVELESS = expression(  # T0 R: the parser of Marlin takes letters without a value
    rb"(?m)^[ \t]*(?:[Nn][ \t]*[0-9]+[ \t]*)?(?:(?:[Gg]["
    rb" \t]*(?!0*(?:[01235]|92)(?![0-9]))[0-9]|[Mm])[^\n]*|[Tt][ \t]*[0-9][^\nGg]*$)"
)
BARE = expression(rb"(?<![A-Za-z])[A-Za-z](?=[ \t]*(?:[A-Za-z]|\r?$))")
SETTINGS = expression(rb"[D-FH-MO-TQ][ \t]*[+-]?[0-9.]+", re.IGNORECASE)  # of homing: R5, P0 T300
TOGETHER = expression(rb"[A-Za-z](?=[ \t]*(?:[A-Za-z]|\r?$))")  # G28 XY
HOME = expression(rb"[ \t]*(?:[Nn][ \t]*[0-9]+[ \t]*)?[Gg][ \t]*0*28(?![0-9.])")
# F#5, S#<_hal[spindle-speed]>, F[#<feed> * 2]: brackets may nest once.
MACHINE_KNOWS = expression(
    rb"(?<![A-Za-z0-9_<#])([FfSs])[ \t]*(?:#[ \t]*(?:[0-9]+|<[^>\n]*>|\[[^\[\]\n]*\])|"
    rb"\[(?:[^\[\]\n]|\[[^\[\]\n]*\])*\])"
)
MARKS = bytes(range(0x80, 0x100))
REPLACED = bytes.maketrans(MARKS, b"\xff" * len(MARKS))


def _assignments(code: bytes, grammar: Grammar) -> bytes:
    """X=IC(5), AX[X]=5 and the like."""
    code = NAMED.sub(_named, code)
    for pattern, letter in _spelled(grammar):
        code = pattern.sub(partial(_stands, letter), code)
    return ASSIGNED.sub(_assigned, code)


# Whole: one spelling after the other, each where the grammar has it.
def respelled(code: bytes, grammar: Grammar) -> bytes:
    """The text with every other spelling brought to letter and number, byte for byte as long."""
    # One after the other, from whole lines down to letters: what a line runs or leaves out
    # (statements, checksums, remarks, macros) is gone before single words are looked at.
    # the letters that stand for spellings are none of the program's own
    code = code if code.isascii() else code.translate(REPLACED)
    if grammar.klartext:
        from postproc.nc import klartext

        code = klartext.respelled(code)
    if grammar.checksums and b"*" in code:
        code = checksums.cover(code)
    for pattern in _ignored(grammar.ignores):
        code = pattern.sub(_blank, code)
    if grammar.homing:
        code = _ignored((grammar.homing,))[0].sub(_homes, code)
    for pattern, number in _macros(grammar.macros):
        code = pattern.sub(partial(_macro, number), code)
    for text, letter in grammar.letters:
        code = _ignored((text,))[0].sub(partial(_lettered, letter), code)
    if grammar.machine_variables and (b"#" in code or b"[" in code):
        code = MACHINE_KNOWS.sub(_machine_variable, code)
    if grammar.bare_letters:
        code = MOVELESS.sub(_without_bare, code)
    if grammar.assigns and b"=" in code:
        code = _assignments(code, grammar)
    words = _keywords(grammar.keywords)
    if words is not None:
        code = words[0].sub(lambda m: words[1][m[1].upper()].ljust(len(m[0])), code)
    return code


@lru_cache
def _ignored(texts: tuple[str, ...]) -> tuple[re.Pattern[bytes], ...]:
    return tuple(re.compile(text.encode(), re.IGNORECASE | re.MULTILINE) for text in texts)


def _lettered(letter: str, match: re.Match[bytes]) -> bytes:
    """The match with another letter in its group."""
    at = match.start(1) - match.start()
    return match[0][:at] + letter.encode() + match[0][at + 1 :]


def _homes(match: re.Match[bytes]) -> bytes:
    return bytes([HOMING]).ljust(len(match[0]))


@lru_cache
def _macros(macros: tuple[tuple[str, int], ...]) -> tuple[tuple[re.Pattern[bytes], int], ...]:
    patterns = _ignored(tuple(text for text, _ in macros))
    return tuple(zip(patterns, (number for _, number in macros), strict=True))


@lru_cache
def _spelled(grammar: Grammar) -> tuple[tuple[re.Pattern[bytes], bytes], ...]:
    """Spellings such as CR= with the letter that they stand for, "" for a parameter that moves
    nothing."""
    result = []
    for spelling, letter in grammar.spellings:
        name = re.escape(spelling.rstrip("=").encode())
        stands = letter.encode() or bytes([PARAMETER])
        result.append(
            (
                re.compile(
                    rb"(?<![A-Za-z0-9_$])" + name + rb"[ \t]*=(?=" + NUMBER + rb")", re.IGNORECASE
                ),
                stands,
            )
        )
    return tuple(result)


@lru_cache
def _keywords(keywords: tuple[str, ...]) -> tuple[re.Pattern[bytes], dict[bytes, bytes]] | None:
    """A pattern for all keywords, and what each is read as: KEYWORD_LETTER and its number."""
    if not keywords:
        return None
    from postproc.nc.codes import KEYWORD, code_number

    read = {
        k.encode(): bytes([KEYWORD_LETTER]) + b"%d" % (code_number(k) - KEYWORD) for k in keywords
    }
    long = [word for word, number in read.items() if len(number) > len(word)]
    if long:  # all that stands behind one would be read, and written, beside its place
        raise ValueError(f"no room for the numbers of the keywords {long}")
    every = b"|".join(re.escape(k) for k in sorted(read, key=len, reverse=True))
    return re.compile(rb"(?<![A-Za-z_$])(" + every + rb")" + ARGUMENTS, re.IGNORECASE), read


def _blank(match: re.Match[bytes]) -> bytes:
    """As many blanks; what the pattern's group holds stays."""
    if not match.re.groups or match[1] is None:
        return b" " * len(match[0])
    return b" " * (match.start(1) - match.start()) + match[1] + b" " * (match.end() - match.end(1))


def _named(match: re.Match[bytes]) -> bytes:
    """A tool with a name is some tool; what else has a name is no number."""
    if match[0][:1].upper() == b"T":
        return b"T9999"[: len(match[0])].ljust(len(match[0]))
    return b" " * len(match[0])


def _stands(letter: bytes, match: re.Match[bytes]) -> bytes:
    return letter + b" " * (len(match[0]) - 1)


def _without_bare(match: re.Match[bytes]) -> bytes:
    """Homing, M and T have letters without a number; which ones G28 names says what it moves."""
    home = HOME.match(match[0])
    if home:
        behind = SETTINGS.sub(_blank, match[0][home.end() :])
        return home[0] + TOGETHER.sub(_named_alone, behind)
    return BARE.sub(b" ", match[0])


def _named_alone(match: re.Match[bytes]) -> bytes:
    letter = match[0].decode().upper()
    return bytes([ALONE + AXES.index(letter)]) if letter in AXES else b" "


def _macro(number: int, match: re.Match[bytes]) -> bytes:
    """One word that stands for the text behind a name: MACRO, and the number of the reason why
    not."""
    begin = match.end(1) if match.re.groups and match[1] else match.start()
    kept, text = match[0][: begin - match.start()], match[0][begin - match.start() :]
    blank = text[: len(text) - len(text.lstrip())]
    word = bytes([MACRO]) + (b"%d" % number if number else b"")
    if len(word) > len(text) - len(blank):  # no room for it: it is no word of this control
        return match[0]
    return kept + blank + word.ljust(len(text) - len(blank))


def _machine_variable(match: re.Match[bytes]) -> bytes:
    """S is gone, F a word without a number."""
    return (b" " if match[1].upper() == b"S" else bytes([UNKNOWN_FEED])).ljust(len(match[0]))


def _assigned(match: re.Match[bytes]) -> bytes:
    letter = match[1].upper()
    how = (match[2] or b"").upper()
    if how and letter.decode() in AXES:
        letter = bytes([(RELATIVE if how == b"IC" else ABSOLUTE) + AXES.index(letter.decode())])
    # AC() of no axis (S=AC(5)) stays as it stands, and is refused as text
    elif how:
        return match[0]
    begin, stop = match.span(3) if how else match.span(5)
    return (
        letter
        + b" " * (begin - match.start() - 1)
        + match.string[begin:stop]
        + b" " * (match.end() - stop)
    )
