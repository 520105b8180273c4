"""Which side of its lost motion each slide bears on, from the motion that the slide is to make.

A slide is driven through a nut with play B: commanded c, it stands at the nearest point of c - B/2
.. c + B/2 to where it stood. So a slide that is to stand at w needs c = w + B/2 when it last moved
in +, c = w - B/2 when it last moved in -, and the step from one to the other (the take-up) where it
turns back:

    moving in +   [w---------c----------]  -->         <--  [----------c---------w]   moving in -
                  c - B/2         c + B/2                   c - B/2         c + B/2

That holds for an axis that the program moves and for one that only its corrections move. The wanted
positions of an axis that rests wander to and fro; a slide keeps its side until it has to turn back
by more than the hysteresis H.

Both are one operator, the play (backlash) operator of Krasnosel'skii and Pokrovskii: a state r that
is carried along inside w - H/2 .. w + H/2. The side is the direction in which r moved last, and r +
side * H/2 is where the slide is to be held: w itself while it goes on, the place where it turned
while it is inside the hysteresis. Each step is a clamp, and a clamp behind a clamp is a clamp, so
that a batch is one scan. Where an effect builds up over some travel (pre-travel, --reversal ramp),
the share that is taken up, -1 to +1, is another such operator of the way travelled.
"""

from __future__ import annotations

import numpy as np

from postproc.flags import all_of, any_of
from postproc.records import columns

FEW = 32  # strokes that are looked at one by one
FAR = np.int64(2**62)  # ticks: a clamp that far apart holds nothing


@columns
class Sides:
    """What of the lost motion one batch hands to the next. side (A,): -1, 0 (unknown), +1;
    middle (A,): ticks, the state r; taken (A,): ticks of the ramp that have been travelled, from
    -reach to +reach; located (A,): whether the axis has stood at a known place."""

    side: np.ndarray
    middle: np.ndarray
    taken: np.ndarray
    located: np.ndarray


def initial(axes: int) -> Sides:
    """Before the first motion."""
    zero = np.zeros(axes, np.int64)
    return Sides(zero, zero, zero, zero.astype(bool))


def scan(low: np.ndarray, high: np.ndarray, carry: np.ndarray) -> np.ndarray:
    """(A, S) a state (A,) clamped into low .. high (A, S), ticks, one after the other.

    Composed in pairs, pairs of pairs and so on (Hillis and Steele 1986), until each leaves one
    place alone; whole numbers, so any cut gives the same.
    """
    low, high = low.copy(), high.copy()
    for least, most in zip(low, high, strict=True):
        width = 1
        while width < len(least):
            # Clamp k now stands for itself and width - 1 before it. Where both bounds meet it
            # leaves one place, whatever came before, and is done.
            open_ = (least[width:] < most[width:]).nonzero()[0]
            if not len(open_):
                break
            at: slice | np.ndarray = slice(width, None)
            before: slice | np.ndarray = slice(-width)
            if 2 * len(open_) < len(least):  # the others stay
                at, before = open_ + width, open_
            low_there, high_there = least[at], most[at]
            pair = [
                np.minimum(np.maximum(end[before], low_there), high_there) for end in (least, most)
            ]
            least[at], most[at] = pair
            width *= 2
    scan: np.ndarray = np.minimum(np.maximum(carry[:, None], low), high)
    return scan


def bear(
    place: np.ndarray,
    band: np.ndarray,
    sense: np.ndarray,
    given: np.ndarray,
    stays: np.ndarray,
    carry: Sides,
) -> tuple[np.ndarray, np.ndarray]:
    """(A, S) side and (A, S) state r behind each stroke.

    place (A, S): ticks where the slide is wanted at the end of each stroke; band (A,): ticks, the
    hysteresis, even; sense (A, S): the side, where `given` (A, S) says that it is known whatever
    was before; stays (A, S): the slide is not moved.
    """
    half = (band // 2)[:, None]
    low, high = place - half, place + half
    if any_of(stays):
        low, high = np.where(stays, -FAR, low), np.where(stays, FAR, high)
    known = any_of(given)
    if known:
        there = place - sense * half
        low, high = np.where(given, there, low), np.where(given, there, high)
    middle = scan(low, high, carry.middle)
    sign = middle.copy()
    sign[:, 0] -= carry.middle
    sign[:, 1:] -= middle[:, :-1]
    sign = np.sign(sign)
    if known:
        return hold_last(np.where(given, sense, sign), given | (sign != 0), carry.side), middle
    return hold_last(sign, sign != 0, carry.side), middle


def hold_last(value: np.ndarray, given: np.ndarray, carry: np.ndarray) -> np.ndarray:
    """(A, S) the last value (A, S) that was given, or carry (A,)."""
    if all_of(given):
        return value
    result, open_ = value.copy(), ~given
    np.copyto(result[:, 0], carry, where=open_[:, 0])
    open_[:, 0] = False
    at = open_.ravel().nonzero()[0]
    if len(at):
        first = np.ones(len(at), bool)  # of those in a row, which all take what stands before it
        np.not_equal(at[1:], at[:-1] + 1, out=first[1:])
        flat = result.ravel()
        flat[at] = flat.take(at[first] - 1).take(first.cumsum() - 1)
    return result


def last_way(first: np.ndarray, then: np.ndarray, carry: np.ndarray) -> np.ndarray:
    """(A,) the sign of the last of two ways (A, S) of each stroke that is any, or carry (A,)."""
    way = carry.copy()
    for row, (one, two) in enumerate(zip(first, then, strict=True)):
        for at in (one | two).nonzero()[0][-1:]:
            way[row] = np.sign(two[at] or one[at])
    return way


def ramp(
    travel: np.ndarray, given: np.ndarray, value: np.ndarray, reach: np.ndarray, carry: np.ndarray
) -> np.ndarray:
    """(A, S) ticks of a ramp travelled behind each stroke, held within +-reach (A,).

    travel (A, S): ticks, signed, that count; given (A, S): where it is `value` (A, S) whatever was
    before; carry (A,).
    """
    # The state less all travel so far changes by clamps alone, whose bounds move by that travel: so
    # this too is one scan.
    total = np.cumsum(travel, axis=1)
    low = np.where(given, value, -reach[:, None]) - total
    high = np.where(given, value, reach[:, None]) - total
    ramp: np.ndarray = scan(low, high, carry) + total
    return ramp


def resting(
    goes_on: np.ndarray, start: np.ndarray, own: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """(K,) ticks at which strokes end along which an axis rests: where the one before left it, or
    at `start` if it does not go on from there, as long as that lies from `low` to `high`, else at
    its `own` place; (K,) each."""
    asked = np.arange(len(own))
    if len(own) > FEW:
        # Each ends from its low to its high, or at its own: most next ones lie beyond all of that.
        least, most = np.minimum(low, own), np.maximum(high, own)
        far = (most[:-1] < low[1:]) | (least[:-1] > high[1:])
        asked = np.append(0, (~(far & goes_on[1:])).nonzero()[0] + 1)
    ends = own.tolist()
    columns = (column.take(asked).tolist() for column in (goes_on, start, low, high))
    for k, on, begin, lowest, highest in zip(asked.tolist(), *columns, strict=True):
        here = ends[k - 1] if on else begin
        if lowest <= here <= highest:
            ends[k] = here
    return np.array(ends, np.int64)
