"""What the motors made, beside the way that the program asks for. All in steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from postproc.streaming import zero
from postproc.streaming.path import nearest
from proof.streaming.programs import Program
from tests.streaming.real_grbl import STEPS, in_order

# Steps, by axis: the controller rounds to whole ones, and its chords miss an arc by half a step
# ($12).
WITHIN = 1.5


HELD = 21  # motions that the controller may have answered and not made


@dataclass
class Way:
    """A program's way in steps of the motors. zero: mm, where G54 lies."""

    program: Program
    zero: tuple[float, float, float]

    def __post_init__(self) -> None:
        self.places = (self.program.places + self.zero) * STEPS
        rows = [self.places[:1]]
        for a, b in zip(self.places[:-1], self.places[1:], strict=True):
            n = int(np.ceil(np.abs(b - a).max())) or 1
            rows.append(a + (b - a) * (np.arange(1, n + 1) / n)[:, None])
        dense = np.vstack(rows)
        self._tree = cKDTree(dense)
        self._flat = cKDTree(dense[:, :2])
        self._depth = dense[:, 2]
        self._clear = (self.program.cuts + self.zero[2]) * STEPS

    def near(self, stop: np.ndarray, reached: int) -> int:
        """Motions from the first place, of those that the controller may not have made, where it
        stands on the way when it stands at `stop`, to the last that it reached: where a way is cut
        twice over, or in short pieces, the first is meant, to be sure."""
        limit = zero.NEAR_MM * STEPS + 2
        motion, last = self.program.motion, max(reached - 1, 0)
        for i in range(1, reached):
            if motion[i] < motion[last] - HELD:
                continue
            _, off = nearest(self.places[i - 1 : i + 1], stop)
            if off <= limit:
                return int(motion[last] - motion[i])
        return 0

    def reached(self, steps: np.ndarray, within: float = WITHIN) -> int:
        """How many places the motors came by, from the first on, in order."""
        return in_order(steps, self.places, within)

    def left(self, steps: np.ndarray, within: float = WITHIN) -> int:
        """The first place from which on the motors came by all, in order."""
        return len(self.places) - in_order(steps[::-1], self.places[::-1], within)

    def beside(self, steps: np.ndarray) -> float:
        """The farthest (steps) that the tool was from the way, where it cuts and not straight above
        it: what it cut and should not have."""
        low = steps[steps[:, 2] < self._clear]
        if not len(low):
            return 0.0
        off, _ = self._tree.query(low, p=np.inf)
        far = off > WITHIN + 1
        worst = float(off[~far].max(initial=0.0))
        for place, distance in zip(low[far], off[far], strict=True):
            under = self._flat.query_ball_point(place[:2], WITHIN + 1, p=np.inf)
            if not under or place[2] < self._depth[under].min() - WITHIN - 1:
                worst = max(worst, float(distance))
        return worst

    def mm(self, first: int, stop: int) -> float:
        """Length of the way between two places."""
        part = self.places[max(first - 1, 0) : stop]
        if stop <= first:
            return 0.0
        return float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum()) / STEPS

    def motions(self, first: int, stop: int) -> int:
        """Programmed motions between two places, begun ones counted."""
        motion = self.program.motion
        return int(motion[stop - 1] - motion[first] + 1) if stop > first else 0


@dataclass
class Verdict:
    """uncut: mm of the way that neither run made; twice: motions that both made; beside: mm beside
    the way, at most; below: mm below the program's lowest place."""

    uncut: float
    twice: int
    beside: float
    below: float

    def right(self, margin: int) -> bool:
        return (
            self.uncut == 0.0
            and self.twice <= margin
            and self.beside <= (WITHIN + 1) / STEPS
            and self.below <= 1.0 / STEPS
        )

    def words(self) -> str:
        words = f"uncut {self.uncut:.2f} mm, twice {self.twice} motions"
        return f"{words}, beside {self.beside:.4f} mm, below {self.below:.4f} mm"


def judged(way: Way, first: np.ndarray, second: np.ndarray, within: float = WITHIN) -> Verdict:
    """Two runs of one job; `second` may be empty."""
    both = np.vstack([first, second]) if len(second) else first
    reached = way.reached(first, within)
    begin = way.left(second, within) if len(second) else len(way.places)
    below = max(0.0, float(way.places[:, 2].min() - both[:, 2].min()))
    return Verdict(
        way.mm(reached, begin), way.motions(begin, reached), way.beside(both) / STEPS, below / STEPS
    )  # fmt: skip
