"""What the code that follows a batch asks of it again and again, and the notices that it leaves."""

from __future__ import annotations

import numpy as np

from postproc.errors import Notice
from postproc.nc.batch import NO_WORDS, Batch
from postproc.records import replace

SET_TOOL = 61  # M61 of LinuxCNC: the tool in the spindle, without a change


def tell(b: Batch, code: str, said: str, block: int) -> None:
    """Leave a notice at a block."""
    b.notices.append(Notice(code, said, int(b.words.line[block])))


def words_of(b: Batch, letter: str) -> np.ndarray:
    """(K,) the words with this letter."""
    place: np.ndarray = b.places.get(letter, NO_WORDS)
    return place


def names(b: Batch, letters: str) -> np.ndarray:
    """(B,) bool: blocks that have one of these letters."""
    found = np.zeros(b.n, bool)
    for letter in letters:
        found[b.words.block[words_of(b, letter)]] = True
    return found


def word_column(b: Batch, place: np.ndarray | None) -> np.ndarray:
    """(B,) the one of the words `place` (K,) that stands in each block, -1: none."""
    column = np.full(b.n, -1, np.int64)
    if place is not None:
        column[b.words.block[place]] = place
    return column


def at_first(b: Batch, group: str) -> int:
    """The code of a modal group in force in the first block."""
    return int(np.broadcast_to(b.held(group), b.n)[0])


def unit_at_first(b: Batch, letter: str = "Z") -> int:
    """Ticks of one unit of an axis in the first block."""
    return int(np.broadcast_to(b.unit_scale(letter)[0], b.n)[0])


def lose(b: Batch, letters: str) -> None:
    """From here on it is not known where these axes stand."""
    # a copy: the state before the batch may be used again
    known = b.state.known.copy()
    known[[row for x, row in b.rows.items() if x in letters]] = False
    b.state = replace(b.state, known=known)


def tool_in_use(b: Batch) -> int:
    """The tool in the spindle behind the batch: the last T when M6 came, -1 before any."""
    #   block    T1 M6  T2  M6  T3     M6 brings the last T that is named before it or in its block;
    #   spindle    1     1   2   2     a T behind it makes the next tool ready.
    place, change = b.places.get("T"), b.places.get("M")
    b.next_tool = b.state.next_tool if place is None else int(b.numbers(place[-1:])[0])
    if change is None:
        return b.state.tool_number
    if (told := _tool_told(b, change)) is not None:
        return told
    changes = change[(b.words.mantissa[change] == 6) & (b.words.decimals[change] == 0)]
    if not len(changes):
        return b.state.tool_number
    if place is None:
        return b.state.next_tool
    called = place[b.words.block[place] <= b.words.block[changes[-1]]]
    return int(b.numbers(called[-1:])[0]) if len(called) else b.state.next_tool


def _tool_told(b: Batch, change: np.ndarray) -> int | None:
    """The tool that M61 Q says last, with no M6 behind it; None: none. change (K,): the M words."""
    if b.dialect.m_codes.get(SET_TOOL) != "set tool number":
        return None
    w, number = b.words, words_of(b, "Q")
    brings = change[((w.mantissa[change] == 6) | (w.mantissa[change] == SET_TOOL))]
    if not len(brings) or w.mantissa[brings[-1]] != SET_TOOL:
        return None
    own = number[w.block[number] == w.block[brings[-1]]]
    return int(b.numbers(own[:1])[0]) if len(own) else None
