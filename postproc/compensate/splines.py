r"""B-splines: every control point is written where its own correction takes it, and the spline is
kept where what that leaves is proven to lie within the tolerance.

A point of a B-spline is a mean of the last DEGREE + 1 control points at most, with weights that are
not negative, whatever its knots, degree and weights are (L. Piegl, W. Tiller: The NURBS Book,
properties 3.5 and 4.3): s = sum w P. With the control points Q = P + k that are written the control
goes to q = sum w Q, and the machine with its deviation e to q + e(q). What that is off by,

    q + e(q) - s  =  sum w (Q + e(Q) - P)  +  (e(q) - sum w e(Q)),

is at most what the worst of the points is off by, and what e bends by over their box. A slope that
differs by `kink` over a length L bends a mean by kink * L / 4 at most, and a product of two axes by
a quarter of the product of their ranges (G. Grüss, Math. Z. 39, 1935): so the bounds of straight
motions hold for means of any number of points; where they are too wide the corners of the cells are
looked at (`_tight`). In which direction a slide moves at a point of the curve is one of the
directions along the legs of those points, so both are looked at where it turns.

Where the control calculates the knots itself, from the points as written, the curve changes with
them. Taken for granted is that the intervals change no more, one against another, than the legs of
the control polygon near them do, as by chord length, centripetally or evenly (The NURBS Book,
9.2.1): by a factor of 1 + d at most. In de Boor's algorithm each point is P' = (1 - a) P1 + a P2 of
two points of the level before. There a changes by d / 4 at most, along the last level's leg on the
curve's own tangent; the legs of level r are as long as r legs of the polygon, in the cone of their
directions. Beside the tangent that is, to first order in d, d / 4 * (1 + 2) * the longest leg * the
sine of the largest turn. By chord length the curve moves by a tenth of that or less; intervals and
weights that take it to nine tenths exist (tests/test_bspline.py).
"""

from __future__ import annotations

from itertools import combinations, product

import numpy as np

from postproc.compensate.batch import Batch
from postproc.compensate.settings import Course
from postproc.errors import MotionFault
from postproc.flags import any_of
from postproc.motions import SPLINE
from postproc.records import names
from postproc.units import TICKS_PER_MM, UM

DEGREE = 3  # the largest
# legs on either side of a span's own whose lengths its knots depend on: DEGREE - 1 intervals, each
# of which a rule may average over DEGREE legs
BESIDE = 2 * DEGREE - 1
REACH = 2 * BESIDE + DEGREE
MOST_CORNERS = 4096  # of cells


def check(b: Batch) -> Course | None:
    """Prove every spline of a batch; what its last one hands on, None: it does not end in one.
    Raises MotionFault at the first block that leaves more than the tolerance."""
    on = (b.code == SPLINE) & b.moved
    if not any_of(on):
        return None if len(on) else b.carry.spline
    _refuse(b, on.nonzero()[0])
    edges = np.diff(np.concatenate([[False], on, [False]]).astype(np.int8))
    course = None
    for first, stop in zip((edges == 1).nonzero()[0], (edges == -1).nonzero()[0], strict=True):
        before = b.carry.spline if first == 0 else None
        course = _joined(b, int(first), int(stop), before)
        _prove(b, course, np.arange(first, stop))
    assert course is not None
    return _last(course) if on[-1] else None


def _refuse(b: Batch, which: np.ndarray) -> None:
    """Raises MotionFault for splines that can not be followed at all."""
    turns = (b.travel[list(b.machine.turning)][:, which] != 0).any(axis=0)
    for i in which[turns][:1]:
        raise MotionFault(
            int(b.motion[i]),
            "a B-spline while a rotary axis turns",
            "let the CAM program write such motions as short lines",
        )
    for i in which[~b.known_before[which]][:1]:
        raise MotionFault(
            int(b.motion[i]),
            "a B-spline that begins at an unknown place",
            "move every axis to an absolute position first, or say --start",
        )


def _joined(b: Batch, first: int, stop: int, before: Course | None) -> Course:
    """The control points of strokes first to stop - 1 behind those that came before: of the same
    spline, or where it begins."""
    if before is None:
        side = b.carry.sides.side.astype(float) if first == 0 else b.weight_end[:, first - 1]
        before = Course(
            wanted=b.begin_nominal[:, first : first + 1],
            written=b.begin[:, first : first + 1] / TICKS_PER_MM,
            side=side[:, None],
            spaced=np.ones(1, bool),
        )
    part = slice(first, stop)
    own = {
        "wanted": b.end_nominal[:, part],
        "written": b.end[:, part] / TICKS_PER_MM,
        "side": b.weight_end[:, part],
        "spaced": b.m.spaced[b.motion[part]],
    }
    both = {x: np.concatenate([getattr(before, x), own[x]], axis=-1) for x in own}
    return Course(**both)


def _last(course: Course) -> Course:
    """What the next batch must know of a spline."""
    return Course(**{x: getattr(course, x)[..., -REACH - 1 :] for x in names(Course)})


def _prove(b: Batch, course: Course, stroke: np.ndarray) -> None:
    """Raises MotionFault for the first of the strokes, which are the last points of a course, where
    what is left may be more than the tolerance."""
    last = np.arange(course.wanted.shape[1] - len(stroke), course.wanted.shape[1])
    window = np.maximum(last[:, None] - np.arange(DEGREE + 1), 0)  # (n, 4) the points of a span
    ways = _ways(b, course, window)
    off = np.max([_off(b, course, window, np.stack(way)) for way in product(*ways)], axis=0)
    own = _off(b, course, window, None)
    knots = _knots(course, last)
    grid = b.m.grid[b.rows][:, b.motion[stroke]].max(axis=0) / TICKS_PER_MM
    allowed = _allowed(b, own, grid)
    uncertain = off + _bend(b, course.written[:, window]) + knots > allowed
    for i in uncertain.nonzero()[0]:
        points, wanted = course.written[:, window[i]], course.wanted[:, window[i]]
        sides = [[float(side[i]) for side in row] for row in ways]
        left = _tight(b, points, wanted, sides) + float(knots[i])
        if left > allowed[i]:
            parts = {"off": left}
            if own[i] <= allowed[i]:
                still = course.side[:, window[i, :1]]
                parts = {**_parts(b, points, wanted, sides, still), "knots": float(knots[i])}
            known = bool(course.spaced[max(last[i] - REACH, 0) : last[i] + 1].all())
            raise _fault(b, int(b.motion[stroke[i]]), parts, left, known)


def _ways(b: Batch, course: Course, window: np.ndarray) -> list[list[np.ndarray]]:
    """Of each axis the sides (n,) on which it may bear in windows (n, 4): one, or both of those
    along their legs where it turns back in any of them."""
    found = []
    for row, side in enumerate(course.side[:, window]):
        low, high = side.min(axis=1), side.max(axis=1)
        turns = (low != high) & b.machine.two_way[row]
        unsure = turns & ((low == 0) | (high == 0))  # it comes from an unknown side
        last = side[:, 0]
        low = np.where(unsure, -1.0, np.where(turns, low, last))
        high = np.where(unsure, 1.0, np.where(turns, high, last))
        found.append([low, high] if turns.any() else [last])
    return found


def _off(b: Batch, course: Course, window: np.ndarray, sides: np.ndarray | None) -> np.ndarray:
    """(n,) mm that the worst point of each window (n, 4) is off by where the slides bear on `sides`
    (A, n), None: each on its own."""
    worst = np.zeros(len(window))
    for at in window.T:
        written = course.written[:, at]
        side = course.side[:, at] if sides is None else sides
        off = written + b.machine.deviation(written, side) - course.wanted[:, at]
        np.maximum(worst, np.linalg.norm(off[b.rows], axis=0), out=worst)
    return worst


def _allowed(b: Batch, own: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """(n,) mm that may be left in all: the tolerance and half an increment; where the points are
    off by more already, held back by the hysteresis, half the tolerance beyond that."""
    plain = b.c.tolerance + grid / 2 + 1e-9
    allowed: np.ndarray = np.minimum(np.maximum(plain, own + b.c.tolerance / 2), b.c.allowed(grid))
    return allowed


def _parts(
    b: Batch, points: np.ndarray, wanted: np.ndarray, sides: list[list[float]], still: np.ndarray
) -> dict[str, float]:
    """mm: what the map bends between points (A, 4), and what lost motion adds where sides change.
    still (A, 1): the last side."""
    ideal = points + b.machine.deviation(points, np.broadcast_to(still, points.shape))
    bend = _tight(b, points, ideal, still.tolist())
    turns = any(len(set(x)) > 1 for x in sides)
    return {"bend": bend, "play": (_tight(b, points, wanted, sides) - bend) * turns}


def _bend(b: Batch, points: np.ndarray) -> np.ndarray:
    """(n,) mm by which the deviation bends over the boxes of points (A, n, 4) mm at most."""
    low, high = points.min(axis=2), points.max(axis=2)
    size = high - low
    longest = size[b.c.slides].max(axis=0, initial=0.0)
    bounds = b.machine.bounds
    bend: np.ndarray = bounds.local(low, high)[0] * longest / 4 + bounds.bend(size)
    return bend


def _tight(b: Batch, points: np.ndarray, wanted: np.ndarray, sides: list[list[float]]) -> float:
    """mm that a mean of points (A, 4) may be off by from the same mean of those wanted (A, 4), on
    any of the sides of each axis.

    For any linear function a of the place, q + e(q) - s = (e - a)(q) + sum w (Q + a(Q) - P). Along
    each axis e is linear between nodes, so that e - a is largest in a corner of a cell; beside that
    counts what an arm that grows along its own axis bends within one."""
    low, high = points.min(axis=1), points.max(axis=1)
    marks = [
        np.unique([low[row], high[row], *_between(b, letter, low[row], high[row])])
        for row, letter in enumerate(b.machine.letters)
    ]
    if np.prod([float(len(x)) for x in marks]) > MOST_CORNERS:
        return np.inf
    corners = np.stack([x.ravel() for x in np.meshgrid(*marks, indexing="ij")])
    ways = [np.array(way)[:, None] for way in product(*map(np.unique, sides))]
    each = [
        b.machine.deviation(corners, np.broadcast_to(way, corners.shape))[b.rows] for way in ways
    ]
    middle = ((low + high) / 2)[:, None]

    def linear(place: np.ndarray) -> np.ndarray:
        return np.vstack([np.ones(place.shape[1]), place - middle])

    slope = np.linalg.lstsq(linear(corners).T, np.mean(each, axis=0).T, rcond=None)[0]
    rest = max(np.linalg.norm(e - slope.T @ linear(corners), axis=0).max() for e in each)
    off = (points - wanted)[b.rows] + slope.T @ linear(points)
    own = float((np.diag(b.machine.bounds.twist) * (high - low) ** 2).sum() / 4)
    return float(rest + np.linalg.norm(off, axis=0).max() + own)


def _between(b: Batch, letter: str, low: float, high: float) -> list[float]:
    """Nodes of an axis, mm, between two places."""
    every = (x for nodes in b.machine.knots.get(letter, ()) for x in nodes.tolist())
    return [x for x in every if low < x < high]


def _knots(course: Course, last: np.ndarray) -> np.ndarray:
    """(n,) mm by which knots that the control calculates may move the curve about points `last`
    (n,), and about those of which the legs behind them tell only now."""
    way = np.diff(course.wanted, axis=1)
    length, new = (np.linalg.norm(x, axis=0) for x in (way, np.diff(course.written, axis=1)))
    ratio = np.divide(new, length, out=np.full_like(new, np.nan), where=length > 0)
    legs = np.maximum(last[:, None] - 1 - np.arange(REACH), 0)
    least = np.nanmin(ratio[legs], axis=1, initial=np.inf)
    most = np.nanmax(ratio[legs], axis=1, initial=0.0)
    spread = np.where(most > 0, most / np.maximum(least, 1e-9) - 1.0, 0.0)
    levels = DEGREE * (DEGREE - 1) / 2
    moved = spread / 4 * levels * _aside(way, length)[legs[:, : BESIDE + 1]].max(axis=1)
    return np.where(course.spaced[legs + 1].all(axis=1), 0.0, moved)


def _aside(way: np.ndarray, length: np.ndarray) -> np.ndarray:
    """(L,) mm: of the DEGREE legs that end with each one the longest, times the sine of the largest
    angle between two of them, 1 beyond a right one."""
    before = np.maximum(np.arange(len(length))[:, None] - np.arange(DEGREE), 0)
    sine = np.zeros(len(length))
    for one, two in combinations(before.T, 2):
        size = length[one] * length[two]
        along = (way[:, one] * way[:, two]).sum(axis=0)
        cosine = np.divide(along, size, out=np.ones_like(size), where=size > 0)
        angle = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
        sine = np.maximum(sine, np.where(cosine > 0, angle, 1.0))
    found: np.ndarray = length[before].max(axis=1) * sine
    return found


WRITE_OUT = "--expand writes it out as straight lines"  # or says why it does not
MAKE_UNIFORM = "let the CAM program write a uniform one, PL alike in each of its blocks"
SAYS = {  # what the largest part is for, and the way out
    "off": (
        "it begins where no motion was corrected before",
        "lead to its start by a motion of its own",
    ),
    "play": (
        "a slide turns back within it or at its start, and no block can take its lost motion up"
        " there",
        "where it turns at the start, lead up to it in the direction of its first leg; elsewhere"
        " lines and arcs, or leave lost motion to the control (--reversal mean)",
    ),
    "bend": ("the map bends between its control points", "more of them, or lines and arcs"),
    "knots": (
        "the control spaces its knots by the control points, which are corrected",
        "let the CAM program write PL in each of its blocks, more control points, or lines and"
        " arcs",
    ),
}


def _fault(b: Batch, motion: int, parts: dict[str, float], left: float, known: bool) -> MotionFault:
    """left: mm. known: whether its blocks say the intervals of its knots."""
    part = max(parts, key=lambda x: parts[x])
    why, out = SAYS[part]
    if part in ("play", "bend"):
        out = f"{WRITE_OUT if known else MAKE_UNIFORM}; or {out}"
    return MotionFault(
        motion,
        f"a B-spline whose curve may stay off by {left / UM:.1f} um (tolerance"
        f" {b.c.tolerance / UM:g} um): {why}",
        f"{out}; or --tolerance",
    )
