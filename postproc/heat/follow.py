"""The drivers of a machine along a program: a log of temperatures read at the program's own clock, and a spindle that warms up.

Values are given in whole steps, each of which moves an axis by a small share of the tolerance, so that blocks that meet the same
temperature are corrected together. A program that outlasts its log is refused unless holding its last row was asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from postproc.errors import BlockFault
from postproc.heat import clock
from postproc.heat.log import Log
from postproc.machine.growth import Driver
from postproc.motions import Motions
from postproc.nc.lexer import Words
from postproc.units import UM

SHARE = 1 / 8  # of the tolerance, that steps of all drivers together may leave
ALIKE = 1e-4  # of a time constant


@dataclass(frozen=True)
class Warmth:
    """What one batch hands the next. spindles: two lags of each spindle driver, and when they were so, s; most: axis to mm, by how much heat moved it most so far; ticking: the clock."""

    ticking: clock.Ticking = field(default_factory=clock.Ticking)
    spindles: tuple[tuple[float, float, float], ...] = ()
    most: tuple[float, ...] = ()  # in the order of `letters`


@dataclass(frozen=True)
class Heat:
    """drivers; log; begin: s of the log at which the program starts; pace: how many times longer the machine takes than the
    words say; rates: of its clock; step (D,): unit of each whole step; hold: whether the log's last row holds beyond it."""

    drivers: tuple[Driver, ...]
    log: Log
    begin: float
    pace: float
    rates: clock.Rates
    step: np.ndarray
    hold: bool = False

    def initial(self) -> Warmth:
        """Before the first block: spindles are cold."""
        none = tuple((0.0, 0.0, 0.0) for d in self.drivers if not d.column)
        return Warmth(spindles=none, most=(0.0,) * len(self.letters))

    @cached_property
    def letters(self) -> tuple[str, ...]:
        """The axes that heat moves."""
        return tuple(dict.fromkeys(d.letter for d in self.drivers))

    def _moved(self, letter: str, values: np.ndarray) -> float:
        """mm: by how much drivers (D, N) move an axis, at most, wherever it stands."""
        own = [k for k, d in enumerate(self.drivers) if d.letter == letter]
        nodes = np.unique(np.concatenate([self.drivers[k].nodes for k in own]))
        unit = np.array(
            [np.interp(nodes, self.drivers[k].nodes, self.drivers[k].unit) for k in own]
        )
        return float(np.abs(unit.T @ np.unique(values[own], axis=1)).max(initial=0.0))

    def run(self, words: Words, motions: Motions, before: Warmth) -> tuple[Motions, Warmth]:
        """The motions with the whole steps (D, N) of the drivers in the middle of each. Raises BlockFault."""
        values, after = self.values(words, motions, before)
        steps = np.rint(values / self.step[:, None]).astype(np.int64)
        return replace(motions, heat=steps), after

    def values(self, words: Words, motions: Motions, before: Warmth) -> tuple[np.ndarray, Warmth]:
        """(D, N): each driver in the middle of each motion, and what the next batch must know. Raises BlockFault."""
        times, ticking = clock.run(words, motions, self.rates, before.ticking)
        at = times.middle * self.pace
        self._refuse(motions, times, ticking)
        result = np.zeros((len(self.drivers), len(motions)))
        spindles, k = list(before.spindles), 0
        for row, driver in enumerate(self.drivers):
            if driver.column:
                result[row] = self._read(driver, at)
            else:
                result[row], spindles[k] = _spun(dict(driver.spindle), at, times.rpm, spindles[k])
                k += 1
        most = tuple(
            max(a, self._moved(x, result)) for x, a in zip(self.letters, before.most, strict=True)
        )
        return result, Warmth(ticking, tuple(spindles), most)

    def within(self, words: Words, motions: Motions, before: Warmth) -> float:
        """mm: by how much the log's temperatures move the machine within half of one motion, at most."""
        times, _ = clock.run(words, motions, self.rates, before.ticking)
        moved = np.zeros(len(motions))
        for driver in (d for d in self.drivers if d.column):
            middle = self._read(driver, times.middle * self.pace)
            ends = [
                self._read(driver, end * self.pace / clock.MICRO) - middle
                for end in (times.begin, times.end)
            ]
            moved += np.abs(ends).max(axis=0) * driver.most
        return float(moved.max(initial=0.0))

    def _read(self, driver: Driver, at: np.ndarray) -> np.ndarray:
        """(N,) K above where the driver does nothing."""
        zero = driver.zero
        if math.isnan(zero):
            zero = float(Log.at(self.log, driver.column, np.array([self.begin]))[0])
        return self.log.at(driver.column, self.begin + at) - zero

    def _refuse(self, motions: Motions, times: clock.Times, ticking: clock.Ticking) -> None:
        """A block behind the end of the log."""
        if self.hold or not any(d.column for d in self.drivers):
            return
        left = float(self.log.time[-1]) - self.begin
        late = np.flatnonzero(times.end * self.pace / clock.MICRO > left)
        if len(late):
            k = int(late[0])
            raise BlockFault(
                int(motions.block[k]),
                f"{self.log.name} ends {left:.0f} s after the program begins, and this block ends after "
                f"{times.end[k] * self.pace / clock.MICRO:.0f} s",
                "a longer log, --log-begin where it fits, or --hold-temperature, which holds its last row",
            )

    def told(self, warmth: Warmth) -> str:
        """How long the program takes, and what the heat did, for a person."""
        lasts = warmth.ticking.now * self.pace / clock.MICRO
        moved = ", ".join(
            f"{x} by {size / UM:.1f} um" for x, size in zip(self.letters, warmth.most, strict=True)
        )
        return f"by its own clock the program takes {lasts:.0f} s; heat moves {moved or 'nothing'} at most"


def steps(drivers: tuple[Driver, ...], tolerance: float) -> np.ndarray:
    """(D,) whole steps: half a step of every driver along one axis is SHARE of the tolerance, mm, together, over all axes."""
    n = max(1, len(drivers))
    return np.array([2 * SHARE * tolerance / (n * d.most) if d.most else 1.0 for d in drivers])


def _spun(
    p: dict[str, float], at: np.ndarray, rpm: np.ndarray, before: tuple[float, float, float]
) -> tuple[np.ndarray, tuple[float, float, float]]:
    """(N,) um of growth in the middle of each motion, from turns (N,) that hold since the one before; spindle_growth's own two
    lags, solved exactly over each step."""
    fastest = max(p["fastest_rpm"], 1.0)
    heat = (np.abs(rpm) / fastest) ** p["power"] * fastest / 1000.0
    tau, housing = p["tau_s"], p["housing_s"]
    if housing > 0 and abs(housing / tau - 1.0) < ALIKE:
        housing = tau * (1.0 + ALIKE)
    level, slow, last = before
    result = np.zeros(len(at))
    for k, (t, hot) in enumerate(zip(at.tolist(), heat.tolist(), strict=True)):
        gone, above = t - last, level - hot
        first = math.exp(-gone / tau)
        if housing > 0:
            second = math.exp(-gone / housing)
            through = above * tau / (tau - housing) * (first - second)
            slow = hot + through + (slow - hot) * second
        level, last = hot + above * first, t
        result[k] = level * p["um_per_1000_rpm"] + (slow * p["housing_um"] if housing > 0 else 0.0)
    return result + p["shift_um"] * (np.abs(rpm) / fastest) ** 2, (level, slow, last)
