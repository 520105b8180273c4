"""Line numbers and checksums of a stream as hosts send it to RepRap firmware: `N12 G1 X1 Y2*85 ;
remark`.

The checksum is all bytes before the `*` combined by exclusive or. The receiver wants consecutive
numbers, each with its checksum; M110 sets the number from which it counts. A number without a
checksum before the first line that has both is a CNC program's label, and stays as it is.

Sources: Marlin/src/gcode/queue.cpp (get_serial_commands), RepRapFirmware's StringParser::Put. They
differ in whether blanks before the N count, so a checksum is right either way, and lines that are
written anew have no such blanks.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import reduce
from operator import xor
from typing import NamedTuple

from postproc.expressions import expression

MARK = expression(rb"\*[ \t]*[0-9]{1,9}(?=[ \t\r]*(?:;|\n|\Z))")
LAST_MARK = expression(rb"\*[ \t]*([0-9]{1,9})\Z")
NUMBER = expression(rb"([ \t]*[Nn][ \t]*)([+-]?[0-9]{1,9})(?![0-9.])")
RESET = expression(rb"(?<![A-Z])M110(?![0-9.])", re.IGNORECASE)
LATER_NUMBER = expression(rb"[Nn][ \t]*([+-]?[0-9]{1,9})(?![0-9.])")
COMMENT = expression(rb"\([^()]*\)")
BLANK = b" \t\r"


class Numbering(NamedTuple):
    """What one piece of a stream hands to the next. last: the number that was last written, None
    before the first line that has a number and a checksum; shift: how many lines were added since
    the receiver's count was last set."""

    last: int | None = None
    shift: int = 0


START = Numbering()


def cover(code: bytes) -> bytes:
    """The same text, as long as it was, with blanks in place of checksums, so that the lexer does
    not see them."""
    if b"*" not in code:
        return code
    covered = bytearray(code)
    for _, star, stop in _marks(code):
        covered[star:stop] = b" " * (stop - star)
    return bytes(covered)


def check(text: bytes) -> tuple[int, str] | None:
    """The first line (from 0) whose checksum is wrong, and what it is and should be; None where all
    are right."""
    if b"*" not in text:
        return None
    for start, star, stop in _marks(text):
        code, value = text[start:star], int(text[star + 1 : stop])
        if value not in _right(code):
            message = (
                f"the checksum is *{value}, and the bytes before it give"
                f" *{_xor(code.lstrip(BLANK))}"
            )
            return text.count(b"\n", 0, start), message
    return None


def bare(text: bytes) -> bytes:
    """A whole stream without its numbers and checksums, line by line: of other lines they would be
    wrong. One whose checksums are wrong, or that has none, stays as it is."""
    if b"*" not in text or check(text) is not None:
        return text
    result = bytearray(text)
    for start, star, stop in reversed([*_marks(text)]):
        number = NUMBER.match(text, start)
        del result[star:stop]
        if number:
            del result[start : number.end()]
    return bytes(result)


def renumber(text: bytes, state: Numbering = START) -> tuple[bytes, Numbering]:
    """Corrected lines, with the numbers and checksums that a receiver wants; and what the next
    piece needs.

    `text`: whole lines, only the last of the stream may lack its end. Once a stream has begun, a
    line with words and without N is one that was added: it takes the next number and a checksum,
    and all later numbers are shifted by one, until M110 sets the count anew. A checksum that does
    not fit its line is computed anew; where there was none behind an N, none is invented. Lines
    that need no change, comments and blank lines keep their bytes.
    """
    #   as it came          corrected               as it leaves
    #   N1 G1 X1*96         N1 G1 X1.002*96         N1 G1 X1.002*124    other bytes, another sum
    #                       G1 X1.5                 N2 G1 X1.5*120      put in: the next number
    #   N2 G1 X2*96         N2 G1 X2.001*96         N3 G1 X2.001*126    all behind count on: shift 1
    if state.last is None and b"*" not in text:
        return text, state
    out = []
    for line in text.split(b"\n"):
        new, state = _line(line, state)
        out.append(new)
    return b"\n".join(out), state


def _reset(code: bytes, number: re.Match[bytes] | None, state: Numbering) -> Numbering:
    """The numbering behind M110: the number that stands behind it, or its own."""
    if named := LATER_NUMBER.search(code, number.end() if number else 0):
        return Numbering(int(named[1]), 0)
    return Numbering(int(number[2]), 0) if number else state


def _line(line: bytes, state: Numbering) -> tuple[bytes, Numbering]:
    """One line without its end."""
    body = line.partition(b";")[0].rstrip(BLANK)
    tail = line[len(body) :]
    # a remark is not part of the sum, and its own "*12" is none
    mark = LAST_MARK.search(body)
    code = body[: mark.start()] if mark else body
    number = NUMBER.match(code)
    numbered = state.last is not None or (number is not None and mark is not None)
    if RESET.search(code) and numbered:
        return _sealed(line, code, code, mark, tail), _reset(code, number, state)
    if number is not None and numbered:
        # numbers of the program's own count on as they did, each later by the lines that were put
        # in
        last = int(number[2]) + state.shift
        new = number[1] + _digits(last, number[2]) + code[number.end() :] if state.shift else code
        return _sealed(line, code, new, mark, tail), Numbering(last, state.shift)
    if mark or state.last is None:
        return _sealed(line, code, code, mark, tail), state
    words = COMMENT.sub(b"", code).strip(BLANK)
    if not words or words.startswith((b"%", b"/")):  # no block, or one that the host takes out
        return line, state
    last = state.last + 1
    code = b"N%d %s" % (last, code.lstrip(BLANK))
    return code + b"*%d" % _xor(code) + tail, Numbering(last, state.shift + 1)


def _sealed(
    line: bytes, code: bytes, new: bytes, mark: re.Match[bytes] | None, tail: bytes
) -> bytes:
    """The line with `new` in place of `code`, and a checksum that fits where it has one."""
    if not mark:
        return line if new == code else new + tail
    if new == code and int(mark[1]) in _right(code):
        return line
    new = new.lstrip(BLANK)
    return new + b"*%d" % _xor(new) + tail


def _digits(value: int, like: bytes) -> bytes:
    """A number with as many leading zeros as it had."""
    return (
        b"%0*d" % (len(like), value) if like.startswith(b"0") and len(like) > 1 else b"%d" % value
    )


def _marks(text: bytes) -> Iterator[tuple[int, int, int]]:
    """Start of the line, place of the `*`, and end of the digits, of every checksum."""
    found = MARK.search(text)
    while found:
        start = text.rfind(b"\n", 0, found.start()) + 1
        if text.find(b";", start, found.start()) < 0:
            yield start, found.start(), found.end()
        # What follows in this line is a comment.
        stop = text.find(b"\n", found.end())
        found = MARK.search(text, stop) if stop >= 0 else None


def _right(code: bytes) -> tuple[int, int]:
    """The checksums of a line's code: with the blanks before it, and without."""
    return _xor(code), _xor(code.lstrip(BLANK))


def _xor(code: bytes) -> int:
    return reduce(xor, code, 0)
