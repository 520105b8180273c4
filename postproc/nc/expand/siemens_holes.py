"""The holes of a Sinumerik program while it runs: what MCALL names is drilled behind every motion,
what is called alone where it stands, and a pattern drills what MCALL named at each of its places.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from postproc.nc.comments import code_alone
from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_boring import Boring
from postproc.nc.expand.siemens_cycle import Cycle
from postproc.nc.expand.siemens_drilling import Drilling, moves
from postproc.nc.expand.siemens_face import Face
from postproc.nc.expand.siemens_frames import Frame
from postproc.nc.expand.siemens_kept import THREADS, Tapping, Thread
from postproc.nc.expand.siemens_patterns import Pattern
from postproc.nc.expand.siemens_pockets import Pocket
from postproc.nc.expand.siemens_removal import NAME as REMOVAL
from postproc.nc.expand.siemens_removal import Removal
from postproc.nc.expand.siemens_spigots import Spigot
from postproc.nc.expand.siemens_values import Value
from postproc.nc.expand.tracker import Tracker

HOLES: dict[str, type[Drilling]] = {
    name: kind for kind in (Drilling, Boring, Tapping) for name in kind.words
}
FIGURES: dict[str, type[Cycle]] = {
    name: kind for kind in (Pattern, Pocket, Spigot, Face) for name in kind.words
}
CYCLES: dict[str, type[Cycle]] = {**HOLES, **FIGURES}
NAMES = {*CYCLES, *THREADS, REMOVAL}  # the cycles that are written out
# Words of the program that hold on behind a cycle: S1= and M1= are those of the main spindle, S2=
# and M2= another one's. Beside G4 F and S are times, beside G25 and G26 S is a limit.
FEED = re.compile(rb"(?<![A-Z_0-9])F[ \t]*=?[ \t]*([0-9]*\.?[0-9]+)", re.IGNORECASE)
SPEED = re.compile(
    rb"(?<![A-Z_0-9])S[ \t]*(?:0*1?[ \t]*=[ \t]*)?([0-9]*\.?[0-9]+)\.?(?![0-9.]|[ \t]*=)",
    re.IGNORECASE,
)
SPINDLE = re.compile(
    rb"(?<![A-Z_0-9])M[ \t]*(?:0*1?[ \t]*=[ \t]*)?0*([34])(?![0-9]|[ \t]*=)", re.IGNORECASE
)
BESIDE = re.compile(rb"(?<![A-Z_0-9])G[ \t]*0*(?:4|25|26)(?![0-9])", re.IGNORECASE)


class Holes:
    """What is drilled, and the pockets."""

    def __init__(self, tracker: Tracker):
        self.tracker = tracker
        self.feed = self.speed = b""  # the last F and S words that have left
        self.sense = 1  # -1: M4 turns the spindle
        self.modal: tuple[Frame, Drilling] | None = None  # what MCALL calls, and where it was named
        self.called: Cycle | Removal | Thread | None = None  # to be drilled behind this line

    def call(
        self,
        name: str,
        values: Sequence[Value | None],
        contour: Callable[[str], list[bytes]],
        around: tuple[bytes, bytes],
    ) -> None:
        """A cycle that stands alone; contour: the plain lines of one by its name; around: the
        program's lines before and behind the call. Raises Refusal."""
        if name == REMOVAL:
            self.called = Removal.of(values, contour)
        elif name in THREADS:
            self.called = Thread(name, values)
        else:
            self.called = CYCLES[name].of(name, values, self.sense)
            if isinstance(self.called, Tapping):
                self.called.around = around

    def behind(self, frame: Frame, text: bytes, own: bool) -> Iterator[bytes]:
        """The plain lines behind a line that has left. own: it is one of the program. Raises
        Refusal."""
        code = code_alone(text, self.tracker.dialect.grammar) if own else b""
        if code.lstrip()[:1] == b"/" and self.tracker.setup.block_delete:
            code = b""
        if not BESIDE.search(code):
            self._hear(code)
        hole, self.called = self.called, None
        if isinstance(hole, Pattern):
            yield from self._pattern(frame, hole)
            return
        # MCALL holds in the program that named it, not in subprograms that it calls
        if self.modal and self.modal[0] is frame and moves(code):
            hole = self.modal[1]
        if hole:
            yield from hole.lines(self.tracker, self.feed, self.speed)

    def _hear(self, code: bytes) -> None:
        """Keep F, S and the sense of the spindle."""
        letters = code.upper()
        if b"F" in letters:
            self.feed = next((f[1] for f in FEED.finditer(code)), self.feed)
        if b"S" in letters:
            self.speed = next((s[1] for s in SPEED.finditer(code)), self.speed)
        if b"M" in letters:
            self.sense = next((7 - 2 * int(m[1]) for m in SPINDLE.finditer(code)), self.sense)

    def _pattern(self, frame: Frame, pattern: Pattern) -> Iterator[bytes]:
        """The places of a pattern, with a hole at each; the motion code is what it was."""
        if not self.modal or self.modal[0] is not frame:
            raise Refusal(
                f"no MCALL is in force here: what {pattern.name} does at its places is not known",
                "write MCALL and the cycle of one hole before it, in the same program",
            )
        code = self.tracker.motion_code()
        for place in pattern.lines(self.tracker, self.feed):
            yield place
            yield from self.modal[1].lines(self.tracker, self.feed, self.speed)
        yield from code
