"""A corrected contour that the control could not follow is not handed on.

A correction turns blocks by a fraction of a degree, and a cut may come to lie before an inside
corner that nobody could foresee. Both contours are followed with LinuxCNC's rules; where the
nominal one passes and the corrected does not, the block is refused.
"""

from __future__ import annotations

import copy
from math import ceil, pi

import numpy as np

from postproc.errors import BlockFault
from postproc.motions import ENTRY, FREE, RAPID, Motions
from postproc.nc.beside_refusals import block_of, follower
from postproc.nc.shifted import Block, Gouge, Shifted
from postproc.pieces import Pieces
from postproc.records import mutable
from postproc.units import TICKS_PER_MM

LIMIT = (
    "inside G41 G42 a correction can make a corner too narrow: let the CAM program write the tool"
    " centre path there"
)


@mutable
class Contours:
    """Both contours while the program is inside one that can be followed."""

    nominal: Shifted | None = None
    corrected: Shifted | None = None


def follow_both(before: Contours, motions: Motions, pieces: Pieces) -> Contours:
    """The contours behind a batch; `before` stays as it is. Raises BlockFault for a block that only
    the nominal program could cut."""
    if not np.count_nonzero(motions.cutter):  # all FREE
        return before
    inside = np.flatnonzero(motions.cutter != FREE)
    c = copy.deepcopy(before)
    first = np.searchsorted(pieces.motion, np.arange(len(motions) + 1))
    for i in inside.tolist():
        # Way in and way out are both ENTRY; behind G40 there is no radius.
        leaves = motions.cutter[i] == ENTRY and not motions.radius[i]
        if motions.cutter[i] == ENTRY and not leaves:
            c = Contours(follower(motions, i), follower(motions, i))
        nominal, corrected = c.nominal, c.corrected
        if nominal is None or corrected is None:
            continue
        try:
            _step(nominal, motions, i, motions.start[:, i], block_of(motions, i, i))
        except Gouge:  # its control has other rules
            c = Contours()
            continue
        try:
            # the corrected contour has a block for each piece
            for k in range(int(first[i]), int(first[i + 1])):
                _step(corrected, motions, i, pieces.start[:, k], _block(motions, pieces, k))
        except Gouge as gouge:
            message = f"the corrected contour can not be followed by its tool: {gouge}"
            raise BlockFault(int(motions.block[i]), message, LIMIT) from None
        if corrected.backwards and not nominal.backwards:
            raise BlockFault(
                int(motions.block[i]), "the corrected contour runs backwards behind a corner", LIMIT
            )
        c = Contours() if leaves else c
    return c


def _step(shifted: Shifted, motions: Motions, i: int, start: np.ndarray, block: Block) -> None:
    if motions.cutter[i] != ENTRY:
        shifted.follow(block)
    elif motions.radius[i]:
        shifted.enter(start / TICKS_PER_MM, block)
    else:
        shifted.leave(block)
    shifted.done.clear()


def _block(motions: Motions, pieces: Pieces, k: int) -> Block:
    """A piece as a block of the contour."""
    block = Block(0, pieces.end[:, k] / TICKS_PER_MM, bool(pieces.code[k] == RAPID))
    arc = int(pieces.arc[k])
    if arc >= 0:
        arcs = motions.arcs
        rows = [int(arcs.first[arc]), int(arcs.second[arc])]
        first, second = ((pieces.start[rows, k] + pieces.centre[:, k]) / TICKS_PER_MM).tolist()
        sweep = float(arcs.sweep[arc] * pieces.share[k])
        block.centre = (first, second)
        # a piece of next to no sweep is still less than a turn, which is 1
        block.turns = int(np.sign(sweep)) * max(ceil(abs(sweep) / (2 * pi) - 1e-9), 1)
    return block
