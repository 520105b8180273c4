"""Readings of one set-up as rows of a residual, model less reading, with their slopes.

Each kind has nuisances of its own, which belong to the set-up: six of a free frame (a tracker
stands where it stands), three and a dead path of a station, a zero of every line, a zero and a
slope of every straightness, the place of a sphere on its table.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from postproc.machine.model import Machine
from postproc.machine.poses import tips
from postproc.machine.rotary import rotation
from postproc.units import UM, URAD
from postproc.volumetric import step_diagonals
from postproc.volumetric.unknowns import Unknowns

SAME = 1e-3  # mm


@dataclass(frozen=True)
class Rows:
    """N readings of one set-up. kind: cloud, shift, length, line, stair, straightness, angle,
    sphere; q, approach (A, N); value: mm, of clouds and shifts (3, N), else (N,); u: mm or rad,
    nan: not stated; tool (3,) mm; along (3,): direction of lines; letter, row: of angles; aside (3,
    N) mm: of stairs, from their line; start: nuisances to begin with; loose: 1/mm, by how much each
    is held there, nothing: not at all; name: of the file; alike: how many readings beside each
    other are off by the same, so that they tell no more than one."""

    kind: str
    q: np.ndarray
    approach: np.ndarray
    value: np.ndarray
    u: float
    tool: np.ndarray
    start: np.ndarray
    name: str
    along: np.ndarray
    letter: str = ""
    row: int = 0
    aside: np.ndarray = field(default_factory=lambda: np.zeros((3, 0)))
    loose: np.ndarray = field(default_factory=lambda: np.zeros(0))
    alike: float = 1.0

    @property
    def counted(self) -> float:
        """mm or rad: the u with which each reading counts, so that `alike` of them make one."""
        return self.u * float(np.sqrt(self.alike))

    def __len__(self) -> int:
        return self.value.size

    def residual(
        self, off: np.ndarray, own: np.ndarray, nominal: np.ndarray, angle: np.ndarray
    ) -> np.ndarray:
        """(R,) mm or rad: model less reading. off (3, N) mm at the tip; own: nuisances; nominal (3,
        N) mm: of the tip; angle (N,) rad."""
        if self.kind == "cloud":
            # a cloud: the tracker's frame, turned and shifted (own), must meet the places of the
            # tip
            return (nominal + off - _turn(own[:3]) @ self.value - own[3:, None]).ravel()
        if self.kind == "shift":
            return (off + own[:, None] - self.value).ravel()
        if self.kind == "sphere":
            return (nominal + off - own[:, None]).ravel()
        if self.kind == "length":
            # a length: |tip - station| + dead path
            return np.linalg.norm(nominal + off - own[:3, None], axis=0) + own[3] - self.value
        if self.kind == "angle":
            return angle + own[0] - self.value
        # line, straightness, stair: along the beam or across it, with the set-up's zero and its
        # further numbers
        return self.along @ off + own[0] - self.value + own[1:] @ self._more

    def slopes(
        self,
        columns: np.ndarray,
        off: np.ndarray,
        own: np.ndarray,
        nominal: np.ndarray,
        angles: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """(R, P) by the unknowns, whose columns (P, 3, N) act at the tip, and (R, M) by the
        nuisances."""
        n = self.q.shape[1]
        if self.kind in ("cloud", "shift", "sphere"):
            by = columns.reshape(len(columns), -1).T
            if self.kind == "cloud":
                # by central differences: 1e-7 rad of a turn vector; the error goes with its square
                each = 1e-7
                turned = [
                    (_turn(own[:3] + each * e) - _turn(own[:3] - each * e))
                    @ self.value
                    / (2 * each)
                    for e in np.eye(3)
                ]
                more = [-t.ravel() for t in turned] + [-np.repeat(e, n) for e in np.eye(3)]
                return by, np.array(more).T
            sign = 1.0 if self.kind == "shift" else -1.0
            return by, sign * np.array([np.repeat(e, n) for e in np.eye(3)]).T
        if self.kind == "length":
            away = nominal + off - own[:3, None]
            # to first order a length changes by what of a displacement lies along it
            way = away / np.linalg.norm(away, axis=0)
            return np.einsum("pin,in->np", columns, way), np.vstack([-way, np.ones(n)]).T
        if self.kind == "angle":
            return angles.T, np.ones((n, 1))
        by = np.einsum("pin,i->np", columns, self.along)
        return by, np.vstack([np.ones(n), self._more]).T

    @property
    def _more(self) -> np.ndarray:
        """(M, N): what the set-up adds by its own numbers, beyond its zero: a slope of a
        straightness, mm per turn of (-1 to 1); of a stair the motions aside, mm, which a mirror's
        lean is times."""
        if self.kind == "straightness":
            return self._way[None]
        if self.kind == "stair":
            return step_diagonals.across(self.aside) @ self.aside
        return np.zeros((0, self.q.shape[1]))

    @property
    def _way(self) -> np.ndarray:
        """(N,) from -1 to 1 along the motion of a straightness."""
        moved = self.q[int(np.argmax(np.ptp(self.q, axis=1)))]
        # of the order of 1, so that the slope's number is mm, as the zero's is
        return 2 * (moved - moved.mean()) / max(float(np.ptp(moved)), SAME)


def nominal_tip(machine: Machine, q: np.ndarray, tool: np.ndarray) -> np.ndarray:
    """(3, N) mm: where the tip is without errors, in the part where rotary axes turn it."""
    if machine.chain.rotary:
        return tips(replace(machine, tool=tool), q)
    return machine.xyz(q) + tool[:, None]


def to_machine(machine: Machine, q: np.ndarray) -> np.ndarray:
    """(3, 3, N): directions of the part to those of the machine, where rotary axes carry the
    part."""
    turn = np.repeat(np.eye(3)[:, :, None], q.shape[1], axis=2)
    for x in machine.chain.rotary:
        if machine.chain.side(x) == "workpiece":
            turn = np.einsum(
                "ijn,jkn->ikn", turn, rotation(x, np.radians(q[machine.letters.index(x)]))
            )
    return turn.transpose(1, 0, 2)


def _turn(vector: np.ndarray) -> np.ndarray:
    """(3, 3) of a rotation vector (3,) rad (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0:
        return np.eye(3)
    k = vector / angle
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)


def angle_columns(unknowns: Unknowns, rows: Rows) -> np.ndarray:
    """(P, N) of angles, nothing of other kinds."""
    if rows.kind != "angle":
        return np.zeros((unknowns.number, 0))
    return unknowns.of_axis(rows.letter, rows.row, rows.q)


def unit_of(rows: Rows) -> float:
    """mm or rad of one unit of these readings, as told to a person."""
    return URAD if rows.kind == "angle" else UM
