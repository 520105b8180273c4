"""A turning centre as polar interpolation sees it: its deviation along the coordinates of the face.

The words are places of the part, which C turns, so what X, Y and C together miss by is told along
both of them: what lies along X goes outwards from C's line, what lies across goes along with C. The
nearer to that line, the faster both turn: from NEAREST on nothing is corrected.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from postproc.machine import face, poses
from postproc.machine.bounds import Bounds
from postproc.machine.tip import TipBounds, TipMachine
from postproc.records import record

NEAREST = 1.0  # mm from C's line: a deviation of 0.05 mm changes by 0.05 mm per mm of way there
BEYOND = 1.5  # of a deviation at the ends of a box, which it may reach within


@record
class PolarMachine(TipMachine):
    """The machine `base`, with the tool in its spindle, in a space of polar interpolation."""

    @cached_property
    def corrected(self) -> tuple[int, ...]:
        """Rows of X and of the second coordinate, and Z."""
        return tuple(i for i, x in enumerate(self.letters) if x in "XZC" and x in self.chain.axes)

    @cached_property
    def direct(self) -> np.ndarray:
        """(A,) bool: Z."""
        return np.array([x == "Z" for x in self.letters])

    @cached_property
    def turning(self) -> tuple[int, ...]:
        """Rows whose places are angles."""
        return tuple(i for i in self.base.turning if self.letters[i] != "C")

    @cached_property
    def bounds(self) -> Bounds:
        """How far the deviation can bend and change."""
        return PolarBounds(self)

    def slides(self, position: np.ndarray) -> np.ndarray:
        """(A, N) slide positions, mm and degrees, at commands (A, N) of the face."""
        known = self.base.ranges.get("C", face.ANY)
        return face.slides_of(self.letters, self.space, position, known)

    def deviation(
        self, position: np.ndarray, approach: np.ndarray, direction: int | None = None
    ) -> np.ndarray:
        """(A, N) mm: actual - commanded, at commands (A, N) of the face."""
        slides = self.slides(position)
        off = poses.turned(self.space.matrix.T, self.base.carried(slides, approach)[0])
        if "Y" in self.letters:  # the control takes it to stand on C's line
            # It sends X to hypot(x, c). A tool that stands `aside` along Y is as far off across:
            # along (-c, x) / hypot(x, c), a quarter turn ahead of the place (x, c).
            aside = slides[self.letters.index("Y")] - self.space.across
            x, c = (position[self.letters.index(letter)] for letter in "XC")
            # On C's line that is no direction, and no tool comes there.
            far = np.hypot(x, c)
            off[:2] += aside * np.stack([-c, x]) / np.where(far > 0, far, 1.0)
        result = np.zeros(position.shape)
        for letter, row in zip("XCZ", off, strict=True):
            if letter in self.letters:
                result[self.letters.index(letter)] = row
        return result


class PolarBounds(TipBounds):
    """The same for a machine as polar interpolation sees it: what is off turns with the face."""

    machine: PolarMachine

    @cached_property
    def steepest(self) -> float:
        """mm/mm: bound of the deviation's change over the way."""
        return min(self._base.steepest * (1 + np.pi / 180) + 0.1, 0.5)

    def local(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) kink and (N,) steepness, mm/mm, in boxes of the face: the slides' own, and a vector
        of the largest size found at their corners that turns once around C's line."""
        kink, steep = super().local(low, high)
        size = np.zeros(low.shape[1])
        still = np.zeros_like(low)
        # two corners and the middle are looked at; what is larger in between BEYOND allows for
        for place in (low, high, (low + high) / 2):
            off = self.machine.deviation(place, still)
            size = np.maximum(size, BEYOND * np.linalg.norm(off, axis=0))
        rows = [self.machine.letters.index(x) for x in "XC"]
        # A box that holds a coordinate's zero is 0 from it in that coordinate; else the nearer of
        # its edges counts. So `near` is the box' least distance from C's line.
        near = np.hypot(*(np.maximum(np.maximum(low[r], -high[r]), 0.0) for r in rows))
        turns = size / np.maximum(near, NEAREST)
        # A vector of size e that turns once around the line changes by e / r per mm at radius r; a
        # chord through it misses as if the slope differed by twice that.
        return kink + 2 * turns, steep + turns

    def angle(self, start: np.ndarray, target: np.ndarray) -> np.ndarray:
        """(M,) degrees that C turns along straight motions (A, M)."""
        x, c = (self.machine.letters.index(letter) for letter in "XC")
        # The angle between both ends seen from C's line, below half a turn: a line that does not go
        # through it turns C by less than that. Rows are x + i y.
        one, two = start[x] + 1j * start[c], target[x] + 1j * target[c]
        swept: np.ndarray = np.abs(np.degrees(np.angle(two * np.conj(one))))
        return swept
