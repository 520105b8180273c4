"""What nothing corrects must be commanded as the program has it: axes without errors of their own,
rotary ones above all, of which no distance from the path tells."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from postproc.errors import GcompError, Place
from postproc.machine.model import Machine
from postproc.motions import Motions
from postproc.pieces import Pieces
from postproc.units import TICKS_PER_MM

WHOLE = 1e-9  # of a motion: a piece that ends so near to its end ends it


def begins_of(pieces: Pieces) -> np.ndarray:
    """(P,) t of its motion at which each piece begins."""
    #     nominal motion  0 ----- 0.4 -------- 1     shares of the pieces, added up: of what
    #     pieces             0.4   |    0.6          part of the motion each stands
    owner, begin = pieces.motion, np.cumsum(pieces.share) - pieces.share
    first = np.concatenate([[True], owner[1:] != owner[:-1]])
    result: np.ndarray = begin - begin[first][np.cumsum(first) - 1]
    return result


def check(
    machine: Machine,
    nominal: Motions,
    pieces: Pieces,
    run: Motions,
    oriented: bool,
    near: Callable[[int], Place],
) -> None:
    """Raises GcompError for a piece, as the motions of a run read it, that sends an axis that
    nothing corrects elsewhere by more than an increment: rotary axes at every place, since they
    turn evenly along each motion, the others at the ends. oriented: rotary axes are corrected where
    words are places of the tip; near: where in the program a piece belongs."""
    owner, t = pieces.motion, begins_of(pieces) + pieces.share
    corrected = [bool(space and (space.polar or oriented)) for space in nominal.spaces]
    counts = ~nominal.alone[owner] & ~np.array(corrected)[nominal.space[owner]]
    inner = t < 1.0 - WHOLE
    for row in (row for row in machine.chained if row not in machine.corrected):
        start, target = nominal.start[row, owner], nominal.target[row, owner]
        known = counts & run.target_known[row] & nominal.target_known[row, owner]
        # behind a face C stays where the corrections led it, until it is named
        known &= (nominal.word[row, owner] >= 0) & ~nominal.incremental[row, owner]
        if row in machine.turning:
            known &= nominal.start_known[row, owner] | ~inner
        else:
            known &= ~inner
        should = np.where(inner, start + (target - start) * t, target)
        off = np.abs(run.target[row] - should)
        for k in np.flatnonzero(known & (off > nominal.grid[row, owner] + 1))[:1].tolist():
            sent, wanted = run.target[row, k] / TICKS_PER_MM, should[k] / TICKS_PER_MM
            letter = machine.letters[row]
            raise GcompError(
                f"the output sends {letter} to {sent:g}, and the program to {wanted:g}",
                "this is an error of gcomp: please report the program",
                near(k),
            )
