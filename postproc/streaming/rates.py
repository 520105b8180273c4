"""What a link must carry, and how long a job takes: from feeds, bytes and baud, without
acceleration."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from postproc.streaming.account import Account
from postproc.streaming.events import Status
from postproc.streaming.lines import WireLine
from postproc.streaming.pace import Pace

# lines over which controller and buffer even the load out: about a planner and a receive buffer
AHEAD = 32
MOST = 0.8  # part of the link that a job may use


@dataclass
class Load:
    """A program as a load on a link of `rate` bytes/s (0: no limit). add() every line, in order."""

    rate: float = 0.0
    lines: int = 0
    bytes: int = 0
    motion: float = 0.0
    expected: float = 0.0
    worst: float = 0.0
    worst_lines: tuple[int, int] = (0, 0)
    worst_rate: float = 0.0
    worst_size: float = 0.0
    over: float = 0.0
    _window: deque[tuple[int, float, int]] = field(default_factory=deque)
    _sum: list[float] = field(default_factory=lambda: [0.0, 0.0])

    def add(self, line: WireLine) -> None:
        size = len(line.text) + 1
        self.lines += 1
        self.bytes += size
        self.motion += line.seconds
        self.expected += self.seconds(line)
        if not self.rate:
            return
        self._window.append((size, line.seconds, line.source))
        self._sum[0] += size
        self._sum[1] += line.seconds
        if len(self._window) > AHEAD:
            old = self._window.popleft()
            self._sum[0] -= old[0]
            self._sum[1] -= old[1]
        if len(self._window) == AHEAD:
            time = max(self._sum[1], 1e-9)
            # s on the wire for each s of motion, over as many lines as buffer and planner even out
            need = self._sum[0] / self.rate / time
            if need > MOST:
                self.over += line.seconds
            if need > self.worst and self._sum[1] > 0:
                self.worst, self.worst_rate = need, AHEAD / time
                self.worst_size = self._sum[0] / AHEAD
                self.worst_lines = (self._window[0][2], line.source)

    def seconds(self, line: WireLine) -> float:
        """How long a line takes: its motion, or its way over the wire where that is longer."""
        return max(line.seconds, self.link(line))

    def link(self, line: WireLine) -> float:
        """s of its way over the wire."""
        return (len(line.text) + 1) / self.rate if self.rate else 0.0

    def warning(self) -> str:
        """What to tell where the link is too slow for the feeds, or ""."""
        if self.worst <= MOST:
            return ""
        carries = self.rate / self.worst_size
        where = (
            "source line {0}"
            if self.worst_lines[0] == self.worst_lines[1]
            else "source lines {0} to {1}"
        )
        return (
            f"{where.format(*self.worst_lines)} need {self.worst_rate:.0f} lines/s of"
            f" {self.worst_size:.0f} bytes, and the link carries {carries:.0f} ({self.rate:.0f}"
            f" bytes/s): the machine will slow down or stutter there, {self.over:.1f} s of"
            f" {self.motion:.0f} s of motion; --compact, a wider --tolerance or a faster --baud"
            " help"
        )


@dataclass
class Clock:
    """What is left: by the load's seconds, by a planner's where it knows the machine's
    accelerations, and by how the job went so far.
    held: s that it stood in a hold, which say nothing of the pace; rate: the feed's override, 1: as
    programmed."""

    expected: float
    started: float
    pace: Pace | None = None
    done: float = 0.0
    held: float = 0.0
    rate: float = 1.0

    def over(self, account: Account, status: Status | None) -> None:
        """Take where the machine is."""
        if self.pace is None:
            self.done = account.seconds
            return
        line, share = account.likely(status)
        begin, end = self.pace.at(line), self.pace.at(line + 1)
        self.done = begin + (end - begin) * share

    def left(self, now: float) -> float:
        """s to the end, as far as can be said."""
        spent = now - self.started - self.held
        rest = max(0.0, self.expected - self.done) / max(self.rate, 0.1)
        if self.done > 5.0 and spent > 5.0:  # the machine's own pace, once there is enough of it
            # within a factor of two faster and four slower: the first lines of a job are no measure
            # of it
            return rest * max(0.5, min(4.0, spent * self.rate / self.done))
        return rest
