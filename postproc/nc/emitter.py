"""Pieces to text: a word that need not change keeps its bytes, and so does everything that is not a
word.

The first piece of a motion is written into its own block, which keeps N, F, S, T, M and comments;
further pieces become blocks of their own behind it, in the block's own style (spaces, line end,
block delete). Codes that a control executes after the motion (M0 M1 M2 M5 M9 M30) move to the last
piece.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.motions import FOREIGN, Motions
from postproc.nc.added_blocks import frames_of_blocks, late_codes
from postproc.nc.centres import centre_words
from postproc.nc.columns import begins, cells
from postproc.nc.cycle_words import hole_words, preset_words
from postproc.nc.dialects import Dialect
from postproc.nc.feeds import GROUPS, kept_feeds, states_feed
from postproc.nc.grammar import RELATIVE
from postproc.nc.interpreter import Setup
from postproc.nc.inverse_time import inverse_time
from postproc.nc.lexer import Words
from postproc.nc.numbers import INSERT_WORD, MOST_DECIMALS, POWERS, counts
from postproc.nc.splice import Splice
from postproc.nc.stops import exact_stops
from postproc.nc.threads import thread_words
from postproc.pieces import Pieces
from postproc.records import record

INSERT_CODE = 1
AFTER, AFTER_END = (
    -(10**12),
    10_000,
)  # ranks of added blocks: before all else at their place, unless that is the end of the text


@record
class Written:
    """What one batch hands to the next: the motion code that the output last wrote (-1: as the
    program), whether the marker stands, the line end in use, and the F that it has in force where
    the program has another (else nan)."""

    code: int = -1
    marked: bool = False
    newline: bytes = b""
    shift: tuple[int, ...] = ()
    bottom: int = 0
    feed: float = float("nan")


class Emitter:
    """Writes one machine's corrected programs in one dialect. Holds no state."""

    def __init__(self, dialect: Dialect, setup: Setup, marker: str):
        self.dialect, self.setup, self.marker = dialect, setup, marker
        self.spelled = dialect.grammar.is_respelled
        # rows of each group of axes
        self.groups = [[i for i, x in enumerate(setup.axes) if x in group] for group in GROUPS]

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
            if state.feed == state.feed and states_feed(words):
                state = replace(state, feed=float("nan"))
            if not len(motions.presets) or not any(state.shift):
                return words.text, state, 0, 0
            splice = Splice(words.text)
            preset_words(splice, words, motions, np.array([state.shift]).T)
            return splice.result(), state, 0, 0
        return Batch(self, words, motions, pieces, state).run()


class Batch:
    def __init__(
        self, emitter: Emitter, words: Words, motions: Motions, pieces: Pieces, state: Written
    ):
        self.e, self.w, self.m, self.p, self.state = emitter, words, motions, pieces, state
        self.splice = Splice(words.text)
        self.axes = emitter.setup.axes
        self.first = begins(pieces.motion)
        self.final = np.empty(len(pieces), bool)
        self.final[:-1], self.final[-1:] = self.first[1:], True
        self.touched = np.zeros(len(motions), bool)
        self.byte = np.frombuffer(words.text + b"\0", np.uint8)
        self.bottom = state.bottom
        # whether words may carry letters of other spellings
        self.spelled = emitter.spelled
        # whether any does
        self.told = self.spelled and np.count_nonzero(words.letter >= RELATIVE) > 0
        self.several = ~(self.first & self.final)
        # numbers above 0 have their sign, and every block begins with its statement
        self.klartext = emitter.dialect.grammar.klartext
        self.layout()

    def run(self) -> tuple[bytes, Written, int, int]:
        self.motion_codes()
        self.axis_words()
        centre_words(self)
        hole_words(self)
        if len(self.m.presets):
            preset_words(self.splice, self.w, self.m, self._shift())
        feed = kept_feeds(self) if self.e.dialect.feed_along_first else self.state.feed
        added = len(self.p) - len(self.m)
        if added:
            inverse_time(self)
            late_codes(self)
            exact_stops(self)
            thread_words(self)
            frames_of_blocks(self, (~self.first).nonzero()[0])
        shift = tuple((self.p.end[:, -1] - self.m.target[:, -1]).tolist())
        state = Written(
            self._last_code(), self.state.marked, self.state.newline, shift, self.bottom, feed
        )
        touched = self.touched.nonzero()[0]
        if len(touched) and not state.marked and self.e.marker:
            at = self.w.text.rfind(b"\n", 0, int(self.w.block_start[self.m.block[touched[0]]])) + 1
            self.splice.texts(
                [at], [at], [-1], [self.e.marker.encode() + (self.state.newline or b"\n")]
            )
            state = replace(state, marked=True)
        return self.splice.result(), state, len(touched), added

    def _shift(self) -> np.ndarray:
        """(A, N + 1) ticks by which the axes stand beside their nominal places before each motion,
        and behind the last."""
        first = self.state.shift or (0,) * len(self.axes)
        return np.concatenate(
            [np.array([first]).T, self.p.end[:, self.final] - self.m.target], axis=1
        )

    def layout(self) -> None:
        """Where new words go: per motion `at` (N,) behind its last axis or centre word, `head` (N,)
        before its first, and whether its words are spaced."""
        m, w = self.m, self.w
        every = m.word
        all_words = every
        if len(m.arcs):
            centre = np.full((3, len(m)), -1)
            centre[:, m.arcs.motion] = m.arcs.words
            all_words = np.concatenate([every, centre])
        if len(m.holes):
            bottom = np.full((1, len(m)), -1)
            bottom[0, m.holes.motion] = m.holes.word
            all_words = np.concatenate([all_words, bottom])
        highest = all_words.max(axis=0)
        some = highest >= 0
        # Without a sign -1, no word, is the largest number of all; where nothing else is, it stays.
        first = all_words.view(np.uint64).min(axis=0).view(np.int64)
        last = highest
        if all_words is not every:
            axis_last = every.max(axis=0)
            last = np.where(axis_last >= 0, axis_last, highest)
        n = len(w.start)
        fallback = w.block_stop[m.block]
        if n and np.count_nonzero(some) < len(
            some
        ):  # behind the block's last word, before a comment
            last_word = np.searchsorted(w.block, m.block, side="right") - 1
            fallback = np.where(
                w.block[np.maximum(last_word, 0)] == m.block, self.tail(last_word), fallback
            )
        self.head = np.where(some, w.start[first], fallback) if n else fallback
        self.at = np.where(some, self.tail(last), fallback) if n else fallback
        blank = (self.byte == ord(" ")) | (self.byte == ord("\t"))
        self.spaced = (
            blank[np.maximum(self.head - 1, 0)] | blank[np.minimum(self.at, len(blank) - 1)]
        )
        # G64X=5 would be read as no code and its word
        self.spaced |= self.e.dialect.grammar.assigns or self.klartext

    # -- G words -----------------------------------------------------------------------------------

    def motion_codes(self) -> None:
        """Name the motion code where the output's differs from the program's."""
        p, m = self.p, self.m
        first_code, last_code = p.code[self.first], p.code[self.final].astype(np.int64)
        last_code[last_code == FOREIGN] = -1  # what it leaves in force is the program's own affair
        before = np.empty_like(last_code)
        before[0], before[1:] = self.state.code, last_code[:-1]
        # the program named its code anew since
        before = np.where(m.renamed | (before < 0), m.code, before)
        explicit, followed = m.code_word >= 0, m.code != FOREIGN
        change = (explicit & (first_code != m.code) & followed).nonzero()[0]
        if len(change):
            word = m.code_word[change]
            self.splice.texts(
                self.w.number[word],
                self.w.stop[word],
                np.zeros(len(word)),
                [b"%d" % c for c in first_code[change]],
            )
            self.touched[change] = True
        insert = (~explicit & (first_code != before) & followed).nonzero()[0]
        if len(insert):
            texts = [
                b"G%d" % c + (b" " if s else b"")
                for c, s in zip(first_code[insert], self.spaced[insert], strict=True)
            ]
            self.splice.texts(
                self.head[insert], self.head[insert], np.full(len(insert), INSERT_CODE), texts
            )
            self.touched[insert] = True
        # Pieces behind the first name their code when it differs from the piece before.
        code = p.code.astype(np.int64)
        self.names_code = begins(code) & ~self.first
        if self.klartext or not self.e.dialect.modal_motion:
            self.names_code = ~self.first

    def _last_code(self) -> int:
        code = int(self.p.code[-1])
        return code if code != FOREIGN else -1

    # -- axis words --------------------------------------------------------------------------------

    def value(self, row: int | np.ndarray, piece: np.ndarray, decimals: np.ndarray) -> np.ndarray:
        """(K,) whole numbers: the axis word of pieces, in 10**-decimals of its unit."""
        return counts(
            self._ticks(row, piece), cells(self.m.scale, row, self.p.motion[piece]), decimals
        )

    def _ticks(self, row: int | np.ndarray, piece: np.ndarray) -> np.ndarray:
        """(K,) what the axis word of pieces is worth."""
        m, p = self.m, self.p
        motion = p.motion[piece]
        absolute = cells(p.end, row, piece) - cells(m.origin, row, motion)
        if not self.told and not m.incremental.any():
            return absolute
        incremental = m.incremental[row, motion]
        if self.told:  # X=IC() holds for its own word; blocks put in follow G90 G91
            by_letter = self._by_letter(row, motion) & ~self.first[piece]
            incremental = np.where(by_letter, m.relative[motion], incremental)
        return np.where(incremental, p.end[row, piece] - p.start[row, piece], absolute)

    def _by_letter(self, row: int | np.ndarray, motion: np.ndarray) -> np.ndarray:
        """(K,) bool: words whose own spelling says whether they are absolute."""
        word = self.m.word[row, motion]
        return (
            (word >= 0) & (self.w.letter[np.maximum(word, 0)] >= RELATIVE)
            if len(self.w.letter)
            else word >= 0
        )

    def decimals(self, row: int | np.ndarray, motion: np.ndarray) -> np.ndarray:
        """(K,) decimals to write: the least increment's, or the programmed word's own if it has
        more."""
        m, w = self.m, self.w
        word, places = cells(m.word, row, motion), cells(m.places, row, motion)
        own = np.where(word >= 0, w.decimals[np.maximum(word, 0)], 0) if len(w.decimals) else 0
        return np.minimum(np.maximum(places, own), MOST_DECIMALS)

    def _enough(self, row: int, piece: np.ndarray, decimals: np.ndarray) -> np.ndarray:
        """(K,) as many decimals as new words need: more than the least increment's where the
        nominal place has more."""
        ticks, scale = self._ticks(row, piece), self.m.scale[row, self.p.motion[piece]]
        for _ in range(MOST_DECIMALS):
            decimals = decimals + (
                (ticks % (scale // POWERS[decimals]) != 0) & (decimals < MOST_DECIMALS)
            )
        return decimals

    def axis_words(self) -> None:
        m, p = self.m, self.p
        # Every motion has a first piece: columns of first pieces are columns of motions.
        first = self.first.nonzero()[0]
        starts, ends = p.start.take(first, axis=1), p.end.take(first, axis=1)
        suspect = (ends != m.target) | (m.incremental & (starts != m.start))
        followed = ~m.alone
        named = m.word >= 0
        suspect &= named & followed
        # In blocks of their own, and put into the motion's where it does not name an axis that
        # moves.
        missing = ~named & (ends != starts) & m.target_known
        missing &= followed & (m.code != FOREIGN) & p.corrected[first]
        if len(m.holes):
            missing[m.holes.axis, m.holes.motion] = False
        added = (~self.first).nonzero()[0]
        self._rewrite(*suspect.nonzero())
        for row, letter in enumerate(self.axes) if len(added) or np.count_nonzero(missing) else ():
            write = first[missing[row]]
            if len(added):
                moves = p.end[row, added] != p.start[row, added]
                write = np.sort(np.concatenate([write, added[moves | self._in_plane(row, added)]]))
            if len(write):
                self._put_in(row, letter, write)

    def _rewrite(self, row: np.ndarray, motion: np.ndarray) -> None:
        """Change the numbers of words (K,) that stand in the text."""
        word = cells(self.m.word, row, motion)
        decimals = self.decimals(row, motion)
        value = self.value(row, self.first.nonzero()[0][motion], decimals)
        differs = value != self._stands(word, decimals)
        self._replace(word, value, decimals, differs)
        self.touched[motion[differs]] = True

    def _put_in(self, row: int, letter: str, write: np.ndarray) -> None:
        """Write words that stand nowhere yet."""
        motion = self.p.motion[write]
        decimals = self._enough(row, write, self.decimals(row, motion))
        start = np.where(self.first[write], self.at[motion], self.behind()[motion])
        prefix = np.zeros((len(write), 6 if self.spelled else 2), np.uint8)
        prefix[:, 0] = np.where(
            self.spaced[motion] & (self.first[write] | self._not_leading(row, write)), ord(" "), 0
        )
        prefix[:, 1] = self._letters(row, letter, motion)
        rank = np.where(self.first[write], INSERT_WORD + row, self.rank(write) + 10 + row)
        place = self._as_place(row, motion)
        if place.any():  # X=AC(5)
            prefix[place, 2:] = np.frombuffer(b"=AC(", np.uint8)
        value = self.value(row, write, decimals)
        if self.klartext:
            prefix[:, 2] = np.where(value >= 0, ord("+"), 0)
        self.splice.numbers(start, start, rank, value, decimals, prefix)
        self.splice.constants(start[place], start[place], rank[place], b")")
        self.touched[motion] = True

    def _as_place(self, row: int, motion: np.ndarray) -> np.ndarray:
        """(K,) bool: new words that say themselves that they are places, though G91 is in force."""
        m = self.m
        if not self.spelled:
            return np.zeros(len(motion), bool)
        place: np.ndarray = (
            m.relative[motion] & (m.word[row, motion] < 0) & ~m.incremental[row, motion]
        )
        return place

    def _in_plane(self, row: int, piece: np.ndarray) -> np.ndarray:
        """(K,) bool: pieces that are arcs in whose plane the axis lies."""
        arcs, arc = self.m.arcs, self.p.arc[piece]
        if not len(arcs):
            return np.zeros(len(piece), bool)
        at = np.maximum(arc, 0)
        plane: np.ndarray = (arc >= 0) & ((arcs.first[at] == row) | (arcs.second[at] == row))
        return plane

    def _stands(self, word: np.ndarray, decimals: np.ndarray) -> np.ndarray:
        """(K,) the numbers that stand in the text, in 10**-decimals."""
        w = self.w
        own = w.decimals[word]
        if not np.count_nonzero(own > decimals):
            return w.mantissa[word] * POWERS[decimals - own]
        kept = np.minimum(own, decimals)
        return w.mantissa[word] // 10 ** (own - kept) * POWERS[decimals - kept]

    def _replace(
        self, word: np.ndarray, value: np.ndarray, decimals: np.ndarray, where: np.ndarray
    ) -> None:
        if np.count_nonzero(where) < len(where):
            word, value, decimals = word[where], value[where], decimals[where]
        plus = np.where(value >= 0, ord("+"), 0).astype(np.uint8)[:, None]
        self.splice.numbers(
            self.w.number[word],
            self.w.stop[word],
            np.zeros(len(word), np.int64),
            value,
            decimals,
            plus if self.klartext else None,
        )

    def _letters(self, row: int, letter: str, motion: np.ndarray) -> np.ndarray:
        """(K,) uint8 the letter to write: the block's own (U for X, lower case) where it has
        one."""
        word = self.m.word[row, motion]
        if not len(self.w.start) or self.klartext:  # an increment's letter is the I of IX
            return np.full(len(motion), ord(letter), np.uint8)
        own = self.byte[self.w.start[np.maximum(word, 0)]]
        absolute_letter = np.full(len(motion), ord(letter), np.uint8)
        if letter == "C":  # the second coordinate of polar interpolation
            polar = [s.polar if s is not None else "" for s in self.m.spaces]
            told = np.array([ord(x or letter) for x in polar], np.uint8)
            absolute_letter = told[self.m.space[motion]]
        # Blocks with U or W alone stay incremental for their own axis; other axes follow G90 G91.
        return np.where(word >= 0, own, absolute_letter)

    def rank(self, piece: np.ndarray) -> np.ndarray:
        """(K,) order of pieces behind one block."""
        begin = self.first.nonzero()[0]
        count = np.cumsum(self.first) - 1
        base = np.where(
            self.w.block_stop[self.m.block[self.p.motion[piece]]] < len(self.w.text),
            AFTER,
            AFTER_END,
        )
        return base + (piece - begin[count[piece]]) * 1000

    def behind(self) -> np.ndarray:
        """(N,) offset where blocks behind each motion's own begin."""
        return np.minimum(self.w.block_stop[self.m.block] + 1, len(self.w.text))

    def _not_leading(self, row: int, piece: np.ndarray) -> np.ndarray:
        """(K,) whether another word stands before this axis' in an added block."""
        p = self.p
        leads = self.names_code[piece].copy()
        for other in range(row):
            leads |= (p.end[other, piece] != p.start[other, piece]) | self._in_plane(other, piece)
        return leads

    def tail(self, word: np.ndarray) -> np.ndarray:
        """(K,) offsets behind words, with the parenthesis of X=IC(5)."""
        stop = self.w.stop[word]
        if not self.told or self.klartext:
            return stop
        stop = stop.copy()
        for k in (self.w.letter[word] >= RELATIVE).nonzero()[0]:
            stop[k] = self.w.text.find(b")", int(stop[k])) + 1 or stop[k]
        return stop

    def delete(self, word: np.ndarray, motion: np.ndarray) -> None:
        """Take words out, with the blank before them (after them, for the first word)."""
        start, stop = self.w.start[word], self.tail(word)
        leads = start <= self.head[motion]
        start = start - ((self.byte[np.maximum(start - 1, 0)] == ord(" ")) & ~leads)
        stop = stop + ((self.byte[stop] == ord(" ")) & leads)
        self.splice.constants(start, stop, np.zeros(len(word)), b"")
        self.touched[motion] = True
