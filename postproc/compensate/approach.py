"""Direction of approach, from the nominal motion alone: which column of a two-way table holds.

Every axis carries a whole number that follows its nominal travel in ticks and is held within +-reach. With a reach of one
tick it is the sign of the last move (modes step and off); with a reach of half the ramp it runs from one side to the
other while the axis travels the ramp (mode ramp); in mode mean it stays 0. The weight is that number over its reach:
-1, reached in -, to +1, reached in +; 0 is the mean of both, as before an axis has moved.

A stroke is a motion, or a part of an arc, along which no axis turns back.
"""

from __future__ import annotations

from itertools import accumulate

import numpy as np

from postproc.units import TICKS_PER_MM

MODES = ("mean", "step", "ramp", "off")


def reach(mode: str, ramp_mm: float) -> int:
    """Ticks of travel from the mean to either side; 0 where direction is not looked at."""
    if mode == "mean":
        return 0
    return round(ramp_mm / 2 * TICKS_PER_MM) if mode == "ramp" else 1


def follow(travel: np.ndarray, forget: np.ndarray, carry: np.ndarray, limit: int) -> tuple[np.ndarray, np.ndarray]:
    """(A, S) state before and after each stroke.

    travel (A, S): ticks, signed, of each stroke; forget (A, S): the axis came from nobody knows where; carry (A,): the
    state before the first stroke.
    """
    if limit == 0 or not travel.shape[1]:
        still = np.zeros_like(travel)
        return still, still
    after = np.empty_like(travel)
    if limit == 1:
        sign, given = np.sign(travel), travel != 0
        if forget.any():
            sign[forget], given = 0, given | forget
        last = np.maximum.accumulate(np.where(given, np.arange(travel.shape[1]), -1), axis=1)
        after = np.where(last >= 0, np.take_along_axis(sign, np.maximum(last, 0), axis=1), carry[:, None])
    else:
        for axis in range(len(travel)):
            steps = zip(travel[axis].tolist(), forget[axis].tolist(), strict=True)
            states = accumulate(
                steps, lambda s, d: 0 if d[1] else max(-limit, min(limit, s + d[0])), initial=int(carry[axis])
            )
            after[axis] = list(states)[1:]
    before = np.concatenate([carry[:, None], after[:, :-1]], axis=1)
    return before, after
