"""Reference lines and the straightness error about them, ISO 230-1.

A deviation is the distance of the functional point from its reference line, positive towards + of
the axis. The straightness error is the largest positive deviation plus the size of the largest
negative one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.iso.minimax import minimax

LINES = ("end-point", "least-squares", "minimum-zone")


@dataclass(frozen=True)
class Line:
    """value(x) = offset + slope * (x - origin), mm; slope in rad for a straightness."""

    kind: str
    origin: float
    offset: float
    slope: float

    def value(self, x: np.ndarray) -> np.ndarray:
        """(K,) mm: height of the line at x (K,) mm."""
        return self.offset + self.slope * (x - self.origin)


def reference(kind: str, x: np.ndarray, y: np.ndarray) -> Line:
    """The reference line of points x, y (K,), mm. Of one point a level line.

    end-point: through the points of smallest and largest x (means where there are several);
    least-squares: smallest sum of squares; minimum-zone: the middle of the narrowest pair of
    parallels that holds all points (distances along y).
    """
    # in the middle, so that offset and slope are found apart: far from zero they would cancel
    # digits
    origin = float((x.min() + x.max()) / 2)
    if np.ptp(x) == 0:
        return Line(
            kind,
            origin,
            float((y.min() + y.max()) / 2 if kind == "minimum-zone" else y.mean()),
            0.0,
        )
    if kind == "end-point":
        first, last = float(y[x == x.min()].mean()), float(y[x == x.max()].mean())
        return Line(kind, origin, (first + last) / 2, (last - first) / float(np.ptp(x)))
    basis = np.stack([np.ones(len(x)), x - origin], axis=1)
    if kind == "least-squares":
        offset, slope = np.linalg.lstsq(basis, y, rcond=None)[0]
    else:
        (offset, slope), _ = minimax(basis, y)
    return Line(kind, origin, float(offset), float(slope))


def straightness_error(kind: str, x: np.ndarray, y: np.ndarray) -> float:
    """mm: width of the zone about the reference line, ISO 230-1."""
    left = y - reference(kind, x, y).value(x)
    # the line itself is in the zone, where all points lie on one side of it
    return float(max(left.max(), 0.0) + max(-left.min(), 0.0))
