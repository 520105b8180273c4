"""Siemens 840D, 828D, 808D: interpolatory compensation of an encoder, $AA_ENC_COMP (leadscrew and
measuring system errors).

A positive value moves the axis in the negative direction, so +deviation is written. N = (MAX - MIN)
/ STEP + 1 values without a gap; the first and the last hold over the rest of the travel; zero at
the reference point. Not direction dependent: the mean of both directions is written, and MD32450
(backlash) is stated. Source: function manual K3, pages 238 to 242.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.recordings import Source
from postproc.units import UM

TITLE = "Siemens 840D 828D 808D encoder compensation ($AA_ENC_COMP)"
VERIFIED = True
UNVERIFIED = ""
SIGN = "+deviation, mean of both directions"
EXTRA = {
    "encoder": "0 or 1, 0",
    "points": "MD38000, 200",
    "axis_Z": "the control's name of axis Z, Z1",
    "channel": "1",
}
DECIMALS = {"mm": 5, "inch": 7}
#     %_N_AX_EEC_INI
#     CHANDATA(1)
#     $AA_ENC_COMP[0,0,X1]=0.00300         encoder, point, axis
#     $AA_ENC_COMP[0,1,X1]=0.00180
#     $AA_ENC_COMP_STEP[0,X1]=50           _MIN, _MAX and _IS_MODULO beside it
#     M17
FRAME = re.compile(r"|%.*|CHANDATA.*|M0", re.IGNORECASE)
WORD = re.compile(
    r"\$AA_ENC_COMP(_STEP|_MIN|_MAX|_IS_MODULO)?\s*\[([^\]]*)\]\s*=\s*(\S+)", re.IGNORECASE
)


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One file for all axes. Raises TableError where the points do not suffice."""
    unit, decimals = common.mm_per_unit(options), DECIMALS[options.unit]
    encoder = common.whole(options, "encoder", 0, 0, 1)
    most = common.whole(options, "points", 200, 2, 5000)
    kept, notices = common.own_axis(tables, "the encoder compensation")
    lines = ["%_N_AX_EEC_INI", f"CHANDATA({common.whole(options, 'channel', 1, 1, 10)})"]
    done: list[tuple[ErrorTable, float]] = []
    for table in kept:
        at = common.reference(table, options, notices)
        middle = common.mean(table)
        written = common.even(middle, options, float(table.nodes[0]), most)
        written, by = common.zeroed(written, at, 0.0, notices)
        done.append((table, by))
        name = common.axis_name(table.moving, options, f"{table.moving}1")
        lines += [
            f"$AA_ENC_COMP[{encoder},{i},{name}]={common.fixed(v / unit, decimals)}"
            for i, v in enumerate(written.forward)
        ]
        lines += even_words("$AA_ENC_COMP", f"{encoder},{name}", written.nodes / unit)
        lines.append(f"$AA_ENC_COMP_IS_MODULO[{encoder},{name}]=0")
        notices.append(
            f"{name}: MD38000 must be at least {len(written.nodes)}; load with MD32700 = 0, then"
            " set MD32700 = 1 and reference the axis"
        )
        _held(written, notices)
    file = "AX_EEC.INI"
    data = common.text_of([*lines, "M17"])
    back = {t.moving: t for t in read(Source(file, data), options)}
    remainder = {}
    for table, by in done:
        play = common.play(table)
        target, got = common.shifted(table, by), back[table.moving]
        plain = common.left(target, got)
        if table.two_way:
            # MD32450 moves the axis on by `play` at a reversal: half of it to either side of the
            # mean.
            got = ErrorTable(
                got.moving, got.along, got.nodes, got.forward - play / 2, got.reverse + play / 2
            )
            notices.append(
                f"{table.name}: the table is the mean of both directions; set MD32450 (backlash) ="
                f" {common.fixed(play / unit, decimals)} {options.unit}: without it up to"
                f" {plain / UM:.2f} um stay, with it {common.left(target, got) / UM:.2f} um; tables"
                " by direction: --control siemens-cec"
            )
        remainder[table.name] = common.left(target, got)
    notices.append(
        f"values are in {options.unit}, the unit of MD10240; the size of a value is not watched by"
        " the control"
    )
    return Export({file: data}, tuple(notices), remainder)


def _held(written: ErrorTable, notices: list[str]) -> None:
    ends = [(float(written.nodes[i]), float(written.forward[i])) for i in (0, -1)]
    said = ", ".join(
        f"{v / UM:+.2f} um beyond {written.moving} = {p:g}" for p, v in ends if abs(v) > 1e-9
    )
    if said:
        notices.append(
            f"{written.name}: the first and last values are held over the rest of the travel:"
            f" {said}"
        )


def even_words(variable: str, index: str, nodes: np.ndarray) -> list[str]:
    """STEP, MIN and MAX of a table with even nodes (K,), control's unit."""
    first, last = nodes[0], nodes[-1]
    step = (last - first) / max(1, len(nodes) - 1)
    return [
        f"{variable}_{key}[{index}]={common.place(value)}"
        for key, value in (("STEP", step), ("MIN", first), ("MAX", last))
    ]


def statements(source: Source) -> Iterator[common.Line]:
    """The lines between the frame of a file and its M17, without comments. Raises TableError where
    M17 is missing or is not the end."""
    ended = False
    for at in common.numbered(source):
        plain = at.text.split(";")[0].strip()
        if FRAME.fullmatch(plain):
            continue
        if ended:
            raise at.fault("text after M17, which ends the file")
        ended = plain.upper() in ("M17", "M02", "M30")
        if not ended:
            yield at._replace(text=plain)
    if not ended:
        raise common.fault(source, at.number, "M17 is missing: the file is not whole")


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """One table per axis. Raises TableError with the line for gaps, a STEP that does not fit,
    modulo tables or no M17."""
    unit = common.mm_per_unit(options)
    values: dict[str, dict[int, tuple[float, int]]] = {}
    heads: dict[str, dict[str, tuple[float, int]]] = {}
    for at in statements(source):
        key, inside, value = _word(at, at.text)
        name = inside[-1].upper()
        if key:
            heads.setdefault(name, {})[key] = (value, at.number)
            continue
        if not inside[1].isdigit():
            raise at.fault(f"the point {inside[1]!r} is not a whole number")
        points = values.setdefault(name, {})
        if int(inside[1]) in points:
            raise at.fault(f"point {inside[1]} of {name} stands twice")
        points[int(inside[1])] = (value * unit, at.number)
    if not values:
        raise common.fault(source, 1, "there is no $AA_ENC_COMP[...] in this file")
    return [
        _axis(source, name, points, heads.get(name, {}), unit, options)
        for name, points in values.items()
    ]


def _word(at: common.Line, plain: str) -> tuple[str, list[str], float]:
    """What a line gives, "" for a point; the indices; and the value. Raises TableError."""
    found = WORD.fullmatch(plain)
    if found is None:
        raise at.fault("this is no line of an encoder compensation", "$AA_ENC_COMP[0,0,X1]=0.003")
    key, inside = (found[1] or "").upper(), [p.strip() for p in found[2].split(",")]
    value = at.finite(found[3], "the value")
    if len(inside) != (2 if key else 3):
        raise at.fault(f"[{found[2]}] has {len(inside)} indices")
    return key, inside, value


def _axis(
    source: Source,
    name: str,
    points: dict[int, tuple[float, int]],
    head: dict[str, tuple[float, int]],
    unit: float,
    options: ExportOptions,
) -> ErrorTable:
    last_line = max(line for _, line in points.values())
    nodes = even_head(source, name, head, len(points), last_line, unit)
    for i in range(len(points)):
        if i not in points:
            raise common.fault(
                source,
                last_line,
                f"point {i} of {name} is missing: the control keeps what stood there before",
                "write every point",
            )
    letter = common.letter_of(name, options)
    if letter not in "XYZUVW":
        raise TableError(f"which axis is {name}?", f"--set axis_X={name}")
    column = np.array([points[i][0] for i in range(len(points))])
    return ErrorTable(letter, letter, nodes, column, column)


def even_head(
    source: Source,
    name: str,
    head: dict[str, tuple[float, int]],
    count: int,
    line: int,
    unit: float,
) -> np.ndarray:
    """(count,) mm: the positions that STEP, MIN and MAX give. Raises TableError where they do not
    fit the points."""
    for key in ("_STEP", "_MIN", "_MAX"):
        if key not in head:
            raise common.fault(source, line, f"{key[1:]} of {name} is missing")
    (step, at), (low, _), (high, _) = head["_STEP"], head["_MIN"], head["_MAX"]
    if head.get("_IS_MODULO", (0.0, 0))[0]:
        raise common.fault(
            source, head["_IS_MODULO"][1], f"{name} is a modulo table, of a rotary axis: not read"
        )
    if count > 1 and (step <= 0 or abs((high - low) / step + 1 - count) > 1e-3):
        raise common.fault(
            source,
            at,
            f"{name}: MIN {low:g} to MAX {high:g} in steps of {step:g} does not give {count}"
            " points",
            "points = (MAX - MIN) / STEP + 1",
        )
    return np.asarray(np.round(np.linspace(low, high, count) * unit, 9))
