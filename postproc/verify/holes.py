"""Holes of drilling cycles, sampled from R to the bottom: how far the axis of each is off sideways,
and its bottom along it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from postproc.machine.model import Machine
from postproc.motions import Motions
from postproc.slides import Led
from postproc.units import TICKS_PER_MM
from postproc.verify.distance import PLACES, all_known


@dataclass(frozen=True)
class Hole:
    """One hole. row: of its axis; motion: number of the nominal one; tap: whether it is one; of, t
    (K,): motion of the run and place in it; command (A, K) mm; sense: -1 or +1, of the way down;
    target (A, 1) mm: the nominal one; bottom mm: nominal place of the bottom less that of the
    target; place: whether the cycle goes to its place, else the axes stand there already."""

    row: int
    motion: int
    tap: bool
    of: np.ndarray
    t: np.ndarray
    command: np.ndarray
    sense: float
    target: np.ndarray
    bottom: float
    place: bool

    def weights(self, led: Led) -> Iterator[np.ndarray]:
        """(A, K) with which sides each place is reached: by the direction last commanded, and with
        lost motion as such."""
        rapid = np.ones(len(self.t), bool)
        for weight in led.at(self.of, 1.0 * rapid, self.command, 0 * self.command, rapid):
            # down the hole in both views: its own axis has gone that way from R on
            weight[self.row] = self.sense
            yield weight

    def off(self, actual: np.ndarray, rows: list[int]) -> tuple[float, float, float]:
        """mm: of actual places (A, K) the bottom along the axis, and the farthest sideways in
        `rows`; and how far off that may be since the axis bends while one place holds: half the
        diagonal of the box around it, and all of it where the axes stood at its top before."""
        off = actual - self.target
        deep = float(off[self.row, -1] - self.bottom)
        off[self.row] = 0.0
        bend = float(np.linalg.norm(np.ptp(off[rows], axis=1))) / (2 if self.place else 1)
        return abs(deep), float(np.linalg.norm(off[rows], axis=0).max()), bend


def holes_of(machine: Machine, nominal: Motions, run: Motions) -> Iterator[Hole]:
    """The holes of a run whose nominal place is known and that are corrected."""
    holes, drilled = nominal.holes, run.holes
    if not len(holes):
        return
    counts = all_known(machine, nominal.target_known)[holes.motion] & ~nominal.alone[holes.motion]
    for k in np.flatnonzero(counts):
        row, motion = int(holes.axis[k]), int(holes.motion[k])
        top, bottom = drilled.level[k] / TICKS_PER_MM, drilled.bottom[k] / TICKS_PER_MM
        nodes = np.concatenate([[top], *machine.knots.get(machine.letters[row], [])])
        nodes = (nodes - top) / ((bottom - top) or 1.0)
        # 32 places between R and the bottom, R and the nodes between, where it bends, and the
        # bottom itself as the last one (`off`)
        t = np.concatenate([PLACES[:32], nodes[(nodes >= 0) & (nodes < 1)], [1.0]])
        command = np.repeat(run.target[:, [drilled.motion[k]]] / TICKS_PER_MM, len(t), axis=1)
        command[row] = top + (bottom - top) * t
        yield Hole(
            row,
            motion,
            bool(holes.tap[k]),
            np.full(len(t), drilled.motion[k]),
            t,
            command,
            float(np.sign(bottom - top)),
            nominal.target[:, [motion]] / TICKS_PER_MM,
            (holes.bottom[k] - nominal.target[row, motion]) / TICKS_PER_MM,
            bool(holes.place[k]),
        )
