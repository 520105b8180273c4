r"""How long motions take, with accelerations: a planner that looks as far ahead as the
controller's.

GRBL's rules (gnea/grbl planner.c, the comments above planner_recalculate, and plan_buffer_line):
along a motion the rate and the acceleration of the slowest axis for its direction ($110.., $120..)
count; at a junction the speed at which a circle that leaves the corner by $11 could be gone round
with that acceleration; before a stop of the queue it can brake to zero within what it holds.

Squares of speeds rise and fall evenly along the way, by 2 a per mm:

    v^2 |      _____________ rate^2         Without room for the rate both ramps meet where
        |     /             \               peak^2 = (2 a length + enter^2 + leave^2) / 2.
        |    /               \ leave^2
        |   / enter^2         |
        +--------------------------> way

At a corner of angle theta between the ways (straight on: 180 degrees) the circle that touches both
and passes $11 beside the corner has the radius R = $11 sin(theta/2) / (1 - sin(theta/2)), and v^2 =
a R.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence

from postproc.streaming.lines import WireLine
from postproc.streaming.protocols import Controller

EVERY = 64  # lines between two sums that are kept
DEVIATION = 0.01  # mm, $11 where it is not said
STOPS = 1e-9


class Block:
    """A motion in the queue. rate: mm/s; most: square of the speed with which it may begin; entry:
    with which it does."""

    __slots__ = ("acceleration", "entry", "least", "length", "most", "rate")

    def __init__(self, length: float, rate: float, acceleration: float, most: float, least: float):
        self.length = length
        self.rate = rate
        self.acceleration = acceleration
        self.most = most
        self.least = least
        self.entry = most

    def seconds(self, leave: float) -> float:
        """From the square of its entry speed to the square of that of the next, up to its rate
        between."""
        a, v = self.acceleration, self.rate
        enter, leave = min(self.entry, v * v), min(leave, v * v)
        peak = min(v * v, (2 * a * self.length + enter + leave) / 2)
        # up to the peak and down from it: (v_peak - v_enter) / a + (v_peak - v_leave) / a
        ramps = (2 * math.sqrt(max(peak, 0.0)) - math.sqrt(enter) - math.sqrt(leave)) / a
        cruise = self.length - (2 * peak - enter - leave) / (2 * a)
        return max(self.least, ramps + max(cruise, 0.0) / max(math.sqrt(max(peak, STOPS)), STOPS))


class Pace:
    """add() every line of a job in order, then end(). wire: s that a line takes on the link at
    least; order: where each axis of a line's end stands in the settings. total: s."""

    def __init__(
        self, controller: Controller, order: Sequence[int], wire: Callable[[WireLine], float]
    ):
        self._rates = [(controller.setting(110 + k) or math.inf) / 60 for k in order]
        self._accelerations = [controller.setting(120 + k) or math.inf for k in order]
        self._deviation = controller.setting(11) or DEVIATION
        self._ahead, self._wire = max(2, min(controller.planner, 256)), wire
        self._queue: deque[Block] = deque()
        self._last: tuple[float, ...] = ()
        self._direction: list[float] = []
        self._before = 0.0  # square of the speed at which the last block may run
        self._leave = 0.0
        self.total = 0.0
        self._sums: list[float] = [0.0]
        self._n = 0

    @property
    def knows(self) -> bool:
        """Whether the controller says its accelerations."""
        return any(math.isfinite(a) for a in self._accelerations)

    def add(self, line: WireLine) -> None:
        start, self._last = self._last, line.end or ()
        if line.length > 0 and line.seconds > 0 and len(start) == len(line.end) > 0:
            self._motion(line, start)
        elif line.seconds > 0 or not line.length:
            wait = max(line.seconds, self._wire(line))
            if line.seconds > 0:  # a dwell: the queue runs empty
                self._empty()
            self.total += wait if line.seconds > 0 else 0.0
        self._n += 1
        if self._n % EVERY == 0:
            # A sum every 64 lines in the place of one a line: a program may have millions.
            self._sums.append(self.total + self._waiting())

    def _motion(self, line: WireLine, start: tuple[float, ...]) -> None:
        places = [start, *line.points, line.end]
        enter = _unit(places[0], places[1])
        leave = _unit(places[-2], places[-1])
        if enter is None or leave is None:
            self.total += line.seconds
            return
        rate = min(line.length / line.seconds, _limit(self._rates, enter))
        acceleration = _limit(self._accelerations, enter)
        if not math.isfinite(acceleration):
            self.total += max(line.seconds, self._wire(line))
            return
        if line.points:  # round a curve no faster than its own junctions allow
            rate = min(rate, math.sqrt(self._chords(places, acceleration)))
        most = (
            min(rate * rate, self._before, self._junction(enter, acceleration))
            if self._queue
            else 0.0
        )
        self._queue.append(Block(line.length, rate, acceleration, most, self._wire(line)))
        self._before, self._direction = rate * rate, leave
        if len(self._queue) > self._ahead:
            self._take()

    def _junction(self, enter: list[float], acceleration: float) -> float:
        """Square of the speed round the corner (planner.c, junction deviation)."""
        cosine = -sum(a * b for a, b in zip(self._direction, enter, strict=True))
        if cosine > 0.999999:
            return 0.0  # it turns back
        if cosine < -0.999999:
            return math.inf
        half = math.sqrt(0.5 * (1.0 - cosine))  # sin(theta / 2)
        return acceleration * self._deviation * half / (1.0 - half)

    def _chords(self, places: Sequence[Sequence[float]], acceleration: float) -> float:
        """Square of the speed at which a curve's chords may follow each other: a circle of its
        radius."""
        first = _unit(places[0], places[1])
        second = _unit(places[1], places[2]) if len(places) > 2 else None
        if first is None or second is None:
            return math.inf
        turn = math.acos(
            max(-1.0, min(1.0, sum(a * b for a, b in zip(first, second, strict=True))))
        )
        chord = math.dist(places[0][: len(first)], places[1][: len(first)])
        return acceleration * chord / turn if turn > 1e-6 and chord == chord else math.inf

    def _backward(self) -> None:
        """What each block must not exceed so that the last one can stop."""
        after = 0.0
        for block in reversed(self._queue):
            block.entry = min(block.most, after + 2 * block.acceleration * block.length)
            after = block.entry

    def _take(self) -> None:
        """The oldest block is executed."""
        self._backward()
        block = self._queue.popleft()
        # Backwards says how fast it may be so as to brake in time, forwards how fast it can be by
        # now: the lower one holds.
        block.entry = min(block.entry, self._leave)
        following = self._queue[0].entry if self._queue else 0.0
        self._leave = min(following, block.entry + 2 * block.acceleration * block.length)
        self.total += block.seconds(self._leave)

    def _empty(self) -> None:
        while self._queue:
            self._take()

    def _waiting(self) -> float:
        """About what lies in the queue."""
        return sum(max(block.least, block.length / block.rate) for block in self._queue)

    def end(self) -> None:
        """No more lines."""
        self._empty()
        self._sums.append(max(self.total, self._sums[-1]))

    def at(self, line: int) -> float:
        """s of the job that are over when so many lines are."""
        k = min(line // EVERY, len(self._sums) - 2)
        low, high = self._sums[k], self._sums[k + 1]
        lines = EVERY if k < len(self._sums) - 2 else max(1, self._n - k * EVERY)
        return low + (high - low) * min(1.0, (line - k * EVERY) / lines)


def _unit(a: Sequence[float], b: Sequence[float]) -> list[float] | None:
    """The direction from a to b; None where there is none, or it is not known."""
    step = [0.0 if x != x or y != y else y - x for x, y in zip(a, b, strict=True)]
    length = math.sqrt(sum(v * v for v in step))
    return [v / length for v in step] if length > 0 else None


def _limit(most: Sequence[float], direction: Sequence[float]) -> float:
    """How much along a direction when each axis has its own most (planner.c,
    limit_value_by_axis_maximum)."""
    return min(
        (limit / abs(d) for limit, d in zip(most, direction, strict=True) if abs(d) > 1e-12),
        default=math.inf,
    )
