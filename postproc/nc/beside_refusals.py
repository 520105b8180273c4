"""What LinuxCNC refuses of a program with G41 G42: codes, and contours that the tool can not
follow.

The control stops there by itself, so nothing is corrected from there on: a reason stands beside
every motion behind it.
Source: LinuxCNC, src/emc/rs274ngc/interp_convert.cc (convert_cutter_compensation_on,
convert_set_plane, convert_coordinate_system, convert_home, convert_straight), interp_check.cc.
"""

from __future__ import annotations

import copy
from math import ceil, pi

import numpy as np

from postproc.motions import CLOCKWISE, COUNTER, ENTRY, FREE, HOLE, RAPID, Motions
from postproc.nc.batch import Batch
from postproc.nc.beside import DYNAMIC, by_tool
from postproc.nc.columns import spread
from postproc.nc.queries import names
from postproc.nc.shifted import LEFT, RIGHT, Block, Gouge, Shifted
from postproc.nc.state import NONE
from postproc.records import replace
from postproc.units import TICKS_PER_MM

ADVICE = "LinuxCNC stops there: change the program"


def refuse_beside(b: Batch, motions: Motions) -> Motions:
    """The motions with a reason from the first block on that LinuxCNC refuses. Sets `b.beside`."""
    before = b.state.beside
    followed = before.on or before.fault or b.beside.on or "cutter" in b.given
    if not (followed or np.count_nonzero(motions.cutter)) or not by_tool(b):
        return motions
    # A contour is followed only up to the first code that is refused: which of the two comes first
    # must not hang on where the input was cut.
    found = [(-1, before.fault)] if before.fault else [*_codes(b), *_motions(b, motions)]
    first = min(found)[0] if found else b.n
    if gouge := _gouge(b, motions, first):
        found = [gouge]
    if not found:
        return motions
    block, message = min(found)
    b.beside = replace(b.beside, shifted=None, fault=message)
    behind = (motions.block >= block) & (motions.reason == 0)
    return replace(motions, reason=np.where(behind, b.because(message, ADVICE), motions.reason))


def _codes(b: Batch) -> list[tuple[int, str]]:
    """Block and sentence of codes that may not stand there."""
    held, plane = spread(b.held("cutter"), b.n), spread(b.held("plane"), b.n)
    # (B,) whether compensation was on behind the block before each, plane and work offset likewise:
    # what counts is the change, and it may lie between two batches
    before = np.isin(
        np.concatenate([[b.state.codes.get("cutter", NONE)], held[:-1]]), b.dialect.beside
    )
    plane_before = np.concatenate([[b.state.codes.get("plane", NONE)], plane[:-1]])
    given = b.given.get("cutter", np.full(b.n, NONE))
    begins = np.isin(given, b.dialect.beside)
    work = spread(b.held("work offset"), b.n)
    work_before = np.concatenate([[b.state.codes.get("work offset", NONE)], work[:-1]])
    sent = np.zeros(b.n, bool)
    for number in (280, 300):
        sent[b.single.get(number, [])] = True
    wrong = (
        (begins & before, "cutter radius compensation is turned on while it is on"),
        (begins & (plane == 190), "cutter radius compensation in the plane YZ"),
        (begins & np.isin(given, DYNAMIC) & ~names(b, "D"), "G41.1 or G42.1 without D"),
        (
            before & (plane != plane_before),
            "the plane changes while cutter radius compensation is on",
        ),
        (
            before & (work != work_before),
            "the work offset changes while cutter radius compensation is on",
        ),
        (before & b.machine, "G53 while cutter radius compensation is on"),
        (before & sent, "G28 or G30 while cutter radius compensation is on"),
    )
    found = [(int(np.argmax(where)), message) for where, message in wrong if where.any()]
    return found + [
        (block, f"tool {number} of D is not in the tool table")
        for block, number in b.beside_missing
    ]


def _motions(b: Batch, motions: Motions) -> list[tuple[int, str]]:
    """The same for motions."""
    ends = (
        (motions.cutter == ENTRY)
        & (motions.radius == 0)
        & (np.isin(motions.code, (CLOCKWISE, COUNTER)))
    )
    ends &= spread(b.held("cutter"), b.n)[motions.block] == 400
    drills = (motions.cutter != FREE) & (motions.code == HOLE)
    wrong = (
        (ends, "the move just behind cutter radius compensation is an arc"),
        (drills, "a drilling cycle with cutter radius compensation on"),
    )
    return [
        (int(motions.block[np.argmax(where)]), message) for where, message in wrong if where.any()
    ]


def _gouge(b: Batch, motions: Motions, end: int) -> tuple[int, str] | None:
    """Where the tool does not fit, of the blocks before `end`. Follows the centre from batch to
    batch."""
    # the state before the batch may be asked again, and must not know of it
    shifted = copy.deepcopy(b.state.beside.shifted)
    for i in np.flatnonzero((motions.cutter != FREE) & (motions.block < end)).tolist():
        try:
            shifted = _followed(shifted, motions, i)
        except Gouge as gouge:
            return int(motions.block[i]), f"the contour can not be followed by its tool: {gouge}"
    b.beside = replace(b.beside, shifted=shifted)
    return None


def _followed(shifted: Shifted | None, motions: Motions, i: int) -> Shifted | None:
    block = block_of(motions, i, i)
    if motions.cutter[i] == ENTRY:
        if shifted is not None:
            shifted.leave(block)
        shifted = follower(motions, i)
        if shifted is not None:
            shifted.enter(motions.start[:, i] / TICKS_PER_MM, block)
    elif shifted is not None:
        shifted.follow(block)
    if shifted is not None:
        # ways that are sure by now are of no use here
        shifted.done.clear()
    return shifted


def follower(motions: Motions, i: int) -> Shifted | None:
    """A follower for the contour that motion i begins; None where it ends one, or can not be
    followed: by an arc, from an unknown place, or with a tool that is not stated."""
    # 0: nothing is shifted; nan: not stated
    radius = float(motions.radius[i])
    known = motions.start_known[:, i].all() and motions.target_known[:, i].all()
    arc = motions.code[i] in (CLOCKWISE, COUNTER)
    if (
        not radius
        or not np.isfinite(radius)
        or arc
        or not known
        or (motions.plane[:, i] < 0).any()
        or motions.alone[i]
    ):
        return None
    (first, second), (along, across) = motions.plane[:, i].tolist(), motions.nose[:, i].tolist()
    return Shifted((first, second), abs(radius), LEFT if radius > 0 else RIGHT, (along, across))


def block_of(motions: Motions, i: int, owner: int) -> Block:
    """Motion i as a block of a contour."""
    block = Block(owner, motions.target[:, i] / TICKS_PER_MM, bool(motions.code[i] == RAPID))
    k = int(np.searchsorted(motions.arcs.motion, i))
    if k < len(motions.arcs) and motions.arcs.motion[k] == i:
        sweep = float(motions.arcs.sweep[k])
        block.centre = float(motions.arcs.centre[0, k]), float(motions.arcs.centre[1, k])
        # 2 for more than a turn; the last part takes off what rounding adds to a full one
        block.turns = int(np.sign(sweep)) * ceil(abs(sweep) / (2 * pi) - 1e-9)
    return block
