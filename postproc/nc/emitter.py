"""Pieces to text: a word that need not change keeps its bytes, and so does everything that is not a
word.

The first piece of a motion is written into its own block, which keeps N, F, S, T, M and comments;
further pieces become blocks of their own behind it, in the block's own style (spaces, line end,
block delete). Codes that a control executes after the motion (M0 M1 M2 M5 M9 M30) move to the last
piece.
"""

from __future__ import annotations

import numpy as np

from postproc.motions import Motions
from postproc.nc.added_blocks import codes_after_motion, frames_of_blocks
from postproc.nc.axis_words import axis_words, last_code, motion_codes
from postproc.nc.centres import centre_words
from postproc.nc.cycle_words import hole_words, preset_words
from postproc.nc.dialects import Dialect
from postproc.nc.feeds import inverse_time, kept_feeds, states_feed
from postproc.nc.lexer import Words
from postproc.nc.splice import Splice
from postproc.nc.state import Setup
from postproc.nc.stops import exact_stops
from postproc.nc.threads import thread_words
from postproc.nc.writing import Writing, Written
from postproc.pieces import Pieces
from postproc.records import replace


class Emitter:
    """Writes one machine's corrected programs in one dialect. Holds no state."""

    def __init__(self, dialect: Dialect, setup: Setup, marker: str):
        self.dialect, self.axes, self.marker = dialect, setup.axes, marker

    def run(
        self, words: Words, motions: Motions, pieces: Pieces, state: Written
    ) -> tuple[bytes, Written, int, int]:
        """Text of a batch, the next state, and how many blocks were changed and added."""
        first = words.text.find(b"\n")
        if not state.newline and first >= 0:  # the program's first line says it for all
            state = replace(
                state,
                newline=b"\r\n" if words.text[first - 1 : first] == b"\r" and first > 0 else b"\n",
            )
        if not len(motions):
            # not nan: a feed of the output's own is in force, which an F without a motion takes
            # back
            if state.feed == state.feed and states_feed(words):
                state = replace(state, feed=float("nan"))
            if not len(motions.presets) or not any(state.shift):
                return words.text, state, 0, 0
            splice = Splice(words.text)
            preset_words(splice, words, motions, np.array([state.shift]).T)
            return splice.result(), state, 0, 0
        return self._written(Writing(self.dialect, self.axes, words, motions, pieces, state))

    def _written(self, b: Writing) -> tuple[bytes, Written, int, int]:
        """The text with every word that must change; then what cut blocks need: times, M codes,
        stops, threads, line ends. Each part writes its splices, whatever the others do."""
        motion_codes(b)
        axis_words(b)
        centre_words(b)
        hole_words(b)
        if len(b.m.presets):
            preset_words(b.splice, b.w, b.m, b.shift())
        feed = kept_feeds(b) if self.dialect.feed_along_first else b.state.feed
        added = len(b.p) - len(b.m)
        if added:
            inverse_time(b)
            codes_after_motion(b)
            exact_stops(b)
            thread_words(b)
            frames_of_blocks(b, (~b.first).nonzero()[0])
        shift = tuple((b.p.end[:, -1] - b.m.target[:, -1]).tolist())
        state = Written(
            code=last_code(b), marked=b.state.marked, newline=b.state.newline, shift=shift,
            bottom=b.bottom, feed=feed,
        )  # fmt: skip
        touched = b.touched.nonzero()[0]
        if len(touched) and not state.marked and self.marker:
            # The marker tells a second pass that the program is corrected already (docs/DESIGN.md,
            # "A header in every output"): before the first block that changed, at the begin of its
            # line.
            at = b.w.text.rfind(b"\n", 0, int(b.w.block_start[b.m.block[touched[0]]])) + 1
            b.splice.texts([at], [at], [-1], [self.marker.encode() + (b.state.newline or b"\n")])
            state = replace(state, marked=True)
        return b.splice.result(), state, len(touched), added
