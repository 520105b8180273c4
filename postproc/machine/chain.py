"""Who carries whom: "w-b-Z-X-t" reads workpiece, bed, Z carries X, tool. An axis between w and b carries the workpiece.

Deviation of the tool relative to the workpiece, first order (ISO 230-1, rigid-body kinematics):

    e = sum over axes j of  d_j + eps_j x (r_j - m_j) + c_j x (q_j u_j)

d_j, eps_j: translations and rotations of axis j at its position q_j; r_j: the arm from j's carriage to the tool tip, the
tool plus the positions of the axes between j and the tool (for an axis that carries the workpiece its own as well);
m_j: the same arm where j was measured; c_j: squareness. Rotary axes: rotary.py. What is dropped are products of two errors: 100 urad times
100 um is 10 nm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

XYZ, ROTARY = "XYZ", "ABC"
OPTICS = ("tool", "workpiece")
Parts = list[np.ndarray | None]  # six (N,) columns of one axis' deviations, None: zero everywhere


@dataclass(frozen=True)
class Chain:
    """The parsed chain: axes from the workpiece through the bed to the tool, and how many of them carry the workpiece."""

    axes: tuple[str, ...]
    workpiece_side: int

    @property
    def rotary(self) -> tuple[str, ...]:
        """Rotary axes that the chain names."""
        return tuple(x for x in self.axes if x in ROTARY)

    def side(self, letter: str) -> str:
        """ "workpiece" for an axis that carries the workpiece, else "tool"."""
        return "workpiece" if self.axes.index(letter) < self.workpiece_side else "tool"

    def arm(self, letter: str, optic: str = "") -> tuple[str, ...]:
        """Linear axes whose positions make up the arm of `letter`.

        optic: what the measured point was fixed to, if not to the side that the axis carries. A point fixed to the tool
        goes along with it, so the axis' own position is no part of the arm; one fixed to the workpiece stays behind.
        """
        at = self.axes.index(letter)
        own = (optic or self.side(letter)) == "workpiece"
        return tuple(x for x in self.axes[at if own else at + 1 :] if x in XYZ)


def parse(text: str) -> Chain:
    """Read "w-X-Y-b-Z-t" or "w-C-A-b-X-Y-Z-t". Raises ValueError with what is wrong."""
    parts = text.split("-")
    if len(parts) < 3 or parts[0] != "w" or parts[-1] != "t" or parts.count("b") != 1:
        raise ValueError(f"chain {text!r} must begin with w, end with t and hold one b, like w-b-Z-X-t")
    axes = [p for p in parts[1:-1] if p != "b"]
    for axis in axes:
        if axis not in XYZ + ROTARY or len(axis) != 1:
            raise ValueError(f"chain {text!r}: {axis!r} is not one of X Y Z A B C")
    if len(set(axes)) != len(axes):
        raise ValueError(f"chain {text!r} names an axis twice")
    if sum(x in ROTARY for x in axes) > 2:
        raise ValueError(f"chain {text!r} has more than two rotary axes")
    return Chain(tuple(axes), parts.index("b") - 1)


def tip_deviation(
    chain: Chain,
    parts: dict[str, Parts],
    square: dict[str, np.ndarray],
    tool: np.ndarray,
    measured: dict[str, np.ndarray],
    optic: dict[str, str],
    position: dict[str, np.ndarray],
) -> list[np.ndarray]:
    """Three (N,) columns X Y Z of the deviation in mm, of a chain without rotary axes.

    parts: axis to its six deviations at its position; square: axis to (3,) rad; tool (3,) mm; measured: axis to (3,) mm,
    where the others stood; optic: axis to what the measured point was fixed to; position: axis to (N,) mm.
    """
    n = len(next(iter(position.values())))
    total: list[np.ndarray] = [np.zeros(n) for _ in XYZ]
    for letter in chain.axes:
        own = XYZ.index(letter)
        q = position[letter]
        lean = square.get(letter)
        if lean is not None:
            for k, across in ((1, 2), (2, 1)):  # c x (q u): the component across rotates into the other
                i, j = (own + k) % 3, (own + across) % 3
                sign = 1.0 if k == 1 else -1.0
                if lean[j]:
                    total[i] += sign * lean[j] * q
        part = parts.get(letter)
        if part is None:
            continue
        for i in range(3):
            if part[i] is not None:
                total[i] += part[i]
        if part[3] is None and part[4] is None and part[5] is None:
            continue
        arm: list[np.ndarray | float] = list(tool - measured[letter])
        for other in chain.arm(letter, optic.get(letter, "")):
            arm[XYZ.index(other)] = arm[XYZ.index(other)] + position[other]
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # (eps x arm)_i = eps_j arm_k - eps_k arm_j
            turn, back = part[3 + j], part[3 + k]
            if turn is not None:
                total[i] += turn * arm[k]
            if back is not None:
                total[i] -= back * arm[j]
    return total
