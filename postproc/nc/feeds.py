"""F in a block in which only rotary axes, or second slides (U V W), were to move, and corrections now move X Y Z too.

LinuxCNC takes F along X Y Z where any of them moves, else along U V W, else as degrees a minute, and gives the other axes the
time that they need (emccanon.cc, getStraightVelocity; NIST IR 6556, 2.1.2.5). With 9 um of correction in X a turn of 90 degrees at F360
would be one of 9 um at 360 mm/min: as fast as the rotary axis can. So each piece gets the F with which it takes
the time that it had, and the next motion the program's F again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from postproc.errors import BlockFault
from postproc.motions import FEED, RAPID, THREAD
from postproc.nc.numbers import INSERT_WORD
from postproc.units import TICKS_PER_INCH, TICKS_PER_MM

if TYPE_CHECKING:
    from postproc.nc.emitter import Batch

GROUPS = ("XYZ", "UVW", "ABC")  # the first of them that moves is the one whose way F is along
SAME = 0.01  # of a feed: less is what every correction does to the length of a block


def kept_feeds(b: Batch) -> float:
    """Write F where a block's pieces would else be run in another time. Returns the F that the output has in force where
    the program has another one, else nan."""
    m, p = b.m, b.p
    rows = [[i for i, x in enumerate(b.axes) if x in group] for group in GROUPS]
    stands = b.state.feed
    special = _special(b, rows)
    if not special.any() and stands != stands:
        return stands
    ratio = _ratios(b, rows, special)
    first = b.first.nonzero()[0]
    takes = (m.code != RAPID) & (m.code != THREAD) & ~m.inverse & (m.feed > 0)
    for i in map(int, takes.nonzero()[0]):
        stop = int(first[i + 1]) if i + 1 < len(first) else len(p)
        if m.feed_word[i] >= 0:
            stands = np.nan
        for k in range(int(first[i]), stop):
            wanted = m.feed[i] * ratio[k]
            written = m.feed[i] if stands != stands else stands
            if p.code[k] == RAPID or abs(wanted - written) <= SAME * wanted:
                continue
            _write(b, i, k, wanted)
            stands = wanted if ratio[k] != 1.0 else np.nan
    return float(stands)


def _special(b: Batch, rows: list[list[int]]) -> np.ndarray:
    """(N,) bool: feeds in which axes beside X Y Z move, and whose pieces are not as long as they were by more than `SAME`."""
    m = b.m
    if not (rows[1] or rows[2]):
        return np.zeros(len(m), bool)
    moves = (m.target != m.start)[rows[1] + rows[2]].any(axis=0) & (
        m.start_known & m.target_known
    ).all(axis=0)
    return moves & (m.code == FEED) & ~m.inverse & b.p.corrected[b.first]


def _ratios(b: Batch, rows: list[list[int]], special: np.ndarray) -> np.ndarray:
    """(P,) by how much F must be larger in each piece, 1 where it stays. Raises BlockFault where F is not known as a number."""
    m, p = b.m, b.p
    result = np.ones(len(p))
    which = (special[p.motion] & (p.share > 0)).nonzero()[0]
    motion = p.motion[which]
    nominal, kind = _along(b, rows, m.start[:, motion], m.target[:, motion], motion)
    written, now = _along(b, rows, p.start[:, which], p.end[:, which], motion)
    ratio = np.divide(
        written,
        nominal * p.share[which],
        out=np.ones(len(which)),
        where=(nominal > 0) & (written > 0),
    )
    other = (kind != now) | (np.abs(ratio - 1.0) > SAME)
    for k in (other & ~(m.feed[motion] > 0)).nonzero()[0][:1]:
        raise BlockFault(
            int(motion[k]), "a feed of rotary axes whose F is not known as a number: corrections of X Y Z would change its speed",
            "write F as a number",
        )  # fmt: skip
    result[which[other]] = ratio[other]
    return result


def _along(b: Batch, rows: list[list[int]], start: np.ndarray, end: np.ndarray, motion: np.ndarray):
    """(K,) the way that F is along, in mm, inches or degrees, and (K,) which of GROUPS that is."""
    linear = rows[0] + rows[1]
    inch = (b.m.scale[linear][:, motion] % TICKS_PER_INCH == 0).any(axis=0)
    unit = np.stack(
        [np.where(inch, TICKS_PER_INCH, TICKS_PER_MM)] * 2 + [np.full(len(motion), TICKS_PER_MM)]
    )
    ways = np.stack(
        [np.sqrt((((end - start)[group] / TICKS_PER_MM) ** 2).sum(axis=0)) for group in rows]
    )
    kind = np.argmax(ways > 0, axis=0)
    own = (kind, np.arange(len(motion)))
    return ways[own] * (TICKS_PER_MM / unit[own]), kind


def _write(b: Batch, i: int, k: int, value: float) -> None:
    """F into piece k of motion i."""
    word, number = (
        b.m.feed_word[i],
        np.format_float_positional(value, 7, fractional=False, trim="-").encode(),
    )
    if b.first[k] and word >= 0:
        b.splice.texts([b.w.number[word]], [b.w.stop[word]], [0], [number])
    else:
        at, rank = (
            (b.at[i], INSERT_WORD + 50)
            if b.first[k]
            else (b.behind()[i], b.rank(np.array([k]))[0] + 50)
        )
        b.splice.texts([at], [at], [rank], [(b" F" if b.spaced[i] else b"F") + number])
    b.touched[i] = True
