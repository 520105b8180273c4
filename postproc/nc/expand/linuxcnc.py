"""LinuxCNC programs (RS274/NGC), written out: O-words, parameters and expressions become plain
lines.

LinuxCNC reads line by line and looks for labels where it must skip or go back; so does this module,
so that programs with computed labels, loops left in the middle and subs behind the end run as they
do there. Its peculiarities, as measured on 2.9: a repeat that is left by return goes on counting at
the next call; a while loop left by break makes the next do loop run once; break and continue are
for while and do only. A call looks for a sub that has been read, then for a file of its name, then
further down. M98 and M99 call Fanuc-style programs (O100 alone in a line).

Refused beyond what LinuxCNC refuses: a do label used twice (it goes back to the first), M99 in the
main program (it begins again, for ever), and subs within called subs.

Sources: LinuxCNC documentation, "O codes"; measured on LinuxCNC 2.9
(tests/expand/test_linuxcnc.py).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from postproc.errors import BlockFault, ProgramError
from postproc.nc.expand import Limits, Line, Program, Refusal
from postproc.nc.expand.linuxcnc_blocks import Control, Outcome, read
from postproc.nc.expand.linuxcnc_expressions import whole
from postproc.nc.expand.linuxcnc_flow import File, Flow, Place
from postproc.nc.expand.linuxcnc_parameters import Memory
from postproc.nc.expand.linuxcnc_polar import right_angled
from postproc.nc.expand.linuxcnc_states import States
from postproc.nc.expand.tracker import Tracker

CONTROL = re.compile(rb"[ \t]*/?[ \t]*(?:[Nn][ \t\d.]+)?(?:[Oo]|[Mm][ \t]*9[ \t]*[89])")
PLACE = re.compile(rb"\([^)\n]*\)|;[^\n]*|(?P<word>[XxZz][ \t]*[-+.\d][.\d \t]*)")
LOCAL_NAME = re.compile(rb"#[ \t]*<[ \t]*(?!_)")
ENDS, STATES, CALLS = (2, 30), (70, 71, 72, 73), (98, 99)


def lines(program: Program, tracker: Tracker, limits: Limits) -> Iterator[Line]:
    """The plain lines of a program in the order of execution. Raises ProgramError where it can not
    be run, or runs beyond the limits."""
    return Run(program, tracker, limits).lines()


class Run:
    """One program while it is executed."""

    def __init__(self, program: Program, tracker: Tracker, limits: Limits):
        self.program, self.tracker, self.limits = program, tracker, limits
        self.memory = Memory(tracker)
        self.flow = Flow(program, self.memory, limits.depth)
        self.states = States(tracker, program.text)
        tracker.rendered, tracker.shape = self._rendered, self._shape
        self.main = self.flow.file
        first = next((i for i, line in enumerate(self.main.lines) if line.strip()), -1)
        self.opening = first if first >= 0 and self.main.lines[first].strip() == b"%" else -1
        # lines that are no program ($X, %wait of a sender)
        ignores = tracker.dialect.grammar.ignores
        self.ignored = re.compile("|".join(ignores).encode(), re.IGNORECASE) if ignores else None
        self.ended = False

    # Whole: the hot loop: lines without a special word pass in one go.
    def lines(self) -> Iterator[Line]:
        """Execute it."""
        flow, steps = self.flow, 0
        # a program without loops may be as long as it likes
        most = self.limits.steps + len(self.main.lines)
        while True:
            file, at = flow.file, flow.at
            special = file.special.find(1, at)
            # up to the next line that may be more than plain words, at once
            until = min(special if special >= 0 else len(file.lines), at + most - steps)
            if until > at and flow.skip is None:
                name = file.name
                for number, text in enumerate(file.lines[at:until], at + 1):
                    if self.states.watching:
                        self.states.watch(text)
                    yield Line(text, number, name)
            steps += until - at
            if until >= len(file.lines):
                self._run_out()
                return
            at, text = until, file.lines[until]
            flow.at, steps = at + 1, steps + 1
            try:
                if steps > most:
                    raise self.limits.endless()
                plain = self._step(file, at, text)
                back = self.states.called(len(flow.calls))
            except Refusal as e:
                raise self._fault(Place("", file, at), e) from None
            except BlockFault as e:
                before = Refusal(
                    f"what holds here is not known, because of a line before: {e.message}", e.advice
                )
                raise self._fault(Place("", file, at), before) from None
            for line in back:
                yield Line(line, at + 1, file.name)
            if plain is not None:
                if self.states.watching:
                    self.states.watch(plain)
                for line in plain.split(b"\n"):
                    yield Line(line, at + 1, file.name)
                if at == self.opening and file is self.main:
                    # read alone: of what stands behind "%" in the same text, nothing is read
                    _ = self.tracker.state
            if self.ended:
                yield from self._closing(file, at)
                return

    # -- one line ----------------------------------------------------------------------------------

    def _step(self, file: File, at: int, text: bytes) -> bytes | None:
        """Execute a line; the plain text that it leaves, if any. Raises Refusal."""
        flow, memory = self.flow, self.memory
        if text.strip() == b"%":
            return self._mark(file, at)
        if self._passes(text):
            return text if flow.skip is None else None
        # what is skipped is not read: it may be no code at all
        if flow.skip is not None and not CONTROL.match(text):
            return None
        found = file.read.get(at) or read(text)
        if file.met[at]:
            file.read[at] = found
        file.met[at] = 1
        # #<_line> counts from the opening "%" on, which is line 1 then
        memory.line = at + 1 - max(self.opening if file is self.main else 0, 0)
        if isinstance(found, Control):
            flow.control(found, Place(found.kind, file, at))
            return text if found.plain and not flow.calls and flow.skip is None else None
        outcome = found.run(memory)
        memory.notice(outcome.g, outcome.m, outcome.letters)
        return self._plain(outcome)

    def _passes(self, text: bytes) -> bool:
        """Whether a line is none of the program, or deleted."""
        if self.ignored and self.ignored.fullmatch(text):
            return True
        return self.tracker.setup.block_delete and text.lstrip()[:1] == b"/"

    def _plain(self, outcome: Outcome) -> bytes | None:
        """The plain text of a line that was run, if any. Raises Refusal."""
        for value in outcome.m:
            code = whole(value, "M")
            if code in CALLS:
                raise Refusal(
                    f"M{code} is not the first word of its line",
                    f"write M{code} into a line of its own",
                )
            if code in STATES:
                return self._state(code, outcome)
            self.ended |= code in ENDS
        if outcome.text is not None and ("@" in outcome.letters or "^" in outcome.letters):
            codes = {round(10 * value) for value in outcome.g}
            return right_angled(outcome.text, codes, outcome.letters, self.memory)
        return outcome.text

    def _state(self, code: int, outcome: Outcome) -> bytes | None:
        """M70 to M73: the modes are kept, or come back as lines of their own."""
        if len(outcome.m) > 1 or outcome.g or outcome.letters.strip("mn"):
            raise Refusal(f"M{code} beside other words", f"write M{code} into a line of its own")
        lines = self.states.take(code)
        if code in (70, 71) and not self.flow.calls:
            return outcome.text
        return b"\n".join(lines) or None

    def _rendered(self, raw: bytes) -> bytes | None:
        """A block of a cycle's shape with the values of its parameters as they are now. None: it
        sets parameters, or asks for named ones that a subroutine does not see."""
        found = read(raw)
        if isinstance(found, Control) or LOCAL_NAME.search(raw):
            return None
        if not all(edit.letter for edit in found.edits):
            return None
        try:
            return found.run(self.memory).text
        except Refusal as e:
            raise BlockFault(0, e.message, e.advice) from None

    def _shape(self, number: int, begin: bytes) -> list[bytes]:
        """The plain lines of the subroutine of a cycle's shape, run as LinuxCNC runs it:
        #<_x> is where the shape has come to (interp_g7x.cc, convert_g7x)."""
        flow, memory, found = self.flow, self.memory, list[bytes]()
        level, tracker = len(flow.calls), memory.tracker
        # the shape is run as it would be, but the program stands still meanwhile: another tracker
        # hears it
        memory.tracker = beside = tracker.beside()
        beside.take(begin)
        try:
            call = read(b"O%d CALL" % number)
            assert isinstance(call, Control)
            flow.control(call, Place(call.kind, flow.file, flow.at))
            for _ in range(self.limits.steps):
                if len(flow.calls) == level:
                    return found
                file, at = flow.file, flow.at
                if at >= len(file.lines):
                    self._run_out()
                flow.at = at + 1
                plain = self._step(file, at, file.lines[at])
                if plain is not None:
                    found.append(plain)
                    words = [m["word"] for m in PLACE.finditer(plain) if m["word"]]
                    beside.take(b" ".join([b"G0", *words]) if words else b"")
            raise self.limits.endless()
        except Refusal as e:
            raise BlockFault(0, e.message, e.advice) from None
        finally:
            memory.tracker = tracker

    def _mark(self, file: File, at: int) -> bytes | None:
        """A line "%": the first one of a program opens it, the next one ends it. Raises Refusal."""
        if file is not self.main:
            if self.flow.skip is None:
                raise Refusal(
                    f"'%' within {self.flow.sub}",
                    f"{self.flow.way_back} ends it before the end of its file",
                )
            return None
        if at != self.opening:
            self._run_out()
            self.ended = True
        return file.lines[at]

    # -- the end -----------------------------------------------------------------------------------

    def _closing(self, file: File, at: int) -> Iterator[Line]:
        """Behind M2 or M30: the "%" that closes the program, if it has been opened by one. Senders
        send on what stands there (GRBL and its kin)."""
        lines = self.main.lines
        rest = range(at + 1, len(lines)) if file is self.main else range(0)
        if self.tracker.dialect.homes and not any(CONTROL.match(lines[i]) for i in rest):
            yield from (Line(lines[i], i + 1) for i in rest)
            return
        if self.opening < 0 or (file is self.main and lines[at].strip() == b"%"):
            return
        later = range(max(self.opening, at if file is self.main else 0) + 1, len(lines))
        mark = next((i for i in later if lines[i].strip() == b"%"), -1)
        if mark >= 0:
            yield Line(lines[mark], mark + 1)

    def _run_out(self) -> None:
        """The end of a file: the main program may end here. Raises ProgramError."""
        flow = self.flow
        if flow.skip is not None and flow.since:
            raise self._fault(*flow.since)
        if flow.calls:
            wrong = Refusal(
                f"the file ends within {flow.sub}",
                f"{flow.way_back} goes back to where it was called",
            )
            raise self._fault(Place("", flow.file, max(len(flow.file.lines) - 1, 0)), wrong)

    def _fault(self, place: Place, wrong: Refusal) -> ProgramError:
        text = place.file.lines[place.at] if place.file.lines else b""
        name = place.file.name or self.program.name
        return wrong.at(name, place.at + 1, text)
