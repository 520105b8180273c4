"""Words and modal state in, motions out.

Follows the program as the control would, up to where the tool shall be; knows nothing of errors.
Each modal group is a column over the blocks, filled down from the last code given; a group that no
block names stays a single number. Absolute words set a position, incremental words add to it; both
in whole ticks, so any cut of the input gives the same positions.

    N1 G0 X9 . N2 X8 | N3 G92 X0 . N4 G1 X5 . N5 X6 | N6 G54 . N7 X1      a batch of blocks
    '-- segment ---' '---------- segment ---------' '-- segment --'       followed one by one

A block that shifts the coordinates (postproc.nc.frames) begins a segment, so within one every shift
is a number, and all its blocks are followed at once.

Not followed here, and handed on as motions with a reason (postproc.nc.codes): cycles, cutter
radius, tool length, shifts of the coordinates, subprograms.
"""

from __future__ import annotations

import itertools

import numpy as np

from postproc.errors import BlockFault, Notice
from postproc.flags import any_of
from postproc.motions import FOREIGN, Motions, join, no_motions, no_spells
from postproc.nc import face, frames
from postproc.nc.arcs import Circle, arcs_of
from postproc.nc.batch import NO_WORDS, AxisWords, Batch
from postproc.nc.beside import beside_columns
from postproc.nc.beside_refusals import refuse_beside
from postproc.nc.coded import Coded, written_codes
from postproc.nc.columns import at, hold_last_float, named_since, one_of, spread
from postproc.nc.conditionals import conditionals
from postproc.nc.control import Control, spelled
from postproc.nc.dialects import Dialect
from postproc.nc.engraving import as_motion, cycle_of, known_behind, loose_axes
from postproc.nc.grammar import ABSOLUTE, KEYWORD_LETTER, RELATIVE, UNKNOWN_FEED
from postproc.nc.holes import holes_of, refuse_slants
from postproc.nc.increments import count_increments
from postproc.nc.left import left_as_they_are
from postproc.nc.lexer import Words
from postproc.nc.planes import refuse_planes
from postproc.nc.plans import Plans
from postproc.nc.positions import Places, position
from postproc.nc.queries import tool_in_use, word_column
from postproc.nc.refusals import (
    check_letters,
    check_points,
    check_second,
    cycle_calls,
    drop_arguments,
    idle_letters,
    m_codes,
    macros,
    refuse_dwells,
    refuse_motions,
    refused_groups,
    single_commands,
    stray_words,
    unnamed_motions,
)
from postproc.nc.rotary_ways import refuse_ways
from postproc.nc.splines import refuse_splines, spaced_column
from postproc.nc.state import NONE, Beside, Frame, ModalState, Setup, no_frame
from postproc.nc.stops import stop_column
from postproc.nc.threads import thread_columns
from postproc.nc.tips import first_frame, refuse_cycles, refuse_tips, tip_codes, transformed
from postproc.nc.zeros import offset_columns
from postproc.records import replace
from postproc.units import TICKS_PER_MM


class Interpreter(Control):
    """Follows programs of one dialect on one machine. Holds no state: `run` takes it and gives the
    next."""

    def __init__(self, dialect: Dialect, setup: Setup):
        super().__init__(dialect, setup)
        self.plans = Plans(self)

    def initial(self) -> ModalState:
        """The state before the first block."""
        setup = self.setup
        # ten times the number of a code: G90, G21, G94, and G90.1 or G91.1
        modal = dict.fromkeys(self.dialect.groups, NONE)
        modal.update({"plane": self.dialect.plane, "distance": 900, "units": 210, "feed mode": 940})
        modal["arc centre"] = 901 if setup.arc_centre == "absolute" else 911
        modal["carried"] = 900
        modal["motion"] = self.dialect.motion
        if "return" in modal:
            modal["return"] = self.dialect.returns
        modal["work offset"] = (
            540 if "G54" in setup.offsets and 540 in self.dialect.by_number else NONE
        )
        start, known = self.stands()
        frame = self._first_frame()
        position, known = transformed(setup.kinematics, start, known, (None, frame))
        beside = Beside(tool=setup.tool if self.dialect.length_letter == "D" else NONE)
        return ModalState(
            modal, position, known, frame=frame, beside=beside, tool_number=setup.tool
        )

    def _first_frame(self) -> Frame:
        """No shift, but a G92 that was in force before the program."""
        frame = no_frame(len(self.setup.axes))
        place = self.setup.offsets.get("G92") or self.setup.offsets.get("G52") or {}
        preset = [round(place.get(x, 0.0) * TICKS_PER_MM) for x in self.setup.axes]
        return first_frame(self.setup.kinematics, replace(frame, preset=np.array(preset, np.int64)))

    def run(self, words: Words, state: ModalState) -> tuple[Motions, ModalState, list[Notice]]:
        """Motions of a batch. Raises BlockFault for the first block that can not be followed;
        nothing is changed then."""
        # a line like one before, in the same modes: what hangs on its places alone is worked out
        key = self.plans.key(words, state)
        if key is not None and (plan := self.plans.get(key)) is not None:
            return plan.of(words, state)
        cuts, coded = self._segments(words, state)
        if len(cuts) <= 2:  # one segment
            b = Batch(self, words, state, coded)
            found = follow(b)
            return found if key is None else self.plans.remember(key, b, found)
        parts, blocks, starts = [], [], []
        notices: list[Notice] = []
        for first, stop in itertools.pairwise(cuts):
            part = words.part(first, stop)
            try:
                motions, state, more = follow(Batch(self, part, state))
            except BlockFault as fault:
                fault.block += first  # it was counted in the segment
                raise
            parts.append(motions)
            blocks.append(first)
            starts.append(int(np.searchsorted(words.block, first)))
            notices += more
        return join(parts, blocks, starts), state, notices

    def _segments(self, words: Words, state: ModalState) -> tuple[list[int], Coded | None]:
        """Blocks at which segments begin, and the number of blocks: a block that shifts the
        coordinates begins one; and the codes that were read for it, if any were."""
        if state.ended:
            return [0, words.blocks], None
        # Most lines of a stream have no G: a look at the letters as bytes is the whole price of it.
        place: np.ndarray = NO_WORDS
        letters_there = words.letter.tobytes()
        if b"G" in letters_there or KEYWORD_LETTER in letters_there:
            place = ((words.letter == ord("G")) | (words.letter == KEYWORD_LETTER)).nonzero()[0]
        switches = list(tip_codes(self.dialect, self.setup))
        if self.dialect.length_letter == "D":
            switches.append(6)  # M6 brings a tool with its edge
        letters = self.dialect.shifts_at_once
        if not len(place) and not letters and not switches:
            return [0, words.blocks], None
        tools: list[int] = []
        if switches and b"M" in letters_there:
            coded = np.isin(words.mantissa, switches) & (words.decimals == 0)
            tools = words.block[coded & (words.letter == ord("M"))].tolist()
        if letters:
            tools += words.block[np.isin(words.letter, letters)].tolist()
        # A segment begins with a block whose code or letter (H, D, T, E of some controls) changes a
        # shift, or switches the tool point. Behind an engraving one ends: where its text stops is
        # not known, so that the next block must begin from a state of its own.
        number = written_codes(words, place)
        begins = words.block[
            place[self.dialect.begins_segment[np.maximum(number, 0)] & (number >= 0)]
        ].tolist()
        ends = (words.block[place[one_of(number, self.dialect.engraves)]] + 1).tolist()
        return sorted({0, words.blocks, *begins, *tools, *ends}), (place, number)


def follow(b: Batch) -> tuple[Motions, ModalState, list[Notice]]:
    """In the order of a control: letters, codes, what they take away from the motion, then
    positions and arcs."""
    # First what letters mean in this segment, then the codes, and from these which words are no
    # targets (taken), which motions are not followed (foreign) and why (reason): places are worked
    # out of what is left. Batch.blame keeps the first reason of a block, so the order of steps is
    # also that of what is said.
    drop_arguments(b)
    check_letters(b)
    b.read_codes()
    b.polar = face.letter_in(b)
    check_second(b)
    if b.dialect.grammar.homing:
        b.read_homing()
    if b.integers == "least increments":
        count_increments(b)  # before any word is turned into ticks
    axis_words = _axis_words(b)
    single_codes(b, axis_words)
    if b.n:
        frames.event(b, axis_words)
    refused_groups(b)
    offset_columns(b)  # behind what moves zeros
    face.settle_zero(b)
    refuse_tips(b)
    refuse_planes(b, axis_words)
    m_codes(b)
    macros(b)
    cycle_calls(b)
    if b.dialect.conditions:
        conditionals(b)
    check_points(b)
    centre_words = {c: place for c, s in CENTRES.items() if len(place := b.one_of(*s))}
    motion = face.motions(b, as_motion(b, _motion(b)))
    moving = _moving(b, motion, centre_words)
    b.cycle = cycle_of(b, motion, axis_words)
    if b.cycle is not None:
        moving[b.cycle.mask] = False
        moving[b.cycle.blocks] = True
    b.loose = loose_axes(b, motion, moving, axis_words)
    refuse_motions(b, motion, moving)
    refuse_cycles(b, motion, moving)
    face.refuse_faces(b, motion, moving)
    refuse_splines(b, motion, moving, centre_words)
    if 40 in b.single:
        refuse_dwells(b, moving, centre_words)
    if b.dialect.one_command:
        single_commands(b)
    if b.dialect.letters:
        idle_letters(b, motion, moving)
    if not b.dialect.modal_motion:
        unnamed_motions(b, moving)
    if centre_words:
        stray_words(b, centre_words, moving & ((motion == 0) | (motion == 10)))
    places = position(b, block := (moving | b.foreign).nonzero()[0], axis_words)
    refuse_slants(b, block, places)
    refuse_ways(b, block, places)
    return columns(b, block, motion, places, centre_words), next_state(b, places), b.notices


def _axis_words(b: Batch) -> AxisWords:
    """The words of each axis, absolute and relative; sets b.has_axis."""
    words = {
        x: (b.one_of(*absolute), b.one_of(*relative))
        for x, absolute, relative in face.spellings(b, b.control.spellings)
    }
    for place in itertools.chain(*words.values()):
        if len(place):
            b.has_axis[b.words.block[place]] = True
    return words


def _motion(b: Batch) -> np.ndarray:
    """(B,) the motion code in force, or a cycle's, where cycles are a group of their own."""
    motion = spread(b.held("motion"), b.n)
    if b.dialect.stays:
        left_as_they_are(b, motion)
    if not b.dialect.hole_axis:
        return motion
    cycle = spread(b.held("cycle"), b.n)
    return np.where(b.dialect.is_hole[np.maximum(cycle, 0)], cycle, motion)


def _moving(b: Batch, motion: np.ndarray, centre_words: dict[str, np.ndarray]) -> np.ndarray:
    """(B,) bool: blocks that move; a full circle has its centre alone."""
    moving = b.has_axis & ~b.taken
    if centre_words:
        arc_code = (motion == 20) | (motion == 30)
        for place in centre_words.values():
            block = b.words.block[place]
            moving[block] |= arc_code[block] & ~b.taken[block]
    return moving


def single_codes(b: Batch, axis_words: AxisWords) -> None:
    """Codes that act in their own block only: G28 and G30 take the axis words, G53 changes their
    frame, G4 waits."""
    for number, block in b.single.items():
        code = b.dialect.by_number[number]
        # G28 X0: a place on the way, not where the block ends
        if code.takes:
            b.taken[block] = True
            if not code.refuses and not code.does:
                b.loses[block] = True
        if code.refuses:
            b.foreign[block] = True
            b.reason[block] = b.because(f"{code.word} ({code.meaning})", code.refuses)
        if number == 530:
            b.machine[block] = True
            wrong = block[spread(b.held("distance"), b.n)[block] == 910]
            b.blame(wrong, "G53 under G91", "controls disagree on what that means: write G90 G53")
            added = np.concatenate([b.words.block[place] for _, place in axis_words.values()])
            b.blame(
                block[np.isin(block, added)],
                f"an increment in a block of {code.word}",
                "write the place in machine coordinates",
            )
        elif number == 40 and b.dialect.dwell != "P":
            b.taken[block] = True  # X and U are seconds here
        elif number == 40:
            timed = word_column(b, b.once("P")) >= 0
            b.blame(
                block[(b.has_axis & ~timed)[block]],
                "G4 with an axis word and no P",
                "this control's dwell time is P; for X or U in seconds use another --dialect",
            )


def _feeds(b: Batch) -> tuple[np.ndarray, np.ndarray]:
    """(B,) F that holds in each block, and (B,) its F word, -1: none. Sets `b.feed`
    and `b.feed_words`."""
    place = b.once("F")
    if "F" in b.dialect.dwell and 40 in b.single:  # there F is the time of a dwell
        # (Sinumerik, Heidenhain's DIN/ISO): as a feed it would hold for all that follows
        place = place[~np.isin(b.words.block[place], b.single[40])]
    feed, word = np.empty(b.n), np.empty(b.n, np.int64)
    word.fill(-1)
    unknown_feed = b.places.get(chr(UNKNOWN_FEED))
    b.feed, b.feed_words = b.state.feed, place
    if not len(place) and unknown_feed is None:
        feed.fill(b.feed)
        return feed, word
    feed.fill(np.nan)
    feed[b.words.block[place]] = b.numbers(place)
    if unknown_feed is not None:  # a value that only the machine knows
        feed[b.words.block[unknown_feed]] = 0.0
    word[b.words.block[place]] = place
    feed = hold_last_float(feed, b.feed)
    b.feed = float(feed[-1])
    return feed, word


def columns(
    b: Batch,
    block: np.ndarray,
    motion: np.ndarray,
    places: Places,
    centre_words: dict[str, np.ndarray],
) -> Motions:
    """Gather the columns of the moving blocks, and the arcs among them."""
    feed, feed_word = _feeds(b)
    renamed, b.renamed = named_since(b.code_word >= 0, block, b.state.renamed)
    if not len(block):
        beside_columns(b, block)
        none = no_motions(len(b.rows), b.reasons, b.presets, b.frame.space)
        return refuse_beside(b, none)
    motion = motion[block]
    code = b.dialect.kind[np.maximum(motion, 0)]
    if any_of(b.foreign):
        code[b.foreign[block]] = FOREIGN
    inverse = spread(at(b.held("feed mode"), block), len(block)) == INVERSE
    if any_of(inverse):
        # F under G93 is 1 / minutes of its own block: one that holds from before says no time of
        # this one
        slow = inverse & (feed_word[block] < 0) & (motion != 0) & ~b.foreign[block]
        if chr(UNKNOWN_FEED) in b.places:
            unknown = inverse & np.isin(block, b.words.block[b.places[chr(UNKNOWN_FEED)]])
            b.blame(
                block[unknown],
                "G93 and an F whose value only the machine knows",
                "write the number of every F, or G94",
            )
        b.blame(
            block[slow],
            "G93 and no F in the block",
            "inverse time needs an F word in every block that feeds",
        )
    # G53, and rapids from where an engraving has ended
    alone = (b.machine | b.as_written)[block]
    circle = Circle(
        block=block, code=code, plane=spread(at(b.held("plane"), block), len(block)),
        absolute=spread(at(b.held("arc centre"), block), len(block)) == 901, alone=alone,
    )  # fmt: skip
    arcs = arcs_of(b, places, circle, centre_words)
    whole, lead = thread_columns(b, block, code, motion, feed[block])
    length = np.empty((len(b.rows), len(block)), np.int64)
    length[:] = b.frame.length[:, None]  # one throughout: what changes it begins a segment
    holes = holes_of(b, b.cycle, block, places.start)
    motions = Motions(
        block=block, code=code, start=places.start, target=places.target,
        start_known=places.start_known, target_known=places.target_known, word=places.word,
        incremental=places.incremental, grid=places.grid, scale=places.scale, origin=places.origin,
        places=places.least, alone=alone, inverse=inverse, feed=feed[block],
        feed_word=feed_word[block], code_word=b.code_word[block], reason=b.reason[block],
        renamed=renamed, arcs=arcs, reasons=b.reasons, holes=holes, presets=b.presets,
        **beside_columns(b, block), length=length,
        relative=spread(at(b.held("distance"), block), len(block)) == RELATIVE_WORDS,
        sent=places.sent, changed=places.changed, stop=stop_column(b, block), whole=whole,
        lead=lead, spaced=spaced_column(b, block, code),
        space=spread(int(b.frame.space is not None), len(block)), spaces=[None, b.frame.space],
        heat=NO_HEAT, spells=no_spells(), alike=None,
    )  # fmt: skip
    return refuse_beside(b, motions)


def next_state(b: Batch, places: Places) -> ModalState:
    return ModalState(
        codes=b.after(), position=places.end_position, known=known_behind(b, places.end_known),
        tool=b.tool_after, feed=b.feed, ended=b.ended, renamed=b.renamed, origin=b.offset[:, -1],
        zero_known=b.zero_known, frame=b.frame, sent=places.end_sent, changed=places.end_changed,
        cycle=b.cycle.after if b.cycle else None, beside=b.beside, tool_number=tool_in_use(b),
        next_tool=b.next_tool, loose=b.loose, offsets=b.offsets,
    )  # fmt: skip


NO_HEAT = np.zeros((0, 0), np.int64)
INVERSE, RELATIVE_WORDS = np.array(930), np.array(910)  # without axes: postproc.units
CENTRES = {c: (c, spelled(ABSOLUTE, c), spelled(RELATIVE, c)) for c in "IJK"} | {"R": ("R",)}
