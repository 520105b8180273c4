"""What blocks have in common that their places alone tell apart.

In a stream a line is mostly like others before it: the same letters in the same modes, other
places. So what was worked out for a batch of one block is remembered by its letters, the values of
those that name no axis, and the modes. Where the next one is like it, only its places and F are
worked out, the places by the code that works them out for all (positions.py); every other column is
the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from postproc.errors import Notice
from postproc.flags import all_of
from postproc.motions import FEED, RAPID, Motions
from postproc.nc.rotary_ways import GROUP, SHORTER
from postproc.nc.state import NONE, ModalState
from postproc.records import mutable, replace

if TYPE_CHECKING:
    from postproc.nc.batch import Batch
    from postproc.nc.control import Control
    from postproc.nc.lexer import Words

MOST = 256  # plans that are kept
LAST_LETTER = ord("Z")
WHOLE = b"DFGHLMNOPQS"  # letters whose numbers mean the same with a point and without
DWELL, TIMED = 4, [*b"GP"]  # G4, whose P says how long it lasts
Key = tuple[object, ...]
Followed = tuple[Motions, ModalState, list[Notice]]  # a batch's, the state behind it


@mutable
class Plan:
    """A batch of one block, `block` (0 or 1,) whether it moves, its motions, and the state behind
    it."""

    b: Batch
    block: np.ndarray
    motions: Motions
    after: ModalState

    def of(self, words: Words, state: ModalState) -> Followed:
        """Those of other words, another position and another F. Raises BlockFault for a number
        beyond all places."""
        b, feed = self.b, state.feed
        # The batch of the plan itself is used again: all that it has worked out but its places
        # stands.
        b.words, b.state = words, state
        if len(b.feed_words):
            feed = float(b.numbers(b.feed_words)[-1])
        if b.axes is None:
            return self.motions, self.after.at(state.position, feed), []
        start, target, position = b.axes.again(self.block)
        motions = self.motions
        if len(self.block):
            feeds = np.empty(len(self.block))
            feeds.fill(feed)
            motions = replace(motions, start=start, target=target, feed=feeds)
        return motions, self.after.at(position, feed), []


class Plans:
    """The plans of one control, those that were asked for last."""

    def __init__(self, control: Control):
        self.by_key: dict[Key, Plan] = {}
        # letters of a block to its words that name no axis, nor F, those of them that count if it
        # is a dwell, and those that must have a point; None: no block that is planned
        self.others: dict[bytes, tuple[np.ndarray, np.ndarray, np.ndarray] | None] = {}
        axes = (*control.rows, *control.increment_rows)
        #   G1 X10 Y5 F300     Letters GXYF; of these X Y F are free, G counts.
        #   G1 X12.5 Y6 F250   the same plan
        #   G0 X12.5 Y6        another one: another number of G, and other letters
        self.free = {ord(x) for x in (*axes, "F", "N")}
        d = control.dialect
        counts = (control.setup.integers or d.integers) == "least increments"
        # where X1 and X1. differ, a word without a point says more than its place; T1100 and T01100
        # may be two tools
        points = bool(counts or d.integer_notice or d.tool_offsets)
        self.whole = set(WHOLE) - {ord(x) for x in axes} if points else set(range(LAST_LETTER + 1))
        self.none = d.conditions  # these hang on how far a line is indented

    def key(self, words: Words, state: ModalState) -> Key | None:
        """All by which a batch of one block is another than its places; None: none is planned."""
        if words.blocks != 1 or self.none:
            return None
        letters = words.letter.tobytes()
        if letters not in self.others:
            self._others(letters)
        found = self.others[letters]
        if found is None or words.skip[0] or words.within >= 0:
            return None
        others, dwell, pointed = found
        if len(pointed) and not all_of(words.pointed.take(pointed)):
            return None
        for k in dwell[:1]:
            if words.mantissa[k] == DWELL and not words.decimals[k]:
                others = dwell
        if not len(others):
            return letters, state.modes
        values = words.mantissa.take(others).tobytes(), words.decimals.take(others).tobytes()
        return letters, state.modes, *values

    def _others(self, letters: bytes) -> None:
        """Keep which words of a block of these letters count."""
        if len(self.others) >= MOST:
            self.others.clear()
        # letters beyond Z stand for texts, of which a key says nothing; what would differ by these
        # is guarded elsewhere today
        if max(letters, default=0) > LAST_LETTER:
            self.others[letters] = None
            return
        others = [k for k, letter in enumerate(letters) if letter not in self.free]
        of = bytes(letters[k] for k in others)
        dwell = [k for k in others if letters[k] == ord("G")] if sorted(of) == TIMED else []
        pointed = [k for k, letter in enumerate(letters) if letter not in self.whole]
        first, second, third = (np.array(x, np.int64) for x in (others, dwell, pointed))
        self.others[letters] = first, second, third

    def get(self, key: Key) -> Plan | None:
        plan = self.by_key.pop(key, None)
        if plan is not None:  # it is the last one that was asked for
            self.by_key[key] = plan
        return plan

    def remember(self, key: Key, b: Batch, found: Followed) -> Followed:
        """Make a plan of a batch, where its places say nothing else. What was found; its motions
        then know those that are like them."""
        motions, after, notices = found
        if notices or not _places_alone(b, motions, after):
            return found
        while len(self.by_key) >= MOST:
            del self.by_key[next(iter(self.by_key))]
        motions = replace(motions, alike={})
        self.by_key[key] = Plan(b=b, block=motions.block, motions=motions, after=after)
        return motions, after, notices


def _places_alone(b: Batch, m: Motions, after: ModalState) -> bool:
    """Whether nothing but start, target and position of a batch depends on where its axes go, or
    stand: lines and feeds outside cycles, cutter radius compensation, tilted planes and tool point
    control, that shift no coordinates and that no tool change and no reference point comes with.

    Which places are known, and what is refused, say the names of axes and the modes alone.
    """
    before, axes = b.state, b.axes
    shifts = b.frame is not before.frame or after.offsets is not before.offsets
    # within G41 G42, and where they begin and end, every batch makes another one
    beside = b.beside is not before.beside
    if after.codes.get(GROUP, NONE) == SHORTER:  # the way says what is refused
        return False
    if shifts or beside or b.frame.space is not None or b.cycle is not None:
        return False
    if axes is not None and (axes.forgets or axes.held):
        return False
    return all_of((m.code == RAPID) | (m.code == FEED))
