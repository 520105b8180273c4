"""What an axis that turns back moves the others by: its straightness and angles may have been
measured both ways, and no take-up of another axis can bring that about in the same moment. The
difference along itself counts too where nothing takes it up: of one that a rapid moves by no more
than its sides lie apart, for which it is not cut, and where forward lies beyond reverse, which asks
for a way beyond the place and back.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from postproc.motions import RAPID, Motions
from postproc.slides import LEAST, Led
from postproc.units import TICKS_PER_MM
from postproc.verify.machines import Machines


class Turning:
    """The motions of a run (M), each of which stands for one `owner` (M,) of the nominal ones. back
    (A, M) bool: axes that may change their side in all of that nominal motion; unled (A, M) bool:
    those that a rapid hardly moves, or of which forward lies beyond reverse (`overshoots`,
    (A,))."""

    def __init__(
        self, machines: Machines, nominal: Motions, owner: np.ndarray, run: Motions, led: Led,
        overshoots: np.ndarray,
    ):  # fmt: skip
        self.machines, self.run, self.led = machines, run, led
        # a correction turns what moves by less than the sides lie apart
        apart = machines.whole.widest_play * TICKS_PER_MM
        rests = (np.abs(nominal.target - nominal.start) <= apart[:, None])[:, owner]
        held = rests & (run.code == RAPID)
        self.unled = held | overshoots[:, None]
        self.back = led.back(owner, len(nominal))[:, owner] | held

    def aside(
        self, some: np.ndarray, where: Any, command: np.ndarray, weight: np.ndarray
    ) -> np.ndarray:
        """(K,) mm at commands (A, K) of motions and t (K,) each, reached with weights (A, K): how
        far the two sides of the axes that turn back lie apart; 0 but for `some` (K,) bool."""
        total, at = np.zeros(len(some)), some.nonzero()[0]
        row, t = (column[at] for column in where)
        before = self.led.side[:, self.led.leg(row, t)]
        turns = self.back[:, row] | (np.abs(weight[:, at] - before) > LEAST)
        for axis in self.led.slides.rows.tolist():
            # Deviation with this axis on its + side less that on its - side, the others in the
            # mean: what it moves them by when it turns. Along itself it counts where no take-up was
            # made (unled).
            side = np.zeros((len(command), len(at)))
            side[axis] = 1.0
            apart = self.machines.deviation(self.run, (row, t), command[:, at], side)
            apart -= self.machines.deviation(self.run, (row, t), command[:, at], -side)
            apart[axis] *= self.unled[axis, row]
            total[at] += np.where(turns[axis], np.linalg.norm(apart, axis=0), 0.0)
        return total
