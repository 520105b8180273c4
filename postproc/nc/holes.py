"""Canned cycles for holes, in place: X and Y are the hole's place, Z its bottom, R the level from
which it is drilled.

The block stays a cycle; what is corrected are its words. Z and R hold from block to block; the axis
that drills is the one across the plane. Without R a Fanuc drills from where it stands: G80 leaves
"R = 0 and Z = 0 in incremental command" (B-63534EN, "Canned cycle cancel"). Sources: NIST RS274/NGC
3.5.16 (G98: back to "the position that axis was in just before this series", holes with G99 between
or not); Fanuc B-63944EN, "Canned cycle for drilling"; LinuxCNC as measured
(tests/linuxcnc/README.md).
"""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.motions import Holes, no_holes
from postproc.nc.batch import AxisWords, Batch
from postproc.nc.columns import hold_index, hold_last
from postproc.nc.positions import Places
from postproc.nc.queries import tell, word_column, words_of
from postproc.nc.state import Cycle, InCycle
from postproc.records import replace

#   initial  ---.            .---  where the axis stood before the cycle; G98 goes back to it
#               : rapid      ^
#   level R  ---:------------.---  holes begin here; G99 goes back to it
#               v feed       |
#   bottom   ---'------------'---  the word Z (or that of the axis across the plane)
#
# In G90 R and Z count from the work offset's zero; in G91 R counts from the initial level and Z
# from R.
NONE = np.zeros(0, np.int64)
ACROSS = {170: "Z", 180: "Y", 190: "X"}
PLANES = {letter: code for code, letter in ACROSS.items()}
OTHER_PLANE = "a hole of a canned cycle in another plane than the cycle was called in"
WRITE_OUT = "--expand writes the cycle out as plain blocks"
PECKS = (730, 830)
NO_REPEATS = "on other controls it repeats the hole: write each hole in a block of its own"
SUNK = "a cycle in G98 whose R lies above the level where the tool stands"
SUNK_ADVICE = "whether it goes back to R or down is not said: write G99, or stand at R or above"
WITHOUT_R = (
    "a canned cycle without R is drilled from the level where the tool stands, and goes back there"
)
BY_CAM = "let the CAM program write the hole out as G0 and G1"  # where nothing writes it out


def _way_out(b: Batch) -> str:
    return WRITE_OUT if b.dialect.holes_written_out else BY_CAM


def _called(b: Batch, block: int) -> bool:
    """Whether the code of a canned cycle stands in a block."""
    codes = [b.given[group][block] for group in ("motion", "cycle") if group in b.given]
    return bool(b.dialect.is_hole[np.maximum(codes, 0)].any()) if codes else False


def _axis_of(b: Batch, first: int, motion: np.ndarray, planes: np.ndarray) -> tuple[str, bool]:
    """The axis along which is drilled, and whether the cycle's code says it. first: its block."""
    if letter := b.dialect.hole_axis.get(int(motion[first]), ""):
        return letter, True
    cycle = b.state.cycle
    if cycle is not None and not _called(b, first):  # it goes on
        return cycle.letter, False
    there_and_back = b.dialect.there_and_back[np.maximum(motion, 0)] & (motion >= 0)
    named = (there_and_back & b.has_axis & ~b.taken).nonzero()[0]
    if len(named):
        first = int(named[0])
        if (b.words.block[words_of(b, "Z")] == first).any():
            return "Z", False  # it goes to its words, whatever the plane: G18 is a lathe's
    return ACROSS.get(int(planes[first]), ""), False


# Whole: one line to a column; a branch is a kind of cycle.
def in_cycle(b: Batch, motion: np.ndarray, axis_words: AxisWords) -> InCycle | None:
    """What the cycle in force does in each of its blocks, or None. motion (B,): the motion code in
    force."""
    mask = b.dialect.is_hole[np.maximum(motion, 0)] & (motion >= 0)
    if not any_of(mask):
        return None
    planes = np.broadcast_to(b.held("plane"), b.n)
    cycle, begins = b.state.cycle, False
    letter, of_lathe = _axis_of(b, int(np.argmax(mask)), motion, planes)
    if letter not in b.rows:
        b.blame(
            mask.nonzero()[0],
            f"a canned cycle across {letter or 'a plane'}, which can not be followed",
            _way_out(b),
        )
        return None
    row = b.rows[letter]
    taps = b.dialect.there_and_back[np.maximum(motion, 0)[mask]].any()
    # a new series begins: what G98 goes back to is where its axis stands now
    if cycle is None or cycle.letter != letter or taps:
        initial, known = int(b.state.position[row]), bool(b.state.known[row])
        cycle, begins = Cycle(letter, initial=initial, known=known), True
    absolute = np.broadcast_to(b.held("distance"), b.n) != 910
    if taps:
        return _there_and_back(b, mask, motion, letter, cycle, absolute, axis_words)
    absolute_word, increment = axis_words[letter]
    depth = np.sort(np.concatenate([absolute_word, increment]))
    depth = depth[mask[b.words.block[depth]]]
    level_word = b.once("R")
    level_word = level_word[mask[b.words.block[level_word]]]
    drills = mask & b.has_axis & ~b.taken
    # R alone in a block drills at the place where the tool stands
    drills[b.words.block[level_word]] = True
    if not of_lathe:  # its code says the axis
        turned = drills & (planes != PLANES[letter])
        b.blame(turned.nonzero()[0], OTHER_PLANE, _way_out(b))
    scale = np.broadcast_to(b.unit_scale(letter)[0] // b.halves(letter), b.n)
    offset = np.broadcast_to(b.offset[row], b.n)
    by_increment = b.words.block[increment][mask[b.words.block[increment]]]
    b.blame(by_increment, "an increment for the bottom of a hole", _way_out(b))
    from_start = of_lathe and b.dialect.level_from_start
    level_zero = np.where(absolute & (not from_start), offset, cycle.initial)
    level_scale = np.broadcast_to(b.unit_scale(letter)[0], b.n) if from_start else scale  # a radius
    level, has_level = _held(b, level_word, level_zero, level_scale, cycle.level)
    named = has_level
    if of_lathe:
        level, has_level = np.where(has_level, level, cycle.initial), np.ones(b.n, bool)
    elif b.dialect.hole_from_start and not has_level.all():
        level = _from_start(b, mask & drills, level, has_level, cycle)
        has_level = np.ones(b.n, bool)
    bottom, has_bottom = _held(b, depth, np.where(absolute, offset, level), scale, cycle.bottom)
    holes = drills.nonzero()[0]
    aside = [
        b.words.block[place] for x, each in axis_words.items() if x != letter for place in each
    ]
    stored = _repeats(b, mask, drills, cycle.stored, np.concatenate([NONE, *aside]))
    if b.dialect.repeats == "L":  # where K repeats nothing, it is the least peck of G73 and G83
        k = b.words.block[words_of(b, "K")]
        b.blame(k[(mask & ~np.isin(motion, PECKS))[k]], "K in a cycle that has none", NO_REPEATS)
    holes = drills.nonzero()[0]
    word = word_column(b, depth)
    back = np.broadcast_to(b.held("return"), b.n) != 990
    # without R it goes back to where it stood, which is R level too
    initial = back & (cycle.initial > level) | (~named & (not of_lathe))
    _blame(b, holes, has_level, has_bottom, level, bottom, letter)
    flush = higher = None
    if cycle.known and not of_lathe:
        # R names the very level where the axis stood. In G98 it goes back to that as written, which
        # is another place than R once R is corrected (4.3 um were left of it on a map with lost
        # motion).
        even = named & absolute & (cycle.initial == level)
        initial |= back & even
        if b.dialect.returns_no_lower:
            higher = (back & even)[holes]
        else:
            b.blame(holes[(back & named & (cycle.initial < level))[holes]], SUNK, SUNK_ADVICE)
            flush = even[holes]
    own = word_column(b, level_word)
    first = int(np.argmax(mask))
    # A hole in G91 of a cycle that began in G90 is refused, or the other way round. How it began is
    # kept in Cycle.absolute, for the answer must not hang on where the input was cut.
    begun = None if absolute[first] and _called(b, first) else cycle.absolute
    if begun is None and len(holes):
        begun = bool(absolute[holes[0]])
    mixed = holes[absolute[holes] != begun]
    relative = holes[~absolute[holes] & ~initial[holes]]
    b.blame(np.concatenate([mixed, relative]), "a cycle that returns to R under G91", _way_out(b))
    after = None
    if mask[-1]:  # it goes on in the next batch
        held = int(level[-1]) if named[-1] else None  # where it stands anew, without R
        deep = int(bottom[-1]) if has_bottom[-1] else None
        after = Cycle(letter, held, deep, cycle.initial, cycle.known, stored, begun, cycle.away)
    return InCycle(
        letter=letter, row=row, mask=mask, blocks=holes,
        target=np.where(initial, cycle.initial, level)[holes], bottom=bottom[holes],
        level=level[holes], zero=np.where(absolute, offset, level)[holes], word=word[holes],
        initial=initial[holes], code=motion[holes], known=cycle.known, after=after,
        begins=begins, away=cycle.away, higher=higher, flush=flush, level_word=own[holes],
    )  # fmt: skip


def _there_and_back(
    b: Batch,
    mask: np.ndarray,
    motion: np.ndarray,
    letter: str,
    cycle: Cycle,
    absolute: np.ndarray,
    axis_words: AxisWords,
) -> InCycle:
    """G33.1: in step with the spindle from where the axes stand to the words, and back there
    (LinuxCNC as measured)."""
    row = b.rows[letter]
    place = axis_words[letter][0]
    place = place[mask[b.words.block[place]]]
    word = word_column(b, place)
    holes = (mask & b.has_axis & ~b.taken).nonzero()[0]
    goes_on = b.state.cycle is not None and not _called(b, int(np.argmax(mask)))
    # the next block of the series goes along the same axis, whatever plane holds by then
    led = mask[-1] and (goes_on or len(holes) > 0)  # else the next words say its axis
    after = Cycle(letter, initial=cycle.initial, known=cycle.known) if led else None
    level = np.full(b.n, cycle.initial, np.int64)
    zero = np.where(absolute, np.broadcast_to(b.offset[row], b.n), level)
    scale = np.broadcast_to(b.unit_scale(letter)[0] // b.halves(letter), b.n)
    bottom = level.copy()
    bottom[b.words.block[place]] = (
        b.ticks(place, scale[b.words.block[place]]) + zero[b.words.block[place]]
    )
    return InCycle(
        letter=letter, row=row, mask=mask, blocks=holes, target=level[holes], bottom=bottom[holes],
        level=level[holes], zero=zero[holes], word=word[holes], initial=np.ones(len(holes), bool),
        code=motion[holes], known=cycle.known, after=after,
    )  # fmt: skip


def refuse_slants(b: Batch, block: np.ndarray, places: Places) -> None:
    """G33.1 to a place beside the one where it stands. A word of that place itself moves nothing.
    block (N,): the blocks of `places`."""
    cycle = b.cycle
    if cycle is None or not b.dialect.there_and_back[cycle.code].any():
        return
    at = np.searchsorted(block, cycle.blocks)
    for other, row in b.rows.items():
        stays = places.start_known[row, at] & (places.start[row, at] == places.target[row, at])
        if row != cycle.row:
            b.blame(
                cycle.blocks[(places.word[row, at] >= 0) & ~stays],
                f"a rigid tap with a word of {other}, where it does not stand",
                f"go to its place before it: G33.1 with {cycle.letter} alone",
            )


def _held(
    b: Batch, place: np.ndarray, zero: np.ndarray, scale: np.ndarray, carry: int | None
) -> tuple[np.ndarray, np.ndarray]:
    """(B,) ticks of a word that holds until the next one, counted from `zero`, and whether it was
    ever given."""
    block = b.words.block[place]
    value = np.full(b.n, 0 if carry is None else carry, np.int64)
    named = np.zeros(b.n, bool)
    named[block] = True
    own = np.zeros(b.n, np.int64)
    # the zero of the word's own block counts, not of the block in which it still holds
    own[block] = b.ticks(place, scale[block]) + zero[block]
    last = hold_index(named)
    return np.where(last >= 0, own[np.maximum(last, 0)], value), (last >= 0) | (carry is not None)


def _from_start(
    b: Batch, drills: np.ndarray, level: np.ndarray, has_level: np.ndarray, cycle: Cycle
) -> np.ndarray:
    """(B,) ticks of R level, which is the initial level where no R was ever given. That is told."""
    without = (drills & ~has_level).nonzero()[0]
    if len(without):
        tell(b, "without R", WITHOUT_R, without[0])
    return np.where(has_level, level, cycle.initial)


def _repeats(b: Batch, mask: np.ndarray, drills: np.ndarray, stored: str, aside: np.ndarray) -> str:
    """L or K: so many holes; none stores the words alone, for the next hole. Takes the letter of
    such a block that came without a hole behind it before the batch, and returns that behind it.
    aside (W,): blocks of words of the other axes."""
    before = {-1: stored} if stored else {}  # block to letter
    several = []
    for letter in b.dialect.repeats:
        place = words_of(b, letter)
        place = place[mask[b.words.block[place]]]
        count, block = b.numbers(place), b.words.block[place]
        drills[block[count == 0]] = False
        before |= dict.fromkeys(block[count == 0].tolist(), letter)
        # The tool does not go to that place: taken as reached, a block of the way to it was put in
        # front of the next hole.
        goes = block[(count == 0) & np.isin(block, aside)]
        b.foreign[goes] = True
        b.blame(goes, f"{letter}0 beside a place stores words without drilling", _way_out(b))
        several.append(block[(count != 1) & (count != 0)])
    holes = drills.nonzero()[0]
    for at, letter in before.items():
        b.blame(
            holes[holes > at][:1],
            f"{letter}0 before this hole stores words without drilling",
            _way_out(b),
        )
    for block in several:
        b.blame(block, "a cycle that is repeated", _way_out(b))
    last = max(before, default=-1)
    return "" if len(holes) and holes[-1] > last else before.get(last, "")


def _blame(
    b: Batch,
    holes: np.ndarray,
    has_level: np.ndarray,
    has_bottom: np.ndarray,
    level: np.ndarray,
    bottom: np.ndarray,
    letter: str,
) -> None:
    b.blame(
        holes[~has_level[holes]],
        "a canned cycle without R",
        "write R, the level from which it drills",
    )
    b.blame(
        holes[~has_bottom[holes]],
        f"a canned cycle without {letter}",
        f"write {letter}, the bottom of the hole",
    )
    b.blame(
        holes[(bottom > level)[holes]],
        f"a hole whose bottom lies beyond R, against the sense of {letter}",
        WRITE_OUT,
    )


def holes_of(b: Batch, cycle: InCycle | None, block: np.ndarray, start: np.ndarray) -> Holes:
    """The holes among the motions whose blocks these are. start (A, N): ticks, where they begin."""
    if cycle is None or not len(cycle.blocks):
        return no_holes()
    motion, code = np.searchsorted(block, cycle.blocks), cycle.code
    no = np.zeros(len(motion), bool)
    flush = no if cycle.flush is None else cycle.flush
    # R may be written lower only together with the tool that stands at it. Behind holes that ended
    # at a lower R the tool does not, and R came out as that lower one.
    away = flush & (start[cycle.row, motion] != cycle.level)  # it stands at another R
    flush = flush & ~away
    back = np.broadcast_to(b.held("return"), b.n)[cycle.blocks] != 990
    level_word = np.full(len(motion), -1) if cycle.level_word is None else cycle.level_word
    held = hold_last(np.where(level_word >= 0, away, -1), cycle.away) > 0
    # its correction may make it so, and R does not go down with it
    b.blame(cycle.blocks[(away | flush & held) & back], SUNK, SUNK_ADVICE)
    if cycle.after is not None:
        b.cycle = replace(cycle, after=replace(cycle.after, away=bool(held[-1])))
    return Holes(
        motion=motion, axis=np.full(len(motion), cycle.row), bottom=cycle.bottom, level=cycle.level,
        zero=cycle.zero, word=cycle.word, initial=cycle.initial, flush=flush,
        first=(np.arange(len(motion)) == 0) & cycle.begins,
        higher=no if cycle.higher is None else cycle.higher,
        level_word=np.where(flush, level_word, -1), tap=b.dialect.is_tap[code],
        place=~b.dialect.there_and_back[code],
    )  # fmt: skip
