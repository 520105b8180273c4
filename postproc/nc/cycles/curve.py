"""Rational B-splines as straight lines that leave the curve by no more than a tolerance.

A curve is cut at its knots into Bezier pieces (knots are inserted, W. Boehm 1980), and a piece is
halved (de Casteljau) until all its poles lie as near to its chord as wanted. With positive weights
a piece lies within the hull of its poles, so this bounds the distance of every point and not only
of those that somebody looked at.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

MOST_HALVINGS = 24  # a curve of 10 m is cut into 0.6 um then


@dataclass(frozen=True)
class Curve:
    """`poles` (K, D) in the order of the program, `weights` (K,) above 0, `knots` (K + order,)
    ascending; order is the degree and 1. The curve goes over the knots from number order - 1 to
    number K."""

    poles: np.ndarray
    weights: np.ndarray
    knots: np.ndarray
    order: int

    def beziers(self) -> list[np.ndarray]:
        """Its pieces, (order, D + 1) poles each with their weight behind, the coordinates times the
        weight."""
        # (K, D + 1): a rational curve is a polynomial one of these, so knots are inserted and
        # pieces halved without a division; the weights divide at the end.
        points = np.column_stack([self.poles * self.weights[:, None], self.weights])
        knots, degree = list(map(float, self.knots)), self.order - 1
        first, last = knots[degree], knots[len(points)]
        for knot in sorted({k for k in knots if first <= k <= last}):
            # At a knot that stands `degree` times the curve meets a pole: between two such it is
            # one piece.
            while knots.count(knot) < degree:
                points, knots = _inserted(points, knots, degree, knot)
        starts = [i for i in range(degree, len(points)) if knots[i] < knots[i + 1]]
        return [points[i - degree : i + 1] for i in starts]

    def points(self, tolerance: float, straight: int) -> np.ndarray:
        """(M, D) ends of lines behind the first pole. The lines leave the curve by `tolerance` at
        most, in its first `straight` coordinates; what is behind these is carried along."""
        return np.concatenate(self.spans(tolerance, straight))

    def spans(self, tolerance: float, straight: int) -> list[np.ndarray]:
        """The same between each two of its knots."""
        return [lines_of(piece, tolerance, straight) for piece in self.beziers()]


def lines_of(piece: np.ndarray, tolerance: float, straight: int) -> np.ndarray:
    """(M, D) ends of the lines that one Bezier piece becomes: (K, D + 1) poles, each with its
    weight behind, the coordinates times the weight."""
    return np.array(
        [end[:-1] / end[-1] for end in _ends(piece, tolerance, straight, MOST_HALVINGS)]
    )


def uniform(poles: np.ndarray, weights: np.ndarray, order: int) -> Curve:
    """A curve that begins and ends in its first and last pole, with all inner knots 1 apart."""
    # Of 5 poles and order 3: 0 0 0 1 2 3 3 3, so that the curve begins and ends in a pole.
    inner = len(poles) - order + 1
    knots = np.concatenate([np.zeros(order), np.arange(1, inner), np.full(order, inner)])
    return Curve(poles, weights, knots, order)


def bezier(*poles: tuple[float, ...]) -> Curve:
    """A Bezier curve: quadratic of three poles, cubic of four."""
    return uniform(np.array(poles), np.ones(len(poles)), len(poles))


def _inserted(
    points: np.ndarray, knots: list[float], degree: int, knot: float
) -> tuple[np.ndarray, list[float]]:
    """The same curve with one more knot."""
    at = max(i for i, k in enumerate(knots) if k <= knot)
    at = min(at, len(points) - 1) if knot < knots[-1] else len(points) - 1
    new = []
    for i in range(len(points) + 1):
        if i <= at - degree:
            new.append(points[i])
        elif i > at:
            new.append(points[i - 1])
        else:
            # The `degree` poles that the knot touches move towards their neighbour; those before it
            # stay, those behind it are one further on.
            share = (knot - knots[i]) / (knots[i + degree] - knots[i])
            new.append((1 - share) * points[i - 1] + share * points[i])
    return np.array(new), sorted([*knots, knot])


def _ends(piece: np.ndarray, tolerance: float, straight: int, halvings: int) -> list[np.ndarray]:
    """The ends of the lines that a Bezier piece becomes."""
    if not halvings or _bend(piece, straight) <= tolerance:
        return [piece[-1]]
    #  row 0   p0    p1    p2    p3    middles between neighbours, row by row: the first of each
    #  row 1     q0    q1    q2        row are the poles of the left half, the last of each row,
    #  row 2        r0    r1           from below, those of the right one
    #  row 3           s
    left, right, row = [piece[0]], [piece[-1]], piece
    while len(row) > 1:
        row = (row[:-1] + row[1:]) / 2
        left.append(row[0])
        right.append(row[-1])
    halves = np.array(left), np.array(right[::-1])
    return [end for half in halves for end in _ends(half, tolerance, straight, halvings - 1)]


def _bend(piece: np.ndarray, straight: int) -> float:
    """How far the poles lie from the chord at most."""
    places = piece[:, :straight] / piece[:, -1:]
    chord, arms = places[-1] - places[0], places[1:-1] - places[0]
    length = float(chord @ chord)
    # From the chord and not from its line: poles beyond its ends, of a piece that runs back over
    # itself, lie far from it.
    shares = np.clip(arms @ chord / length, 0.0, 1.0) if length else np.zeros(len(arms))
    return float(np.linalg.norm(arms - shares[:, None] * chord, axis=1).max(initial=0.0))
