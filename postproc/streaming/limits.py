"""How long a sender waits before it draws a conclusion, and when it asks for a report of the
controller's state."""

from __future__ import annotations

import math
from dataclasses import dataclass

AGAIN = 1.0  # s after which an unanswered request is made again


@dataclass(frozen=True)
class Limits:
    """s: how often a status is asked for; how long silence, a standstill with lines unanswered, and
    an ordered stop may last.
    watch: the same where the
    path is watched; soon: and where an answer is late. off_mm: how far the machine may stand from
    where the last line ends; path_mm: from the path while it runs, beside the steps of its
    motors."""

    poll: float = 0.2
    silence: float = 2.0
    stall: float = 2.0
    grace: float = 1.0
    off_mm: float = 0.02
    path_mm: float = 0.05
    watch: float = 0.1
    soon: float = 0.05


@dataclass
class Poll:
    """asked: when it was asked for last; waits: it has not come yet."""

    asked: float = -math.inf
    waits: bool = False

    def due(
        self, now: float, limits: Limits, watched: bool, off_path: bool, answered: float
    ) -> bool:
        """watched: whether the path is; off_path: whether a report was beside it; answered: when a
        line was answered last."""
        # a motion takes longer than those before: where does it go?
        late = answered + limits.soon / 2
        pause = (
            limits.poll
            if not watched
            else limits.soon
            if off_path or self.asked < late < now
            else limits.watch
        )
        return now - self.asked >= (AGAIN if self.waits else pause)

    def ask(self, now: float) -> None:
        self.asked, self.waits = now, True
