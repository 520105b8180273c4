"""Siemens 840D, 828D: cross error compensation $AN_CEC (sag, squareness, straightness; with
DIRECTION position by direction).

A table adds its value to the compensation axis over the position of the base axis; DIRECTION 1 and
-1 make a pair for the two directions of travel, 0 is for both. A product of two tables
(MULT_BY_TABLE: the number of the other, its index + 1) is neither written nor read. Points, STEP,
MIN, MAX, DIRECTION: function manual K3, pages 249 and 264, and 802D sl, page
222. The SIGN is not in the pages found: one public generator writes -deviation (`cec_sign=-`);
`cec_sign=+` writes the opposite, and one of both has to be said. The dial-gauge test in the notices
tells, at a tenth of the weight, which is right.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables.siemens_enc_comp import DECIMALS, even_head, even_words, statements
from postproc.errors import UsageError
from postproc.recordings import Source
from postproc.units import UM

TITLE = "Siemens 840D 828D cross error compensation ($AN_CEC)"
VERIFIED = False
UNVERIFIED = "the sign, which has to be said"
SIGN = (
    "-deviation with --set cec_sign=-, +deviation with +; no source says which (unverified), so it"
    " has to be said"
)
STATED = {  # what no source gives, so the user must: key to why and how it is found
    "cec_sign": (
        "the sign of $AN_CEC is in no source that we know: --set cec_sign=- writes -deviation, as"
        " one public generator does, + the opposite; try it at SD41310 = 0.1 with a dial gauge, the"
        " deviation has to become a tenth less"
    )
}
EXTRA = {
    "cec_sign": "- or +, which has to be said",
    "points": "points of one table (MD18342), 200",
    "tables": "tables there are, 8",
    "first_table": "index of the first, 0",
    "axis_Z": "the control's name of axis Z, AX and its number in XYZ",
}
#     $AN_CEC_INPUT_AXIS[0]=(AX1)      base axis: it moves
#     $AN_CEC_OUTPUT_AXIS[0]=(AX3)     compensation axis: it is corrected
#     $AN_CEC_STEP[0]=50  _MIN[0]=0  _MAX[0]=500  _DIRECTION[0]=0  ...     one to a line
#     $AN_CEC[0,0]=0.003               table 0, point 0
WORD = re.compile(r"\$AN_CEC(_[A-Z_]+)?\s*\[([^\]]*)\]\s*=\s*(\S+)", re.IGNORECASE)
KEYS = (
    "_INPUT_AXIS", "_OUTPUT_AXIS", "_STEP", "_MIN", "_MAX", "_DIRECTION", "_MULT_BY_TABLE",
    "_IS_MODULO",
)  # fmt: skip


def _sign(options: ExportOptions) -> float:
    """Of the deviation in the table. Raises UsageError where it is not stated."""
    if "cec_sign" not in options.extra:
        raise UsageError("cec_sign is not said, - or +", STATED["cec_sign"])
    return common.sign(options, "cec_sign", "")


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One file with all tables. Raises TableError where tables or points do not suffice."""
    unit, decimals = common.mm_per_unit(options), DECIMALS[options.unit]
    sign = _sign(options)
    most = common.whole(options, "points", 200, 2, 10000)
    first = common.whole(options, "first_table", 0, 0, 100)
    room = common.whole(options, "tables", 8, 1, 100)
    tables = common.checked(tables)
    notices = [
        "unverified: the sign of $AN_CEC is from one public generator, not from the manual; run the"
        " dial-gauge test first"
    ]
    lines: list[str] = []
    used = first
    shifts: dict[str, float] = {}
    for table in tables:
        at = common.reference(table, options, notices)
        chosen = table if options.two_way else common.mean(table)
        written = common.even(chosen, options, float(chosen.nodes[0]), most)
        written, shifts[table.name] = common.zeroed(written, at, 0.0, notices)
        # DIRECTION 1 and -1, a table each, where the deviation differs; else 0, one for both
        ways = (
            (("1", written.forward), ("-1", written.reverse))
            if written.two_way
            else (("0", written.forward),)
        )
        for direction, values in ways:
            lines += _table(used, written, direction, sign * values / unit, unit, decimals, options)
            used += 1
    if used - first > room:
        raise TableError(
            f"{used - first} tables are needed, and the control has {room}",
            "--component for fewer, --one-way for one instead of two, or --set tables=N if your"
            " control has more",
        )
    note = "; unverified sign: dial-gauge test at SD41310 = 0.1 before use"
    file = "NC_CEC.INI"
    data = common.text_of(["%_N_NC_CEC_INI", "CHANDATA(1)", note, *lines, "M17"])
    remainder = common.remainder(tables, read(Source(file, data), options), shifts)
    notices += _advice(tables, options, most)
    return Export({file: data}, tuple(notices), remainder)


def _table(
    index: int,
    table: ErrorTable,
    direction: str,
    values: np.ndarray,
    unit: float,
    decimals: int,
    options: ExportOptions,
) -> list[str]:
    head = [
        f"$AN_CEC_INPUT_AXIS[{index}]=({_name(table.moving, options)})",
        f"$AN_CEC_OUTPUT_AXIS[{index}]=({_name(table.along, options)})",
        *even_words("$AN_CEC", str(index), table.nodes / unit),
        f"$AN_CEC_DIRECTION[{index}]={direction}",
        f"$AN_CEC_MULT_BY_TABLE[{index}]=0",
        f"$AN_CEC_IS_MODULO[{index}]=0",
    ]
    return head + [
        f"$AN_CEC[{index},{i}]={common.fixed(float(v), decimals)}" for i, v in enumerate(values)
    ]


def _name(letter: str, options: ExportOptions) -> str:
    return common.axis_name(letter, options, f"AX{'XYZUVW'.index(letter) + 1}")


def _advice(tables: list[ErrorTable], options: ExportOptions, most: int) -> list[str]:
    table = max(tables, key=common.largest)
    curve = np.abs(table.forward)
    low, high = float(table.nodes[int(np.argmin(curve))]), float(table.nodes[int(np.argmax(curve))])
    rise = (
        float(table.at(np.array([high]), 1.0)[0]) - float(table.at(np.array([low]), 1.0)[0])
    ) / UM
    weight = "0.1"
    other = "-" if _sign(options) > 0 else "+"
    return [
        (
            f"dial-gauge test: set SD41310 = {weight} (weight), gauge along {table.along}, move"
            f" {table.moving} in + from {low:g} to {high:g}; without tables the gauge shows a"
            f" deviation of {rise:+.1f} um, with them {0.9 * rise:+.1f} um if the sign is right and"
            f" {1.1 * rise:+.1f} um if it is wrong (then --set cec_sign={other})"
        ),
        (
            f"MD18342 must hold {most} points (changing it formats the memory), MD32710 = 1,"
            " SD41300 = 1 for each table, then SD41310 = 1"
        ),
        "axis names in the file: "
        + ", ".join(
            f"{x} is {_name(x, options)}"
            for x in sorted({t.moving for t in tables} | {t.along for t in tables})
        ),
        (
            "what depends on two axes (a rotation times an arm) needs MULT_BY_TABLE, which is not"
            " written: see the notices on what stays"
        ),
    ]


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """One table per pair of axes. Raises TableError with the line for gaps, products, modulo, or
    tables that overlap."""
    tables: dict[int, _Table] = {}
    for at in statements(source):
        key, (index, *point), word = _word(at, at.text)
        tables.setdefault(int(index), _Table(source, f"table {index}")).take(at, key, point, word)
    tables = {t: table for t, table in tables.items() if table.points}
    if not tables:
        raise common.fault(source, 1, "there is no $AN_CEC[...] in this file")
    return _joined(list(tables.values()), options)


@dataclass
class _Table:
    """What a file says of one table. points: index to value as it stands; head: key to its number
    and line; axes: key to the control's name; line: the last that names the table."""

    source: Source
    name: str
    points: dict[int, float] = field(default_factory=dict)
    head: dict[str, tuple[float, int]] = field(default_factory=dict)
    axes: dict[str, str] = field(default_factory=dict)
    line: int = 1

    def take(self, at: common.Line, key: str, point: list[str], word: str) -> None:
        """A word of the file; key: "" for a value. Raises TableError."""
        self.line = at.number
        if key.endswith("_AXIS"):
            self.axes[key] = word.strip("()\"' ").upper()
        elif key:
            self.head[key] = (at.finite(word, "the value"), at.number)
        elif int(point[0]) in self.points:
            raise at.fault(f"point {point[0]} of {self.name} stands twice")
        else:
            self.points[int(point[0])] = at.finite(word, "the value")

    def fault(self, message: str, advice: str = "", key: str = "") -> TableError:
        """What is wrong with the table, or with what stands under a key."""
        line = self.head[key][1] if key else self.line
        return common.fault(self.source, line, message, advice)

    def letter(self, key: str, options: ExportOptions) -> str:
        """The axis of a key. Raises TableError where it is missing or not known."""
        if key not in self.axes:
            raise self.fault(f"{key[1:]} of {self.name} is missing")
        return _letter(self.source, self.axes[key], self.line, options)

    def way(self) -> str:
        """DIRECTION. Raises TableError for another than 0, 1, -1, and for a product."""
        if self.head.get("_MULT_BY_TABLE", (0.0, 0))[0]:
            raise self.fault(
                f"{self.name} is multiplied by another: not read", key="_MULT_BY_TABLE"
            )
        way = f"{self.head.get('_DIRECTION', (0.0, 0))[0]:g}"
        if way not in ("0", "1", "-1"):
            message = f"DIRECTION of {self.name} is {way}, not 0, 1 or -1"
            raise self.fault(message, key="_DIRECTION")
        return way


def _word(at: common.Line, plain: str) -> tuple[str, list[str], str]:
    """What a line gives, "" for a value; the indices of the table and, of a value, the point; and
    what it gives."""
    found = WORD.fullmatch(plain)
    key = (found[1] or "").upper() if found else "?"
    if found is None or key not in ("", *KEYS):
        raise at.fault("this is no line of a cross error compensation", "$AN_CEC[0,0]=0.003")
    indices = [p.strip() for p in re.split("[,.]", found[2])]
    if len(indices) != (1 if key else 2) or not all(map(str.isdigit, indices)):
        raise at.fault(f"[{found[2]}] is not the index of a {'table' if key else 'point'}")
    return key, indices, found[3]


def _joined(tables: list[_Table], options: ExportOptions) -> list[ErrorTable]:
    """Tables of the same two axes made one: DIRECTION 1 forward, -1 reverse, 0 both."""
    unit, sign = common.mm_per_unit(options), _sign(options)
    columns: dict[tuple[str, str], dict[str, tuple[np.ndarray, np.ndarray]]] = {}
    for table in tables:
        count = len(table.points)
        nodes = even_head(table.source, table.name, table.head, count, table.line, unit)
        if sorted(table.points) != list(range(count)):
            raise table.fault(f"{table.name} has a gap: the control keeps what stood there before")
        way = table.way()
        moving, along = (table.letter(key, options) for key in ("_INPUT_AXIS", "_OUTPUT_AXIS"))
        known = columns.setdefault((moving, along), {})
        if way in known or "0" in known or (way == "0" and known):
            raise table.fault(
                f"{table.name} acts from {moving} on {along} in a direction that another has"
                " already",
                "give their sum",
            )
        known[way] = nodes, np.array([table.points[i] for i in range(count)]) * unit * sign
    return [_of_ways(moving, along, ways) for (moving, along), ways in columns.items()]


def _of_ways(moving: str, along: str, ways: dict[str, tuple[np.ndarray, np.ndarray]]) -> ErrorTable:
    """One table of nodes and values by direction."""
    # a direction without a table of its own is not corrected: zero
    none = (np.zeros(1), np.zeros(1))
    up, down = (ways.get("0", ways.get(way, none)) for way in ("1", "-1"))
    nodes = (up if len(up[0]) > 1 else down)[0]
    if {"1", "-1"} <= ways.keys():
        nodes = np.union1d(up[0], down[0])
    return ErrorTable(moving, along, nodes, np.interp(nodes, *up), np.interp(nodes, *down))


def _letter(source: Source, name: str, line: int, options: ExportOptions) -> str:
    for key, value in options.extra.items():
        if key.startswith("axis_") and value.upper() == name:
            return key[5:].upper()
    if number := re.fullmatch(r"AX([1-6])", name):
        return "XYZUVW"[int(number[1]) - 1]
    if name[:1] in "XYZUVW":
        return name[:1]
    raise common.fault(source, line, f"which axis is {name}?", f"--set axis_X={name}")
