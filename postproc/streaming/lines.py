"""A line on the wire, and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass

from postproc.errors import GcompError


class Unsendable(GcompError):
    """A line that the controller would not take as it is meant."""


@dataclass(frozen=True, slots=True)
class WireLine:
    """One line as it is sent, without its line end.

    number: from 1, in the order of sending; source: line of the program, from 1 (0: none, it is
    gcomp's own); piece: 0 the block itself, 1.. what was put in behind it. end: mm (degrees),
    machine coordinates commanded, by axis of the machine; nan where not known, () where nothing is
    known. correction: mm by axis. length: mm of path; seconds: at the programmed feed, without
    acceleration. points: places between start and end of an arc, where they were asked for.
    file: the subprogram's file that the source line is of; "": the program itself. straight: it
    goes to `end` straight or along `points`; a cycle does not, nor an arc without points.
    """

    number: int
    source: int
    piece: int
    text: bytes
    end: tuple[float, ...] = ()
    correction: tuple[float, ...] = ()
    length: float = 0.0
    seconds: float = 0.0
    points: tuple[tuple[float, ...], ...] = ()
    file: str = ""
    straight: bool = True

    def where(self) -> str:
        """The line in words, for a person."""
        text = self.text.decode("ascii", "replace")
        if not self.source:
            return f"wire line {self.number} ({text}), which is gcomp's own"
        part = f", piece {self.piece + 1} of it" if self.piece else ""
        of = f" of {self.file}" if self.file else ""
        return f"source line {self.source}{of}{part}, sent as wire line {self.number}: {text}"


class Part:
    """One line that may move: its places, () where anything may happen; whether it was answered,
    and surely makes a block.
    upto: number of the last line behind it that is over when it is."""

    __slots__ = ("answered", "block", "line", "places", "seconds", "upto")

    def __init__(self, line: WireLine, places: tuple[tuple[float, ...], ...], block: bool):
        self.line, self.places, self.block = line, places, block
        self.answered, self.upto, self.seconds = False, line.number, line.seconds
