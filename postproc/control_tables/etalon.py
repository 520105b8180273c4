"""Etalon exchange text, variant "Vendor": what TRAC-CAL and LineCal write, and ISG and Beckhoff
VolComp read.

A parameter is a section: `[EXY]` with `Gridpoints = { argument value ... }`, `[C0B]` with `VALUE =
`; `//` begins a comment. Lengths are mm, angles rad; a component has its own axis as its only
argument. Source: Beckhoff TF5280, "Etalon Exchange Format", "Units of measure", "Constancy in the
case of modulo passages".

Sign: as in isg_csv. A component is the deviation, actual - commanded, as its ISO 230-1 name says
(+e); squareness is the right-handed rotation of its name, gcomp's own meaning: B0X > 0 leans X
towards -Z.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables import _volumetric as volumetric
from postproc.control_tables._volumetric import COMPONENT, LOCATION, Collected, plain
from postproc.machine.chain import ROTARY
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS, AxisTable
from postproc.machine.volumetric import VolumetricMap, add, directions, merged, of_machine
from postproc.recordings import Source

TITLE = "Etalon exchange text (TRAC-CAL, LineCal; read by ISG and Beckhoff VolComp)"
VERIFIED = True
UNVERIFIED = "the sign of a component, and from where arms count"
SIGN = volumetric.SIGN
#     // comment
#     [EXX]
#     Gridpoints = {
#         0.0 0.0001            argument mm, value mm (rad)
#         100.0 0.0003
#     }
#     [C0Y]
#     VALUE = -0.000012         rad
EXTRA = volumetric.EXTRA


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """The tables as translations of each axis. Two-way tables are written as their mean. Raises
    TableError."""
    found, left = volumetric.map_of(tables)
    return _export(found, options, left)


def write_machine(machine: Machine, options: ExportOptions) -> Export:
    """All components and squareness. What depends on a second axis is written as its middle over
    that axis.

    Raises TableError where there is nothing to write, MachineError for rotary axes.
    """
    found, left = of_machine(machine)
    add(left, directions(machine, found))
    return _export(_flat(machine, found, left), options, left)


def _flat(machine: Machine, found: VolumetricMap, left: dict[str, float]) -> VolumetricMap:
    """The map with each grid as its middle over the second axis; adds to `left` what that leaves,
    mm."""
    axes = dict(found.one_way().axes)
    notices = list(found.notices)
    for grid in found.one_way().grids:
        # The middle of the extremes leaves the least of the worst, where the mean leaves more at
        # one end.
        middle = (grid.forward.max(axis=2) + grid.forward.min(axis=2)) / 2
        off = grid.forward - middle[:, :, None]
        add(
            left,
            directions(
                machine, replace(found, axes={}, grids=(replace(grid, forward=off, reverse=-off),))
            ),
        )
        notices.append(
            f"the format has one argument: errors of {grid.letter} over {grid.other} are written as"
            " their middle"
        )
        # six rows, EX EY EZ EA EB EC, the same for both directions
        parts = [(i, grid.nodes, middle[i], middle[i]) for i in range(6)]
        if (own := axes.get(grid.letter)) is not None:
            nodes = np.union1d(own.nodes, grid.nodes)
            sums = [
                np.interp(nodes, own.nodes, own.mean[i]) + np.interp(nodes, grid.nodes, middle[i])
                for i in range(6)
            ]
            parts = [(i, nodes, v, v) for i, v in enumerate(sums)]
        axes[grid.letter] = merged(grid.letter, parts)
    return replace(found, axes=axes, grids=(), notices=tuple(notices))


def _export(found: VolumetricMap, options: ExportOptions, left: dict[str, float]) -> Export:
    lines = [
        f"// {options.program}: mm and rad, deviation = actual - commanded, arms from machine zero",
        f"// {volumetric.SIGN_NOTICE}",
    ]
    for name, angle in found.square.items():
        lines += [f"[{name}]", f"VALUE = {plain(angle)}"]
    for x, table in sorted(found.axes.items()):
        lines += [
            line for row in table.rows for line in _section(table, row, f"{COMPONENTS[row]}{x}")
        ]
    if len(lines) == 2:
        raise TableError("there is no deviation to write", "all tables of the machine are zero")
    order = f"{''.join(found.chain)}, {found.workpiece_axes} of them on the workpiece's side"
    notices = (
        volumetric.SIGN_NOTICE,
        *found.notices,
        *volumetric.loss(left),
        volumetric.ENDS,
        volumetric.FLANGE,
        f"the order of the axes is not in the file, tell the control: {order}",
    )
    return Export({f"{options.program}.txt": common.text_of(lines)}, notices, left)


def _section(table: AxisTable, row: int, name: str) -> list[str]:
    points = [
        f"    {plain(q)} {plain(e)}" for q, e in zip(table.nodes, table.mean[row], strict=True)
    ]
    return [f"[{name}]", "Gridpoints = {", *points, "}"]


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """The translations of each axis. Raises TableError for rotations or squareness: see
    read_machine."""
    return volumetric.tables_of(read_machine(source, options), source.name)


def read_machine(source: Source, options: ExportOptions) -> VolumetricMap:
    """A map. The order of the axes is not in the file: options.extra "chain" ("XYZ") and
    "workpiece_axes" ("0") tell it.

    Raises TableError with file, line and reason for what is no such file.
    """
    reading = _Reading(Collected(source))
    for at in volumetric.lines_of(source):
        reading.take(at)
    reading.end()
    return reading.found.map(options)


@dataclass
class _Reading:
    """A file up to a line. name, header: the section that is open, "" for none, and its line;
    points: of its Gridpoints, None outside of them; last: the last line read."""

    found: Collected
    name: str = ""
    header: int = 0
    points: list[tuple[float, float]] | None = None
    last: int = 1

    def take(self, at: common.Line) -> None:
        """The next line. Raises TableError where it can not stand there."""
        self.last = at.number
        if self.points is not None:
            self._point(at, self.points)
        elif section := re.fullmatch(r"\[(\w+)\]", at.text):
            self._begin(at, section[1])
        elif not self.name:
            advice = "a parameter begins with its name: [EXY]"
            raise at.fault("a line outside of a section", advice)
        elif value := re.fullmatch(r"VALUE\s*=\s*(\S+)", at.text, re.IGNORECASE):
            if COMPONENT.fullmatch(self.name):
                raise at.fault(f"{self.name} is one VALUE: a component needs Gridpoints")
            self.found.location(self.name, volumetric.value_of(at, value[1]))
            self.name = ""
        elif re.fullmatch(r"Gridpoints\s*=\s*\{", at.text, re.IGNORECASE):
            self.points = []
        else:
            raise at.fault("neither VALUE = .. nor Gridpoints = {")

    def _begin(self, at: common.Line, name: str) -> None:
        """A section. Raises TableError for a name that is no parameter."""
        if self.name:
            raise at.fault(f"[{self.name}] has neither VALUE nor Gridpoints")
        if not (COMPONENT.fullmatch(name) or LOCATION.fullmatch(name)):
            raise at.fault(f"{name[:40]!r} is not a parameter", "EXX .. ECC, A0Z B0Z C0Y ..")
        self.name, self.header = name, at.number
        self.found.once(at.number, name)

    def _point(self, at: common.Line, before: list[tuple[float, float]]) -> None:
        """A point behind those before, or the end of them."""
        if at.text == "}":
            _keep(self.found, self.header, self.name, before)
            self.name, self.points = "", None
            return
        cells = at.text.split()
        if len(cells) != 2:
            message = f"{len(cells)} words where an argument and its value must stand"
            raise at.fault(message, "or a closing } is missing above")
        argument, value = (volumetric.value_of(at, cell) for cell in cells)
        if before and argument <= before[-1][0]:
            raise at.fault(f"{argument:g} does not ascend after {before[-1][0]:g}")
        before.append((argument, value))

    def end(self) -> None:
        """Raises TableError where the file is not whole."""
        source, name = self.found.source, self.name
        if self.points is not None:
            message = f"the file ends inside the Gridpoints of {name} (line {self.header})"
            raise common.fault(source, self.last, message)
        if name:
            raise common.fault(source, self.header, f"[{name}] has neither VALUE nor Gridpoints")
        if not self.found.seen:
            raise common.fault(source, self.last, "no parameter stands in this file")


def _keep(found: Collected, line: int, name: str, points: list[tuple[float, float]]) -> None:
    if LOCATION.fullmatch(name):
        if len({value for _, value in points}) != 1:
            raise common.fault(
                found.source, line, f"{name} is no constant: only a constant is known for it"
            )
        found.location(name, points[0][1])
    elif len(points) < 2:
        raise common.fault(
            found.source, line, f"{name} has {len(points)} points: a component needs two"
        )
    elif name[1] in ROTARY + "XYZ" and name[2] in ROTARY:
        found.notices.append(f"{name}: components of rotary axes are not read")
    else:
        nodes, values = np.array(points).T
        found.component(name, nodes, values)
