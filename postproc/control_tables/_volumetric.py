"""What the two volumetric texts share: names of parameters, what a file has said so far, one-axis
tables to a map and back.

No control: ISG CSV and Etalon exchange hold the same parameters in different letters.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from postproc.control_tables import ErrorTable, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.tables import COMPONENTS, GridTable
from postproc.machine.volumetric import VolumetricMap, merged
from postproc.recordings import Source
from postproc.units import UM

COMPONENT = re.compile(r"E([XYZABC])([XYZABC])")
LOCATION = re.compile(r"([XYZABC])0([XYZABC])")
LARGEST = 1e6  # mm: a position or value beyond is a slip
DECIMALS = 12  # as Etalon's own files: a picometre, a microarcsecond's thousandth
SIGN = (
    "+deviation (actual - commanded), by the ISO 230-1 names (unverified); squareness right-handed"
)
EXTRA = {
    "chain": "reading: the axes from the workpiece to the tool, XYZ",
    "workpiece_axes": "reading: how many of them, from the first, carry the workpiece, 0",
}
SIGN_NOTICE = (
    "unverified: that a component is taken as a deviation (actual - commanded), and from where arms"
    " count, follows from the ISO 230-1 names; the manual's pages on the format do not say it."
    " Measure one place with the compensation on: where the deviation has doubled, set `negate XYZ`"
    " in the control's list"
)
ENDS = (
    "what the control does beyond the first and last node is not documented: the tables must be as"
    " long as the travel"
)
FLANGE = (
    "positions count from machine zero with tool length 0; the control adds the tool's length where"
    " N0X N0Y N0Z are set"
)


def plain(value: float) -> str:
    """The shortest text of the number rounded to DECIMALS, never with an exponent and never -0."""
    # + 0.0 turns -0.0 into 0.0
    return str(np.format_float_positional(round(float(value), DECIMALS) + 0.0, trim="0"))


def lines_of(source: Source) -> Iterator[common.Line]:
    """Every line that holds more than a // comment, without it."""
    for at in common.numbered(source):
        if text := at.text.split("//", 1)[0].strip():
            yield at._replace(text=text)


def value_of(at: common.Line, word: str) -> float:
    """A number no larger than a machine. Raises TableError."""
    value = at.finite(word, "the value")
    if abs(value) > LARGEST:
        raise at.fault(f"{word} is too large for a machine", "lengths are mm, angles rad")
    return value


def map_of(tables: list[ErrorTable]) -> tuple[VolumetricMap, dict[str, float]]:
    """One-axis tables as a map without rotations, and component to mm that the mean of both
    directions leaves.

    Raises TableError for no table, or one that is given twice.
    """
    parts: dict[str, list[tuple[int, np.ndarray, np.ndarray, np.ndarray]]] = {}
    for table in common.checked(tables):
        row = XYZ.index(table.along)
        parts.setdefault(table.moving, []).append((row, table.nodes, table.forward, table.reverse))
    left = {t.name: float(np.abs(t.forward - t.reverse).max() / 2) for t in tables}
    return VolumetricMap({x: merged(x, p) for x, p in parts.items()}), {
        n: size for n, size in left.items() if size
    }


def tables_of(found: VolumetricMap, name: str) -> list[ErrorTable]:
    """A map without rotations as one-axis tables. Raises TableError for any other: they would lose
    it."""
    more = [COMPONENTS[i] + x for x, t in found.axes.items() for i in t.rows if i >= 3]
    more += [f"{g.letter} over {g.other}" for g in found.grids] + [
        n for n, a in found.square.items() if a
    ]
    if more:
        raise TableError(
            f"{name} holds a whole machine ({', '.join(more[:6])}): one-axis tables would lose it",
            "read it as a machine",
        )
    return [
        ErrorTable(x, XYZ[i], t.nodes, t.forward[i], t.reverse[i])
        for x, t in found.axes.items()
        for i in t.rows
    ]


def loss(left: dict[str, float]) -> list[str]:
    """The notice about what one value for both directions, and straight lines, leave."""
    if not left:
        return []
    sizes = ", ".join(f"{name} {size / UM:.2f} um" for name, size in sorted(left.items()))
    return [
        "the format holds one value for both directions, straight between nodes; that leaves up"
        f" to: {sizes}"
    ]


class Collected:
    """What a volumetric file has said so far."""

    def __init__(self, source: Source):
        self.source = source
        self.parts: dict[str, list[tuple[int, np.ndarray, np.ndarray, np.ndarray]]] = {}
        self.grids: list[GridTable] = []
        self.square: dict[str, float] = {}
        self.notices: list[str] = []
        self.seen: dict[str, int] = {}

    def once(self, line: int, name: str) -> None:
        """Raises TableError for a parameter that has been given before."""
        if name in self.seen:
            raise common.fault(
                self.source,
                line,
                f"{name} has been given in line {self.seen[name]}",
                "a parameter stands once",
            )
        self.seen[name] = line

    def location(self, name: str, value: float) -> None:
        """A constant: squareness of a linear axis, or what is only told."""
        place = LOCATION.fullmatch(name)
        if (
            place
            and place[1] in ROTARY
            and place[2] in XYZ
            # A0X would be a turn of X about itself: roll, which no squareness is
            and ROTARY.index(place[1]) != XYZ.index(place[2])
        ):
            self.square[name] = value
        elif value:
            self.notices.append(
                f"{name} = {plain(value)} is not read: it is no squareness of two linear axes"
            )

    def component(self, name: str, nodes: np.ndarray, values: np.ndarray) -> None:
        # EXZ: row EX of the table over Z; one direction, so both columns are alike
        self.parts.setdefault(name[2], []).append(
            (COMPONENTS.index(name[:2]), nodes, values, values)
        )

    def grid(
        self, name: str, other: str, nodes: np.ndarray, others: np.ndarray, values: np.ndarray
    ) -> None:
        # (6, K, M): EX EY EZ EA EB EC over K places of the moving axis and M of the other
        full = np.zeros((6, *values.shape))
        full[COMPONENTS.index(name[:2])] = values
        self.grids.append(GridTable(name[2], other, nodes, others, full, full))

    def map(self, options: ExportOptions) -> VolumetricMap:
        """The map. Raises TableError for a chain that is none, or that lacks an axis of the
        file."""
        chain, count = options.extra.get("chain", "XYZ"), options.extra.get("workpiece_axes", "0")
        good = (
            chain
            and set(chain) <= set(XYZ)
            and len(set(chain)) == len(chain)
            and count in ("0", "1", "2", "3")
        )
        if not good or int(count) > len(chain):
            raise TableError(
                f"chain {chain!r} with {count!r} workpiece axes is none",
                "like --set chain=XYZ --set workpiece_axes=1",
            )
        if absent := sorted((set(self.parts) | {g.letter for g in self.grids}) - set(chain)):
            raise TableError(
                f"{self.source.name} has components of {' '.join(absent)}, not in the chain {chain}"
            )
        notices = list(self.notices)
        if "chain" not in options.extra:
            notices.append(
                f"the file does not tell the order of the axes: taken as {chain}, {count} of them"
                " on the workpiece's side"
            )
        axes = {x: merged(x, parts) for x, parts in self.parts.items()}
        return VolumetricMap(
            axes, tuple(self.grids), self.square, tuple(chain), int(count), tuple(notices)
        )
