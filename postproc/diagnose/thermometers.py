"""Temperatures that no body can have: a thermometer that hangs, and one that jumps faster than
metal warms.

While it hangs it counts as not recorded, if readings before and after say between what it was; one
that hangs at the beginning or the end, or that jumps, is not used at all: what it was is unknown
then, or which of its levels was right.
"""

from __future__ import annotations

import numpy as np

LONG = 20  # readings in a row, equal to the last digit
# of the readings elsewhere differ from the one before: a coarse or slow channel says nothing
RESTLESS = 0.5
LEAST_K = 0.3  # K: by how much the channel varies where it does not hang
JUMP_K = 0.8  # K between two readings in a row
SPEED = 0.1  # K/s: 6 K a minute; metal that a sensor lies on and the air of a hall are slower
USUAL = 10.0  # times the channel's usual step
SETTLED = 3  # readings before and after that agree with themselves


def faulty(value: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, str] | None:
    """(M,) numbers of the readings that can not be used, from the first that shows it, and what is
    wrong; None of a channel in order. value, time (N,): degrees Celsius and s, in the order of
    time; NaN where there is no reading."""
    known = np.flatnonzero(np.isfinite(value))
    if len(known) < LONG:
        return None
    v, t = value[known], time[known]
    return _hangs(v, known) or _jumps(v, t, known)


def _hangs(v: np.ndarray, everywhere: np.ndarray) -> tuple[np.ndarray, str] | None:
    """A stretch without the noise that the rest of the channel has."""
    start = np.concatenate([[0], np.flatnonzero(np.diff(v) != 0) + 1])
    length = np.diff(np.append(start, len(v)))
    longest = int(np.argmax(length))
    others = np.delete(length, longest)
    if (
        length[longest] < LONG
        or np.ptp(v) < LEAST_K
        or len(others) < LONG
        or len(others) < RESTLESS * others.sum()
    ):
        return None
    begin, times = int(start[longest]), int(length[longest])
    rows = everywhere[begin : begin + times]
    said = f"reads {v[begin]:.4g} degrees {times} times in a row"
    if 0 < begin < len(v) - times:
        # only the stretch: readings on both sides of it bracket what it was
        return rows, f"{said}, and changed before and after"
    others_too = np.setdiff1d(everywhere, rows)
    return np.concatenate([rows, others_too]), f"{said}, and changed " + (
        "after" if begin == 0 else "before"
    )


def _jumps(v: np.ndarray, t: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, str] | None:
    """A step that stays."""
    step, gap = np.abs(np.diff(v)), np.maximum(np.diff(t), 1e-3)
    usual = float(np.quantile(step, 0.9))
    for k in np.argsort(-step)[:3]:
        if step[k] < max(JUMP_K, USUAL * usual) or step[k] / gap[k] < SPEED:
            continue
        before, after = v[max(0, k + 1 - SETTLED) : k + 1], v[k + 1 : k + 1 + SETTLED]
        if (
            min(len(before), len(after)) == SETTLED
            and max(np.ptp(before), np.ptp(after)) < step[k] / 3
        ):
            all_of_it = np.concatenate([rows[k + 1 :], rows[: k + 1]])
            return all_of_it, f"jumps by {v[k + 1] - v[k]:.2g} degrees in {gap[k]:.2g} s"
    return None
