"""Fadal format 1, run: subroutines of the text become plain blocks where they are called.

L100 begins subroutine 1, L200 the second, M17 ends one, M30 ends them all, and the program begins
behind it. L103 runs subroutine 1 three times. Fadal, User Manual (format 1), "Subroutines"; no text
of it was found, so this follows programs that ran: holes listed in L100, called as L101 behind a
cycle with L0, which drills none itself; the first of the holes gets its words. How often a block
with an L of its own runs is not followed, nor are the control's own routines (L93 to L99).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from postproc.errors import ProgramError
from postproc.nc.comments import COMMENTS
from postproc.nc.expand import Limits, Line, Program, fault
from postproc.nc.expand.tracker import Tracker

HEAD = re.compile(rb"[ \t]*(?:/[ \t]*)?(?:N[ \t]*[0-9]+[ \t]*)?")
ROUTINE = re.compile(rb"L[ \t]*([0-9]+)([0-9][0-9])[ \t\r]*")
ENDS_ONE = re.compile(rb"M[ \t]*0*17[ \t\r]*")
CYCLE = re.compile(rb"G[ \t]*(?:7[346]|8[1-9])(?:\.1)?(?![0-9.])")
NO_HOLE = re.compile(rb"(?<![A-Z])L[ \t]*0+\.?0*(?![0-9.])", re.IGNORECASE)
PLACE = re.compile(rb"(?<![A-Z])[XY][ \t]*[+-]?[0-9.]+[ \t]*", re.IGNORECASE)
PLACES = re.compile(rb"(?:[XY][ \t]*[+-]?[0-9.]+[ \t]*)+")
ENDS_ALL = re.compile(rb"M[ \t]*0*30[ \t\r]*")


def lines(program: Program, tracker: Tracker, limits: Limits) -> Iterator[Line]:
    """The plain lines in the order of execution. Raises ProgramError."""
    yield from _Run(program, program.whole_lines(), limits).main()


class _Run:
    """One program. `routines`: number to the first and the last line of a subroutine's blocks;
    `behind`: the line where the program goes on behind them; `stored`: the line of a cycle whose
    words wait for a hole, -1: none."""

    def __init__(self, program: Program, texts: list[bytes], limits: Limits):
        self.program, self.texts, self.limits = program, texts, limits
        self.codes = [_code(text) for text in texts]
        self.routines: dict[int, range] = {}
        self.left, self.stored = limits.steps, -1
        self.first = self.behind = len(texts)
        self._find()

    def _find(self) -> None:
        #   L100 .. M17 L200 .. M17 M30 ..       subroutines from `first` on, the program before and
        #   first                       behind   `behind` them
        first = -1
        for at, code in enumerate(self.codes):
            routine = ROUTINE.fullmatch(code)
            if ENDS_ALL.fullmatch(code) and self.first < len(self.texts):
                self.behind = at + 1
                break
            if routine and routine[2] == b"00":
                number, first = int(routine[1]), at + 1
                self.first = min(self.first, at)
                if number in self.routines:
                    raise self._fault(at, f"L{number}00 stands twice", "give one another number")
                self.routines[number] = range(first, len(self.texts))
            elif ENDS_ONE.fullmatch(code) and first >= 0:
                self.routines[number], first = range(first, at), -1
        if first >= 0:
            raise self._fault(first - 1, f"L{number}00 has no M17 behind it", "write it at its end")
        if self.routines and self.behind == len(self.texts):
            what = "subroutines without the M30 that ends them"
            raise self._fault(self.first, what, "write M30 behind the last M17")

    def main(self) -> Iterator[Line]:
        """All but the subroutines' own lines."""
        yield from self._run(range(self.first), 0)
        yield from self._run(range(self.behind, len(self.texts)), 0)

    def _run(self, rows: range, depth: int) -> Iterator[Line]:
        for at in rows:
            self.left -= 1
            if self.left < 0:
                raise self.limits.endless().at(self.program.name, at + 1, self.texts[at])
            call = ROUTINE.fullmatch(self.codes[at])
            # L103: subroutine 1, three times
            if call is None:
                yield from self._plain(at)
                continue
            number, times = int(call[1]), int(call[2])
            if number not in self.routines or not times:
                what = f"there is no subroutine L{number}00 before M30"
                raise self._fault(at, what, "write its motions here: it may be the control's own")
            if depth >= self.limits.depth:
                raise self.limits.too_deep().at(self.program.name, at + 1, self.texts[at])
            for _ in range(times):
                yield from self._run(self.routines[number], depth + 1)

    def _plain(self, at: int) -> Iterator[Line]:
        """A block that is no call, a hole with the words of the cycle before it."""
        code, text, stored = self.codes[at], self.texts[at], self.stored
        if stored >= 0 and PLACES.fullmatch(code):
            #   G81 X1. Y1. Z-1. R.1 F10. L0   stored, for it drills nothing there
            #   X2. Y2., the first in L101     G81 Z-1. R.1 F10. X2. Y2.
            cycle = PLACE.sub(b"", NO_HOLE.sub(b"", self.texts[stored])).rstrip()
            text, self.stored = cycle + b" " + code, -1
        elif stored >= 0 and code:
            yield Line(self.texts[stored], stored + 1)
            self.stored = -1
        if CYCLE.search(code) and NO_HOLE.search(code):
            self.stored = at
        else:
            yield Line(text, at + 1)

    def _fault(self, at: int, message: str, advice: str) -> ProgramError:
        return fault(self.program.name, at + 1, self.texts[at], message, advice)


def _code(text: bytes) -> bytes:
    """A block without its number, its slash and its comments, in capitals."""
    bare = COMMENTS["end of block"].sub(b" ", text)
    head = HEAD.match(bare.upper())
    assert head is not None
    return bare[head.end() :].strip().upper()
