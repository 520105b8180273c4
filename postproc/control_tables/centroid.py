"""Centroid's ballscrew ("laser") compensation: a sheet of values, and the table of the oldest
software, cnc7x.tab.

The control keeps a .tab file per axis: a header with axis, length, interval and unit, then the
correction at every point; from CNC7 v7.50 on two corrections, for motion forward and back. Of these
only version 1 (CNC7 v6.00) is known to the letter: a header of two numbers, `24 -1448819`, and 24
corrections in encoder counts. With 40,000 counts per inch that travel is 920.00 mm,
23 intervals of 40 mm: so the header is taken as the number of points and the place of the last one,
counted from home.
Source: CNC Services Northwest, "Laser Compensation on Centroid Controls". What newer controls keep
is not known: for them a sheet is written, in gcomp's own layout, never a .tab file.

Sign: "the amount of correction to apply": -deviation. Unverified; --set sign=+ turns it.
"""

from __future__ import annotations

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError, _sheet
from postproc.control_tables import _common as common
from postproc.errors import UsageError
from postproc.recordings import Source

TITLE = "Centroid ballscrew compensation (a sheet to type in; version=1: CNC7 v6 table)"
VERIFIED = False
UNVERIFIED = "the sign, and the layout but version 1"
SIGN = "-deviation, unverified; --set sign=+ turns it"
EXTRA = {
    "version": "sheet, or 1 for the table of CNC7 v6.00 to v7.17",
    "sign": "- or +, -",
    "points": "how many points, 1000",
    "counts_per_mm": "of version 1: encoder counts per mm; needed",
    "axis": "of version 1, when reading: X, Y or Z",
}
# version 1:
#     24 -1448819        points, and the last one's place in counts from home
#     0                  correction at home, counts
#     -3                 at the next point, and so on
COLUMNS = ("correction_forward", "correction_reverse")
NOTICE = (
    "unverified: the sign, and all of the layout but version 1. Enter one axis, move to a place"
    " with a large error and measure: where it has doubled, write again with --set sign=+"
)


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One sheet, or one table of version 1, per axis. Raises TableError or UsageError."""
    version = common.setting(options, "version", "sheet", ("sheet", "1"))
    sign = _sign(options)
    most = common.whole(options, "points", 1000, 2, 100_000)
    kept, notices = common.own_axis(tables, "Centroid's table")
    files: dict[str, bytes] = {}
    left: dict[str, float] = {}
    for table in kept:
        single = version == "1" or not options.two_way
        chosen = common.mean(table) if single and table.two_way else table
        home = (
            common.reference(table, options, notices) if version == "1" else float(chosen.nodes[0])
        )
        even = common.even(chosen, options, home, most)
        if version == "1":
            even, _ = common.zeroed(even, home, 0.0, notices)
            name = f"cnc7{table.moving.lower()}.tab"
            files[name] = _counts(even, home, sign, options)
            back = _parsed_counts(Source(name, files[name]), table.moving, home, sign, options)
        else:
            name = f"centroid-{table.moving}.txt"
            files[name] = _sheet.text(
                even,
                options,
                sign,
                COLUMNS,
                [f"{options.program}: correction of {table.moving}", NOTICE],
            )
            back = _sheet.parsed(Source(name, files[name]), sign, COLUMNS)
        left[table.name] = common.left(table, back)
        if single and table.two_way:
            notices.append(
                f"{table.name}: the mean of both directions is written; backlash stays a setting of"
                " the control"
            )
    notices.append(
        "what the control does beyond the ends of a table is not documented: it must be as long as"
        " the travel"
    )
    return Export(files, (NOTICE, *notices), left)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """The file's one table. Raises TableError with file and line, UsageError where counts or axis
    are not told."""
    if common.setting(options, "version", "sheet", ("sheet", "1")) == "sheet":
        return [_sheet.parsed(source, _sign(options), COLUMNS)]
    axis = options.extra.get("axis", "").upper()
    if axis not in ("X", "Y", "Z"):
        raise UsageError(
            f"which axis is {source.name}? A table of version 1 does not say", "--set axis=X"
        )
    return [_parsed_counts(source, axis, options.reference.get(axis, 0.0), _sign(options), options)]


def _sign(options: ExportOptions) -> float:
    return common.sign(options, "sign", "-")


def _per_mm(options: ExportOptions) -> float:
    value = common.number(options, "counts_per_mm", 0.0, 0.0, 1e7)
    if not value:
        raise UsageError(
            "a table of version 1 is in encoder counts",
            "--set counts_per_mm=1574.803, as the axis has them",
        )
    return value


def _counts(table: ErrorTable, home: float, sign: float, options: ExportOptions) -> bytes:
    """Points from home to the far end of the travel, in counts."""
    per_mm, places = _per_mm(options), table.nodes - home
    # the point next to home first: travels below home are listed from their upper end on
    if abs(places[0]) > abs(places[-1]):
        places, values = places[::-1], table.forward[::-1]
    else:
        values = table.forward
    if abs(places[0]) > 1e-6 or len(places) < 2:
        raise TableError(
            f"{table.name} reaches to both sides of home at {home:g} mm",
            "a table of version 1 begins at home: --reference",
        )
    rows = [
        f"{len(places)} {round(float(places[-1]) * per_mm)}",
        *(str(round(sign * float(v) * per_mm)) for v in values),
    ]
    return common.text_of(rows, "\r\n")


def _header(at: common.Line) -> tuple[int, float]:
    """How many points, and the place of the last in counts. Raises TableError."""
    words = at.text.split()
    if len(words) != 2 or not words[0].isdecimal() or int(words[0]) < 2:
        advice = "number of points and place of the last, like 24 -1448819"
        raise at.fault("not a header of version 1", advice)
    last = at.finite(words[1], "the place of the last point")
    if not last:
        raise at.fault("the last point stands at home")
    return int(words[0]), last


def _parsed_counts(
    source: Source, axis: str, home: float, sign: float, options: ExportOptions
) -> ErrorTable:
    per_mm = _per_mm(options)
    head, *lines = (at for at in common.numbered(source) if at.text.strip())
    count, last = _header(head)
    values = [at.finite(at.text, "the correction") for at in lines]
    if len(values) != count:
        end = (lines or [head])[-1].number
        raise common.fault(source, end, f"{len(values)} corrections, and the header tells {count}")
    nodes = home + np.round(np.linspace(0.0, last / per_mm, count), 3)  # a count is about that
    off = sign * np.array(values) / per_mm
    if last < 0:
        nodes, off = nodes[::-1], off[::-1]
    return ErrorTable(axis, axis, nodes, off, off)
