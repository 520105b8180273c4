"""Haas lead screw compensation, as a list to key in.

Values every 0.5 inch of machine coordinates, the first at machine zero, the next ones towards
minus; in inches, resolution 0.0001 inch; the control interpolates them into 256 entries and limits
them to 127 encoder steps. The same for both directions. Source: VF series manual 96-8000, page 305,
which also says that a user should never need to change them.
Unverified: the sign. -deviation is written (a value is added to the command), `haas_sign=+` flips
it.
"""

from __future__ import annotations

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables import _lists as lists
from postproc.recordings import Source
from postproc.units import MM_PER_INCH, UM

TITLE = "Haas lead screw compensation, a list to key in"
VERIFIED = False
UNVERIFIED = "the sign, and how the values are entered"
SIGN = "-deviation by default (unverified; --set haas_sign=+ flips it)"
EXTRA = {
    "haas_sign": "- or +, -",
    "encoder_step_mm": "mm of an encoder step, for the limit of 127 steps",
}
SPACING = 0.5 * MM_PER_INCH
POINTS, STEPS, DECIMALS = 256, 127, 4
COLUMNS = ("axis", "point", "position_in", "value_in")


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One list, positions in inches of machine coordinates. Raises TableError beyond 256 points or
    127 encoder steps."""
    sign = common.sign(options, "haas_sign", "-")
    encoder = common.number(options, "encoder_step_mm", 0.0, 0.0, 1.0)
    kept, notices = common.own_axis(tables, "the Haas lead screw compensation")
    remark = (
        "unverified: the sign, and how the values are entered; Haas' manual says a user should not"
        " need to change them"
    )
    notices.insert(0, remark)
    rows: list[list[str]] = []
    for table in kept:
        home = common.reference(table, options, notices)
        if table.nodes[0] > home - 1e-9:
            raise TableError(
                f"{table.name} begins at {table.nodes[0]:g} mm, and machine zero is {table.moving}"
                f" = {home:g}: entries only go down from there",
                f"--reference {table.moving}={table.nodes[-1]:g} if machine zero is at the"
                " upper end",
            )
        count = max(2, int(np.ceil((home - table.nodes[0]) / SPACING - 1e-9)) + 1)
        if count > POINTS:
            raise TableError(
                f"{table.name} reaches {count} points of 0.5 inch below machine zero, and there are"
                f" {POINTS}"
            )
        if table.nodes[-1] > home + 1e-9:
            notices.append(
                f"{table.name}: nothing stands above machine zero {table.moving} = {home:g}: the"
                f" value there is held up to {table.nodes[-1]:g}"
            )
        #     point      0        1        2
        #     inch       0.0     -0.5     -1.0      from machine zero down
        values = common.mean(table).at(home - SPACING * np.arange(count)) * sign / MM_PER_INCH
        if encoder and np.abs(values).max() * MM_PER_INCH > STEPS * encoder:
            raise TableError(
                f"{table.name}: {np.abs(values).max() * MM_PER_INCH / UM:.1f} um are more than"
                f" {STEPS} encoder steps of {encoder / UM:g} um"
            )
        rows += [
            [table.moving, str(i), common.fixed(-0.5 * i, 1), common.fixed(float(v), DECIMALS)]
            for i, v in enumerate(values)
        ]
        notices += common.lost_motion(table)
    if not encoder:
        notices.append(
            f"values are limited to {STEPS} encoder steps: not checked (--set"
            " encoder_step_mm=0.001)"
        )
    name = f"{options.program}_haas.csv"
    data = lists.written([remark], COLUMNS, rows)
    left = common.remainder(kept, read(Source(name, data), options))
    return Export({name: data}, tuple(notices), left)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """The list's tables. Machine zero stands at options.reference. Raises TableError with file and
    line."""
    sign = common.sign(options, "haas_sign", "-")
    tables = []
    for axis, rows in lists.by_axis(source, COLUMNS, whole=(0,)).items():
        point, position, value = np.array(rows).T
        if not np.allclose(position, -0.5 * point) or point[0] != 0:
            raise TableError(
                f"{source.name}: positions of {axis} are not 0, -0.5, -1.0 ... inch from machine"
                " zero"
            )
        # turned round: our nodes ascend
        nodes = (options.reference.get(axis, 0.0) + position * MM_PER_INCH)[::-1]
        column = (sign * value * MM_PER_INCH)[::-1]
        tables.append(ErrorTable(axis, axis, np.round(nodes, 9), column, column))
    return tables
