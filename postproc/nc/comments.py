"""What of a program's text is no word: comments, and what block delete drops.

It is blanked, byte for byte, before the lexer looks for words; other spellings are brought to
letter and number there.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache

from postproc.nc.faults import LONE, LONE_RETURN
from postproc.nc.grammar import Grammar

NUMBER_FOLLOWS = re.compile(rb"[ \t\r]*[0-9.+-]")
COMMENTS = {
    "comment": re.compile(rb"\([^()\n]*\)|;[^\n]*"),
    "end of block": re.compile(rb"\([^()\n]*\)"),
}
SKIPPED = {
    "comment": re.compile(rb"(?m)^([ \t]*/)[^\n]*"),
    "end of block": re.compile(rb"(?m)((?:^|;)[ \t]*/)[^;\n]*"),
}
# Of a block: up to a slash within it, and what stands behind; none behind a bracket or a variable,
# where it divides, and none before a number, which would become part of the word before.
WITHIN = re.compile(
    rb"(?im)((?:^|;)(?:[ \t]*/)?[ \t]*[^][#;/\s][^][#;/\n]*)/"
    rb"([ \t\r]*(?:[A-Z][^][#;/\n]*)?)(?![^;\n])"
)
AFTER_SEMICOLON = re.compile(rb";[^\n]*")
STRINGS = re.compile(rb'"[^"\n]*"')
BESIDE_STRINGS = re.compile(rb'("[^"\n]*")|;[^\n]*')  # MSG("a;b") holds no comment


@cache
def _respelled() -> Callable[[bytes, Grammar], bytes]:
    """What brings other spellings to letter and number: its expressions cost start-up."""
    from postproc.nc.spellings import respelled

    return respelled


def uncommented(text: bytes, grammar: Grammar) -> bytes:
    """The text, byte for byte as long, with its comments blanked."""
    semicolon = grammar.semicolon
    if b"(" not in text and not (semicolon == "comment" and b";" in text):
        return text
    if grammar.parentheses:
        return COMMENTS[semicolon if b";" in text else "end of block"].sub(_blank, text)
    if semicolon != "comment":
        return text
    if b'"' in text:
        return BESIDE_STRINGS.sub(lambda found: found[1] or _blank(found), text)
    return AFTER_SEMICOLON.sub(_blank, text)


def code_alone(text: bytes, grammar: Grammar) -> bytes:
    """The text, byte for byte as long, without its comments and what stands in strings: what a
    search for words must not read."""
    code = uncommented(text, grammar)
    return STRINGS.sub(lambda found: b" " * len(found[0]), code) if b'"' in code else code


def without_comments(text: bytes, grammar: Grammar, drop: bool) -> tuple[bytes, bool, int]:
    """The text, byte for byte as long, with comments and what block delete drops blanked and other
    spellings brought to letter and number; whether that was looked for; and the offset of the first
    slash within a block, -1: none. A newline ends it."""
    # Comments first, for a slash or an equals sign in one means nothing; then what is not executed,
    # for nothing in it need be readable; other spellings last. Every byte keeps its place: offsets
    # into `code` are offsets into the program.
    code, within = uncommented(text, grammar), -1
    if drop and b"/" in code:
        code = SKIPPED[grammar.semicolon].sub(_only_slash, code)
    if grammar.slash_within and b"/" in code:
        found = WITHIN.search(code)
        within = found.end(1) if found else -1
        code = WITHIN.sub(_only_slash if drop else _both, code)
    spelled = grammar.is_respelled or (grammar.machine_variables and (b"#" in code or b"[" in code))
    if spelled:
        code = _respelled()(code, grammar)
    if b"\r" in code and code.count(b"\r") != code.count(b"\r\n"):
        # as a blank, which it is elsewhere, it would join two lines of an old Macintosh's file in
        # silence
        code = LONE_RETURN.sub(bytes([LONE]), code)
    return code if code.endswith(b"\n") else code + b"\n", spelled, within


def _blank(comment: re.Match[bytes]) -> bytes:
    """As many blanks; but a comment before a digit breaks a number in two, and stays, to be
    refused."""
    end = comment.end()
    if NUMBER_FOLLOWS.match(comment.string, end):
        return comment[0]
    return b" " * (end - comment.start())


def _only_slash(block: re.Match[bytes]) -> bytes:
    """A block without what is skipped of it."""
    # the slash stays: by it the lexer knows that the block is skipped
    return block[1] + b" " * (block.end() - block.end(1))


def _both(block: re.Match[bytes]) -> bytes:
    """A block without the slash in it."""
    return block[1] + b" " + block[2]
