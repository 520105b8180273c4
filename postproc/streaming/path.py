"""Whether the machine stands on the path of the lines that it may be executing: what a GRBL without echo can not say, its reports show.

A report stands in the stream behind the answers that were given before it. So of the motions that were answered by then, all but as many
as the planner holds are over; the machine is somewhere on these, or on what was sent behind them. Their firmware does not round
corners: what may explain a distance is a step of the motors, an arc's chords, and the digits of a report.

Nothing is concluded where the path is not known: around homing, G28, probing and
tool changes, in states in which something else than the program moves, and behind a refused line.
"""

from __future__ import annotations

import math
import re
from collections import deque

import numpy as np

from postproc.streaming.events import Status
from postproc.streaming.limits import Limits
from postproc.streaming.lines import WireLine
from postproc.streaming.protocols import Controller

JUDGED = {"run", "hold"}
REST = "idle"
SPARE = 2  # motions: the one that is just being taken, and one for the doubt
SHORT = 0.05  # mm: a motion below a step never comes into the planner
UNKNOWN_PLANNER = (
    130  # motions, where a controller does not say how many it holds (FluidNC's may be configured up to 120)
)
MOST = 4096
# M6 and macros may move in ways of their own.
OTHER = re.compile(rb"M0*(?:6|6[0-9]|9[89]|[1-9][0-9]{2,})(?![0-9])|G0*6[56](?![0-9])|^\$", re.IGNORECASE)
AXES = re.compile(rb"[A-CI-KRU-Z]", re.IGNORECASE)
LOOK, OFF, CLEAR = "look", "off", "clear"


def nearest(points: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, float]:
    """The point of a polyline (K, A) that is nearest to a place (A,), and its distance."""
    start, step = points[:-1], np.diff(points, axis=0)
    square = (step**2).sum(axis=1)
    share = ((place - start) * step).sum(axis=1) / np.where(square > 0, square, 1.0)
    near = start + np.clip(share, 0.0, 1.0)[:, None] * step
    distance = np.linalg.norm(near - place, axis=1)
    i = int(np.argmin(distance))
    return near[i], float(distance[i])


def coarsest_step(controller: Controller) -> float:
    """mm: of the motors, by $100 and on; 0 where it does not say so."""
    said = [controller.settings.get(str(100 + i), "") for i in range(6)]
    known = [float(s) for s in said if re.fullmatch(r"[0-9]*\.?[0-9]+", s) and float(s) > 0]
    return max((1.0 / k for k in known), default=0.0)


class _Part:
    """One motion: its places, () where anything may happen; whether it was answered."""

    __slots__ = ("answered", "line", "places")

    def __init__(self, line: WireLine, places: tuple[tuple[float, ...], ...]):
        self.line, self.places, self.answered = line, places, False


class Path:
    """sent() and answered() for every line, judge() for every report. order: where each axis of a line's `end` stands in the
    reports, (): in the same order. limit: mm. Without a controller nothing is watched.
    distance, nearest: mm beside the path, and the line that is nearest, as they were seen last; doubts: how often."""

    def __init__(
        self, controller: Controller | None = None, order: tuple[int, ...] = (), limit: float = Limits.path_mm
    ):
        self.order = order
        self.limit = limit + (2 * coarsest_step(controller) if controller else 0.0)
        self._planner = controller.planner if controller and controller.planner_told else UNKNOWN_PLANNER
        self._parts: deque[_Part] = deque()
        self._by: dict[int, _Part] = {}
        self._last: tuple[float, ...] = ()
        self._idle = 0  # reports of rest since the last answer
        self._over = 0  # answered motions among the parts that came into the planner
        self._lost = controller is None
        self.doubts = 0
        self.distance = 0.0
        self.nearest: WireLine | None = None

    @property
    def watched(self) -> bool:
        return not self._lost

    def sent(self, line: WireLine) -> None:
        """A line that left."""
        if self._lost or line.number <= 0:
            return
        end = () if OTHER.search(line.text) else line.end
        if end and not AXES.search(line.text):
            return  # where the program believes that it stands; it may have been jogged since
        start, self._last = self._last, end
        if start and end:
            start += (math.nan,) * (len(end) - len(start))
            if not line.points and all(a == b or (a != a and b != b) for a, b in zip(start, end, strict=True)):
                return  # no motion
        known = line.straight and bool(start and end)
        part = _Part(line, (start, *line.points, end) if known else ())
        self._parts.append(part)
        self._by[line.number] = part
        if len(self._parts) > MOST:  # many motions without any length
            self.forget()

    def answered(self, number: int) -> None:
        """A line that was taken."""
        part = self._by.pop(number, None)
        if part is None:
            return
        part.answered = True
        self._idle = 0
        self._over += self._long(part)
        while self._parts and self._parts[0].answered:
            long = self._long(self._parts[0])
            if self._over - long < self._planner + SPARE:
                break
            self._over -= long
            self._parts.popleft()

    @staticmethod
    def _long(part: _Part) -> bool:
        places = part.places
        if len(places) != 2:
            return True
        return sum((b - a) ** 2 for a, b in zip(*places, strict=True) if not math.isnan(b - a)) >= SHORT**2

    def forget(self) -> None:
        """Something else has moved the machine, or may have: what was sent so far tells nothing."""
        for part in self._parts:
            part.places = ()
        while len(self._parts) > MOST // 2:
            self._by.pop(self._parts.popleft().line.number, None)
        self._over = sum(1 for part in self._parts if part.answered)

    def lose(self) -> None:
        """From here on the lines do not say where the machine goes: one of them was left out."""
        self._parts.clear()
        self._by.clear()
        self._lost = True

    def lines(self) -> list[WireLine]:
        """Those that the machine may be executing."""
        return [part.line for part in self._parts]

    def judge(self, status: Status) -> str:
        """LOOK: it seems to stand beside the path; hold it, and ask again. OFF: it does (`distance`, mm, and `nearest` say how far
        from which line). CLEAR: it was held for that, stands, and is on the path. "": nothing new."""
        found = self._off(status)
        if found is not None:
            self.distance, self.nearest = found
            self.doubts += 1
            return LOOK if self.doubts == 1 else OFF
        if self.doubts and (status.state == REST or (status.state in JUDGED and status.detail == "0")):
            self.doubts = 0
            return CLEAR
        return ""

    def _off(self, status: Status) -> tuple[float, WireLine] | None:
        if status.free:
            self._planner = max(self._planner, status.free[0] + 1)
        if status.state == REST:
            self._rests(status)
            return None
        self._idle = 0
        if status.state not in JUDGED:
            self.forget()
            return None
        if not self._parts or status.place is None or any(not part.places for part in self._parts):
            return None
        n = len(self._parts[0].places[0])
        rows = self.order or range(n)
        seen = [k for k, row in enumerate(rows) if k < n and row < len(status.place)]
        place = np.array([status.place[rows[k]] for k in seen])
        best, at = math.inf, self._parts[0].line
        for part in self._parts:
            points = np.array(part.places)[:, seen]
            unknown = np.isnan(points).any(axis=0)
            points[:, unknown] = place[unknown]
            _, distance = nearest(points, place)
            if distance < best:
                best, at = distance, part.line
                if best <= self.limit:
                    return None
        return best, at

    def _rests(self, status: Status) -> None:
        """Idle twice, with no answer in between: what was answered is over. (Once says nothing: what is planned may not have begun.)"""
        self._idle += 1
        while self._idle > 1 and self._parts and self._parts[0].answered:
            self._over -= self._long(self._parts.popleft())
        if not self._parts and status.place is not None and not self._lost:
            rows = self.order or range(len(status.place))
            self._last = tuple(status.place[k] if k < len(status.place) else math.nan for k in rows)
