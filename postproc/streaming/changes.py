"""A tool change on a controller that has none (M6 on GRBL and its kin): what is sent before and
behind the pause, and what is asked then.

The spindle is stopped and the tool parked by a macro of the user's, a person changes the tool while
the controller is paused (M0), a second macro touches off. Then the controller says where its zeros
and its tool length are now, for the error map has to lie there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from postproc.errors import GcompError, Place, ProgramError
from postproc.streaming.lines import Unsendable
from postproc.streaming.precheck import CALL, M6

MOVES = re.compile(rb"[A-CI-KRU-Z] *[-+.0-9]", re.IGNORECASE)
ENDS = re.compile(rb"M0*(?:2|30)(?![0-9.])|%", re.IGNORECASE)
ZEROS, MODES = b"$#", b"$G"
QUESTIONS = (ZEROS, MODES)
# Macros begin in mm, absolute, whatever the program has in force; G4 answers when the machine
# stands, and `$` needs that.
OPENING, SYNC = (b"M5", b"M9", b"G21 G90 G94"), b"G4 P0.01"
LONGER = b"{longer}"
PROBED = re.compile(r"\[PRB:([^:\]]*):1\]")


@dataclass(frozen=True)
class Macro:
    """Lines that a user wrote for a controller; `rows`: number of the line in its file, text as it
    is sent."""

    name: str = ""
    rows: tuple[tuple[int, bytes], ...] = ()


def macro(text: bytes, name: str, prepare: Callable[[bytes], bytes]) -> Macro:
    """A macro's lines as they are sent. prepare: the protocol's. Raises ProgramError for what can
    not stand in one."""
    rows = []
    for number, line in enumerate(text.split(b"\n"), 1):
        place = Place(name, number, line.decode("latin-1").strip())
        try:
            wire = prepare(line)
        except Unsendable as error:
            raise ProgramError(error.message, error.advice, place) from None
        if not wire:
            continue
        if wire.startswith(b"$"):
            raise ProgramError(
                "a line of a tool change is an order to the controller, which it takes at rest"
                " alone",
                "leave it out",
                place,
            )
        if M6.search(wire) or CALL.search(wire) or ENDS.search(wire):
            raise ProgramError(
                "lines of a tool change move, probe, set offsets and pause (M0), and this one does"
                " none of that",
                "leave it out",
                place,
            )
        rows.append((number, wire))
    return Macro(name, tuple(rows))


def split(text: bytes) -> bytes:
    """The block of a tool change as the pause in which it is made. Raises Unsendable where
    something else happens in it."""
    if MOVES.search(M6.sub(b"", text)):
        raise Unsendable(
            "a motion stands in the block of the tool change, and which tool makes it is not"
            " certain",
            "put it into a block of its own behind M6",
        )
    return M6.sub(b"M0", text)


def steps(pause: bytes, park: Macro, touch: Macro) -> Iterator[tuple[str, int, bytes]]:
    """Lines of one tool change in order: the macro's name ("": none) and line, and the text. The
    questions come last, and before each line with LONGER, whose value follows from them."""
    yield from (("", 0, text) for text in OPENING)
    yield from ((park.name, number, text) for number, text in park.rows)
    yield "", 0, pause
    for number, text in touch.rows:
        # G4 first, for $# is answered only at rest; the answer holds [PRB:x,y,z:1] of the last
        # probe
        if LONGER in text:
            yield from (("", 0, question) for question in (SYNC, *QUESTIONS))
        yield touch.name, number, text
    yield from (("", 0, text) for text in (SYNC, *QUESTIONS))


class Longer:
    """By how much (mm) each tool is longer than the first that was probed in this job: its probe
    touches so much higher."""

    def __init__(self, per: float = 1.0):
        self.per = per
        self.first: float | None = None

    def put(self, text: bytes, answers: list[str] | None) -> bytes:
        """The line with its number. answers: to ZEROS; None: before the job, when nothing has been
        probed. Raises GcompError."""
        value, line = 0.0, text.decode()
        if answers is not None:
            found = [match[1] for match in map(PROBED.fullmatch, answers) if match]
            try:
                z = float(found[-1].split(",")[2]) * self.per
            except (IndexError, ValueError):
                raise GcompError(
                    f"{line}: nothing was probed before this line, so how much longer the tool is"
                    " is not known",
                    "put G38.2 before it in the file of --touch-off",
                ) from None
            # All tools touch one plate: a tool that is 3 mm longer stops with Z 3 mm higher.
            self.first = z if self.first is None else self.first
            value = z - self.first
        return text.replace(LONGER, f"{value:.3f}".encode())
