"""Where a canned cycle goes back to: the command at which the axis stood before it, also behind
holes of the same cycle that ended at R."""

from __future__ import annotations

import numpy as np

from postproc.compensate.columns import Columns


def origins(b: Columns, row: int) -> dict[int, int]:
    """By stroke, for holes from which axis `row` goes back to the initial level while the
    stroke before ended at another one (R, of a hole in the same cycle): the stroke at whose end it
    stood at that level, -1: before the batch."""
    found, holes, ends = {}, b.m.holes, b.of(b.m.target)[row]
    for k in np.flatnonzero(holes.initial & (holes.axis == row)):
        i = int(b.hole[k])
        level, j = ends[i], i - 1
        while j >= 0 and ends[j] != level:
            j -= 1
        if j < i - 1 or (i == 0 and b.m.start[row, 0] != level):
            found[i] = j
    return found


def level(
    b: Columns, row: int, origin: int, still: np.ndarray, value: list[int], end: np.ndarray
) -> int:
    """ticks: where axis `row` ended in stroke `origin`, -1: before the batch. value: of the first
    of the strokes `still` (K,), which are worked out; end (S,): of the others."""
    if origin < 0:
        first = b.m.start[row, 0] == b.nominal_end[row, int(still[len(value)])]
        return int((b.carry.issued if first else b.carry.level)[row])
    k = int(np.searchsorted(still, origin))
    return value[k] if still[k] == origin else int(end[origin])


def back(b: Columns) -> np.ndarray:
    """(H,) ticks commanded of the axis of each hole behind it: the initial level as it was written
    out, or R. Of a batch that begins with its holes, all along one axis."""
    holes, row, found = b.m.holes, int(b.m.holes.axis[0]), list[int]()
    origin, start = origins(b, row), b.m.start[row, 0]
    for k, own in enumerate(b.m.target[row, holes.motion].tolist()):
        j = origin.get(k, k - 1)
        before = found[j] if j >= 0 else (b.carry.issued if start == own else b.carry.level)[row]
        found.append(before if holes.initial[k] else min(own, before) if holes.flush[k] else own)
    return np.array(found, np.int64)


def initial(b: Columns) -> np.ndarray:
    """(A,) ticks of `_initial` for each axis."""
    return np.array([_initial(b, row) for row in range(len(b.end))])


def _initial(b: Columns, row: int) -> int:
    """ticks: where axis `row` stood before the holes with which the batch ends, all of which ended
    at R; where it stands, if there are none."""
    holes = b.m.holes
    ended = set(b.hole[~holes.initial & (holes.axis == row)].tolist())
    j = b.end.shape[1] - 1
    while j in ended:
        j -= 1
    return int(b.end[row, j] if j >= 0 else b.carry.level[row])
