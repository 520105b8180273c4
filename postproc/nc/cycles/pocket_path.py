"""How a closed pocket is cleared: once around it at a distance from its wall, then stroke by stroke
across, from wall to wall.

All lies in the plane, (x, y). The tool's centre stays on or within the contour at the distance, so
that it comes nowhere nearer to the wall; from stroke to stroke it goes along that contour, where
it has cut before. A shape may overlap itself where it leads to an island and back: what lies
within its other parts is no wall there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

Point = tuple[float, float]
NEAR = 1e-7  # of the program's unit: places that a rounding tells apart
TANGENT = 1e-6  # rad: no corner
SAMPLES = 33  # places on a piece that are looked at
MOST_STROKES = 10_000


class DoesNotFit(Exception):
    """The tool does not reach along all of the shape."""


@dataclass(frozen=True)
class Piece:
    """A line (`turn` 0) or an arc about `centre`, counter-clockwise (1) or clockwise (-1); one that
    ends where it began is a full circle."""

    turn: int
    start: Point
    end: Point
    centre: Point = (0.0, 0.0)

    @property
    def radius(self) -> float:
        return math.dist(self.start, self.centre)

    @property
    def sweep(self) -> float:
        """rad, above 0."""
        angle = (self.turn * (self._angle(self.end) - self._angle(self.start))) % math.tau
        return angle if min(angle, math.tau - angle) * self.radius > NEAR else math.tau

    @property
    def length(self) -> float:
        return self.sweep * self.radius if self.turn else math.dist(self.start, self.end)

    def _angle(self, p: Point) -> float:
        return math.atan2(p[1] - self.centre[1], p[0] - self.centre[0])

    def at(self, share: float) -> Point:
        """The place behind a share of its length."""
        if not self.turn:
            (x0, y0), (x1, y1) = self.start, self.end
            return x0 + share * (x1 - x0), y0 + share * (y1 - y0)
        angle = self._angle(self.start) + self.turn * share * self.sweep
        r = self.radius
        return self.centre[0] + r * math.cos(angle), self.centre[1] + r * math.sin(angle)

    def part(self, first: float, last: float) -> Piece:
        """From one share of its length to another, also backwards."""
        turn = self.turn if last > first else -self.turn
        return replace(self, turn=turn, start=self.at(first), end=self.at(last))

    def tangent(self, at_end: bool) -> Point:
        """The direction of travel, length 1."""
        if not self.turn:
            size = math.dist(self.start, self.end)
            (x0, y0), (x1, y1) = self.start, self.end
            return (x1 - x0) / size, (y1 - y0) / size
        p = self.end if at_end else self.start
        arm = (p[0] - self.centre[0]) / self.radius, (p[1] - self.centre[1]) / self.radius
        return -self.turn * arm[1], self.turn * arm[0]

    def share_of(self, p: Point) -> float | None:
        """The share of its length at which a place lies on it; None: it does not."""
        if self.turn:
            turned = (self.turn * (self._angle(p) - self._angle(self.start))) % math.tau
            share = turned / self.sweep
            near = abs(math.dist(p, self.centre) - self.radius) < NEAR
        else:
            t, size = self.tangent(False), self.length
            away = p[0] - self.start[0], p[1] - self.start[1]
            share = (away[0] * t[0] + away[1] * t[1]) / size
            near = abs(away[0] * t[1] - away[1] * t[0]) < NEAR
        return share if near and 0.0 < share < 1.0 else None

    def crossings(self, axis: int, value: float) -> list[float]:
        """Shares of its length at which coordinate `axis` has this value."""
        if not self.turn:
            way = self.end[axis] - self.start[axis]
            share = (value - self.start[axis]) / way if way else -1.0
            return [share] if 0.0 <= share < 1.0 else []
        away = (value - self.centre[axis]) / self.radius
        if abs(away) >= 1.0:
            return []
        turn = math.acos(away) if axis == 0 else math.asin(away)
        angles = (turn, -turn) if axis == 0 else (turn, math.pi - turn)
        begin = self._angle(self.start)
        shares = [((self.turn * (a - begin)) % math.tau) / self.sweep for a in angles]
        return [s for s in shares if s < 1.0]


def area(shape: list[Piece]) -> float:
    """What a closed shape encloses, above 0 where it runs counter-clockwise."""
    total = 0.0
    for p in shape:  # triangles from the zero, and the segment between each arc and its chord
        total += (p.start[0] * p.end[1] - p.end[0] * p.start[1]) / 2
        if p.turn:
            total += p.turn * p.radius**2 * (p.sweep - math.sin(p.sweep)) / 2
    return total


def across(a: Piece, b: Piece) -> float:
    """The sine of the angle by which the way turns from one piece to the next, left above 0."""
    s, t = a.tangent(True), b.tangent(False)
    return s[0] * t[1] - s[1] * t[0]


def corner(a: Piece, b: Piece) -> float:
    """rad by which the way turns from one piece to the next, left above 0."""
    s, t = a.tangent(True), b.tangent(False)
    return math.atan2(across(a, b), s[0] * t[0] + s[1] * t[1])


# -- the contour -----------------------------------------------------------------------------------


def beside(shape: list[Piece], distance: float, side: int) -> list[Piece]:
    """The closed shape `distance` to the left (`side` 1) or right (-1) of its way: cut off in inner
    corners, round about outer ones. Raises DoesNotFit."""
    moved = [aside(p, distance * side) for p in shape]
    ends: list[Point] = []
    joints: list[Piece | None] = []
    for k, (a, b) in enumerate(zip(shape, [*shape[1:], shape[0]], strict=True)):
        one, other, turn = moved[k], moved[(k + 1) % len(moved)], corner(a, b)
        joint = None
        if abs(turn) < TANGENT:  # both moved ends are one place
            ends.append(one.end)
        elif turn * side > 0 and abs(turn) < math.pi - TANGENT:
            ends.append(_meeting(one, other))
        else:
            ends.append(one.end)
            joint = Piece(-side, one.end, other.start, a.end)  # about the old corner
        joints.append(joint)
    contour: list[Piece] = []
    for k, p in enumerate(moved):
        before = joints[k - 1]
        new = replace(p, start=before.end if before else ends[k - 1], end=ends[k])
        if math.dist(new.start, new.end) > NEAR or (p.turn and p.sweep == math.tau):
            _keeps_sense(p, new)
            contour.append(new)
        joint = joints[k]
        if joint is not None:
            contour.append(joint)
    if not contour:
        raise DoesNotFit
    keeps_away(walls(shape, side), contour, distance)
    return contour


def aside(p: Piece, left: float, least: float = NEAR) -> Piece:
    """The piece moved sideways. Raises DoesNotFit where the radius of an arc would not be above
    `least`."""
    if not p.turn:
        t = p.tangent(False)
        by = -t[1] * left, t[0] * left

        def shift(q: Point) -> Point:
            return q[0] + by[0], q[1] + by[1]

        return replace(p, start=shift(p.start), end=shift(p.end))
    scale = (p.radius - left * p.turn) / p.radius
    if scale * p.radius <= least:
        raise DoesNotFit

    def away(q: Point) -> Point:
        x, y = (c + (v - c) * scale for v, c in zip(q, p.centre, strict=True))
        return x, y

    return replace(p, start=away(p.start), end=away(p.end))


def _meeting(a: Piece, b: Piece) -> Point:
    """Where two pieces meet, on longer ones if need be: the place nearest to their ends."""
    middle = (a.end[0] + b.start[0]) / 2, (a.end[1] + b.start[1]) / 2
    places = _circles(a, b) if a.turn and b.turn else with_line(a, b)
    if not places:
        raise DoesNotFit
    return min(places, key=lambda p: math.dist(p, middle))


def with_line(a: Piece, b: Piece, touches: bool = False) -> list[Point]:
    """Where two pieces, one of them a line, meet, both as long as need be. `touches`: whether a
    line that misses an arc by a rounding touches it."""
    line, other = (b, a) if a.turn else (a, b)
    # At (x, y) + k s, s of length 1: of two lines the cross product with the other's direction t
    # leaves k alone. A circle is met half a chord before and behind the foot of its centre.
    s, (x, y) = line.tangent(False), line.start
    if not other.turn:
        t = other.tangent(False)
        away = other.start[0] - x, other.start[1] - y
        k = (away[0] * t[1] - away[1] * t[0]) / (s[0] * t[1] - s[1] * t[0])
        return [(x + k * s[0], y + k * s[1])]
    to = other.centre[0] - x, other.centre[1] - y
    foot, off = to[0] * s[0] + to[1] * s[1], s[0] * to[1] - s[1] * to[0]
    if abs(off) > other.radius and not touches:
        return []
    half = math.sqrt(max(other.radius**2 - off**2, 0.0))
    return [(x + k * s[0], y + k * s[1]) for k in (foot - half, foot + half)]


def _circles(a: Piece, b: Piece) -> list[Point]:
    #        o          along^2 + half^2 = Ra^2
    #   Ra / | \ Rb     (apart - along)^2 + half^2 = Rb^2
    #     a--+--b       their difference has `along` alone
    apart = math.dist(a.centre, b.centre)
    if not abs(a.radius - b.radius) <= apart <= a.radius + b.radius or not apart:
        return []
    along = (apart**2 + a.radius**2 - b.radius**2) / (2 * apart)
    half = math.sqrt(max(a.radius**2 - along**2, 0.0))
    u = (b.centre[0] - a.centre[0]) / apart, (b.centre[1] - a.centre[1]) / apart
    foot = a.centre[0] + along * u[0], a.centre[1] + along * u[1]
    return [(foot[0] - k * u[1], foot[1] + k * u[0]) for k in (half, -half)]


def _keeps_sense(before: Piece, new: Piece) -> None:
    """A piece that was cut off from both sides beyond its middle runs backwards."""
    if before.turn:
        wrong = new.sweep > before.sweep + math.pi  # it runs nearly all the way round
    else:
        s, t = before.tangent(False), new.tangent(False)
        wrong = s[0] * t[0] + s[1] * t[1] < 0
    if wrong:
        raise DoesNotFit


def walls(shape: list[Piece], side: int) -> list[Piece]:
    """The parts of a closed shape beyond which nothing is cut. side: of the tool, 1: left."""
    parts: list[Piece] = []
    for p in shape:
        cuts = {0.0, 1.0}
        for other in shape:
            places = [other.start, other.end, *_on_both(p, other)]
            cuts |= {s for q in places if (s := p.share_of(q)) is not None}
        for low, high in pairwise(sorted(cuts)):
            if (high - low) * p.length > NEAR:
                parts.append(p.part(low, high))
    beyond = []
    for p in parts:
        (x, y), t = p.at(0.5), p.part(0.0, 0.5).tangent(True)
        beyond.append((x + side * 1e-5 * t[1], y - side * 1e-5 * t[0]))  # away from the tool
    return [p for p, q in zip(parts, beyond, strict=True) if not _around(shape, q)]


def _on_both(a: Piece, b: Piece) -> list[Point]:
    if a is b:
        return []
    if a.turn and b.turn:
        places = _circles(a, b)
    elif a.turn or b.turn or abs(math.sin(corner(a, b))) > TANGENT:
        places = with_line(a, b)
    else:
        return []
    return [q for q in places if b.share_of(q) is not None]


def _around(shape: list[Piece], place: Point) -> int:
    """How often a closed shape runs around a place."""
    total = 0.0
    for p in shape:
        steps = max(2, math.ceil(p.sweep / 0.01)) if p.turn else 2
        ends = [p.at(k / (steps - 1)) for k in range(steps)]
        angles = [math.atan2(y - place[1], x - place[0]) for x, y in ends]
        total += sum((b - a + math.pi) % math.tau - math.pi for a, b in pairwise(angles))
    return round(total / math.tau)


def keeps_away(wall: list[Piece], way: list[Piece], distance: float) -> None:
    """No place of the way is nearer to the wall. Raises DoesNotFit."""
    places = np.array([p.at(s) for p in way for s in np.linspace(0.0, 1.0, SAMPLES)])
    if nearest(wall, places) < distance - 1e-4:
        raise DoesNotFit


def nearest(shape: list[Piece], places: np.ndarray) -> float:
    """The least distance of (N, 2) places from a shape."""
    return min(float(_distance(p, places).min()) for p in shape)


def _distance(p: Piece, places: np.ndarray) -> np.ndarray:
    """(N,) of places (N, 2): an arc is as far as its circle where the arm from the centre to the
    place lies within its sweep, else as far as its nearer end."""
    ends = np.minimum(np.hypot(*(places - p.start).T), np.hypot(*(places - p.end).T))
    if not p.turn:
        way = np.subtract(p.end, p.start)
        share = (places - p.start) @ way / (way @ way)
        foot = np.array(p.start) + np.outer(np.clip(share, 0.0, 1.0), way)
        straight: np.ndarray = np.hypot(*(places - foot).T)
        return straight
    arm = places - p.centre
    begin = math.atan2(p.start[1] - p.centre[1], p.start[0] - p.centre[0])
    within = (p.turn * (np.arctan2(arm[:, 1], arm[:, 0]) - begin)) % math.tau <= p.sweep
    distance: np.ndarray = np.where(within, np.abs(np.hypot(*arm.T) - p.radius), ends)
    return distance


# -- strokes ---------------------------------------------------------------------------------------


def clearing(contour: list[Piece], axis: int, step: float) -> list[Piece]:
    """The way behind the contour, from its first place back there: strokes across it, each `step`
    farther along coordinate `axis`, and the ways between them along the contour. Raises
    DoesNotFit where there are too many."""
    behind = np.concatenate([[0.0], np.cumsum([p.length for p in contour])])
    here = 0.0
    way: list[Piece] = []
    for value in _values(contour, axis, step):
        left = _within(contour, behind, axis, value)
        while left:  # a level may cross a pocket with arms more than once
            one = min(left, key=lambda ends: min(_apart(here, e, behind[-1]) for e in ends))
            left.remove(one)  # the stroke whose nearer end lies next along the contour
            first, last = sorted(one, key=lambda e: _apart(here, e, behind[-1]))
            way += _along(contour, behind, here, first)
            way.append(Piece(0, _place(contour, behind, first), _place(contour, behind, last)))
            here = last
    return way + _along(contour, behind, here, 0.0)


def _within(
    contour: list[Piece], behind: np.ndarray, axis: int, value: float
) -> list[tuple[float, float]]:
    """The lengths along the contour at which each stroke begins and ends."""
    crossing = []
    for k, p in enumerate(contour):
        for s in p.crossings(axis, value):
            ahead = p.part(0.0, s).tangent(True) if s * p.length > NEAR else p.tangent(False)
            crossing.append((p.at(s)[1 - axis], behind[k] + s * p.length, ahead[axis] > 0))
    ends, turns = [], 0  # turns: of the contour around the places behind the crossing
    for _, at, up in sorted(crossing):
        before, turns = turns, turns + (1 if up else -1)
        if not before or not turns:  # from outside in, or out; not between overlaps
            ends.append(float(at))
    return list(zip(ends[::2], ends[1::2], strict=True))


def _values(contour: list[Piece], axis: int, step: float) -> list[float]:
    """Where the strokes lie: a step from each other, from the end that is nearer to the first
    place, none through an end of a piece."""
    extremes = [p.at(s)[axis] for p in contour for s in (0.0, 1.0)]
    extremes += [p.centre[axis] + k * p.radius for p in contour if p.turn for k in (-1, 1)]
    whole = [p.at(s)[axis] for p in contour for s in np.linspace(0.0, 1.0, SAMPLES)]
    low, high = min(whole), max(whole)
    count = math.ceil((high - low) / step - 1e-6)  # not one more for a rounding
    if count > MOST_STROKES:
        raise DoesNotFit
    values = []
    for k in range(1, count):
        value = low + k * step
        while any(abs(value - e) < NEAR for e in extremes):
            value += 3 * NEAR  # a line through a corner crosses one piece, two or none
        values.append(value)
    return values[::-1] if contour[0].start[axis] > (low + high) / 2 else values


def _apart(a: float, b: float, around: float) -> float:
    return min((b - a) % around, (a - b) % around)


def _place(contour: list[Piece], behind: np.ndarray, at: float) -> Point:
    k = min(int(np.searchsorted(behind, at, side="right")) - 1, len(contour) - 1)
    return contour[k].at((at - behind[k]) / contour[k].length)


def _along(contour: list[Piece], behind: np.ndarray, first: float, last: float) -> list[Piece]:
    """The shorter way along the contour from one place to another."""
    around = float(behind[-1])
    ahead, back = (last - first) % around, (first - last) % around
    if min(ahead, back) < NEAR:
        return []
    if back < ahead:
        return [p.part(1.0, 0.0) for p in reversed(_along_ahead(contour, behind, last, back))]
    return _along_ahead(contour, behind, first, ahead)


def _along_ahead(
    contour: list[Piece], behind: np.ndarray, first: float, ahead: float
) -> list[Piece]:
    around, parts = float(behind[-1]), []
    for start in (0.0, around):  # once more around, if it goes over the contour's end
        for p, (begin, end) in zip(contour, pairwise(behind + start), strict=True):
            low, high = max(first, begin), min(first + ahead, end)
            if high - low > NEAR:
                parts.append(p.part((low - begin) / p.length, (high - begin) / p.length))
    return parts
