"""What heat does along both programs, for --verify: the drivers as they are, not in steps, each program by a clock of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.filter import Filter
from postproc.machine import growth
from postproc.machine.model import Machine
from postproc.motions import Motions
from postproc.nc.lexer import Words
from postproc.units import UM


class Warm:
    """The drivers of a filter's machine; none where nobody follows temperatures. within: mm, by how much heat moves the machine
    within half of one block, at most."""

    def __init__(self, filter_: Filter):
        self.heat = filter_.heat
        self.warmth = (
            [filter_.heat.initial() for _ in range(2)] if filter_.heat else []
        )  # of the nominal program, of the output
        self.values: dict[int, np.ndarray] = {}  # of the motions at hand: (D, N) drivers
        self.alone = _alone(filter_.machine)
        self.within = 0.0

    def see(self, words: Words, motions: Motions, again: Words, back: Motions) -> None:
        """A batch and its output."""
        if self.heat is None:
            return
        first, second = self.warmth
        nominal, after = self.heat.values(words, motions, first)
        own, behind = self.heat.values(again, back, second)
        self.values, self.warmth = {id(motions): nominal, id(back): own}, [after, behind]
        self.within = max(self.within, self.heat.within(words, motions, first))

    def deviation(
        self, run: Motions, row: np.ndarray, command: np.ndarray, weight: np.ndarray
    ) -> np.ndarray | float:
        """(A, K) mm: what heat adds at commands that belong to motions `row`."""
        parts = zip(self.alone, self.values.get(id(run), ()), strict=False)
        return sum((value[row] * one.deviation(command, weight) for one, value in parts), 0.0)

    def report(self) -> str:
        """What heat does while one block lasts."""
        return (
            f"; heat moves it by {self.within / UM:.2f} um at most within one block"
            if self.heat
            else ""
        )


def _alone(machine: Machine) -> list[Machine]:
    """For each driver of a machine's growth the machine that has nothing else, moved by one unit of it."""
    nothing = replace(
        machine, axes={x: a.bare for x, a in machine.axes.items()}, square={}, effects=()
    )
    every = np.eye(len(machine.growth))
    return [growth.grown(nothing, machine.growth, one) for one in every]
