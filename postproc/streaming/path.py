"""Whether the machine stands on the path of the lines that it may be executing: what a GRBL without
echo can not say, its reports show.

A report stands in the stream behind the answers that were given before it. So the machine is
somewhere on the lines that are not over by the account of execution (`account`). Their firmware
does not round corners: what may explain a distance is a step of the motors, an arc's chords, and
the digits of a report.

Nothing is concluded where the path is not known: around homing, G28, probing and
tool changes, in states in which something else than the program moves, and behind a refused line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from postproc.streaming.account import REST, Account
from postproc.streaming.events import Status
from postproc.streaming.limits import Limits
from postproc.streaming.lines import Part, WireLine
from postproc.streaming.protocols import Controller

JUDGED = {"run", "hold"}
RUN_ON = 2.0  # mm
LOOK, OFF, CLEAR = "look", "off", "clear"


def nearest(points: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, float]:
    """The point of a polyline (K, A) that is nearest to a place (A,), and its distance."""
    start, step = points[:-1], np.diff(points, axis=0)
    square = (step**2).sum(axis=1)
    # foot of the perpendicular on each leg, 0 at its start and 1 at its end, held within the leg
    share = ((place - start) * step).sum(axis=1) / np.where(square > 0, square, 1.0)
    near = start + np.clip(share, 0.0, 1.0)[:, None] * step
    distance = np.linalg.norm(near - place, axis=1)
    i = int(np.argmin(distance))
    return near[i], float(distance[i])


class Path:
    """judge() for every report, which also goes to the account. order: where each axis of a line's
    `end` stands in the reports, (): in the same order. limit: mm. watched: whether it looks.
    distance, nearest: mm beside the path, and the line that is nearest, as they were seen last;
    off_path: how often."""

    def __init__(
        self,
        controller: Controller,
        order: tuple[int, ...] = (),
        limit: float = Limits.path_mm,
        watched: bool = True,
    ):
        self.order = order
        self.account = Account(controller, order)
        self.limit = limit + 2 * controller.coarsest_step
        self._lost = not watched
        self.off_path = 0
        self.distance = 0.0
        self._beside: tuple[float, ...] | None = None  # the place that was seen beside it last
        self.nearest: WireLine | None = None

    @property
    def watched(self) -> bool:
        return not self._lost

    def lose(self) -> None:
        """From here on the lines do not say where the machine goes: one of them was left out."""
        self._lost = True

    def lines(self) -> list[WireLine]:
        """Those that the machine may be executing."""
        return self.account.lines()

    def judge(self, status: Status) -> str:
        """LOOK: it seems to stand beside the path; hold it, and ask again. OFF: it does, twice at
        one place (`distance`, mm, and `nearest` say how far from which line). CLEAR: it was held
        for that, stands, and is on the path. "": nothing new."""
        self.account.reported(status)
        found = None if self._lost else self._off(status)
        if found is not None:
            self.distance, self.nearest = found
            self.off_path += 1
            before, self._beside = self._beside, status.place
            return LOOK if self.off_path == 1 else OFF if self._same(before, status.place) else ""
        if self.off_path and (
            status.state == REST or (status.state in JUDGED and status.detail == "0")
        ):
            self.off_path, self._beside = 0, None
            return CLEAR
        return ""

    def _same(self, one: tuple[float, ...] | None, other: tuple[float, ...] | None) -> bool:
        """Whether two reports say one place, but for what it ran on while it slowed down: two that
        were damaged hardly do."""
        if one is None or other is None or len(one) != len(other):
            return False
        return max(abs(a - b) for a, b in zip(one, other, strict=True)) <= RUN_ON

    def _off(self, status: Status) -> tuple[float, WireLine] | None:
        if status.state != REST and status.state not in JUDGED:
            self.account.forget()
            return None
        parts = [] if status.state == REST else self.account.running(status)
        if not parts or status.place is None or any(not part.places for part in parts):
            return None
        return self._nearest(parts, *self._seen(status.place, len(parts[0].places[0])))

    def _seen(self, place: tuple[float, ...], count: int) -> tuple[list[int], np.ndarray]:
        """Which of so many axes a report has, and where it says that they are, mm."""
        rows = list(self.order or range(count))[:count]
        seen = [k for k, row in enumerate(rows) if row < len(place)]
        return seen, np.array([place[rows[k]] for k in seen])

    def _nearest(
        self, parts: Sequence[Part], seen: list[int], place: np.ndarray
    ) -> tuple[float, WireLine] | None:
        """The part beside which it is least, and by how much; None: within the limit. seen: rows
        of the parts' places that the report has; place: mm, those of the report."""
        #            x  the report          The least distance from any line that is not over:
        #            :                      a machine that is late, or ahead, is on one of them, and
        #   o--------+------o------o         one beside them all is not where it was sent. Axes
        #     over     may be executed       that are not known are taken as they are reported.
        best, at = math.inf, parts[0].line
        for part in parts:
            points = np.array(part.places)[:, seen]
            unknown = np.isnan(points).any(axis=0)
            points[:, unknown] = place[unknown]
            _, distance = nearest(points, place)
            if distance < best:
                best, at = distance, part.line
                if best <= self.limit:
                    return None
        return best, at
