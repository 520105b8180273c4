"""Burst noise: an instrument that switches between two levels, there and back, whenever it pleases.

Contacts, amplifiers and fringe counters do so (random telegraph signal: Machlup, Noise in semiconductors: spectrum of a two-parameter
random signal, Journal of Applied Physics 25, 1954, 341). Which level it had is seen in the readings; how far the two lie apart
is one unknown more. What changes where an axis turns, starts or stops is the machine's, and so is what changes at a place.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from postproc.diagnose.noise import Unit
from postproc.diagnose.rows import Rows

WINDOW = 8  # samples on either side of a change
CLEAR, NOISE = 6.0, 3.0  # times what such medians differ by elsewhere; times the white noise
FEWEST = 3  # changes: there and back once may be a step that was lost and found
ALIKE = 0.3  # of the usual change: by how much one may differ from it
NEAR_S, NEAR = 0.1, 2  # s, samples: so close to a turn, a start or a stop it is the machine's
MOST_NEAR = 0.5  # of the changes may by chance be so close to one
APART = 0.05  # of the way: changes all within so little are of the place
MAD = 1.4826


def levels(rows: Rows, units: list[Unit]) -> list[np.ndarray | None]:
    """For each unit (n,) -0.5 or 0.5, the level of its readings; None where it has one level only, or more than two. Where one
    signal of a recording does so, a single change of another is no step of the machine either."""
    found = [_levels(rows, unit, FEWEST) for unit in units]
    files = {
        int(rows.file[u.rows[0]]) for u, one in zip(units, found, strict=True) if one is not None
    }
    return [
        _levels(rows, unit, 1) if one is None and int(rows.file[unit.rows[0]]) in files else one
        for unit, one in zip(units, found, strict=True)
    ]


def _levels(rows: Rows, unit: Unit, fewest: int) -> np.ndarray | None:
    y, n = rows.residual[unit.rows], len(unit)
    if not unit.dense or n < 8 * WINDOW:
        return None
    at = _lasting(y, _changes(y, NOISE * float(np.median(unit.r))))
    if len(at) < fewest or np.mean(_near_turns(rows, unit)[at]) > MOST_NEAR:
        return None
    size = _steps(y, at)
    usual = float(np.median(np.abs(size)))
    if np.any(size[1:] * size[:-1] >= 0) or np.any(np.abs(np.abs(size) - usual) > ALIKE * usual):
        return None
    if any(_at_a_place(rows, unit, at[size * side > 0]) for side in (1, -1)):
        return None
    level = np.repeat(np.arange(len(at) + 1), np.diff([0, *at, n])) % 2
    return level - 0.5


def _changes(y: np.ndarray, least: float) -> np.ndarray:
    """Numbers of the first readings behind abrupt changes of y (n,) by at least so much."""
    before = median_filter(y, WINDOW, origin=WINDOW // 2 - 1, mode="nearest")  # of k-7 to k
    jump = np.zeros(len(y))
    jump[1:-WINDOW] = before[WINDOW:-1] - before[: -WINDOW - 1]
    size = np.abs(jump)
    least = max(CLEAR * MAD * float(np.median(size)), least, 1e-9)
    sharp = size + 1e-6 * np.abs(
        np.diff(y, prepend=y[0])
    )  # of medians that are alike the one with the step itself
    return np.flatnonzero((size >= least) & (sharp == maximum_filter1d(sharp, 2 * WINDOW + 1)))


def _steps(y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(C,) by how much the median of y (n,) differs from one change to the next, before and after each of `at` (C,)."""
    return np.diff([float(np.median(part)) for part in np.split(y, at)])


def _lasting(y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The changes of which something stays: of a pulse shorter than the window only one end is found."""
    size = np.abs(_steps(y, at))
    return at[size > np.median(size) / 2] if len(at) else at


def _near_turns(rows: Rows, unit: Unit) -> np.ndarray:
    """(n,) bool: near a turn, a start or a stop of an axis, or the end of a passage."""
    n, near = len(unit), np.zeros(len(unit), bool)
    events = set(unit.edges[1:-1].tolist())
    for x in rows.state.velocity:
        way = np.sign(rows.state.velocity[x][unit.rows])
        events |= set((np.flatnonzero(np.diff(way)) + 1).tolist())
    for k in events:
        close = np.abs(unit.time - unit.time[min(k, n - 1)]) < NEAR_S
        near |= close
        near[max(0, k - NEAR) : k + NEAR] = True
    return near


def _at_a_place(rows: Rows, unit: Unit, at: np.ndarray) -> bool:
    """Whether an axis that moves was about the same place at each of several changes."""
    places = [p[unit.rows] for p in rows.state.position.values()]
    return len(at) > 1 and any(
        np.ptp(p) > 1e-3 and np.ptp(p[at]) < APART * np.ptp(p) for p in places
    )
