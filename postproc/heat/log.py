"""A log of temperatures: a table with a time and a column for each thermometer, as data loggers and
controllers write it.

The first row is the head, with the names of the columns; empty lines and lines that begin with #
are skipped. The time is `t_s`, or the first column: seconds, or a date and time (ISO 8601). A cell
without a number is a gap, which is bridged from its neighbours.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime

import numpy as np

from postproc import intake
from postproc.diagnose.thermometers import JUMP_K, SPEED
from postproc.errors import GcompError, Place
from postproc.units import OTHER_TIME

# degrees Celsius of a machine; beyond, a column is no temperature in Celsius
PLAUSIBLE = (-40.0, 150.0)
# What a heading says of other degrees: "T1 (°F)", T_degF.
OTHER_DEGREES = re.compile(
    r"°\s*[FK]\b|deg_?F|fahrenheit|kelvin|[(\[]\s*[FK]\s*[)\]]", re.IGNORECASE
)
TIMES = ("t_s", "time_s", "time", "timestamp", "date", "datetime")
# The DS18B20 reads 85 C after its power was lost (its data sheet: power-on value), and the library
# that most loggers read it with gives -127 C where it does not answer (DallasTemperature.h,
# DEVICE_DISCONNECTED_C).
FAULTY = (
    "it lies on metal, which is slower: a thermometer's fault (85 and -127 are what a DS18B20 that"
    " failed reads)? Mend it, and empty such cells: a gap is bridged"
)


class LogError(GcompError):
    """A log of temperatures can not be read, or says what can not be."""


@dataclass(frozen=True)
class Log:
    """name: of the file; time (R,) s, ascending; columns: name to (R,) degrees Celsius; dated: s of
    the first row since 1970 in UTC where times are dates, None where they are seconds; known:
    name to (K,) rows whose cell holds a number (none: all of them); lines (R,): of the file, from
    1."""

    name: str
    time: np.ndarray
    columns: dict[str, np.ndarray]
    dated: float | None = None
    known: dict[str, np.ndarray] = field(default_factory=dict)
    lines: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))

    def recorded(self, column: str) -> np.ndarray:
        """(K,) s at which a column holds a number."""
        rows = self.known.get(column)
        return self.time if rows is None else self.time[rows]

    def widest(self, column: str) -> float:
        """s, the longest time between two numbers of a column."""
        return float(np.diff(self.recorded(column)).max(initial=0.0))

    def place(self, row: int) -> Place:
        """Where a row stands."""
        return Place(self.name, int(self.lines[row]) if len(self.lines) else 1)

    def at(self, column: str, time: np.ndarray) -> np.ndarray:
        """(N,) degrees Celsius, on straight lines between the rows; beyond the ends what they are
        there."""
        return np.interp(time, self.time, self.columns[column])

    def varied(self, column: str, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        """(N,) K by which it changes from first to last (N,) s, to and fro added up."""
        # To and fro added up: a temperature that came back meanwhile has moved the machine all the
        # same, and the middle of the block would not know.
        change = np.abs(np.diff(self.columns[column], prepend=self.columns[column][0]))
        total = np.cumsum(change)
        return np.interp(last, self.time, total) - np.interp(first, self.time, total)

    def moment(self, text: str) -> float:
        """s of the log: of seconds, or of a date and time. Raises GcompError."""
        if (seconds := _number(text)) is not None:
            return seconds
        moment = _date(text)
        if moment is None or self.dated is None:
            kind = "dates, like 2026-11-23T08:15:00" if self.dated is not None else "seconds"
            raise GcompError(f"{text!r} is no time of {self.name}", f"its times are {kind}")
        return moment - self.dated


class Newest(Log):
    """A log that goes on while the program runs: its newest row counts, whatever the clock says.
    fresh() reads it anew, and raises LogError."""

    def __init__(self, first: Log, fresh: Callable[[], Log]):
        super().__init__(
            first.name, first.time, first.columns, first.dated, first.known, first.lines
        )
        object.__setattr__(self, "fresh", fresh)

    def at(self, column: str, time: np.ndarray) -> np.ndarray:
        """(N,) degrees Celsius of the newest row."""
        values: np.ndarray = np.full(np.shape(time), self.fresh().columns[column][-1])  # type: ignore[attr-defined]
        return values

    def varied(self, column: str, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        """None: what will be read later is not known."""
        return np.zeros(np.shape(first))


def read(name: str, data: bytes) -> Log:
    """Raises LogError with file and line."""
    numbers, head, cells = _cells(name, data)
    at = next((head.index(c) for c in head if c.lower() in TIMES), 0)
    moments = (row[at] if at < len(row) else "" for row in cells)
    time, dated = _times(name, list(zip(numbers[1:], moments, strict=True)))
    if dated is None and (unit := OTHER_TIME.search(head[at])):
        raise LogError(
            f"the times are {unit[1]} by their heading {head[at]!r}, and seconds are read",
            "a column t_s in seconds, or dates like 2026-11-23T08:15:00",
            Place(name, numbers[0]),
        )
    columns, known = _columns([c if i != at else "" for i, c in enumerate(head)], cells, time)
    if not columns:
        raise LogError(
            "no column holds numbers",
            "a column a thermometer, degrees Celsius",
            Place(name, numbers[0]),
        )
    return Log(name, time, columns, dated, known, np.array(numbers[1:]))


def _cells(name: str, data: bytes) -> tuple[list[int], list[str], list[list[str]]]:
    """The numbers of the file's lines that count, the names in the first of them, and the cells of
    the others."""
    lines = [
        (k, line)
        for k, line in enumerate(intake.lines_of(intake.decoded(data, name, LogError)), 1)
        if line.strip() and not line.startswith("#")
    ]
    if len(lines) < 3:
        raise LogError(
            "a log needs a row of names and two rows of numbers",
            "t_s,T_screw_Z_C, then a row a moment",
            Place(name, 1),
        )
    # a comma may be the decimal point where cells are parted by tabs or semicolons (_number takes
    # it)
    mark = next((c for c in ("\t", ";") if c in lines[0][1]), ",")
    head, *cells = (_row(name, line, text, mark) for line, text in lines)
    head = [cell.strip() for cell in head]
    _check_names(head, Place(name, lines[0][0]))
    return [k for k, _ in lines], head, cells


def _check_names(head: list[str], at: Place) -> None:
    """Raises LogError for two columns of one name."""
    for column in filter(None, head):
        if head.count(column) > 1:
            raise LogError(
                f"{head.count(column)} columns are called {column}",
                "a name of its own for each thermometer",
                at,
            )


def _columns(
    head: list[str], cells: list[list[str]], time: np.ndarray
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """(R,) degrees Celsius of each column that has a name and a number, gaps bridged; and its (K,)
    rows that hold one."""
    columns, known = {}, {}
    for i, column in enumerate(head):
        values = np.array([_cell(row, i) for row in cells])
        rows = np.flatnonzero(np.isfinite(values))
        if column and len(rows):
            # held before the first number and behind the last; `known` says how far it was really
            # read
            columns[column] = np.interp(time, time[rows], values[rows])
            known[column] = rows
    return columns, known


def _row(name: str, line: int, text: str, mark: str) -> list[str]:
    """The cells of a line."""
    try:
        return next(csv.reader([text], delimiter=mark, strict=True))
    except csv.Error as error:
        raise LogError(
            f"this line is no row of a table: {error}",
            "a log of temperatures is a table: t_s,T_screw_Z_C, then a row a moment",
            Place(name, line),
        ) from None


def check(log: Log, used: list[str]) -> None:
    """Raises LogError where a column that is used can be no temperature of a machine in degrees
    Celsius: by what it reads, or by how fast it changes."""
    for column in used:
        low, high = float(log.columns[column].min()), float(log.columns[column].max())
        if low < PLAUSIBLE[0] or high > PLAUSIBLE[1] or OTHER_DEGREES.search(column):
            raise LogError(
                f"{column} goes from {low:g} to {high:g}",
                "temperatures are degrees Celsius: is it Fahrenheit, or no temperature?",
                Place(log.name, 1),
            )
        rows = log.known.get(column, np.arange(len(log.time)))
        value, time = log.columns[column][rows], log.time[rows]
        step, gap = np.abs(np.diff(value)), np.diff(time)
        # what metal can not do in the time between two readings is the thermometer's
        for k in np.flatnonzero(step > JUMP_K + SPEED * gap)[:1]:
            raise jumped(log, column, float(value[k]), float(gap[k]), int(rows[k + 1]))


def jumped(log: Log, column: str, before: float, seconds: float, row: int) -> LogError:
    """What is said of a reading that lies farther from the one before than metal can warm."""
    return LogError(
        f"{column} goes from {before:g} to {log.columns[column][row]:g} C in {seconds:.3g} s",
        FAULTY,
        log.place(row),
    )


def follow(log: Log, before: Log, seconds: float, used: list[str]) -> None:
    """Whether a log that goes on may stand for what it was `seconds` ago. Raises LogError."""
    for column in used:
        if column not in log.columns:
            raise LogError(
                f"{column} is no column of it any more: {', '.join(log.columns)}",
                "leave the log's columns as they are while the job runs",
                Place(log.name, 1),
            )
    check(log, used)
    for column in used:
        now, was = float(log.columns[column][-1]), float(before.columns[column][-1])
        # rows of one log were looked at above; another one may have been begun
        apart = max(seconds, float(log.time[-1] - before.time[-1]))
        if abs(now - was) > JUMP_K + SPEED * apart:
            raise jumped(log, column, was, apart, len(log.time) - 1)


def _times(name: str, cells: list[tuple[int, str]]) -> tuple[np.ndarray, float | None]:
    """(R,) s, and the moment, s, of the first row where they are dates. Raises LogError."""
    numbers = [_number(text) for _, text in cells]
    dated = None
    if numbers[0] is None:
        numbers = [_date(text) for _, text in cells]
        dated = numbers[0]
    for (line, text), value in zip(cells, numbers, strict=True):
        if value is None:
            raise LogError(
                f"{text!r} is no time",
                "seconds (t_s), or dates like 2026-11-23T08:15:00",
                Place(name, line),
            )
    time = np.array([v for v in numbers if v is not None])
    back = np.flatnonzero(np.diff(time) <= 0)
    if len(back):
        line = cells[int(back[0]) + 1][0]
        raise LogError(
            "this row is not later than the one before",
            "rows in the order of time, each moment once",
            Place(name, line),
        )
    return time - (dated or 0.0), dated


def _number(text: str) -> float | None:
    try:
        value = float(text.strip().replace(",", "."))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _cell(row: list[str], i: int) -> float:
    value = _number(row[i]) if i < len(row) else None
    return math.nan if value is None else value


def _date(text: str) -> float | None:
    try:
        found = datetime.fromisoformat(text.strip())
    except ValueError:
        return None
    # A time without a zone counts as UTC: only differences are used, and a local time would jump
    # where summer time begins.
    return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp()
