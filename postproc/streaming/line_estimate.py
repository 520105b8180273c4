"""In which of its lines a machine probably is: good for telling a person, and the time, and for
nothing else.

A controller that says how much of its planner is free says by that on which motion it is. GRBL does
not where $10 has no 2 in it, as it comes: then its place tells. It comes by its lines in order, so
of those whose way passes that place it is in the first that is not before the one where it was seen
last.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from postproc.streaming.events import Status
from postproc.streaming.lines import Part


class LineEstimate:
    """near: mm from its way at which a machine stands on it; order: where each axis of a line's end
    stands in the reports, (): in the same order."""

    def __init__(self, near: float, order: tuple[int, ...] = ()):
        self._near, self._order = near, order
        self._last = 0  # number of the line in which it was seen last

    def at(
        self, parts: Iterable[Part], blocks: int, status: Status | None
    ) -> tuple[Part | None, float]:
        """The part in which it is, and the share of it that is over; None: of those that were
        answered all are. blocks: motions that the planner holds, one that it just takes
        included."""
        moving = [part for part in parts if part.block]
        answered = [part for part in moving if part.answered]
        if status is None or not moving:
            return None, 0.0
        if status.free:
            # The planner holds the last ones that were answered; the oldest of these is in
            # execution.
            planned = min(blocks - 1 - status.free[0], len(answered))
            if planned <= 0:
                return None, 0.0
            part = answered[-planned]
            return part, self._along(part, status)[1]
        # One that is not answered may be in execution: an arc is when all of it is planned.
        return self._by_place(moving[: len(answered) + 1], status)

    def _by_place(self, parts: Sequence[Part], status: Status) -> tuple[Part | None, float]:
        best: tuple[float, Part | None, float] = (math.inf, None, 0.0)
        for part in parts:
            if part.line.number < self._last:
                continue
            distance, share = self._along(part, status)
            if distance < best[0]:
                best = distance, part, share
            if distance <= self._near:
                break
        _, found, share = best
        if found is not None:
            self._last = found.line.number
        return found, share

    def _along(self, part: Part, status: Status) -> tuple[float, float]:
        """How far from this way it is, mm, and the share of the way behind it; inf: that is not
        known."""
        if status.place is None or len(part.places) < 2:
            return math.inf, 0.0
        rows = self._order or range(len(part.places[0]))
        seen = [k for k, row in enumerate(rows) if row < len(status.place)]
        points = np.array(part.places)[:, seen]
        points = points[:, ~np.isnan(points).any(axis=0)]
        if points.shape[1] < len(seen):
            return math.inf, 0.0
        return along(points, np.array([status.place[rows[k]] for k in seen]))


def along(points: np.ndarray, place: np.ndarray) -> tuple[float, float]:
    """How far a place (A,) is from a polyline (K, A), and the share of its length up to there."""
    step = np.diff(points, axis=0)
    length = np.linalg.norm(step, axis=1)
    square = np.where(length > 0, length**2, 1.0)
    part = np.clip(((place - points[:-1]) * step).sum(axis=1) / square, 0.0, 1.0)
    distance = np.linalg.norm(points[:-1] + part[:, None] * step - place, axis=1)
    i = int(np.argmin(distance))
    whole = float(length.sum())
    share = (float(length[:i].sum()) + part[i] * length[i]) / whole if whole > 0 else 0.0
    return float(distance[i]), float(share)
