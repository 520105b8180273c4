"""Axis words and motion codes of the output: a word that need not change keeps its bytes."""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.motions import FOREIGN
from postproc.nc.columns import begins, cells
from postproc.nc.numbers import INSERT_WORD, MOST_DECIMALS, POWERS
from postproc.nc.writing import Writing

INSERT_CODE = 1
NOUGHT, MOST = np.array(0), np.array(MOST_DECIMALS)  # without axes: postproc.units
NO_MOTIONS = np.zeros(0, np.int64)


def motion_codes(b: Writing) -> None:
    """Name the motion code where the output's differs from the program's."""
    p, m = b.p, b.m
    first_code, last_code = p.code[b.first], p.code[b.final]
    before = np.empty(len(m), np.int64)
    before[0], before[1:] = b.state.code, last_code[:-1]
    before[before == FOREIGN] = -1  # what it leaves in force is the program's own affair
    # the program named its code anew since
    anew = m.renamed | (before < NOUGHT)
    if any_of(anew):
        before = np.where(anew, m.code, before)
    explicit, differs = m.code_word >= NOUGHT, first_code != m.code
    change: np.ndarray = NO_MOTIONS
    if any_of(differs):
        change = (explicit & differs & (m.code != FOREIGN)).nonzero()[0]
    if len(change):
        word = m.code_word[change]
        b.splice.texts(
            b.w.number[word],
            b.w.stop[word],
            np.zeros(len(word)),
            [b"%d" % c for c in (first_code + b.above)[change]],
        )
        b.touched[change] = True
    unnamed = first_code != before
    if any_of(unnamed):
        unnamed &= (m.code != FOREIGN) & ~explicit
    insert = unnamed.nonzero()[0]
    if len(insert):
        texts = [
            b"G%d" % c + (b" " if s else b"")
            for c, s in zip((first_code + b.above)[insert], b.spaced[insert], strict=True)
        ]
        b.splice.texts(b.head[insert], b.head[insert], np.full(len(insert), INSERT_CODE), texts)
        b.touched[insert] = True
    # Pieces behind the first name their code when it differs from the piece before.
    if len(p) > len(m) and b.dialect.modal_motion and not b.klartext:
        # L is a radius beside G102 and G103 alone
        b.names_code &= begins(p.code) | ((b.above[p.motion] > 0) & (p.arc >= 0))


def last_code(b: Writing) -> int:
    code = int(b.p.code[-1])
    return code if code != FOREIGN else -1


def _enough(b: Writing, row: int, piece: np.ndarray, decimals: np.ndarray) -> np.ndarray:
    """(K,) as many decimals as new words need: more than the least increment's where the
    nominal place has more (200 mm in inches), and the control reads so many digits."""
    ticks, scale = b.ticks(row, piece), b.m.scale[row, b.p.motion[piece]]
    most = np.full(len(piece), MOST_DECIMALS)
    if b.dialect.digits:
        whole = np.searchsorted(POWERS[1:], np.abs(ticks) // scale, side="right") + 1
        most = np.clip(b.dialect.digits - whole, decimals, MOST_DECIMALS)
    for _ in range(MOST_DECIMALS):
        wants = (ticks % (scale // POWERS[decimals]) != 0) & (decimals < most)
        if not any_of(wants):
            break
        decimals = decimals + wants
    return decimals


def axis_words(b: Writing) -> None:
    m, p = b.m, b.p
    first, starts, ends = b.begin, p.start, p.end
    if len(p) > len(m):
        starts, ends = starts.take(first, axis=1), ends.take(first, axis=1)
    suspect, named = ends != m.target, m.word >= NOUGHT
    if any_of(m.incremental):
        suspect |= m.incremental & (starts != m.start)
    suspect = suspect & named & ~m.alone
    # In blocks of their own, and put into the motion's where it does not name an axis that
    # moves.
    missing = (ends != starts) & ~named
    if any_of(missing):
        missing &= m.target_known & ~m.alone & (m.code != FOREIGN) & p.corrected[first]
    if len(m.holes):
        missing[m.holes.axis, m.holes.motion] = False
    added = (~b.first).nonzero()[0] if len(p) > len(m) else NO_MOTIONS
    at = suspect.T.ravel().nonzero()[0]  # in the order of the text, nearly
    motion = at // len(suspect)
    _rewrite(b, motion, at - motion * len(suspect))
    for row, letter in enumerate(b.axes) if len(added) or any_of(missing) else ():
        write = first[missing[row]]
        if len(added):
            moves = p.end[row, added] != p.start[row, added]
            write = np.sort(np.concatenate([write, added[moves | _in_plane(b, row, added)]]))
        if len(write):
            _put_in(b, row, letter, write)


def _rewrite(b: Writing, motion: np.ndarray, row: np.ndarray) -> None:
    """Change the numbers of words (K,) that stand in the text."""
    word = cells(b.m.word, row, motion)
    own = b.w.decimals.take(word)
    decimals = np.minimum(np.maximum(cells(b.m.places, row, motion), own), MOST)
    value = b.value(row, b.begin[motion], decimals)
    differs = value != b.stands(word, decimals)
    b.renumber(word, value, decimals, differs)
    b.touched[motion[differs]] = True


def _put_in(b: Writing, row: int, letter: str, write: np.ndarray) -> None:
    """Write words that stand nowhere yet."""
    motion = b.p.motion[write]
    decimals = _enough(b, row, write, b.decimals(row, motion))
    start = np.where(b.first[write], b.at[motion], b.behind(motion))
    prefix = np.zeros((len(write), 6 if b.spelled else 2), np.uint8)
    prefix[:, 0] = np.where(
        b.spaced[motion] & (b.first[write] | _not_leading(b, row, write)), ord(" "), 0
    )
    prefix[:, 1] = _letters(b, row, letter, motion)
    rank = np.where(b.first[write], INSERT_WORD + row, b.rank(write) + 10 + row)
    place = _as_place(b, row, motion)
    if place.any():  # X=AC(5)
        prefix[place, 2:] = np.frombuffer(b"=AC(", np.uint8)
    value = b.value(row, write, decimals)
    if b.klartext:
        prefix[:, 2] = np.where(value >= 0, ord("+"), 0)
    b.splice.numbers(start, start, rank, value, decimals, prefix)
    b.splice.constants(start[place], start[place], rank[place], b")")
    b.touched[motion] = True


def _as_place(b: Writing, row: int, motion: np.ndarray) -> np.ndarray:
    """(K,) bool: new words that say themselves that they are places, though G91 is in force."""
    m = b.m
    if not b.spelled:
        return np.zeros(len(motion), bool)
    place: np.ndarray = m.relative[motion] & (m.word[row, motion] < 0) & ~m.incremental[row, motion]
    return place


def _in_plane(b: Writing, row: int, piece: np.ndarray) -> np.ndarray:
    """(K,) bool: pieces that are arcs in whose plane the axis lies."""
    arcs, arc = b.m.arcs, b.p.arc[piece]
    if not len(arcs):
        return np.zeros(len(piece), bool)
    at = np.maximum(arc, 0)
    plane: np.ndarray = (arc >= 0) & ((arcs.first[at] == row) | (arcs.second[at] == row))
    return plane


def _letters(b: Writing, row: int, letter: str, motion: np.ndarray) -> np.ndarray:
    """(K,) uint8 the letter to write: the block's own (U for X, lower case) where it has
    one."""
    word = b.m.word[row, motion]
    if not len(b.w.start) or b.klartext:  # an increment's letter is the I of IX
        return np.full(len(motion), ord(letter), np.uint8)
    own = b.byte[b.w.start[np.maximum(word, 0)]]
    absolute_letter = np.full(len(motion), ord(letter), np.uint8)
    if letter == "C":  # the second coordinate of polar interpolation
        polar = [s.polar if s is not None else "" for s in b.m.spaces]
        letters = np.array([ord(x or letter) for x in polar], np.uint8)
        absolute_letter = letters[b.m.space[motion]]
    # Blocks with U or W alone stay incremental for their own axis; other axes follow G90 G91.
    return np.where(word >= 0, own, absolute_letter)


def _not_leading(b: Writing, row: int, piece: np.ndarray) -> np.ndarray:
    """(K,) whether another word stands before this axis' in an added block."""
    p = b.p
    leads: np.ndarray = b.names_code[piece].copy()
    for other in range(row):
        leads |= (p.end[other, piece] != p.start[other, piece]) | _in_plane(b, other, piece)
    return leads
