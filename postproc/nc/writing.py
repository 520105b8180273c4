"""The output of one batch while it is written: where new words go, and what words are worth."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from postproc.flags import all_of, any_of
from postproc.motions import Motions
from postproc.nc.columns import begins, cells
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import RELATIVE
from postproc.nc.lexer import Words
from postproc.nc.numbers import INSERT_WORD, MOST_DECIMALS, POWERS, counts
from postproc.nc.splice import Splice
from postproc.pieces import Pieces
from postproc.records import record

# Edits at one place stand in the order of their ranks.
#   in the motion's own block             in a block put in behind, its piece's rank and
#     1           motion code                0          what it begins with: "/", a code, L
#     100 + row   axis words                 2          the code of an exact stop
#     120, 121    centre words               10 + row   axis words
#     140         bottom of a hole           30, 31     centre words, or R
#     150         F                          50         F, FMAX, the lead of a thread
#   0 is what stands there and is            60         M codes that act behind the motion
#   written anew.                            90         the end of the block
AFTER, AFTER_END = (
    -(10**12),
    10_000,
)  # ranks of added blocks: before all else at their place, unless that is the end of the text


IS_BLANK = np.isin(np.arange(256), (ord(" "), ord("\t")))


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


class Writing:
    """One batch of N motions in P pieces; from the first to the last piece of a motion, say of N10
    that is cut twice:

        piece      0    1    2    3         first (P,)   1 0 0 1
        motion     0    0    0    1         final (P,)   0 0 1 1
        text     N10  new  new  N20         several (P,) 1 1 1 0

    A first piece is written into the motion's own block, the others into blocks of their own
    behind it; touched (N,): whether the text of a motion's block changed."""

    def __init__(
        self,
        dialect: Dialect,
        axes: Sequence[str],
        words: Words,
        motions: Motions,
        pieces: Pieces,
        state: Written,
    ):
        self.dialect, self.axes, self.state = dialect, axes, state
        self.w, self.m, self.p = words, motions, pieces
        self.splice = Splice(words.text)
        if len(pieces) == len(motions):
            motions.recall(self, "one piece each", self._pieces)
        else:
            self._pieces()
        self.touched = np.zeros(len(motions), bool)
        self.byte = np.frombuffer(words.text + b"\0", np.uint8)
        self.bottom = state.bottom

    def _pieces(self) -> None:
        """What does not depend on where pieces lead."""
        dialect, motions = self.dialect, self.m
        self.first = begins(self.p.motion)
        # every motion has a first piece: columns of these are columns of motions
        self.begin = self.first.nonzero()[0]
        self.final = np.empty(len(self.p), bool)
        self.final[:-1], self.final[-1:] = self.first[1:], True
        # whether words may carry letters of other spellings
        self.spelled = dialect.grammar.is_respelled
        # whether any does
        self.has_spelled = self.spelled and any_of(self.w.letter >= RELATIVE)
        self.names_code = ~self.first  # pieces whose block names its motion code
        self.several = ~(self.first & self.final)
        # numbers above 0 have their sign, and every block begins with its statement
        self.klartext = dialect.grammar.klartext
        # what is above G1 G2 G3 in their codes: G101 of Okuma's polar interpolation
        self.above = np.zeros(len(motions), np.int64)
        if dialect.contour:
            polar = np.array([s is not None and bool(s.polar) for s in motions.spaces], bool)
            self.above[:] = dialect.contour * polar[motions.space]

    @property
    def head(self) -> np.ndarray:
        """(N,) where new words go before the first axis or centre word of motions."""
        return self._layout[0]

    @property
    def at(self) -> np.ndarray:
        """(N,) where they go behind the last."""
        return self._layout[1]

    @property
    def spaced(self) -> np.ndarray:
        """(N,) bool: motions whose words are spaced."""
        return self._layout[2]

    @cached_property
    def _layout(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """`head`, `at`, `spaced`, which a batch without new words needs none of."""
        m, w = self.m, self.w
        every = m.word
        all_words = every
        if len(m.arcs):
            centre = m.arcs.words
            if len(m.arcs) < len(m):
                centre = np.full((3, len(m)), -1)
                centre[:, m.arcs.motion] = m.arcs.words
            all_words = np.concatenate([every, centre])
        if len(m.holes):
            bottom = np.full((1, len(m)), -1)
            bottom[0, m.holes.motion] = m.holes.word
            all_words = np.concatenate([all_words, bottom])
        highest = all_words.max(axis=0)
        some = highest >= 0
        # of words 12 and 15, and none of a third axis: first 12, last 15
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
        head = np.where(some, w.start.take(first), fallback) if n else fallback
        at = np.where(some, self.tail(last), fallback) if n else fallback
        before, behind = self.byte.take(np.maximum(head - 1, 0)), self.byte.take(at)
        spaced = IS_BLANK.take(before) | IS_BLANK.take(behind)
        if self.dialect.grammar.assigns or self.klartext:
            spaced.fill(True)  # G64X=5 would be read as no code and its word
        return head, at, spaced

    def value(self, row: int | np.ndarray, piece: np.ndarray, decimals: np.ndarray) -> np.ndarray:
        """(K,) whole numbers: the axis word of pieces, in 10**-decimals of its unit."""
        return counts(
            self.ticks(row, piece), cells(self.m.scale, row, self.p.motion[piece]), decimals
        )

    def ticks(self, row: int | np.ndarray, piece: np.ndarray) -> np.ndarray:
        """(K,) what the axis word of pieces is worth."""
        m, p = self.m, self.p
        motion = p.motion[piece]
        absolute: np.ndarray = cells(p.end, row, piece) - cells(m.origin, row, motion)
        if not self.has_spelled and not any_of(m.incremental):
            return absolute
        incremental = m.incremental[row, motion]
        if self.has_spelled:  # X=IC() holds for its own word; blocks put in follow G90 G91
            by_letter = self.by_letter(m.word[row, motion]) & ~self.first[piece]
            incremental = np.where(by_letter, m.relative[motion], incremental)
        return np.where(incremental, p.end[row, piece] - p.start[row, piece], absolute)

    def by_letter(self, word: np.ndarray) -> np.ndarray:
        """(K,) bool: words whose own spelling says whether they are absolute."""
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
        decimals: np.ndarray = np.minimum(np.maximum(places, own), MOST_DECIMALS)
        return decimals

    def stands(self, word: np.ndarray, decimals: np.ndarray) -> np.ndarray:
        """(K,) the numbers that stand in the text, in 10**-decimals."""
        w = self.w
        own = w.decimals[word]
        if not any_of(own > decimals):
            whole: np.ndarray = w.mantissa[word] * POWERS[decimals - own]
            return whole
        kept = np.minimum(own, decimals)
        stands: np.ndarray = w.mantissa[word] // 10 ** (own - kept) * POWERS[decimals - kept]
        return stands

    def renumber(
        self, word: np.ndarray, value: np.ndarray, decimals: np.ndarray, where: np.ndarray
    ) -> None:
        if not all_of(where):
            word, value, decimals = word[where], value[where], decimals[where]
        plus = None
        if self.klartext:
            plus = np.where(value >= 0, ord("+"), 0).astype(np.uint8)[:, None]
        self.splice.numbers(
            self.w.number[word], self.w.stop[word], np.zeros(len(word), np.int64), value, decimals,
            plus,
        )  # fmt: skip

    def rank(self, piece: np.ndarray) -> np.ndarray:
        """(K,) order of pieces behind one block."""
        return self._ranks.take(piece)

    @cached_property
    def _ranks(self) -> np.ndarray:
        """(P,) the same of all."""
        # 1000 from piece to piece of a motion, counted from its first: what is put in behind a
        # block stands before what the next block, which begins at the same place, has changed of
        # itself.
        base = np.where(self.w.block_stop[self.m.block] < len(self.w.text), AFTER, AFTER_END)
        ranks: np.ndarray = (base - self.begin * 1000).take(self.p.motion)
        ranks += np.arange(0, len(ranks) * 1000, 1000)
        return ranks

    def behind(self, motion: int | np.ndarray) -> np.ndarray:
        """(K,) offset where blocks behind a motion's own begin."""
        return self._behind.take(motion)

    @cached_property
    def _behind(self) -> np.ndarray:
        """(N,) the same of all."""
        behind: np.ndarray = np.minimum(self.w.block_stop[self.m.block] + 1, len(self.w.text))
        return behind

    def feed(self, piece: int, number: bytes) -> None:
        """F of a piece: its number in the block that has it, else a word put in."""
        motion, first = self.p.motion[piece], self.first[piece]
        word = self.m.feed_word[motion]
        if first and word >= 0:
            self.splice.texts([self.w.number[word]], [self.w.stop[word]], [0], [number])
            return
        at = self.at[motion] if first else self.behind(motion)
        rank = INSERT_WORD if first else self.rank(np.array([piece]))[0]
        text = (b" F" if self.spaced[motion] else b"F") + number
        self.splice.texts([at], [at], [rank + 50], [text])

    def tail(self, word: np.ndarray) -> np.ndarray:
        """(K,) offsets behind words, with the parenthesis of X=IC(5)."""
        stop: np.ndarray = self.w.stop[word]
        if not self.has_spelled or self.klartext:
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

    def shift(self) -> np.ndarray:
        """(A, N + 1) ticks by which the axes stand beside their nominal places before each motion,
        and behind the last."""
        first = self.state.shift or (0,) * len(self.axes)
        return np.concatenate(
            [np.array([first]).T, self.p.end[:, self.final] - self.m.target], axis=1
        )
