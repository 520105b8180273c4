"""Turned, scaled and mirrored coordinates as one map: q = M p + t over X Y Z."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

AXES = ("X", "Y", "Z")
Point = tuple[float, float, float]
Matrix = tuple[Point, Point, Point]
NO_TURN: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
# Products of turns leave some 1e-16 where there should be 0: below this nothing is mixed, or a
# rotation about Z would ask for Z to be named in every block.
TINY = 1e-12


@dataclass(frozen=True)
class Affine:
    """Programmed coordinates p to those of the output, q = matrix p + shift, in the program's
    unit."""

    matrix: Matrix = NO_TURN
    shift: Point = (0.0, 0.0, 0.0)

    def __call__(self, p: Point) -> Point:
        x, y, z = (a + b for a, b in zip(self.turned(p), self.shift, strict=True))
        return x, y, z

    def turned(self, v: Point) -> Point:
        """A distance."""
        x, y, z = (sum(m * c for m, c in zip(row, v, strict=True)) for row in self.matrix)
        return x, y, z

    def after(self, first: Affine) -> Affine:
        """This map behind another one."""
        # M2 (M1 p + t1) + t2: the columns of M1, turned by M2, are those of the product.
        columns = [self.turned(column) for column in _columns(first.matrix)]
        return Affine(_columns((columns[0], columns[1], columns[2])), self(first.shift))

    @property
    def identity(self) -> bool:
        # Exactly, without a tolerance: while it holds, blocks keep their bytes. A turn by 360
        # degrees is the identity again, because `exact_turn` does not round quarter turns.
        return self == Affine()

    @property
    def can_be_undone(self) -> bool:
        """Whether a place has one programmed coordinate."""
        # a factor of 1e-6 to 1e6 along each of three axes
        return 1e-18 < abs(_det(*self.matrix)) < 1e18

    @property
    def turns(self) -> bool:
        """Whether every circle stays one, in whatever plane."""
        # so it is where the axes become equally long and at right angles: M'M = s^2 I
        a, b, c = _columns(self.matrix)
        sizes = [sum(x * x for x in column) for column in (a, b, c)]
        slack = 1e-9 * max(sizes)
        return max(sizes) - min(sizes) < slack and all(
            abs(sum(x * y for x, y in zip(one, other, strict=True))) < slack
            for one, other in ((a, b), (a, c), (b, c))
        )

    def partners(self, axis: str) -> list[str]:
        """The axes that a word of this axis moves, and those that its coordinate depends on: itself
        at least."""
        i = AXES.index(axis)
        mixed = {i} | {
            j for j in range(3) if abs(self.matrix[i][j]) > TINY or abs(self.matrix[j][i]) > TINY
        }
        # what a partner mixes with has to be written too; of three axes the second step finds all
        for j in list(mixed):
            mixed |= {
                k
                for k in range(3)
                if abs(self.matrix[j][k]) > TINY or abs(self.matrix[k][j]) > TINY
            }
        return [AXES[j] for j in sorted(mixed)]

    def leaves(self, axis: str) -> bool:
        """Whether an axis keeps its coordinates."""
        i = AXES.index(axis)
        return (
            self.matrix[i] == NO_TURN[i] and self.shift[i] == 0.0 and self.partners(axis) == [axis]
        )

    def inverse(self, q: Point) -> Point:
        """The programmed coordinates of a place. The map must be one that can be undone."""
        x, y, z = (a - b for a, b in zip(q, self.shift, strict=True))
        d: Point = (x, y, z)
        a, b, c = _columns(self.matrix)
        det = _det(a, b, c)
        # Cramer: each unknown is the determinant with its column put out for the right side
        return _det(d, b, c) / det, _det(a, d, c) / det, _det(a, b, d) / det

    def similarity(self, first: str, second: str) -> float | None:
        """What circles of a plane become: their factor, negative where their sense turns round;
        None: no circles, or none in this plane."""
        i, j = AXES.index(first), AXES.index(second)
        k = 3 - i - j
        m = self.matrix
        if any(abs(m[a][k]) > TINY or abs(m[k][a]) > TINY for a in (i, j)):
            return None
        # Both axes of the plane become (a, c) and (b, d). A circle stays one where these are at
        # right angles and equally long; then det is the square of the factor, with its sense.
        a, b, c, d = m[i][i], m[i][j], m[j][i], m[j][j]
        scale = max(abs(x) for x in (a, b, c, d))
        det = a * d - b * c
        if (
            abs(a * b + c * d) > 1e-9 * scale**2
            or abs(a * a + c * c - b * b - d * d) > 1e-9 * scale**2
            or not det
        ):
            return None
        return math.copysign(math.sqrt(abs(det)), det)


def point(values: Mapping[str, float | None]) -> Point:
    """X Y Z by name, 0 where there is none."""
    x, y, z = (values.get(axis) or 0.0 for axis in AXES)
    return x, y, z


def _columns(m: Matrix) -> Matrix:
    """The matrix with rows and columns changed over."""
    a, b, c = m
    return (a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2])


def _det(a: Point, b: Point, c: Point) -> float:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def exact_turn(degrees: float) -> tuple[float, float]:
    """Cosine and sine; whole quarter turns without rounding."""
    quarters, rest = divmod(degrees, 90.0)
    if rest == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters) % 4]
    return math.cos(math.radians(degrees)), math.sin(math.radians(degrees))


def rotation(first: str, second: str, degrees: float, centre: Point = (0.0, 0.0, 0.0)) -> Affine:
    """A turn in a plane, counter-clockwise from its first to its second axis, about a point."""
    #   second ^  . q     first' = first cos - second sin,  second' = first sin + second cos
    #          | /        G18 has Z as its first axis and X as its second (ISO 841: X x Y = Z), so
    #          |/ . p     its turns go from Z to X
    #          +-----> first
    i, j = AXES.index(first), AXES.index(second)
    cosine, sine = exact_turn(degrees)
    rows = [list(row) for row in NO_TURN]
    rows[i][i] = rows[j][j] = cosine
    rows[i][j], rows[j][i] = -sine, sine
    return _about(rows, centre)


def scaling(factors: dict[str, float], centre: Point = (0.0, 0.0, 0.0)) -> Affine:
    """A factor per axis (1 where none is given) about a point; a negative one mirrors."""
    rows = [list(row) for row in NO_TURN]
    for axis, factor in factors.items():
        i = AXES.index(axis)
        rows[i][i] = factor
    return _about(rows, centre)


def _about(rows: list[list[float]], centre: Point) -> Affine:
    # q = M (p - centre) + centre = M p + (centre - M centre)
    a, b, c = ((row[0], row[1], row[2]) for row in rows)
    turned = Affine((a, b, c)).turned(centre)
    x, y, z = (c - t for c, t in zip(centre, turned, strict=True))
    return Affine((a, b, c), (x, y, z))
