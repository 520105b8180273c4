"""I J K and R of the arcs that are written: kept as they are where they hold, anew where the arc is
cut, none in a chord."""

from __future__ import annotations

import numpy as np

from postproc.motions import CLOCKWISE, COUNTER
from postproc.nc.columns import one_of
from postproc.nc.face import ON_FACE, PLANES
from postproc.nc.numbers import INSERT_WORD, MOST_DECIMALS, counts
from postproc.nc.writing import Writing
from postproc.units import TICKS_PER_MM


def centre_words(b: Writing) -> None:
    """I J K or R of kept arcs; R becomes a centre where no R will do; none in what became a
    chord."""
    m, p = b.m, b.p
    if not len(m.arcs):
        return
    first_piece = b.first.nonzero()[0]
    mine = ((m.code == CLOCKWISE) | (m.code == COUNTER)).nonzero()[0]
    mine = mine[p.corrected[first_piece[mine]]]
    arc_of = np.full(len(m), -1)
    arc_of[m.arcs.motion] = np.arange(len(m.arcs))
    piece, arc = first_piece[mine], arc_of[mine]
    later = (~b.first & (p.arc >= 0)).nonzero()[0]
    _turns(b, mine[b.several[piece]])
    if b.dialect.skips_centre:
        _outside_plane(b, mine[p.arc[piece] < 0])
    _radii(b, mine, piece, arc, later)
    later = later[p.radius[later] == 0]
    for k in range(2):
        _centres(b, mine, piece, arc, k)
        _further_centres(b, later, k)


def _radii(
    b: Writing, mine: np.ndarray, piece: np.ndarray, arc: np.ndarray, later: np.ndarray
) -> None:
    """R words: their numbers in the blocks that have them, none where a piece needs a centre, new
    ones behind."""
    word = b.m.arcs.words[2, arc]
    gone = (word >= 0) & (b.p.radius[piece] == 0)
    b.delete(word[gone], mine[gone])
    kept = (b.p.radius[piece] != 0).nonzero()[0]
    number, decimals = _radius_number(b, piece[kept], arc[kept])
    differs = number != b.stands(word[kept], decimals)
    b.renumber(word[kept], number, decimals, differs)
    b.touched[mine[kept[differs]]] = True
    later = later[b.p.radius[later] != 0]
    number, decimals = _radius_number(b, later, b.p.arc[later])
    motion = b.p.motion[later]
    at = b.behind(motion)
    b.splice.numbers(
        at, at, b.rank(later) + 30, number, decimals, _spelling(b, motion, b.p.arc[later])
    )


def _radius_number(b: Writing, piece: np.ndarray, arc: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) whole numbers and decimals of the R words of pieces; the programmed number keeps its own
    decimals."""
    word, radius = b.m.arcs.words[2, arc], b.p.radius[piece]
    least = np.minimum(*(_centre_decimals(b, arc, k, np.full(len(arc), -1)) for k in range(2)))
    own = np.minimum(b.w.decimals[word], MOST_DECIMALS)
    same = np.abs(radius) == np.abs(b.m.arcs.by_radius[arc])
    decimals = np.where(same, own, np.maximum(least, own))
    return counts(radius, np.full(len(arc), 1), decimals, _unit(b, arc, 0)), decimals


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


def _centres(b: Writing, mine: np.ndarray, piece: np.ndarray, arc: np.ndarray, k: int) -> None:
    """The words for k = 0 or 1, the plane's first or second centre word, in the motions' own
    blocks."""
    m, p, w = b.m, b.p, b.w
    is_arc, by_radius = p.arc[piece] >= 0, m.arcs.words[2, arc] >= 0
    word = m.arcs.words[k, arc]
    gone = (word >= 0) & ~is_arc
    b.delete(word[gone], mine[gone])
    value = _centre(b, piece, arc, k)
    wanted = np.where(m.arcs.absolute[k, arc], value, p.centre[k, piece])
    decimals = _centre_decimals(b, arc, k, word)
    number = counts(wanted, np.full(len(arc), 1), decimals, _unit(b, arc, k))
    own = np.minimum(np.where(word >= 0, w.decimals[np.maximum(word, 0)], 0), MOST_DECIMALS)
    stands = np.where(
        word >= 0, w.mantissa[np.maximum(word, 0)] * 10 ** np.maximum(decimals - own, 0), 0
    )
    replace = (is_arc & (word >= 0) & (number != stands) & ~by_radius).nonzero()[0]
    b.splice.numbers(
        w.number[word[replace]], w.stop[word[replace]], np.zeros(len(replace)), number[replace],
        decimals[replace],
    )  # fmt: skip
    new = np.where(by_radius, p.radius[piece] == 0, number != stands)
    add = (is_arc & (word < 0) & new).nonzero()[0]
    at, rank = b.at[mine[add]], np.full(len(add), INSERT_WORD + 20 + k)
    _insert_centre(b, mine[add], arc[add], k, number[add], decimals[add], at, rank)
    b.touched[mine[replace]] = b.touched[mine[add]] = True


def _further_centres(b: Writing, later: np.ndarray, k: int) -> None:
    """The same in blocks put in behind."""
    m, p, arc = b.m, b.p, b.p.arc[later]
    decimals = _centre_decimals(b, arc, k, np.full(len(later), -1))
    # I=AC() is a word's own affair: blocks put in follow the mode in force, and controls that have
    # it are incremental.
    absolute = m.arcs.absolute[k, arc] & ~b.by_letter(m.arcs.words[k, arc])
    wanted = np.where(absolute, _centre(b, later, arc, k), p.centre[k, later])
    number = counts(wanted, np.full(len(later), 1), decimals, _unit(b, arc, k))
    motion = p.motion[later]
    _insert_centre(b, motion, arc, k, number, decimals, b.behind(motion), b.rank(later) + 30 + k)


def _centre(b: Writing, piece: np.ndarray, arc: np.ndarray, k: int) -> np.ndarray:
    """(K,) ticks of an absolute centre word."""
    axis = (b.m.arcs.first, b.m.arcs.second)[k][arc]
    centre: np.ndarray = b.p.start[axis, piece] + b.p.centre[k, piece] - b.m.arcs.origin[k, arc]
    return centre


def _unit(b: Writing, arc: np.ndarray, k: int) -> np.ndarray:
    """(K,) ticks of one unit of a centre word (a radius, so never halved)."""
    axis = (b.m.arcs.first, b.m.arcs.second)[k][arc]
    scale = b.m.scale[axis, b.m.arcs.motion[arc]]
    unit: np.ndarray = np.where(
        scale < TICKS_PER_MM,
        scale * 2,
        np.where((scale > TICKS_PER_MM) & (scale < 20 * TICKS_PER_MM), scale * 2, scale),
    )
    return unit


def _centre_decimals(b: Writing, arc: np.ndarray, k: int, word: np.ndarray) -> np.ndarray:
    least = np.rint(np.log10(_unit(b, arc, k) / b.m.arcs.grid[k, arc])).astype(np.int64)
    own = np.where(word >= 0, b.w.decimals[np.maximum(word, 0)], 0)
    centre_decimals: np.ndarray = np.minimum(np.maximum(least, own), MOST_DECIMALS)
    return centre_decimals


def _insert_centre(
    b: Writing,
    motion: np.ndarray,
    arc: np.ndarray,
    k: int,
    number: np.ndarray,
    decimals: np.ndarray,
    at: np.ndarray,
    rank: np.ndarray,
) -> None:
    """Put the words for k = 0 or 1, the plane's first or second centre word, in at the places
    `at`."""
    letters = {
        (b.axes.index(first), b.axes.index(second)): words
        for first, second, *words in (*PLANES.values(), ON_FACE)
        if first in b.axes and second in b.axes
    }
    of_plane = np.zeros((len(b.axes), len(b.axes)), np.uint8)
    for plane, words in letters.items():
        of_plane[plane] = ord(words[k])
    letter = of_plane[b.m.arcs.first[arc], b.m.arcs.second[arc]]
    prefix = np.zeros((len(motion), 2), np.uint8)
    prefix[:, 0] = np.where(b.spaced[motion], ord(" "), 0)
    prefix[:, 1] = letter
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
    if b.dialect.turns:
        place = ((b.w.letter == ord("P")) & np.isin(b.w.block, b.m.block[motion])).nonzero()[0]
        owner = np.searchsorted(b.m.block, b.w.block[place])
        b.delete(place, owner)
