"""A sheet of evenly spaced values, for controls whose values are typed in and whose file is not
known.

`name = value` lines, then a heading of columns, then rows between commas; `#` begins a comment. It
is gcomp's own layout.
"""

from __future__ import annotations

import numpy as np

from postproc.control_tables import ErrorTable, ExportOptions
from postproc.control_tables import _common as common
from postproc.recordings import Source

#     # remarks
#     axis = X
#     unit = mm
#     start = 0.00000
#     length = 500.00000
#     points = 11
#     position, error_positive, error_negative
#     0.00000, 0.00120, 0.00310
HEAD = ("axis", "unit", "start", "length", "points")


def text(
    table: ErrorTable,
    options: ExportOptions,
    sign: float,
    columns: tuple[str, str],
    comments: list[str],
) -> bytes:
    """The sheet of a table with even nodes; sign times deviation under both columns, or under the
    first alone where the table is the same for both directions."""
    unit, decimals = common.mm_per_unit(options), 5 if options.unit == "mm" else 7
    nodes = table.nodes / unit
    values = [table.forward, table.reverse] if table.two_way else [table.forward]
    values_of_head = (table.moving, options.unit, nodes[0], nodes[-1] - nodes[0], len(nodes))
    head = dict(zip(HEAD, values_of_head, strict=True))
    lines = [f"# {line}" for line in comments]
    lines += [
        f"{k} = {v}" if isinstance(v, (str, int)) else f"{k} = {common.fixed(float(v), decimals)}"
        for k, v in head.items()
    ]
    lines.append(", ".join(["position", *columns[: len(values)]]))
    cells = [nodes, *(sign * v / unit for v in values)]
    lines += [
        ", ".join(common.fixed(float(v), decimals) for v in row) for row in zip(*cells, strict=True)
    ]
    return common.text_of(lines)


def parsed(source: Source, sign: float, columns: tuple[str, str]) -> ErrorTable:
    """The sheet's table. Raises TableError with file and line."""
    head, rows, last = _lines(source, columns)
    if absent := [key for key in HEAD if key not in head]:
        raise common.fault(source, last, f"{absent[0]} is missing")
    if head["axis"] not in ("X", "Y", "Z") or head["unit"] not in ("mm", "inch"):
        raise common.fault(
            source, 1, f"axis {head['axis']} in {head['unit']}: X, Y or Z in mm or inch are read"
        )
    if len(rows) < 2 or head["points"] != str(len(rows)):
        raise common.fault(
            source,
            last,
            f"{len(rows)} rows, and points = {head['points']}",
            "two at least, and as many as stated",
        )
    unit = common.mm_per_unit(ExportOptions(unit=head["unit"]))
    data = np.array(rows).T * unit
    _check_places(source, data[0], head, unit, last)
    return ErrorTable(head["axis"], head["axis"], data[0], sign * data[1], sign * data[-1])


def _check_places(
    source: Source, places: np.ndarray, head: dict[str, str], unit: float, last: int
) -> None:
    """Raises TableError where places, mm, are not even, or not those of the head. unit: mm."""
    gaps = np.diff(places)
    if np.any(gaps <= 0) or np.ptp(gaps) > 0.001:
        raise common.fault(source, last, "the positions do not ascend in even steps")
    start, length = (common.finite(source, 1, head[key], key) * unit for key in ("start", "length"))
    if abs(start - places[0]) > 0.001 or abs(length - (places[-1] - places[0])) > 0.001:
        raise common.fault(source, 1, "start and length do not agree with the rows")


def _take_key(at: common.Line, plain: str, head: dict[str, str]) -> None:
    key, _, value = (part.strip() for part in plain.partition("="))
    if key not in HEAD or key in head:
        raise at.fault(f"{key!r} is not known, or stands twice", f"one each of {', '.join(HEAD)}")
    head[key] = value


def _lines(
    source: Source, columns: tuple[str, str]
) -> tuple[dict[str, str], list[list[float]], int]:
    """The head, the rows of numbers, and the number of the last line that holds anything."""
    head: dict[str, str] = {}
    heading: list[str] = []
    rows: list[list[float]] = []
    last = 1
    for at in common.numbered(source):
        plain = at.text.split("#", 1)[0].strip()
        if not plain:
            continue
        last = at.number
        cells = [cell.strip() for cell in plain.split(",")]
        if heading:
            if len(cells) != len(heading):
                raise at.fault(f"{len(cells)} values under {len(heading)} columns")
            rows.append([at.finite(cell, "the value") for cell in cells])
        elif "=" in plain:
            _take_key(at, plain, head)
        else:
            heading = cells
            if heading not in (["position", columns[0]], ["position", *columns]):
                raise at.fault("not the heading of this sheet", f"position, {', '.join(columns)}")
    return head, rows, last
