"""What heat does along both programs, for --verify: the drivers as they are, not in steps, each
program by a clock of its own."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.filter import Filter
from postproc.heat.course import Course
from postproc.machine import growth
from postproc.machine.model import Machine
from postproc.motions import Motions
from postproc.nc.lexer import Words


class Warm:
    """The drivers of a filter's machine along both programs; none where temperatures are not
    followed."""

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
