"""A nominal motion as the reference machine makes it: its path through the axes, its place nearest
to a point, and on which side of its play each slide stands.

A slide that turns back by no more than the machine's hysteresis (and an increment, to which its
words were rounded) keeps its side.
"""

import math

import numpy as np

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


class Slide:
    """On which side of its play one slide stands: the sign of its last commanded motion, and how
    far it has come there.

    keeps: mm that it may turn back without another side, or move from its first place without any.
    """

    def __init__(self, axis, keeps):
        self.axis, self.keeps = axis, keeps
        self.side, self.farthest = 0, None

    def along(self, block):
        """[(t, side from there on)] of a block, which is thereby passed."""
        start, end = block.start[self.axis], block.end[self.axis]
        if start is None or end is None:
            if start != end:  # a move from or to nowhere known has no known direction
                self.side, self.farthest = 0, end
            return [(0.0, self.side)]
        changes = [(0.0, self.side)]
        cuts = turning_points(block, self.axis)
        for begin, stop in zip(cuts, cuts[1:]):
            t = self._change(block, begin, stop)
            if t is not None:
                changes.append((t, self.side))
        return changes

    def _change(self, block, begin, stop):
        """Pass a stretch without a reversal; where the side changes, or None."""
        at = lambda t: place(block, self.axis, t)
        if self.farthest is None:
            self.farthest = at(begin)
        way = 1 if at(stop) > at(begin) else -1
        beyond = lambda t: (at(t) - self.farthest) * way
        if way == self.side:
            if beyond(stop) > 0:
                self.farthest = at(stop)
            return None
        if beyond(stop) <= self.keeps:
            return None
        low, high = begin, stop
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (low, middle) if beyond(middle) > self.keeps else (middle, high)
        self.side, self.farthest = way, at(stop)
        return high


def place(block, axis, t):
    """mm: one axis at t of a block, wherever the others are."""
    if t in (0.0, 1.0):
        return (block.end if t else block.start)[axis]
    if block.kind == "arc" and axis in block.plane_axes:
        angle, radius = block.polar(t)
        k = block.plane_axes.index(axis)
        return block.centre[k] + radius * (math.cos(angle), math.sin(angle))[k]
    return block.start[axis] + (block.end[axis] - block.start[axis]) * t


def turning_points(block, axis):
    """0, 1 and the t between them at which an axis of an arc's plane reverses."""
    if block.kind != "arc" or axis not in block.plane_axes:
        return [0.0, 1.0]
    angle, _ = block.polar(0)
    quarter = 0.0 if axis == block.plane_axes[0] else math.pi / 2
    low, high = sorted((angle, angle + block.sweep))
    halves = range(math.ceil((low - quarter) / math.pi), math.floor((high - quarter) / math.pi) + 1)
    cuts = {(quarter + k * math.pi - angle) / block.sweep for k in halves}
    return [0.0, *sorted(t for t in cuts if 0.0 < t < 1.0), 1.0]


class Motion:
    """A nominal motion: its path through the axes."""

    def __init__(self, block, axes, marks):
        self.block, self.axes, self.marks = block, axes, marks
        self.known = block.known and block.kind != "machine"
        self.end_known = None not in block.end.values() and block.kind != "machine"
        self.length = (block.length or 0.0) if self.known else 0.0
        self.empty = self.known and self.length == 0.0

    def at(self, t):
        """(n,) mm: the path in the machine's axes."""
        point = self.block.point(t)
        return np.array([point[axis] for axis in self.axes])

    def _slope(self, t):
        block = self.block
        slope = np.array([block.end[axis] - block.start[axis] for axis in self.axes])
        if block.kind == "arc":
            angle, radius = block.polar(t)
            growth = block.polar(1)[1] - block.polar(0)[1]
            for axis, unit, normal in zip(
                block.plane_axes,
                (math.cos(angle), math.sin(angle)),
                (-math.sin(angle), math.cos(angle)),
            ):
                slope[self.axes.index(axis)] = growth * unit + radius * block.sweep * normal
        return slope

    def nearest(self, point, hint=None):
        """(t, distance in mm) of the point of the path that is nearest; among the turns of an arc,
        nearest to hint."""
        if self.empty:
            return 0.0, float(np.linalg.norm(self.at(0) - point))
        guesses = [0.0]
        if self.block.kind == "arc":
            angle, _ = self.block.polar(0)
            u, v = (
                point[self.axes.index(axis)] - c
                for axis, c in zip(self.block.plane_axes, self.block.centre)
            )
            turn = 2 * math.pi / abs(self.block.sweep)
            first = (math.atan2(v, u) - angle) / self.block.sweep % turn - turn
            guesses = [first + k * turn for k in range(math.floor(1.0 / turn) + 3)]
            # Beyond an end the end itself is nearest, so a guess is worth what it is when held
            # there.
            guesses = (
                sorted(guesses, key=lambda t: abs(t - hint))[:2] if hint is not None else guesses
            )
        best = None
        for t in guesses:
            t = min(max(t, 0.0), 1.0)
            for _ in range(30 if self.block.kind == "arc" else 1):  # a line is its own tangent
                slope, before = self._slope(t), t
                t = min(
                    max(t - float((self.at(t) - point) @ slope) / float(slope @ slope), 0.0), 1.0
                )
                if abs(t - before) * self.length < 1e-9:
                    break
            distance = float(np.linalg.norm(self.at(t) - point))
            worth = distance if hint is None else distance + 1e-3 * abs(t - hint) * self.length
            if best is None or worth < best[0]:
                best = worth, t, distance
        return best[1], best[2]
