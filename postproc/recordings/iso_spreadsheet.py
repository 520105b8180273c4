"""Sheets of a test by ISO 230-2 saved as CSV: targets down, runs across (interleaved or in blocks),
or one reading a row.

Interleaved: up 1, down 1, up 2, ...; blocks: all up, then all down; long: columns target, run,
direction, deviation, and time where it is known (seconds, or ISO 8601).
Headings that name the direction of every column settle it; otherwise the layout must be said. Tabs,
semicolons, commas; decimal commas. Above the table may stand lines of key and value.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from postproc.errors import Place, UsageError
from postproc.recordings import Fault, ReadingOptions, Recording, RecordingError, Source, _sheet
from postproc.recordings import _components as components
from postproc.recordings import _targets as targets
from postproc.recordings import _text as text
from postproc.recordings import _units as units
from postproc.recordings._components import Component
from postproc.recordings._units import Unit

TITLE = "ISO 230-2 sheet as CSV (interleaved, blocks or long)"
TAKES = (
    "axis", "component", "unit", "bidirectional", "first", "layout", "others", "machine", "head",
)  # fmt: skip
EXTRA = {
    "decimal": ". or ,: the decimal sign, where it is not clear",
    "position_unit": "mm, inch or deg: of the targets",
}
#     interleaved   target | up 1 | down 1 | up 2 | down 2      runs 1 2 3 4
#     blocks        target | up 1 | up 2 | down 1 | down 2      runs 1 3 2 4
#     long          target | run | direction | deviation        one reading a row
LAYOUTS = ("interleaved", "blocks", "long")
LONG = {
    "target": re.compile(r"target|position|nominal|soll", re.I),
    "run": re.compile(r"\brun\b|\blauf\b|\bcycle\b", re.I),
    "direction": re.compile(r"^dir|approach|richtung", re.I),
    "value": re.compile(
        r"deviation|reading|value|error|abweichung|pitch|yaw|roll|angle|winkel", re.I
    ),
    "time": re.compile(r"^(time|date|timestamp|zeit|t_s)\b", re.I),
}
WORDS = re.compile(r"up|down|↑|forward|reverse|fwd|rev|run|dir|lauf|richtung", re.I)


def recognises(source: Source) -> bool:
    """A table whose headings name the direction of every column, or name target, run and
    deviation."""
    marked = source.data.startswith(tuple(text.BOMS))
    # laser text, or a binary file: either may hold words like run and forward
    if b"HEADER::" in source.data[:200] or (b"\x00" in source.data[:200] and not marked):
        return False
    try:
        content, _ = text.decoded(source)
        if not WORDS.search(content[:20_000]):
            return False
        table = text.table(source, content)
        if _long(table) is not None:
            return True
        sheet = _sheet.find(source, table)
    except RecordingError:
        return False
    return bool(sheet.columns) and len(sheet.columns) > 1 and all(c.sign for c in sheet.columns)


def read(source: Source, options: ReadingOptions) -> Recording:
    """Raises RecordingError with the line for what is not a number, and where layout, axis or unit
    are open."""
    if options.layout and options.layout not in LAYOUTS:
        raise UsageError(f"--layout {options.layout} is not known", f"one of {', '.join(LAYOUTS)}")
    content, odd = text.decoded(source)
    table = text.table(source, content, text.stated_decimal(options.extra))
    notices = [*table.notices, *odd]
    columns = _long(table)
    if options.layout == "long" or (columns is not None and not options.layout):
        return _read_long(source, options, table, columns, notices)
    return _read_wide(source, options, table, notices)


def _measured(source, options, said, before, heading, notices) -> tuple[Component, Unit, float]:
    """The component, the unit of its readings, and mm (degrees) per unit of the targets under
    `heading`, a line and its words."""
    line, words = heading
    axis = components.axis_in(_sheet.value_of(before, "axis", "achse"))
    component = components.positioning(options, source, axis, said, line, notices)
    unit = components.unit_for(options, source, component, said, line)
    rotary = component.axis in "ABC"
    return (component, unit, _sheet.position_factor(source, words, line, options, rotary, notices))


def _first(options: ReadingOptions, relative: bool, notices: list[str]) -> ReadingOptions:
    """The options still to be heeded where signs that are relative to the first run were turned."""
    if relative and not options.first:
        notices.append("the first direction is not in the file: taken as + (--first - if it was -)")
    return replace(options, first=0, bidirectional=None) if relative else options


def _read_wide(
    source: Source, options: ReadingOptions, table: text.Table, notices: list[str]
) -> Recording:
    """Targets down, runs across."""
    sheet = _sheet.find(source, table)
    if not sheet.columns:
        raise source.fault(sheet.line, "there is no column of readings beside the targets")
    runs, relative = _runs(source, sheet, options)
    said = _sheet.reading_unit(source, sheet)
    heading = (sheet.line, sheet.headings[sheet.target])
    component, unit, scale = _measured(source, options, said, sheet.before, heading, notices)
    found, faults = _sheet.cells(source, table, sheet, options)
    notices += _sheet.missing(faults)
    readings = targets.Readings.of(
        (run, target * scale, value, line, sign)
        for column, line, target, value in found
        for run, sign in [runs[column.at]]
    )
    heed, head = _first(options, relative, notices), _head(sheet.before)
    return targets.recording(source, heed, component, unit, readings, head, notices, faults)


def _long(table: text.Table) -> tuple[int, dict[str, int]] | None:
    """Row and columns of a heading with target, run and deviation among the first rows; None where
    there is none."""
    for k, (_, cells) in enumerate(table.rows[:40]):
        if any(table.numeric(c) for c in cells):
            continue
        names = _long_names(cells)
        # a wide table has a run in many of its headings
        alone = all(len(names[w]) == 1 for w in ("target", "run", "value"))
        if alone and len(names["direction"] + names["time"]) <= 2:
            columns = {what: at[0] for what, at in names.items() if at}
            return (k, columns) if len(set(columns.values())) == len(columns) else None
    return None


def _long_names(cells: list[str]) -> dict[str, list[int]]:
    """Which cells head what in a long table."""
    return {
        what: [j for j, c in enumerate(cells) if c and pattern.search(c)]
        for what, pattern in LONG.items()
    }


@dataclass(frozen=True)
class Row:
    """A row of a long table: its numbers under target, run and value; its sign of approach, and
    whether that is relative to the first run; what is wrong, in which column."""

    line: int
    numbers: dict[str, float | None]
    sign: int
    relative: bool
    time: str
    wrong: str
    column: str


def _row(line: int, cells: list[str], at: dict[str, int], titles: list[str], decimal: str) -> Row:
    """One reading; titles: the headings."""
    # a row may stop short of its headings
    cells = cells + [""] * len(titles)
    cell = {what: cells[j] for what, j in at.items()}
    target, run, value = (text.number(cell[what], decimal) for what in ("target", "run", "value"))
    numbers = {"target": target, "run": run, "value": value}
    way = text.direction(cell.get("direction", ""))
    column = next((what for what, number in numbers.items() if number is None), "")
    if column:
        wrong = f"{titles[at[column]]!r} is not a number"
    elif not (wrong := text.wrong_run(run)) and way is None and "direction" in at:
        wrong = f"{cell['direction']!r} is no direction, like +, -, up, down, forward, reverse"
    return Row(line, numbers, *(way or (0, False)), cell.get("time", ""), wrong, column)


def _read_long(source, options, table, columns, notices) -> Recording:
    """One reading a row."""
    if columns is None:
        raise source.fault(
            table.rows[0][0],
            "there is no heading with target, run and deviation",
            "a long table has these columns, and may have direction",
        )
    top, at = columns
    line, headings = table.rows[top]
    before = _sheet.pairs(table.rows[:top])
    said = units.in_heading(headings[at["value"]]) or units.unit_of(
        _sheet.value_of(before, "unit", "units", "einheit")
    )
    heading = (line, headings[at["target"]])
    component, unit, scale = _measured(source, options, said, before, heading, notices)
    rows: list[Row] = []
    faults: list[Fault] = []
    for number, cells in table.rows[top + 1 :]:
        row = _row(number, cells, at, headings, table.decimal)
        if row.wrong:
            fault = Fault(number, row.column, row.wrong)
            faults.append(source.unusable(fault, options.strict, table.delimiter.join(cells)))
        else:
            rows.append(row)
    heed = _first(options, any(row.relative for row in rows), notices)
    readings = _readings(source, rows, scale, options.first or 1, table.decimal)
    return targets.recording(
        source, heed, component, unit, readings, _head(before), notices, faults
    )


def _readings(
    source: Source, rows: list[Row], scale: float, start: int, decimal: str
) -> targets.Readings:
    """scale: mm (degrees) per unit of the targets; start: sign of the first run."""
    return targets.Readings.of(
        (
            (
                int(row.numbers["run"] or 1),
                (row.numbers["target"] or 0.0) * scale,
                row.numbers["value"] or 0.0,
                row.line,
                row.sign * start if row.relative else row.sign,
            )
            for row in rows
        ),
        t=text.times(source, [(row.line, row.time) for row in rows], decimal),
    )


def _runs(
    source: Source, sheet: _sheet.Sheet, options: ReadingOptions
) -> tuple[dict[int, tuple[int, int]], bool]:
    """Column to (run, sign), runs counted as they alternate; and whether signs are relative to the
    first run."""
    signs = _signs(sheet.columns, options, Place(source.name, sheet.line))
    start = options.first or 1
    counts = {1: 0, -1: 0}
    both = len(set(signs)) == 2
    result = {}
    relative = False
    for column, sign in zip(sheet.columns, signs, strict=True):
        counts[sign] += 1
        # the direction of the first column is that of the odd runs
        run = 2 * counts[sign] - (sign == signs[0]) if both else counts[sign]
        turns = column.relative or not column.sign
        result[column.at] = (run, sign * start if turns else sign)
        relative = relative or turns
    return result, relative


def _signs(columns: list[_sheet.Column], options: ReadingOptions, place: Place) -> list[int]:
    """+1 or -1 of each column: as headings name it, or as the layout has it."""
    named = [c.sign for c in columns]
    n = len(columns)
    if all(named):
        _agree(columns, named, options.layout, place)
        return named
    if any(named):
        odd = next(c for c in columns if not c.sign)
        raise RecordingError(
            f"the heading {odd.title!r} names no direction, and others do",
            "name all or none; a summary is called mean or average",
            place,
        )
    if options.bidirectional is False:
        return [1] * n
    if not options.layout:
        raise RecordingError(
            f"the headings do not say the direction of the {n} columns of readings",
            "say --layout interleaved (up 1, down 1, up 2 ...) or --layout blocks (all up, then all"
            " down), or --bidirectional no",
            place,
        )
    # a mean in an odd column would be taken for a run, and all runs behind it for the other
    # direction
    if n % 2:
        raise RecordingError(
            f"{n} columns of readings are no pairs of there and back",
            "is one of them a mean? --bidirectional no if all went one way",
            place,
        )
    return _laid_out(options.layout, n, 1)


def _agree(columns: list[_sheet.Column], named: list[int], layout: str, place: Place) -> None:
    """Raises RecordingError where the layout that was said contradicts the headings."""
    two = len(set(named)) == 2
    if layout and two and named != _laid_out(layout, len(named), named[0]):
        raise RecordingError(
            f"--layout {layout} does not agree with the headings"
            f" ({', '.join(c.title for c in columns[:4])}, ...)",
            "leave --layout out",
            place,
        )


def _laid_out(layout: str, n: int, first: int) -> list[int]:
    if layout == "interleaved":
        return [first if k % 2 == 0 else -first for k in range(n)]
    return [first] * (n // 2) + [-first] * (n - n // 2)


def _head(before: list[tuple[str, str, int]]) -> dict[str, str]:
    return {
        "machine": _sheet.value_of(before, "machine", "maschine"),
        "instrument": _sheet.value_of(before, "instrument", "messgerät"),
        "date": _sheet.value_of(before, "date", "datum"),
        "operator": _sheet.value_of(before, "operator", "by", "prüfer"),
    }
