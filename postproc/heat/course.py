"""The drivers of a machine along one batch: what each is at any moment of any motion, and by how
much it changes meanwhile."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from postproc.effects.spindle_growth import OPTIONAL, lagged, later
from postproc.heat import clock
from postproc.heat.log import Log
from postproc.machine.axis import Driver

State = tuple[float, float]  # of the two lags of one spindle driver


@dataclass(frozen=True)
class Lags:
    """A spindle that warms, along N motions. p: parameters of spindle_growth; level, slow (N,):
    both lags where each motion begins; hot (N,): what they go to meanwhile; shift (N,) um, of the
    shaft, at once; after: both lags behind the batch."""

    p: dict[str, float]
    level: np.ndarray
    slow: np.ndarray
    hot: np.ndarray
    shift: np.ndarray
    after: State

    def at(self, row: np.ndarray, gone: np.ndarray) -> np.ndarray:
        """(K,) um of growth, `gone` (K,) s after motions (K,) began."""
        level, slow = self._later(row, gone)
        return self._um(level, slow) + self.shift[row]

    def varied(self, row: np.ndarray, gone: np.ndarray) -> np.ndarray:
        """(K,) um by which both lags have changed since motions (K,) began: each goes one way, or
        nearly so, while the turns stay."""
        level, slow = self._later(row, gone)
        # both sizes are taken of their own change: they may go against each other, and the sum
        # would cancel
        first = self._um(np.abs(level - self.level[row]), 0 * slow)
        second = self._um(0 * level, np.abs(slow - self.slow[row]))
        return np.abs(first) + np.abs(second)

    def _later(self, row: np.ndarray, gone: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        p = self.p
        return later(
            self.level[row], self.slow[row], self.hot[row], gone, p["tau_s"], p["housing_s"]
        )

    def _um(self, level: np.ndarray, slow: np.ndarray) -> np.ndarray:
        found: np.ndarray = level * self.p["um_per_1000_rpm"]
        return found + slow * self.p["housing_um"] if self.p["housing_s"] > 0 else found


def spindle_lags(p: dict[str, float], times: clock.Times, pace: float, before: State) -> Lags:
    """A spindle along a batch. pace: how many times longer the machine takes than the clock."""
    took, rpm, moves = times.steps()
    fastest = max(p["fastest_rpm"], 1.0)
    turns = np.abs(rpm)
    # G96 near the centre asks for more turns than any spindle has: at a stated limit they end
    if fastest > OPTIONAL["fastest_rpm"]:  # it is stated: no control turns it faster
        turns = np.minimum(turns, fastest)
    share = turns / fastest
    # as in spindle_growth.columns: what the lag goes to while these turns last
    hot = share ** p["power"] * fastest / 1000.0
    # dwells as well: a spindle warms while nothing moves, so all steps are followed, motions picked
    # behind
    level, slow = lagged(took * pace / clock.MICRO, hot, before, p["tau_s"], p["housing_s"])
    begins = np.flatnonzero(moves)
    return Lags(
        p, level[begins], slow[begins], hot[begins], p["shift_um"] * share[begins] ** 2,
        (float(level[-1]), float(slow[-1])),
    )  # fmt: skip


@dataclass(frozen=True)
class Course:
    """drivers (D of them); log, and begin, s of it at which the program starts; start, end (N,): s
    since then, of each motion; lags: of each driver that is a spindle, in their order."""

    drivers: tuple[Driver, ...]
    log: Log
    begin: float
    start: np.ndarray
    end: np.ndarray
    lags: tuple[Lags, ...]

    def at(self, row: np.ndarray, share: np.ndarray) -> np.ndarray:
        """(D, K): each driver in motions `row` (K,), when a share (K,) of their time is over."""
        took = (self.end - self.start)[row] * share
        moment, lags = self.start[row] + took, iter(self.lags)
        found = np.zeros((len(self.drivers), len(row)))
        for k, driver in enumerate(self.drivers):
            if driver.column:
                found[k] = self.log.at(driver.column, self.begin + moment) - self._zero[k]
            else:
                found[k] = next(lags).at(row, took)
        return found

    def varied(self, row: np.ndarray, share: np.ndarray, unit: np.ndarray) -> np.ndarray:
        """(K,): by how many units (D,) all drivers have changed, to and fro added up, since motions
        `row` (K,) began, when a share (K,) of their time is over."""
        took = (self.end - self.start)[row] * share
        first, lags = self.begin + self.start[row], iter(self.lags)
        found = np.zeros(len(row))
        for k, driver in enumerate(self.drivers):
            if driver.column:
                found += self.log.varied(driver.column, first, first + took) / unit[k]
            else:
                found += next(lags).varied(row, took) / unit[k]
        return found

    @cached_property
    def _zero(self) -> list[float]:
        """Degrees Celsius at which each driver does nothing: as stated, or as it was when the
        program began."""
        return [
            (
                float(Log.at(self.log, d.column, np.array([self.begin]))[0])
                if d.column and math.isnan(d.zero)
                else d.zero
            )
            for d in self.drivers
        ]
