"""Laser text with one table at tabs, as programs for Agilent, HP and Aerotech lasers write it.

Lines of key: value; a row that begins with `Target Position`, then `RUN 1` ... `RUN n` and
`Average`; one row a target; then `Environmental Data:` with lines of key: value. The unit is in a
heading: (arcsec), mrad or µm. The layout is known from one public reader of such files: unverified
against original files. That reader also meets records over time (`Time`, `Position`), which are not
targets and are refused here.
"""

from __future__ import annotations

import re

import numpy as np

from postproc import intake
from postproc.errors import Place
from postproc.recordings import ReadingOptions, Recording, RecordingError, Source, _sheet
from postproc.recordings import _components as components
from postproc.recordings import _environment as environment
from postproc.recordings import _targets as targets
from postproc.recordings import _text as text
from postproc.recordings import _units as units

TITLE = "laser text with a tab table (Target Position, RUN 1 ... n, Average)"
TAKES = ("axis", "component", "unit", "bidirectional", "first", "others", "machine", "head")
EXTRA = {
    "decimal": ". or ,: the decimal sign, where it is not clear",
    "position_unit": "mm, inch or deg: of the targets",
}
TOP = re.compile(r"^\s*\"?Target Position", re.I)
TIME = re.compile(r"^\s*Time\s*(\([^)]*\))?\tPosition", re.I)
RUN = re.compile(r"^RUN\s*#?\s*([0-9]{1,4})\b", re.I)
AVERAGE = re.compile(r"^(average|mean|avg)\b", re.I)
ENVIRONMENT = re.compile(r"^\s*Environmental Data", re.I)
SLIP = 0.02  # an average that is off by more than this part of the range of the readings is a slip


def recognises(source: Source) -> bool:
    head = source.data[:200_000]
    return bool(re.search(rb"(?im)^\s*\"?Target Position[^\r\n]*\tRUN", head)) or bool(
        re.search(rb"(?im)^\s*Time[^\t\r\n]*\tPosition", head) and b"Environmental Data" in head
    )


def _top(source: Source, lines: list[str]) -> int:
    """Index of the row above the targets. Raises RecordingError where there is none."""
    for i, line in enumerate(lines):
        if TOP.match(line):
            return i
    for i, line in enumerate(lines):
        if TIME.match(line):
            raise source.fault(
                i + 1,
                "this is a record over time, not of targets",
                "make a CSV of it and name its columns: --format mapped-csv",
            )
    raise source.fault(1, "there is no row that begins with Target Position")


def _readings(found, scale: float, columns: dict[str, float]) -> targets.Readings:
    """scale: mm of a target's unit; columns: temperatures, the same for all."""
    return targets.Readings(
        [_run(c.title) for c, *_ in found],
        [t * scale for _, _, t, _ in found],
        [v for *_, v in found],
        [line for _, line, *_ in found],
        columns={n: [v] * len(found) for n, v in columns.items()},
    )


def read(source: Source, options: ReadingOptions) -> Recording:
    """Raises RecordingError with the line for what is not a number, and where axis or unit are
    open."""
    content, notices = text.decoded(source)
    lines = intake.lines_of(content)
    top = _top(source, lines)
    weather = next(
        (i for i in range(top + 1, len(lines)) if ENVIRONMENT.match(lines[i])), len(lines)
    )
    sheet, table = _table(source, lines, top, weather, options, notices)
    before = _keys(lines[:top])
    said = _unit(source, sheet, lines, top)
    axis = components.axis_in(before.get("axis", "")) or components.axis_in(
        next(iter(re.findall(r"\b([XYZABC])[ -]axis", before.get("comments", ""), re.I)), "")
    )
    component = components.positioning(options, source, axis, said, sheet.line, notices)
    unit = components.unit_for(options, source, component, said, sheet.line)
    scale = _sheet.position_factor(
        source, sheet.headings[0], sheet.line, options, component.axis in "ABC", notices
    )
    found, faults = _sheet.cells(source, table, sheet, options)
    notices += _sheet.missing(faults)
    _averages(sheet, table, found, notices)
    # one value each for the whole recording: a column of the same number in every row
    columns, noted, more = environment.taken(_keys(lines[weather + 1 :], lower=False).items())
    readings = _readings(found, scale, columns)
    head = {
        "machine": before.get("machine", ""),
        "instrument": "laser interferometer",
        "comments": before.get("comments", ""),
        "serial_number": before.get("serial number", ""),
        "date": before.get("date", ""),
        "environment": noted or None,
    }
    # no direction is written; runs go as the list of targets goes, so it is the one of the first
    first = 1 if not found or found[-1][2] >= found[0][2] else -1
    return targets.recording(
        source, options, component, unit, readings, head, [*notices, *more], faults, first
    )


def _run(title: str) -> int:
    """The number of a run, from its heading."""
    found = RUN.match(title)
    return int(found[1]) if found else 0


def _keys(lines: list[str], lower: bool = True) -> dict[str, str]:
    pairs = [line.partition(":") for line in lines if ":" in line]
    # reversed, so that of a key that stands twice the first one is kept
    return {(k.strip().lower() if lower else k.strip()): v.strip() for k, _, v in reversed(pairs)}


def _rows(source: Source, lines: list[str], top: int, end: int) -> list[tuple[int, list[str]]]:
    """Headings and targets; what follows them begins with no number."""
    rows = []
    for i in range(top, end):
        if i > top and not re.match(r"\s*[-+\u2212]?[.,]?[0-9]", lines[i]):
            # A row of targets that begins with no number, and numbers below it: a slip, not the
            # end.
            goes_on = any(re.match(r"\s*[-+]?[0-9]", x) for x in lines[i + 1 : end])
            if lines[i].strip() and goes_on and "\t" in lines[i]:
                raise source.fault(
                    i + 1, f"the target {lines[i].split(chr(9))[0]!r} is not a number", "", lines[i]
                )
            if i > top + 1:
                break
            continue
        place = Place(source.name, i + 1, lines[i])
        rows.append((i + 1, text.cells_of(lines[i], "\t", place)))
    return rows


def _columns(headings: list[str], at: Place, notices: list[str]) -> list[_sheet.Column]:
    """The columns of the runs. Raises RecordingError where there are none, or one twice."""
    columns: dict[int, _sheet.Column] = {}
    for j, title in enumerate(headings[1:], 1):
        if RUN.match(title):
            if _run(title) in columns:
                raise RecordingError(f"RUN {_run(title)} heads two columns", "", at)
            columns[_run(title)] = _sheet.Column(j, title, 0, False)
        elif title and not AVERAGE.match(title):
            notices.append(f"the column {title!r} is neither a run nor the average: left out")
    if not columns:
        raise RecordingError(
            "there is no column RUN 1", "the readings stand in columns RUN 1, RUN 2, ...", at
        )
    return list(columns.values())


def _table(source, lines, top, end, options, notices) -> tuple[_sheet.Sheet, text.Table]:
    """The rows of targets, and the columns of the runs."""
    rows = _rows(source, lines, top, end)
    headings, body = rows[0][1], rows[1:]
    at = Place(source.name, top + 1, lines[top])
    if not body:
        raise RecordingError("there are no rows below Target Position", "", at)
    cells = ((line, cell) for line, row in body for cell in row)
    decimal, more = text.decimal_of(source, cells, text.stated_decimal(options.extra))
    notices += more
    columns = _columns(headings, at, notices)
    sheet = _sheet.Sheet(body, headings, 0, columns, [], [], top + 1)
    return sheet, text.Table(body, "\t", decimal)


def _unit(source: Source, sheet: _sheet.Sheet, lines: list[str], top: int) -> units.Unit | None:
    """The unit that the headings of runs have, or a line above the table has in brackets."""
    said = {u.name: u for h in sheet.headings[1:] for u in (units.in_heading(h),) if u}
    if not said:
        said = {
            u.name: u
            for line in lines[:top]
            if re.search(r"error|deviation|accuracy|unit", line, re.I)
            for u in (units.in_heading(line), units.unit_of(line.partition(":")[2])) if u
        }  # fmt: skip
    if len(said) > 1:
        raise source.fault(top + 1, f"the headings name {' and '.join(said)}", "one unit for all")
    return next(iter(said.values()), None)


def _means(found, runs: int) -> tuple[dict[int, float], float]:
    """Line to the mean of its readings, of the rows that have one of each run; and the range of all
    readings."""
    own: dict[int, list[float]] = {}
    for _, line, _, value in found:
        own.setdefault(line, []).append(value)
    spread = float(np.ptp([v for *_, v in found])) or 1.0
    return {line: float(np.mean(v)) for line, v in own.items() if len(v) >= runs}, spread


def _averages(sheet, table, found, notices) -> None:
    """The file's averages against its runs: where they differ, one of them is a slip."""
    at = next((j for j, h in enumerate(sheet.headings) if AVERAGE.match(h)), None)
    if at is None or not found:
        return
    whole, spread = _means(found, len(sheet.columns))
    for line, row in sheet.rows:
        stated, mean = text.number("".join(row[at : at + 1]), table.decimal), whole.get(line)
        if stated is not None and mean is not None and abs(stated - mean) > SLIP * spread:
            notices.append(
                f"line {line}: the average stands as {stated:g}, and the mean of its runs is"
                f" {mean:g}: is a number mistyped?"
            )
