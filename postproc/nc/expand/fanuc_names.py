"""Programs of a Fanuc by their names: <GROOVE> begins one, M98 <GROOVE> L2 calls it.

Fanuc B-64484EN (30i), "Program name" (up to 32 characters) and "Subprogram (M98, M99)". A called
name that the text holds becomes a number which no program has; the first one stays, since it is the
main program's. Other names stay too, and are refused where they are read.
"""

from __future__ import annotations

import re
from dataclasses import replace

from postproc.nc.comments import COMMENTS
from postproc.nc.expand import Program

FIRST = 900_000_000  # O numbers have eight digits at most
HEAD = re.compile(rb"(?m)^[ \t]*<([^<>\n]{1,32})>(?=[ \t]*\r?$)")
CALL = re.compile(rb"M[ \t]*0*98[ \t]*<([^<>\n]{1,32})>", re.IGNORECASE)


def numbered(program: Program, semicolon: str) -> Program:
    """The program with numbers for the names of its subprograms, line for line."""
    if b"<" not in program.text:
        return program
    code = COMMENTS[semicolon].sub(lambda found: _blank(found[0]), program.text)
    heads = list(HEAD.finditer(code))
    # nothing but the tape mark before it: the name of the main program, which no one calls
    if heads and not code[: heads[0].start()].strip(b" \t\r\n%"):
        heads.pop(0)
    numbers: dict[bytes, bytes] = {}
    for found in heads:
        numbers.setdefault(found[1], b"%d" % (FIRST + len(numbers)))
    changes = [(found.span(), b"O" + numbers[found[1]]) for found in heads]
    changes += [
        (found.span(), b"M98 P" + numbers[found[1]])
        for found in CALL.finditer(code)
        if found[1] in numbers
    ]
    text, at = b"", 0
    for (start, stop), by in sorted(changes):
        text, at = text + program.text[at:start] + by, stop
    return replace(program, text=text + program.text[at:])


def _blank(comment: bytes) -> bytes:
    return re.sub(rb"[^\n]", b" ", comment)
