"""Fagor 8055 leadscrew error compensation, as a list to key in.

Each point: position referred to machine zero, error in the positive direction, error in the
negative direction; up to 1000 points an axis (NPOINTS, P16), active with LSCRWCOM (P15). Where the
error in the negative direction is zero at all points, the control takes that of the positive
direction for both. Source: CNC 8055 installation manual, page 328. The amount of error is entered,
so +deviation; that sign, and the file, are unverified (`fagor_sign=-` flips it).
"""

from __future__ import annotations

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables import _lists as lists
from postproc.control_tables._thinning import thinned
from postproc.recordings import Source
from postproc.units import UM

TITLE = "Fagor 8055 leadscrew error compensation, a list to key in"
VERIFIED = False
UNVERIFIED = "the sign, and how the list is entered"
SIGN = "+deviation by default (unverified; --set fagor_sign=- flips it)"
EXTRA = {"fagor_sign": "+ or -, +", "points": "NPOINTS, 1000"}
DECIMALS = {"mm": 4, "inch": 5}
NAMES = {"mm": "mm", "inch": "in"}


def columns(options: ExportOptions) -> tuple[str, ...]:
    """The list's header."""
    unit = NAMES[options.unit]
    return ("axis", f"position_{unit}", f"error_plus_{unit}", f"error_minus_{unit}")


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One list for all axes. Raises TableError beyond NPOINTS."""
    unit, decimals = common.mm_per_unit(options), DECIMALS[options.unit]
    sign = common.sign(options, "fagor_sign", "+")
    most = common.whole(options, "points", 1000, 2, 1000)
    kept, notices = common.own_axis(tables, "the Fagor leadscrew table")
    remark = (
        "unverified: the sign, and how the list is entered; set LSCRWCOM (P15) = ON and NPOINTS"
        " (P16)"
    )
    notices.insert(0, remark)
    rows: list[list[str]] = []
    for table in kept:
        chosen = common.chosen(table, options, most)
        chosen, lost = thinned(chosen, most)
        if lost:
            notices.append(
                f"{table.name}: thinned out to {len(chosen.nodes)} points, which loses"
                f" {lost / UM:.3f} um"
            )
        up, down = (np.round(sign * v / unit, decimals) for v in (chosen.forward, chosen.reverse))
        if not np.any(down) and np.any(up):
            # One least digit, for all zeros would mean "as in +" to the control, and put in what
            # was measured only one way.
            down[-1] = 10.0**-decimals
            notices.append(
                f"{table.name}: the errors for travel in - are all zero, which the control reads as"
                f" 'like in +': the last is {down[-1]:g} {options.unit}"
            )
        rows += [
            [table.moving, *(common.fixed(float(v), decimals) for v in row)]
            for row in zip(chosen.nodes / unit, up, down, strict=True)
        ]
    name = f"{options.program}_fagor.csv"
    data = lists.written([remark], columns(options), rows)
    left = common.remainder(kept, read(Source(name, data), options))
    return Export({name: data}, tuple(notices), left)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """The list's tables. Raises TableError with file and line."""
    unit = common.mm_per_unit(options)
    sign = common.sign(options, "fagor_sign", "+")
    tables = []
    for axis, rows in lists.by_axis(source, columns(options)).items():
        if len(rows) > 1000:
            raise TableError(f"{source.name}: {axis} has {len(rows)} points, and there are 1000")
        nodes, up, down = np.array(rows).T * unit
        tables.append(
            ErrorTable(axis, axis, nodes, sign * up, sign * (down if np.any(down) else up))
        )
    return tables
