"""Exact stops of a motion that was cut: only its last piece stops, the ones before run on.

A modal code (G61) is taken back by G64 at the first piece and named again at the last; one that
acts in its own block (G9) moves to the last piece.
"""

from __future__ import annotations

import numpy as np

from postproc.nc.batch import Batch
from postproc.nc.lexer import Words
from postproc.nc.numbers import INSERT_WORD
from postproc.nc.writing import Writing

RUN_ON = b"G64"


def stop_column(b: Batch, block: np.ndarray) -> np.ndarray:
    """(N,) ten times the code that makes the motion end in an exact stop, 0: none."""
    stop = np.zeros(b.n, np.int16)
    held = b.held("path")
    for number in b.dialect.exact_stops:
        if number in b.single:
            stop[b.single[number]] = number
        if isinstance(held, int):
            if held == number:
                stop.fill(number)
        else:
            stop[held == number] = number
    stop_column: np.ndarray = stop[block]
    return stop_column


def exact_stops(b: Writing) -> None:
    """Write the codes around every motion that stops exactly and has several pieces."""
    m, w = b.m, b.w
    final = b.final.nonzero()[0]
    cut = ((m.stop > 0) & b.several[b.first.nonzero()[0]]).nonzero()[0]
    for i in map(int, cut):
        number = int(m.stop[i])
        #   G61 G1 X9, cut at X3 and X6     G64 G1 X3   X6   G61 X9
        #   X9 with G61 in force            G64 X3      X6   G61 X9
        #   G9 G1 X9                        G1 X3       X6   G9 X9      (acts in its own block only)
        name = b"G%d" % (number // 10) + (b".%d" % (number % 10) if number % 10 else b"")
        space = b" " if b.spaced[i] else b""
        low, high = np.searchsorted(w.block, [m.block[i], m.block[i] + 1])
        own = [k for k in range(low, high) if w.letter[k] == ord("G") and _is(w, k, number)]
        single = bool(own) and number not in b.dialect.modal_stops
        if single:
            b.delete(np.array(own), np.full(len(own), i))
        elif own:
            word = own[-1]
            b.splice.texts([int(w.start[word])], [int(w.stop[word])], [0], [RUN_ON])
        else:
            b.splice.texts([int(b.head[i])], [int(b.head[i])], [0], [RUN_ON + space])
        at = int(b.behind(i))
        rank = int(b.rank(final[[i]])[0])
        b.splice.texts([at], [at], [rank + INSERT_WORD // 50], [name + space])


def _is(w: Words, word: int, number: int) -> bool:
    return bool(int(w.mantissa[word]) * 10 == number * 10 ** int(w.decimals[word]))
