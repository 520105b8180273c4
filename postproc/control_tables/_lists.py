"""Tables that a control only takes at its keyboard: a list to key in, one row a point, and its
reader. No control."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice

from postproc.control_tables import _common as common
from postproc.recordings import Source


def written(remarks: Sequence[str], columns: Sequence[str], rows: Sequence[Sequence[str]]) -> bytes:
    """The list as CSV; remarks stand above it, behind #."""
    return common.text_of([*(f"# {r}" for r in remarks), *map(",".join, [columns, *rows])])


def _row(
    at: common.Line, cells: list[str], columns: Sequence[str], whole: Sequence[int]
) -> list[float]:
    """The numbers behind the axis. Raises TableError."""
    row = [at.finite(c, n) for c, n in zip(cells[1:], columns[1:], strict=True)]
    for i in whole:
        if row[i] != int(row[i]):
            raise at.fault(f"{columns[i + 1]} {cells[i + 1]} is not a whole number")
    return row


def by_axis(
    source: Source, columns: Sequence[str], whole: Sequence[int] = ()
) -> dict[str, list[list[float]]]:
    """Axis letter to rows of numbers, in the order of the columns behind `axis`; `whole`: columns
    without a fraction.

    The first of those columns ascends or descends steadily. Raises TableError with file and line.
    """
    lines = common.csv_rows(common.numbered(source))
    # the same iterator goes on below: the heading is the first row, and rows are what is left of it
    for at, cells in islice(lines, 1):
        if cells != list(columns):
            raise at.fault(f"the columns are {', '.join(cells)}", ",".join(columns))
    result: dict[str, list[list[float]]] = {}
    for at, cells in lines:
        if not common.is_letter(cells[0]):
            raise at.fault(f"{cells[0]!r} is not an axis letter")
        row = _row(at, cells, columns, whole)
        rows = result.setdefault(cells[0].upper(), [])
        if rows and row[0] <= rows[-1][0]:
            raise at.fault(f"{columns[1]} {cells[1]} does not ascend after {rows[-1][0]:g}")
        rows.append(row)
    if not result:
        raise common.fault(source, 1, "there are no rows in this list")
    return result
