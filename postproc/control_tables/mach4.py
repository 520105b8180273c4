"""Mach4's screw mapping: the values to type into the Machine Calibration plugin, a sheet per axis.

Start point, length, number of evenly spaced points, both ends counted; then the error at every
point, "the difference between the expected position and the actual position". Since build 4780
there is a map for each direction, before one for both. Source: MachMotion support, "Mach 4 Screw
Mapping". How Mach4 keeps the values in a file is not known: the sheet is gcomp's own.

Sign: unverified, for that sentence can be read both ways. +deviation (actual - expected) is
written; --set sign=- turns it.
"""

from __future__ import annotations

from postproc.control_tables import ErrorTable, Export, ExportOptions, _sheet
from postproc.control_tables import _common as common
from postproc.recordings import Source

TITLE = "Mach4 screw mapping (a sheet to type in)"
VERIFIED = False
UNVERIFIED = "the sign"
SIGN = "+deviation, unverified; --set sign=- turns it"
EXTRA = {"sign": "+ or -, +", "points": "how many points the plugin takes, 1000"}
COLUMNS = ("error_positive", "error_negative")
NOTICE = (
    "unverified: which sign Mach4 expects. Enter one axis, move to a place with a large error and"
    " measure: where it has doubled, write again with --set sign=-"
)


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One sheet per axis. Raises TableError where the points do not suffice."""
    sign = common.sign(options, "sign", "+")
    most = common.whole(options, "points", 1000, 2, 100_000)
    kept, notices = common.own_axis(tables, "Mach4")
    files: dict[str, bytes] = {}
    left: dict[str, float] = {}
    for table in kept:
        # start, length and number of points are all that the plugin asks for: even steps, always
        even = common.chosen(table, options, most, always=True)
        name = f"mach4-{table.moving}.txt"
        files[name] = _sheet.text(
            even,
            options,
            sign,
            COLUMNS,
            [f"{options.program}: Mach4 screw map of {table.moving}", NOTICE],
        )
        left[table.name] = common.left(
            table, _sheet.parsed(Source(name, files[name]), sign, COLUMNS)
        )
    if any(t.two_way for t in kept):
        both = (
            "maps for both directions need build 4780 or later; with them the backlash of the axis"
            " must be 0"
        )
        notices.append(
            both
            if options.two_way
            else "one map for both directions: backlash stays a setting of its own"
        )
    notices.append(
        "positions are the motor's, as Capture Start shows them; what Mach4 does beyond the ends is"
        " not documented"
    )
    return Export(files, (NOTICE, *notices), left)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """The sheet's one table. Raises TableError with file and line."""
    sign = common.sign(options, "sign", "+")
    return [_sheet.parsed(source, sign, COLUMNS)]
