"""In which coordinates the X Y Z of motions are told: slide positions, or places of the tool tip in
the part.

Under tool centre point control (G43.4, TRAORI, M128) words are places of the tip in a frame that
goes with the part, and the control moves the slides so that rotary words leave the tip where it is.
Text and physics share only what is here; where the slides then stand is the machine's affair
(`Kinematics`).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from postproc.records import record

# a turn by nothing: the unit matrix, row by row
LEVEL = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@record
class Space:
    """A frame of the tip's places: the programmed place u (word and work offset, mm) is the place
    turn @ u + origin of the part as it lies with all rotary axes at zero. turn: nine numbers of a
    rotation, row by row; origin: mm; held: whether the control holds the tip while rotary axes
    turn.

    polar: the letter of the second coordinate where X and it are Cartesian coordinates of the face
    that C turns (polar interpolation); it stands in the row of C then, in mm. There heading is
    where C stood at the call, degrees, and `turn` a rotation by it; shift, across: mm, slides X
    and Y that stand on C's line; beside: mm by which Y stands beside its nominal place, as it was
    corrected before."""

    turn: tuple[float, ...] = LEVEL
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    held: bool = True
    polar: str = ""
    heading: float = 0.0
    shift: float = 0.0
    across: float = 0.0
    beside: float = 0.0

    @property
    def matrix(self) -> np.ndarray:
        """(3, 3) `turn`."""
        return np.array(self.turn).reshape(3, 3)

    def of(self, inner: Space) -> Space:
        """The frame of places of `inner` that are told in this one."""
        # u of the inner frame: turn_i u + origin_i is a place of this one, turned and shifted once
        # more
        turn = self.matrix @ inner.matrix
        origin = self.matrix @ np.array(inner.origin) + np.array(self.origin)
        return Space(
            tuple(turn.ravel().tolist()),
            (float(origin[0]), float(origin[1]), float(origin[2])),
            self.held,
        )


class Kinematics(Protocol):
    """What the text layer asks of a machine with rotary axes. Positions (A,) mm and degrees in the
    order of its axes, lengths (A,) mm; a space of None: slide positions."""

    # message and advice: what must be stated before the tip can be followed
    lacking: tuple[str, str] | None
    carrying: tuple[str, ...]  # rotary axes that carry the part
    rotary: tuple[str, ...]
    needs: tuple[int, ...]  # rows on whose positions the tip's place depends
    linear: tuple[int, ...]  # rows of X Y Z
    frame: str  # "zero", "call", or "": as the control does
    planes: str  # the same of tilted planes; "": asked for where it matters
    codes: dict[int, bool]  # M codes that switch the tool point on and off on this machine
    at_start: bool  # whether it is on when a program begins
    face: tuple[int, int] | None  # rows of X and C, where C turns the part under X

    def convert(
        self,
        position: np.ndarray,
        one: tuple[Space | None, np.ndarray],
        other: tuple[Space | None, np.ndarray],
    ) -> np.ndarray:
        """(A,): the place that `position` of the first space and length is in the second."""

    def tool_axis(self, position: np.ndarray) -> np.ndarray:
        """(3,): the tool's direction in the part, away from it."""

    def aligned(self, normal: np.ndarray, position: np.ndarray) -> list[np.ndarray]:
        """Positions (A,) within the travels whose tool has the direction `normal` (3,) of the part;
        that with the shortest way from `position` first."""

    def space_at(self, position: np.ndarray) -> Space:
        """The frame whose axes are the machine's while the rotary axes stand at `position`, and
        that turns with the part from there."""
