"""What an axis that turns back moves the others by: its straightness and angles may have been
measured both ways, and no take-up of another axis can bring that about in the same moment. Of one
that rests in a rapid the difference along itself counts too: it turns where its correction does, in
a motion that is not cut for it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from postproc.motions import RAPID, Motions
from postproc.slides import LEAST, Led
from postproc.verify.machines import Machines


class Turning:
    """The motions of a run (M), each of which stands for one `owner` (M,) of the nominal ones. back
    (A, M) bool: axes that may change their side in all of that nominal motion; unled (A, M) bool:
    those that rest in a rapid."""

    def __init__(
        self, machines: Machines, nominal: Motions, owner: np.ndarray, run: Motions, led: Led
    ):  # fmt: skip
        self.machines, self.run, self.led = machines, run, led
        rests = (nominal.start == nominal.target)[:, owner]
        self.unled = rests & (run.code == RAPID)
        self.back = led.back(owner, len(nominal))[:, owner] | self.unled

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
            side = np.zeros((len(command), len(at)))
            side[axis] = 1.0
            apart = self.machines.deviation(self.run, (row, t), command[:, at], side)
            apart -= self.machines.deviation(self.run, (row, t), command[:, at], -side)
            apart[axis] *= self.unled[axis, row]
            total[at] += np.where(turns[axis], np.linalg.norm(apart, axis=0), 0.0)
        return total
