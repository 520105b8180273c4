"""Holes of canned cycles: X and Y are corrected for the middle of the hole's axis, the bottom for
the bottom.

A hole stays one block as long as its axis, which the machine drills with X and Y held, stays within
the tolerance of holes of the nominal one over the whole depth: deviations are linear between the
nodes, so ends and nodes tell. A tap can not be written out, since its feed is the spindle's: what
bends stays, and is said. The level R and the way back are rapids, and stay as written, but for an R
at which the tool stands: where that place comes to lie below R, R goes there with it, since
not every control says where it goes back to from there.
"""

from __future__ import annotations

import itertools

import numpy as np

from postproc.compensate.batch import Batch
from postproc.compensate.depths import axis_of, depths, down, weights
from postproc.compensate.inverse import command
from postproc.compensate.known import known
from postproc.compensate.settings import Settings
from postproc.errors import MotionFault, Notice
from postproc.motions import Motions
from postproc.units import TICKS_PER_MM, UM


def settle(b: Batch) -> None:
    """Set end, exact and bottom of every stroke that is a hole. Raises MotionFault for a hole that
    bends too much."""
    holes = b.m.holes
    if not len(holes):
        return
    free = b.free[holes.motion]
    for k in map(int, np.flatnonzero(free)):
        i, row = int(b.hole[k]), int(holes.axis[k])
        #    R        o     )          ) what corrects the axis at each depth, looked at from above
        #             |    (           as a cloud of places: the hole is written at the middle of
        #             |     )          the box around it, so that half the box's diagonal, `bend`,
        #    bottom   v      )         is the most that stays
        target, exact = down(b, k, b.weight_end[:, i : i + 1])
        across, middle, bend, depth = axis_of(b.machine, exact, target, row)
        stands = (b.end[:, i - 1] if i else b.carry.issued)[across]
        if not holes.place[k]:  # the tap goes straight down from there
            off = exact[across] - stands[:, None] / TICKS_PER_MM
            bend = float(np.linalg.norm(off, axis=0).max()) if across else 0.0
        if bend > b.c.tolerance:
            _bends(b, k, bend, target[row])
        place = b.end_nominal[:, i].copy()
        place[across] += middle
        place[row] = exact[row, -1]
        b.exact[:, i] = place
        step = b.m.grid[:, holes.motion[k]]
        whole = np.rint((place - b.end_nominal[:, i]) * TICKS_PER_MM / step).astype(np.int64) * step
        b.end[across, i] = b.nominal_end[across, i] + whole[across] if holes.place[k] else stands
        # In whole increments: less than half of one leaves the word as it stands.
        steps = np.rint(depth * TICKS_PER_MM / step[row])
        bottom = holes.bottom[k] + int(steps) * step[row] if row in b.rows else holes.bottom[k]
        if (bottom > holes.level[k]) != (
            holes.bottom[k] > holes.level[k]
        ) and bottom != holes.level[k]:
            raise MotionFault(
                int(holes.motion[k]),
                f"the hole is {abs(holes.bottom[k] - holes.level[k]) / TICKS_PER_MM:g} mm deep, and"
                " its corrected bottom lies beyond R",
                "set R farther from the bottom than the correction is large",
            )
        b.bottom[holes.motion[k]] = bottom
        b.end[row, i] = b.nominal_end[row, i]
        if holes.flush[k]:
            b.end[row, i] = min(b.end[row, i], (b.end[:, i - 1] if i else b.carry.issued)[row])
        b.end_nominal[row, i] = (
            holes.bottom[k] / TICKS_PER_MM if row in b.rows else b.end_nominal[row, i]
        )
    b.bottom[holes.motion[~free]] = holes.bottom[~free]
    before = np.concatenate([b.carry.issued[:, None], b.end[:, :-1]], axis=1)
    b.before = np.where(b.jumps, b.m.start[:, b.motion], before)


def _bends(b: Batch, k: int, bend: float, depth: np.ndarray) -> None:
    """Say that the axis of hole k bends by `bend` mm over `depth` (K,) mm, or raise MotionFault
    where that is too much."""
    motion, letter = int(b.m.holes.motion[k]), b.machine.letters[int(b.m.holes.axis[k])]
    where = f"between {letter} = {depth[0]:.3f} and {depth[-1]:.3f} mm"
    how = (
        "it is corrected for the middle"
        if b.m.holes.place[k]
        else "G33.1 goes straight down from where the axes stand"
    )
    limit = f"tolerance of holes {b.c.hole_tolerance / UM:g} um"
    if bend <= b.c.hole_tolerance:
        what = (
            f"a hole's axis bends by up to {bend / UM:.2f} um while its cycle holds its place"
            f" ({limit})"
        )
        b.notices.append(Notice("hole", what, motion, bend))
    elif b.m.holes.tap[k]:
        what = f"a tapped hole's axis bends by {bend / UM:.2f} um {where} ({limit}); {how}"
        b.notices.append(Notice("tap", what, motion, bend))
    else:
        taken = f"--hole-tolerance {np.ceil(bend / UM * 10) / 10:g}um takes it as it is"
        written = (
            "--expand writes it out as plain blocks, " if b.c.options.holes_written_out else ""
        )
        raise MotionFault(
            motion,
            f"the hole's axis bends by {bend / UM:.2f} um {where} ({limit})",
            f"a cycle holds its place over the depth: {written}{taken}",
        )


def straight(c: Settings, m: Motions, tolerance: float) -> bool:
    """Whether every hole of these motions bends by less than `tolerance` mm, from whatever side its
    place is reached, and keeps a depth: so its cycle can stay.

    Deviations are linear in the side of approach, so that the bend, a norm, is largest where every
    axis lies at one end or the other of its lost motion.
    """
    holes, there = m.holes, known(c.machine, m).end
    for k, motion in enumerate(map(int, holes.motion)):
        row = int(holes.axis[k])
        if not there[motion]:
            return False
        target = depths(c.machine, holes, k, m.target[:, motion] / TICKS_PER_MM)
        deep = abs(target[row, -1] - target[row, 0])
        sides = _sides(c, row)
        each, count = target.shape[1], target.shape[1] * sides.shape[1]
        wanted, weight = np.tile(target, sides.shape[1]), weights(c.follows, holes, k, sides, each)
        exact = command(c.machine, wanted, weight, np.full(count, motion))
        for first in range(0, count, each):
            axis = axis_of(c.machine, exact[:, first : first + each], target, row)
            if axis.bend >= tolerance or 2 * abs(axis.depth) >= deep:
                return False
    return True


def _sides(c: Settings, row: int) -> np.ndarray:
    """(A, S): every side from which the axes but that of the hole may have come."""
    rows = [r for r in np.flatnonzero(c.machine.two_way) if r != row] if c.follows else []
    sides = np.zeros((len(c.machine.letters), 2 ** len(rows)))
    if rows:
        sides[rows] = np.array(list(itertools.product((-1.0, 1.0), repeat=len(rows)))).T
    return sides
