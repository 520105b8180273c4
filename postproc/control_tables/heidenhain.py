"""Heidenhain nonlinear axis error compensation: .COM value tables and the .CMA table that assigns
them.

A .COM file belongs to the axis that moves: AXISPOS (referred to the machine datum), a column for
each axis that is corrected, and BACKLASH, the moving axis' own values for travel in -. A .CMA row
names, in the column of the moving axis, its .COM: "[axis in column from .com] = F(axis in column
from .cma, in which .com is entered)" (MANUALplus 620 technical manual, pages 716 to 718). A value
is positive where the axis travels too far (TNC 407 technical manual, page 151, of MP720), so
+deviation. At most 256 entries. form=legacy: evenly spaced by a power of two x 0.1 um, neighbours
at most spacing / 64 apart (TNC 407, pages 153 to 156).

The lines that frame such a file were not found. With the control's own exported empty table as
template its frame and column widths are kept and filled; without, a frame from general knowledge is
written and called unverified.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from postproc import intake
from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables._heidenhain_reading import ENTRIES, UNIT, end_of, layout, read
from postproc.errors import UsageError
from postproc.recordings import Source
from postproc.units import UM

TITLE = "Heidenhain axis error compensation (.COM and .CMA), into your exported empty table"
VERIFIED = False
UNVERIFIED = "the sign, and the lines that frame the file without --template"
SIGN = "+deviation: positive where the axis travels too far (unverified: from MP720)"
EXTRA = {
    "template": "text of an exported empty .COM table (--template FILE)",
    "form": "free or legacy (spacing a power of two x 0.1 um), free",
    "points": "entries of one table, 256 (64 in the oldest controls)",
}
# AXIS_Z.COM, of the axis that moves: a column to each axis that it moves off, and its own reverse.
#
#     BEGIN AXIS_Z.COM MM
#     NR      AXISPOS         X               Z               BACKLASH
#     0       0.00000         0.00012         0.00000         0.00210
#     [END]
TICK = 0.0001  # mm
DECIMALS = {"mm": 5, "inch": 6}
FRAME = "BEGIN AXIS.COM {unit}\nNR      AXISPOS         {columns}\n[END]\n"
WIDTH = 16
NAMES = {"mm": "MM", "inch": "INCH"}


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """AXIS_Z.COM for each moving axis, and config.CMA without a template. Raises TableError where a
    template has no column for a value, or is too narrow, and where the legacy limits are broken."""
    tables = common.checked(tables)
    form = common.setting(options, "form", "free", ("free", "legacy"))
    template = options.extra.get("template", "")
    notices: list[str] = [
        "unverified: the sign of .COM values follows MP720; look with a gauge before cutting"
    ]
    if template:
        notices.append("the frame and the columns are those of your template")
    else:
        notices.append(
            "unverified: the lines that frame the file; export an empty table from the control and"
            " give it with --template FILE"
        )
    files: dict[str, bytes] = {}
    remainder: dict[str, float] = {}
    moving = sorted({t.moving for t in tables})
    for letter in moving:
        group = [t for t in tables if t.moving == letter]
        written = _sampled(group, options, form, notices)
        nodes = written[0].nodes
        name = f"AXIS_{letter}.COM"
        files[name] = _filled(template, name, letter, written, options)
        remainder |= common.remainder(group, read(Source(name, files[name]), options))
        if form == "legacy":
            notices.append(
                f"{name}: datum {nodes[0]:g} mm, spacing"
                f" 2^{round(math.log2((nodes[1] - nodes[0]) / TICK))} x 0.1 um"
            )
    if not template:
        files["config.CMA"] = _config(moving)
    notices.append(
        "assign in the .CMA table: "
        + ", ".join(f"column {x}: AXIS_{x}.COM" for x in moving)
        + "; * in ACTIVE"
    )
    notices.append("AXISPOS counts from the machine datum (MP_refPosition)")
    return Export(files, tuple(notices), remainder)


def _ways(table: ErrorTable, options: ExportOptions, notices: list[str]) -> ErrorTable:
    if not table.two_way or (options.two_way and table.moving == table.along):
        return table
    why = "one-way was asked for" if not options.two_way else "BACKLASH is of the moving axis alone"
    notices.append(f"{table.name}: the mean of both directions is written ({why})")
    return common.mean(table)


def _nodes(
    group: list[ErrorTable], options: ExportOptions, form: str, notices: list[str]
) -> np.ndarray:
    """Positions for all columns of one file: common nodes, thinned out, or even ones."""
    most = common.whole(options, "points", ENTRIES, 2, ENTRIES)
    span = group[0]
    nodes = span.nodes
    for table in group[1:]:
        nodes = np.union1d(nodes, table.nodes)
    span = replace(span, nodes=nodes, forward=np.zeros_like(nodes), reverse=np.zeros_like(nodes))
    if form == "legacy":
        if options.unit != "mm":
            raise UsageError("the legacy form is in mm", "--unit mm")
        # the least power of two x 0.1 um with which `most` entries reach over the travel
        power = max(
            0, math.ceil(math.log2(max(float(np.ptp(nodes)), TICK) / (most - 1) / TICK) - 1e-9)
        )
        if options.spacing:
            power = round(math.log2(options.spacing / TICK))
            if abs(TICK * 2**power - options.spacing) > 1e-9:
                near = sorted(
                    {
                        TICK * 2 ** math.floor(math.log2(options.spacing / TICK)),
                        TICK * 2 ** math.ceil(math.log2(options.spacing / TICK)),
                    }
                )
                raise UsageError(
                    f"a spacing of {options.spacing:g} mm is not a power of two x 0.1 um",
                    f"--spacing {' or '.join(f'{n:.10g}' for n in near)}",
                )
        step = TICK * 2**power
        count = math.ceil(float(np.ptp(nodes)) / step - 1e-9) + 1
        if count > most:
            raise TableError(
                f"{span.moving}: {count} entries of {step:g} mm, and the control has {most}",
                f"--spacing {2 * step:.10g}",
            )
        return np.asarray(np.round(nodes[0] + step * np.arange(max(2, count)), 9))
    if options.spacing:
        return common.even_nodes(span, options, float(nodes[0]), most)
    if len(nodes) > most:
        even = common.even_nodes(span, options, float(nodes[0]), most)
        notices.append(
            f"{span.moving}: {len(nodes)} nodes are more than {most} entries: every"
            f" {even[1] - even[0]:g} mm instead"
        )
        return even
    return nodes


def _gentle(table: ErrorTable) -> None:
    step = float(table.nodes[1] - table.nodes[0])
    for values in (table.forward, table.reverse):
        rise = np.abs(np.diff(values))
        worst = int(np.argmax(rise))
        if rise[worst] > step / 64:
            raise TableError(
                f"{table.name} changes by {rise[worst] / UM:.1f} um between {table.nodes[worst]:g}"
                f" and {table.nodes[worst + 1]:g} mm; spacing / 64 = {step / 64 / UM:.1f} um is the"
                " limit",
                "a larger --spacing, or form=free",
            )


def _sampled(
    group: list[ErrorTable], options: ExportOptions, form: str, notices: list[str]
) -> list[ErrorTable]:
    """The tables of one axis at the same nodes. Raises TableError beyond the legacy limits."""
    chosen = [_ways(t, options, notices) for t in group]
    nodes = _nodes(chosen, options, form, notices)
    written = [common.sampled(t, nodes) for t in chosen]
    if form == "legacy":
        for t in written:
            _gentle(t)
    return written


def _frame(name: str, heads: list[str], options: ExportOptions) -> str:
    """The lines around the rows of a table, where there is no template."""
    columns = "".join(h.ljust(WIDTH) for h in heads).rstrip()
    return FRAME.format(unit=NAMES[options.unit], columns=columns).replace("AXIS.COM", name)


def _config(moving: list[str]) -> bytes:
    """The .CMA table that assigns a .COM file to each axis."""
    width = max(len(f"AXIS_{letter}.COM") for letter in moving) + 2
    head = "NR  " + "".join(letter.ljust(width) for letter in moving) + "ACTIVE"
    row = "0   " + "".join(f"AXIS_{letter}.COM".ljust(width) for letter in moving) + "*"
    return f"BEGIN CONFIG.CMA\n{head}\n{row}\n[END]\n".encode()


def _filled(
    template: str, name: str, letter: str, tables: list[ErrorTable], options: ExportOptions
) -> bytes:
    """The template with the rows of `tables` in its columns."""
    heads = [t.along for t in tables] + ["BACKLASH"] * any(t.two_way for t in tables)
    template = template or _frame(name, heads, options)
    at, columns = layout(template, "the template")
    lines = intake.lines_of(template)
    _check_template(lines[0], dict(columns), heads, options)
    rows = _rows(columns, _entries(letter, tables, options))
    end = end_of(template, at)
    if end is None:
        raise TableError(
            "the template has no line [END]", "export the whole table from the control"
        )
    newline = "\r\n" if "\r\n" in template else "\n"
    return (newline.join([*lines[: at + 1], *rows, *lines[end:]]) + newline).encode()


def _check_template(
    head: str, columns: dict[str, int], wanted: list[str], options: ExportOptions
) -> None:
    """Raises UsageError for a template of another unit, TableError for one that lacks a column."""
    said = UNIT.search(head.upper())
    if said and said[1] != NAMES[options.unit]:
        raise UsageError(
            f"the template is in {said[1]}, and the unit is {options.unit}",
            f"--unit {'mm' if said[1] == 'MM' else 'inch'}",
        )
    for name in wanted:
        if name not in columns:
            raise TableError(
                f"the template has no column {name}: its columns are {', '.join(columns)}",
                "add the column at the control, and export again",
            )


def _entries(letter: str, tables: list[ErrorTable], options: ExportOptions) -> list[dict[str, str]]:
    """The cells of each row by their column."""
    unit, decimals = common.mm_per_unit(options), DECIMALS[options.unit]
    values = {"AXISPOS": tables[0].nodes} | {t.along: t.forward for t in tables}
    for own in (t for t in tables if t.along == letter):
        values["BACKLASH"] = own.reverse
    return [
        {"NR": str(i)} | {c: common.fixed(float(v[i]) / unit, decimals) for c, v in values.items()}
        for i in range(len(tables[0].nodes))
    ]


def _rows(columns: list[tuple[str, int]], entries: list[dict[str, str]]) -> list[str]:
    """Lines of a table; columns: name and first character. Raises TableError for a cell that is
    wider than its column."""
    edges = [start for _, start in columns[1:]] + [math.inf]
    rows = []
    for entry in entries:
        row = ""
        for (column, start), edge in zip(columns, edges, strict=True):
            cell = entry.get(column, "")
            if len(cell) >= edge - start:
                raise TableError(
                    f"{cell} does not fit the column {column} of the template, {edge - start} wide"
                )
            row = row.ljust(start) + cell
        rows.append(row.rstrip())
    return rows
