"""Leadscrew error compensation of Beckhoff TwinCAT CNC and ISG kernels: the list kw.ssfk.* of one
axis.

Lengths are whole tenths of a micrometre (unit 1). interval 0: every point has its setpoint; else
points stand evenly from kw_startpos on. bilateral 1: .pos for motion in +, .neg in -; the control
spreads a reversal over lr_param.n_backlash_cyc cycles. Linear between points. Source: Beckhoff
TF5200 axis compensation, "Overview" (management data), "Example - Non-equidistant bilateral SSFK",
P-COMP-00017 to -00025, -00059.

Sign: the manual's example computes the value as actual - setpoint (19856.5 um reached for 19866.7
um is -102): +e.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.recordings import Source
from postproc.units import UM

TITLE = "Beckhoff and ISG leadscrew error compensation list (kw.ssfk)"
VERIFIED = True
UNVERIFIED = ""
SIGN = "actual - setpoint = +deviation, in 0.1 um"
TENTH = 0.0001  # mm, the unit of the list
POINTS = 1500  # P-COMP-00059, its default
EXTRA = {
    "points": "how many entries kw.ssfk.max_points allows, 1500",
    "axis_X": "the control's name of axis X",
    "number_X": "its logical number",
}
#     kopf.achs_nr 1                   kopf.log_achs_name X
#     kw.ssfk.interval 0               each point has its setpoint; else their distance, 0.1 um
#     kw.ssfk.kw_nr_max 2              kw.ssfk.unit 1    kw.ssfk.bilateral 1
#     kw.ssfk.table[0].setpoint 0      kw.ssfk.table[0].pos -102      kw.ssfk.table[0].neg -95
LINE = re.compile(r"(kopf|kw)\.([a-z_0-9.]+?)(?:\[\s*(\d+)\s*\]\.(setpoint|pos|neg))?\s+(\S.*)")
COMMENT = re.compile(r"/\*.*?\*/|#.*")


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One list per axis. Raises TableError where there are more points than the control holds."""
    most = common.whole(options, "points", POINTS, 2, 1_000_000)
    kept, notices = common.own_axis(tables, "the list kw.ssfk")
    files: dict[str, bytes] = {}
    left: dict[str, float] = {}
    for table in kept:
        chosen = table if options.two_way or not table.two_way else common.mean(table)
        if options.spacing:
            first = float(np.round(chosen.nodes[0], 4))
            chosen = common.even(chosen, options, first, most, TENTH)
        elif len(chosen.nodes) > most:
            raise TableError(
                f"{table.name} has {len(chosen.nodes)} points, the list holds {most}",
                "--spacing for fewer, or --set points=N",
            )
        data = _text(chosen, options, notices)
        name = f"achskw_{table.moving}.lis"
        files[name] = data
        left[table.name] = common.left(table, _parsed(Source(name, data), options, table.moving))
        if table.two_way and not options.two_way:
            notices.append(
                f"{table.name}: one table for both directions; the control's backlash must stay as"
                " it is"
            )
    notices += [
        (
            "activate with lr_param.ssfk 1 in the axis' parameters; with both directions in the"
            " list its own backlash must be 0"
        ),
        (
            "what the control does beyond the first and last point is not documented: the table"
            " must be as long as the travel"
        ),
    ]
    return Export(files, tuple(notices), left)


def _text(table: ErrorTable, options: ExportOptions, notices: list[str]) -> bytes:
    places, pos, neg = (
        np.round(v / TENTH).astype(np.int64) for v in (table.nodes, table.forward, table.reverse)
    )
    if np.any(np.diff(places) <= 0):
        raise TableError(
            f"two nodes of {table.name} are closer than {TENTH / UM:g} um", "leave one out"
        )
    x = table.moving
    key = f"number_{x}"
    usual = 1 + "XYZABC".index(x)
    if key not in options.extra:
        notices.append(f"{x} is written as logical axis {usual}: --set {key}=N if it is another")
    logical = common.whole(options, key, usual, 1, 65535)
    # 0: each point brings its setpoint, so that the map's own nodes are written and nothing is lost
    gap = int(places[1] - places[0]) if options.spacing and len(places) > 1 else 0
    bilateral = int(not np.array_equal(pos, neg))
    head = [
        f"# {options.program}: {table.name}, actual - setpoint, 0.1 um",
        f"kopf.achs_nr {logical}",
        f"kopf.log_achs_name {common.axis_name(x, options, x)}",
        f"kw.ssfk.interval {gap}",
        f"kw.ssfk.kw_startpos {places[0]}",
        f"kw.ssfk.kw_nr_max {len(places)}",
        "kw.ssfk.unit 1",
        f"kw.ssfk.bilateral {bilateral}",
    ]
    none = places[:0]
    columns = {"setpoint": none if gap else places, "pos": pos, "neg": neg if bilateral else none}
    rows = [f"kw.ssfk.table[{i}].{n} {v}" for n, c in columns.items() for i, v in enumerate(c)]
    return common.text_of(head + rows)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """The list's one table; the axis by its name in the list. Raises TableError with file and
    line."""
    return [_parsed(source, options)]


@dataclass
class List:
    """A list's entries: keys to their line and words; columns of the table to their points; last:
    the last line."""

    source: Source
    head: dict[str, tuple[int, str]] = field(default_factory=dict)
    cells: dict[str, dict[int, float]] = field(
        default_factory=lambda: {"setpoint": {}, "pos": {}, "neg": {}}
    )
    last: int = 1

    def fault(self, key: str, message: str, advice: str = "") -> TableError:
        """What is wrong with the entry of a key."""
        return common.fault(self.source, self.head[key][0], message, advice)

    def number(self, key: str, usual: float | None = None) -> float:
        """The number of a key. Raises TableError where it is missing and none is usual."""
        if key in self.head:
            return common.finite(self.source, *self.head[key], key)
        if usual is None:
            raise common.fault(self.source, self.last, f"kw.{key} is missing")
        return usual

    def column(self, name: str, count: int) -> np.ndarray:
        """A column of the table. Raises TableError where one of its points is missing."""
        points = self.cells[name]
        for i in range(count):
            if i not in points:
                missing = f"table[{i}].{name} is missing, kw_nr_max is {count}"
                raise common.fault(self.source, self.last, missing)
        return np.array([points[i] for i in range(count)])


def _entries(source: Source) -> List:
    """Line by line. Raises TableError for what is no entry, or stands twice."""
    result = List(source)
    for at in common.numbered(source):
        text = COMMENT.sub("", at.text).strip()
        if not text or text.lower() in ("end", "ende"):
            continue
        result.last = at.number
        found = LINE.fullmatch(text)
        if not found:
            raise at.fault("not an entry of a compensation list", "like kw.ssfk.unit 1")
        _, key, index, column, value = found.groups()
        if index is None:
            if key in result.head:
                raise at.fault(f"{key} has been given in line {result.head[key][0]}")
            result.head[key] = (at.number, value.strip())
            continue
        if key != "ssfk.table":
            raise at.fault(f"kw.{key} is not read: only kw.ssfk is")
        if int(index) in result.cells[column]:
            raise at.fault(f"table[{index}].{column} is given twice")
        result.cells[column][int(index)] = at.finite(value, "the entry")
    return result


def _columns(entries: List, count: int, gap: float) -> dict[str, np.ndarray]:
    """mm of each column that the list must have. Raises TableError where a point is missing, or one
    too many."""
    needed = ["pos"] if gap else ["setpoint", "pos"]
    if entries.number("ssfk.bilateral", 0):
        needed.append("neg")
    columns = {c: entries.column(c, count) * TENTH for c in needed}
    extra = [f"table[{i}].{c}" for c, points in entries.cells.items() for i in points if i >= count]
    if extra:
        raise common.fault(entries.source, entries.last, f"{extra[0]} is beyond kw_nr_max {count}")
    return columns


def _parsed(source: Source, options: ExportOptions, letter: str = "") -> ErrorTable:
    entries = _entries(source)
    if entries.number("ssfk.unit") != 1:
        raise entries.fault(
            "ssfk.unit", "unit 0: lengths are encoder increments", "only unit 1, 0.1 um, is read"
        )
    if entries.number("ssfk.modulo", 0):
        raise entries.fault("ssfk.modulo", "a modulo axis: tables of rotary axes are not read")
    count, gap = int(entries.number("ssfk.kw_nr_max")), entries.number("ssfk.interval", 0)
    if count < 2:
        raise entries.fault("ssfk.kw_nr_max", f"kw_nr_max is {count}: a table needs two points")
    column = _columns(entries, count, gap)
    if gap:
        nodes = (entries.number("ssfk.kw_startpos", 0) + gap * np.arange(count)) * TENTH
    else:
        nodes = column["setpoint"]
    if np.any(np.diff(nodes) <= 0):
        raise common.fault(source, entries.last, "the setpoints do not ascend")
    name = entries.head.get("log_achs_name", (1, ""))[1]
    axis = letter or common.letter_of(name, options)
    if axis not in tuple("XYZ"):
        raise common.fault(
            source, 1, f"log_achs_name is {name!r}: no linear axis X, Y or Z", "--set axis_X=NAME"
        )
    table = ErrorTable(axis, axis, nodes, column["pos"], column.get("neg", column["pos"]))
    return replace(table, nodes=np.round(nodes, 7))
