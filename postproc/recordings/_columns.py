"""Rows of a CSV table to columns of numbers, with the lines they stand in.

Rows that can not be used (a blank or a NaN in a needed column) are an error with their line, or,
where strict is off, are left out and listed.
"""

from __future__ import annotations

import csv
import itertools
import math
import re
from dataclasses import dataclass, field

import numpy as np

from postproc.errors import Place
from postproc.recordings import Fault, RecordingError, Source
from postproc.recordings import _text as text

# A log of a minute at 1 kHz has 60,000 lines. numpy reads a block at once, some ten times as fast
# as cell by cell; one bad cell costs its block alone.
BLOCK = 20_000  # lines
TEXTS = {"feature", "kind", "axis", "part"}  # columns of features that are words
OPTIONAL = re.compile(
    r"run|t_s|reading|T_\w+_C|load_\w+_N|force_\w+_N|spindle_rpm|feed_mm_min|\w+_current_A|line|\w+_act_(mm|deg)|approach_[A-CX-Z]"
)


def read_columns(
    source: Source,
    lines: list[str],
    top: int,
    names: list[str],
    needed: set[str],
    kind: str,
    strict: bool,
) -> tuple[dict[str, np.ndarray], np.ndarray, list[Fault]]:
    """Columns (N,), the lines they stand in, and the rows left out. Unknown columns are kept, as
    words if they are.

    Blocks in which every cell is a number are read at once; a block with anything else in it is
    read cell by cell.
    """
    table = _Table(source, lines, names, needed, TEXTS if kind == "features" else set(), strict)
    whole = range(top + 1, len(lines))
    if table.texts:
        return _columns(table, [_cells_of_all(table, whole)])
    parts: list[_Part] = []
    for span in (whole[i : i + BLOCK] for i in range(0, len(whole), BLOCK)):
        numbers = _all_numbers(lines[span.start : span.stop], names, needed)
        if numbers is not None:
            parts.append(_Part(numbers, np.arange(span.start + 1, span.stop + 1)))
            continue
        parts.append(_cells_of_all(table, span))
        if parts[-1].words:  # a column of words is words in every block
            parts = [_cells_of_all(table, whole)]
            break
    return _columns(table, parts)


@dataclass(frozen=True)
class _Table:
    """The lines of a table. names: its columns; needed: those that every row must fill; texts:
    those that are words; strict: whether a row that can not be used is an error."""

    source: Source
    lines: list[str]
    names: list[str]
    needed: set[str]
    texts: set[str]
    strict: bool

    def is_known(self, name: str) -> bool:
        return name in self.needed or name in self.texts or bool(OPTIONAL.fullmatch(name))


@dataclass
class _Part:
    """Some rows. numbers: (N, C); at: (N,) their lines; faults: rows left out; words: columns that
    turned out to be words; raw: the cells, of a part that was read cell by cell."""

    numbers: np.ndarray
    at: np.ndarray
    faults: list[Fault] = field(default_factory=list)
    words: set[str] = field(default_factory=set)
    raw: list[list[str]] = field(default_factory=list)


def _with_nan(text: str) -> str:
    """Empty cells as nan."""
    framed = f"\n{text}\n"
    if any(empty in framed for empty in (",,", ",\n", "\n,")):
        # the four places of an empty cell: before a comma, at a line's end, at the end, at the
        # beginning
        return re.sub(r"(?<=[,\n])(?=,)|(?<=,)(?=\n)|(?<=,)\Z|\A(?=,)", "nan", text)
    return text


def _all_numbers(block: list[str], names: list[str], needed: set[str]) -> np.ndarray | None:
    """(N, C) of a block of lines, empty cells as NaN; None where a cell is no number, or a needed
    one is empty."""
    joined = "\n".join(block)
    # Quotes and comments want the slow way, and numpy would take 1_000 for a thousand, which
    # number() refuses.
    if any(sign in joined for sign in '"#_'):
        return None
    try:
        table = np.loadtxt(_with_nan(joined).split("\n"), delimiter=",", comments=None, ndmin=2)
    except ValueError:
        return None
    # a row of another length would have raised; a blank line is passed over and shows in the shape
    if table.shape != (len(block), len(names)) or np.isinf(table).any():
        return None
    wanted = [i for i, name in enumerate(names) if name in needed]
    return None if np.isnan(table[:, wanted]).any() else table


def _cells_of_all(table: _Table, span: range) -> _Part:
    """Some of a table's lines, cell by cell."""
    part = _Part(np.zeros(0), np.zeros(0))
    rows: list[list[float]] = []
    at: list[int] = []
    for i in span:
        line = table.lines[i]
        if not line.strip() or line.startswith("#"):
            continue
        place = Place(table.source.name, i + 1, line)
        cells = [cell.strip() for cell in cells_of(line, place)]
        if cells == table.names:
            raise RecordingError(
                "the header row stands here a second time: these are two recordings in one file",
                "cut the file in two, and name both", place,
            )  # fmt: skip
        row, wrong = _numbers(table, i + 1, cells, part.words)
        if wrong is None:
            rows.append(row)
            part.raw.append(cells)
            at.append(i + 1)
        elif table.strict:
            raise RecordingError(
                wrong.message,
                "every row needs a number in every needed column; --lenient leaves such rows out",
                place,
            )
        else:
            part.faults.append(wrong)
    part.numbers = np.array(rows, np.float64).reshape(len(rows), len(table.names))
    part.at = np.array(at, np.int64)
    return part


def _numbers(
    table: _Table, line: int, cells: list[str], words: set[str]
) -> tuple[list[float], Fault | None]:
    """The numbers of a row, NaN for a cell that is none, and what is wrong with it. Adds to `words`
    the unknown columns in which it has a word."""
    wrong: Fault | None = None
    if len(cells) != len(table.names):
        wrong = Fault(line, "", f"{len(cells)} values under {len(table.names)} columns")
    row = []
    for name, cell in itertools.zip_longest(table.names, cells[: len(table.names)], fillvalue=""):
        found = text.number(cell)
        row.append(math.nan if found is None else found)
        if found is None:
            wrong = wrong or _no_number(table, line, name, cell, words)
    return row, wrong


def _no_number(table: _Table, line: int, name: str, cell: str, words: set[str]) -> Fault | None:
    """What is wrong with a cell that is no number."""
    blank = cell.lower() in ("", "nan")
    if name in table.texts or (blank and name not in table.needed):
        return None
    if not blank and not table.is_known(name):
        words.add(name)
        return None
    return Fault(line, name, f"{name} = {cell!r} is not a number" if cell else f"{name} is empty")


def _no_row(table: _Table, faults: list[Fault]) -> RecordingError:
    """What is said where no row is left."""
    if not faults:
        return table.source.fault(len(table.lines), "there are no rows")
    line = faults[0].line
    return table.source.fault(
        line,
        f"no row can be used: {faults[0].message}, and all {len(faults)} rows are of that kind",
        "look at the columns and at how numbers are written",
        table.lines[line - 1],
    )


def _columns(
    table: _Table, parts: list[_Part]
) -> tuple[dict[str, np.ndarray], np.ndarray, list[Fault]]:
    """The parts as columns. Raises RecordingError where no row is left."""
    faults = list(itertools.chain.from_iterable(part.faults for part in parts))
    at = np.concatenate([np.zeros(0, np.int64), *(part.at for part in parts)]).astype(np.int64)
    if not len(at):
        raise _no_row(table, faults)
    words = table.texts.union(*(part.words for part in parts))
    columns = {
        name: (
            np.array([row[i] for part in parts for row in part.raw], dtype=object)
            if name in words
            else np.concatenate([part.numbers[:, i] for part in parts])
        )
        for i, name in enumerate(table.names)
    }
    return columns, at, faults


def cells_of(line: str, place: Place) -> list[str]:
    """Of one line. Raises RecordingError for what is no CSV."""
    try:
        return next(csv.reader([line]))
    except (csv.Error, StopIteration) as error:
        raise RecordingError(f"not a line of a CSV table: {error}", "", place) from None
