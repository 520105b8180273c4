"""Rows of a CSV table to columns of numbers, with the lines they stand in.

Rows that can not be used (a blank or a NaN in a needed column) are an error with their line, or,
where strict is off, are left out and listed.
"""

from __future__ import annotations

import csv
import itertools
import math
import re
from typing import Any

import numpy as np

from postproc.errors import Place
from postproc.recordings import Fault, RecordingError, Source
from postproc.recordings import _text as text

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
    texts = TEXTS if kind == "features" else set()
    known = needed | texts | {n for n in names if OPTIONAL.fullmatch(n)}
    if kind == "features":
        return _columns(
            names,
            texts,
            [
                _cells_of_all(
                    source, lines, top + 1, len(lines), names, needed, known, texts, strict
                )
            ],
            lines,
            source,
        )
    parts = []
    for first in range(top + 1, len(lines), BLOCK):
        stop = min(first + BLOCK, len(lines))
        table = _all_numbers(lines[first:stop], names, needed)
        part = (
            (table, np.arange(first + 1, stop + 1), [], set(), [])
            if table is not None
            else _cells_of_all(source, lines, first, stop, names, needed, known, texts, strict)
        )
        if part[3]:  # a column of words is words in every block
            parts = [
                _cells_of_all(
                    source, lines, top + 1, len(lines), names, needed, known, texts, strict
                )
            ]
            break
        parts.append(part)
    return _columns(names, texts, parts, lines, source)


def _with_nan(text: str) -> str:
    """Empty cells as nan."""
    framed = f"\n{text}\n"
    if any(empty in framed for empty in (",,", ",\n", "\n,")):
        return re.sub(r"(?<=[,\n])(?=,)|(?<=,)(?=\n)|(?<=,)\Z|\A(?=,)", "nan", text)
    return text


def _all_numbers(block: list[str], names: list[str], needed: set[str]) -> np.ndarray | None:
    """(N, C) of a block of lines, empty cells as NaN; None where a cell is no number, or a needed
    one is empty."""
    joined = "\n".join(block)
    if any(sign in joined for sign in '"#_'):
        return None
    try:
        table = np.loadtxt(_with_nan(joined).split("\n"), delimiter=",", comments=None, ndmin=2)
    except ValueError:
        return None
    if table.shape != (len(block), len(names)) or np.isinf(table).any():
        return None
    wanted = [i for i, name in enumerate(names) if name in needed]
    return None if np.isnan(table[:, wanted]).any() else table


def _cells_of_all(source, lines, first, stop, names, needed, known, texts, strict):
    """Of lines[first:stop], cell by cell: (N, C) numbers, their lines, rows left out, columns of
    words, and the cells."""
    words: set[str] = set()
    raw: list[list[str]] = []
    rows: list[list[Any]] = []
    at: list[int] = []
    faults: list[Fault] = []
    for number in range(first + 1, stop + 1):
        line = lines[number - 1]
        if not line.strip() or line.startswith("#"):
            continue
        place = Place(source.name, number, line)
        cells = [cell.strip() for cell in cells_of(line, place)]
        if cells == names:
            raise RecordingError(
                "the header row stands here a second time: these are two recordings in one file",
                "cut the file in two, and name both", place,
            )  # fmt: skip
        wrong: Fault | None = None
        if len(cells) != len(names):
            wrong = Fault(number, "", f"{len(cells)} values under {len(names)} columns")
            cells = (cells + [""] * len(names))[: len(names)]
        row: list[float] = []
        for name, cell in zip(names, cells, strict=True):
            found = None if name in texts else text.number(cell)
            row.append(math.nan if found is None else found)
            if name in texts or found is not None:
                continue
            blank = cell.lower() in ("", "nan")
            if not blank and name not in known:
                words.add(name)
            elif name in needed or not blank:
                wrong = wrong or _no_number(number, name, cell)
        if wrong is not None:
            if strict:
                raise RecordingError(
                    wrong.message,
                    "every row needs a number in every needed column; --lenient leaves such"
                    " rows out",
                    place,
                )
            faults.append(wrong)
            continue
        rows.append(row)
        raw.append(cells)
        at.append(number)
    return (
        np.array(rows, np.float64).reshape(len(rows), len(names)),
        np.array(at, np.int64),
        faults,
        words,
        raw,
    )


def _no_number(line: int, name: str, cell: str) -> Fault:
    return Fault(line, name, f"{name} = {cell!r} is not a number" if cell else f"{name} is empty")


def _no_row(source: Source, faults: list[Fault], lines: list[str]) -> RecordingError:
    """What is said where no row is left."""
    if not faults:
        return source.fault(len(lines), "there are no rows")
    line = faults[0].line
    return source.fault(
        line,
        f"no row can be used: {faults[0].message}, and all {len(faults)} rows are of that kind",
        "look at the columns and at how numbers are written",
        lines[line - 1],
    )


def _columns(names, texts, parts, lines, source):
    """The parts as columns. Raises RecordingError where no row is left."""
    faults = list(itertools.chain.from_iterable(part[2] for part in parts))
    at = np.concatenate([np.zeros(0, np.int64), *(part[1] for part in parts)]).astype(np.int64)
    if not len(at):
        raise _no_row(source, faults, lines)
    words = set().union(*(part[3] for part in parts)) | texts
    columns = {
        name: (
            np.array([row[i] for part in parts for row in part[4]], dtype=object)
            if name in words
            else np.concatenate([part[0][:, i] for part in parts])
        )
        for i, name in enumerate(names)
    }
    return columns, at, faults


def cells_of(line: str, place: Place) -> list[str]:
    """Of one line. Raises RecordingError for what is no CSV."""
    try:
        return next(csv.reader([line]))
    except (csv.Error, StopIteration) as error:
        raise RecordingError(f"not a line of a CSV table: {error}", "", place) from None
