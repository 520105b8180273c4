"""A calibration: which components there are, what they are, what was left out, what looks wrong."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from postproc.calibrate import Finding, Options
from postproc.calibrate.assign import Diagonal
from postproc.calibrate.component import Component
from postproc.calibrate.outliers import Outlier
from postproc.calibrate.square import Squareness
from postproc.errors import GcompError
from postproc.machine.axis import Axis
from postproc.machine.chain import XYZ
from postproc.machine.lacks import lacks
from postproc.machine.model import Machine
from postproc.machine.stated import Limits
from postproc.machine.tables import COMPONENTS, AxisTable
from postproc.recordings import Recording


@dataclass(frozen=True)
class Calibration:
    """components: those that are written, by name; left_out: the others with the reason ("range",
    "noise"); refused: recordings that fit nothing, with why; measured_at: axis to other axis to mm;
    optics: axis to "", tool or workpiece.
    """

    options: Options
    components: dict[str, Component]
    left_out: list[tuple[Component, str]]
    refused: list[GcompError]
    outliers: list[Outlier]
    diagonals: list[Diagonal]
    measured_at: dict[str, dict[str, float]]
    optics: dict[str, str]
    circles: list[Recording] = field(default_factory=list)
    squareness: dict[str, Squareness] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)

    @property
    def measured(self) -> dict[str, Component]:
        """All components that were measured, written or not."""
        return self.components | {c.name: c for c, _ in self.left_out}

    def axes(self) -> list[str]:
        """Axes of the chain that have a component to be written."""
        return [
            x
            for x in self.options.chain.axes
            if any(c.letter == x for c in self.components.values())
        ]

    def of(self, letter: str) -> list[Component]:
        """Components of an axis that are written, in the order of a table."""
        mine = [c for c in self.components.values() if c.letter == letter]
        return sorted(mine, key=lambda c: COMPONENTS.index(c.name[:2]))

    def nodes(self, letter: str) -> np.ndarray:
        """(K,) all targets of the axis' components: each is linear between its own, so nothing is
        lost."""
        return np.unique(np.concatenate([c.nodes for c in self.of(letter)]))

    def values(self, component: Component) -> np.ndarray:
        """(2, K) of a component at all nodes of its axis, held beyond its own."""
        value = np.tile(component.mean, (2, 1)) if self.options.mean else component.value
        return np.stack(
            [np.interp(self.nodes(component.letter), component.nodes, v) for v in value]
        )

    def two_way(self, component: Component) -> bool:
        """Whether a component is written with a column for each direction."""
        return component.two_way and not self.options.mean

    def travel(self, letter: str) -> tuple[float, float]:
        """mm: as stated, else from the first target to the last."""
        if letter in self.options.travel:
            return self.options.travel[letter]
        nodes = [c.nodes for c in self.measured.values() if c.letter == letter]
        # of those that were measured, also where they are left out as small
        return (min(n[0] for n in nodes), max(n[-1] for n in nodes)) if nodes else (0.0, 1.0)

    @cached_property
    def machine(self) -> Machine:
        """The machine that the components make, without squareness."""
        axes = {}
        for x in sorted(self.options.chain.axes, key=(XYZ + "ABC").index):
            table = None
            if x in self.axes():
                both = np.zeros((2, 6, len(self.nodes(x))))
                for component in self.of(x):
                    # held beyond a component's own targets, as the machine will hold its tables
                    both[:, COMPONENTS.index(component.name[:2])] = self.values(component)
                stated = tuple(COMPONENTS.index(c.name[:2]) for c in self.of(x))
                table = AxisTable(x, self.nodes(x), both[0], both[1], stated)
            at = np.array([self.measured_at.get(x, {}).get(i, 0.0) for i in XYZ])
            small = tuple(c.name for c, _ in self.left_out if c.letter == x)
            axes[x] = Axis(
                x, self.travel(x), 1e-4, at, table, self.optics.get(x, ""), left_out=small
            )
        return Machine(
            "", "", "", self.options.chain, axes, tool=np.array(self.options.point),
            limits=Limits(outside=self.options.outside), signs="unverified",
        )  # fmt: skip

    @property
    def lacks(self) -> list[str]:
        """What the machine to be written does not hold, in words."""
        return lacks(replace(self.machine, square_stated=tuple(self.squareness)))
