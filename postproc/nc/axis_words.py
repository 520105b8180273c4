"""Axis words and motion codes of the output: a word that need not change keeps its bytes."""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.motions import FOREIGN
from postproc.nc.columns import begins, cells
from postproc.nc.numbers import INSERT_WORD, MOST_DECIMALS, POWERS, counts, steps
from postproc.nc.writing import Writing

INSERT_CODE = 1
NOUGHT, MOST = np.array(0), np.array(MOST_DECIMALS)  # without axes: postproc.units
NO_MOTIONS = np.zeros(0, np.int64)


def motion_codes(b: Writing) -> None:
    """Name the motion code where the output's differs from the program's."""
    p, m = b.p, b.m
    first_code, last_code = p.code, p.code
    if len(p) > len(m):
        first_code, last_code = p.code.take(b.begin), p.code.compress(b.final)
    #   program   G3 X.. Y.. I..         X.. Y.. I..       An arc that is written as chords ends in
    #   output    G1 X.. Y..  X.. Y..    G3 X.. Y.. I..    G1: the block behind it, which names no
    #                                                      code, must say G3 again.
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


def _enough(b: Writing, ticks: np.ndarray, scale: np.ndarray, decimals: np.ndarray) -> np.ndarray:
    """(K,) as many decimals as new words need: more than the least increment's where the
    nominal place has more (200 mm in inches), and the control reads so many digits."""
    most = MOST
    if b.dialect.digits:
        whole = np.searchsorted(POWERS[1:], np.abs(ticks) // scale, side="right") + 1
        most = b.dialect.digits - whole
    for _ in range(MOST_DECIMALS):
        per = steps(scale, decimals)
        wants = (ticks // per * per != ticks) & (decimals < most)
        if not any_of(wants):
            break
        decimals = decimals + wants
    return decimals


def axis_words(b: Writing) -> None:
    """Words of the axes: changed where the end or the start of an increment moved, and put in where
    an axis moves that the block does not name."""
    m, p = b.m, b.p
    first, starts, ends = b.begin, p.start, p.end
    if len(p) > len(m):
        starts, ends = starts.take(first, axis=1), ends.take(first, axis=1)
    # an absolute word follows the end of its motion, a distance the start too
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
    at = suspect.T.ravel().nonzero()[0]  # in the order of the text, nearly
    motion = at // len(suspect)
    _rewrite(b, motion, at - motion * len(suspect))
    if len(p) > len(m):
        missing = _new_words(b, missing)
    if any_of(missing):
        at = missing.T.ravel().nonzero()[0]
        piece = at // len(missing)
        _put_in(b, at - piece * len(missing), piece)


def _new_words(b: Writing, missing: np.ndarray) -> np.ndarray:
    """(A, P) bool: words that stand nowhere yet, of pieces; in blocks of their own all axes that
    move, and those of an arc's plane. missing (A, N): those of first pieces."""
    p, arcs = b.p, b.m.arcs
    new: np.ndarray = p.end != p.start
    curved = (p.arc >= 0).nonzero()[0]
    arc = p.arc[curved]
    new[arcs.first[arc], curved] = new[arcs.second[arc], curved] = True
    new[:, b.begin] = missing
    return new


def _rewrite(b: Writing, motion: np.ndarray, row: np.ndarray) -> None:
    """Change the numbers of words (K,) that stand in the text."""
    word = cells(b.m.word, row, motion)
    own = b.w.decimals.take(word)
    decimals = np.minimum(np.maximum(cells(b.m.places, row, motion), own), MOST)
    value = b.value(row, b.begin[motion], decimals)
    differs = value != b.stands(word, decimals)
    b.renumber(word, value, decimals, differs)
    b.touched[motion[differs]] = True


def _put_in(b: Writing, row: np.ndarray, piece: np.ndarray) -> None:
    """Write words (K,) that stand nowhere yet; those of a piece stand side by side."""
    motion, first = b.p.motion[piece], b.first[piece]
    ticks, scale = b.ticks(row, piece), cells(b.m.scale, row, motion)
    decimals = _enough(b, ticks, scale, b.decimals(row, motion))
    value = counts(ticks, scale, decimals)
    start = np.where(first, b.at[motion], b.behind(motion))
    rank = np.where(first, INSERT_WORD, b.rank(piece) + 10) + row
    prefix = np.zeros((len(piece), 6 if b.spelled else 2), np.uint8)
    not_leading = b.names_code[piece] | ~begins(piece) | first
    prefix[:, 0] = np.where(b.spaced[motion] & not_leading, ord(" "), 0)
    prefix[:, 1] = _letters(b, row, motion)
    if b.klartext:
        prefix[:, 2] = np.where(value >= 0, ord("+"), 0)
    place = _as_place(b, row, motion) if b.spelled else NO_MOTIONS
    if any_of(place):  # X=AC(5)
        prefix[place, 2:] = np.frombuffer(b"=AC(", np.uint8)
    b.splice.numbers(start, start, rank, value, decimals, prefix)
    if any_of(place):
        b.splice.constants(start[place], start[place], rank[place], b")")
    b.touched[motion] = True


def _as_place(b: Writing, row: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """(K,) bool: new words that say themselves that they are places, though G91 is in force."""
    m = b.m
    place: np.ndarray = m.relative[motion]
    if any_of(place):
        place &= (cells(m.word, row, motion) < 0) & ~cells(m.incremental, row, motion)
    return place


def _letters(b: Writing, row: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """(K,) uint8 the letters to write: the block's own (U for X, lower case) where it has one."""
    letters: np.ndarray = np.array([*map(ord, b.axes)], np.uint8)[row]
    if not len(b.w.start) or b.klartext:  # an increment's letter is the I of IX
        return letters
    # the second coordinate of polar interpolation
    polar = [s.polar if s is not None else "" for s in b.m.spaces]
    if any(polar):
        others = np.array([ord(x or "C") for x in polar], np.uint8)[b.m.space[motion]]
        letters = np.where(letters == ord("C"), others, letters)
    word = cells(b.m.word, row, motion)
    # Blocks with U or W alone stay incremental for their own axis; other axes follow G90 G91.
    letters = np.where(word >= 0, b.byte.take(b.w.start.take(np.maximum(word, 0))), letters)
    return letters
