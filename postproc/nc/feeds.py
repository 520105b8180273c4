"""F in a block in which only rotary axes, or second slides (U V W), were to move, and corrections
now move X Y Z too.

LinuxCNC takes F along X Y Z where any of them moves, else along U V W, else as degrees a minute,
and gives the other axes the time that they need (emccanon.cc, getStraightVelocity; NIST IR 6556,
2.1.2.5). With 9 um of correction in X a turn of 90 degrees at F360 would be one of 9 um at 360
mm/min: as fast as the rotary axis can. So each piece gets the F with which it takes the time that
it had, and the next motion the program's F again. Under G93 every piece of a block that was cut
takes its part of the time.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from postproc.errors import BlockFault
from postproc.flags import any_of
from postproc.motions import FEED, RAPID, THREAD
from postproc.nc.lexer import Words
from postproc.nc.writing import Writing
from postproc.units import TICKS_PER_INCH, TICKS_PER_MM

GROUPS = ("XYZ", "UVW", "ABC")  # the first of them that moves is the one whose way F is along
SAME = 0.01  # of a feed: less is what every correction does to the length of a block


def kept_feeds(b: Writing) -> float:
    """Write F where a block's pieces would else be run in another time. Returns the F that the
    output has in force where the program has another one, else nan. Raises BlockFault where a
    correction would change an unknown time."""
    m, p = b.m, b.p
    rows = _rows(tuple(b.axes))
    stands = b.state.feed
    special = _special(b, rows)
    if not any_of(special) and stands != stands:
        return stands
    # `stands`: the F that the output has in force beside the program's, nan while it is the
    # program's own (nan is what differs from itself).
    ratio = _ratios(b, rows, special)
    first = b.first.nonzero()[0]
    takes = (m.code != RAPID) & (m.code != THREAD) & ~m.inverse & (m.feed > 0)
    anew, anew_behind = _stated(b)
    for i in map(int, (takes | anew).nonzero()[0]):
        stop = int(first[i + 1]) if i + 1 < len(first) else len(p)
        if anew[i]:
            stands = np.nan
        for k in range(int(first[i]), stop if takes[i] else 0):
            wanted = m.feed[i] * ratio[k]
            written = m.feed[i] if stands != stands else stands
            # a take-up in rapid takes no F
            if p.code[k] == RAPID or abs(wanted - written) <= SAME * wanted:
                continue
            b.feed(k, np.format_float_positional(wanted, 7, fractional=False, trim="-").encode())
            b.touched[i] = True
            stands = wanted if ratio[k] != 1.0 else np.nan
    return float("nan" if anew_behind else stands)


@cache
def _rows(axes: tuple[str, ...]) -> list[list[int]]:
    """Rows of each group of axes."""
    return [[i for i, x in enumerate(axes) if x in group] for group in GROUPS]


def states_feed(words: Words) -> bool:
    """Whether an F stands anywhere in these blocks."""
    return bool((words.letter == ord("F")).any())


def _stated(b: Writing) -> tuple[np.ndarray, bool]:
    """(N,) bool: an F stands in the motion's block, or in one since the motion before; and whether
    one stands behind the last."""
    blocks = b.w.block[b.w.letter == ord("F")]
    count = np.searchsorted(blocks, b.m.block, side="right")
    return np.diff(count, prepend=0) > 0, len(blocks) > count[-1]


def _special(b: Writing, rows: list[list[int]]) -> np.ndarray:
    """(N,) bool: corrected feeds in which axes beside X Y Z move."""
    m = b.m
    beside = rows[1] + rows[2]
    if not beside:
        return np.zeros(len(m), bool)
    feeds = (m.code == FEED) & ~m.inverse & b.p.corrected[b.first]
    known = m.start_known & m.target_known
    turned = ((m.word >= 0) & ~known)[beside] & feeds
    if turned.any():
        _same_time(b, rows[0], beside, turned)
    moves = ((m.target != m.start) & known)[beside].any(axis=0)
    special: np.ndarray = moves & feeds & known[rows[0]].all(axis=0)
    return special


def _same_time(b: Writing, linear: list[int], beside: list[int], turned: np.ndarray) -> None:
    """Raises BlockFault where X Y Z move by their correction alone, beside an axis of which it is
    not known how far it moves: the time of that block is not known."""
    m, p = b.m, b.p
    # X Y Z that the program moves itself take F anyway, and what turns beside them follows
    led = (m.target != m.start)[linear].any(axis=0)
    shifted = np.zeros(len(m), bool)
    np.logical_or.at(shifted, p.motion, (p.end != p.start)[linear].any(axis=0))
    for i in (turned.any(axis=0) & ~led & shifted).nonzero()[0][:1]:
        axis = b.axes[beside[int(np.argmax(turned[:, i]))]]
        raise BlockFault(
            int(m.block[i]),
            f"where {axis} stands before this feed is not known, and so not the time that it takes:"
            " F would be along the corrections of X Y Z",
            f"move {axis} to an absolute position before, or say where it is: --start {axis}0",
        )


def _ratios(b: Writing, rows: list[list[int]], special: np.ndarray) -> np.ndarray:
    """(P,) by how much F must be larger in each piece, 1 where it stays. Raises BlockFault where F
    is not known as a number."""
    m, p = b.m, b.p
    result = np.ones(len(p))
    which = (special[p.motion] & (p.share > 0)).nonzero()[0]
    motion = p.motion[which]
    known = (m.start_known & m.target_known)[:, motion]
    nominal, kind = _along(b, rows, (m.target - m.start)[:, motion] * known, motion)
    written, now = _along(b, rows, (p.end - p.start)[:, which] * known, motion)
    # F is along what the control counts: the block takes nominal * share / F, and shall take that
    # along the corrected way too.
    ratio = np.divide(
        written,
        nominal * p.share[which],
        out=np.ones(len(which)),
        where=(nominal > 0) & (written > 0),
    )
    other = (kind != now) | (np.abs(ratio - 1.0) > SAME)
    for k in (other & ~(m.feed[motion] > 0)).nonzero()[0][:1]:
        raise BlockFault(
            int(m.block[motion[k]]),
            "a feed of rotary axes whose F is not known as a number: corrections of X Y Z would"
            " change its speed",
            "write F as a number",
        )
    result[which[other]] = ratio[other]
    return result


def _along(
    b: Writing, rows: list[list[int]], way: np.ndarray, motion: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(K,) the length of `way` (A, K), ticks, that F is along, in mm, inches or degrees, and (K,)
    which of GROUPS that is."""
    linear = rows[0] + rows[1]
    inch = (b.m.scale[linear][:, motion] % TICKS_PER_INCH == 0).any(axis=0)
    # a degree has as many ticks as a mm, whatever the units are
    unit = np.stack(
        [np.where(inch, TICKS_PER_INCH, TICKS_PER_MM)] * 2 + [np.full(len(motion), TICKS_PER_MM)]
    )
    ways = np.stack([np.sqrt(((way[group] / TICKS_PER_MM) ** 2).sum(axis=0)) for group in rows])
    kind = np.argmax(ways > 0, axis=0)
    own = (kind, np.arange(len(motion)))
    return ways[own] * (TICKS_PER_MM / unit[own]), kind


def inverse_time(b: Writing) -> None:
    """G93: every piece takes its part of the time. A take-up goes as fast as the motion it
    precedes."""
    m, p = b.m, b.p
    for i in map(int, (m.inverse[p.motion] & b.several & (p.code != RAPID)).nonzero()[0]):
        motion = p.motion[i]
        share = p.share[i] or _take_up_share(b, i)
        text = _seven_digits(m.feed[motion] / share)
        b.feed(i, text)


def _take_up_share(b: Writing, i: int) -> float:
    """Length of a take-up over the length of its motion."""
    p = b.p
    own = np.linalg.norm((p.end[:, i] - p.start[:, i]).astype(float))
    same = (p.motion == p.motion[i]).nonzero()[0]
    whole = sum(
        np.linalg.norm((p.end[:, j] - p.start[:, j]).astype(float))
        for j in same
        if not p.take_up[j]
    )
    return float(own / whole) if whole else 1.0


def _seven_digits(value: float) -> bytes:
    """A feed with seven digits, no exponent."""
    return f"{value:.{max(0, 6 - len(str(int(abs(value)))) + 1)}f}".encode()
