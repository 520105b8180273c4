"""Which way round a rotary axis goes: C=DC(10) of Sinumerik, M126 of Heidenhain.

On both the control goes the other way round than the numbers say, from 350 to 10 degrees by +20
instead of -340. A feed that is cut would be led back through all angles between them, so it is not
followed there. Sources: Siemens NC programming manual, "Absolute dimension for rotary axes (DC,
ACP, ACN)"; Heidenhain TNC 620 (34056x-04), ISO programming, "Shortest-path traverse of rotary axes:
M126".
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.nc.batch import Batch
from postproc.nc.columns import hold_last, spread
from postproc.nc.grammar import ABSOLUTE, AXES
from postproc.nc.positions import Places
from postproc.nc.queries import words_of
from postproc.nc.state import NONE
from postproc.units import TICKS_PER_MM

GROUP = "rotary way"  # among the modal groups, where M126 and M127 are one
SHORTER, STRAIGHT = 126, 127
HALF, WHOLE = 180 * TICKS_PER_MM, 360 * TICKS_PER_MM  # of a turn, ticks
BY_STEPS = "write it as an increment, or as two blocks of less than 180 degrees"


def refuse_ways(b: Batch, block: np.ndarray, places: Places) -> None:
    """Blame the feeds in which an axis goes another way round than from its start to its target.
    block (N,): the blocks of `places`."""
    shorter = _shorter(b)
    rows = {x: row for x, row in b.rows.items() if x in "ABC" and x not in b.dialect.carried}
    if not rows or b.polar:
        return
    feeds = (spread(b.held("motion"), b.n) != 0)[block]
    for letter, row in rows.items():
        way = places.target[row] - places.start[row]
        known = places.start_known[row] & places.target_known[row] & feeds
        own = places.word[row] >= 0
        if shorter is not None:
            b.blame(
                block[known & own & shorter[block] & (np.abs(way) > HALF)],
                f"{letter} turns by more than 180 degrees under M126, which goes the shorter way",
                BY_STEPS,
            )
        for how, at in _directed(b, letter, block):
            wrong = {
                b"DC": np.abs(way[at]) > HALF,
                b"ACP": (way[at] < 0) | (way[at] >= WHOLE),
                b"ACN": (way[at] > 0) | (way[at] <= -WHOLE),
            }[how]
            b.blame(
                block[at[wrong & known[at]]],
                f"{letter}={how.decode()}() goes round the other way than its number says",
                BY_STEPS,
            )


def _shorter(b: Batch) -> np.ndarray | None:
    """(B,) bool: where M126 is in force, None where the control has it not."""
    if b.dialect.m_codes.get(SHORTER) != "shorter way":
        return None
    place = words_of(b, "M")
    column = np.full(b.n, NONE, np.int64)
    for number in (SHORTER, STRAIGHT):
        of = place[(b.words.mantissa[place] == number) & (b.words.decimals[place] == 0)]
        column[b.words.block[of]] = number
    b.given[GROUP] = column
    shorter: np.ndarray = hold_last(column, b.state.codes.get(GROUP, NONE)) == SHORTER
    return shorter


def _directed(b: Batch, letter: str, block: np.ndarray) -> Iterator[tuple[bytes, np.ndarray]]:
    """How words of an axis say the way, and (K,) the motions that they lead."""
    w, place = b.words, words_of(b, chr(ABSOLUTE + AXES.index(letter)))
    if not len(place):
        return
    texts = [w.text[w.start[k] : w.number[k]].upper() for k in place.tolist()]
    for how in (b"DC", b"ACP", b"ACN"):
        own = place[[how in text for text in texts]]
        at = np.searchsorted(block, w.block[own])
        yield how, at[np.isin(w.block[own], block)]
