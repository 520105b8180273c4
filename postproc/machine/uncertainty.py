"""How well the map itself is known, carried to where the tool is: U of the deviation, 95 %.

Law of propagation of uncertainty, first order (JCGM 100, 5.1.2): the deviation is linear in every
error, so what the U of one error makes of it is the deviation of a machine that has this error
alone, U in size (chain.py, rotary.py: the same arms). Those parts are summed in quadrature for each
direction. Taken as independent: components of the tables, angles of squareness, parameters of
effects. Along one component, and between its two directions of approach, the errors are taken as
fully correlated, so that U between nodes is linear between theirs, which is never too small.

All that a folder states is U with k = 2, and so is the result. What it does not state has no part
in it, and is named.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.machine.axis import Axis
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS, only
from postproc.units import UM


class MapUncertainty:
    """U of one machine's map. parts: name of an error to the machine that has it alone, with the
    size of its U; missing: names of the errors that the map corrects and whose uncertainty nobody
    states."""

    def __init__(self, machine: Machine):
        self.machine = machine
        self.parts = _parts(machine)
        self.missing = tuple(name for name in _errors(machine) if name not in self.parts)
        self.turns = any(part.turns for part in self.parts.values())

    def expanded(self, position: np.ndarray, approach: np.ndarray) -> np.ndarray:
        """(A, N) mm: U of Machine.deviation at commanded slide positions (A, N) mm, approach as
        there; zero where nothing is stated."""
        square = np.zeros(position.shape)
        for part in self.parts.values():
            # Independent errors: squares add (JCGM 100, 5.1.2). The sign of a part means nothing,
            # so that U may stand in a table as if it were a deviation.
            square += part.deviation(position, approach) ** 2
        return np.sqrt(square)

    def length(self, position: np.ndarray, approach: np.ndarray) -> np.ndarray:
        """(N,) mm: that of the vector of U over the corrected axes. In no direction is the
        deviation known worse."""
        rows = list(self.machine.corrected)
        joint: np.ndarray = np.sqrt((self.expanded(position, approach)[rows] ** 2).sum(axis=0))
        return joint

    def with_tool(self, length: tuple[float, float, float]) -> MapUncertainty:
        """The same with a tool of this length, as Machine.with_tool."""
        return MapUncertainty(self.machine.with_tool(length))


class AlongPath:
    """The largest U along a program. largest: mm; line: of the program, 0 where nothing was
    seen."""

    def __init__(self, machine: Machine):
        self.known = MapUncertainty(machine)
        self.with_tool = {(0.0, 0.0, 0.0): self.known}
        self.largest, self.line = 0.0, 0

    def see(
        self, position: np.ndarray, approach: np.ndarray, tool: np.ndarray, line: np.ndarray
    ) -> None:
        """Places (A, N) mm, the tool's length there (A, N) mm, and the line of each. Of equal ones
        the first line counts, in whatever portions they come."""
        # nothing is stated: an U of zero would be a figure, and a wrong one
        if not len(line) or not self.known.parts:
            return
        u = self.at(position, approach, tool)
        largest = float(u.max())
        first = int(line[u == largest].min())
        if self.line == 0 or largest > self.largest:
            self.largest, self.line = largest, first

    def at(self, position: np.ndarray, approach: np.ndarray, tool: np.ndarray) -> np.ndarray:
        """(N,) mm: U at places, as in `see`."""
        # in programs of several tools each has its own arms, and so its own machines
        u = np.zeros(position.shape[1])
        # Where no rotation is uncertain the tool is no arm of anything: one length stands for all.
        # a machine for each tool length would be built anew: a program has few of them
        lengths, which = np.unique(
            tool if self.known.turns else 0.0 * tool, axis=1, return_inverse=True
        )
        for k, length in enumerate(lengths.T):
            of = which.ravel() == k
            u[of] = self._with(length).length(position[:, of], approach[:, of])
        return u

    def _with(self, tool: np.ndarray) -> MapUncertainty:
        x, y, z = self.known.machine.xyz(tool).tolist()
        if (x, y, z) not in self.with_tool:
            self.with_tool[x, y, z] = self.known.with_tool((x, y, z))
        return self.with_tool[x, y, z]

    def report(self) -> str:
        """How well the map is known where this program goes, for a person."""
        if not self.known.parts:
            return "the map's own uncertainty is not stated"
        if not self.line:
            return "the map's own uncertainty is stated, and no place of the path is known"
        says = (
            f"the map itself is known to +- {micrometres(self.largest)} um (95 %, line {self.line})"
        )
        return says + unstated(self.known.missing)


def unstated(missing: tuple[str, ...]) -> str:
    """What has no part in a U, as the end of a sentence."""
    return f"; no uncertainty is stated of {', '.join(missing)}" if missing else ""


def micrometres(mm: float) -> str:
    """A U, mm, in um: a tenth, or two digits where it is smaller than one (JCGM 100, 7.2.6)."""
    return f"{mm / UM:.1f}" if mm >= UM else f"{mm / UM:.2g}"


def _parts(machine: Machine) -> dict[str, Machine]:
    """Name to the machine with one error alone, U in size."""
    # without tables and effects, but with the chain, tool and measured_at: the arms stay the same
    nothing = machine.bare
    parts: dict[str, Machine] = {}
    for x, axis in machine.axes.items():
        if axis.uncertainty is None:
            continue
        for i in axis.uncertainty.stated:
            alone = replace(nothing.axes[x], table=only(axis.uncertainty.table, [i]))
            parts[f"{COMPONENTS[i]}{x}"] = replace(nothing, axes={**nothing.axes, x: alone})
    for name, angle in machine.square_u.items():
        lean = np.where(np.arange(3) == ROTARY.index(name[0]), angle, 0.0)
        parts[name] = replace(nothing, square={name[2]: lean})
    for k, term in enumerate(machine.effects):
        for one in term.spread:
            parts[f"{_named(machine, k)} ({one.name})"] = replace(nothing, effects=(one,))
    return parts


def _errors(machine: Machine) -> list[str]:
    """Names, as in `_parts`, of the errors of a map; those that a place does not decide are none of
    it. An effect without any U stands by its name alone."""
    names = [
        name for x, axis in machine.axes.items() for name in _of_axis(axis, x in machine.expansions)
    ]
    # squareness that is stated as zero corrects nothing and needs no U
    names += machine.angles
    unsaid = [
        k
        for k, term in enumerate(machine.effects)
        if (term.tables or term.grids) and not term.spread
    ]
    return names + [_named(machine, k) for k in unsaid]


def _of_axis(axis: Axis, grows: bool) -> list[str]:
    """Of its table, its grids, its place, and its growth."""
    x = axis.letter
    names = [f"{COMPONENTS[i]}{x}" for i in (axis.table.rows if axis.table is not None else ())]
    names += [f"{COMPONENTS[i]}{x} by {grid.other}" for grid in axis.grids for i in grid.rows]
    names += [f"{(XYZ + ROTARY)[i]}0{x}" for i in map(int, np.flatnonzero(axis.location))]
    return names + ([f"heat {x}"] if grows else [])


def _named(machine: Machine, k: int) -> str:
    """The k-th effect: its name and axis, numbered where there are two of them."""
    names = [f"{term.name} {term.axis}".strip() for term in machine.effects]
    return (
        names[k] if names.count(names[k]) == 1 else f"{names[k]} #{names[: k + 1].count(names[k])}"
    )
