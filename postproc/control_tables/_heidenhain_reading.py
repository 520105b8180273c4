"""Heidenhain's .COM value tables, read back: the line of columns, rows, [END]."""

from __future__ import annotations

import re

import numpy as np

from postproc import intake
from postproc.control_tables import ErrorTable, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.errors import UsageError
from postproc.recordings import Source
from postproc.units import MM_PER_INCH

ENTRIES = 256
FACTOR = {"MM": 1.0, "INCH": MM_PER_INCH}
UNIT = re.compile(r"\b(MM|INCH)\b")
END = re.compile(r"\[END\]|END", re.IGNORECASE)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """A .COM file's tables. The moving axis: options.extra["axis"], or a name like AXIS_Z.COM.
    Raises TableError with file and line."""
    letter = options.extra.get("axis", "").upper() or _moving(source)
    lines = common.numbered(source)
    at, columns = layout(source.text, source.name)
    said = UNIT.search(lines[0].text.upper() * bool(at))
    unit = FACTOR[said[1]] if said else common.mm_per_unit(options)
    rows: list[dict[str, float]] = []
    end = end_of(source.text, at)
    for line in lines[at + 1 : end]:
        rows.append(_entry(line, columns, rows))
    if end is None:
        raise common.fault(source, lines[-1].number, "[END] is missing: the file is not whole")
    if not rows or len(rows) > ENTRIES:
        raise common.fault(source, at + 1, f"{len(rows)} entries: a table has 1 to {ENTRIES}")
    tables = _tables(letter, {h: np.array([row[h] for row in rows]) * unit for h in rows[0]})
    if not tables:
        raise common.fault(source, at + 1, f"no column of an axis: {', '.join(dict(columns))}")
    return tables


def _moving(source: Source) -> str:
    """The moving axis by the name of the file."""
    named = re.search(r"(?:^|[/\\]|AXIS[-_]?)([XYZUVW])\.COM$", source.name, re.IGNORECASE)
    if named is None:
        raise UsageError(
            f"of which moving axis is {source.name}? A .COM table does not say", "--axis X"
        )
    return named[1].upper()


def layout(text: str, name: str) -> tuple[int, list[tuple[str, int]]]:
    """Index of the line with the columns, and each column's name and first character."""
    for i, line in enumerate(intake.lines_of(text)):
        found = [(m[0].upper(), m.start()) for m in re.finditer(r"\S+", line)]
        if found and found[0][0] == "NR" and ("AXISPOS", dict(found).get("AXISPOS")) in found:
            return i, found
    raise TableError(
        f"{name} has no line of columns that begins with NR and holds AXISPOS",
        "export an empty .COM table from the control",
    )


def _entry(
    at: common.Line, columns: list[tuple[str, int]], rows: list[dict[str, float]]
) -> dict[str, float]:
    """The numbers of a row by their column, which are name and first character. Raises TableError
    for a row that can not come after `rows`."""
    # Cells go by the first characters of their headings, not by blanks: an empty cell is one, too.
    edges = [start for _, start in columns[1:]] + [None]
    cells = {h: at.text[a:b].strip() for (h, a), b in zip(columns, edges, strict=True)}
    row = {h: at.finite(c, h) for h, c in cells.items() if c}
    # numbered from 0 without a gap: a row that is lost in a copy shows
    if row.get("NR") != len(rows):
        raise at.fault(f"row {cells['NR']!r} where NR {len(rows)} is due")
    if "AXISPOS" not in row:
        raise at.fault("AXISPOS is empty")
    if rows:
        _check_after(at, row, rows)
    return row


def _check_after(at: common.Line, row: dict[str, float], rows: list[dict[str, float]]) -> None:
    """Raises TableError for a row that does not go on from those before."""
    before = rows[-1]["AXISPOS"]
    if row["AXISPOS"] <= before:
        raise at.fault(f"AXISPOS {row['AXISPOS']:g} does not ascend after {before:g}")
    if row.keys() != rows[0].keys():
        raise at.fault("a value is missing that the first row has, or one too many")


def end_of(text: str, at: int) -> int | None:
    """Index of the line [END] behind the one with the columns, None where there is none."""
    lines = enumerate(intake.lines_of(text))
    return next((i for i, line in lines if i > at and END.match(line.strip())), None)


def _tables(letter: str, column: dict[str, np.ndarray]) -> list[ErrorTable]:
    """A table for each column of an axis; letter: the axis that moves."""
    own = {letter: column["BACKLASH"]} if "BACKLASH" in column else {}
    return [
        ErrorTable(letter, head, column["AXISPOS"], values, own.get(head, values))
        for head, values in column.items()
        if head in ("X", "Y", "Z", "U", "V", "W")
    ]
