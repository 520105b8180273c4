"""A Sinumerik program or subprogram that runs: where it stands, and which repetitions it is in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from postproc.nc.expand.siemens_source import Source
from postproc.nc.expand.siemens_values import Scope


@dataclass
class Repeat:
    """A part of a program that runs again: first and last line, how often still, the line of the
    REPEAT."""

    start: int
    stop: int
    left: int
    back: int


@dataclass
class Frame:
    """A program that is being executed: its lines, the next of them, its variables; how often it is
    to run again."""

    source: Source
    scope: Scope
    at: int = 0
    repeats: list[Repeat] = field(default_factory=list)
    # end values of the FOR loops that run, by line
    ends: dict[int, float] = field(default_factory=dict)
    passes: int = 1
    new_scope: Callable[[], Scope] | None = None

    def step(self) -> None:
        """Control goes to the next line."""
        self.go(self.at, self.at + 1)

    def go(self, at: int, to: int) -> None:
        """Control goes from line `at` to line `to`, or back to the begin of what is repeated."""
        #   10  ANF: ..      start    REPEAT ANF P2 puts (10, 12, 2, 20) on top: from 12 it goes
        #   12  ..           stop     to 10 while passes are left, then to 21. A jump out of 10 to
        #   20  REPEAT ANF   back     12 ends it, and the one around it is asked.
        while self.repeats:
            top = self.repeats[-1]
            if at == top.stop and to == at + 1:
                top.left -= 1
                if top.left > 0:
                    to = top.start
                    break
                self.repeats.pop()
                at, to = top.back, top.back + 1
            elif top.start <= to <= top.stop:
                break
            else:
                self.repeats.pop()
        self.at = to
