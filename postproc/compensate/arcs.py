"""Where nominal arcs lead: their points, their quadrants, and where an axis turns back."""

from __future__ import annotations

import numpy as np

from postproc.compensate.nodes import spread
from postproc.motions import Arcs

SHALLOWEST = 1e-6  # mm
HALF = np.array(0.5)  # without axes: postproc.units


def direction(angle: np.ndarray) -> np.ndarray:
    """(2, ...) cosine and sine of angles (...), rad, to 3e-16, by the tangent of half the angle:
    NumPy has that one in vector instructions, a tenth of the time of the other two."""
    tangent = np.tan(angle * HALF)
    result = np.empty((2, *tangent.shape))
    cosine, sine = result
    np.multiply(tangent, tangent, out=cosine)
    cosine += 1.0
    np.divide(2.0, cosine, out=cosine)
    np.multiply(tangent, cosine, out=sine)
    cosine -= 1.0
    return result


def height(sweep: np.ndarray) -> np.ndarray:
    """(...) by which arcs of radius 1 and these sweeps, rad, leave their chords, 1 - cos(sweep /
    2)."""
    tangent = np.tan(sweep * (HALF / 2))
    square = tangent * tangent
    return 2.0 * square / (1.0 + square)


def points(
    arcs: Arcs, start: np.ndarray, target: np.ndarray, arc: np.ndarray, t: np.ndarray
) -> np.ndarray:
    """(A, K) mm: nominal points of arcs at t from 0 to 1. start, target (A, n) mm of all arcs;
    spirals and helices linear."""
    p = _along(start, target, arc, t)
    angle = arcs.sweep.take(arc)
    angle *= t
    angle += arcs.angle.take(arc)
    radius = _along(arcs.radius, arcs.radius_end, arc, t)
    inner = (t > 0) & (t < 1)  # ends stay as programmed, to the bit
    for axes, centre, value in zip(
        (arcs.first, arcs.second), arcs.centre, direction(angle), strict=True
    ):
        value *= radius
        value += centre.take(arc)
        one = int(axes[0]) if len(axes) else 0
        if (axes == one).all():
            p[one] = np.where(inner, value, p[one])
        else:
            which = inner.nonzero()[0]
            p[axes[arc[which]], which] = value[which]
    return p


def _along(begin: np.ndarray, end: np.ndarray, arc: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(..., K) at t (K,) from begin to end (..., n) of arcs."""
    value: np.ndarray = (end - begin).take(arc, axis=-1)
    value *= t
    value += begin.take(arc, axis=-1)
    return value


def quadrants(arcs: Arcs) -> tuple[np.ndarray, np.ndarray]:
    """(K,) arc and (K,) t of the places where a plane axis turns back, in the order of the way."""
    quarter = np.pi / 2
    last = arcs.angle + arcs.sweep
    low, high = np.minimum(arcs.angle, last) + 1e-9, np.maximum(arcs.angle, last) - 1e-9
    first = np.ceil(low / quarter).astype(np.int64)
    count = np.maximum(np.floor(high / quarter).astype(np.int64) - first + 1, 0)
    arc, nth = spread(count)
    # In the order of the way: down from the last where the arc turns clockwise.
    down = (arcs.sweep < 0).take(arc)
    index = first.take(arc) + np.where(down, count.take(arc) - 1 - nth, nth)
    t = (index * quarter - arcs.angle.take(arc)) / arcs.sweep.take(arc)
    return arc, t


def turning_points(
    arcs: Arcs, start: np.ndarray, target: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(K,) arc and (K,) t inside arcs where a plane axis turns back; start, target (A, n) mm of the
    arcs.

    An arc that is meant to begin or end at a quadrant, and misses it by the rounding of its words,
    turns back by less than a nanometre there: that is none.
    """
    arc, t = quadrants(arcs)
    inside = (t > 0) & (t < 1)
    arc, t = arc[inside], t[inside]
    index = np.rint((arcs.angle[arc] + arcs.sweep[arc] * t) / (np.pi / 2)).astype(np.int64)
    # the axis that is at its extreme there
    axis = np.where(index % 2 == 0, arcs.first[arc], arcs.second[arc])
    place = points(arcs, start, target, arc, t)[axis, np.arange(len(arc))]
    deep = np.ones(len(arc), bool)
    for end, way in ((start, t), (target, 1 - t)):
        # by going round it may come to the same place farther away
        near = np.abs(arcs.sweep[arc]) * way < np.pi / 4
        deep &= ~near | (np.abs(place - end[axis, arc]) > SHALLOWEST)
    return arc[deep], t[deep]
