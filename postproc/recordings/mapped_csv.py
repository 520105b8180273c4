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

import re
from dataclasses import replace

from postproc.errors import Place, UsageError
from postproc.recordings import Fault, ReadingOptions, Recording, RecordingError, Source, _sheet
from postproc.recordings import _components as components
from postproc.recordings import _mapped_kinds as kinds
from postproc.recordings import _targets as targets
from postproc.recordings import _text as text
from postproc.recordings import _units as units
from postproc.units import MM_PER_INCH

TITLE = "any CSV, by --column NAME=HEADING"
TAKES = (
    "axis",
    "component",
    "unit",
    "bidirectional",
    "first",
    "columns",
    "others",
    "machine",
    "head",
)
EXTRA = {
    "decimal": ". or ,: the decimal sign, where it is not clear",
    "delimiter": "tab, semicolon, bar or comma, where it is not clear",
}
POSITION = re.compile(r"([XYZ])_(mm|in|inch)|([ABC])_(deg)")
READING = re.compile(r"(reading|actual)(?:_(.+))?")
WAY = re.compile(r"(forward|reverse)([0-9]{0,3})(?:_(.+))?")
OTHER = re.compile(r"run|direction|t_s|T_\w+_C|load_\w+_N|force_\w+_N|spindle_rpm|feed_mm_min")
DELIMITER = {"tab": "\t", "semicolon": ";", "bar": "|", "comma": ","}


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
    content, encoding = text.decoded(source)
    sign = options.extra.get("delimiter", "")
    if sign and sign not in DELIMITER:
        raise UsageError(f"--set delimiter={sign} is not known", f"one of {', '.join(DELIMITER)}")
    table = text.table(source, content, text.told_decimal(options.extra), DELIMITER.get(sign, ""))
    notices = list(table.notices) + (
        ["the text is not UTF-8: read as cp1252"] if encoding == "cp1252" else []
    )
    top, at = _columns(source, table, mapping)
    if kinds.is_other(mapping):
        return kinds.read(source, options, table, top, at, notices)
    return _targets(source, options, table, top, at, notices)


def _columns(
    source: Source, table: text.Table, mapping: dict[str, str]
) -> tuple[int, dict[str, int]]:
    """Index of the first row of data, and each name's column from 0. Raises RecordingError for a
    heading that is not there."""
    named = {n: h for n, h in mapping.items() if not h.strip().isdigit()}
    top = -1
    headings: list[str] = []
    for k, (_, cells) in enumerate(table.rows):
        lower = [c.lower() for c in cells]
        if named and all(h.strip().lower() in lower for h in named.values()):
            top, headings = k, cells
            break
    if named and top < 0:
        k = max(
            range(min(len(table.rows), 30)),
            key=lambda i: sum(
                h.strip().lower() in [c.lower() for c in table.rows[i][1]] for h in named.values()
            ),
        )
        line, cells = table.rows[k]
        gone = next(
            h for h in named.values() if h.strip().lower() not in [c.lower() for c in cells]
        )
        raise RecordingError(
            f"no column is called {gone!r}",
            f"columns here: {', '.join(c or '(none)' for c in cells)}",
            Place(source.name, line),
        )
    at: dict[str, int] = {}
    for name, heading in mapping.items():
        if heading.strip().isdigit():
            at[name] = int(heading) - 1
            continue
        same = [j for j, c in enumerate(headings) if c == heading.strip()] or [
            j for j, c in enumerate(headings) if c.lower() == heading.strip().lower()
        ]
        if len(same) > 1:
            raise RecordingError(
                f"{len(same)} columns are called {heading!r}",
                f"say which by its number: --column {name}={same[0] + 1}",
                Place(source.name, table.rows[top][0]),
            )
        at[name] = same[0]
    widest = max(len(cells) for _, cells in table.rows)
    for name, j in at.items():
        if not 0 <= j < widest:
            raise UsageError(
                f"--column {name}={j + 1}: the table has {widest} columns", "they count from 1"
            )
    if top < 0:
        rows = (
            k
            for k, (_, cells) in enumerate(table.rows)
            if any(j < len(cells) and table.numeric(cells[j]) for j in at.values())
        )
        top = next(rows, 0) - 1
    return top + 1, at


def _targets(source, options, table, top, at, notices) -> Recording:
    """Readings at targets, one a row or several."""
    positions = {n: (m[1] or m[3], m[2] or m[4]) for n in at for m in (POSITION.fullmatch(n),) if m}
    ways = {
        n: (1 if m[1] == "forward" else -1, int(m[2] or 1), m[3] or "")
        for n in at
        for m in (WAY.fullmatch(n),)
        if m
    }
    values = {n: (m[1], m[2] or "") for n in at for m in (READING.fullmatch(n),) if m}
    unknown = [
        n
        for n in at
        if n not in positions and n not in ways and n not in values and not OTHER.fullmatch(n)
    ]
    if unknown:
        raise UsageError(
            f"--column {unknown[0]}=... is no column of a recording",
            "Z_mm, reading_um, actual_mm, forward_um, reverse_um, run, direction, t_s,"
            " T_air_C, ...",
        )
    if not positions:
        raise UsageError("the mapping names no position", "like --column Z_mm=Position")
    if bool(ways) == bool(values) or len(values) > 1:
        raise UsageError(
            "the mapping must name one column of readings, or columns forward and reverse",
            "like --column reading_um=Deviation",
        )
    if ways and ("run" in at or "direction" in at):
        raise UsageError(
            "forward and reverse say run and direction already",
            "leave run and direction out of the mapping",
        )
    moving = (
        options.component and components.parsed(options.component).axis
    ) or options.axis.strip().upper()
    letters = [letter for letter, _ in positions.values()]
    if moving and moving not in letters:
        raise UsageError(
            f"the mapping names no position of {moving}", f"like --column {moving}_mm=Position"
        )
    if not moving and len(letters) > 1:
        raise UsageError(
            f"the mapping names positions of {', '.join(letters)}",
            "say which axis moved: --axis Z, or --component EXZ",
        )
    said = _unit({w[2] for w in ways.values() if w[2]} | {v[1] for v in values.values() if v[1]})
    where = table.rows[top - 1][0] if top else 1
    component = components.positioning(options, source, moving or letters[0], said, where, notices)
    unit = components.unit_for(options, source, component, said, where)
    factors = {n: MM_PER_INCH if u.startswith("in") else 1.0 for n, (_, u) in positions.items()}
    own = next(n for n, (letter, _) in positions.items() if letter == component.axis)
    rows, faults, relative = _rows(source, options, table, top, at, list(ways or values), notices)
    actual = any(what == "actual" for what, _ in values.values())
    to_unit = _actual_factor(unit, own) if actual else 0.0

    start = options.first or 1
    result = targets.Readings(
        [],
        [],
        [],
        [],
        [],
        {
            n: []
            for n in at
            if n != own
            and (n in positions or OTHER.fullmatch(n))
            and n not in ("run", "direction", "t_s")
        },
    )
    lists: tuple[list, ...] = (result.run, result.target, result.value, result.line, result.sign)  # type: ignore[assignment]
    rename = {
        n: f"{letter}_{'mm' if letter in 'XYZ' else 'deg'}" for n, (letter, _) in positions.items()
    }
    times: list[tuple[int, str]] = []
    every = dict(table.rows)
    both = len({w for w, *_ in ways.values()}) == 2
    for line, row, sign in rows:
        target = row[own] * factors[own]
        for name in [*ways, *values]:
            if name not in row:
                continue
            run, way = int(row.get("run", 1)), sign
            if name in ways:
                way, count = ways[name][0] * start, ways[name][1]
                run = 2 * count - (ways[name][0] > 0) if both else count
            value = row[name] - row[own] * factors[own] * to_unit if actual else row[name]
            for values_, v in zip(lists, (run, target, value, line, way), strict=True):
                values_.append(v)
            for extra, cells in result.columns.items():
                cells.append(row[extra] * factors.get(extra, 1.0))  # type: ignore[attr-defined]
            times.append((line, _cell(every[line], at.get("t_s", -1))))
    if (ways or relative) and not options.first:
        notices.append(
            "forward is taken as +, reverse as - (--first - if forward went towards minus)"
        )
    result = replace(
        result,
        columns={rename.get(n, n): c for n, c in result.columns.items()},
        t=text.times(source, times, table.decimal) if "t_s" in at and not ways else None,
        sign=result.sign if ways or "direction" in at else (),
    )
    heed = replace(options, first=0, bidirectional=None) if ways or relative else options
    return targets.recording(
        source, heed, component, unit, result, head={}, notices=notices, faults=faults
    )


def _cell(cells: list[str], at: int) -> str:
    """The cell of a column; empty where there is none."""
    return cells[at] if 0 <= at < len(cells) else ""


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


def _rows(source, options, table, top, at, readings, notices) -> tuple[list, list[Fault], bool]:
    """(line, name to number, sign) of every row; empty readings are left out and listed; whether
    signs are relative."""
    rows: list[tuple[int, dict[str, float], int]] = []
    faults: list[Fault] = []
    relative = False
    start = options.first or 1
    for line, cells in table.rows[top:]:
        place = Place(source.name, line, table.delimiter.join(cells))
        row: dict[str, float] = {}
        sign, wrong = 0, ""
        for name, j in at.items():
            cell = cells[j] if j < len(cells) else ""
            if name == "direction":
                way = text.direction(cell)
                if way is None:
                    wrong = (
                        wrong
                        or f"the direction {cell!r} is none, like + -, up down, forward reverse"
                    )
                else:
                    relative = relative or way[1]
                    sign = way[0] * start if way[1] else way[0]
                continue
            if name == "t_s":
                row[name] = line  # all times are read together
                continue
            value = text.number(cell, table.decimal)
            if value is None and not cell and name in readings:
                faults.append(Fault(line, name, _sheet.MISSING))
            elif value is None:
                wrong = wrong or (
                    f"{name} {cell!r} is not a number" if cell else f"{name} is empty"
                )
            elif name == "run" and not (value == int(value) and 1 <= value <= 1e6):
                wrong = wrong or f"run {value:g} is not a whole number from 1 on"
            else:
                row[name] = value
        if wrong and options.strict:
            raise RecordingError(wrong, "mend the row; --lenient leaves such rows out", place)
        if wrong:
            faults.append(Fault(line, "", wrong))
        else:
            rows.append((line, row, sign))
    notices += _sheet.missing(faults)
    return rows, faults, relative
