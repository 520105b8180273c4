"""What the controls share: even points, zero at the reference, the comparison of a written table
with its map.

No control: it knows no format and no sign.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from postproc import intake
from postproc.control_tables import ErrorTable, ExportOptions, TableError
from postproc.errors import Place, UsageError
from postproc.recordings import Source
from postproc.units import MM_PER_INCH, UM

GRAIN = 0.0001  # mm: positions closer than that are one
NICE = (1.0, 2.0, 5.0)


def mm_per_unit(options: ExportOptions) -> float:
    """mm of one length unit of the control. Raises UsageError for a unit that is neither mm nor
    inch."""
    if options.unit not in ("mm", "inch"):
        raise UsageError(
            f"the unit {options.unit!r} is neither mm nor inch", "--unit mm, or --unit inch"
        )
    return MM_PER_INCH if options.unit == "inch" else 1.0


def setting(options: ExportOptions, key: str, default: str, among: Sequence[str] = ()) -> str:
    """A control's own option. Raises UsageError with the lawful values."""
    value = options.extra.get(key, default)
    if among and value not in among:
        raise UsageError(
            f"{key} = {value!r} is not known", f"--set {key}= one of {', '.join(among)}"
        )
    return value


def sign(options: ExportOptions, key: str, default: str) -> float:
    """A control's own option that is + or -, as 1 or -1."""
    return 1.0 if setting(options, key, default, ("-", "+")) == "+" else -1.0


def number(
    options: ExportOptions, key: str, default: float, low: float = -math.inf, high: float = math.inf
) -> float:
    """A control's own number. Raises UsageError where it is none, or outside low to high."""
    text = options.extra.get(key, "")
    try:
        value = float(text) if text else default
    except ValueError:
        raise UsageError(f"{key} = {text!r} is not a number", f"--set {key}={default:g}") from None
    if not low <= value <= high:
        raise UsageError(f"{key} = {value:g} is not between {low:g} and {high:g}")
    return value


def whole(options: ExportOptions, key: str, default: int, low: int, high: int) -> int:
    """As `number`, without a fraction."""
    value = number(options, key, default, low, high)
    if value != int(value):
        raise UsageError(f"{key} = {value:g} is not a whole number")
    return int(value)


def checked(tables: Sequence[ErrorTable]) -> list[ErrorTable]:
    """The tables, if they can be written at all. Raises TableError for none, one twice, or values
    that are not finite."""
    if not tables:
        raise TableError(
            "there is nothing to write: no component is left",
            "see what the machine has: gcomp machines show",
        )
    seen: set[str] = set()
    for table in tables:
        if table.name in seen:
            raise TableError(
                f"{table.name} is given twice", "a control adds them up: give their sum"
            )
        seen.add(table.name)
        if not len(table.nodes) or np.any(np.diff(table.nodes) <= 0):
            raise TableError(f"the nodes of {table.name} do not ascend")
            # nan is a number of no control
        if not all(np.all(np.isfinite(v)) for v in (table.nodes, table.forward, table.reverse)):
            raise TableError(f"{table.name} has values that are not finite")
    return list(tables)


def own_axis(tables: Sequence[ErrorTable], control: str) -> tuple[list[ErrorTable], list[str]]:
    """Tables of axes along themselves, and a notice for each other one, that this control has no
    place for.

    Raises TableError where nothing is left.
    """
    tables = checked(tables)
    kept = [t for t in tables if t.moving == t.along]
    notices = [
        f"{t.name} is not written: {control} has no table of {t.moving} that corrects {t.along};"
        f" {largest(t) / UM:.2f} um stay"
        for t in tables
        if t.moving != t.along
    ]
    if not kept:
        raise TableError(
            f"{control} only holds tables along the moving axis, and there is none among"
            f" {', '.join(t.name for t in tables)}",
            "correct the rest in the program: gcomp --machine M FILE",
        )
    return kept, notices


def largest(table: ErrorTable) -> float:
    """mm: the largest deviation of either direction."""
    return float(max(np.abs(table.forward).max(), np.abs(table.reverse).max()))


def mean(table: ErrorTable) -> ErrorTable:
    """The same for both directions: their mean."""
    middle = (table.forward + table.reverse) / 2
    return replace(table, forward=middle, reverse=middle)


def play(table: ErrorTable) -> float:
    """mm: the lost motion that a control without tables by direction is told, positive where the
    axis stops short in both.

    The middle between the largest and the smallest, so that the worst that stays is least.
    """
    # Approached in -, an axis with lost motion stays too far in +: its deviation is larger by it.
    gap = table.reverse - table.forward
    return float(gap.max() + gap.min()) / 2


def shifted(table: ErrorTable, by: float) -> ErrorTable:
    """The table less a constant, mm."""
    return replace(table, forward=table.forward - by, reverse=table.reverse - by)


def reference(table: ErrorTable, options: ExportOptions, notices: list[str]) -> float:
    """mm: the moving axis' reference position; 0 with a notice where it is not stated."""
    if table.moving in options.reference:
        return float(options.reference[table.moving])
    text = (
        f"the reference position of {table.moving} is not stated: taken as {table.moving} = 0"
        f" (--reference {table.moving}=0)"
    )
    if text not in notices:
        notices.append(text)
    return 0.0


def zeroed(
    table: ErrorTable, at: float, approach: float, notices: list[str]
) -> tuple[ErrorTable, float]:
    """The table with zero at a position, for an approach (0: the mean), and the constant in mm that
    was taken off."""
    # Referencing sets the position there: a table that is not zero at it would shift the zero by as
    # much.
    by = float(table.at(np.array([at]), approach)[0])
    if abs(by) > 1e-9:
        notices.append(
            f"{table.name}: {-by / UM:+.2f} um is added throughout, so that it is zero at the"
            f" reference {table.moving} = {at:g}; that moves the zero of {table.along}, not the"
            " shape"
        )
    return shifted(table, by), by


def chosen(
    table: ErrorTable, options: ExportOptions, most: int, always: bool = False
) -> ErrorTable:
    """The table that the control holds: of one direction or both, at even nodes where a spacing was
    asked for, or `always`."""
    one = table if options.two_way or not table.two_way else mean(table)
    if not options.spacing and not always:
        return one
    return even(one, options, float(one.nodes[0]), most)


def sampled(table: ErrorTable, nodes: np.ndarray) -> ErrorTable:
    """The table at other nodes."""
    return replace(table, nodes=nodes, forward=table.at(nodes, 1.0), reverse=table.at(nodes, -1.0))


def even(
    table: ErrorTable, options: ExportOptions, anchor: float, most: int, multiple: float = GRAIN
) -> ErrorTable:
    """The table at its `even_nodes`."""
    return sampled(table, even_nodes(table, options, anchor, most, multiple))


def even_mean(
    table: ErrorTable, options: ExportOptions, most: int, notices: list[str]
) -> tuple[ErrorTable, float]:
    """The mean of both directions at even nodes, one of them the reference, and zero there; and the
    constant in mm that was taken off."""
    # the reference is made a node first: at even nodes only a node can be zero exactly
    home = reference(table, options, notices)
    whole = sampled(mean(table), np.union1d(table.nodes, [home]))
    return zeroed(even(whole, options, home, most), home, 0.0, notices)


def lost_motion(table: ErrorTable) -> list[str]:
    """The notice of a control that holds the mean of both directions."""
    if not table.two_way:
        return []
    return [
        f"{table.name}: the mean of both directions is written; lost motion of"
        f" {play(table) / UM:+.1f} um is a parameter of its own"
    ]


def is_letter(cell: str) -> bool:
    """Whether a cell can name an axis."""
    return len(cell) == 1 and cell.isalpha()


def _common_step(places: np.ndarray, multiple: float) -> float:
    """mm: the largest step of which all places are multiples; 0 where one is no whole multiple of
    `multiple` mm."""
    # whole multiples of `multiple`, 0 among them, so that gcd of 0, 20, 50 is 10
    ticks = np.append(places / multiple, 0.0)
    if np.any(np.abs(ticks - np.round(ticks)) >= 1e-3):
        return 0.0
    return math.gcd(*(int(t) for t in np.round(ticks))) * multiple


def even_nodes(
    table: ErrorTable, options: ExportOptions, anchor: float, most: int, multiple: float = GRAIN
) -> np.ndarray:
    """Evenly spaced positions, mm, of which one would be `anchor`, that cover the table's nodes.

    The spacing is options.spacing, or the largest that meets every node; where that takes more than
    `most` points, the smallest of 1, 2, 5, 10 ... that does not. Spacings are whole multiples of
    `multiple` mm. Raises TableError where the spacing asked for needs more points than there are.
    """
    places, step = table.nodes - anchor, options.spacing
    if step < 0 or abs(step / multiple - round(step / multiple)) > 1e-6:
        raise UsageError(f"a spacing of {step:g} mm is not a multiple of {multiple:g} mm")
    long = float(table.nodes[-1]) - float(table.nodes[0])
    # two of the points may lie beyond the ends, on either side
    least = long / max(1, most - 2)
    if step and (count := len(_covering(places, step))) > most:
        raise TableError(
            f"{table.name}: {long:g} mm in steps of {step:g} mm are {count} points,"
            f" and the control has {most}",
            f"--spacing {math.ceil(least):g} or more, or --set points=N if your control has more",
        )
    # The largest step that meets every node loses nothing of the map; any other rounds off its
    # corners.
    step = step or _common_step(places, multiple)
    if not step or len(_covering(places, step)) > most:
        step = _nice_step(places, multiple, most, least)
    return np.round(anchor + step * np.array(_covering(places, step)), 9)


def _nice_step(places: np.ndarray, multiple: float, most: int, least: float) -> float:
    """mm: the smallest of 1, 2, 5, 10 ... with which `most` points cover the places, not below
    `least` nor a quarter of the smallest gap."""
    if len(places) > 1:
        least = max(least, float(np.diff(places).min()) / 4)
    wide = (v for v in _nice(multiple) if v >= least - 1e-9)
    return next(v for v in wide if len(_covering(places, v)) <= most)


def _covering(places: np.ndarray, step: float) -> range:
    """The multiples of a step that cover ascending places."""
    low, high = float(places[0]), float(places[-1])
    # 1e-6 of a step: 0.30000000000000004 / 0.1 is 3, and no fourth point is needed for it
    return range(math.floor(low / step + 1e-6), math.ceil(high / step - 1e-6) + 1)


def _nice(multiple: float) -> Iterable[float]:
    decade = multiple
    while True:
        yield from (decade * n for n in NICE)
        decade *= 10


def left(table: ErrorTable, written: ErrorTable) -> float:
    """mm: the largest deviation, of either direction, that a written table leaves of the map it was
    made from.

    Exact: both are straight between their nodes and held beyond, so that no place between is worse.
    """
    places = np.union1d(table.nodes, written.nodes)
    return float(
        max(np.abs(table.at(places, way) - written.at(places, way)).max() for way in (1.0, -1.0))
    )


def remainder(
    tables: Sequence[ErrorTable], written: Sequence[ErrorTable], by: Mapping[str, float] = {}
) -> dict[str, float]:
    """`left` of each table, less the constant `by` that was taken off, by the name of one that was
    read back."""
    back = {t.name: t for t in written}
    return {t.name: left(shifted(t, by.get(t.name, 0.0)), back[t.name]) for t in tables}


def text_of(lines: Iterable[str], end: str = "\n") -> bytes:
    """Lines as the text of a file."""
    return "".join(line + end for line in lines).encode()


def fixed(value: float, decimals: int) -> str:
    """A number with so many decimals, never -0."""
    text = f"{value:.{decimals}f}"
    return text[1:] if text.startswith("-") and not float(text) else text


def place(value: float) -> str:
    """A position or a spacing to 8 decimals, without needless zeros."""
    return f"{round(value, 8) + 0.0:.12g}"


class Line(NamedTuple):
    """A line of a file, its number from 1."""

    number: int
    text: str
    source: Source

    def fault(self, message: str, advice: str = "") -> TableError:
        """The error to raise here."""
        return fault(self.source, self.number, message, advice, self.text)

    def finite(self, word: str, what: str) -> float:
        """A number of the line. Raises TableError where it is none."""
        return finite(self.source, self.number, word, what, self.text)


def numbered(source: Source) -> list[Line]:
    """Every line. Raises TableError for an empty file or text that is not UTF-8."""
    if not source.data.strip():
        raise fault(source, 1, "the file is empty")
    return [Line(i, text, source) for i, text in enumerate(intake.lines_of(source.text), 1)]


def csv_rows(lines: Iterable[Line]) -> Iterator[tuple[Line, list[str]]]:
    """The rows of a list between commas, its heading first; `#` begins a comment line. Raises
    TableError for a row with other columns than the heading."""
    columns = 0
    for at in lines:
        if not at.text.strip() or at.text.startswith("#"):
            continue
        cells = [cell.strip() for cell in next(csv.reader([at.text]))]
        columns = columns or len(cells)
        if len(cells) != columns:
            raise at.fault(f"{len(cells)} values under {columns} columns")
        yield at, cells


def fault(source: Source, line: int, message: str, advice: str = "", text: str = "") -> TableError:
    """A fault of a file, with its place."""
    return TableError(message, advice, Place(source.name, line, text))


def finite(source: Source, line: int, word: str, what: str, text: str = "") -> float:
    """A number of a file. Raises TableError with the place where it is none."""
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise fault(source, line, f"{what} {word.strip()!r} is not a number", "", text)
    return value


def letter_of(name: str, options: ExportOptions) -> str:
    """The axis letter of a control's axis name: as --set axis_Z=NAME says, or its own first letter
    (Z1 is Z)."""
    for key, value in options.extra.items():
        if key.startswith("axis_") and value.upper() == name.upper():
            return key[5:].upper()
    return name[:1].upper()


def axis_name(letter: str, options: ExportOptions, usual: str) -> str:
    """The control's name of an axis."""
    return options.extra.get(f"axis_{letter}", usual)
