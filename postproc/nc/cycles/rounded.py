"""Rectangles with round corners about zero, and the rings by which a tool clears one from inside
out; a circle is one whose corners are its half sides, a slot one whose corners are the shorter.

All lies in the plane, (x, y), and is the way of the tool's centre. A ring runs counter-clockwise
from its middle on the right. Where corners are sharp, what lies outside of one ring in its corner
is reached by the next one only where they lie no further apart than CORNER radii of the tool.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from postproc.nc.cycles.pocket_path import Piece, Point

NEAR = 1e-7
CORNER = 1.4  # the half of a square lies sqrt(2) times its side away in the corner
MOST_RINGS = 1000


@dataclass(frozen=True)
class Rounded:
    """Half sides and the radius of the corners."""

    a: float
    b: float
    corner: float

    def less(self, distance: float) -> Rounded:
        """The same as far inside on all sides (outside where below 0)."""
        # Corners shrink with the sides: rings of one pocket are parallel, and sharp once they lie
        # as far inside as the corner's radius.
        a, b, corner = (max(v - distance, 0.0) for v in (self.a, self.b, self.corner))
        return Rounded(a, b, min(corner, a, b))

    @property
    def start(self) -> Point:
        return self.a, 0.0

    def ring(self) -> list[Piece]:
        """Once around."""
        a, b, r = self.a, self.b, self.corner
        pieces: list[Piece] = []
        here = self.start
        #  (-1, 1) .-------. (1, 1)     Counter-clockwise from corner to corner, each between a
        #          |       o start      point on its side along Y and one on that along X: in the
        # (-1, -1) '-------' (1, -1)    first and third quadrant the former comes first.
        for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
            centre = x * (a - r), y * (b - r)
            ends = (x * a, centre[1]), (centre[0], y * b)
            first, last = ends if x * y > 0 else ends[::-1]
            pieces += [Piece(0, here, first), Piece(1, first, last, centre)]
            here = last
        pieces.append(Piece(0, here, self.start))
        return [p for p in pieces if math.dist(p.start, p.end) > NEAR]

    def joined(self, longest: float) -> list[Piece]:
        """Once around from within, joined and left on quarter circles, so that the tool does not
        stand still at the wall. longest: their radius, which is less where there is no room."""
        #      (a - r, r) o.
        #                   `o.  off
        #         middle o     o (a, 0), on the wall
        #                   .o'  on
        #     (a - r, -r) o'
        a, r = self.a, min(longest, self.a / 2, self.b / 2)
        if r <= NEAR:
            return self.ring()
        middle, touch = (a - r, 0.0), (a, 0.0)
        on, off = Piece(1, (a - r, -r), touch, middle), Piece(1, touch, (a - r, r), middle)
        return [on, *self.ring(), off]

    def rings(self, step: float) -> list[Rounded]:
        """From inside out, no further apart than `step`; the last one is this. Raises ValueError
        where there are too many."""
        inner = min(self.a, self.b)
        count = math.ceil(inner / step - NEAR)
        if count > MOST_RINGS:
            raise ValueError
        # From a line or a point in the middle (k = 0) outwards, all alike.
        return [self.less(inner * (1 - k / count)) for k in range(count)] + [self]


def step_of(shape: Rounded, wanted: float, radius: float) -> float:
    """How far rings may lie apart: as far as wanted, and where their corners are sharp no further
    than leaves nothing between them."""
    round_about = abs(shape.corner - min(shape.a, shape.b)) < NEAR
    return wanted if round_about else min(wanted, CORNER * radius)
