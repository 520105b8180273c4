"""Several statements in one block of a Haas: where each of them begins.

Haas Mill Operator's Manual (2017, next generation control), "Macros": "a GOTO command can be used
on the same line as other G-codes. The GOTO is executed after any other commands"; `G00 X0 Y0 [#1 EQ
#2] M99 P5`, where "the conditional is for the M99 portion of the statement only"; `IF [#1 GE 180]
THEN #101=0.0 M99`, and "if a conditional evaluates to FALSE, then the remainder of the IF block is
ignored".
"""

from __future__ import annotations

import re
from itertools import pairwise

from postproc.nc.expand import Refusal
from postproc.nc.expand.fanuc_blocks import HEAD, BlockReader, bare
from postproc.nc.expand.fanuc_expressions import NUMBER, Reader

BEGINS = re.compile(r"[#\[]|GO(?:TO)?N?[\d#\[]|IF\[|WH(?:ILE)?\[|DO\d|END\d", re.ASCII)
LOOP = re.compile(r"(?:DO|END)\d", re.ASCII)
JUMP = re.compile(r"GO(?:TO)?N?", re.ASCII)
THEN = re.compile(r"TH(?:EN)?")
SKIP = re.compile(rb"[ \t]*(?:[Nn][ \t0-9]*)?(/[1-9]?)")


class NoStatement(Exception):
    """What stands there is none: the block itself says why."""


def parts(raw: bytes, semicolon: str) -> list[bytes]:
    """The statements of a block, each with what stands behind it: one, where the block is read as
    it stands or can not be read so either."""
    try:
        BlockReader(raw, semicolon, True).block()
    except Refusal:
        #   G00 X0 Y0 [#1 EQ #2] M99 P5      cut before each statement that follows another; each
        #   G00 X0 Y0 | [#1 EQ #2] M99 P5    piece gets the block delete of the whole
        code, at = bare(raw, semicolon)
        try:
            starts = _starts(code)
        except (Refusal, NoStatement):
            return [raw]
        skip = SKIP.match(raw)
        edges = [0, *(at[k] for k in starts), len(raw)]
        pieces = [raw[a:b] for a, b in pairwise(edges)]
        first, *more = [*(piece.rstrip(b" \t") for piece in pieces[:-1]), pieces[-1]]
        return [first, *((skip[1] if skip else b"") + piece for piece in more)]
    return [raw]


def _starts(code: str) -> list[int]:
    """Where every statement but the first begins."""
    head = HEAD.match(code)
    at = _behind(code, head.end() if head else 0)
    starts = []
    while at < len(code):
        starts.append(at)
        at = _behind(code, at)
    return starts


def _behind(code: str, at: int) -> int:
    """Where the statement that begins at `at` ends. Raises Refusal or NoStatement."""
    reader = Reader(code, at, haas=True)
    if code.startswith("#", at):
        reader.number_of_variable()
        if not code.startswith("=", reader.at):
            raise NoStatement
        reader.at += 1
        reader.expression()
        return reader.at
    if code.startswith(("IF[", "["), at):
        reader.at = code.index("[", at)
        reader.bracketed()
        then = THEN.match(code, reader.at)
        return _behind(code, then.end() if then else reader.at)
    if code.startswith(("WHILE[", "WH["), at):
        reader.at = code.index("[", at)
        reader.bracketed()
        at = reader.at
    if loop := LOOP.match(code, at):
        return loop.end()
    if BEGINS.match(code, at) and (jump := JUMP.match(code, at)):
        return _value(code, jump.end())
    return _words(code, at)


def _words(code: str, start: int) -> int:
    at = start
    while at < len(code) and (at == start or not BEGINS.match(code, at)):
        at += code[at] == ","
        if not code[at : at + 1].isalpha():
            raise NoStatement
        at += 1
        at = _value(code, at + (code[at : at + 1] in ("+", "-")))
    return at


def _value(code: str, at: int) -> int:
    """Behind a number, a variable or an expression in brackets."""
    if digits := NUMBER.match(code, at):
        return digits.end()
    reader = Reader(code, at, haas=True)
    reader.value()
    return reader.at
