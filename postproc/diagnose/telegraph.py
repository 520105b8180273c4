"""Burst noise: an instrument that switches between levels, there and back, whenever it pleases.

Contacts, amplifiers and fringe counters do so (random telegraph signal: Machlup, Noise in
semiconductors: spectrum of a two-parameter random signal, Journal of Applied Physics 25, 1954,
341). Which level it had is seen in the readings; how far two of them lie apart is one unknown more;
where they are more than two each change is an unknown of its own.
What changes where an axis turns, starts or stops is the machine's, and so is what changes at a
place.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.ndimage import maximum_filter1d

from postproc.diagnose.jumps import CLEAR, WINDOW, changes, difference
from postproc.diagnose.noise import Unit
from postproc.diagnose.rows import Rows

NOISE = 3.0  # times the white noise
FEWEST = 3  # changes: there and back once may be a step that was lost and found
MANY = 4  # changes between more levels than two: a drive that loses steps more often is not run on
BACK = 0.25  # of them go the rarer way: what is lost again and again goes one way
ALIKE = 0.3  # of the usual change: by how much one may differ from it
NEAR_S, NEAR = 0.1, 2  # s, samples: so close to a turn, a start or a stop it is the machine's
MOST_NEAR = 0.5  # of the changes may by chance be so close to one
APART = 0.05  # of the way: changes within so little of each other are of the place
MOST_THERE = 2 / 3  # of the changes: two of three may by chance be at one place
MAD = 1.4826


def levels(rows: Rows, units: list[Unit]) -> list[np.ndarray | None]:
    """For each unit (n,) -0.5 or 0.5, the level of its readings; None where it has one level only,
    or more than two. Where one signal of a recording switches, the same electronics read the
    others: there and back once is enough there. One change that stays is not."""
    found = [_levels(rows, unit, FEWEST) for unit in units]
    files = switching(rows, units, found)
    return [
        _levels(rows, unit, 2) if one is None and int(rows.file[unit.rows[0]]) in files else one
        for unit, one in zip(units, found, strict=True)
    ]


def switching(rows: Rows, units: list[Unit], found: Sequence[object]) -> set[int]:
    """Numbers of the recordings in which an instrument switches, by what levels() or steps()
    says."""
    return {
        int(rows.file[unit.rows[0]])
        for unit, level in zip(units, found, strict=True)
        if level is not None
    }


def steps(rows: Rows, units: list[Unit]) -> list[tuple[np.ndarray, float] | None]:
    """For each unit that levels() knows nothing of: (n, C + 1) 1 between two changes, and mm, their
    usual size (about one zero: what jumps to and fro carries no slope away); None where the signals
    of its recording do not change many times together, to and fro."""
    found = [
        _steps_of(rows, unit) if level is None else (np.zeros(0, int), np.zeros(0))
        for unit, level in zip(units, levels(rows, units), strict=True)
    ]
    file = np.array([int(rows.file[unit.rows[0]]) for unit in units])
    result: list[tuple[np.ndarray, float] | None] = []
    for unit, number, (at, size) in zip(units, file, found, strict=True):
        others = [found[k][1] for k in np.flatnonzero(file == number)]
        # of all signals of the recording: the same electronics read them
        together = np.concatenate(others) > 0
        rarer = min(np.count_nonzero(together), np.count_nonzero(~together))
        several = sum(len(o) > 0 for o in others) > 1  # one alone may be a place that is passed
        if not several or not len(at) or len(together) < MANY or rarer < BACK * len(together):
            result.append(None)
            continue
        number_of = np.searchsorted(at, np.arange(len(unit)), side="right")
        between = (number_of[:, None] == np.arange(len(at) + 1)).astype(float)
        result.append((between, float(np.median(np.abs(size)))))
    return result


def _steps_of(rows: Rows, unit: Unit) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (C,) of the first readings behind changes that are not the machine's, and mm (C,)
    their sizes."""
    y, n = rows.residual[unit.rows], len(unit)
    none = np.zeros(0, int), np.zeros(0)
    if not unit.dense or n < 8 * WINDOW:
        return none
    at = _changes(y, NOISE * float(np.median(unit.r)))
    at = at[np.abs(_steps(y, at)) > np.abs(difference(y)[at]) / 2]  # what drifts back was no level
    if not len(at) or np.mean(near_turns(rows, unit)[at]) > MOST_NEAR or _driven(rows, unit, at):
        return none
    size = _steps(y, at)
    return none if _at_places(rows, unit, at, size > 0) else (at, size)


def _driven(rows: Rows, unit: Unit, at: np.ndarray) -> bool:
    """Whether something that was recorded beside (a force, a speed of the spindle) changes as
    abruptly at most of the changes."""
    for values in rows.state.channels.values():
        own = values[unit.rows]
        if not np.isfinite(own).all() or np.ptp(own) == 0:
            continue
        jump = np.abs(difference(own))
        near = maximum_filter1d(jump, WINDOW)[at]
        if np.mean(near > max(CLEAR * MAD * float(np.median(jump)), 0.1 * np.ptp(own))) > 0.5:
            return True
    return False


def notices(rows: Rows, units: list[Unit]) -> list[str]:
    """What a person is told of each instrument that switches."""
    return [
        f"{Path(rows.files[rows.file[unit.rows[0]]]).name}:"
        f" {rows.signals[rows.signal[unit.rows[0]]]}"
        f" switches between two levels, {np.count_nonzero(np.diff(level))} times by about"
        f" {_usual(rows, unit, level):.2g} um: burst noise of the instrument, taken out"
        for unit, level in zip(units, levels(rows, units), strict=True)
        if level is not None
    ] + [
        f"{Path(rows.files[rows.file[unit.rows[0]]]).name}:"
        f" {rows.signals[rows.signal[unit.rows[0]]]}"
        f" jumps by about {step[1] * 1e3:.2g} um, {step[0].shape[1] - 1} in all, away from turns"
        " and from any one place, and the signals of this recording jump to and fro: burst noise of"
        " the instrument, taken out"
        for unit, step in zip(units, steps(rows, units), strict=True)
        if step is not None
    ]


def _usual(rows: Rows, unit: Unit, level: np.ndarray) -> float:
    """um, usual size of a change."""
    at = np.flatnonzero(np.diff(level)) + 1
    return float(np.median(np.abs(_steps(rows.residual[unit.rows], at)))) * 1e3


def _levels(rows: Rows, unit: Unit, fewest: int) -> np.ndarray | None:
    y, n = rows.residual[unit.rows], len(unit)
    if not unit.dense or n < 8 * WINDOW:
        return None
    at = _lasting(y, _changes(y, NOISE * float(np.median(unit.r))))
    if len(at) < fewest or np.mean(near_turns(rows, unit)[at]) > MOST_NEAR:
        return None
    size = _steps(y, at)
    usual = float(np.median(np.abs(size)))
    # up and down by turns, and by as much: two levels
    if np.any(size[1:] * size[:-1] >= 0) or np.any(np.abs(np.abs(size) - usual) > ALIKE * usual):
        return None
    if _at_places(rows, unit, at, size > 0):
        return None
    #     at:        at[0]    at[1]       at[2]
    #           ------|   .------|    .-----|          level -0.5, 0.5, -0.5, 0.5
    #                 '--'       '---'
    # How far the two lie apart is the coefficient of this column, its sign included.
    level = np.repeat(np.arange(len(at) + 1), np.diff([0, *at, n])) % 2
    return level - 0.5


def _changes(y: np.ndarray, least: float) -> np.ndarray:
    """Numbers of the first readings behind abrupt changes of y (n,) by at least so much."""
    at, size = changes(y)
    usual = MAD * float(np.median(np.abs(difference(y))))
    return at[size >= max(CLEAR * usual, least, 1e-9)]


def _steps(y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(C,) by how much the median of y (n,) differs from one change to the next, before and after
    each of `at` (C,)."""
    return np.diff([float(np.median(part)) for part in np.split(y, at)])


def _lasting(y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The changes of which something stays: of a pulse shorter than the window only one end is
    found."""
    size = np.abs(_steps(y, at))
    return at[size > np.median(size) / 2] if len(at) else at


def near_turns(rows: Rows, unit: Unit) -> np.ndarray:
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


def _at_places(rows: Rows, unit: Unit, at: np.ndarray, up: np.ndarray) -> bool:
    """Whether most changes of one kind, to a higher level as the place of an axis rises or as it
    falls, are about where others of that kind are, and the axis was elsewhere between them."""
    for x, p in rows.state.position.items():
        place, forth = p[unit.rows], rows.state.approach[x][unit.rows][at] > 0
        near = APART * float(np.ptp(place))
        if np.ptp(place) <= 1e-3:
            continue
        there = 0
        for own in (at[up == forth], at[up != forth]):
            left = [np.ptp(place[a : b + 1]) > 2 * near for a, b in pairwise(own)]
            if len(own) > 1 and np.ptp(place[own]) < near and all(left):
                there += len(own)
        if there > MOST_THERE * len(at):
            return True
    return False
