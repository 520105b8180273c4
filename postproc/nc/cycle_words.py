"""Words that are no target of a motion and change all the same: the bottom of a hole, and
coordinates given to the place where the machine stands."""

from __future__ import annotations

import numpy as np

from postproc.motions import Motions
from postproc.nc.lexer import Words
from postproc.nc.numbers import INSERT_WORD, MOST_DECIMALS, POWERS, counts
from postproc.nc.splice import Splice
from postproc.nc.writing import Writing


def hole_words(b: Writing) -> None:
    """The bottom's word of every hole: kept where it holds, else anew, or put in where the one of
    the hole before would hold and is another. R's where the tool stands there, and comes to stand
    below."""
    m, p, w, holes = b.m, b.p, b.w, b.m.holes
    if not len(holes):
        return
    piece = np.searchsorted(p.motion, holes.motion)
    use = p.corrected[piece]
    for k in np.flatnonzero(use):
        row, motion, word = int(holes.axis[k]), int(holes.motion[k]), int(holes.word[k])
        if holes.level_word[k] >= 0:
            _level_word(b, int(k), int(p.start[row, piece[k]]))
        # In G91 the word is a distance from R, and R one from the level where the axis stands: that
        # level lies beside its place by the correction of the motion before, and R with it.
        beside = (
            int(p.start[row, piece[k]] - m.start[row, motion]) if m.incremental[row, motion] else 0
        )
        ticks = (
            int(p.bottom[piece[k]] - holes.zero[k]) - beside
        )  # under G91 R lies as much beside its place as the axis
        stands = int(holes.bottom[k] - holes.zero[k]) if word >= 0 else b.bottom
        b.bottom = ticks
        if ticks == stands:
            continue
        own = int(w.decimals[word]) if word >= 0 else 0
        decimals = np.array([min(max(int(m.places[row, motion]), own), MOST_DECIMALS)])
        value = counts(np.array([ticks]), m.scale[row, [motion]], decimals)
        b.touched[motion] = True
        if word >= 0:
            b.splice.numbers(
                w.number[[word]], w.stop[[word]], np.zeros(1, np.int64), value, decimals
            )
            continue
        prefix = np.array([[ord(" ") if b.spaced[motion] else 0, ord(b.axes[row])]], np.uint8)
        at = b.at[[motion]]
        b.splice.numbers(at, at, np.array([INSERT_WORD + 40]), value, decimals, prefix)


def _level_word(b: Writing, k: int, stands: int) -> None:
    """R of hole k, where its axis stands, at `stands` ticks."""
    m, w, holes = b.m, b.w, b.m.holes
    row, motion, word = int(holes.axis[k]), int(holes.motion[k]), int(holes.level_word[k])
    if stands >= holes.level[k]:
        return
    places = max(int(m.places[row, motion]), int(w.decimals[word]))
    decimals = np.array([min(places, MOST_DECIMALS)])
    value = counts(np.array([stands - holes.zero[k]]), m.scale[row, [motion]], decimals)
    b.touched[motion] = True
    b.splice.numbers(w.number[[word]], w.stop[[word]], np.zeros(1, np.int64), value, decimals)


def preset_words(splice: Splice, w: Words, m: Motions, shift: np.ndarray) -> None:
    """G92 X and its like name the nominal place; the machine stands beside it, so the word is moved
    by as much. shift (A, N + 1): ticks, before each motion. An axis that G28 has taken elsewhere
    since stands beside nothing."""
    t = m.presets
    for k in range(len(t)):
        at = t.axis[k], min(int(t.motion[k]), shift.shape[1] - 1)
        # G92 X0 where the machine stands 5 um beside X0: written as 0.005, so that the zero comes
        # to lie where the program means it.
        ticks, word = int(shift[at]), int(t.word[k])
        if not ticks or t.sent[k]:
            continue
        own = int(w.decimals[word])
        decimals = min(max(own, int(t.places[k])), MOST_DECIMALS)
        kept = min(own, decimals)
        number = int(w.mantissa[word]) // 10 ** (own - kept) * int(POWERS[decimals - kept])
        more = counts(np.array([ticks]), t.scale[k : k + 1], np.array([decimals]))
        splice.numbers(
            w.number[[word]], w.stop[[word]], np.zeros(1, np.int64), number + more,
            np.array([decimals], np.int64),
        )  # fmt: skip
