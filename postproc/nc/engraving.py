"""Engraving of text (G47 of Haas): the block stays, its strokes are the control's.

X and Y are where the text begins, Z is its depth: these are corrected, as those of a hole, and R,
to which the tool returns, stays. What the machine is off across the text stays, which a notice
says. The tool ends beside the last letter, and how wide that is the control alone knows:
until rapids have named X and Y again, they are left as written, and nothing else may begin there.

Haas Mill Operator's Manual (2017, next generation control), "G47 Text Engraving"; the order of its
motions is in the built-in program O9876 as printed in manual 96-8000 (rev R), page 159: "G00 X#24
Y#25", "Z#18 If R, move there", the depth from there to Z, rapids between strokes at that level.
"""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.nc.batch import NO_WORDS, AxisWords, Batch
from postproc.nc.coded import written_codes
from postproc.nc.columns import one_of, spread
from postproc.nc.holes import ACROSS, in_cycle
from postproc.nc.queries import tell
from postproc.nc.state import InCycle

RAPID_FIRST = "the width of its letters is the control's: go on with G0 X Y in G90"
FEEDS = (10, 20, 30)


def as_motion(b: Batch, motion: np.ndarray) -> np.ndarray:
    """(B,) the motion code in force, or the engraving's in a block that engraves."""
    for number in b.dialect.engraves:
        if number in b.single:
            block = b.single[number]
            held = motion[block]
            b.blame(
                block[b.dialect.is_hole[np.maximum(held, 0)]],
                "an engraving within a canned cycle",
                "write G80 before it",
            )
            # a code of its own block only: what is in force stays for the blocks behind
            motion = motion.copy()
            motion[block] = number
            place = b.places["G"]
            place = place[written_codes(b.words, place) == number]
            b.code_word[b.words.block[place]] = place
    return motion


def cycle_of(b: Batch, motion: np.ndarray, axis_words: AxisWords) -> InCycle | None:
    """The engraving of a segment, or the canned cycle that holds its blocks. motion (B,): the
    motion code in force."""
    mask = one_of(motion, b.dialect.engraves)
    return (
        _place_of_text(b, mask, motion, axis_words)
        if any_of(mask)
        else in_cycle(b, motion, axis_words)
    )


def _place_of_text(
    b: Batch, mask: np.ndarray, motion: np.ndarray, axis_words: AxisWords
) -> InCycle | None:
    """The block of an engraving, alone in its segment, as a hole at the place where the text
    begins."""
    block, letter = mask.nonzero()[0], "Z"
    code = b.dialect.by_number[int(motion[block[0]])]
    plane = int(spread(b.held("plane"), b.n)[block[0]])
    absolute = spread(b.held("distance"), b.n)[block] != 910
    b.blame(block[~absolute], f"{code.word} ({code.meaning}) in G91", "write G90 before it")
    if ACROSS.get(plane) != letter or letter not in b.rows:
        b.blame(block, f"{code.word} ({code.meaning}) outside the XY plane", "write G17 before it")
        return None
    row = b.rows[letter]
    scale = int(np.broadcast_to(b.unit_scale(letter)[0], b.n)[block[0]])
    zero = int(np.broadcast_to(b.offset[row], b.n)[block[0]])
    own = {"Z": axis_words[letter][0], "R": b.once("R")}
    value = {x: zero + int(b.ticks(p[:1], np.array([scale]))[0]) for x, p in own.items() if len(p)}
    if "Z" not in value:
        b.foreign[block] = True
        b.blame(block, f"{code.word} ({code.meaning}) without Z", "write Z, its depth")
        return None
    stands, known = int(b.state.position[row]), bool(b.state.known[row])
    level = value.get("R", stands)
    if value["Z"] > level:
        b.blame(block, f"{code.word} whose depth lies above R", "check R and Z")
        return None
    said = (
        f"{code.word} ({code.meaning}) stays: where its text begins and its depth are corrected,"
        " what the machine is off across the text is not"
    )
    tell(b, f"left {code.word}", said, block[0])

    def one(x: float, kind: type = np.int64) -> np.ndarray:
        return np.array([x], kind)

    # As a hole: the tool goes to X Y of the first letter, down to Z, and up to R behind the last
    # one.
    return InCycle(
        letter=letter, row=row, mask=mask, blocks=block, target=one(level), bottom=one(value["Z"]),
        level=one(level), zero=one(zero), word=own["Z"][:1], initial=one(False, bool),
        code=motion[block], known=known or "R" in value, after=b.state.cycle,
    )  # fmt: skip


def known_behind(b: Batch, known: np.ndarray) -> np.ndarray:
    """(A,) bool, whether the place of each axis is known behind the batch. known (A,): were it not
    for an engraving."""
    if not _engraves(b):
        return known
    return known & ~np.isin(np.arange(len(known)), [b.rows[x] for x in b.loose])


def _engraves(b: Batch) -> bool:
    return not b.single.keys().isdisjoint(b.dialect.engraves)


def loose_axes(
    b: Batch, motion: np.ndarray, moving: np.ndarray, axis_words: AxisWords
) -> tuple[str, ...]:
    """Refuse what begins where an engraving has ended, leave rapids from there as they are, and
    give the axes whose place is not certain behind the batch."""
    if _engraves(b):
        return tuple(x for x in "XY" if x in b.rows)
    loose = b.state.loose
    if not loose:
        return ()
    # Of each axis: the first block that says its place anew. Up to the last of these every motion
    # begins beside where the words have it; rapids pass as written, for they are no cut.
    absolute = (np.broadcast_to(b.held("distance"), b.n) != 910) | b.machine
    named = {x: np.zeros(b.n, bool) for x in loose}
    counted = np.zeros(b.n, bool)
    for x in loose:
        for place, is_place in zip(axis_words[x], (True, False), strict=True):
            block = b.words.block[place]
            block = block[~b.taken[block]]
            # a distance from an uncertain place is as uncertain
            sure = absolute[block] & is_place
            named[x][block[sure]] = True
            counted[block[~sure & moving[block]]] = True
    for number in (280, 300):  # a reference point: the place is known, or said to be unknown
        for x in loose:
            named[x][b.single.get(number, NO_WORDS)] = True
    still = [x for x in loose if not named[x].any()]
    first = {x: int(named[x].argmax()) if x not in still else b.n for x in loose}
    unsure = np.arange(b.n) < max(first.values())
    before = np.arange(b.n) <= max(first.values())
    hole = b.dialect.is_hole[np.maximum(motion, 0)]
    wrong = counted | np.isin(motion, FEEDS) & before | hole & unsure
    b.blame(
        np.flatnonzero(wrong & moving & before),
        "a motion from where an engraving has ended",
        RAPID_FIRST,
    )
    b.as_written |= unsure & moving
    return tuple(still)
