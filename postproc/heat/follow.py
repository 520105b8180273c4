"""The drivers of a machine along a program: a log of temperatures read at the program's own clock,
and a spindle that warms up.

Values are given in whole steps, each of which moves an axis by a small share of the tolerance, so
that blocks that meet the same temperature are corrected together. A block that lasts so long that
heat moves the machine meanwhile is given in spells, to be cut in time. A program that outlasts its
log is refused unless holding its last reading was asked for.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from postproc.errors import BlockFault, Notice
from postproc.heat import clock
from postproc.heat.course import Course, Lags, State, spindle_lags
from postproc.heat.log import Log, Newest
from postproc.machine.axis import Driver
from postproc.motions import CLOCKWISE, COUNTER, FEED, FREE, Motions, Spells
from postproc.nc import pace
from postproc.nc.lexer import Words
from postproc.units import UM

# of the tolerance: what steps of all drivers together may leave, and as much again what heat does
# within one spell, from its middle on
SHARE = 1 / 8
LONG = 60.0  # s: a thermometer on metal moves by 6 K at most meanwhile (diagnose/thermometers.py)
SAMPLES = 16  # places a spell at which is looked where heat has moved the machine how far


@dataclass(frozen=True)
class HeatState:
    """What one batch hands the next. clock_state: the clock; spindles: two lags of each spindle
    driver; most: axis to mm, by how much heat moved it most so far."""

    clock_state: clock.ClockState = field(default_factory=clock.ClockState)
    spindles: tuple[State, ...] = ()
    most: tuple[float, ...] = ()  # in the order of `letters`


@dataclass(frozen=True)
class Heat:
    """drivers; log; begin: s of the log at which the program starts; pace: how many times longer
    the machine takes than the words say; rates: of its clock; step (D,): unit of each whole step;
    hold: whether the log's last row holds beyond it."""

    drivers: tuple[Driver, ...]
    log: Log
    begin: float
    pace: float
    rates: clock.Rates
    step: np.ndarray
    hold: bool = False

    def initial(self) -> HeatState:
        """Before the first block: spindles are cold."""
        none = tuple((0.0, 0.0) for d in self.drivers if not d.column)
        return HeatState(spindles=none, most=(0.0,) * len(self.letters))

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

    def run(
        self, words: Words, motions: Motions, before: HeatState
    ) -> tuple[Motions, HeatState, list[Notice]]:
        """The motions with the whole steps (D, N) of the drivers in the middle of each, and spells
        of those that are to be cut in time. Raises BlockFault."""
        # the middle of a motion stands for it: heat goes on evenly over so short a time
        course, after = self.course(words, motions, before)
        every = np.arange(len(motions))
        values = course.at(every, np.full(len(every), 0.5))
        steps = self._whole(values)
        spells, notices = self._spells(course, motions)
        if len(spells):
            values = np.concatenate([values, spells.heat * self.step[:, None]], axis=1)
        # how far heat moved each axis, for the sentence at the end: of every motion's middle and
        # every spell
        most = tuple(
            max(a, self._moved(x, values)) for x, a in zip(self.letters, before.most, strict=True)
        )
        after = replace(after, most=most)
        notices += [Notice("heat", self.sentence(after), size=1.0 + after.clock_state.now)]
        state = after.clock_state
        notices += self._stops(state.stops) + self._untimed(state.untimed)
        notices += self._unlimited(state.unlimited)
        return replace(motions, heat=steps, spells=spells), after, notices

    def course(self, words: Words, motions: Motions, before: HeatState) -> tuple[Course, HeatState]:
        """The drivers along a batch, and what the next one must know. Raises BlockFault."""
        times, clock_state = clock.run(words, motions, self.rates, before.clock_state)
        self._refuse(motions, times)
        lags: list[Lags] = []
        for driver in (d for d in self.drivers if not d.column):
            lags.append(
                spindle_lags(dict(driver.spindle), times, self.pace, before.spindles[len(lags)])
            )
        # the clock counts by the program's words; pace says that the machine takes longer
        second = self.pace / clock.MICRO
        course = Course(
            self.drivers, self.log, self.begin, times.begin * second, times.end * second,
            tuple(lags),
        )  # fmt: skip
        return course, replace(
            before, clock_state=clock_state, spindles=tuple(x.after for x in lags)
        )

    def _whole(self, values: np.ndarray) -> np.ndarray:
        """(D, K) whole steps of values (D, K)."""
        return np.rint(values / self.step[:, None]).astype(np.int64)

    def _spells(self, course: Course, motions: Motions) -> tuple[Spells, list[Notice]]:
        """Spells of motions within which heat moves the machine by more than two SHARE of the
        tolerance; and what is said of those that can not be cut."""
        every, limit = np.arange(len(motions)), max(1, len(self.drivers))
        varied = course.varied(every, np.ones(len(every)), self.step)
        # Only what cuts is cut in time, and only where a block may become several: no cycle, no
        # cutter compensation, no motion with an unknown end.
        may = np.isin(motions.code, (FEED, CLOCKWISE, COUNTER)) & ~motions.alone
        may &= (motions.start_known & motions.target_known).all(axis=0)
        if len(motions.cutter):
            may &= motions.cutter == FREE
        motion, until, heat = [], [], []
        for k in np.flatnonzero(may & (varied > limit)).tolist():
            #    heat ^            .---       Spells of equal change of heat, not of equal time:
            #         |       .--'           `so_far` turned round gives the shares of the motion at
            #         |    .-'               which they end, and their middles.
            #         +---|----|---|--> share
            parts = int(np.ceil(varied[k] / limit))
            share = np.linspace(0.0, 1.0, SAMPLES * parts + 1)
            so_far = course.varied(np.full(len(share), k), share, self.step)
            edges = np.interp(np.arange(1, parts) / parts * varied[k], so_far, share)
            middles = np.interp((np.arange(parts) + 0.5) / parts * varied[k], so_far, share)
            motion.append(np.full(parts, k))
            until.append(np.append(edges, 1.0))
            heat.append(self._whole(course.at(motion[-1], middles)))
        notices = self._left(motions, np.where(may, 0.0, varied) / limit, course)
        if not motion:
            return Spells(np.zeros(0, np.int64), np.zeros(0), np.zeros((0, 0), np.int64)), notices
        found = Spells(np.concatenate(motion), np.concatenate(until), np.concatenate(heat, axis=1))
        return found, notices

    def _left(self, motions: Motions, varied: np.ndarray, course: Course) -> list[Notice]:
        """What heat does within a block that is not cut, where that is more than the tolerance, of
        which `varied` (N,) is in units of two SHARE; rapids and what is left as it is do not
        count."""
        found = []
        counts = (motions.code >= FEED) & ~motions.alone
        worst = int(np.argmax(np.where(counts, varied, 0.0))) if len(motions) else 0
        if len(motions) and counts[worst] and varied[worst] * 2 * SHARE > 1.0:
            ends = course.at(np.array([worst, worst]), np.array([0.0, 1.0]))
            moved = max(self._moved(x, ends[:, 1:] - ends[:, :1]) for x in self.letters)
            message = (
                f"heat moves the machine by up to {moved / UM:.1f} um while this block lasts, which"
                " can not be cut in time: it is corrected for its middle"
            )
            found.append(Notice("heat in a block", message, int(motions.block[worst]), moved))
        longest = float((course.end - course.start).max(initial=0.0))
        if isinstance(self.log, Newest) and longest > LONG:
            k = int(np.argmax(course.end - course.start))
            message = (
                f"this block lasts {longest:.0f} s, and is corrected for the temperature at which"
                " it was prepared"
            )
            found.append(Notice("heat later", message, int(motions.block[k]), longest))
        return found

    def _stops(self, stops: int) -> list[Notice]:
        """What is said of stops of unknown time, where the clock counts."""
        if not stops or (isinstance(self.log, Newest) and all(d.column for d in self.drivers)):
            return []
        message = (
            f"heat over time: {stops} stops and tool changes (M0 M1 M6 M60) take no time by the"
            " program's clock: how long they take is not known, and what follows is corrected as if"
            " it came at once (G4 in their place counts)"
        )
        return [Notice("heat stops", message, size=float(stops))]

    def _untimed(self, dwells: int) -> list[Notice]:
        """What is said of dwells whose time is not known."""
        if not dwells or (isinstance(self.log, Newest) and all(d.column for d in self.drivers)):
            return []
        message = (
            f"heat over time: {dwells} dwells (G4) take no time by the program's clock: how long"
            f" they last on {self.rates.dialect.title} is not known"
            f" ({pace.told_by(self.rates.dialect)})"
        )
        return [Notice("heat dwells", message, size=float(dwells))]

    def _unlimited(self, blocks: int) -> list[Notice]:
        """What is taken of turns under G96 where the program tells no limit of them."""
        if not blocks or all(d.column for d in self.drivers):
            return []
        message = (
            f"heat over time: {blocks} blocks under G96 tell no limit of the spindle's turns (G50"
            " S, G92 S, LIMS=, D): they are taken as the surface speed asks for, at a radius of"
            " 1 mm at least, or as the machine's fastest_rpm"
        )
        return [Notice("heat surface", message, size=float(blocks))]

    def _refuse(self, motions: Motions, times: clock.Times) -> None:
        """A block behind the last reading of a column."""
        if self.hold:
            return
        ends = times.end * self.pace / clock.MICRO
        for driver in (d for d in self.drivers if d.column):
            left = float(self.log.recorded(driver.column)[-1]) - self.begin
            unrecorded = np.flatnonzero(ends > left)
            if len(unrecorded):
                k = int(unrecorded[0])
                raise BlockFault(
                    int(motions.block[k]),
                    f"{driver.column} of {self.log.name} ends {left:.0f} s after the program"
                    f" begins, and this block ends after {ends[k]:.0f} s",
                    "a longer log, --log-begin where it fits, or --hold-temperature, which holds"
                    " its last reading",
                )

    def sentence(self, state: HeatState) -> str:
        """How long the program takes, and what the heat did, for a person."""
        lasts = state.clock_state.now * self.pace / clock.MICRO
        moved = ", ".join(
            f"{x} by {size / UM:.1f} um" for x, size in zip(self.letters, state.most, strict=True)
        )
        return (
            f"by its own clock the program takes {lasts:.0f} s; heat moves {moved or 'nothing'} at"
            " most"
        )


def steps(drivers: tuple[Driver, ...], tolerance: float) -> np.ndarray:
    """(D,) whole steps: half a step of every driver along one axis is SHARE of the tolerance, mm,
    together, over all axes."""
    # Rounding to whole steps leaves half a step of each driver: n of them, SHARE * tolerance / n
    # each, make SHARE. A driver that moves nothing may have any step.
    n = max(1, len(drivers))
    return np.array([2 * SHARE * tolerance / (n * d.most) if d.most else 1.0 for d in drivers])
