"""Who carries whom: "w-b-Z-X-t" reads workpiece, bed, Z carries X, tool. An axis between w and b carries the workpiece.

Deviation of the tool relative to the workpiece, first order (ISO 230-1, rigid-body kinematics):

    e = sum over axes j of  d_j + eps_j x (r_j - m_j) + c_j x (q_j u_j)

d_j, eps_j: translations and rotations of axis j at its position q_j; r_j: the arm from j's carriage to the tool tip, the
tool plus the positions of the axes between j and the tool (for an axis that carries the workpiece its own as well);
m_j: the same arm where j was measured; c_j: squareness. What is dropped are products of two errors: 100 urad times
100 um is 10 nm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.machine.tables import AxisTable

XYZ = "XYZ"


@dataclass(frozen=True)
class Chain:
    """The parsed chain: axes from the workpiece through the bed to the tool, and how many of them carry the workpiece."""

    axes: tuple[str, ...]
    workpiece_side: int

    def arm(self, letter: str) -> tuple[str, ...]:
        """Axes whose positions make up the arm of `letter`."""
        at = self.axes.index(letter)
        return self.axes[at:] if at < self.workpiece_side else self.axes[at + 1 :]


def parse(text: str) -> Chain:
    """Read "w-X-Y-b-Z-t". Raises ValueError with what is wrong."""
    parts = text.split("-")
    if len(parts) < 3 or parts[0] != "w" or parts[-1] != "t" or parts.count("b") != 1:
        raise ValueError(f"chain {text!r} must begin with w, end with t and hold one b, like w-b-Z-X-t")
    axes = [p for p in parts[1:-1] if p != "b"]
    for axis in axes:
        if axis not in XYZ or len(axis) != 1:
            raise ValueError(f"chain {text!r}: {axis!r} is not one of X Y Z")
    if len(set(axes)) != len(axes):
        raise ValueError(f"chain {text!r} names an axis twice")
    return Chain(tuple(axes), parts.index("b") - 1)


def tip_deviation(
    chain: Chain,
    tables: dict[str, AxisTable],
    square: dict[str, np.ndarray],
    tool: np.ndarray,
    measured: dict[str, np.ndarray],
    position: dict[str, np.ndarray],
    approach: dict[str, np.ndarray],
) -> list[np.ndarray]:
    """Three (N,) columns X Y Z of the deviation in mm.

    square: axis to (3,) rad; tool (3,) mm; measured: axis to (3,) mm, where the others stood; position, approach: axis to
    (N,).
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
        table = tables.get(letter)
        if table is None or not table.rows:
            continue
        parts = table.evaluate(q, approach[letter])
        for i in range(3):
            if parts[i] is not None:
                total[i] += parts[i]
        if parts[3] is None and parts[4] is None and parts[5] is None:
            continue
        arm: list[np.ndarray | float] = list(tool - measured[letter])
        for other in chain.arm(letter):
            arm[XYZ.index(other)] = arm[XYZ.index(other)] + position[other]
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # (eps x arm)_i = eps_j arm_k - eps_k arm_j
            turn, back = parts[3 + j], parts[3 + k]
            if turn is not None:
                total[i] += turn * arm[k]
            if back is not None:
                total[i] -= back * arm[j]
    return total
