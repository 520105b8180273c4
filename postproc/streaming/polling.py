"""When a report of the controller's state is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass

from postproc.streaming.limits import Limits

AGAIN = 1.0  # s after which an unanswered request is made again


@dataclass
class Poll:
    """asked: when it was asked for last; waits: it has not come yet."""

    asked: float = -math.inf
    waits: bool = False

    def due(
        self, now: float, limits: Limits, watched: bool, off_path: bool, answered: float
    ) -> bool:
        """watched: whether the path is; doubts: whether a report was beside it; answered: when a
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
