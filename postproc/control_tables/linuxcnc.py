"""LinuxCNC's screw compensation: [JOINT_n] COMP_FILE and COMP_FILE_TYPE.

Three numbers a line: nominal, forward, reverse, in joint coordinates and machine units. Type 0:
forward and reverse are the actual positions, so nominal + deviation is written; the control adds
trim = nominal - actual. Any other type: they are the trims that are added to the command, so
-deviation is written. Reading stops in silence at the first line without three numbers: no header,
no comment, no blank line. At most 256 entries, strictly ascending; linear between, held beyond.
With any entry loaded BACKLASH is ignored. Source: LinuxCNC's usrmotintf (reading), command (entries
and slopes), control (direction by the sign of the joint's commanded velocity).
"""

from __future__ import annotations

import re

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables._thinning import thinned
from postproc.errors import UsageError
from postproc.recordings import Source
from postproc.units import UM

TITLE = "LinuxCNC screw compensation file (COMP_FILE, types 0 and 1)"
VERIFIED = True
UNVERIFIED = ""
SIGN = "type 0: actual position = nominal + deviation; type 1: -deviation"
EXTRA = {
    "type": "0 (actual positions) or 1 (trims)",
    "max_loss_um": "um that thinning out to 256 entries may lose, 1",
}
ENTRIES = 256
DECIMALS = {"mm": 6, "inch": 8}  # a nanometre and less
FARTHEST = 5.0  # mm: a larger deviation is a file of the other type, or of another unit


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One file per axis, X.comp. Raises TableError where 256 entries lose more than max_loss_um."""
    unit, decimals = common.mm_per_unit(options), DECIMALS[options.unit]
    kind = common.setting(options, "type", "0", ("0", "1"))
    bound = common.number(options, "max_loss_um", 1.0, 0.0) * UM
    kept, notices = common.own_axis(tables, "LinuxCNC")
    files: dict[str, bytes] = {}
    remainder: dict[str, float] = {}
    for table in kept:
        chosen = common.chosen(table, options, 1 << 20)
        # beyond 256 LinuxCNC refuses the rest, in the middle of the travel
        thin, lost = thinned(chosen, ENTRIES)
        if lost > bound:
            raise TableError(
                f"{table.name} has {len(chosen.nodes)} entries, LinuxCNC holds {ENTRIES}, and"
                f" thinning them out loses {lost / UM:.2f} um",
                f"--spacing for fewer, or --set max_loss_um={lost / UM:.1f} to accept it",
            )
        if len(thin.nodes) < len(chosen.nodes):
            notices.append(
                f"{table.name}: {len(chosen.nodes)} entries thinned out to {len(thin.nodes)}, which"
                f" loses {lost / UM:.3f} um at most"
            )
        #     type 0   100.0 100.012 100.015    where the joint really is: nominal + deviation
        #     type 1   100.0  -0.012  -0.015    what is added to the command: -deviation
        base, sign = (thin.nodes, 1.0) if kind == "0" else (np.zeros_like(thin.nodes), -1.0)
        columns = (thin.nodes, base + sign * thin.forward, base + sign * thin.reverse)
        rows = [
            " ".join(common.fixed(float(v) / unit, decimals) for v in row)
            for row in zip(*columns, strict=True)
        ]
        name = f"{table.moving}.comp"
        data = common.text_of(rows)
        files[name] = data
        back = _parsed(Source(name, data), table.moving, kind, unit)
        remainder[table.name] = common.left(table, back)
        notices.append(
            f"{table.moving}: in the INI file, under the [JOINT_n] of {table.moving}: COMP_FILE ="
            f" {name} and COMP_FILE_TYPE = {kind}; positions are joint coordinates in"
            f" {options.unit}"
        )
    notices.append(
        "LinuxCNC ignores BACKLASH of a joint that has a COMP_FILE: it is in the two columns"
        + (
            ""
            if options.two_way
            else ", but this table is the same for both directions, so lost motion stays"
        )
    )
    return Export(files, tuple(notices), remainder)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """The file's one table. The axis: options.extra["axis"], or the first letter of a file named
    like Z.comp.

    Raises TableError where LinuxCNC would stop reading, or refuse an entry; UsageError where the
    axis is open.
    """
    kind = common.setting(options, "type", "0", ("0", "1"))
    axis = options.extra.get("axis", "")
    if not axis:
        named = re.fullmatch(
            r"(?:.*[/\\])?([XYZABCUVW])(?:[-_ ]?axis)?\.\w+", source.name, re.IGNORECASE
        )
        if named is None:
            raise UsageError(
                f"which axis is {source.name}? A compensation file does not say", "--axis X"
            )
        axis = named[1]
    return [_parsed(source, axis.upper(), kind, common.mm_per_unit(options))]


def _lines(source: Source) -> list[common.Line]:
    """The lines up to the last that holds anything."""
    lines = common.numbered(source)
    while lines and not lines[-1].text.strip():
        lines.pop()
    return lines


def _check_screw(at: common.Line, row: list[float], kind: str) -> None:
    """Raises TableError for a deviation that no screw has. row: mm."""
    off = max(abs(v - (row[0] if kind == "0" else 0.0)) for v in row[1:])
    if off > FARTHEST:
        raise at.fault(
            f"a deviation of {off:g} mm is no screw's: this is not a file of type {kind}, or"
            " not in this unit",
            f"--set type={1 - int(kind)}, or another --unit",
        )


def _parsed(source: Source, axis: str, kind: str, unit: float) -> ErrorTable:
    lines = _lines(source)
    rows: list[list[float]] = []
    for at in lines:
        row = _row(at, lines[-1].number - at.number, unit)
        if rows and row[0] <= rows[-1][0]:
            raise at.fault(
                f"nominal {row[0] / unit:g} does not ascend after {rows[-1][0] / unit:g}",
                "LinuxCNC refuses such an entry: order them, each once",
            )
        if len(rows) == ENTRIES:
            raise at.fault(f"more than {ENTRIES} entries: LinuxCNC refuses the rest")
        _check_screw(at, row, kind)
        rows.append(row)
    if not rows:
        advice = "three numbers a line: nominal, forward, reverse"
        raise common.fault(source, 1, "there are no numbers in it", advice)
    nominal, forward, reverse = np.array(rows).T
    if kind == "0":
        return ErrorTable(axis, axis, nominal, forward - nominal, reverse - nominal)
    return ErrorTable(axis, axis, nominal, -forward, -reverse)


def _row(at: common.Line, below: int, unit: float) -> list[float]:
    """Nominal, forward and reverse of a line, mm; below: how many lines follow. Raises
    TableError."""
    words = at.text.split()[:3]
    if len(words) < 3 or not all(map(_is_number, words)):
        raise at.fault(
            "not three numbers: LinuxCNC stops reading here and says nothing;"
            f" {below} lines below are not loaded",
            "take out comments, headings and blank lines",
        )
    return [at.finite(w, "the entry") * unit for w in words]


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
