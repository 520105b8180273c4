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

from postproc.records import columns

MODES = ("mean", "step", "ramp", "off")
FAR = np.int64(2**62)  # ticks: a clamp that far apart holds nothing


@columns
class Sides:
    """What of the lost motion one batch hands to the next. side (A,): -1, 0 (unknown), +1;
    middle (A,): ticks, the state r; taken (A,): ticks of the ramp that have been travelled, from
    -reach to +reach; begun (A,): whether the axis has stood at a known place."""

    side: np.ndarray
    middle: np.ndarray
    taken: np.ndarray
    begun: np.ndarray


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
        while width < len(least) and np.count_nonzero(least[width:] < most[width:]):
            at = slice(width, None)
            pair = [
                np.minimum(np.maximum(end[:-width], least[at]), most[at]) for end in (least, most)
            ]
            least[at], most[at] = pair
            width *= 2
    return np.minimum(np.maximum(carry[:, None], low), high)


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
    low = np.where(given, place - sense * half, np.where(stays, -FAR, place - half))
    high = np.where(given, low, np.where(stays, FAR, place + half))
    middle = scan(low, high, carry.middle)
    before = np.concatenate([carry.middle[:, None], middle[:, :-1]], axis=1)
    sign = np.where(given, sense, np.sign(middle - before))
    return hold_last(sign, given | (sign != 0), carry.side), middle


def hold_last(value: np.ndarray, given: np.ndarray, carry: np.ndarray) -> np.ndarray:
    """(A, S) the last value (A, S) that was given, or carry (A,)."""
    if np.count_nonzero(given) == value.size:
        return value
    last = np.maximum.accumulate(np.where(given, np.arange(value.shape[1]), -1), axis=1)
    first = np.arange(0, value.size, value.shape[1])[:, None]  # of each row
    return np.where(last >= 0, value.take(np.maximum(last, 0) + first), carry[:, None])


def ramp(
    travel: np.ndarray, given: np.ndarray, value: np.ndarray, reach: np.ndarray, carry: np.ndarray
) -> np.ndarray:
    """(A, S) ticks of a ramp travelled behind each stroke, held within +-reach (A,).

    travel (A, S): ticks, signed, that count; given (A, S): where it is `value` (A, S) whatever was
    before; carry (A,).
    """
    total = np.cumsum(travel, axis=1)
    low = np.where(given, value, -reach[:, None]) - total
    high = np.where(given, value, reach[:, None]) - total
    return scan(low, high, carry) + total
