"""ISG CSV: the volumetric compensation of ISG kernels and of Beckhoff TwinCAT CNC (VolComp,
TF5280).

A header names arguments (X Y Z, mm) and parameters (EXX .. ECZ, B0Z ..), rows of numbers follow,
blanks between; `//` begins a comment, `#` a new table. Lengths are mm, angles rad. Source: Beckhoff
TF5280, "ISG CSV format", "Units of measure", "List of parameters supported", "General
configuration", P-VOLC-00007 (chain), -00008 (workpiece_axes), -00014 (interpolation).

Sign: names are those of ISO 230-1, so a component is the deviation, actual - commanded: written as
it is (+e). Squareness B0Z is a right-handed rotation about Y of axis Z, gcomp's own meaning: B0X >
0 leans X towards -Z, B0Z > 0 leans Z towards +X, C0Y > 0 leans Y towards -X, A0Z > 0 leans Z
towards -Y; written as it is. The chain is told from the workpiece to the tool, the first
workpiece_axes of it carry the workpiece, exactly as the surveyor counted them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables import _volumetric as volumetric
from postproc.control_tables._volumetric import COMPONENT, LOCATION, Collected, plain
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS
from postproc.machine.volumetric import VolumetricMap, add, directions, of_machine
from postproc.recordings import Source

TITLE = "ISG CSV (volumetric compensation of ISG and Beckhoff VolComp)"
VERIFIED = True
UNVERIFIED = "the sign of a component, and from where arms count"
SIGN = volumetric.SIGN
EXTRA = volumetric.EXTRA
#     // comment
#     B0Z C0Y                       squareness, rad: one row
#     0.000012 -0.000005
#     #                             a new table
#     X EXX EYX EBX                 components of X over X
#     0.0 0.0001 0.0 0.000002
#     100.0 ...
#     #
#     Z X EXX                       a component over two axes: the second one, Z, turns slowest
OTHERS = re.compile(r"[PN]0[XYZ]|[PV][XYZ][XYZABC]|ID[XYZ]|LN[XYZABC]")
LONE = 0.5  # mm to either side of the one place at which a component was measured


# -- writing ---------------------------------------------------------------------------------------


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """The tables as translations of each axis. Two-way tables are written as their mean. Raises
    TableError."""
    found, left = volumetric.map_of(tables)
    return _export(found, options, left, [])


def write_machine(machine: Machine, options: ExportOptions) -> Export:
    """All components, squareness, the chain. Raises TableError or MachineError for what VolComp can
    not hold."""
    found, left = of_machine(machine)
    if missing := [x for x in XYZ if x not in found.chain]:
        raise TableError(
            f"{machine.name} has no axis {' '.join(missing)}: VolComp needs X, Y and Z",
            "state the missing axis in the machine's chain, or write one-axis tables"
            " (beckhoff-lsec)",
        )
    notices = [
        f"{x} travels from {machine.axes[x].travel[0]:g} to {machine.axes[x].travel[1]:g} mm, its"
        f" table only from {t.nodes[0]:g} to {t.nodes[-1]:g} mm"
        for x, t in found.axes.items()
        if machine.axes[x].travel[0] < t.nodes[0] or machine.axes[x].travel[1] > t.nodes[-1]
    ]
    add(left, directions(machine, found))
    return _export(found, options, left, notices)


def _export(
    found: VolumetricMap, options: ExportOptions, left: dict[str, float], notices: list[str]
) -> Export:
    mean = found.one_way()
    lines = [
        f"// {options.program}: mm and rad, deviation = actual - commanded, arms from machine zero",
        f"// {volumetric.SIGN_NOTICE}",
    ]
    blocks = [_location(mean.square)] if mean.square else []
    for key, names in _groups(mean).items():
        blocks.append(_table(mean, key, names))
    if not blocks:
        raise TableError("there is no deviation to write", "the machine's tables are empty")
    for i, block in enumerate(blocks):
        lines += (["#"] if i else []) + block
    name = options.program
    records = sum(len(block) - 1 for block in blocks)
    listing = [
        f"chain                    {''.join(found.chain)}",
        f"workpiece_axes           {found.workpiece_axes}",
        *(f"{x}                        {1 + XYZ.index(x)}" for x in XYZ),
        "interpolation            GRID",
        f"file[0]                  {name}.csv",
        "file_format[0]           ISG_CSV",
    ]
    notices = [
        volumetric.SIGN_NOTICE,
        *found.notices,
        *notices,
        *volumetric.loss(left),
        volumetric.ENDS,
        volumetric.FLANGE,
        (
            "the list gives X, Y, Z the logical axes 1, 2, 3: set yours; vol_comp[0].max_records"
            f" must be {records} or more"
        ),
    ]
    files = {f"{name}.csv": common.text_of(lines), f"{name}.lis": common.text_of(listing)}
    return Export(files, tuple(notices), left)


def _location(square: dict[str, float]) -> list[str]:
    return [" ".join(square), " ".join(plain(a) for a in square.values())]


def _groups(found: VolumetricMap) -> dict[tuple[str, str], list[int]]:
    """(axis, second axis or "") to the components that depend on just these. A parameter may stand
    only once, so what has a grid is written there with its table added."""
    others: dict[tuple[str, int], str] = {}
    for grid in found.grids:
        for row in grid.rows:
            known = others.setdefault((grid.letter, row), grid.other)
            if known != grid.other:
                name = COMPONENTS[row] + grid.letter
                raise TableError(
                    f"{name} depends on {known} and on {grid.other}", "write one of the two"
                )
    groups: dict[tuple[str, str], list[int]] = {}
    for (x, row), other in others.items():
        groups.setdefault((x, other), []).append(row)
    for x, table in found.axes.items():
        for row in table.rows:
            if (x, row) not in others:
                groups.setdefault((x, ""), []).append(row)
    return {key: sorted(rows) for key, rows in sorted(groups.items())}


def _table(found: VolumetricMap, key: tuple[str, str], rows: list[int]) -> list[str]:
    letter, other = key
    names = [COMPONENTS[row] + letter for row in rows]
    if other:
        heads, cells = [other, letter, *names], _grid(found, letter, other, rows)
    else:
        own = found.axes[letter]
        heads, cells = [letter, *names], [own.nodes, *own.forward[rows]]
    lines = (" ".join(map(plain, row)) for row in zip(*cells, strict=True))
    return [" ".join(heads), *lines]


def _grid(found: VolumetricMap, letter: str, other: str, rows: list[int]) -> list[np.ndarray]:
    """Columns of a grid, its own table added: the second axis, which turns slowest, as in the
    manual's example, the first, and the components of `rows`."""
    grids = [g for g in found.grids if (g.letter, g.other) == (letter, other)]
    own = [found.axes[letter]] if letter in found.axes else []
    nodes = [g.nodes for g in grids] + [t.nodes for t in own]
    first = np.unique(np.concatenate(nodes))
    second = np.unique(np.concatenate([g.others for g in grids]))
    q, p = np.tile(first, len(second)), np.repeat(second, len(first))
    none = np.zeros(q.size)
    parts = [g.evaluate(q, p, none) for g in grids] + [t.evaluate(q, none) for t in own]
    return [p, q, *(_sum(parts, k, none) for k in rows)]


def _sum(parts: Sequence[Sequence[np.ndarray | None]], k: int, none: np.ndarray) -> np.ndarray:
    return sum((v for part in parts if (v := part[k]) is not None), none)


# -- reading ---------------------------------------------------------------------------------------


@dataclass
class _Block:
    """One table: the line of its header, its columns, rows with their lines."""

    at: common.Line
    names: list[str]
    rows: list[list[float]] = field(default_factory=list)
    lines: list[common.Line] = field(default_factory=list)

    def fault(self, message: str, advice: str = "") -> TableError:
        """What is wrong with the whole table."""
        return common.fault(self.at.source, self.at.number, message, advice)

    @property
    def arguments(self) -> list[str]:
        return [name for name in self.names if len(name) == 1]

    @property
    def column(self) -> dict[str, np.ndarray]:
        """Name to (R,) numbers of its rows, mm or rad."""
        return dict(zip(self.names, np.array(self.rows).T, strict=True))


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """The translations of each axis. Raises TableError for rotations, squareness or two arguments:
    see read_machine."""
    return volumetric.tables_of(read_machine(source, options), source.name)


def read_machine(source: Source, options: ExportOptions) -> VolumetricMap:
    """A map. The order of the axes is not in the file: options.extra "chain" ("XYZ") and
    "workpiece_axes" ("0") tell it.

    Raises TableError with file, line and reason for what is no such file.
    """
    found = Collected(source)
    for block in _blocks(source):
        for name, values in block.column.items():
            if name not in block.arguments:
                found.once(block.at.number, name)
                _parameter(found, block, name, values)
    return found.map(options)


def _blocks(source: Source) -> list[_Block]:
    blocks: list[_Block] = []
    fresh = True
    for at in volumetric.lines_of(source):
        cells = at.text.split()
        if at.text.startswith("#"):
            if at.text.strip("#-=* "):
                advice = "write the header on a line of its own"
                raise at.fault("text behind #, which begins a new table", advice)
            fresh = True
        elif fresh:
            _check_header(at, cells)
            blocks.append(_Block(at, cells))
            fresh = False
        else:
            if len(cells) != len(blocks[-1].names):
                message = f"{len(cells)} values under {len(blocks[-1].names)} columns"
                raise at.fault(message, "blanks part the columns")
            blocks[-1].rows.append([volumetric.value_of(at, cell) for cell in cells])
            blocks[-1].lines.append(at)
    for block in blocks:
        if not block.rows:
            raise block.fault("a header without rows")
    if not blocks:
        raise common.fault(source, 1, "no table stands in this file")
    return blocks


def _check_header(at: common.Line, names: list[str]) -> None:
    for name in names:
        known = name in tuple(XYZ + ROTARY) or any(
            p.fullmatch(name) for p in (COMPONENT, LOCATION, OTHERS)
        )
        if not known:
            advice = "a table begins with a header: X Y Z A B C, EXX .. ECC, A0Z B0Z C0Y .."
            raise at.fault(f"{name[:40]!r} is not an argument or parameter", advice)
        if names.count(name) > 1:
            raise at.fault(f"{name} heads two columns")


def _parameter(found: Collected, block: _Block, name: str, values: np.ndarray) -> None:
    component = COMPONENT.fullmatch(name)
    if component and component[2] in XYZ:
        _component(found, block, name, values)
    elif component:
        found.notices.append(f"{name}: components of rotary axes are not read")
    elif np.ptp(values) > 0:
        raise block.fault(f"{name} changes from row to row: only a constant is known for it")
    else:
        found.location(name, float(values[0]))


def _component(found: Collected, block: _Block, name: str, column: np.ndarray) -> None:
    """One component over its arguments."""
    other = _second(found, block, name)
    nodes, second, values = _placed(block, name, column, other)
    if other and len(nodes) == 1:
        nodes, values = np.array([nodes[0] - LONE, nodes[0] + LONE]), np.repeat(values, 2, axis=0)
    if len(nodes) < 2:
        raise block.fault(f"{name} has one row: a component needs two")
    if other:
        found.grid(name, other, nodes, second, values)
    else:
        found.component(name, nodes, values[:, 0])


def _second(found: Collected, block: _Block, name: str) -> str:
    """The argument beside its own on which a component depends, "" for none: one that never changes
    is none. Raises TableError."""
    letter = name[2]
    if letter not in block.arguments:
        raise block.fault(f"{name} stands without its argument {letter}")
    others = []
    for x in (x for x in block.arguments if x != letter):
        if np.ptp(block.column[x]) > 0:
            others.append(x)
        else:
            found.notices.append(
                f"{name} is given at {x} = {block.column[x][0]:g} only: taken for all {x}"
            )
    if len(others) > 1 or set(others) & set(ROTARY):
        raise block.fault(
            f"{name} depends on {' and '.join(others)} beside {letter}: one more linear axis is"
            " known at most"
        )
    return "".join(others)


def _placed(
    block: _Block, name: str, column: np.ndarray, other: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places of a component's own argument and of the other, [0] for none, and its values there.
    Raises TableError where one is missing, or stands twice."""
    nodes, first = np.unique(block.column[name[2]], return_inverse=True)
    second, last = np.unique(block.column.get(other, 0 * column), return_inverse=True)
    places = np.ravel(first) * len(second) + np.ravel(last)
    once = np.unique(places, return_index=True)[1]
    for row in np.setdiff1d(np.arange(len(places)), once)[:1]:
        at = block.lines[row]
        raise common.fault(at.source, at.number, f"{name} stands twice at the same place")
    if len(places) < len(nodes) * len(second):
        raise block.fault(
            f"{len(places)} rows are no grid of {len(nodes)} by {len(second)} places",
            "every place of the grid needs its row",
        )
    return nodes, second, column[np.argsort(places)].reshape(len(nodes), len(second))
