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
import re
from dataclasses import replace

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.errors import UsageError
from postproc.recordings import Source
from postproc.units import MM_PER_INCH, UM

TITLE = "Heidenhain axis error compensation (.COM and .CMA), into your exported empty table"
VERIFIED = False
UNVERIFIED = "the sign, and the lines that frame the file without --template"
SIGN = "+deviation: positive where the axis travels too far (unverified: from MP720)"
EXTRA = {
    "template": "text of an exported empty .COM table (--template FILE)",
    "form": "free or legacy (spacing a power of two x 0.1 um), free",
    "points": "entries of one table, 256 (64 in the oldest controls)",
}
ENTRIES = 256
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
        chosen = [_ways(t, options, notices) for t in group]
        nodes = _nodes(chosen, options, form, notices)
        written = [common.sampled(t, nodes) for t in chosen]
        if form == "legacy":
            for t in written:
                _gentle(t)
        name = f"AXIS_{letter}.COM"
        files[name] = _filled(template, name, letter, written, options)
        back = {t.name: t for t in read(Source(name, files[name]), options)}
        remainder |= {t.name: common.left(t, back[t.name]) for t in group}
        if form == "legacy":
            notices.append(
                f"{name}: datum {nodes[0]:g} mm, spacing"
                f" 2^{round(math.log2((nodes[1] - nodes[0]) / TICK))} x 0.1 um"
            )
    if not template:
        width = max(len(f"AXIS_{letter}.COM") for letter in moving) + 2
        head = "NR  " + "".join(letter.ljust(width) for letter in moving) + "ACTIVE"
        row = "0   " + "".join(f"AXIS_{letter}.COM".ljust(width) for letter in moving) + "*"
        files["config.CMA"] = f"BEGIN CONFIG.CMA\n{head}\n{row}\n[END]\n".encode()
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
                    f"--spacing {' or '.join(f'{n:g}' for n in near)}",
                )
        step = TICK * 2**power
        count = math.ceil(float(np.ptp(nodes)) / step - 1e-9) + 1
        if count > most:
            raise TableError(
                f"{span.moving}: {count} entries of {step:g} mm, and the control has {most}",
                f"--spacing {2 * step:g}",
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


def _layout(text: str, name: str) -> tuple[int, list[tuple[str, int]]]:
    """Index of the line with the columns, and each column's name and first character."""
    for i, line in enumerate(text.splitlines()):
        found = [(m[0].upper(), m.start()) for m in re.finditer(r"\S+", line)]
        if found and found[0][0] == "NR" and ("AXISPOS", dict(found).get("AXISPOS")) in found:
            return i, found
    raise TableError(
        f"{name} has no line of columns that begins with NR and holds AXISPOS",
        "export an empty .COM table from the control",
    )


def _filled(
    template: str, name: str, letter: str, tables: list[ErrorTable], options: ExportOptions
) -> bytes:
    """The template with the rows of `tables` in its columns."""
    unit, decimals = common.mm_per_unit(options), DECIMALS[options.unit]
    back = next((t for t in tables if t.two_way), None)
    if not template:
        heads = [t.along for t in tables] + (["BACKLASH"] if back else [])
        template = FRAME.format(
            unit=NAMES[options.unit], columns="".join(h.ljust(WIDTH) for h in heads).rstrip()
        ).replace("AXIS.COM", name)
    at, columns = _layout(template, "the template")
    lines = template.splitlines()
    said = re.search(r"\b(MM|INCH)\b", lines[0].upper())
    if said and said[1] != NAMES[options.unit]:
        raise UsageError(
            f"the template is in {said[1]}, and the unit is {options.unit}",
            f"--unit {'mm' if said[1] == 'MM' else 'inch'}",
        )
    values = {t.along: t.forward for t in tables}
    own = next((t for t in tables if t.along == letter), None)
    if own is not None:
        values["BACKLASH"] = own.reverse
    known = [c for c, _ in columns]
    for wanted in [t.along for t in tables] + (["BACKLASH"] if back else []):
        if wanted not in known:
            raise TableError(
                f"the template has no column {wanted}: its columns are {', '.join(known)}",
                "add the column at the control, and export again",
            )
    rows = []
    for i, position in enumerate(tables[0].nodes):
        row = ""
        for k, (column, start) in enumerate(columns):
            cell = str(i) if column == "NR" else ""
            if column == "AXISPOS":
                cell = common.fixed(position / unit, decimals)
            elif column in values:
                cell = common.fixed(float(values[column][i]) / unit, decimals)
            if k + 1 < len(columns) and len(cell) >= columns[k + 1][1] - start:
                raise TableError(
                    f"{cell} does not fit the column {column} of the template,"
                    f" {columns[k + 1][1] - start} wide"
                )
            row = row.ljust(start) + cell
        rows.append(row.rstrip())
    ends = [
        i
        for i, line in enumerate(lines)
        if i > at and line.strip().upper().startswith(("[END]", "END"))
    ]
    if not ends:
        raise TableError(
            "the template has no line [END]", "export the whole table from the control"
        )
    newline = "\r\n" if "\r\n" in template else "\n"
    return (newline.join([*lines[: at + 1], *rows, *lines[ends[0] :]]) + newline).encode()


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """A .COM file's tables. The moving axis: options.extra["axis"], or a name like AXIS_Z.COM.
    Raises TableError with file and line."""
    letter = options.extra.get("axis", "").upper()
    if not letter:
        named = re.search(r"(?:^|[/\\]|AXIS[-_]?)([XYZUVW])\.COM$", source.name, re.IGNORECASE)
        if named is None:
            raise UsageError(
                f"of which moving axis is {source.name}? A .COM table does not say", "--axis X"
            )
        letter = named[1].upper()
    lines = common.numbered(source)
    at, columns = _layout(source.text, source.name)
    said = re.search(r"\b(MM|INCH)\b", lines[0][1].upper()) if at else None
    unit = (
        common.mm_per_unit(options) if said is None else (1.0 if said[1] == "MM" else MM_PER_INCH)
    )
    heads = [c for c, _ in columns]
    edges = [s for _, s in columns] + [1 << 20]
    rows: list[dict[str, float]] = []
    ended = False
    for line, text in lines[at + 1 :]:
        if text.strip().upper().startswith(("[END]", "END")):
            ended = True
            break
        cells = {h: text[edges[i] : edges[i + 1]].strip() for i, h in enumerate(heads)}
        row = {h: common.finite(source, line, c, h, text) for h, c in cells.items() if c}
        if row.get("NR") != len(rows):
            raise common.fault(
                source, line, f"row {cells['NR']!r} where NR {len(rows)} is due", "", text
            )
        if "AXISPOS" not in row:
            raise common.fault(source, line, "AXISPOS is empty", "", text)
        if rows and row["AXISPOS"] <= rows[-1]["AXISPOS"]:
            raise common.fault(
                source,
                line,
                f"AXISPOS {row['AXISPOS']:g} does not ascend after {rows[-1]['AXISPOS']:g}",
                "",
                text,
            )
        if rows and set(row) != set(rows[0]):
            raise common.fault(
                source, line, "a value is missing that the first row has, or one too many", "", text
            )
        rows.append(row)
    if not ended:
        raise common.fault(source, lines[-1][0], "[END] is missing: the file is not whole")
    if not rows or len(rows) > ENTRIES:
        raise common.fault(source, at + 1, f"{len(rows)} entries: a table has 1 to {ENTRIES}")
    column = {h: np.array([row[h] for row in rows]) * unit for h in rows[0]}
    tables = []
    for head in (h for h in column if h in ("X", "Y", "Z", "U", "V", "W")):
        reverse = column.get("BACKLASH", column[head]) if head == letter else column[head]
        tables.append(ErrorTable(letter, head, column["AXISPOS"], column[head], reverse))
    if not tables:
        raise common.fault(source, at + 1, f"no column of an axis: {', '.join(heads)}")
    return tables
