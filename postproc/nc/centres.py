"""I J K and R of the arcs that are written: kept as they are where they hold, anew where the arc is
cut, none in a chord."""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.motions import CLOCKWISE, COUNTER
from postproc.nc.columns import cells, one_of
from postproc.nc.face import ON_FACE, PLANES
from postproc.nc.numbers import INSERT_WORD, MOST_DECIMALS, POWERS, counts
from postproc.nc.writing import Writing
from postproc.records import columns
from postproc.units import TICKS_PER_MM


@columns
class Spelling:
    """How the n arcs of a batch write centres: unit, decimals, letter (2, n): ticks of one unit (a
    radius, so never halved), decimals of a least increment, and uint8 the letter."""

    unit: np.ndarray
    decimals: np.ndarray
    letter: np.ndarray


def _spelled(b: Writing) -> Spelling:
    m, arcs = b.m, b.m.arcs
    axis = np.array([arcs.first, arcs.second])
    scale = cells(m.scale, axis, arcs.motion)
    # Ticks of one unit of a word: 1 mm, or 25.4 mm of an inch, and half of that where the word is a
    # diameter. Half an inch is above one mm, so that the range tells which of the four it is.
    halved = (scale > TICKS_PER_MM) & (scale < 20 * TICKS_PER_MM)
    unit = np.where((scale < TICKS_PER_MM) | halved, scale * 2, scale)
    least = np.rint(np.log10(unit / arcs.grid)).astype(np.int64)
    letter = np.zeros((2, len(b.axes), len(b.axes)), np.uint8)
    for first, second, *words in (*PLANES.values(), ON_FACE):
        if first in b.axes and second in b.axes:
            letter[:, b.axes.index(first), b.axes.index(second)] = [*map(ord, words)]
    letter = letter.reshape(2, -1).take(axis[0] * len(b.axes) + axis[1], axis=1)
    return Spelling(unit, np.clip(least, 0, MOST_DECIMALS), letter)


def centre_words(b: Writing) -> None:
    """I J K or R of kept arcs; R becomes a centre where no R will do; none in what became a
    chord."""
    m, p = b.m, b.p
    if not len(m.arcs):
        return
    of = _spelled(b)
    mine = ((m.code == CLOCKWISE) | (m.code == COUNTER)).nonzero()[0]
    piece = b.begin[mine]
    corrected = p.corrected[piece]
    mine, piece = mine[corrected], piece[corrected]
    arc_of = np.full(len(m), -1)
    arc_of[m.arcs.motion] = np.arange(len(m.arcs))
    arc = arc_of[mine]
    later = (~b.first & (p.arc >= 0)).nonzero()[0]
    _turns(b, mine[b.several[piece]])
    if b.dialect.skips_centre:
        _outside_plane(b, mine[p.arc[piece] < 0])
    if any_of(m.arcs.words[2] >= 0):
        _radii(b, mine, piece, arc, later, of)
        later = later[p.radius[later] == 0]
    _centres(b, mine, piece, arc, of)
    if len(later):
        _further_centres(b, later, of)


def _radii(
    b: Writing,
    mine: np.ndarray,
    piece: np.ndarray,
    arc: np.ndarray,
    later: np.ndarray,
    of: Spelling,
) -> None:
    """R words: their numbers in the blocks that have them, none where a piece needs a centre, new
    ones behind."""
    word = b.m.arcs.words[2, arc]
    # R stays only where the circle that the control makes of it is proven (docs/DESIGN.md,
    # "Blocks")
    gone = (word >= 0) & (b.p.radius[piece] == 0)
    b.delete(word[gone], mine[gone])
    kept = (b.p.radius[piece] != 0).nonzero()[0]
    number, decimals = _radius_number(b, piece[kept], arc[kept], of)
    differs = number != b.stands(word[kept], decimals)
    b.renumber(word[kept], number, decimals, differs)
    b.touched[mine[kept[differs]]] = True
    later = later[b.p.radius[later] != 0]
    number, decimals = _radius_number(b, later, b.p.arc[later], of)
    motion = b.p.motion[later]
    at = b.behind(motion)
    b.splice.numbers(
        at, at, b.rank(later) + 30, number, decimals, _spelling(b, motion, b.p.arc[later])
    )


def _radius_number(
    b: Writing, piece: np.ndarray, arc: np.ndarray, of: Spelling
) -> tuple[np.ndarray, np.ndarray]:
    """(K,) whole numbers and decimals of the R words of pieces; the programmed number keeps its own
    decimals."""
    word, radius = b.m.arcs.words[2, arc], b.p.radius[piece]
    own = np.minimum(b.w.decimals[word], MOST_DECIMALS)
    same = np.abs(radius) == np.abs(b.m.arcs.by_radius[arc])
    decimals = np.where(same, own, np.maximum(of.decimals.min(axis=0)[arc], own))
    return counts(radius, of.unit[0, arc], decimals), decimals


def _spelling(b: Writing, motion: np.ndarray, arc: np.ndarray) -> np.ndarray:
    """(K, L) uint8: what stands before the number of an R word, as the motion's own block has it: "
    R", " CR="."""
    word = b.m.arcs.words[2, arc]
    texts = [b.w.text[i:j].strip() for i, j in zip(b.w.start[word], b.w.number[word], strict=True)]
    prefix = np.zeros((len(texts), 1 + max(map(len, texts), default=0)), np.uint8)
    prefix[:, 0] = np.where(b.spaced[motion], ord(" "), 0)
    for k, text in enumerate(texts):
        prefix[k, 1 : 1 + len(text)] = np.frombuffer(text, np.uint8)
    return prefix


def _centres(
    b: Writing, mine: np.ndarray, piece: np.ndarray, arc: np.ndarray, of: Spelling
) -> None:
    """Both centre words of a plane, side by side (K,), in the motions' own blocks."""
    m, p, w = b.m, b.p, b.w
    mine, piece, arc, k = _twice(mine, piece, arc)
    is_arc, by_radius = p.arc[piece] >= 0, m.arcs.words[2, arc] >= 0
    word = cells(m.arcs.words, k, arc)
    stated = word >= 0
    gone = stated & ~is_arc
    if any_of(gone):
        b.delete(word[gone], mine[gone])
    #   start o--- I --->      I J are distances from the start: where that is corrected they
    #          `.    |         change, though the centre stays. Numbers that are the same keep
    #            `.  J         their bytes, and a word that is not written stays so where it
    #              `o centre   would be 0.
    wanted = _centre(b, piece, arc, k, cells(m.arcs.absolute, k, arc))
    read = np.maximum(word, 0)
    own = np.minimum(np.where(stated, w.decimals[read], 0), MOST_DECIMALS)
    decimals = np.maximum(cells(of.decimals, k, arc), own)
    number = counts(wanted, cells(of.unit, k, arc), decimals)
    stands = np.where(stated, w.mantissa[read] * POWERS[decimals - own], 0)
    differs = number != stands
    replace = (is_arc & stated & differs & ~by_radius).nonzero()[0]
    own = word[replace]
    b.splice.numbers(
        w.number[own], w.stop[own], np.zeros(len(own)), number[replace], decimals[replace]
    )
    new = np.where(by_radius, p.radius[piece] == 0, differs)
    add = (is_arc & ~stated & new).nonzero()[0]
    if len(add):
        at, rank = b.at[mine[add]], INSERT_WORD + 20 + k[add]
        _insert(b, mine[add], arc[add], k[add], number[add], decimals[add], at, rank, of)
    b.touched[mine[replace]] = b.touched[mine[add]] = True


def _twice(*columns_: np.ndarray) -> list[np.ndarray]:
    """Columns (K,) with every place twice, and (2 K,) 0, 1, 0, 1, ...: for both centre words."""
    pairs = [column.repeat(2) for column in columns_]
    k = np.zeros(len(pairs[0]), np.int64)
    k[1::2] = 1
    return [*pairs, k]


def _further_centres(b: Writing, later: np.ndarray, of: Spelling) -> None:
    """The same in blocks put in behind."""
    m, p = b.m, b.p
    later, motion, arc, k = _twice(later, p.motion[later], p.arc[later])
    decimals = cells(of.decimals, k, arc)
    absolute = cells(m.arcs.absolute, k, arc)
    if any_of(absolute):
        # I=AC() is a word's own affair: blocks put in follow the mode in force, and controls that
        # have it are incremental.
        absolute &= ~b.by_letter(cells(m.arcs.words, k, arc))
    number = counts(_centre(b, later, arc, k, absolute), cells(of.unit, k, arc), decimals)
    _insert(b, motion, arc, k, number, decimals, b.behind(motion), b.rank(later) + 30 + k, of)


def _centre(
    b: Writing, piece: np.ndarray, arc: np.ndarray, k: np.ndarray, absolute: np.ndarray
) -> np.ndarray:
    """(K,) ticks of a centre word, absolute or from where the piece begins."""
    m, p = b.m, b.p
    way = cells(p.centre, k, piece)
    if not any_of(absolute):
        return way
    axis = np.where(k, m.arcs.second[arc], m.arcs.first[arc])
    zero = np.where(absolute, cells(p.start, axis, piece) - cells(m.arcs.origin, k, arc), 0)
    return way + zero


def _insert(
    b: Writing,
    motion: np.ndarray,
    arc: np.ndarray,
    k: np.ndarray,
    number: np.ndarray,
    decimals: np.ndarray,
    at: np.ndarray,
    rank: np.ndarray,
    of: Spelling,
) -> None:
    """Put words for k = 0 or 1, the plane's first or second centre word, in at the places `at`."""
    prefix = np.zeros((len(motion), 2), np.uint8)
    prefix[:, 0] = np.where(b.spaced[motion], ord(" "), 0)
    prefix[:, 1] = cells(of.letter, k, arc)
    b.splice.numbers(at, at, rank, number, decimals, prefix)


def _outside_plane(b: Writing, motion: np.ndarray) -> None:
    """Centre words outside of the plane, in what became a chord: no control takes them there."""
    beside = one_of(b.w.letter, map(ord, "IJK")) & np.isin(b.w.block, b.m.block[motion])
    own = b.m.arcs.words
    beside[own[own >= 0]] = False
    place = beside.nonzero()[0]
    b.delete(place, np.searchsorted(b.m.block, b.w.block[place]))


def _turns(b: Writing, motion: np.ndarray) -> None:
    """P of an arc that was cut."""
    place = (b.w.letter == ord("P")).nonzero()[0]
    if len(place):
        place = place[np.isin(b.w.block[place], b.m.block[motion])]
        owner = np.searchsorted(b.m.block, b.w.block[place])
        b.delete(place, owner)
