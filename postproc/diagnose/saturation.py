"""Readings that an instrument could not give: at the end of its range, or the same again and
again."""

from __future__ import annotations

import numpy as np

FEWEST = 5
SHARE = 0.05
MORE = 5.0  # times as often as other values
NEAR = 0.1  # of the range: how near the next value lies to an end that cuts readings off
# of the readings: otherwise the instrument's step is coarse, and equal readings are nothing special
DISTINCT = 0.3
LONG = 8  # readings at rest
SAMPLES = 20
WENT = 20.0  # times the usual step of the encoder


def at_an_end(values: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(N,) bool: readings at the largest or smallest value, where that occurs far more often than
    any value should.

    place (N,): rows with the same number were taken at the same place. Where readings elsewhere
    repeat to the last digit, as without any noise, or are whole steps of a coarse instrument, equal
    readings say nothing.
    """
    result = np.zeros(len(values), bool)
    number, count = np.unique(values, return_counts=True)
    if len(number) < 4:
        return result
    usual = float(np.median(count))
    for k, next_ in ((0, 1), (-1, -2)):
        near = abs(number[k] - number[next_]) < NEAR * np.ptp(number)
        #     count |                    *    readings that are cut off pile up at the end;
        #           |  . .. . ... .. .. .*    an outlier there has no neighbour near it
        #           +--------------------- value
        if near and count[k] >= max(FEWEST, SHARE * len(values), MORE * usual):
            result |= values == number[k]
    rest = values[~result]
    if len(np.unique(rest)) < DISTINCT * len(rest) or _repeats(rest, place[~result]):
        result[:] = False
    return result


def _repeats(values: np.ndarray, place: np.ndarray) -> bool:
    """Whether readings at the same place are mostly equal, or there are none to compare."""
    order = np.argsort(place, kind="stable")
    again = np.diff(place[order]) == 0
    return not again.any() or float(np.mean(np.diff(values[order])[again] == 0)) > 0.5


def unchanged(values: np.ndarray) -> np.ndarray:
    """(N,) bool: all but the first of many equal readings in a row, where readings usually
    differ."""
    result = np.zeros(len(values), bool)
    if len(np.unique(values)) < DISTINCT * len(values):
        return result
    return _same_in_a_row(values, LONG)


def while_moving(cmd: np.ndarray, act: np.ndarray) -> np.ndarray:
    """(N,) bool: samples of an axis whose actual place stands still to the last digit while its
    commanded place goes on."""
    still = _same_in_a_row(act, SAMPLES)
    if not still.any():
        return still
    steps = np.abs(np.diff(np.unique(act)))
    least = max(
        WENT * float(np.median(steps)) if len(steps) else 0.0,
        WENT * float(np.median(np.abs(act - cmd))),
        0.1,
    )
    # begin, end, begin, end ... of the stretches
    edge = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    for a, b in zip(edge[::2], edge[1::2], strict=True):
        if np.ptp(cmd[max(a - 1, 0) : b]) < least:
            still[a:b] = False
    return still


def _same_in_a_row(values: np.ndarray, fewest: int) -> np.ndarray:
    start = np.concatenate([[0], np.flatnonzero(np.diff(values) != 0) + 1])
    length = np.diff(np.append(start, len(values)))
    result = np.repeat(length >= fewest, length)
    result[start] = False
    return result
