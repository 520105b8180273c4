"""A log of temperatures: a table with a time and a column for each thermometer, as data loggers and controllers write it.

The first row that holds names is the head; lines before it that begin with # are skipped. The time is `t_s`, or the first column:
seconds, or a date and time (ISO 8601). A cell without a number is a gap, which is bridged from its neighbours.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from postproc.errors import GcompError, Place

PLAUSIBLE = (
    -40.0,
    150.0,
)  # degrees Celsius of a machine; beyond, a column is no temperature in Celsius
TIMES = ("t_s", "time_s", "time", "timestamp", "date", "datetime")


class LogError(GcompError):
    """A log of temperatures can not be read."""


@dataclass(frozen=True)
class Log:
    """name: of the file; time (R,) s, ascending; columns: name to (R,) degrees Celsius; dated: s of the first row since 1970 in UTC
    where times are dates, None where they are seconds."""

    name: str
    time: np.ndarray
    columns: dict[str, np.ndarray]
    dated: float | None = None

    @property
    def widest(self) -> float:
        """s, the longest time between two rows."""
        return float(np.diff(self.time).max(initial=0.0))

    def at(self, column: str, time: np.ndarray) -> np.ndarray:
        """(N,) degrees Celsius, on straight lines between the rows; beyond the ends what they are there."""
        values: np.ndarray = np.interp(time, self.time, self.columns[column])
        return values

    def moment(self, text: str) -> float:
        """s of the log: of seconds, or of a date and time. Raises GcompError."""
        seconds = _number(text)
        if seconds is not None:
            return seconds
        moment = _date(text)
        if moment is None or self.dated is None:
            kind = "dates, like 2026-11-23T08:15:00" if self.dated is not None else "seconds"
            raise GcompError(f"{text!r} is no time of {self.name}", f"its times are {kind}")
        return moment - self.dated


class Newest(Log):
    """A log that goes on while the program runs: its newest row counts, whatever the clock says. fresh() reads it anew."""

    def __init__(self, first: Log, fresh: Callable[[], Log]):
        super().__init__(first.name, first.time, first.columns, first.dated)
        object.__setattr__(self, "fresh", fresh)

    def at(self, column: str, time: np.ndarray) -> np.ndarray:
        """(N,) degrees Celsius of the newest row."""
        values: np.ndarray = np.full(np.shape(time), self.fresh().columns[column][-1])  # type: ignore[attr-defined]
        return values


def read(name: str, data: bytes) -> Log:
    """Raises LogError with file and line."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise LogError(
            f"byte {data[error.start]} is not UTF-8 text",
            "save the file as UTF-8",
            Place(name, line),
        ) from None
    lines = [
        (k, line)
        for k, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.startswith("#")
    ]
    if len(lines) < 3:
        raise LogError(
            "a log needs a row of names and two rows of numbers",
            "t_s,T_screw_Z_C, then a row a moment",
            Place(name, 1),
        )
    mark = next((c for c in ("\t", ";") if c in lines[0][1]), ",")
    head = [cell.strip() for cell in next(csv.reader([lines[0][1]], delimiter=mark))]
    cells = [next(csv.reader([line], delimiter=mark)) for _, line in lines[1:]]
    at = next((head.index(c) for c in head if c.lower() in TIMES), 0)
    time, dated = _times(
        name,
        [
            (k, row[at] if at < len(row) else "")
            for (k, _), row in zip(lines[1:], cells, strict=True)
        ],
    )
    columns = {}
    for i, column in enumerate(head):
        if i != at:
            values = np.array([_cell(row, i) for row in cells])
            known = np.isfinite(values)
            if known.any() and column:
                columns[column] = np.interp(time, time[known], values[known])
    if not columns:
        raise LogError(
            "no column holds numbers",
            "a column a thermometer, degrees Celsius",
            Place(name, lines[0][0]),
        )
    return Log(name, time, columns, dated)


def check(log: Log, used: list[str]) -> None:
    """Raises LogError where a column that is used can be no temperature in degrees Celsius."""
    for column in used:
        low, high = float(log.columns[column].min()), float(log.columns[column].max())
        if low < PLAUSIBLE[0] or high > PLAUSIBLE[1]:
            raise LogError(
                f"{column} goes from {low:g} to {high:g}", "temperatures are degrees Celsius: is it Fahrenheit, or no temperature?",
                Place(log.name, 1),
            )  # fmt: skip


def _times(name: str, cells: list[tuple[int, str]]) -> tuple[np.ndarray, float | None]:
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
    return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp()
