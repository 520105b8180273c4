"""Programs whose text runs at several places, written out: loops, subprograms, variables and
expressions become plain blocks.

A language is a module here, found by its name (Dialect.language). It reads the whole program, runs
its control structures, and gives one plain line after the other, in the order in which the control
would execute them, with a number in the place of every expression and all other text as it stood.
It knows nothing of machines, and of positions only what the tracker tells it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Self

from postproc.errors import Place, ProgramError


class Line(NamedTuple):
    """A plain line without its line end, the line it came from (from 1), and the file ("": the main
    program)."""

    text: bytes
    source: int
    file: str = ""


@dataclass(frozen=True)
class Limits:
    """How far an unrolling may go: source lines executed, calls nested in each other."""

    steps: int = 10_000_000
    depth: int = 50

    def endless(self, most: int = 0) -> Refusal:
        """What is said beyond `steps`; most: the limit, where it is another."""
        return Refusal(
            f"more than {most or self.steps:,} lines were executed",
            "does a loop not end? --max-steps sets the limit",
        )

    def too_deep(self) -> Refusal:
        """What is said beyond `depth`."""
        return Refusal(
            f"more than {self.depth} calls are nested in each other",
            "does a program call itself? --max-depth sets the limit",
        )


@dataclass(frozen=True)
class Program:
    """A program's whole text, and where others are found: `library` takes a subprogram's name or
    number as the program writes it and gives its text, or None."""

    name: str
    text: bytes
    library: Callable[[str], bytes | None] = lambda name: None

    # bytes, for a comment may hold any of them; the line end of all that is written is chosen once
    # (written.py)
    def lines(self) -> list[bytes]:
        """The lines without their ends."""
        return [line.rstrip(b"\r") for line in self.text.split(b"\n")]

    def whole_lines(self) -> list[bytes]:
        """The same without the empty one that a newline at the end makes."""
        lines = self.lines()
        return lines if lines[-1] else lines[:-1]


class Refusal(Exception):
    """What a program asks for and can not be had. start and stop: offsets into its line, of a
    Fanuc's into its code (0, 0: the whole of it)."""

    def __init__(self, message: str, advice: str = "", start: int = 0, stop: int = 0):
        super().__init__(message)
        self.message, self.advice, self.start, self.stop = message, advice, start, stop

    # Who finds a fault deep in an expression knows its message, who reads the line knows where it
    # stands: each layer on the way up adds a place only where none was given further in.
    def placed(self, start: int, stop: int) -> Self:
        """The same, at a place where it has none of its own."""
        if not self.stop:
            self.start, self.stop = start, stop
        return self

    def at(self, name: str, source: int, text: bytes) -> ProgramError:
        """The error that a user meets, at a line of a program."""
        return fault(name, source, text, self.message, self.advice, self.start, self.stop)


# of a number: how near to a whole one rounding alone may have kept it (Fanuc's manuals name errors
# of arithmetic up to 1e-9)
ROUNDED = 1e-9


def cut(value: float) -> float:
    """A number, to be cut to a whole one. Raises Refusal where it is one but for rounding: controls
    say themselves that a whole number more or less may come of it."""
    if 0 < abs(value - round(value)) <= ROUNDED * max(1.0, abs(value)):
        raise Refusal(
            f"{value!r} is cut to a whole number, and is one but for rounding",
            "which one the control has is not certain: add a little before, such as 0.0001",
        )
    return value


def fault(
    name: str, source: int, text: bytes, message: str, advice: str, start: int = 0, stop: int = 0
) -> ProgramError:
    """An error at a line of a program; start and stop: offsets into `text`."""
    columns = (start + 1, stop + 1) if stop else (0, 0)
    return ProgramError(
        message, advice, Place(name, source, text[:1000].decode("latin-1"), *columns)
    )
