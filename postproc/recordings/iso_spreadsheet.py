"""Sheets of a test by ISO 230-2 saved as CSV: targets down, runs across (interleaved or in blocks),
or one reading a row.

Interleaved: up 1, down 1, up 2, ...; blocks: all up, then all down; long: columns target, run,
direction, deviation, and time where it is known (seconds, or ISO 8601).
Headings that name the direction of every column settle it; otherwise the layout must be said. Tabs,
semicolons, commas; decimal commas. Above the table may stand lines of key and value.
"""

from __future__ import annotations

import re
from dataclasses import replace

from postproc.errors import Place, UsageError
from postproc.recordings import Fault, ReadingOptions, Recording, RecordingError, Source, _sheet
from postproc.recordings import _components as components
from postproc.recordings import _targets as targets
from postproc.recordings import _text as text
from postproc.recordings import _units as units

TITLE = "ISO 230-2 sheet as CSV (interleaved, blocks or long)"
TAKES = (
    "axis",
    "component",
    "unit",
    "bidirectional",
    "first",
    "layout",
    "others",
    "machine",
    "head",
)
EXTRA = {
    "decimal": ". or ,: the decimal sign, where it is not clear",
    "position_unit": "mm, inch or deg: of the targets",
}
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
WORDS = re.compile(r"up|down|↑|forward|reverse|fwd|rev|run|dir", re.I)


def recognises(source: Source) -> bool:
    """A table whose headings name the direction of every column, or name target, run and
    deviation."""
    marked = any(source.data.startswith(mark) for mark in text.BOMS)
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
    content, encoding = text.decoded(source)
    table = text.table(source, content, text.told_decimal(options.extra))
    notices = list(table.notices)
    if encoding == "cp1252":
        notices.append("the text is not UTF-8: read as cp1252")
    columns = _long(table)
    if options.layout == "long" or (columns is not None and not options.layout):
        return _read_long(source, options, table, columns, notices)
    sheet = _sheet.find(source, table)
    if not sheet.columns:
        raise RecordingError(
            "there is no column of readings beside the targets", "", Place(source.name, sheet.line)
        )
    runs, relative = _runs(source, sheet, options)
    start = options.first or 1
    said = _sheet.reading_unit(source, sheet)
    axis = components.axis_in(_sheet.value_of(sheet.before, "axis", "achse"))
    component = components.positioning(options, source, axis, said, sheet.line, notices)
    unit = components.unit_for(options, source, component, said, sheet.line)
    scale = _sheet.position_factor(
        source, sheet.headings[sheet.target], sheet.line, options, component.axis in "ABC", notices
    )
    found, faults = _sheet.cells(source, table, sheet, options)
    notices += _sheet.missing(faults)
    signs = {at: sign * start if at in relative else sign for at, (_, sign) in runs.items()}
    readings = targets.Readings(
        [runs[c.at][0] for c, *_ in found],
        [t * scale for _, _, t, _ in found],
        [v for *_, v in found],
        [line for _, line, *_ in found],
        [signs[c.at] for c, *_ in found],
    )
    if relative and not options.first:
        notices.append("the first direction is not in the file: taken as + (--first - if it was -)")
    told = replace(options, first=0, bidirectional=None) if relative else options
    return targets.recording(
        source,
        told,
        component,
        unit,
        readings,
        head=_head(sheet.before),
        notices=notices,
        faults=faults,
    )


def _long(table: text.Table) -> tuple[int, dict[str, int]] | None:
    """Row and columns of a heading with target, run and deviation among the first rows; None where
    there is none."""
    for k, (_, cells) in enumerate(table.rows[:40]):
        if any(table.numeric(c) for c in cells):
            continue
        names = {
            what: [j for j, c in enumerate(cells) if c and pattern.search(c)]
            for what, pattern in LONG.items()
        }
        # a wide table has a run in many of its headings
        if (
            all(len(names[w]) == 1 for w in ("target", "run", "value"))
            and len(names["direction"] + names["time"]) <= 2
        ):
            columns = {what: at[0] for what, at in names.items() if at}
            return (k, columns) if len(set(columns.values())) == len(columns) else None
    return None


def _read_long(source, options, table, columns, notices) -> Recording:
    """One reading a row."""
    if columns is None:
        raise RecordingError(
            "there is no heading with target, run and deviation",
            "a long table has these columns, and may have direction",
            Place(source.name, table.rows[0][0]),
        )
    top, at = columns
    line, headings = table.rows[top]
    said = next((u for u in (units.in_heading(headings[at["value"]]),) if u), None)
    before = _sheet.pairs(table.rows[:top])
    if said is None:
        said = units.unit_of(_sheet.value_of(before, "unit", "units", "einheit"))
    axis = components.axis_in(_sheet.value_of(before, "axis", "achse"))
    component = components.positioning(options, source, axis, said, line, notices)
    unit = components.unit_for(options, source, component, said, line)
    scale = _sheet.position_factor(
        source, headings[at["target"]], line, options, component.axis in "ABC", notices
    )
    rows: list[tuple[int, float, float, int, int]] = []
    times: list[tuple[int, str]] = []
    faults: list[Fault] = []
    relative = False
    for number, cells in table.rows[top + 1 :]:
        place = Place(source.name, number, table.delimiter.join(cells))
        values = {
            w: text.number(cells[j], table.decimal) if j < len(cells) else None
            for w, j in at.items()
            if w != "time"
        }
        word = cells[at["direction"]] if "direction" in at and at["direction"] < len(cells) else ""
        way = text.direction(word) if "direction" in at else (0, False)
        run = values["run"]
        wrong = next((w for w in ("target", "run", "value") if values[w] is None), "")
        told = f"{headings[at[wrong]]!r} is not a number" if wrong else ""
        if not told and (run is None or run != int(run) or not 1 <= run <= 1e6):
            told = f"run {run:g} is not a whole number from 1 on"
        if not told and way is None:
            told = f"{word!r} is no direction, like +, -, up, down, forward, reverse"
        if told:
            if options.strict:
                raise RecordingError(told, "mend the row; --lenient leaves such rows out", place)
            faults.append(Fault(number, wrong, told))
            continue
        times.append((number, cells[at["time"]] if at.get("time", len(cells)) < len(cells) else ""))
        sign, its = way or (0, False)
        relative = relative or its
        start = options.first or 1
        rows.append(
            (
                int(run or 1),
                float(values["target"] or 0.0),
                float(values["value"] or 0.0),
                number,
                sign * start if its else sign,
            )
        )
    if relative and not options.first:
        notices.append("the first direction is not in the file: taken as + (--first - if it was -)")
    readings = targets.Readings(
        [r[0] for r in rows],
        [r[1] * scale for r in rows],
        [r[2] for r in rows],
        [r[3] for r in rows],
        [r[4] for r in rows],
        t=text.times(source, times, table.decimal),
    )
    told_ = replace(options, first=0, bidirectional=None) if relative else options
    return targets.recording(
        source, told_, component, unit, readings, head=_head(before), notices=notices, faults=faults
    )


def _runs(
    source: Source, sheet: _sheet.Sheet, options: ReadingOptions
) -> tuple[dict[int, tuple[int, int]], set[int]]:
    """Column to (run, sign), runs counted as they alternate; and the columns whose sign is relative
    to the first run."""
    columns, place = sheet.columns, Place(source.name, sheet.line)
    named = [c.sign for c in columns]
    if any(named) and not all(named):
        odd = next(c for c in columns if not c.sign)
        raise RecordingError(
            f"the heading {odd.title!r} names no direction, and others do",
            "name all or none; a summary is called mean or average",
            place,
        )
    n = len(columns)
    if all(named):
        signs = named
        if (
            options.layout
            and len(set(named)) == 2
            and signs not in _laid_out(options.layout, n, named[0])
        ):
            raise RecordingError(
                f"--layout {options.layout} does not agree with the headings"
                f" ({', '.join(c.title for c in columns[:4])}, ...)",
                "leave --layout out",
                place,
            )
        relative = {c.at for c in columns if c.relative}
    elif options.bidirectional is False:
        signs, relative = [1] * n, {c.at for c in columns}
    elif not options.layout:
        raise RecordingError(
            f"the headings do not say the direction of the {n} columns of readings",
            "say --layout interleaved (up 1, down 1, up 2 ...) or --layout blocks (all up, then all"
            " down), or --bidirectional no",
            place,
        )
    elif n % 2:
        raise RecordingError(
            f"{n} columns of readings are no pairs of there and back",
            "is one of them a mean? --bidirectional no if all went one way",
            place,
        )
    else:
        signs, relative = _laid_out(options.layout, n, 1)[0], {c.at for c in columns}
    counts = {1: 0, -1: 0}
    both = len(set(signs)) == 2
    result = {}
    for column, sign in zip(columns, signs, strict=True):
        counts[sign] += 1
        # the direction of the first column is that of the odd runs
        result[column.at] = (
            2 * counts[sign] - (1 if sign == signs[0] else 0) if both else counts[sign],
            sign,
        )
    return result, relative


def _laid_out(layout: str, n: int, first: int) -> list[list[int]]:
    if layout == "interleaved":
        return [[first if k % 2 == 0 else -first for k in range(n)]]
    return [[first] * (n // 2) + [-first] * (n - n // 2)]


def _head(before: list[tuple[str, str, int]]) -> dict[str, str]:
    return {
        "machine": _sheet.value_of(before, "machine", "maschine"),
        "instrument": _sheet.value_of(before, "instrument", "messgerät"),
        "date": _sheet.value_of(before, "date", "datum"),
        "operator": _sheet.value_of(before, "operator", "by", "prüfer"),
    }
