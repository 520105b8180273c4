"""A table of targets by runs, as spreadsheets and laser programs have it: where it begins, what its
columns are, its unit."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable
from dataclasses import dataclass

from postproc.errors import Place, UsageError
from postproc.recordings import Fault, ReadingOptions, RecordingError, Source
from postproc.recordings import _text as text
from postproc.recordings import _units as units
from postproc.recordings._units import Unit
from postproc.units import MM_PER_INCH

SUMMARY = re.compile(
    r"^(mean|average|avg|mittel\w*|std\.?|stdev|standard|sigma|s|b|r|e|a|m|u|x̄|min|max|range|reversal|repeatability|remarks?|notes?|comment)\b",
    re.I,
)
TARGET = re.compile(
    r"target|position|nominal|soll|^p_?i?$|^[xyzabc](?:[ _]?(?:mm|deg|axis|achse).*)?$", re.I
)
TARGET_NUMBER = re.compile(r"^(i|no\.?|nr\.?|#|point|punkt)$", re.I)
RUN = re.compile(r"\brun\b|\blauf\b|\bcycle\b|\bj\s*=|^\s*[0-9]+\s*$", re.I)
MISSING = "the reading is missing"
POSITION = {"mm": 1.0, "inch": MM_PER_INCH, "deg": 1.0}


@dataclass(frozen=True)
class Column:
    """A column of readings. at: its number from 0; sign and relative as the heading says (0: it
    does not); title."""

    at: int
    title: str
    sign: int
    relative: bool


@dataclass(frozen=True)
class Sheet:
    """rows: (line, cells) of the targets; target: number of their column; columns of readings;
    before: key and value pairs above the table; unit: of the readings, as headings say; position:
    factor to mm; line: of the heading."""

    rows: list[tuple[int, list[str]]]
    headings: list[str]
    target: int
    columns: list[Column]
    before: list[tuple[str, str, int]]
    after: list[tuple[str, str, int]]
    line: int


def header_at(table: text.Table) -> int | None:
    """Index of the first row whose own first filled cells are numbers after a row of words; None
    where there is none."""
    for k, (_, cells) in enumerate(table.rows):
        filled = [c for c in cells if c]
        if len(filled) >= 2 and all(table.numeric(c) for c in filled) and len(cells) >= 2:
            return k
    return None


def _targets_and_readings(headings: list[str]) -> tuple[int, list[Column]]:
    """The column of the targets, and those of readings."""
    counts = [bool(TARGET_NUMBER.match(title)) for title in headings]
    target = next((j for j, h in enumerate(headings) if TARGET.search(h) and not counts[j]), 0)
    return target, [
        Column(j, title or f"column {j + 1}", *_direction(title))
        for j, title in enumerate(headings)
        if j != target and not counts[j] and not SUMMARY.match(title)
    ]


def find(source: Source, table: text.Table) -> Sheet:
    """The table of targets in a sheet. Raises RecordingError where there is none."""
    top = header_at(table)
    if top is None:
        raise source.fault(table.rows[0][0], "there is no row of numbers: no target and readings")
    width = len(table.rows[top][1])
    bottom = top
    #     Machine; mill-7            before: key and value
    #     ;Run 1;;Run 2;             names pairs of columns
    #     Target;up;down;up;down     headings
    #     0;0.1;0.4;...              top
    #     ...
    #     mean; ...                  bottom: its first cell is no number
    while bottom < len(table.rows) and _belongs(table, table.rows[bottom][1], width):
        bottom += 1
    headings, used = _headings(table, top, width)
    target, columns = _targets_and_readings(headings)
    line = table.rows[top - 1][0] if used else table.rows[top][0]
    return Sheet(
        table.rows[top:bottom], headings, target, columns, pairs(table.rows[: top - used]),
        pairs(table.rows[bottom:]), line,
    )  # fmt: skip


def _belongs(table: text.Table, cells: list[str], width: int) -> bool:
    """A row of the table begins with a number and has its width; a cell that is no number is a
    fault, not the end."""
    first = next((c for c in cells if c), "")
    return table.numeric(first) and len(cells) > 1 and sum(1 for c in cells if c) >= min(2, width)


def _heads_runs(row: list[str]) -> bool:
    """Whether a row names runs or directions, over pairs of columns."""
    labels = [c for c in row[1:] if c]
    named = all(RUN.search(c) or _direction(c)[0] for c in labels)
    return len(row) > 2 and bool(labels) and named


def _headings(table: text.Table, top: int, width: int) -> tuple[list[str], int]:
    """A heading for each column: of the row above the table and, where it heads pairs of columns,
    of the one above that."""
    rows = [cells for _, cells in table.rows[max(0, top - 2) : top]]
    if not rows or sum(map(bool, rows[-1])) < 2:
        return [""] * width, 0
    *upper, lower = ((cells + [""] * width)[:width] for cells in rows)
    if not upper or not _heads_runs(rows[0]):
        return lower, 1
    # a merged cell stands in the first of its columns, and is empty in the others
    spread: Iterable[str] = itertools.accumulate(upper[0], lambda last, cell: cell or last)
    return [" ".join(filter(None, pair)) for pair in zip(spread, lower, strict=True)], 2


def _direction(title: str) -> tuple[int, bool]:
    """Sign and relative of the one word of direction in a heading; (0, False) where it has none."""
    # Brackets hold units, "(mm)", and now and then a sign, "(+)": of these only the sign is kept.
    plain = re.sub(
        r"[(\[][^()\[\]]*[)\]]",
        lambda m: m[0] if re.fullmatch(r"[(\[]\s*[-+↑↓\u2212]\s*[)\]]", m[0]) else " ",
        title,
    )
    for word in re.findall(r"[↑↓]|[^\W\d_]+|[-+\u2212](?![\w])", plain):
        found = text.direction(word)
        if found and not word.isdigit():
            return found
    return 0, False


def pairs(rows: list[tuple[int, list[str]]]) -> list[tuple[str, str, int]]:
    """Lines like `Machine;mill-7` or `Machine: mill-7`, with where they stand."""
    result = []
    for line, cells in rows:
        filled = [c for c in cells if c]
        if filled and ":" in filled[0] and not filled[0].endswith(":"):
            key, _, value = filled[0].partition(":")
            result.append((key.strip(), value.strip(), line))
        elif len(filled) >= 2:
            result.append((filled[0].rstrip(":").strip(), filled[1], line))
    return result


def value_of(pairs: list[tuple[str, str, int]], *names: str) -> str:
    """The value of the first pair with one of these keys (lower case), or nothing."""
    return next((v for k, v, _ in pairs if k.lower() in names), "")


def _unit_of_line(key: str, value: str, guess: bool) -> tuple[Unit | None, str]:
    """The unit that a line above the table names, and its words. guess: by its key alone too."""
    if re.fullmatch(r"units?|einheit(en)?|deviations?|readings?", key, re.I):
        return units.unit_of(value) or units.in_heading(value), f"{key}: {value}"
    if guess and re.search(r"deviation|reading|error|abweichung", key, re.I):
        return units.in_heading(key), key
    return None, key


def reading_unit(source: Source, sheet: Sheet) -> Unit | None:
    """The unit that the headings of the readings agree on, or a line `Unit`. Raises RecordingError
    where they differ."""
    said = {u.name: c.title for c in reversed(sheet.columns) if (u := units.in_heading(c.title))}
    for key, value, _ in sheet.before:
        unit, where = _unit_of_line(key, value, not said)
        if unit:
            said.setdefault(unit.name, where)
    if len(said) > 1:
        raise source.fault(
            sheet.line,
            f"the readings are in {' and in '.join(said)}:"
            f" {', '.join(repr(v) for v in said.values())}",
            "one unit for all",
        )
    return units.UNITS[next(iter(said))] if said else None


def position_factor(
    source: Source,
    heading: str,
    line: int,
    options: ReadingOptions,
    rotary: bool,
    notices: list[str],
) -> float:
    """mm (degrees of a rotary axis) of one unit of the targets: as their heading says, or --set
    position_unit."""
    said = options.extra.get("position_unit", "")
    usual = "deg" if rotary else "mm"
    unit = units.named(said, "--set position_unit") if said else units.in_heading(heading)
    if unit is None:
        notices.append(
            f"the unit of the targets is not in the file: taken as {usual} (--set"
            " position_unit=...)"
        )
        return 1.0
    # targets in um or arcsec: rather a column of readings that was taken for the targets
    if unit.name not in POSITION or (unit.name == "deg") != rotary:
        text_ = (
            f"the targets are in {unit.name}, and the axis is {'rotary' if rotary else 'linear'}"
        )
        if said:
            raise UsageError(text_, f"--set position_unit={usual}")
        raise source.fault(line, text_, "another --axis or --component")
    return POSITION[unit.name]


def missing(faults: list[Fault]) -> list[str]:
    """A notice for the readings that are not there."""
    n = sum(1 for f in faults if f.message == MISSING)
    return [f"{n} reading{'s are' if n > 1 else ' is'} missing and left out"] if n else []


def _check_width(row: list[str], width: int, sheet: Sheet, place: Place) -> None:
    """Raises RecordingError for a row with more than its headings. width: of what is read."""
    if len(row) > max(width, len(sheet.headings)) and any(row[len(sheet.headings) :]):
        raise RecordingError(
            f"this row has {len(row)} cells under {len(sheet.headings)} columns",
            "a decimal comma in a table split at commas? Say --set decimal=, and split it at"
            " semicolons",
            place,
        )


def cells(
    source: Source, table: text.Table, sheet: Sheet, options: ReadingOptions
) -> tuple[list, list[Fault]]:
    """(column, line, target, value) of every reading; and the faults: cells that are empty, or not
    numbers where not strict.

    Raises RecordingError for a target or, where strict, a reading that is not a number.
    """
    found: list[tuple[Column, int, float, float]] = []
    faults: list[Fault] = []
    width = max([sheet.target, *(c.at for c in sheet.columns)]) + 1
    for line, cells in sheet.rows:
        place = Place(source.name, line, table.delimiter.join(cells))
        row = cells + [""] * (width - len(cells))
        target = text.number(row[sheet.target], table.decimal)
        if target is None:
            raise RecordingError(f"the target {row[sheet.target]!r} is not a number", "", place)
        _check_width(row, width, sheet, place)
        for column in sheet.columns:
            cell = row[column.at]
            if (value := text.number(cell, table.decimal)) is not None:
                found.append((column, line, target, value))
                continue
            if cell and options.strict:
                raise RecordingError(
                    f"{cell!r} under {column.title!r} is not a number",
                    "mend it; --lenient leaves such readings out",
                    place,
                )
            faults.append(
                Fault(line, column.title, f"{cell!r} is not a number" if cell else MISSING)
            )
    return found, faults
