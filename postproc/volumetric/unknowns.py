"""The unknown errors of a machine, and what each of them does at a place.

A component is a function of its axis, linear between nodes. What belongs to no machine is taken out
of it: each is zero at the node next to zero, and a straightness has no slope, since a slope is
squareness or the set-up. What is left has its prior: errors of a machine that runs are far below
it, so it decides nothing that readings tell, and holds what they do not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, pairwise

import numpy as np
from scipy.linalg import null_space

from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS, AxisTable

# mm and rad, standard deviations of the prior: ten times what a sound machine has.
LENGTH, ANGLE, SQUARE = 0.1, 3e-4, 1e-3
LEANS = {"XY": "C0Y", "XZ": "B0Z", "YZ": "A0Z"}  # pair of slides to the name of its squareness
ONE = 1.0


@dataclass(frozen=True)
class Group:
    """One error. name: EXX, C0Y, B:X (lost motion), X0C; letter: its axis; row: of the six, or of
    the three rotations; nodes (K,) mm, none of a single number; basis (K, M): its free numbers to
    values at the nodes; prior: mm or rad of one of them."""

    name: str
    letter: str
    row: int
    nodes: np.ndarray
    basis: np.ndarray
    prior: float

    @property
    def size(self) -> int:
        """How many free numbers it has."""
        return self.basis.shape[1]


def _of_slide(machine: Machine, x: str, nodes: dict[str, np.ndarray]) -> Iterator[Group]:
    """The components of one axis; a straightness only along a slide that the machine has."""
    for row, name in enumerate(COMPONENTS):
        across = row < 3 and XYZ[row] != x
        if across and XYZ[row] not in machine.chain.axes:
            continue
        at = nodes.get(f"{name}{x}", nodes[x])
        # Every curve is the free ones of its null space: those that are 0 at the node nearest to
        # zero and, of a straightness, have no slope over the nodes. A constant is the zero of a
        # set-up, a slope of EYX is C0Y, and neither may be found twice.
        fixed = [np.eye(len(at))[int(np.argmin(np.abs(at)))]]
        if across:
            fixed.append((at - at.mean()) / np.abs(at - at.mean()).max())
        free, unit = null_space(np.array(fixed)), LENGTH if row < 3 else ANGLE
        yield Group(f"{name}{x}", x, row, at, free, unit)


def _square_name(machine: Machine, a: str, b: str) -> str:
    """The squareness of two slides, as the machine states it if it does."""
    rotation = ROTARY[3 - XYZ.index(a) - XYZ.index(b)]  # about the third axis
    names = (f"{rotation}0{a}", f"{rotation}0{b}")
    return next((n for n in names if n in machine.square_stated), LEANS[a + b])


def components(
    machine: Machine,
    nodes: dict[str, np.ndarray],
    zero: frozenset[str] = frozenset(),
    two_way: frozenset[str] = frozenset(),
) -> list[Group]:
    """The errors of the slides: six components of each axis on its nodes, squareness of each pair,
    lost motion where both directions were read. nodes: (K,) mm by axis (X), or by component (EYX)
    where that has its own; zero: names that are taken as zero."""
    slides = [x for x in XYZ if x in nodes]
    found = [group for x in slides for group in _of_slide(machine, x, nodes)]
    for a, b in combinations(slides, 2):
        name = _square_name(machine, a, b)
        found.append(Group(name, name[2], ROTARY.index(name[0]), np.zeros(0), np.eye(1), SQUARE))
    for x in sorted(two_way & set(slides)):
        found.append(Group(f"B:{x}", x, XYZ.index(x), np.zeros(0), np.eye(1), LENGTH))
    return [g for g in found if g.name not in zero and g.size]


def locations(machine: Machine, zero: frozenset[str]) -> list[Group]:
    """How the line of each rotary axis lies: two offsets, and two angles (ISO 230-7)."""
    found = []
    for x in machine.chain.rotary:
        # a shift along its own line, or a turn about it, changes nothing about a line
        for i in (i for i in range(3) if i != ROTARY.index(x)):
            found.append(Group(f"{XYZ[i]}0{x}", x, i, np.zeros(0), np.eye(1), 1.0))
            found.append(Group(f"{ROTARY[i]}0{x}", x, 3 + i, np.zeros(0), np.eye(1), SQUARE))
    return [g for g in found if g.name not in zero]


@dataclass(frozen=True)
class Unknowns:
    """All of them on one machine without errors (`bare`), to which what is known already may be
    added (`known`)."""

    groups: tuple[Group, ...]
    bare: Machine
    known: Machine

    @cached_property
    def slices(self) -> list[slice]:
        """Where each group's numbers stand."""
        ends = np.cumsum([0, *(g.size for g in self.groups)])
        return [slice(int(a), int(b)) for a, b in pairwise(ends)]

    @property
    def number(self) -> int:
        """P: of all groups together."""
        return sum(g.size for g in self.groups)

    @cached_property
    def prior(self) -> np.ndarray:
        """(P,) mm and rad: standard deviation of each number."""
        return np.concatenate([np.full(g.size, g.prior) for g in self.groups])

    def columns(self, q: np.ndarray, approach: np.ndarray, tool: np.ndarray) -> np.ndarray:
        """(P, 3, N) mm: what one of each number does at the tip, along X Y Z of the machine (of the
        part where a rotary axis turns it), at slide positions q (A, N), with the tool's point
        `tool` (3,) mm."""
        result = np.zeros((self.number, 3, q.shape[1]))
        for group, where in zip(self.groups, self.slices, strict=True):
            one = _tip_deviation(self._alone(group, tool), q)
            if not len(group.nodes):
                half = (
                    approach[self.bare.letters.index(group.letter)] / 2
                    if group.name.startswith("B:")
                    else ONE
                )
                result[where] = one * half
                continue
            # Linear between nodes: what one node's value does at q is its hat there times what an
            # error of 1 does at the tip, which depends on where all axes stand (the arm).
            hats = _hat_functions(group.nodes, q[self.bare.letters.index(group.letter)])
            result[where] = np.einsum("km,kn,in->min", group.basis, hats, one)
        return result

    def of_axis(self, letter: str, row: int, q: np.ndarray) -> np.ndarray:
        """(P, N): what each number does to one component of an axis itself, as angle optics read
        it."""
        result = np.zeros((self.number, q.shape[1]))
        for group, where in zip(self.groups, self.slices, strict=True):
            if group.letter == letter and group.row == row and len(group.nodes):
                result[where] = group.basis.T @ _hat_functions(
                    group.nodes, q[self.bare.letters.index(letter)]
                )
        return result

    def already(self, q: np.ndarray, approach: np.ndarray, tool: np.ndarray) -> np.ndarray:
        """(3, N) mm: what the known errors do."""
        return _tip_deviation(replace(self.known, tool=tool), q, approach)

    def _alone(self, group: Group, tool: np.ndarray) -> Machine:
        """The machine with one of a group, the same wherever its axis stands."""
        m = replace(self.bare, tool=tool)
        axis = m.axes[group.letter]
        if group.name.startswith("B:") or len(group.nodes):
            both = np.zeros((6, 2))
            both[group.row] = ONE
            low, high = axis.travel
            # 1 mm or 1 rad all along: what it does at the tip is a derivative, exact since the
            # deviation is linear in every error.
            table = AxisTable(group.letter, np.array([min(low, -1e6), max(high, 1e6)]), both, both)
            return replace(m, axes={**m.axes, group.letter: replace(axis, table=table)})
        if group.letter in ROTARY:
            return replace(
                m, axes={**m.axes, group.letter: replace(axis, location=np.eye(6)[group.row])}
            )
        return replace(m, square={group.letter: np.eye(3)[group.row]})


def _hat_functions(nodes: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(K, N): the share of each node at places q (N,)."""
    #     1 .       .       .       hats: each node has 1 at its own place and 0 at all others;
    #       |'.   .'|'.   .'|       they add up to 1 everywhere, also beyond the ends
    #     0 +---'---+---'---+
    return np.array([np.interp(q, nodes, one) for one in np.eye(len(nodes))])


def _tip_deviation(
    machine: Machine, q: np.ndarray, approach: np.ndarray | None = None
) -> np.ndarray:
    """(3, N) mm by which the tip is off."""
    approach = np.zeros_like(q) if approach is None else approach
    if machine.chain.rotary:
        return machine.carried(q, approach)[0]
    return machine.xyz(machine.deviation(q, approach))
