"""Random programs in every dialect that use everything at once, and hypothesis strategies of them.

A program is a row of snippets: motions, arcs, frames, holes, cutter compensation, macros, text of
all kinds. What a snippet says is meant to be right most of the time, so that programs are followed
to their end; what follows what is left to chance. Coordinates lie in the ranges of cases.WIDE for
as long as no shift takes them elsewhere.
"""

from __future__ import annotations

import random
from functools import reduce
from operator import xor

from hypothesis import strategies as st

from fuzz.holes import Holes
from fuzz.languages import Languages
from fuzz.motions import Motions
from fuzz.words import (
    COMMENTS,
)
from postproc.nc import dialects


def program(rng: random.Random, dialect: str, blocks: int = 12, wild: float = 0.05) -> bytes:
    """A program of about so many blocks. wild: share of things that are wrong on purpose."""
    return Writer(rng, dialect, wild).text(blocks)


def programs(dialect: str, blocks: int = 14, wild: float = 0.05) -> st.SearchStrategy[bytes]:
    """A hypothesis strategy of programs; shrinks towards few blocks."""
    return st.builds(
        lambda rng, n: program(rng, dialect, n, wild),
        st.randoms(use_true_random=False),
        st.integers(1, blocks),
    )


def every() -> list[str]:
    """The dialects that there are."""
    return dialects.names()


class Writer(Motions, Holes, Languages):
    """Writes one program."""

    # -- the course of a program -------------------------------------------------------------------

    def text(self, blocks: int) -> bytes:
        rng = self.rng
        self.spaced, self.numbered = self.often(0.8), self.often(0.3)
        self.sealed = self.printer and self.often(0.4)
        if self.often(0.15) and not self.din:
            self.lines.append("%")
        if self.fanuc and self.often(0.3):
            self.lines.append("O0001" + self.one("", " (PART)"))
        if self.din and self.often(0.5):
            self.lines.append("%PART G71 *")
        if self.often(0.9):
            self.add(self.absolute(), self.g("G0"), *self.coordinates(self.ranges))
        snippets = self.snippets()
        names, weights = list(snippets), list(snippets.values())
        while len(self.lines) < blocks:
            rng.choices(names, weights)[0]()
            if self.often(self.wild / 3):
                self.spoil()
        if self.tail or self.often(0.4):
            self.add(self.one("M30", "M30", "M2", "M17" if self.siemens else "M2"))
            if self.often(0.3):
                self.lines.append(self.one("G1 X5 F100", "garbage )", "%", "#"))
        self.lines += self.tail
        return self.laid_out()

    def snippets(self) -> dict:
        result = {
            self.straight: 24,
            self.small: 6,
            self.arc: 14,
            self.modes: 8,
            self.quiet: 6,
            self.offset: 3,
            self.frame: 8,
            self.away: 3,
            self.stops: 3,
            self.beside: 3,
            self.dwell: 1,
            self.junk: 2,
        }
        if not self.printer and not self.din:
            result[self.holes] = 8
            result[self.thread] = 2
            result[self.turned] = 2
            result[self.macro] = 5
        if self.lathe:
            result[self.increments] = 10
        if self.printer:
            result[self.extrude] = 20
        if self.siemens:
            result[self.by_keyword] = 8
            result[self.polynomial] = 4
        if self.dialect in ("fagor", "okuma"):
            result[self.own] = 14
        return result

    # -- layout ------------------------------------------------------------------------------------

    def laid_out(self) -> bytes:
        rng = self.rng
        end = self.one("\n", "\n", "\n", "\r\n")
        stop = "*" if self.din else ";" if self.fanuc and self.often(0.3) else ""
        lower = self.often(0.1)
        mixed = self.often(self.wild)
        out = ""
        for i, line in enumerate(self.lines):
            line = line.lower() if lower else line
            bare = line.strip()
            label = line[:1] in "%oO:#" or bare.endswith(":")
            if self.numbered and bare and not label:
                line = f"N{(i + 1) * 10}{' ' if self.spaced else ''}{line}"
            if self.sealed and bare and "*" not in line and "(" not in line:
                line = f"N{i + 1} {line}"
                line += f"*{reduce(xor, line.encode('latin-1'), 0)}"
            if bare and self.often(0.08) and not label and not self.sealed:
                comment = rng.choice(COMMENTS)
                line += (
                    f" ;{comment}"
                    if (self.siemens or self.ngc or self.printer) and self.often(0.6)
                    else ""
                    if self.siemens
                    else f"({comment.replace('(', '')})"
                )
            if bare and self.often(0.04) and not label:
                line = "/" + line
            if stop and line[:1] != "%" and self.often(0.9):
                line += stop
            if stop == ";" and self.often(0.2):
                out += line + " "
                continue
            if mixed and self.often(0.2):
                end = self.one("\n", "\r\n", "\r")
            out += line + (end if i + 1 < len(self.lines) or self.often(0.8) else "")
        return out.encode("latin-1")
