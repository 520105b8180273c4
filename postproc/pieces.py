"""What to write for each motion: one or more pieces, in order."""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.motions import FEED
from postproc.records import columns, names

LINES = np.array(FEED, np.int8)  # without axes: postproc.units


@columns
class Pieces:
    """P pieces in program order; A axes.

    motion (P,): whose piece it is; code (P,): RAPID, FEED, CLOCKWISE, COUNTER; start, end (A, P):
    ticks commanded;
    share (P,): part of the motion's length, 0 for a take-up; arc (P,): row of the motions' arcs, or
    -1;
    centre (2, P): ticks from the piece's start to its centre, along the plane axes; radius (P,):
    ticks, the R word of an arc that is written with R, 0 elsewhere; nominal (A, P): ticks, where
    its end lies on the nominal path. take_up (P,): turns the slides round, does not advance on the
    path. corrected (P,): whether its motion was corrected at all; one that was not is left as
    written. bottom (P,): ticks commanded at the bottom of a HOLE, 0 elsewhere.
    """

    motion: np.ndarray
    code: np.ndarray
    start: np.ndarray
    end: np.ndarray
    share: np.ndarray
    arc: np.ndarray
    centre: np.ndarray
    radius: np.ndarray
    nominal: np.ndarray
    take_up: np.ndarray
    corrected: np.ndarray
    bottom: np.ndarray

    def __len__(self) -> int:
        return len(self.motion)


# stroke (P,) and order within it (P,), the pieces
Packed = tuple[tuple[np.ndarray, np.ndarray], Pieces]


def without_rests(pieces: Pieces) -> Pieces:
    """The same without straight pieces of no length, unless a motion has nothing else: turning a
    slide round can bring it to the very place where a short motion ends."""
    rest = np.logical_and.reduce(pieces.start == pieces.end, axis=0) & (pieces.code <= LINES)
    if not any_of(rest):
        return pieces
    first = np.concatenate([[True], pieces.motion[1:] != pieces.motion[:-1]])
    group = np.cumsum(first) - 1
    moves = np.bincount(group, weights=~rest) > 0
    # a motion that rests as a whole keeps its first piece: its block stands in the program, and has
    # its words
    keep = (~rest | (first & ~moves[group])).nonzero()[0]
    fields = names(Pieces)
    return Pieces(**{f: getattr(pieces, f).take(keep, axis=-1) for f in fields})


def in_order(parts: list[Packed]) -> Pieces:
    """Join sets of pieces."""
    if len(parts) == 1:
        stroke, place = parts[0][0]
        if len(stroke) < 2:
            return parts[0][1]
        step = stroke[1:] - stroke[:-1]
        # straight strokes come in order already
        if not any_of((step < 0) | ((step == 0) & (place[1:] <= place[:-1]))):
            return parts[0][1]
    stroke, place = (np.concatenate(keys) for keys in zip(*(k for k, _ in parts), strict=True))
    # one sort of nearly sorted numbers; orders within a stroke go from -2 to 2^30
    order = ((stroke << 32) + place).argsort(kind="stable")
    fields = names(Pieces)
    joined = {
        f: np.concatenate([getattr(p, f) for _, p in parts], axis=-1).take(order, axis=-1)
        for f in fields
    }
    return Pieces(**joined)


def joined(parts: list[Pieces]) -> Pieces:
    """Pieces of motions that follow each other, in one table."""
    fields = names(Pieces)
    return Pieces(**{f: np.concatenate([getattr(p, f) for p in parts], axis=-1) for f in fields})
