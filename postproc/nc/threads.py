"""Threads in the text: which of them a control cuts through several blocks, their lead, and the
words that every piece repeats.

A control that waits for the spindle's mark at the first block of a thread only, and goes on through
the next ones in step, lets a thread be cut into pieces. Sources: Fanuc B-64304EN-1, "Constant lead
threading" and "Continuous threading"; Haas, G32 ("this synchronization remains in effect for each
line in a G32 sequence"); LinuxCNC, G33 (issue 704: G33 behind G33 does not wait for the index
again, by design); Siemens, programming manual fundamentals, G33, chained threads under G64.
"""

from __future__ import annotations

import numpy as np

from postproc.expressions import expression
from postproc.motions import THREAD
from postproc.nc.batch import Batch
from postproc.nc.columns import one_of, spread
from postproc.nc.numbers import INSERT_WORD
from postproc.nc.queries import names, words_of
from postproc.nc.writing import Writing
from postproc.units import TICKS_PER_MM

STAYS = "NGMSTDH"  # words of a thread's block that do not belong to the thread
SPINDLE = expression(rb"[^(;]*?([ \t]*\$[ \t]*\d+)")
START_ANGLE = "Q"  # what it means in a block that does not start the thread, the manuals leave open


def thread_columns(
    b: Batch, block: np.ndarray, code: np.ndarray, motion: np.ndarray, feed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) bool whether a motion must stay one block, and (N,) mm per turn of a thread, 0 where it
    is not said. code (N,): kind;
    motion (N,): motion code in force; feed (N,): the F that holds."""
    whole, lead = np.zeros(len(block), bool), np.zeros(len(block))
    thread = (code == THREAD).nonzero()[0]
    if not len(thread):
        return whole, lead
    at = block[thread]
    d = b.dialect
    chained = np.isin(motion[thread], d.threads_chained) & np.isin(
        spread(b.held("path"), b.n)[at], d.threads_under
    )
    chained &= spread(b.held("feed mode"), b.n)[at] != 930  # F is a time there, not a lead
    for number in d.exact_stops:
        chained &= ~np.isin(at, b.single.get(number, ()))
    chained &= ~names(b, START_ANGLE)[at]
    whole[thread] = ~chained
    # mm of one unit: a lead is in inches under G20
    per = np.broadcast_to(b.unit_scale("Z")[0], b.n)[at] / TICKS_PER_MM
    # F holds from before, other letters (K of G33) stand in the block; one that stands there goes
    # first
    value = np.where("F" in d.thread_words, feed[thread], 0.0)
    for letter in d.thread_words.replace("F", ""):
        place = words_of(b, letter)
        column = np.zeros(b.n)
        column[b.words.block[place]] = np.abs(b.numbers(place))
        value = np.where(column[at] > 0, column[at], value)
    lead[thread] = np.nan_to_num(value) * per
    return whole, lead


def thread_words(b: Writing) -> None:
    """Every piece of a thread that was cut names the lead as its block does. Where that block
    became a rapid, since lost motion is taken up before the thread, all words that belong to the
    thread move to its first piece."""
    m, p, w = b.m, b.p, b.w
    led = ((m.code == THREAD) & (p.code[b.begin] != THREAD)).nonzero()[0]
    moved = np.isin(w.block, m.block[led]) & ~one_of(w.letter, map(ord, STAYS))
    moved[m.word[m.word >= 0]] = False
    at = moved.nonzero()[0]
    b.delete(at, np.searchsorted(m.block, w.block[at]))
    lead = one_of(w.letter, map(ord, b.dialect.thread_words))
    for i in (~b.first & (p.code == THREAD)).nonzero()[0]:
        motion, begins = p.motion[i], p.code[i - 1] != THREAD
        low, high = np.searchsorted(w.block, [m.block[motion], m.block[motion] + 1])
        words = (lead | moved)[low:high] if begins else lead[low:high]
        texts = [w.text[w.start[k] : b.tail(np.array([k]))[0]] for k in low + words.nonzero()[0]]
        if begins:
            texts += _spindle(b, int(motion))
        for text in texts:
            at, rank = int(b.behind(motion)), int(b.rank(np.array([i]))[0]) + INSERT_WORD // 2
            b.splice.texts([at], [at], [rank], [(b" " if b.spaced[motion] else b"") + text])


def _spindle(b: Writing, motion: int) -> list[bytes]:
    """The word $ of LinuxCNC, which names the spindle, taken out of the block of a motion."""
    begin, stop = (int(x[b.m.block[motion]]) for x in (b.w.block_start, b.w.block_stop))
    found = SPINDLE.match(b.w.text[begin:stop])
    if not found:
        return []
    start, end = (begin + k for k in found.span(1))
    b.splice.texts([start], [end], [0], [b""])
    return [found[1].strip()]
