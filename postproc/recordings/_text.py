"""Text, numbers and tables as instruments and spreadsheets write them: encodings, decimal commas,
delimiters, directions."""

from __future__ import annotations

import csv
import datetime
import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from postproc.errors import Place, UsageError
from postproc.intake import lines_of
from postproc.recordings import RecordingError, Source

NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]{1,3})?")
COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+([eE][-+]?[0-9]{1,3})?")
# 1,234 may be 1.234 or 1234; 0,123 and 12,5 are decimals
THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2},[0-9]{3}")
DELIMITERS = {"\t": "tab", ";": "semicolon", "|": "bar", ",": "comma"}
LONGEST_LINE = 100_000
BOMS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}

UP = {"+", "+1", "1", "up", "↑", "pos", "positive", "plus"}
DOWN = {"-", "-1", "down", "dn", "↓", "neg", "negative", "minus"}
THERE = {"fwd", "forward", "f", "go", "hin"}
BACK = {"rev", "reverse", "return", "back", "backward", "bwd", "r", "her", "rück", "zurück"}


def decoded(source: Source, tries: Sequence[str] = ("cp1252",)) -> tuple[str, list[str]]:
    """The text, of UTF-8, UTF-16 with its mark, then `tries`, and a notice where it took these.

    Raises RecordingError with the line of the first byte that is none of them.
    """
    for mark, name in BOMS.items():
        if source.data.startswith(mark):
            try:
                return source.data.decode(name), []
            except UnicodeDecodeError:
                raise source.fault(
                    1, "the file begins as UTF-16 and does not go on as it", "save it as UTF-8"
                ) from None
    try:
        # with or without a mark at the front, as spreadsheets on Windows write it
        return source.data.decode("utf-8-sig"), []
    except UnicodeDecodeError as error:
        first = error.start
    for name in tries:
        try:
            return source.data.decode(name), [f"the text is not UTF-8: read as {name}"]
        except UnicodeDecodeError:
            continue
    line = source.data.count(b"\n", 0, first) + 1
    raise source.fault(
        line,
        f"byte {source.data[first]} is no text in UTF-8, {', '.join(tries)}",
        "save the file as UTF-8",
    )


def number(cell: str, decimal: str = ".") -> float | None:
    """The number that a cell is, or None. Only plain digits count: no 1_000, no nan, no
    thousands."""
    plain = cell.strip().replace("\u2212", "-")
    if decimal == ",":
        if COMMA.fullmatch(plain):
            plain = plain.replace(",", ".")
        elif "." in plain:
            return None
    if not NUMBER.fullmatch(plain):
        return None
    # 1e999 is inf, and no reading
    value = float(plain)
    return value if math.isfinite(value) else None


def _sign_in(plain: str) -> str:
    """What stands in a number: comma, thousands (1,234: either) or point; "" none of them."""
    if COMMA.fullmatch(plain):
        return "thousands" if THOUSANDS.fullmatch(plain) else "comma"
    return "point" if "." in plain and NUMBER.fullmatch(plain) else ""


def decimal_of(
    source: Source,
    cells: Iterable[tuple[int, str]],
    stated: str,
    advice: str = "say --set decimal=. or --set decimal=,",
) -> tuple[str, list[str]]:
    """The decimal sign of a file's cells, "." or ",", and a notice where it had to be taken from
    little.

    cells: each with its line; told: what the user says. Raises RecordingError with both examples
    where a file has both.
    """
    if stated:
        return stated, []
    first: dict[str, tuple[int, str]] = {}
    for line, cell in cells:
        plain = cell.strip().replace("\u2212", "-")
        if kind := _sign_in(plain):
            first.setdefault(kind, (line, plain))
    line, comma = first.get("comma", first.get("thousands", (1, "")))
    if comma and "point" in first:
        both = f"{comma} has a decimal comma and {first['point'][1]} a decimal point"
        raise source.fault(line, f"decimal commas and points are mixed: {both}", advice)
    # every number with a comma could be one of thousands
    if comma and "comma" not in first:
        return ",", [f"{comma} is read as {comma.replace(',', '.')}, with a decimal comma"]
    return ("," if comma else "."), []


def direction(text: str) -> tuple[int, bool] | None:
    """The sign of a word of direction, and whether it is relative to the first run (forward,
    return); or None."""
    plain = text.strip().lower().replace("\u2212", "-").strip("()[].:")
    for words, sign, relative in (
        (UP, 1, False),
        (DOWN, -1, False),
        (THERE, 1, True),
        (BACK, -1, True),
    ):
        if plain in words:
            return sign, relative
    return None


def times(
    source: Source, cells: Sequence[tuple[int, str]], decimal: str = "."
) -> list[float] | None:
    """s, from (line, cell) of every row: seconds as they are, a date and time of ISO 8601 from the
    first on; None where no row has one. Raises RecordingError for a time that is none, and where
    both kinds stand in one file."""
    if not any(cell for _, cell in cells):
        return None
    result: list[float] = []
    start: datetime.datetime | None = None
    for line, cell in cells:
        place = Place(source.name, line)
        value = number(cell, decimal)
        if value is None:
            mixed = bool(result) and start is None
            start, value = _moment(cell, start, place)
        else:
            mixed = start is not None
        if mixed:
            raise RecordingError(
                "times are seconds in some rows and dates in others", "one kind for all", place
            )
        result.append(value)
    return result


def _moment(
    cell: str, start: datetime.datetime | None, place: Place
) -> tuple[datetime.datetime, float]:
    """A date and time: the first one, and s since then. Raises RecordingError."""
    try:
        moment = datetime.datetime.fromisoformat(cell)
        # s since the first row: which day it was says nothing of a machine
        start = start or moment
        return start, (moment - start).total_seconds()
    except (ValueError, TypeError):
        what = f"the time {cell!r} is neither seconds nor a date and time"
        raise RecordingError(
            what if cell else "the time is empty",
            "like 12.5, or 2024-05-17T10:31:00, in every row or in none",
            place,
        ) from None


def wrong_run(run: float | None) -> str:
    """What is wrong with the number of a run; "" where nothing is, and for None."""
    right = run is None or (run == int(run) and 1 <= run <= 1e6)
    return "" if right else f"run {run:g} is not a whole number from 1 on"


def stated_decimal(extra: Mapping[str, str]) -> str:
    """The decimal sign that --set decimal says; "" where it says none. Raises UsageError for
    another sign."""
    sign = extra.get("decimal", "")
    if sign not in ("", ".", ","):
        raise UsageError(
            f"--set decimal={sign} is no decimal sign", "--set decimal=. or --set decimal=,"
        )
    return sign


@dataclass(frozen=True)
class Table:
    """A table in a text: its lines as cells. rows: (line, cells), blank lines left out; delimiter;
    decimal sign."""

    rows: list[tuple[int, list[str]]]
    delimiter: str
    decimal: str
    notices: tuple[str, ...] = ()

    def numeric(self, cell: str) -> bool:
        return number(cell, self.decimal) is not None


def cells_of(line: str, delimiter: str, place: Place) -> list[str]:
    """The cells of one line, quotes taken off. Raises RecordingError for a line that is none of a
    table."""
    try:
        return [
            cell.strip().strip("\u00a0") for cell in next(csv.reader([line], delimiter=delimiter))
        ]
    except (csv.Error, StopIteration) as error:
        raise RecordingError(
            f"this line can not be split at its {DELIMITERS[delimiter]}s: {error}", "", place
        ) from None


def table(source: Source, text: str, decimal: str = "", delimiter: str = "") -> Table:
    """Split a text at the sign that splits most of its lines alike.

    Raises RecordingError where no sign does, or where decimal commas and points are mixed.
    """
    lines = _filled_lines(source, text)
    sign = delimiter or _delimiter(lines)
    if not sign:
        alike = "this is no table: no tab, semicolon, bar or comma splits its lines alike"
        raise source.fault(next((i for i, _ in lines), 1), alike, "save it as CSV")
    every = [(i, cells_of(line, sign, Place(source.name, i, line))) for i, line in lines]
    rows = [(i, cells) for i, cells in every if any(cells)]
    if not rows:
        raise source.fault(1, "the table has no filled cell")
    found, notices = decimal_of(
        source,
        ((i, cell) for i, cells in rows for cell in _numbers(cells)),
        decimal,
        "write all numbers alike; say --set decimal=. or --set decimal=,",
    )
    return Table(rows, sign, found, tuple(notices))


def _filled_lines(source: Source, text: str) -> list[tuple[int, str]]:
    """Numbers and texts of the lines that hold something. Raises RecordingError for one that is
    too long."""
    lines = [(i, line) for i, line in enumerate(lines_of(text), 1) if line.strip()]
    for i, line in lines:
        if len(line) > LONGEST_LINE:
            raise source.fault(i, f"a line of {len(line):,} characters is no row of a table")
    return lines


def _numbers(cells: list[str]) -> list[str]:
    """The cells that look like numbers, where they are two at least: one alone may be a version or
    a serial number."""
    # version 4.13 and serial 12,345 stand above many tables; they would decide for all of it
    alike = [
        c
        for c in cells
        if COMMA.fullmatch(c.replace("\u2212", "-")) or NUMBER.fullmatch(c.replace("\u2212", "-"))
    ]
    return alike if len(alike) > 1 else []


def _delimiter(lines: list[tuple[int, str]]) -> str:
    best, most = "", 0
    # The sign that gives most lines the same number of cells: a comma in two remarks loses against
    # a semicolon in every row.
    for sign in DELIMITERS:
        counts: Counter[int] = Counter()
        for _, line in lines:
            try:
                counts[len(next(csv.reader([line], delimiter=sign)))] += 1
            except (csv.Error, StopIteration):
                continue
        alike = max((n for cells, n in counts.items() if cells > 1), default=0)
        if alike > most:
            best, most = sign, alike
    return best
