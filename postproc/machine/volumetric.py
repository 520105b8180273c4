"""A whole machine as volumetric formats hold it: components over one axis or two, squareness, the
order of the axes.

Such formats say neither where an axis was measured nor with what tool. Both only shift the point at
which a rotation acts by a constant, so they are moved into the translations: eps x (tool -
measured_at + arm) = eps x (tool - measured_at) + eps x arm, node by node and exactly, because both
are linear between the same nodes. What is left counts its arms from the machine's zero with tool
length zero, and gives the same deviation as the machine.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from postproc.errors import MachineError
from postproc.machine.axis import Axis
from postproc.machine.chain import ROTARY, SECOND, XYZ, Chain
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS, AxisTable, GridTable


@dataclass(frozen=True)
class VolumetricMap:
    """axes: letter to its six components over its own position; grids: what depends on a second
    axis, added to them;
    square: name (rotation, 0, axis that leans: "B0Z") to rad, right-handed, so the axis q u leans
    by angle x (q u); chain: linear axes from the workpiece to the tool; workpiece_axes: how many of
    them, from the first, carry the workpiece;
    notices: what a file held that is not here."""

    axes: dict[str, AxisTable]
    grids: tuple[GridTable, ...] = ()
    square: dict[str, float] = field(default_factory=dict)
    chain: tuple[str, ...] = ("X", "Y", "Z")
    workpiece_axes: int = 0
    notices: tuple[str, ...] = ()

    @property
    def two_way(self) -> bool:
        """Whether any component depends on the direction of approach."""
        return any(t.two_way for t in self.axes.values()) or any(g.two_way for g in self.grids)

    def one_way(self) -> VolumetricMap:
        """The mean of both directions."""
        axes = {x: replace(t, forward=t.mean, reverse=t.mean) for x, t in self.axes.items()}
        grids = tuple(replace(g, forward=g.mean, reverse=g.mean) for g in self.grids)
        return replace(self, axes=axes, grids=grids)

    def _ends(self, x: str) -> tuple[float, float]:
        """mm: as far as the tables of an axis go, and the grids by it."""
        own = [t.nodes for t in (self.axes.get(x),) if t is not None]
        own += [g.nodes for g in self.grids if g.letter == x]
        reach = own + [g.others for g in self.grids if g.other == x]
        # without any table any travel will do: nothing depends on it
        return (min(n[0] for n in reach), max(n[-1] for n in reach)) if reach else (-1.0, 1.0)

    def machine(
        self, travel: dict[str, tuple[float, float]] | None = None, name: str = "map"
    ) -> Machine:
        """The machine of this map: measured at zero, tool length zero. travel: mm, else as far as
        the tables go."""
        axes = {}
        for x in sorted(self.chain):
            table = self.axes.get(x)
            grids = tuple(g for g in self.grids if g.letter == x)
            low, high = (travel or {}).get(x, self._ends(x))
            axes[x] = Axis(x, (float(low), float(high)), 1e-4, np.zeros(3), table, grids=grids)
        lean: dict[str, np.ndarray] = {}
        for key, angle in self.square.items():
            # "B0Z": the letter of the turn, 0, and the axis that leans
            lean.setdefault(key[2], np.zeros(3))[ROTARY.index(key[0])] += angle
        chain = Chain(self.chain, self.workpiece_axes)
        return Machine(name=name, title="", control="", chain=chain, axes=axes, square=lean)


def of_machine(machine: Machine) -> tuple[VolumetricMap, dict[str, float]]:
    """The machine's map, and what of it is not exact: component to mm, between nodes.

    Only an axis whose measured point went along with the other side than the axis carries
    (Axis.optic) is not exact there: its own position times its rotation bends between nodes. Raises
    MachineError for a chain with rotary axes. Growth with temperature and effects are not part of a
    map: a notice names them.
    """
    _refuse(machine)
    axes: dict[str, AxisTable] = {}
    grids: list[GridTable] = []
    left: dict[str, float] = {}
    for x in machine.chain.axes:
        axis = machine.axes[x]
        # (3,) mm: what of every arm of this axis stays, whatever the slides do
        offset = machine.tool - machine.measured[x]
        # 1, 0 or -1: its own position is in the arm that its optic had and the axis has not, or the
        # other way round
        #     optic      axis carries   arm has its own position   written arm has it   own
        #     tool       tool           no                         no                    0
        #     workpiece  tool           yes                        no                   +1
        #     tool       workpiece      no                         yes                  -1
        own = (x in machine.chain.arm(x, axis.optic)) - (x in machine.chain.arm(x))
        for table in (axis.table, *axis.grids):
            if table is None or not table.rows:
                continue
            # nodes against (6, K) as (K,), against the (6, K, L) of a grid as (K, 1)
            shape = (-1,) + (1,) * (table.forward.ndim - 2)
            forward, reverse = (
                _moved(v, offset, own, x, table.nodes.reshape(shape))
                for v in (table.forward, table.reverse)
            )
            if isinstance(table, GridTable):
                grids.append(replace(table, forward=forward, reverse=reverse))
            else:
                axes[x] = replace(table, forward=forward, reverse=reverse)
            # exact at the nodes; between them rotation times own position is a parabola, and a
            # table a chord
            if own:
                add(left, _bend(table, x))
    chain, angles, notices = machine.chain, machine.angles, _unwritten(machine)
    return (
        VolumetricMap(axes, tuple(grids), angles, chain.axes, chain.workpiece_side, notices),
        left,
    )


def _refuse(machine: Machine) -> None:
    """Raises MachineError for axes that no map is written of."""
    if machine.chain.rotary:
        raise MachineError(
            f"{machine.name} has rotary axes ({' '.join(machine.chain.rotary)})",
            "volumetric tables are written for chains of linear axes only",
        )
    if second := [x for x in machine.chain.axes if x in SECOND.values()]:
        raise MachineError(
            f"{machine.name} has second slides ({' '.join(second)})",
            "volumetric tables are written for chains of X Y Z only",
        )


def _unwritten(machine: Machine) -> tuple[str, ...]:
    """Notices of what a map can not hold, and of a tool whose length is in it."""
    notices = [f"growth of {x} with temperature is not written" for x in machine.expansions]
    notices += [f"effect {term.name} of {term.axis} is not written" for term in machine.effects]
    if machine.tool.any() and machine.turns:
        at = ", ".join(f"{v:g}" for v in machine.tool)
        notices.append(
            f"the tool of the machine's file ({at} mm) is part of the translations: a longer one"
            " counts from there"
        )
    return tuple(notices)


def directions(machine: Machine, found: VolumetricMap) -> dict[str, float]:
    """Component to mm: by how much the tool stays off where only the mean of both directions is
    written; a rotation at its longest arm within the machine's travel."""
    left: dict[str, float] = {}
    tables: list[AxisTable | GridTable] = [*found.axes.values(), *found.grids]
    for table in tables:
        half = np.abs(table.forward - table.reverse).reshape(6, -1).max(axis=1) / 2
        # at tool length zero, as the map is written: a longer tool would add to the arm
        arm = [max(abs(t) for t in machine.axes[x].travel) for x in machine.chain.arm(table.letter)]
        reach = float(np.linalg.norm(arm)) if arm else 0.0
        sizes = {
            f"{COMPONENTS[i]}{table.letter}": float(h * (1.0 if i < 3 else reach))
            for i, h in enumerate(half)
            if h
        }
        add(left, sizes)
    return left


def merged(
    letter: str, components: Iterable[tuple[int, np.ndarray, np.ndarray, np.ndarray]]
) -> AxisTable:
    """One axis' table from components with nodes of their own: (row, nodes (K,) mm, forward,
    reverse (K,)) each."""
    parts = list(components)
    nodes = np.unique(np.concatenate([nodes for _, nodes, _, _ in parts]))
    forward, reverse = np.zeros((6, len(nodes))), np.zeros((6, len(nodes)))
    for row, own, up, down in parts:
        # Exact: every component is linear between its own nodes, which are all among the common
        # ones; np.interp holds the ends, as our tables do.
        forward[row], reverse[row] = np.interp(nodes, own, up), np.interp(nodes, own, down)
    return AxisTable(letter, nodes, forward, reverse)


def _moved(
    value: np.ndarray, offset: np.ndarray, own: int, letter: str, nodes: np.ndarray
) -> np.ndarray:
    """(6, K) or (6, K, L): rotations unchanged, translations with rotation x offset added."""
    arm: list[np.ndarray | float] = [float(a) for a in offset]
    arm[XYZ.index(letter)] = arm[XYZ.index(letter)] + own * nodes
    result = value.copy()
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # the cross product, row by row
        result[i] += value[3 + j] * arm[k] - value[3 + k] * arm[j]
    return result


def _bend(table: AxisTable | GridTable, letter: str) -> dict[str, float]:
    """Component to mm: a product of two straight lines misses its chord by at most a quarter of
    both rises."""
    # (a + s da) (b + s db) lies s (1 - s) da db beside its chord: in the middle, a quarter
    both = np.stack([table.forward, table.reverse])[:, 3:]
    gaps = np.diff(table.nodes).reshape((-1,) + (1,) * (table.forward.ndim - 2))
    rise = (np.abs(np.diff(both, axis=2)) * gaps).reshape(2, 3, -1).max(axis=(0, 2)) / 4
    own = XYZ.index(letter)
    found = {}
    for i in range(3):
        if i != own and (size := float(rise[3 - own - i])):
            found[f"{COMPONENTS[i]}{letter}"] = size
    return found


def add(total: dict[str, float], more: dict[str, float]) -> None:
    """Sum of sizes by name, in place."""
    for name, value in more.items():
        total[name] = total.get(name, 0.0) + value
