"""One account of execution: which lines were sent, answered, planned, and are over; the watch,
journal, display and restart read it.

A controller answers a line when its motion is planned, not when it is made. What it holds then is
bounded: the blocks of its planner, and those that its stepper has already taken out of it into
segments (GRBL 1.1: 15 blocks, planner.h, and 5 segments of a ring of 6, stepper.h; with motions
shorter than a segment of 10 ms each segment is a block: 20 were counted on its real image). So of
the lines answered, all are over but those behind which fewer motions than that stand. Only motions
count that surely make a block: M and G words alone make none, nor does a motion below one step of
the motors (planner.c, PLAN_EMPTY_BLOCK).

    line   1 ............... | ............... a | a + 1 ........... s | s + 1 ...
           over: executed    | answered, perhaps | sent, not answered: | not sent
                             | in the planner    | in the buffer or    |
                             | or in segments    | on the wire         |
"""

from __future__ import annotations

import math
import re
from collections import deque

from postproc.streaming.events import Status
from postproc.streaming.line_estimate import LineEstimate
from postproc.streaming.lines import Part, WireLine
from postproc.streaming.protocols import Controller

REST = "idle"
# mm: of a motion that surely makes a block, where the controller does not say how fine its steps
# are
SHORT = 0.05
MOST = 4096  # entries that may be kept apart
# M6 and macros may move in ways of their own.
OTHER = re.compile(
    rb"M0*(?:6|6[0-9]|9[89]|[1-9][0-9]{2,})(?![0-9])|G0*6[56](?![0-9])|^\$", re.IGNORECASE
)
QUESTION = re.compile(rb"\$[#$GIN]", re.IGNORECASE)  # which moves nothing
AXES = re.compile(rb"[A-CI-KRU-Z]", re.IGNORECASE)


def _stays(start: tuple[float, ...], end: tuple[float, ...]) -> bool:
    """Whether both are the same place; unknown is like unknown."""
    return all(a == b or (a != a and b != b) for a, b in zip(start, end, strict=True))


class Account:
    """sent(), answered(), refused() for every line, reported() for every report.

    order: where each axis of a line's `end` stands in the reports and settings, (): in the same
    order. sent_to, answered_to, executed: numbers of the last line of which that is certain;
    seconds: of programmed motion that is over. parts: what may still be in execution, or will be,
    oldest first.
    """

    def __init__(self, controller: Controller, order: tuple[int, ...] = ()):
        self.order = order
        # a mm of its axes in its own order; 0 where it does not say so
        self._steps = [controller.setting(100 + i) for i in range(6)]
        self._segments, self._blocks = controller.segments, controller.planner
        self._estimate = LineEstimate(SHORT + 2 * controller.coarsest_step, order)
        self.parts: deque[Part] = deque()
        self.answered_to = self.executed = 0
        self.source = 0
        self.seconds = 0.0
        self._by: dict[int, Part] = {}
        # lines without a motion that were sent and not answered
        self._still: dict[int, WireLine] = {}
        self._last: tuple[float, ...] = ()
        self._over = 0  # blocks among the answered parts
        self._rested = -1  # the last line answered before the report of rest before this one

    @property
    def holds(self) -> int:
        """Motions that may be answered and not over: of the planner one more than it holds, which
        is just being taken."""
        return self._blocks + self._segments

    def sent(self, line: WireLine) -> None:
        """A line that left."""
        if line.number <= 0:
            return
        part = self._motion(line)
        if part is None:
            self._still[line.number] = line
            return
        self.parts.append(part)
        self._by[line.number] = part
        if len(self.parts) > MOST:  # many motions without any length
            self._merge()

    def _motion(self, line: WireLine) -> Part | None:
        """None: this line moves nothing."""
        if QUESTION.fullmatch(line.text):
            return None
        end = () if OTHER.search(line.text) else line.end
        if end and not AXES.search(line.text):
            return None  # where the program believes that it stands; it may have been jogged since
        start, self._last = self._last, end
        if not (start and end):
            return Part(line, (), self._is_block(()))
        start += (math.nan,) * (len(end) - len(start))
        if not line.points and _stays(start, end):
            return None
        places = (start, *line.points, end) if line.straight else ()
        return Part(line, places, self._is_block(places))

    def _is_block(self, places: tuple[tuple[float, ...], ...]) -> bool:
        """Whether it is longer than a step of some motor: then its ends are different whole
        steps."""
        return any(
            abs(place[k] - places[0][k]) * self._steps_of(k) >= 1.001
            for place in places[1:]
            for k in range(len(place))
        )

    def _steps_of(self, axis: int) -> float:
        row = self.order[axis] if axis < len(self.order) else axis
        return (self._steps[row] if row < len(self._steps) else 0.0) or 1.0 / SHORT

    def answered(self, number: int, emptied: bool = False) -> None:
        """A line that was taken. emptied: this answer is given when all before it has been executed
        (G4, M0, M2)."""
        if number <= 0:
            return
        self.answered_to = number
        part = self._by.pop(number, None)
        line = self._still.pop(number, None)
        if part is not None:
            part.answered = True
            self._over += part.block
        elif line is not None and self.parts and self.parts[-1].line.number < number:
            self.parts[-1].upto = number
            self.parts[-1].seconds += line.seconds
        elif line is not None:
            self._behind(line)
        self._finish(number if emptied else -1)

    def _behind(self, line: WireLine) -> None:
        """A line without a motion: over with the last part before it, or at once."""
        before = next(
            (part for part in reversed(self.parts) if part.line.number < line.number), None
        )
        if before is None:
            self.executed, self.source = line.number, line.source
            self.seconds += line.seconds
        else:
            before.upto = max(before.upto, line.number)
            before.seconds += line.seconds

    def refused(self, number: int) -> None:
        """A line that was not taken: it moves nothing, and where the one behind it begins is not
        known."""
        parts = list(self.parts)
        at = next((i for i, part in enumerate(parts) if part.line.number == number), None)
        # the refused one and the one behind it, which begins where the refused one did not go
        for part in parts[at : at + 2] if at is not None else ():
            self._over -= part.block and part.answered
            part.block, part.places = False, ()
        self._last = ()
        self.answered(number)

    def _finish(self, upto: int = -1) -> None:
        """Take out what is over: by the motions behind it, or all answered ones to line `upto`."""
        while self.parts and self.parts[0].answered:
            part = self.parts[0]
            if part.line.number > upto and self._over - part.block < self.holds:
                return
            self._over -= part.block
            self.executed, self.source = part.upto, part.line.source
            self.seconds += part.seconds
            self.parts.popleft()

    def reported(self, status: Status) -> None:
        """A report: how much the planner holds at least; and at rest twice, all is over that was
        answered before the first of both (once says nothing: what is planned may not have
        begun)."""
        if status.free:
            self._blocks = max(self._blocks, status.free[0] + 1)
        if status.state != REST:
            self._rested = -1
            return
        if self._rested >= 0:
            self._finish(self._rested)
        if not self.parts and status.place is not None:
            rows = self.order or range(len(status.place))
            self._last = tuple(status.place[k] if k < len(status.place) else math.nan for k in rows)
        self._rested = self.answered_to

    def forget(self) -> None:
        """Something else has moved the machine, or may have: where these lines go is not known."""
        for part in self.parts:
            part.places = ()

    def _merge(self) -> None:
        """The older half as one part for each block, which may go anywhere."""
        kept: deque[Part] = deque()
        for i, part in enumerate(self.parts):
            if kept and i < MOST // 2 and part.answered and kept[-1].answered and not part.block:
                kept[-1].upto, kept[-1].places = part.upto, ()
                kept[-1].seconds += part.seconds
            else:
                kept.append(part)
        self.parts = kept

    def running(self, status: Status) -> list[Part]:
        """The parts on which it can be at this report, or will be: fewer than `parts` where the
        report says how much of the planner is free. Nothing else follows from that: a report may be
        damaged."""
        if not status.free:
            return list(self.parts)
        held, behind = self._blocks - status.free[0] + self._segments, self._over
        for i, part in enumerate(self.parts):
            behind -= part.block and part.answered
            if not part.answered or behind < held:
                return list(self.parts)[i:]
        return []

    def likely(self, status: Status | None) -> tuple[int, float]:
        """Where it probably is: the last line that is over, and the share of the next that is.
        Good for telling the time, and for nothing else."""
        part, share = self._estimate.at(self.parts, self._blocks, status)
        if part is not None:
            return part.line.number - 1, share
        over = [part.upto for part in self.parts if part.answered and part.block]
        return max([self.executed, *over[-1:]]), 0.0

    def at(self, status: Status | None) -> WireLine | None:
        """The line in which it probably is; None: in none of those that were answered, or nothing
        says it."""
        part, _ = self._estimate.at(self.parts, self._blocks, status)
        return part.line if part is not None else None

    def lines(self) -> list[WireLine]:
        """Those that the machine may be executing, or will."""
        return [part.line for part in self.parts]
