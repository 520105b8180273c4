"""gcomp's own table: `name,X_mm,Y_mm,Z_mm,R_mm`, an offset in a line, for what no control writes as
a file.

Columns after the name, in any order and only those needed: X_mm to W_mm and R_mm (a tool's radius),
A_deg to C_deg, and rotation_deg (of a work offset about Z). An empty cell states nothing. X is a
radius. `#` begins a comment line.
"""

from __future__ import annotations

import csv

from postproc.offsets import (
    EXTENDED_NAME,
    KNOWN_NAMES,
    LINEAR,
    ROTARY,
    WORK_NAME,
    Offsets,
    Source,
    canonical,
)

TITLE = "gcomp's own table"
COLUMNS = {f"{axis}_mm": axis for axis in LINEAR + "R"} | {f"{axis}_deg": axis for axis in ROTARY}
TURN = "rotation_deg"
ADVICE = f"columns: name, {', '.join([*COLUMNS, TURN])}; a line is like: G54,100,50,-200"


def recognises(source: Source) -> bool:
    """Whether the first line that is no comment begins with `name` and a comma."""
    for _, line in source.lines():
        if not line.startswith("#"):
            # the first line that is no comment must be the head: other tables begin otherwise
            return line.replace(" ", "").lower().startswith("name,")
    return False


def _name(source: Source, number: int, cell: str, offsets: Offsets) -> str:
    """The offset of a row. Raises UsageError for one that is not known, or stands there already."""
    name = canonical(cell)
    if name is None:
        raise source.fault(number, f"there is no offset {cell[:40]!r}", f"offsets: {KNOWN_NAMES}")
    if name in offsets.work or name in offsets.tools:
        raise source.fault(number, f"{name} stands twice", "keep the one that is true")
    return name


def read(source: Source) -> Offsets:
    """Work and tool offsets by name. Raises UsageError."""
    offsets = Offsets()
    if source.inch or source.diameter:
        offsets.notices.append("the columns of the table are mm and X a radius: they are read so")
    header: list[str] = []
    for number, line in source.lines():
        if line.startswith("#"):
            continue
        cells = _cells(source, number, line)
        if not header:
            header = _header(source, number, cells)
            continue
        if len(cells) != len(header):
            raise source.fault(number, f"{len(cells)} cells under {len(header)} columns", ADVICE)
        name = _name(source, number, cells[0], offsets)
        filled = {c: x for c, x in zip(header[1:], cells[1:], strict=True) if x}
        values = {c: source.number(number, x) for c, x in filled.items()}
        _take(source, number, name, values, offsets)
    return offsets


def _take(
    source: Source, number: int, name: str, values: dict[str, float], offsets: Offsets
) -> None:
    """One row."""
    work = bool(WORK_NAME.fullmatch(name) or EXTENDED_NAME.fullmatch(name))
    if work and "R_mm" in values:
        raise source.fault(number, f"{name} is a work offset, which has no radius", ADVICE)
    if not work and TURN in values:
        raise source.fault(number, f"{name} is a tool, which is not rotated", ADVICE)
    if turn := values.pop(TURN, 0.0):
        offsets.rotation[name] = turn
    into = offsets.work if work else offsets.tools
    into[name] = {COLUMNS[column]: value for column, value in values.items()}


def _cells(source: Source, number: int, line: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line]))]
    except csv.Error as error:
        raise source.fault(number, f"not a line of a CSV table: {error}", ADVICE) from None


def _header(source: Source, number: int, cells: list[str]) -> list[str]:
    """The columns, written as COLUMNS has them."""
    known = {column.lower(): column for column in [*COLUMNS, TURN]}
    header = [cells[0].lower()] + [known.get(cell.lower(), "") for cell in cells[1:]]
    if header[0] != "name" or "" in header or len(set(header)) < len(header):
        raise source.fault(number, "a column is unknown or stands twice", ADVICE)
    return header
