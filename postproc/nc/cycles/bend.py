r"""The corner between two straight lines, and what rounds it or cuts it off.

start ----> at          a: from the corner back, b: on, both of length 1
           /  \         angle: between them, pi where the lines go on straight
         end
"""

from __future__ import annotations

import math
from typing import NamedTuple

Point = tuple[float, float]
NEAR = 1e-9


class Bend(NamedTuple):
    """`length`: of the shorter line; `left`: whether the way turns to the left there."""

    at: complex
    a: complex
    b: complex
    angle: float
    length: float
    left: bool

    @property
    def straight(self) -> bool:
        """Whether the lines go on straight."""
        return math.pi - self.angle < NEAR

    @property
    def back(self) -> bool:
        """Whether the line behind runs back, or one has no length."""
        return self.angle < NEAR

    def away(self, radius: float) -> float:
        """How far from the corner an arc that touches both lines begins and ends."""
        #  corner +----o---        The arc touches at o, radius / tan(angle / 2) from the corner;
        #          \ . |           its centre is radius / sin(angle / 2) from it, between both
        #           \  + centre    lines.
        #            o
        return radius / math.tan(self.angle / 2)

    def ends(self, away: float) -> tuple[Point, Point]:
        """The places on both lines so far from the corner."""
        first, second = self.at + away * self.a, self.at + away * self.b
        return (first.real, first.imag), (second.real, second.imag)

    def centre(self, radius: float) -> Point:
        """The centre of the arc that touches both lines: on the line that halves the angle."""
        way = self.a + self.b
        middle = self.at + radius / math.sin(self.angle / 2) * way / abs(way)
        return middle.real, middle.imag


def bent(start: Point, corner: Point, end: Point) -> Bend:
    """The corner of a line from `start` and one to `end`."""
    at = complex(*corner)
    before, behind = complex(*start) - at, complex(*end) - at
    length = min(abs(before), abs(behind))
    # A line without length has no direction: any will do, since `length` makes the callers refuse
    # it.
    a, b = (x / abs(x) if length > NEAR else 1.0 + 0j for x in (before, behind))
    turn = a.conjugate() * b
    # From a, which points back, to b: a turn to the left of the way leaves b on the right of a.
    return Bend(at, a, b, math.atan2(abs(turn.imag), turn.real), length, turn.imag < 0)
