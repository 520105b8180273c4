"""What the firmwares of printers share: three skew factors and lost motion, from one-axis tables
and back.

A skew factor says how far an axis moves sideways per mm: the tool stands at x + xy y + xz z, y + yz
z for a command x, y, z. So xy is the slope of EXY, xz that of EXZ, yz that of EYZ. With squareness
of gcomp: xy = -C0Y, xz = B0Z, yz = -A0Z. An axis that leans the other way round (EYX, EZX, EZY:
C0X, -B0X, A0Y) makes the same angle between both, only that the part is turned as a whole; its
slope is added to the factor, and the turn is told.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from postproc.control_tables import ErrorTable, TableError
from postproc.control_tables import _common as common
from postproc.recordings import Source
from postproc.units import UM, URAD

#     y |     /           EXY leans Y by xy > 0 towards +X: a command (0, y) stands at (xy y, y)
#       |    /
#       |   / angle xy    a leaning of X instead, EYX > 0, makes the same angle between both axes:
#       |  /              it closes from 90 degrees as well, and the square is turned besides
#       +---------- x
PLANES = ("xy", "xz", "yz")
FAR = 1000.0  # mm: how far to both sides a table that was read reaches; a factor itself has no ends
STEEPEST = 0.1  # a larger factor is a slip


@dataclass
class Settings:
    """skew: plane to factor; lost: axis to mm of lost motion; left: component to mm; notices."""

    skew: dict[str, float] = field(default_factory=lambda: dict.fromkeys(PLANES, 0.0))
    lost: dict[str, float] = field(default_factory=dict)
    left: dict[str, float] = field(default_factory=dict)
    notices: list[str] = field(default_factory=list)


def _take_lost(result: Settings, table: ErrorTable, backlash: bool) -> None:
    """The lost motion of a positioning error, and what it leaves."""
    # One number for the whole travel: the mean leaves least in squares.
    lost = float(np.mean(table.reverse - table.forward)) if backlash else 0.0
    if lost < 0:
        result.notices.append(
            f"{table.name}: the deviation in - is {-lost / UM:.2f} um below that in +, the"
            " opposite of lost motion: not written"
        )
        lost = 0.0
    elif lost:
        result.lost[table.moving] = lost
    result.left[table.name] = float(
        max(np.abs(table.forward).max(), np.abs(table.reverse - lost).max())
    )


def _take_skew(result: Settings, table: ErrorTable, rest: bool) -> None:
    """The slope of a straightness, and what it leaves. Raises TableError for one too steep."""
    mean = common.mean(table).forward
    # The line's constant is the zero of the other axis, which these firmwares hold elsewhere.
    slope = float(np.polyfit(table.nodes, mean, 1)[0]) if len(table.nodes) > 1 else 0.0
    if abs(slope) > STEEPEST:
        raise TableError(
            f"{table.name} leans by {slope:.3f} mm per mm",
            "a slip in the data or a wrong unit is likely",
        )
    other = table.along > table.moving
    if other and rest:
        slope = 0.0
    plane = "".join(sorted(table.name[1:].lower()))
    result.skew[plane] += slope
    if other and slope:
        result.notices.append(
            f"{table.name} leans by {slope / URAD:.1f} urad: corrected as skew {plane}; the"
            " part lies turned by as much"
        )
    line = slope * table.nodes
    off = max(np.abs(table.forward - line).max(), np.abs(table.reverse - line).max())
    result.left[table.name] = float(off)


def settings(
    tables: list[ErrorTable], control: str, backlash: bool, rest: bool = False
) -> Settings:
    """Factors and lost motion of the tables, least squares over the nodes, and what they leave.
    backlash: whether the control takes up lost motion; rest: whether programs are corrected for
    what is left: then an axis that leans the other way round stays to them, and the part is not
    turned. Raises TableError for no tables, or one twice."""
    result = Settings()
    for table in common.checked(tables):
        if table.moving == table.along:
            _take_lost(result, table, backlash)
        else:
            _take_skew(result, table, rest)
    if large := {name: size for name, size in result.left.items() if size > 0.01 * UM}:
        sizes = ", ".join(f"{name} {size / UM:.2f} um" for name, size in sorted(large.items()))
        result.notices.append(
            f"{control} holds straight leaning{' and lost motion' if backlash else ''} only; it"
            f" leaves: {sizes}"
        )
    return result


def tables(skew: dict[str, float], lost: dict[str, float]) -> list[ErrorTable]:
    """Settings as tables from -FAR to FAR."""
    nodes = np.array([-FAR, FAR])
    found = []
    for plane, factor in skew.items():
        if factor:
            along, moving = plane[0].upper(), plane[1].upper()
            # "xy": X is off by xy times Y, so Y moves and the deviation is along X
            found.append(ErrorTable(moving, along, nodes, factor * nodes, factor * nodes))
    for axis, size in lost.items():
        if size:
            found.append(ErrorTable(axis, axis, nodes, np.zeros(2), np.full(2, size)))
    return found


def lines_of(source: Source) -> list[tuple[common.Line, list[str]]]:
    """Every line that holds more than a comment, and its words. Raises TableError for an empty
    file."""
    rows = ((at, at.text.split(";", 1)[0].upper().split()) for at in common.numbered(source))
    return [(at, words) for at, words in rows if words]


def words(at: common.Line, parts: list[str], lawful: str) -> dict[str, float]:
    """Letter to number of a block's words. Raises TableError for a letter that is not lawful, or
    stands twice."""
    found: dict[str, float] = {}
    for part in parts:
        letter = part[0]
        if letter not in lawful or letter in found:
            lawfully = f"words: {' '.join(lawful)}"
            raise at.fault(f"{part!r} is not read here, or stands twice", lawfully)
        found[letter] = at.finite(part[1:], letter)
    return found


def factor(at: common.Line, value: float) -> float:
    """A factor that can be one. Raises TableError."""
    if abs(value) > STEEPEST:
        raise at.fault(f"a skew factor of {value:g} is no machine's", f"up to {STEEPEST:g}")
    return value
