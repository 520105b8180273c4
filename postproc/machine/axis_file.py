"""The CSV tables of a machine folder: one axis' errors over its position, or over its own and a
second axis'.

Reads strictly: every complaint names file and line.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from postproc import intake
from postproc.errors import MachineError, Place
from postproc.expressions import expression
from postproc.machine.axis import Axis
from postproc.machine.chain import ROTARY
from postproc.machine.tables import COMPONENTS, AxisTable, AxisUncertainty, GridTable
from postproc.units import UM, URAD

# float() alone would also take 1_000, which a table never means. nan and inf pass here, to be
# refused below in words of their own.
NUMBER = expression(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf(inity)?)", re.IGNORECASE)
TURN = 360.0


def text_of(path: Path, most: int = intake.TABLE) -> str:
    """The text of a file; what is not UTF-8 is refused with its line. most: bytes."""
    return intake.decoded(intake.whole(path, most, MachineError), str(path), MachineError)


def read_table(path: Path, letter: str, max_slope: float) -> AxisTable:
    """Read `Z.csv`: first column `Z_mm` (`B_deg` of a rotary axis), then components with their
    unit, by direction where measured so.

    Raises MachineError with file and line for a wrong column or unit, a number that is none, nodes
    that do not ascend, or a slope over `max_slope` (mm/mm for translations).
    """
    _, lines, table = _one_axis(path, letter)
    steep = np.abs(table.slopes[:3]).max(axis=(0, 1))
    worst = int(np.argmax(steep))
    if steep[worst] > max_slope:
        low, high = table.nodes[worst : worst + 2]
        raise _too_steep(path, lines[worst + 1], letter, steep[worst], low, high, max_slope)
    return table


def read_uncertainty(
    path: Path, letter: str, travel: tuple[float, float], table: AxisTable | None
) -> AxisUncertainty:
    """Read `Z_uncertainty.csv`, U (95 %, k = 2) under the columns of `Z.csv`; a component measured
    in both directions may have one U for both. travel: mm or degrees; one turn is repeated over it
    as in `over_turns`; table: what it is of, None for an axis without.

    Raises MachineError with file and line as `read_table` does, for a U below zero, and where the
    nodes leave a part of the table without a U.
    """
    _, lines, found = _one_axis(path, letter)
    both = np.stack([found.forward, found.reverse])
    below = np.flatnonzero((both < 0).any(axis=(0, 1)))
    if len(below):
        component = int(np.flatnonzero((both[:, :, below[0]] < 0).any(axis=0))[0])
        name, scale = f"{COMPONENTS[component]}{letter}", UM if component < 3 else URAD
        raise MachineError(
            f"U of {name} is {both[:, component, below[0]].min() / scale:g} at {letter} ="
            f" {found.nodes[below[0]]:g}",
            "an uncertainty is zero or more: its half width, without a sign",
            Place(str(path), lines[below[0]]),
        )
    # one turn of U is repeated as the table was, or U would end where the table goes on
    if letter in ROTARY:
        found = over_turns(found, *travel, path)
    if table is not None:
        _covers(path, found, table, lines)
    return AxisUncertainty(found, found.stated)


def _covers(path: Path, found: AxisTable, table: AxisTable, lines: list[int]) -> None:
    """Raises MachineError where a part of the table lies outside the nodes of its uncertainties."""
    # Beyond its nodes a table is held (tables.py): U at the last node would pass for the U of
    # places of which nobody has said anything.
    ours, theirs = found.nodes, table.nodes
    late, early = ours[0] > theirs[0], ours[-1] < theirs[-1]
    if late or early:
        raise MachineError(
            f"the uncertainties go from {found.letter} = {ours[0]:g} to {ours[-1]:g}, "
            f"the table from {theirs[0]:g} to {theirs[-1]:g}",
            "state them from the table's first node to its last: none is assumed beyond",
            Place(str(path), lines[0 if late else -1]),
        )


def _one_axis(path: Path, letter: str) -> tuple[dict[tuple[int, str], int], list[int], AxisTable]:
    """Columns by (component, direction), the line of each node, and the values of a table over one
    axis."""
    columns, rows, lines = _rows(path, letter)
    for above, row, line in zip(rows, rows[1:], lines[1:], strict=False):
        if row[0] <= above[0]:
            raise MachineError(
                f"{position_name(letter)} = {row[0]:g} does not ascend after {above[0]:g}",
                "order the nodes, each once",
                Place(str(path), line, intake.lines_of(text_of(path))[line - 1]),
            )
    if len(rows) < 2:
        raise MachineError(
            f"{len(rows)} nodes: a table needs two at least", "", Place(str(path), 1)
        )
    data = np.array(rows).T
    stated = tuple(sorted({component for component, _ in columns}))
    return columns, lines, AxisTable(letter, data[0], *_directions(columns, data), stated)


def read_grid(path: Path, letter: str, other: str, max_slope: float) -> GridTable:
    """Read what of axis `letter` depends on axis `other` too: first columns `Z_mm,X_mm`, then
    components of Z, a row for every pair of a complete grid. Raises MachineError with file and
    line."""
    columns, rows, lines = _rows(path, letter, other)
    data = np.array(rows).T
    # Rows may stand in any order. `at` is the cell of each in the grid, row by row of `nodes`; a
    # cell that is seen twice, or never, is refused, so that `first` puts every value in its place.
    nodes, others = np.unique(data[0]), np.unique(data[1])
    if min(len(nodes), len(others)) < 2:
        raise MachineError(
            f"{len(nodes)} by {len(others)} nodes: a grid needs two each way at least",
            "",
            Place(str(path), 1),
        )
    i, j = np.searchsorted(nodes, data[0]), np.searchsorted(others, data[1])
    at = i * len(others) + j
    seen, first, count = np.unique(at, return_index=True, return_counts=True)
    for k in np.flatnonzero(count > 1)[:1]:
        line = lines[int(np.flatnonzero(at == seen[k])[1])]
        raise MachineError(
            "this pair of positions stands twice", "each once", Place(str(path), line)
        )
    missing = np.setdiff1d(np.arange(len(nodes) * len(others)), seen)
    if len(missing):
        a, b = divmod(int(missing[0]), len(others))
        raise MachineError(
            f"{letter} = {nodes[a]:g}, {other} = {others[b]:g} is missing: {len(missing)} of"
            f" {len(nodes) * len(others)} pairs are",
            "a grid needs a row for every pair",
            Place(str(path), lines[-1]),
        )
    flat_forward, flat_reverse = _directions(columns, data)
    shape = (6, len(nodes), len(others))
    grid = GridTable(
        letter, other, nodes, others, flat_forward[:, first].reshape(shape),
        flat_reverse[:, first].reshape(shape),
    )  # fmt: skip
    for slope, name in zip(grid.slopes, (letter, other), strict=True):
        if slope[:3].max() > max_slope:
            raise MachineError(
                f"the deviation changes by {slope[:3].max() * 1000:.2f} um/mm along {name} (limit"
                f" {max_slope * 1000:g} um/mm)",
                "a slip in the data or a wrong unit is likely; if it is true, set max_slope or"
                " accept_slope = true in [limits]",
                Place(str(path), lines[0]),
            )
    return grid


def over_turns(table: AxisTable, low: float, high: float, path: Path) -> AxisTable:
    """A table of one full turn, repeated over a travel of several. Others stay as they are. Raises
    MachineError where a turn does not end as it began."""
    laid = _laid_out(table.nodes, low, high)
    if laid is None:
        return table
    nodes, which = laid
    for values in (table.forward, table.reverse):
        _check_turn(values, table.letter, table.letter, path)
    return AxisTable(
        table.letter, nodes, table.forward[:, which], table.reverse[:, which], table.stated
    )


def grid_over_turns(grid: GridTable, axes: Mapping[str, Axis], path: Path) -> GridTable:
    """The same of a table over two axes, by each of them that turns."""
    for k, x in enumerate((grid.letter, grid.other)):
        nodes = grid.others if k else grid.nodes
        if x not in ROTARY or x not in axes or not (laid := _laid_out(nodes, *axes[x].travel)):
            continue
        both = [np.moveaxis(v, 1 + k, 1) for v in (grid.forward, grid.reverse)]
        for values in both:
            _check_turn(values, grid.letter, x, path)
        forward, reverse = (np.moveaxis(v[:, laid[1]], 1, 1 + k) for v in both)
        more: dict[str, Any] = {("nodes", "others")[k]: laid[0]}
        grid = replace(grid, forward=forward, reverse=reverse, **more)
    return grid


def _check_turn(values: np.ndarray, letter: str, by: str, path: Path) -> None:
    """Raises MachineError where values (6, K ...) do not end a turn of the axis `by` as they
    began it."""
    gap = np.abs(values[:, -1] - values[:, 0]).reshape(6, -1).max(axis=1)
    if gap.max() > 0:
        name = f"{COMPONENTS[int(np.argmax(gap))]}{letter}"
        raise MachineError(
            f"{name} ends a full turn of {by} with another value than it began",
            "the last node is the first one again",
            Place(str(path), 1),
        )


def _laid_out(nodes: np.ndarray, low: float, high: float) -> tuple[np.ndarray, np.ndarray] | None:
    """(M,) nodes (K,) of a full turn laid out over a travel, and (M,) which of the K each is; None
    of what is no full turn, or goes over the travel already."""
    if abs(nodes[-1] - nodes[0] - TURN) > 1e-9 or (nodes[0] <= low and high <= nodes[-1]):
        return None
    #    0 ......... 360 ......... 720    the last node of a turn is the first of the next: it
    #    '- turn 0 -' '- turn 1 -'        is kept once, at the very end again
    # A table that never ends may state a travel of any size: 100 turns each way are laid out, and
    # beyond them the value at whole turns holds.
    before = max(0, math.ceil((nodes[0] - max(low, -100 * TURN)) / TURN))
    after = max(0, math.ceil((min(high, 100 * TURN) - nodes[-1]) / TURN))
    turns = np.arange(-before, after + 1)
    laid = [nodes[:-1] + TURN * k for k in turns] + [nodes[-1:] + TURN * after]
    last = len(nodes) - 1
    return np.concatenate(laid), np.append(np.tile(np.arange(last), len(turns)), last)


def position_name(letter: str) -> str:
    """The name of the column of an axis' position."""
    return f"{letter}_deg" if letter in ROTARY else f"{letter}_mm"


def _cells(line: str, place: Place) -> list[str]:
    """The cells of a line. Raises MachineError."""
    try:
        return [cell.strip() for cell in next(csv.reader([line], strict=True))]
    except csv.Error as error:
        raise MachineError(
            f"not a line of a CSV table: {error}", "numbers between commas", place
        ) from None


def _numbers(cells: list[str], place: Place) -> list[float]:
    """The cells as numbers. Raises MachineError for one that is none, or no machine's."""
    for cell in cells:
        if not NUMBER.fullmatch(cell):
            raise MachineError(
                f"{cell!r} is not a number", "every node needs a value in every column", place
            )
    values = [float(cell) for cell in cells]
    if not all(map(intake.finite, values)):
        raise MachineError(
            "a value is not finite (NaN or infinity), or beyond any machine",
            "every node needs a value in every column",
            place,
        )
    return values


def _rows(
    path: Path, *letters: str
) -> tuple[dict[tuple[int, str], int], list[list[float]], list[int]]:
    """(component, direction) to column, the numbers, and the line of each row."""
    header: list[str] = []
    rows: list[list[float]] = []
    lines: list[int] = []
    columns: dict[tuple[int, str], int] = {}
    # Line by line, not as one csv file: a quoted cell may then not hold a line end, and each number
    # has its line in the file, which the messages name.
    for number, line in enumerate(intake.lines_of(text_of(path)), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        place = Place(str(path), number, line)
        cells = _cells(line, place)
        if not header:
            header = cells
            columns = _columns(header, letters, place)
            continue
        if len(cells) != len(header):
            raise MachineError(
                f"{len(cells)} values under {len(header)} columns",
                "a value is missing or one too many",
                place,
            )
        rows.append(_numbers(cells, place))
        lines.append(number)
    if not rows:
        raise MachineError("0 nodes: a table needs two at least", "", Place(str(path), 1))
    return columns, rows, lines


def _directions(
    columns: dict[tuple[int, str], int], data: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(6, N) forward and reverse, mm and rad, of columns as they stand in a file."""
    forward, reverse = np.zeros((6, data.shape[1])), np.zeros((6, data.shape[1]))
    for (component, direction), column in columns.items():
        # the only place where the units of a table's file become mm and rad
        scale = UM if component < 3 else URAD
        for wanted, into in (("rev", reverse), ("fwd", forward)):
            if direction in ("", wanted):
                into[component] = data[column] * scale
    return forward, reverse


def _too_steep(
    path: Path, line: int, letter: str, steep: float, low: float, high: float, limit: float
) -> MachineError:
    unit = "degree" if letter in ROTARY else "mm"
    return MachineError(
        f"the deviation changes by {steep * 1000:.2f} um/{unit} between {letter} = {low:g} and"
        f" {high:g} (limit {limit * 1000:g} um/{unit})",
        "a slip in the data or a wrong unit is likely; if it is true, set max_slope or accept_slope"
        " = true in [limits]",
        Place(str(path), line),
    )


def _columns(
    header: list[str], letters: tuple[str, ...], place: Place
) -> dict[tuple[int, str], int]:
    """(component, direction) to column; direction "" for a component measured one way."""
    letter = letters[0]
    _check_positions(header, letters, place)
    columns: dict[tuple[int, str], int] = {}
    allowed = [f"{c}{letter}_um" for c in COMPONENTS[:3]] + [
        f"{c}{letter}_urad" for c in COMPONENTS[3:]
    ]
    for i, name in enumerate(header[len(letters) :], len(letters)):
        base, direction = (name[:-4], name[-3:]) if name.endswith(("_fwd", "_rev")) else (name, "")
        if base not in allowed:
            raise MachineError(
                f"{name!r} is not a component of axis {letter}",
                f"columns: {', '.join(allowed)}, each also with _fwd and _rev",
                place,
            )
        key = (allowed.index(base), direction)
        if key in columns:
            raise MachineError(f"{name!r} stands twice", "", place)
        columns[key] = i
    directions: dict[int, set[str]] = {}
    for component, direction in columns:
        directions.setdefault(component, set()).add(direction)
    for component, found in directions.items():
        if found not in ({""}, {"fwd", "rev"}):
            raise MachineError(
                f"{allowed[component]}: give one column, or both _fwd and _rev", "", place
            )
    return columns


def _check_positions(header: list[str], letters: tuple[str, ...], place: Place) -> None:
    for i, x in enumerate(letters):
        name = header[i] if i < len(header) else ""
        if name != position_name(x):
            nth, unit = ("first", "second")[i], "degrees" if x in ROTARY else "mm"
            raise MachineError(
                f"the {nth} column is {name!r}, not {position_name(x)!r}",
                f"positions are slide positions in {unit}",
                place,
            )
