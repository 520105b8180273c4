"""Straight strokes that pass a node of the map and are known to need no cut.

By how far the correction can leave its own chord is bounded by the nodes that are passed and by
product terms (`Bounds.bow`); what the written ends miss is told by one look at the map. Where both
together keep to the tolerance, no place is looked for, which takes ten times as long.

    written begin *-----_____                  miss: how far written ends lie beside exact ones. The
             miss |          -----_____        chord of a part of the stroke begins and ends no
      exact begin o--___               -----*  farther beside them than that, or than its own
                        ---___   bow        |  rounding.
                              o-____________o exact end
"""

from __future__ import annotations

import numpy as np

from postproc.compensate.batch import Batch
from postproc.compensate.inverse import CLOSE
from postproc.flags import any_of
from postproc.units import TICKS_PER_MM, in_mm


def allowed(b: Batch, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(A, K) mm that each axis may miss its straight way by in strokes `chosen` (K,), and how much
    of it is for rounding."""
    half = b.m.grid.take(b.motion[chosen], axis=1) / TICKS_PER_MM / 2  # what is written is rounded
    chord = np.where(b.travel.take(chosen, axis=1) == 0, b.c.chord / 2, b.c.chord)
    return chord + half, half


def proven(b: Batch, chosen: np.ndarray) -> np.ndarray:
    """(K,) bool: straight strokes `chosen` (K,) that need no cut, as far as that can be told so."""
    none = np.zeros(len(chosen), bool)
    if b.inside or b.tip:  # the map is read beside the stroke, or along the slides' own way
        return none
    begin, end = in_mm(b.begin.take(chosen, axis=1)), in_mm(b.end.take(chosen, axis=1))
    start, target = b.begin_nominal.take(chosen, axis=1), b.end_nominal.take(chosen, axis=1)
    # The map is asked where commands lie, which are as far beside the chord, or beside the exact
    # ends, as they miss it; and both are found to within CLOSE.
    more = 1 + 8 * b.machine.bounds.steepest
    bow = b.machine.bounds.bow(begin, end) * more + 4 * CLOSE
    led = b.c.followed
    if len(led):  # an axis that goes back within its play is held where it is
        back = (end - begin).take(led, axis=0) * b.weight_begin.take(led, axis=0).take(
            chosen, 1
        ) < 0
        bow = np.where(back.any(axis=0), np.inf, bow)
    may, half = allowed(b, chosen)
    # A chord that ends at a node has the rounding there for itself.
    near = (bow <= (may - half)[b.rows]).all(axis=0)
    if not any_of(near):
        return none
    place = np.concatenate([begin, end], axis=1)
    weight = b.weight_begin.take(np.concatenate([chosen, chosen]), axis=1)
    off = np.abs(
        place + b.machine.deviation(place, weight) - np.concatenate([start, target], axis=1)
    )
    miss = np.maximum(off[:, : len(chosen)], off[:, len(chosen) :])
    sure: np.ndarray = near & (miss * more + bow <= may)[b.rows].all(axis=0)
    return sure
