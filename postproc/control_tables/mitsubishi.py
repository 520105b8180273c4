"""Mitsubishi memory-type relative error compensation in increments, as a list to key in.

The value between two division points is (division interval - actual movement) x 2 in output units,
-128 to 127, so positive where the axis moved too little: the increments of -deviation, read from
the - side, in half output units (times the scale factor). Source: E68 manual page 292, C64 manual
section 9.2. The same for both directions. The numbers of the parameters that place the points
(reference, first, last, interval) are not written, so the file is unverified.
"""

from __future__ import annotations

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables import _lists as lists
from postproc.recordings import Source

TITLE = "Mitsubishi relative error compensation in increments, a list to key in"
VERIFIED = False
UNVERIFIED = "how the list is entered, and where its points stand"
SIGN = (
    "-deviation, as increments of half output units (values from the manual; the list is"
    " unverified)"
)
EXTRA = {"points": "points of one axis, 1024", "scale": "compensation scale factor, 1"}
COLUMNS = ("axis", "point", "position_mm", "increment")


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One list, point 0 at the reference. Raises TableError for increments beyond -128 to 127."""
    unit = options.step / 2 * common.whole(options, "scale", 1, 1, 99)
    kept, notices = common.own_axis(tables, "the Mitsubishi relative error table")
    remark = (
        "unverified: how the list is entered, and where its points stand (machine error parameters"
        " of the axis)"
    )
    notices.insert(0, remark)
    rows: list[list[str]] = []
    shifts: dict[str, float] = {}
    for table in kept:
        most = common.whole(options, "points", 1024, 2, 1024)
        even, shifts[table.name] = common.even_mean(table, options, most, notices)
        # Sums first, then their differences, so that roundings do not add up along the travel.
        counts = np.rint(-even.forward / unit).astype(int)
        steps = np.diff(counts, prepend=counts[0])
        if steps.min() < -128 or steps.max() > 127:
            raise TableError(
                f"{table.name} has increments from {steps.min()} to {steps.max()}, and -128 to 127"
                " can be held",
                "--set scale=N, or a smaller --spacing",
            )
        home = options.reference.get(table.moving, 0.0)
        first = int(np.argmin(np.abs(even.nodes - home)))
        rows += [
            [table.moving, str(i - first), f"{p:.10g}", str(k)]
            for i, (p, k) in enumerate(zip(even.nodes, steps, strict=True))
        ]
        notices += common.lost_motion(table)
    name = f"{options.program}_mitsubishi.csv"
    data = lists.written([remark], COLUMNS, rows)
    left = common.remainder(kept, read(Source(name, data), options), shifts)
    return Export({name: data}, tuple(notices), left)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """The list's tables, zero at point 0. Raises TableError with file and line."""
    unit = options.step / 2 * common.whole(options, "scale", 1, 1, 99)
    tables = []
    for axis, rows in lists.by_axis(source, COLUMNS, whole=(0, 2)).items():
        point, nodes, steps = np.array(rows).T
        if steps.min() < -128 or steps.max() > 127:
            raise TableError(
                f"{source.name}: increments of {axis} go from {steps.min():g} to {steps.max():g},"
                " beyond -128 to 127"
            )
        total = np.cumsum(steps)
        total -= np.interp(0.0, point, total)
        tables.append(ErrorTable(axis, axis, nodes, -total * unit, -total * unit))
    return tables
