"""Where the tool tip is on a machine with errors, by exact homogeneous transforms: any chain,
rotary axes too.

Imports nothing of the product. One pose at a time, errors as plain numbers for that pose; nothing
that is small is dropped. Read from the workpiece to the tool every axis is a 4 x 4 motion of what
follows; its errors are another beside it: towards the tool of a slide that carries the tool,
towards the workpiece of a slide that carries the workpiece, and of a rotary axis always on the side
that does not turn with it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tests.reference.machine import UNIT, rotation, translation

TURN = {"A": UNIT["X"], "B": UNIT["Y"], "C": UNIT["Z"]}
ZERO = np.zeros(3)


@dataclass
class Link:
    """One axis at one pose. q: mm or degrees; d mm, eps rad: its errors there; shift mm, lean rad:
    how its line lies beside the nominal one; measured, centre mm; fixed_to: what the measured point
    was fixed to."""

    letter: str
    side: str
    q: float
    d: np.ndarray = field(default_factory=lambda: ZERO)
    eps: np.ndarray = field(default_factory=lambda: ZERO)
    shift: np.ndarray = field(default_factory=lambda: ZERO)
    lean: np.ndarray = field(default_factory=lambda: ZERO)
    measured: np.ndarray = field(default_factory=lambda: ZERO)
    centre: np.ndarray = field(default_factory=lambda: ZERO)
    fixed_to: str = ""

    def motion(self, scale: float) -> np.ndarray:
        """4 x 4 of this axis with its errors times `scale`."""
        if self.letter in UNIT:
            way = UNIT[self.letter] * self.q
            if scale == 0.0:
                return translation(way)
            nominal = translation((rotation(scale * self.lean) @ np.append(way, 1.0))[:3])
            # The point about which it was measured, in the frame in which the errors act.
            own = self.fixed_to or self.side
            point = self.measured.copy()
            if self.side == "tool" and own == "workpiece":
                point = point - way
            if self.side == "workpiece" and own == "tool":
                point = point + way
            errors = self._errors(point, scale)
            return nominal @ errors if self.side == "tool" else errors @ nominal
        about = turned(np.radians(self.q) * TURN[self.letter], self.centre)
        if scale == 0.0:
            return about
        beside = turned(scale * self.lean, self.centre, scale * self.shift)
        nominal = beside @ about @ np.linalg.inv(beside)
        errors = self._errors(self.centre + self.measured, scale)
        return errors @ nominal if self.side == "tool" else nominal @ errors

    def _errors(self, point: np.ndarray, scale: float) -> np.ndarray:
        return turned(scale * self.eps, point, scale * self.d)


def turned(vector: np.ndarray, centre: np.ndarray, shift: np.ndarray = ZERO) -> np.ndarray:
    """4 x 4: a turn of `vector`, rad, about a centre, and a shift behind it; mm."""
    matrix = rotation(vector)
    matrix[:3, 3] = centre + shift - matrix[:3, :3] @ centre
    return matrix


def tip(links: list[Link], tool: np.ndarray, scale: float) -> np.ndarray:
    """(3,) mm: the tool tip in the workpiece's frame; links from the workpiece to the tool; scale 0
    is nominal."""
    chain = np.eye(4)
    for link in links:
        chain = chain @ link.motion(scale)
    return (chain @ np.append(tool, 1.0))[:3]
