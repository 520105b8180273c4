"""Where a canned cycle goes back to: the command at which the axis stood before it, also behind
holes of the same cycle that ended at R."""

from __future__ import annotations

import numpy as np

from postproc.compensate.columns import Columns

LOWEST = -(2**62)  # ticks


def origins(b: Columns, row: int) -> dict[int, tuple[int, int]]:
    """By stroke, for holes from which axis `row` goes back to the initial level, where that may be
    another place than the stroke before ended at (R, of a hole in the same cycle): the stroke at
    whose end it stood before the cycle, -1: before the batch; and ticks of R, if it goes no lower,
    else LOWEST."""
    found, holes = {}, b.m.holes
    begin, at_level = -1, False
    for k in np.flatnonzero(holes.axis == row).tolist():
        i = int(b.hole[k])
        if holes.first[k]:
            begin, at_level = i - 1, True
        if holes.initial[k] and (holes.higher[k] or not at_level):
            found[i] = begin, int(holes.level[k]) if holes.higher[k] else LOWEST
        at_level = bool(holes.initial[k] and not holes.higher[k])
    return found


def _before(b: Columns, row: int) -> int:
    """ticks: the initial level of axis `row` in the first cycle of a batch, which began with it or
    before it."""
    first = b.m.holes.first[b.m.holes.axis == row][0]
    return int((b.carry.issued if first else b.carry.level)[row])


def level(
    b: Columns,
    row: int,
    origin: tuple[int, int],
    still: np.ndarray,
    value: list[int],
    end: np.ndarray,
) -> int:
    """ticks: where axis `row` goes back to, for an `origin`. value: of the first of the strokes
    `still` (K,), which are worked out; end (S,): of the others."""
    stroke, lowest = origin
    if stroke < 0:
        return max(_before(b, row), lowest)
    k = int(np.searchsorted(still, stroke))
    return max(value[k] if still[k] == stroke else int(end[stroke]), lowest)


def back(b: Columns) -> np.ndarray:
    """(H,) ticks commanded of the axis of each hole behind it: the initial level as it was written
    out, or R. Of a batch that begins with its holes, all along one axis."""
    holes, row, found = b.m.holes, int(b.m.holes.axis[0]), list[int]()
    origin = origins(b, row)
    for k, own in enumerate(b.m.target[row, holes.motion].tolist()):
        j, lowest = origin.get(k, (k - 1, LOWEST))
        stands = _before(b, row) if k in origin else int(b.carry.issued[row])
        before = max(found[j] if j >= 0 else stands, lowest)
        found.append(before if holes.initial[k] else min(own, before) if holes.flush[k] else own)
    return np.array(found, np.int64)


def initial(b: Columns) -> np.ndarray:
    """(A,) ticks of `_initial` for each axis."""
    return np.array([_initial(b, row) for row in range(len(b.end))])


def _initial(b: Columns, row: int) -> int:
    """ticks: where axis `row` stood before the cycle of the holes with which the batch ends, none
    of which need have ended there; where it stands, if there are none."""
    holes, j = b.m.holes, b.end.shape[1] - 1
    away = (~holes.initial | holes.higher) & (holes.axis == row)
    for k in range(len(holes) - 1, -1, -1):
        if int(b.hole[k]) != j or not away[k]:
            break
        j -= 1
        if holes.first[k]:
            break
    return int(b.end[row, j]) if j >= 0 else _before(b, row)
