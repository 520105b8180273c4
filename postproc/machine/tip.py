"""A machine as the tool tip sees it: the deviation of places of the tip, and of the rotary axes
where the tool's lean is corrected too.

With tool centre point control the words X Y Z are the tip's place in the part, and the control's
own nominal kinematics turn them into slides. What the tip misses by is then simply told along those
words: to first order it is what rotary.py carries to the part's frame. Nothing has to be told along
slides, and no pose but one at which the control itself can not hold the tip is refused.

A tool that leans is set right by the rotary axes as far as they turn it: the lean across the tool
is told along their directions in the part. Near a pole (C under A0) one of them hardly moves the
tool; from SOFT on downwards less of the lean is corrected, so that no axis is sent round for a few
microradians.
"""

from __future__ import annotations

from dataclasses import field
from functools import cached_property

import numpy as np

from postproc.machine import poses
from postproc.machine.bounds import Bounds
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.machine.rotary import cross
from postproc.records import record
from postproc.spaces import Space

SOFT = 0.05  # rad of the tool per rad of an axis: 2.9 degrees beside a pole
# of one motion: beside a pose that no slide can hold the bound grows beyond every measure
MOST_PARTS = 20_000
# degrees that a stroke turns at most, and places looked at on it
SAMPLES = ((40.0, 9), (160.0, 33), (np.inf, 129))


@record
class TipMachine(Machine):
    """The machine `base`, with the tool in its spindle, in a `space`. anchor (3,): mm, the point
    [tool] without a length.
    oriented: whether rotary axes are corrected for the tool's lean."""

    base: Machine = None  # type: ignore[assignment]
    anchor: np.ndarray = field(default_factory=lambda: np.zeros(3))
    space: Space = field(default_factory=Space)
    oriented: bool = False

    @cached_property
    def corrected(self) -> tuple[int, ...]:
        """Rows of the axes that a correction can move."""
        rotary = self.chain.rotary if self.oriented else ()
        return tuple(
            i
            for i, x in enumerate(self.letters)
            if x in self.chain.axes and (x in XYZ or x in rotary)
        )

    @cached_property
    def is_zero(self) -> bool:
        """Whether no correction can ever be needed."""
        return self.base.is_zero

    @cached_property
    def two_way(self) -> np.ndarray:
        """(A,) bool: axes whose own direction of approach matters: those of the slides behind the
        words."""
        return self.base.two_way

    @cached_property
    def direct(self) -> np.ndarray:
        """(A,) bool: coordinates along which their own slide goes alone, whatever else moves."""
        return np.zeros(len(self.letters), bool)

    @cached_property
    def depends(self) -> np.ndarray:
        """(A, A) bool: every correction needs the places of all axes of the chain."""
        result = np.zeros((len(self.letters),) * 2, bool)
        result[np.ix_(self.corrected, self.chained)] = True
        return result

    @cached_property
    def bounds(self) -> Bounds:
        """How far the deviation can bend and change."""
        return TipBounds(self)

    def slides(self, position: np.ndarray) -> np.ndarray:
        """(A, N) slide positions, mm and degrees, at commands (A, N) of the space."""
        #    word u --turn, origin--> tip in the part --anchor: [tool] without its length--> slides
        # The length of the tool is in `base` already (poses.with_length).
        rows = [self.letters.index(x) for x in XYZ]
        tip = poses.turned(self.space.matrix, position[rows]) + np.array(self.space.origin)[:, None]
        return poses.slides_at(self.base, tip + self.anchor[:, None], position)

    def deviation(
        self, position: np.ndarray, approach: np.ndarray, direction: int | None = None
    ) -> np.ndarray:
        """(A, N) mm and degrees: actual - commanded, at commands (A, N) of the space; approach as
        Machine.deviation, always whole."""
        slides = self.slides(position)
        off, lean = self.base.carried(slides, approach)
        result = np.zeros(position.shape)
        if self.oriented:
            result[[self.letters.index(x) for x in self.chain.rotary]] = np.degrees(
                self._turns(slides, lean)
            )
        rows = [self.letters.index(x) for x in XYZ]
        result[rows] = poses.turned(self.space.matrix.T, off)
        return result

    def _turns(self, slides: np.ndarray, lean: np.ndarray) -> np.ndarray:
        """(R, N) rad by which the rotary axes seem to be off, as a lean (3, N) rad tells it."""
        #     tool ^   .' as it leans      A turn about the tool itself changes no direction of the
        #          | .'                    tool, so only what of the lean, and of each axis' way,
        #     way  o-->                    lies across the tool is told and asked for.
        ways, tool = poses.axes_of(self.base, slides)
        each = np.stack([_across(tool, way) for way in ways], axis=1)  # (3, R, N)
        # Least squares of each @ turn = lean by singular values: `size` is how far the tool turns
        # by a rad of the axes in the direction that `right` gives. 1 / size would grow beyond all
        # bounds towards a pole; below SOFT the gain falls to 0 with it instead.
        left, size, right = np.linalg.svd(each.transpose(2, 0, 1), full_matrices=False)
        gain = size / np.maximum(size, SOFT) ** 2
        turn: np.ndarray = np.einsum("nij,in->nj", left, _across(tool, lean)) * gain
        bent: np.ndarray = np.einsum("nji,nj->in", right, turn)
        return bent


def _across(tool: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(3, N): what of vectors lies across the directions `tool` (3, N)."""
    across: np.ndarray = vectors - tool * (tool * vectors).sum(axis=0)
    return across


def tool_directions(machine: Machine, slides: np.ndarray, approach: np.ndarray) -> np.ndarray:
    """(3, N) the tool's actual direction in the part, away from it, at commanded slide positions
    (A, N)."""
    tool = poses.axes_of(machine, slides)[1]
    actual: np.ndarray = tool + cross(machine.carried(slides, approach)[1], tool)
    return actual


class TipBounds(Bounds):
    """The same for a machine as the tip sees it: by the slides' own way, which is looked at where
    it bends."""

    machine: TipMachine

    @property
    def _base(self) -> Bounds:
        return self.machine.base.bounds

    @cached_property
    def kink(self) -> float:
        """mm/mm: how much the slope of the deviation can differ between two places, at most."""
        return self._base.kink

    @cached_property
    def steepest(self) -> float:
        """mm/mm: bound of the deviation's change over the way; a degree takes the slides along by
        its arm."""
        # A degree swings the longest arm by arm * pi / 180 mm, and the slides have to go as far.
        # Near a pole an axis turns by 1 / SOFT rad for a rad of lean. At most 0.5: of a bound of 1
        # or more the inverse would never believe that it has come close enough.
        arm = max(self._base.reach(x) for x in self.machine.chain.axes)
        return min(
            self._base.steepest
            * (1 + float(np.radians(arm)))
            / (SOFT if self.machine.oriented else 1.0),
            0.5,
        )

    @property
    def second_order(self) -> float:
        """mm: bound of the products of two errors."""
        return self._base.second_order

    def local(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) kink and (N,) steepness, mm/mm, wherever: boxes of the tip are none of the
        slides."""
        n = low.shape[1]
        return np.full(n, self.kink), np.full(n, self._base.steepest)

    def parts(self, start: np.ndarray, target: np.ndarray, slack: float) -> np.ndarray:
        """(M,) into how many equal parts straight motions (A, M) must be thought cut, so that
        nothing bends by more than `slack` mm within one: nodes that the slides pass by kink times
        their way, the rest by second differences."""
        angle = self.angle(start, target)
        result = np.ones(start.shape[1], np.int64)
        least = -np.inf
        for most, count in SAMPLES:
            which = np.flatnonzero((angle > least) & (angle <= most))
            least = most
            for first in range(0, len(which), 4000):  # so many at a time that memory stays flat
                some = which[first : first + 4000]
                result[some] = self._parts(start[:, some], target[:, some], count, slack)
        return result

    def bends(self, start: np.ndarray, target: np.ndarray, slack: float) -> np.ndarray:
        """(M,) bool: straight motions (A, M) that must be cut in more than one of `parts`."""
        return self.parts(start, target, slack) > 1

    def angle(self, start: np.ndarray, target: np.ndarray) -> np.ndarray:
        """(M,) degrees that a rotary axis turns along straight motions (A, M), at most."""
        turns: np.ndarray = np.abs(target - start)[list(self.machine.base.turning)].max(axis=0)
        return turns

    def _parts(self, start: np.ndarray, target: np.ndarray, count: int, slack: float) -> np.ndarray:
        machine, n = self.machine, start.shape[1]
        t = np.linspace(0.0, 1.0, count)
        places = (start[:, :, None] + (target - start)[:, :, None] * t).reshape(len(start), -1)
        # approach 0, the mean of both sides: where a motion bends, and not which side a slide bears
        # on
        off = machine.deviation(places, np.zeros_like(places)).reshape(len(start), n, count)
        slides = machine.slides(places)[list(machine.chained)].reshape(-1, n, count)
        way = np.abs(np.diff(slides, axis=2)).sum(axis=(0, 2))
        every = np.zeros((2, len(start), n))
        every[:, list(machine.chained)] = slides.min(axis=2), slides.max(axis=2)
        kink, steep = self._base.local(every[0], every[1])
        # Second differences over `count` samples stand for f'' (1 / (count - 1))**2; what curves by
        # f'' leaves its chord by f'' / 8. What slides bend, of which the deviation follows by its
        # steepness, counts alike.
        bend = np.abs(np.diff(off, 2, axis=2)).max(axis=(0, 2)) + steep * np.abs(
            np.diff(slides, 2, axis=2)
        ).max(axis=(0, 2))
        smooth = self._base.bend(every[1] - every[0]) + bend * (count - 1) ** 2 / 8
        # kink * s / 4 per part of length s goes with 1 / parts, what is smooth with 1 / parts**2
        wanted = np.maximum(way * kink / (4 * slack), np.sqrt(smooth / slack))
        parts: np.ndarray = np.clip(np.ceil(wanted), 1, MOST_PARTS).astype(np.int64)
        return parts
