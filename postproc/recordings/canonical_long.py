"""The long table that any instrument's data can be brought to: one reading a row, each with its
component and its unit.

Columns component,axis,target,run,dir,value,unit and, where known, x,y,z (mm, where all axes stood),
t_machine,t_air (degrees Celsius) and time (s, or a date and time of ISO 8601). dir is + or -, up or
down, forward or reverse. One file may hold several components: each becomes a recording.
"""

from __future__ import annotations

import re

from postproc.errors import Place, UsageError
from postproc.recordings import Fault, ReadingOptions, Recording, RecordingError, Source
from postproc.recordings import _components as components
from postproc.recordings import _targets as targets
from postproc.recordings import _text as text
from postproc.recordings import _units as units

TITLE = "long table (component,axis,target,run,dir,value,unit,...)"
TAKES = ("axis", "component", "unit", "first", "others", "machine", "head")
EXTRA = {"decimal": ". or ,: the decimal sign, where it is not clear"}
NEEDED = ("component", "axis", "target", "run", "dir", "value", "unit")
PLACES = {"x": "X_mm", "y": "Y_mm", "z": "Z_mm"}
TEMPERATURES = {"t_machine": "T_machine_C", "t_air": "T_air_C"}


def recognises(source: Source) -> bool:
    first = source.data.lstrip(b"\xef\xbb\xbf").split(b"\n", 1)[0].lower()
    return all(re.search(rb"\b" + name.encode() + rb"\b", first) for name in NEEDED)


def read(source: Source, options: ReadingOptions) -> Recording:
    """The one recording of a file, or the one that --component names. Raises RecordingError where
    there are several."""
    rows, table_notices = _rows(source, options)
    there = _components(rows)
    wanted = components.parsed(options.component).name if options.component else ""
    if wanted and wanted not in there:
        raise UsageError(f"{source.name} holds no {wanted}", f"it holds {', '.join(there)}")
    if not wanted and len(there) > 1:
        raise RecordingError(
            f"the file holds {len(there)} components: {', '.join(there)}",
            "say which: --component " + there[0],
            Place(source.name, next(r["line"] for r in rows if r["component"] == there[1])),
        )
    return _one(source, options, wanted or there[0], rows, table_notices)


def read_all(source: Source, options: ReadingOptions) -> list[Recording]:
    """A recording for each component, in the order in which they begin; only one where --component
    names it."""
    if options.component:
        return [read(source, options)]
    rows, notices = _rows(source, options)
    return [_one(source, options, name, rows, notices) for name in _components(rows)]


def _components(rows: list[dict]) -> list[str]:
    return list(dict.fromkeys(row["component"] for row in rows if "fault" not in row))


def _rows(source: Source, options: ReadingOptions) -> tuple[list[dict], list[str]]:
    """The rows, checked; those that can not be used with their fault, where not strict."""
    content, encoding = text.decoded(source)
    table = text.table(source, content, text.told_decimal(options.extra))
    notices = list(table.notices) + (
        ["the text is not UTF-8: read as cp1252"] if encoding == "cp1252" else []
    )
    line, cells = table.rows[0]
    names = [c.lower() for c in cells]
    place = Place(source.name, line, table.delimiter.join(cells))
    for name in NEEDED:
        if names.count(name) != 1:
            what = "is missing" if name not in names else "stands twice"
            raise RecordingError(
                f"the column {name} {what}",
                f"columns here: {', '.join(c or '(none)' for c in cells)}",
                place,
            )
    rows = []
    for number, row in table.rows[1:]:
        at = Place(source.name, number, table.delimiter.join(row))
        try:
            rows.append(
                _row(
                    dict(zip(names, row, strict=False)),
                    len(row),
                    len(names),
                    number,
                    table.decimal,
                    options,
                )
            )
        except ValueError as error:
            if options.strict:
                raise RecordingError(
                    str(error), "mend the row; --lenient leaves such rows out", at
                ) from None
            rows.append(
                {
                    "fault": Fault(number, "", str(error)),
                    "component": row[0].strip().upper(),
                    "line": number,
                }
            )
    if not any("fault" not in row for row in rows):
        raise RecordingError("there are no rows", "", Place(source.name, line))
    return rows, notices


def _row(
    row: dict[str, str], n: int, wanted: int, line: int, decimal: str, options: ReadingOptions
) -> dict:
    """One row as values. Raises ValueError with the sentence that says what is wrong."""
    if n != wanted:
        raise ValueError(f"{n} cells under {wanted} columns")
    try:
        component = components.parsed(row["component"])
    except UsageError as error:
        raise ValueError(error.message) from None
    if row["axis"].strip().upper() != component.axis:
        raise ValueError(
            f"axis is {row['axis']!r}, and {component.name} belongs to {component.axis}"
        )
    numbers: dict[str, float] = {}
    for name in ("target", "run", "value", *PLACES, *TEMPERATURES):
        cell = row.get(name, "")
        value = text.number(cell, decimal)
        if value is None and (cell or name in NEEDED):
            raise ValueError(f"{name} {cell!r} is not a number" if cell else f"{name} is empty")
        if value is not None:
            numbers[name] = value
    if numbers["run"] != int(numbers["run"]) or not 1 <= numbers["run"] <= 1e6:
        raise ValueError(f"run {numbers['run']:g} is not a whole number from 1 on")
    way = text.direction(row["dir"])
    if way is None:
        raise ValueError(f"dir {row['dir']!r} is no direction, like + or -")
    unit = units.unit_of(row["unit"]) if row["unit"] else None
    if row["unit"] and unit is None:
        raise ValueError(f"{row['unit']!r} is no unit of readings: {', '.join(units.UNITS)}")
    if unit and unit.quantity != components.QUANTITY_OF[component.quantity]:
        raise ValueError(
            f"{component.name} is {components.article(component.quantity)}, and its unit here is"
            f" {unit.name}"
        )
    sign = way[0] * (options.first or 1) if way[1] else way[0]
    return {
        "component": component.name,
        "line": line,
        "sign": sign,
        "relative": way[1],
        "unit": unit,
        "time": row.get("time", ""),
        **numbers,
    }


def _one(
    source: Source, options: ReadingOptions, name: str, every: list[dict], table_notices: list[str]
) -> Recording:
    component = components.parsed(name)
    notices = list(table_notices)
    faults = [row["fault"] for row in every if "fault" in row and row["component"] in ("", name)]
    rows = [row for row in every if "fault" not in row and row["component"] == name]
    if options.axis and options.axis.strip().upper() != component.axis:
        raise UsageError(
            f"--axis {options.axis}, and {name} in {source.name} belongs to {component.axis}",
            "leave --axis out",
        )
    said: dict[str, dict] = {}
    for row in rows:
        if row["unit"]:
            said.setdefault(row["unit"].name, row)
    if len(said) > 1:
        raise RecordingError(
            f"{name} is in {' and in '.join(said)}", "one unit for all readings of a component",
            Place(source.name, list(said.values())[1]["line"]),
        )  # fmt: skip
    unit = components.unit_for(
        options,
        source,
        component,
        next(iter(said.values()))["unit"] if said else None,
        rows[0]["line"],
    )
    if any(row["relative"] for row in rows) and not options.first:
        notices.append(
            "forward is taken as +, reverse as - (--first - if the first run went towards minus)"
        )
    if options.first and not any(row["relative"] for row in rows):
        notices.append("the file says the directions itself (dir): --first is not used")
    columns: dict[str, list[float]] = {}
    for key, column in (PLACES | TEMPERATURES).items():
        has = [row for row in rows if key in row]
        if len(has) == len(rows) and not (
            column == component.position and not _same(source, component, rows, key)
        ):
            columns[column] = [row[key] for row in rows]
        elif has:
            notices.append(f"{name}: {key} is not in every row: left out")
    columns.pop(component.position, None)
    readings = targets.Readings(
        [int(row["run"]) for row in rows],
        [row["target"] for row in rows],
        [row["value"] for row in rows],
        [row["line"] for row in rows],
        [row["sign"] for row in rows],
        columns,
        text.times(source, [(row["line"], row["time"]) for row in rows]),
    )
    heed = ReadingOptions(
        component=name, others=options.others, machine=options.machine, head=options.head
    )
    return targets.recording(
        source, heed, component, unit, readings, head={}, notices=notices, faults=faults
    )


def _same(source: Source, component: components.Component, rows: list[dict], key: str) -> bool:
    """The place of the axis that moved must be its target."""
    for row in rows:
        if abs(row[key] - row["target"]) > 1e-6:
            raise RecordingError(
                f"{key} is {row[key]:g}, and the target of {component.axis} is {row['target']:g}",
                f"{key} is where {component.axis} stood: leave it empty, or mend it",
                Place(source.name, row["line"]),
            )
    return True
