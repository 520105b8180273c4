"""NcStudio (Weihong): axeserr.dat, screw error and backlash of all axes.

`unit = mm`, then for each axis `[X]` and rows `nominal, forward error, backward error`, ascending,
machine coordinates from the reference point by the nominal pitch; `;` begins a comment line. A
control applies it by its parameter "Screw error compensation" = 2 (both directions). Source:
Weihong NK200 manual, "Screw Error Compensation File", tables 3-1 and 3-2; EasyRoute manufacturer's
manual, page 68.

Sign: unverified. The manuals only say "error"; their example of an axis with nothing but 0.03 mm of
backlash has forward 0 and backward +0.030, and a tool that stays behind in - stands at actual -
commanded = +0.030: so +deviation is written.
"""

from __future__ import annotations

import re

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions
from postproc.control_tables import _common as common
from postproc.errors import UsageError
from postproc.recordings import Source

TITLE = "NcStudio (Weihong) screw error file axeserr.dat"
VERIFIED = False
UNVERIFIED = "the sign"
SIGN = "+deviation, unverified: by the manual's example of backlash"
NAME = "axeserr.dat"
DECIMALS = 4
#     unit = mm
#     [X]
#     0.0000, 0.0000, 0.0300          nominal, forward error, backward error
#     50.0000, 0.0021, 0.0318
UNIT = re.compile(r";?\s*unit\s*=\s*(\S+)", re.IGNORECASE)  # the manual's example has the ;
NOTICE = (
    "unverified: the sign, which follows from the manual's example of backlash only. Load one axis,"
    " move to a place with a large error and measure: it must be gone, not doubled"
)


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """The file of all axes. Raises TableError, UsageError for inches."""
    if options.unit != "mm":
        raise UsageError("NcStudio's file is in mm", "--unit mm")
    kept, notices = common.own_axis(tables, "NcStudio")
    lines = [f"; {options.program}", f"; {NOTICE}", "unit = mm"]
    places: dict[str, float] = {}
    for table in sorted(kept, key=lambda t: t.moving):
        chosen = common.chosen(table, options, 10_000)
        home = places[table.moving] = common.reference(table, options, notices)
        lines.append(f"[{table.moving}]")
        rows = zip(chosen.nodes - home, chosen.forward, chosen.reverse, strict=True)
        lines += [", ".join(common.fixed(float(v), DECIMALS) for v in row) for row in rows]
        if table.two_way:
            notices.append(
                f"{table.moving}: "
                + (
                    "its own backlash must be off, it is in both columns"
                    if options.two_way
                    else "backlash stays a setting"
                )
            )
    data = common.text_of(lines, "\r\n")
    left = common.remainder(kept, read(Source(NAME, data), ExportOptions(reference=places)))
    notices.append(
        "a nominal coordinate outside of the stroke makes the compensation invalid, says the manual"
    )
    return Export({NAME: data}, (NOTICE, *notices), left)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """A table per axis of the file. Raises TableError with file and line."""
    rows: dict[str, list[list[float]]] = {}
    axis, unit, last = "", "", 1
    for at in common.numbered(source):
        text = at.text.strip()
        if stated := UNIT.fullmatch(text):
            unit = _unit(at, stated[1])
        elif re.fullmatch("|;.*", text):
            continue
        elif section := re.fullmatch(r"\[\s*([XYZ])\s*\]", text, re.IGNORECASE):
            axis = section[1].upper()
            if not unit or axis in rows:
                early = f"[{axis}] stands before the unit, or twice"
                raise at.fault(early, "unit = mm comes first")
            rows[axis] = []
        elif not axis:
            raise at.fault("a row outside of an axis", "like [X]")
        else:
            rows[axis].append(_row(at, text, rows[axis]))
        last = at.number
    if min(map(len, rows.values()), default=0) < 2:
        raise common.fault(source, last, "an axis needs two rows at least")
    return [_parsed(x, values, options) for x, values in rows.items()]


def _parsed(axis: str, rows: list[list[float]], options: ExportOptions) -> ErrorTable:
    nominal, forward, reverse = np.array(rows).T
    home = options.reference.get(axis, 0.0)
    return ErrorTable(axis, axis, nominal + home, forward, reverse)


def _unit(at: common.Line, word: str) -> str:
    if word.lower() != "mm":
        raise at.fault(f"unit {word}: only mm is supported")
    return "mm"


def _row(at: common.Line, text: str, above: list[list[float]]) -> list[float]:
    """Nominal, forward and backward of a row."""
    cells = [cell for cell in (c.strip() for c in text.split(",")) if cell]
    if len(cells) != 3:
        raise at.fault(f"{len(cells)} numbers, where nominal, forward, backward must stand")
    row = [at.finite(cell, "the entry") for cell in cells]
    if above and row[0] <= above[-1][0]:
        raise at.fault(f"{row[0]:g} does not ascend after {above[-1][0]:g}")
    return row
