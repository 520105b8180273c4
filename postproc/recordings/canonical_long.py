"""The long table that any instrument's data can be brought to: one reading a row, each with its
component and its unit.

Columns component,axis,target,run,dir,value,unit and, where known, x,y,z (mm, where all axes stood),
t_machine,t_air (degrees Celsius) and time (s, or a date and time of ISO 8601). dir is + or -, up or
down, forward or reverse. One file may hold several components: each becomes a recording.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from postproc.errors import UsageError
from postproc.recordings import Fault, ReadingOptions, Recording, Source
from postproc.recordings import _components as components
from postproc.recordings import _targets as targets
from postproc.recordings import _text as text
from postproc.recordings import _units as units

#     component,axis,target,run,dir,value,unit,t_air
#     EZZ,Z,0.0,1,+,0.7,um,20.1
#     EZZ,Z,50.0,1,+,3.1,um,20.1
#     EBZ,Z,0.0,1,+,1.2,arcsec,20.1        another component: a recording of its own
TITLE = "long table (component,axis,target,run,dir,value,unit,...)"
TAKES = ("axis", "component", "unit", "first", "others", "machine", "head")
EXTRA = {"decimal": ". or ,: the decimal sign, where it is not clear"}
NEEDED = ("component", "axis", "target", "run", "dir", "value", "unit")
PLACES = {"x": "X_mm", "y": "Y_mm", "z": "Z_mm"}
TEMPERATURES = {"t_machine": "T_machine_C", "t_air": "T_air_C"}


@dataclass(frozen=True)
class Row:
    """A row as values, or its fault; numbers by the name of their column; relative: whether the
    sign is so to the first run."""

    line: int
    component: str
    fault: Fault | None = None
    sign: int = 0
    relative: bool = False
    unit: units.Unit | None = None
    time: str = ""
    numbers: dict[str, float] = field(default_factory=dict)


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
        raise source.fault(
            next(r.line for r in rows if r.component == there[1]),
            f"the file holds {len(there)} components: {', '.join(there)}",
            "say which: --component " + there[0],
        )
    return _one(source, options, wanted or there[0], rows, table_notices)


def read_all(source: Source, options: ReadingOptions) -> list[Recording]:
    """A recording for each component, in the order in which they begin; only one where --component
    names it."""
    if options.component:
        return [read(source, options)]
    rows, notices = _rows(source, options)
    return [_one(source, options, name, rows, notices) for name in _components(rows)]


def _components(rows: list[Row]) -> list[str]:
    return list(dict.fromkeys(row.component for row in rows if row.fault is None))


def _rows(source: Source, options: ReadingOptions) -> tuple[list[Row], list[str]]:
    """The rows, checked; those that can not be used with their fault, where not strict."""
    content, odd = text.decoded(source)
    table = text.table(source, content, text.stated_decimal(options.extra))
    notices = [*table.notices, *odd]
    names = _names(source, table)
    rows = []
    for number, row in table.rows[1:]:
        try:
            rows.append(_row(names, row, number, table.decimal, options.first or 1))
        except ValueError as error:
            if options.strict:
                raise source.fault(
                    number,
                    str(error),
                    advice="mend the row; --lenient leaves such rows out",
                    text=table.delimiter.join(row),
                ) from None
            rows.append(Row(number, row[0].strip().upper(), Fault(number, "", str(error))))
    if all(row.fault for row in rows):
        raise source.fault(table.rows[0][0], "there are no rows")
    return rows, notices


def _names(source: Source, table: text.Table) -> list[str]:
    """Names of the columns, in small letters. Raises RecordingError where a needed one is not there
    once."""
    line, cells = table.rows[0]
    names = [c.lower() for c in cells]
    for name in NEEDED:
        if names.count(name) != 1:
            what = "is missing" if name not in names else "stands twice"
            raise source.fault(
                line,
                f"the column {name} {what}",
                f"columns here: {', '.join(c or '(none)' for c in cells)}",
                table.delimiter.join(cells),
            )
    return names


def _row(names: list[str], cells: list[str], line: int, decimal: str, start: int) -> Row:
    """One row as values; start: sign of the first run. Raises ValueError with the sentence that
    says what is wrong."""
    if len(cells) != len(names):
        raise ValueError(f"{len(cells)} cells under {len(names)} columns")
    row = dict(zip(names, cells, strict=True))
    try:
        component = components.parsed(row["component"])
    except UsageError as error:
        raise ValueError(error.message) from None
    if row["axis"].strip().upper() != component.axis:
        raise ValueError(
            f"axis is {row['axis']!r}, and {component.name} belongs to {component.axis}"
        )
    numbers = _numbers(row, decimal)
    way = text.direction(row["dir"])
    if way is None:
        raise ValueError(f"dir {row['dir']!r} is no direction, like + or -")
    unit = _unit(row["unit"], component)
    sign = way[0] * start if way[1] else way[0]
    time = row.get("time", "")
    if decimal == "," and text.number(time, decimal) is not None:
        time = time.replace(",", ".")
    return Row(line, component.name, None, sign, way[1], unit, time, numbers)


def _numbers(row: dict[str, str], decimal: str) -> dict[str, float]:
    numbers: dict[str, float] = {}
    for name in ("target", "run", "value", *PLACES, *TEMPERATURES):
        cell = row.get(name, "")
        if (value := text.number(cell, decimal)) is not None:
            numbers[name] = value
        elif cell or name in NEEDED:
            raise ValueError(f"{name} {cell!r} is not a number" if cell else f"{name} is empty")
    if wrong := text.wrong_run(numbers["run"]):
        raise ValueError(wrong)
    return numbers


def _unit(cell: str, component: components.Component) -> units.Unit | None:
    """The unit of a row, where it has one."""
    if not cell:
        return None
    unit = units.unit_of(cell)
    if unit is None:
        raise ValueError(f"{cell!r} is no unit of readings: {', '.join(units.UNITS)}")
    if unit.quantity != components.QUANTITY_OF[component.quantity]:
        raise ValueError(
            f"{component.name} is {components.article(component.quantity)}, and its unit here is"
            f" {unit.name}"
        )
    return unit


def _of_directions(rows: list[Row], options: ReadingOptions) -> list[str]:
    """A notice where directions are relative and nothing says to what, or the other way round."""
    relative = any(row.relative for row in rows)
    if relative == bool(options.first):
        return []
    if relative:
        return [
            "forward is taken as +, reverse as - (--first - if the first run went towards minus)"
        ]
    return ["the file says the directions itself (dir): --first is not used"]


def _one(
    source: Source, options: ReadingOptions, name: str, every: list[Row], table_notices: list[str]
) -> Recording:
    component = components.parsed(name)
    notices = list(table_notices)
    faults = [row.fault for row in every if row.fault and row.component in ("", name)]
    rows = [row for row in every if not row.fault and row.component == name]
    if options.axis and options.axis.strip().upper() != component.axis:
        raise UsageError(
            f"--axis {options.axis}, and {name} in {source.name} belongs to {component.axis}",
            "leave --axis out",
        )
    said = _one_unit(source, name, rows)
    unit = components.unit_for(options, source, component, said, rows[0].line)
    notices += _of_directions(rows, options)
    # Directions are in the file and turned already; unit and axis were asked for above. What is
    # left to be heeded is where the others stood.
    heed = ReadingOptions(
        component=name, others=options.others, machine=options.machine, head=options.head
    )
    readings = _readings(source, component, rows, notices)
    return targets.recording(source, heed, component, unit, readings, {}, notices, faults)


def _one_unit(source: Source, name: str, rows: list[Row]) -> units.Unit | None:
    """The unit that all rows of a component have; None where none says one."""
    said: dict[str, tuple[units.Unit, int]] = {}
    for row in rows:
        if row.unit:
            said.setdefault(row.unit.name, (row.unit, row.line))
    if len(said) > 1:
        both = f"{name} is in {' and in '.join(said)}"
        raise source.fault(
            list(said.values())[1][1], both, "one unit for all readings of a component"
        )
    return next((unit for unit, _ in said.values()), None)


def _places(
    source: Source, component: components.Component, rows: list[Row], notices: list[str]
) -> dict[str, list[float]]:
    """The places and temperatures that all rows have, by column."""
    columns: dict[str, list[float]] = {}
    for key, column in (PLACES | TEMPERATURES).items():
        has = [row.numbers[key] for row in rows if key in row.numbers]
        # a column with gaps would need numbers that nobody has read
        if has and len(has) < len(rows):
            notices.append(f"{component.name}: {key} is not in every row: left out")
        elif has and column == component.position:
            _same(source, component, rows, key)
        elif has:
            columns[column] = has
    return columns


def _readings(
    source: Source, component: components.Component, rows: list[Row], notices: list[str]
) -> targets.Readings:
    """The readings of a component, with the places and temperatures that all its rows have."""
    return targets.Readings.of(
        (
            (int(n["run"]), n["target"], n["value"], row.line, row.sign)
            for row in rows
            for n in [row.numbers]
        ),
        columns=_places(source, component, rows, notices),
        t=text.times(source, [(row.line, row.time) for row in rows]),
    )


def _same(source: Source, component: components.Component, rows: list[Row], key: str) -> None:
    """The place of the axis that moved must be its target."""
    for row in rows:
        there, target = row.numbers[key], row.numbers["target"]
        if abs(there - target) > 1e-6:
            raise source.fault(
                row.line,
                f"{key} is {there:g}, and the target of {component.axis} is {target:g}",
                f"{key} is where {component.axis} stood: leave it empty, or mend it",
            )
