"""What a batch of blocks makes the machine do, as columns; the one thing that text and physics both know.

A axes in the machine's order, N motions in program order. Positions are int64 ticks (postproc.units) of slide position
in machine coordinates, radius, whatever the program wrote.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

RAPID, FEED, CLOCKWISE, COUNTER, FOREIGN = 0, 1, 2, 3, 9
LINES = (RAPID, FEED)


@dataclass(frozen=True)
class Arcs:
    """The n arcs among the motions; plane axes are rows of the machine's axes.

    motion (n,): which motion. first, second (n,): axes of the plane (G17 X Y, G18 Z X, G19 Y Z).
    centre (2, n): mm, machine coordinates. angle (n,): rad, of the start seen from the centre. sweep (n,): rad, whole
    way, + is counter-clockwise from `first` to `second`. radius, radius_end (n,): mm. grid (2, n): ticks of one least
    increment of the two centre words. words (3, n): word index of the two centre words and of R, -1 where not written.
    absolute (n,): whether the centre words are absolute; origin (2, n): ticks, their zero if so.
    """

    motion: np.ndarray
    first: np.ndarray
    second: np.ndarray
    centre: np.ndarray
    angle: np.ndarray
    sweep: np.ndarray
    radius: np.ndarray
    radius_end: np.ndarray
    grid: np.ndarray
    words: np.ndarray
    absolute: np.ndarray
    origin: np.ndarray

    def __len__(self) -> int:
        return len(self.motion)


@dataclass(frozen=True)
class Motions:
    """Columns of motions.

    block (N,); code (N,): RAPID, FEED, CLOCKWISE, COUNTER, or FOREIGN for what can not be followed.
    start, target (A, N): ticks; start_known, target_known (A, N). word (A, N): index of the
    axis' word, or -1; incremental (A, N): whether the axis' word is (or would be) a distance.
    grid (A, N): ticks of one least increment of that word; scale (A, N): ticks of one whole unit of it; origin (A, N):
    ticks, where its zero lies when it is absolute; places (A, N): decimals of a least increment. alone (N,): left as written (G53). feed_word (N,): index of the F word, or -1; inverse (N,): G93; feed (N,): the F number that
    holds. code_word (N,): index of its motion G word, or -1; renamed (N,): whether a motion code was named in a block
    since the motion before. reason (N,): index into `reasons`, 0: none, of why a correction can not be trusted here.
    """

    block: np.ndarray
    code: np.ndarray
    start: np.ndarray
    target: np.ndarray
    start_known: np.ndarray
    target_known: np.ndarray
    word: np.ndarray
    incremental: np.ndarray
    grid: np.ndarray
    scale: np.ndarray
    origin: np.ndarray
    places: np.ndarray
    alone: np.ndarray
    inverse: np.ndarray
    feed: np.ndarray
    feed_word: np.ndarray
    code_word: np.ndarray
    reason: np.ndarray
    renamed: np.ndarray
    arcs: Arcs
    reasons: list[tuple[str, str]] = field(default_factory=lambda: [("", "")])

    def __len__(self) -> int:
        return len(self.block)
