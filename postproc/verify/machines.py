"""The machine as each motion finds it: with its tool, in its space, as warm as it is then by the
drivers as they are, not in steps, each program by a clock of its own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from postproc.filter import Filter
from postproc.heat.course import Course
from postproc.machine import growth
from postproc.machine.model import Machine
from postproc.machine.polar import PolarMachine
from postproc.machine.seen import seen_in
from postproc.machine.tip import TipMachine
from postproc.motions import Motions
from postproc.nc.lexer import Words
from postproc.spaces import Space
from postproc.units import TICKS_PER_MM
from postproc.verify.distance import to_path


class Warm:
    """The drivers of heat of a filter's machine along both programs; none where temperatures are
    not followed."""

    def __init__(self, filter_: Filter):
        self.heat = filter_.heat
        self.warmth = (
            [filter_.heat.initial() for _ in range(2)] if filter_.heat else []
        )  # of the nominal program, of the output
        self.courses: dict[int, Course] = {}  # of the motions at hand
        self.alone = _alone(filter_.machine)

    def see(self, words: Words, motions: Motions, read_back: Words, back: Motions) -> None:
        """A batch and its output."""
        if self.heat is None:
            return
        first, second = self.warmth
        nominal, after = self.heat.course(words, motions, first)
        own, behind = self.heat.course(read_back, back, second)
        # by the objects themselves: both are looked up while this batch is measured, and replaced
        # by the next
        self.courses = {id(motions): nominal, id(back): own}
        self.warmth = [after, behind]

    def parts(
        self, run: Motions, where: tuple[np.ndarray, np.ndarray]
    ) -> Iterator[tuple[Machine, np.ndarray]]:
        """For each driver the machine that it alone moves by one unit, and (K,) its value in
        motions (K,) of a run, when a share (K,) of their time is over."""
        if self.heat is not None:
            yield from zip(self.alone, self.courses[id(run)].at(*where), strict=True)


def _alone(machine: Machine) -> list[Machine]:
    """For each driver of a machine's growth the machine that has nothing else, moved by one unit of
    it."""
    every = np.eye(len(machine.growth))
    return [growth.grown(machine.bare, machine.growth, one) for one in every]


class Machines:
    """A machine and what it is for each tool and space. oriented: whether the tool's direction is
    corrected too; warm: what heat does along the programs."""

    def __init__(self, whole: Machine, oriented: bool, warm: Warm):
        self.whole, self.oriented, self.warm = whole, oriented, warm
        self._seen: dict[tuple[int, Space | None, tuple[int, ...]], Machine] = {}

    def deviation(
        self, run: Motions, where: Any, command: np.ndarray, weight: np.ndarray
    ) -> np.ndarray:
        """(A, K) mm at commands (A, K) of motions (K,) when a share (K,) of their time is over."""
        result = np.zeros_like(command)
        for machine, of in self.each(run, where[0]):
            result[:, of] = machine.deviation(command[:, of], weight[:, of])
        for one, value in self.warm.parts(run, where):
            for machine, of in self.each(run, where[0], one):
                # Linear in each driver, so one machine of one unit serves every moment: no machine
                # is built for each temperature, and none is rounded to whole steps as the corrected
                # program is.
                result[:, of] += value[of] * machine.deviation(command[:, of], weight[:, of])
        return result

    def each(
        self, run: Motions, row: np.ndarray, only: Machine | None = None
    ) -> Iterator[tuple[Machine, np.ndarray]]:
        """The machine (or `only`) with each tool and space; (K,) bool, which motions it runs."""
        whole = only or self.whole
        # a tool's length matters where something turns, a space where X Y Z are no slides
        if not (whole.turns and run.length.any()) and not run.space.any():
            yield whole, np.ones(len(row), bool)
            return
        every, which = np.unique(
            np.concatenate([run.length, run.space[None]])[:, row], axis=1, return_inverse=True
        )
        for k, key in enumerate(every.T):
            one = id(whole), run.spaces[int(key[-1])], tuple(key[:-1].tolist())
            if one not in self._seen:
                long = key[:-1] / TICKS_PER_MM
                self._seen[one] = seen_in(whole, long, one[1], self.oriented)
            yield self._seen[one], which.ravel() == k

    def corrected_part(self, run: Motions, row: np.ndarray, off: np.ndarray) -> np.ndarray:
        """(A, K) mm: what of deviations (A, K) of motions `row` lies along corrected axes."""
        result = np.zeros_like(off)
        for machine, of in self.each(run, row):
            seen = machine if isinstance(machine, PolarMachine) else self.whole
            rows = np.array(seen.corrected, dtype=int)
            result[np.ix_(rows, of)] = off[np.ix_(rows, of)]
        return result

    def to_path(
        self, nominal: Motions, owner: np.ndarray, t: np.ndarray, actual: np.ndarray
    ) -> np.ndarray:
        """(K,) mm from actual points (A, K) to the nominal path of motions `owner` (K,) at t."""
        # on a face X and C are Cartesian, and both are corrected: the distance is measured in other
        # rows
        faces = [k for k, space in enumerate(nominal.spaces) if space is not None and space.polar]
        on = np.isin(nominal.space[owner], faces)
        if not on.any():
            return to_path(self.whole, nominal, owner, t, actual)
        result = np.zeros(len(owner))
        for machine, of in self.each(nominal, owner):
            polar = isinstance(machine, PolarMachine)
            seen = machine if polar else self.whole
            result[of] = to_path(seen, nominal, owner[of], t[of], actual[:, of])
        return result

    def slides(self, run: Motions, row: np.ndarray, command: np.ndarray) -> np.ndarray:
        """(A, K) slide positions at commands (A, K) of motions `row`."""
        if not run.space.any():
            return command
        result = command.copy()
        for machine, of in self.each(run, row):
            if isinstance(machine, TipMachine):
                result[:, of] = machine.slides(command[:, of])
        return result
