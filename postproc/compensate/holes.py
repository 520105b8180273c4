"""Holes of canned cycles: X and Y are corrected for the middle of the hole's axis, the bottom for the bottom.

A hole stays one block as long as its axis, which the machine drills with X and Y held, stays within the tolerance of holes
of the nominal one over the whole depth: deviations are linear between the nodes, so ends and nodes tell. A tap can not be
written out, since its feed is the spindle's: what bends stays, and is said. The level R and the way back are rapids, and
stay as written.
"""

from __future__ import annotations

import numpy as np

from postproc.compensate.batch import Batch
from postproc.compensate.inverse import command
from postproc.errors import MotionFault, Notice
from postproc.units import TICKS_PER_MM, UM


def settle(b: Batch) -> None:
    """Set end, exact and bottom of every stroke that is a hole. Raises MotionFault for a hole that bends too much."""
    holes = b.m.holes
    if not len(holes):
        return
    free = b.free[holes.motion]
    for k in map(int, np.flatnonzero(free)):
        i, row = int(b.hole[k]), int(holes.axis[k])
        target, weight = _depth(b, k, i, row)
        exact = command(b.machine, target, weight, np.full(target.shape[1], holes.motion[k]))
        correction = exact - target
        across = [r for r in b.rows if r != row]
        low, high = correction[across].min(axis=1, initial=np.inf), correction[across].max(axis=1, initial=-np.inf)
        bend = float(np.linalg.norm((high - low) / 2)) if across else 0.0
        stands = (b.end[:, i - 1] if i else b.carry.issued)[across]
        if not holes.place[k]:  # the tap goes straight down from there
            off = exact[across] - stands[:, None] / TICKS_PER_MM
            bend = float(np.linalg.norm(off, axis=0).max()) if across else 0.0
        if bend > b.c.tolerance:
            _bends(b, k, bend, target[row])
        place = b.end_nominal[:, i].copy()
        place[across] += (low + high) / 2
        place[row] = exact[row, -1]
        b.exact[:, i] = place
        step = b.m.grid[:, holes.motion[k]]
        whole = np.rint((place - b.end_nominal[:, i]) * TICKS_PER_MM / step).astype(np.int64) * step
        b.end[across, i] = b.nominal_end[across, i] + whole[across] if holes.place[k] else stands
        depth = np.rint(correction[row, -1] * TICKS_PER_MM / step[row])
        bottom = holes.bottom[k] + int(depth) * step[row] if row in b.rows else holes.bottom[k]
        if (bottom > holes.level[k]) != (holes.bottom[k] > holes.level[k]) and bottom != holes.level[k]:
            raise MotionFault(
                int(holes.motion[k]),
                f"the hole is {abs(holes.bottom[k] - holes.level[k]) / TICKS_PER_MM:g} mm deep, and its corrected bottom lies beyond R",
                "set R farther from the bottom than the correction is large",
            )
        b.bottom[holes.motion[k]] = bottom
        b.end[row, i] = b.nominal_end[row, i]
        b.end_nominal[row, i] = holes.bottom[k] / TICKS_PER_MM if row in b.rows else b.end_nominal[row, i]
    b.bottom[holes.motion[~free]] = holes.bottom[~free]
    before = np.concatenate([b.carry.issued[:, None], b.end[:, :-1]], axis=1)
    b.before = np.where(b.jumps, b.m.start[:, b.motion], before)


def _bends(b: Batch, k: int, bend: float, depth: np.ndarray) -> None:
    """Say that the axis of hole k bends by `bend` mm over `depth` (K,) mm, or raise MotionFault where that is too much."""
    motion, letter = int(b.m.holes.motion[k]), b.machine.letters[int(b.m.holes.axis[k])]
    where = f"between {letter} = {depth[0]:.3f} and {depth[-1]:.3f} mm"
    how = (
        "it is corrected for the middle" if b.m.holes.place[k] else "G33.1 goes straight down from where the axes stand"
    )
    limit = f"tolerance of holes {b.c.hole_tolerance / UM:g} um"
    if bend <= b.c.hole_tolerance:
        what = f"a hole's axis bends by up to {bend / UM:.2f} um while its cycle holds its place ({limit})"
        b.notices.append(Notice("hole", what, motion, bend))
    elif b.m.holes.tap[k]:
        what = f"a tapped hole's axis bends by {bend / UM:.2f} um {where} ({limit}); {how}"
        b.notices.append(Notice("tap", what, motion, bend))
    else:
        raise MotionFault(
            motion,
            f"the hole's axis bends by {bend / UM:.2f} um {where} ({limit})",
            "a cycle holds its place over the depth: --expand writes it out as plain blocks, "
            f"--hole-tolerance {np.ceil(bend / UM * 10) / 10:g}um takes it as it is",
        )


def _depth(b: Batch, k: int, stroke: int, row: int) -> tuple[np.ndarray, np.ndarray]:
    """(A, K) mm places down a hole, from R to the bottom with every node between, and (A, K) their approach."""
    top, bottom = b.m.holes.level[k] / TICKS_PER_MM, b.m.holes.bottom[k] / TICKS_PER_MM
    inner = np.unique(np.concatenate([np.zeros(0), *b.machine.knots.get(b.machine.letters[row], [])]))
    inner = inner[(inner > min(top, bottom)) & (inner < max(top, bottom))]
    place = np.concatenate([[top], inner if bottom > top else inner[::-1], [bottom]])
    target = np.repeat(b.end_nominal[:, stroke : stroke + 1], len(place), axis=1)
    target[row] = place
    weight = np.repeat(b.weight_end[:, stroke : stroke + 1], len(place), axis=1)
    if b.c.follows:
        weight[row] = np.sign(bottom - top)
    return target, weight
