"""Any table as CSV, by a mapping of its columns: what stands under which name, or in which column
counted from 1.

Targets, one reading a row: `Z_mm` (or Z_in, Z_deg) and `reading_um` (or _mm, _urad, ...; bare
`reading` with --unit), with run, direction (+ -, up down, forward reverse), t_s, T_<place>_C and
other columns of a recording where the table has them. `actual_mm` in place of the reading is the
position itself. Targets, one row each: `forward_mm`, `reverse_mm`, or `forward1_um`, `reverse1_um`,
`forward2_um` ... in place of the reading. Traces, circles and features: the columns that the
contract names for them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from postproc.errors import UsageError
from postproc.recordings import Fault, ReadingOptions, Recording, Source, _sheet
from postproc.recordings import _components as components
from postproc.recordings import _mapped_columns as names
from postproc.recordings import _mapped_kinds as kinds
from postproc.recordings import _targets as targets
from postproc.recordings import _text as text
from postproc.recordings import _units as units

TITLE = "any CSV, by --column NAME=HEADING"
TAKES = (
    "axis", "component", "unit", "bidirectional", "first", "columns", "others", "machine", "head",
)  # fmt: skip
EXTRA = {
    "decimal": ". or ,: the decimal sign, where it is not clear",
    "delimiter": "tab, semicolon, bar or comma, where it is not clear",
}
MOST = 8  # columns that were not named, in a notice
DELIMITER = {"tab": "\t", "semicolon": ";", "bar": "|", "comma": ","}


@dataclass
class Row:
    """A row of the table: its numbers by name, its sign of approach and whether that is relative to
    the first run, the readings that are empty, what is wrong."""

    line: int
    cells: list[str]
    numbers: dict[str, float] = field(default_factory=dict)
    sign: int = 0
    relative: bool = False
    empty: list[str] = field(default_factory=list)
    wrong: str = ""


def recognises(source: Source) -> bool:
    """Never: a mapping must be given, and then it is taken."""
    return False


def read(source: Source, options: ReadingOptions) -> Recording:
    """Raises UsageError for a mapping that says too little or too much, RecordingError for a table
    that does not bear it."""
    mapping = options.columns
    if not mapping:
        raise UsageError(
            f"{source.name}: no columns are named",
            "like --column Z_mm=Position --column reading_um=Deviation, or --column Z_mm=1",
        )
    content, odd = text.decoded(source)
    sign = options.extra.get("delimiter", "")
    if sign and sign not in DELIMITER:
        raise UsageError(f"--set delimiter={sign} is not known", f"one of {', '.join(DELIMITER)}")
    table = text.table(source, content, text.stated_decimal(options.extra), DELIMITER.get(sign, ""))
    notices = [*table.notices, *odd]
    top, at = names.columns(source, table, mapping)
    notices += _unread(table, top, at)
    if kinds.is_other(mapping):
        return kinds.read(source, options, table, top, at, notices)
    return _targets(source, options, table, top, at, notices)


def _unread(table: text.Table, top: int, at: dict[str, int]) -> list[str]:
    """What else the table holds in numbers, where it has headings: a run that was not named would
    be missed in silence."""
    if not top:
        return []
    headings, first = table.rows[top - 1][1], table.rows[top][1] if top < len(table.rows) else []
    left = [
        f"{heading!r}"
        for j, (heading, cell) in enumerate(zip(headings, first, strict=False))
        if heading and j not in at.values() and table.numeric(cell)
    ]
    more = f" and {len(left) - MOST} more" if len(left) > MOST else ""
    return [f"columns that no --column names: {', '.join(left[:MOST])}{more}"] if left else []


def _targets(source, options, table, top, at, notices) -> Recording:
    """Readings at targets, one a row or several."""
    named = names.named_in(at)
    moving = names.moving(named, options)
    said = _unit(named.units or names.headed(table, top, at, named.readings))
    where = table.rows[top - 1][0] if top else 1
    component = components.positioning(options, source, moving, said, where, notices)
    unit = components.unit_for(options, source, component, said, where)
    own = next(n for n, (letter, _) in named.positions.items() if letter == component.axis)
    rows, faults, relative = _rows(source, options, table, top, named)
    notices += _sheet.missing(faults)
    relative = relative or bool(named.ways)
    readings = _readings(rows, named, own, unit, options.first)
    if relative and not options.first:
        notices.append(
            "forward is taken as +, reverse as - (--first - if forward went towards minus)"
        )
    if "t_s" in at and not named.ways:
        readings = replace(readings, t=_times(source, table, rows, at["t_s"]))
    # Turned already: heeded once more, --first - would turn it back.
    heed = replace(options, first=0, bidirectional=None) if relative else options
    return targets.recording(source, heed, component, unit, readings, {}, notices, faults)


def _readings(
    rows: list[Row], named: names.Named, own: str, unit: units.Unit, first: int
) -> targets.Readings:
    """The readings of all rows; `own`: the position of the axis that moved; first: sign of
    forward, 0: +."""
    # deviation = actual - target, in the unit of the reading
    per = _actual_factor(unit, own) if named.actual else None
    taken = [(row, name) for row in rows for name in named.readings if name in row.numbers]

    def reading(row: Row, name: str) -> tuple[int, float, float, int, int]:
        run, sign = int(row.numbers.get("run", 1)), row.sign
        if name in named.ways:
            run, sign = named.run_of(name), named.sign_of(name) * (first or 1)
        position, value = row.numbers[own] * named.factor(own), row.numbers[name]
        return run, position, value if per is None else value - position * per, row.line, sign

    columns = {
        named.column(n): [row.numbers[n] * named.factor(n) for row, _ in taken]
        for n in named.others
        if n != own
    }
    return targets.Readings.of((reading(*one) for one in taken), columns=columns)


def _unit(said: set[str]) -> units.Unit | None:
    """The one unit that the mapping's names end with."""
    if not said:
        return None
    found = {u.name: u for u in (units.named(s, "--column ..._") for s in said)}
    if len(found) > 1:
        raise UsageError(
            f"the mapping names readings in {' and in '.join(sorted(found))}", "one unit for all"
        )
    return next(iter(found.values()))


def _actual_factor(unit: units.Unit, own: str) -> float:
    """How many of the reading's unit one mm (one degree) of position is."""
    base = units.UNITS["deg" if own.endswith("_deg") else "mm"]
    if unit.quantity != base.quantity:
        raise UsageError(f"actual_{unit.name} is no position of {own}", f"actual_{base.name}")
    return base.factor / unit.factor


def _times(source, table: text.Table, rows: list[Row], column: int) -> list[float] | None:
    """s, of the rows that have readings."""
    times = [(row.line, names.cell_of(row.cells, column)) for row in rows if not row.empty]
    return text.times(source, times, table.decimal)


def _rows(
    source: Source, options: ReadingOptions, table: text.Table, top: int, named: names.Named
) -> tuple[list[Row], list[Fault], bool]:
    """The rows of numbers; empty readings are left out and listed; whether signs are relative."""
    rows: list[Row] = []
    faults: list[Fault] = []
    relative = False
    for line, cells in table.rows[top:]:
        row = _row(line, cells, options.first or 1, table, named)
        relative = relative or row.relative
        faults += [Fault(line, name, _sheet.MISSING) for name in row.empty]
        if row.wrong:
            fault = Fault(line, "", row.wrong)
            faults.append(source.unusable(fault, options.strict, table.delimiter.join(cells)))
        else:
            rows.append(row)
    return rows, faults, relative


def _row(line: int, cells: list[str], start: int, table: text.Table, named: names.Named) -> Row:
    """One row; start: sign of forward."""
    row = Row(line, cells)
    for name, j in named.at.items():
        cell = names.cell_of(cells, j)
        if name == "direction":
            wrong = _take_direction(row, cell, start)
        else:
            wrong = _take_number(row, name, cell, table, name in named.readings)
        row.wrong = row.wrong or wrong
    return row


def _take_direction(row: Row, cell: str, start: int) -> str:
    """Puts the direction of approach into a row; what is wrong with it."""
    way = text.direction(cell)
    if way is None:
        return f"the direction {cell!r} is none, like + -, up down, forward reverse"
    row.sign, row.relative = way[0] * (start if way[1] else 1), way[1]
    return ""


def _take_number(row: Row, name: str, cell: str, table: text.Table, reading: bool) -> str:
    """Puts the number of a cell into a row; what is wrong with it."""
    # all times are read together
    value = row.line if name == "t_s" else text.number(cell, table.decimal)
    if value is not None:
        row.numbers[name] = value
        return text.wrong_run(value) if name == "run" else ""
    if not cell and reading:
        # of several readings in a row one may be missing; the others count
        row.empty.append(name)
        return ""
    return f"{name} {cell!r} is not a number" if cell else f"{name} is empty"
