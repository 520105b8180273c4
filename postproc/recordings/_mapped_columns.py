"""What the names of a mapping of columns stand for, and in which columns they are found."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from postproc.errors import UsageError
from postproc.recordings import ReadingOptions, Source
from postproc.recordings import _components as components
from postproc.recordings import _text as text
from postproc.recordings import _units as units
from postproc.units import MM_PER_INCH, OTHER_TIME

#     Z_mm, Z_in           a position       reading_um, actual_mm      a reading, a position for it
#     C_deg                                 forward2_um, reverse_um    one column to each run
POSITION = re.compile(r"([XYZ](?!_deg)|[ABC](?=_deg))_(mm|in|inch|deg)")
READING = re.compile(r"(reading|actual)(?:_(.+))?")
WAY = re.compile(r"(forward|reverse)([0-9]{0,3})(?:_(.+))?")
OTHER = re.compile(r"run|direction|t_s|T_\w+_C|load_\w+_N|force_\w+_N|spindle_rpm|feed_mm_min")


@dataclass(frozen=True)
class Named:
    """What the names of a mapping stand for.

    at: each one's column from 0; positions: axis and unit; ways: forward or reverse, which of
    them ("" for one alone), unit; values: reading or actual, unit.
    """

    at: dict[str, int]
    positions: dict[str, tuple[str, str]]
    ways: dict[str, tuple[str, str, str]]
    values: dict[str, tuple[str, str]]

    @property
    def readings(self) -> list[str]:
        """The names of readings."""
        return [*self.ways, *self.values]

    @property
    def others(self) -> list[str]:
        """Positions and what else a recording keeps of a row."""
        apart = {*self.readings, "run", "direction", "t_s"}
        return [n for n in self.at if n not in apart]

    @property
    def units(self) -> set[str]:
        """Units that the names of readings end with."""
        return {w[2] for w in self.ways.values() if w[2]} | {
            v[1] for v in self.values.values() if v[1]
        }

    @property
    def actual(self) -> bool:
        """Whether positions stand in place of readings."""
        return any(what == "actual" for what, _ in self.values.values())

    def factor(self, name: str) -> float:
        """mm (or degrees) per unit of a position, 1 of all else."""
        inch = name in self.positions and self.positions[name][1].startswith("in")
        return MM_PER_INCH if inch else 1.0

    def column(self, name: str) -> str:
        """The name of a column in the recording: positions in mm or degrees."""
        if name not in self.positions:
            return name
        return f"{name[0]}_{'mm' if name[0] in 'XYZ' else 'deg'}"

    def run_of(self, name: str) -> int:
        """The run of a column forward or reverse: odd ones forward where both are there."""
        way, count, _ = self.ways[name]
        n = int(count or 1)
        # forward1 reverse1 forward2 reverse2: runs 1 2 3 4
        return 2 * n - (way == "forward") if len({w for w, *_ in self.ways.values()}) == 2 else n

    def sign_of(self, name: str) -> int:
        """+1 of a column forward, -1 of one reverse."""
        return 1 if self.ways[name][0] == "forward" else -1


def columns(
    source: Source, table: text.Table, mapping: dict[str, str]
) -> tuple[int, dict[str, int]]:
    """Index of the first row of data, and each name's column from 0. Raises RecordingError for a
    heading that is not there."""
    named = {n: h for n, h in mapping.items() if not h.strip().isdigit()}
    top = _heading_row(source, table, list(named.values())) if named else -1
    at = {
        n: _called(source, table.rows[top], n, h) if n in named else int(h) - 1
        for n, h in mapping.items()
    }
    widest = max(len(cells) for _, cells in table.rows)
    for name, j in at.items():
        if not 0 <= j < widest:
            raise UsageError(
                f"--column {name}={j + 1}: the table has {widest} columns", "they count from 1"
            )
    top = top + 1 if top >= 0 else _first_of_numbers(table, list(at.values()))
    for name, heading in _headings(table, top, at).items():
        _check_unit(name, heading)
    return top, at


def _headings(table: text.Table, top: int, at: dict[str, int]) -> dict[str, str]:
    """Name to the heading of its column, of the row above the data."""
    cells = table.rows[top - 1][1] if top else []
    return {name: cell_of(cells, j) for name, j in at.items()}


def _check_unit(name: str, heading: str) -> None:
    """Raises UsageError where a heading says another unit than the name that it was given: a factor
    of 25.4 or 1000 looks like a machine."""
    if name == "t_s":
        found = OTHER_TIME.search(heading)
        said, wanted = (found[1] if found else "", "seconds")
    else:
        unit, own = units.in_heading(heading), units.unit_of(name.rpartition("_")[2])
        differs = unit and own and (unit.quantity, unit.factor) != (own.quantity, own.factor)
        said, wanted = (unit.name if unit and differs else "", own.name if own else "")
    if said:
        raise UsageError(
            f"--column {name}={heading}: the heading says {said}, and {name} is {wanted}",
            "Z_mm, Z_in, reading_um, reading_mm ... name the unit of the file; what has no name in"
            " that unit is to be converted in the table",
        )


def headed(table: text.Table, top: int, at: dict[str, int], names: Iterable[str]) -> set[str]:
    """Units that the headings of these columns say."""
    found = _headings(table, top, {n: at[n] for n in names})
    return {unit.name for h in found.values() if (unit := units.in_heading(h))}


def _first_of_numbers(table: text.Table, columns: list[int]) -> int:
    """Index of the first row that has a number in one of the columns; 0: none has."""
    for k, (_, cells) in enumerate(table.rows):
        # columns by numbers alone: lines of words above the table are passed over
        if any(table.numeric(cell_of(cells, j)) for j in columns):
            return k
    return 0


def _heading_row(source: Source, table: text.Table, headings: list[str]) -> int:
    """Index of the first row that holds all headings. Raises RecordingError where none does."""
    for k, (_, cells) in enumerate(table.rows):
        if not _lacking(headings, cells):
            return k
    # the row that lacks fewest of them is the one that was meant: its names help most
    line, cells = min(table.rows[:30], key=lambda row: len(_lacking(headings, row[1])))
    raise source.fault(
        line,
        f"no column is called {_lacking(headings, cells)[0]!r}",
        f"columns here: {', '.join(c or '(none)' for c in cells)}",
    )


def _lacking(headings: list[str], cells: list[str]) -> list[str]:
    """The headings that no cell holds, in capitals or not."""
    there = [c.lower() for c in cells]
    return [h for h in headings if h.strip().lower() not in there]


def _called(source: Source, row: tuple[int, list[str]], name: str, heading: str) -> int:
    """The column of a heading, in capitals or not where none is spelt so."""
    line, cells = row
    wanted = heading.strip()
    same = [j for j, c in enumerate(cells) if c == wanted] or [
        j for j, c in enumerate(cells) if c.lower() == wanted.lower()
    ]
    if len(same) > 1:
        raise source.fault(
            line,
            f"{len(same)} columns are called {heading!r}",
            f"say which by its number: --column {name}={same[0] + 1}",
        )
    return same[0]


def named_in(at: dict[str, int]) -> Named:
    """Raises UsageError for a mapping of targets that says too little or too much."""
    positions, ways, values = (_matching(p, at) for p in (POSITION, WAY, READING))
    known = positions | ways | values
    if unknown := [n for n in at if n not in known and not OTHER.fullmatch(n)]:
        raise UsageError(
            f"--column {unknown[0]}=... is no column of a recording",
            "Z_mm, reading_um, actual_mm, forward_um, reverse_um, run, direction, t_s,"
            " T_air_C, ...",
        )
    if not positions:
        raise UsageError("the mapping names no position", "like --column Z_mm=Position")
    named = Named(at, positions, ways, values)
    _one_kind(named)
    return named


def _matching(pattern: re.Pattern[str], names: Iterable[str]) -> dict[str, Any]:
    """Name to its groups of a pattern, of the names that it fits."""
    return {n: m.groups("") for n in names if (m := pattern.fullmatch(n))}


def _one_kind(named: Named) -> None:
    """Raises UsageError where readings are not of one column, or of columns forward and reverse."""
    if bool(named.ways) == bool(named.values) or len(named.values) > 1:
        raise UsageError(
            "the mapping must name one column of readings, or columns forward and reverse",
            "like --column reading_um=Deviation",
        )
    if named.ways and ("run" in named.at or "direction" in named.at):
        raise UsageError(
            "forward and reverse say run and direction already",
            "leave run and direction out of the mapping",
        )


def moving(named: Named, options: ReadingOptions) -> str:
    """The axis that moved: as the options say, else the one whose position is named."""
    letters = [letter for letter, _ in named.positions.values()]
    moving = (
        options.component and components.parsed(options.component).axis
    ) or options.axis.strip().upper()
    if moving and moving not in letters:
        raise UsageError(
            f"the mapping names no position of {moving}", f"like --column {moving}_mm=Position"
        )
    if not moving and len(letters) > 1:
        raise UsageError(
            f"the mapping names positions of {', '.join(letters)}",
            "say which axis moved: --axis Z, or --component EXZ",
        )
    return moving or letters[0]


def cell_of(cells: list[str], at: int) -> str:
    """The cell of a column; empty where there is none."""
    return cells[at] if 0 <= at < len(cells) else ""
