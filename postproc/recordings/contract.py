"""gcomp's own recordings (format gcomp-recording/1): a TOML head behind `# `, a header row, rows. Read and written.

Rows that can not be used (a blank or a NaN in a needed column) are an error with their line, or, where strict is off,
are left out and listed.
"""

from __future__ import annotations

import csv
import io
import math
import re
import tomllib
from typing import Any

import numpy as np

from postproc.errors import Place
from postproc.recordings import AXES, KINDS, QUANTITIES, Fault, ReadingOptions, Recording, RecordingError, Source

TITLE = "gcomp recording (gcomp-recording/1)"
FORMAT = "gcomp-recording/1"
TEXTS = {"feature", "kind", "axis", "part"}  # columns of features that are words
OPTIONAL = re.compile(r"(T_\w+_C|load_\w+_N|force_\w+_N|spindle_rpm|feed_mm_min|\w+_current_A|line|\w+_act_(mm|deg))")


def recognises(source: Source) -> bool:
    return bool(re.match(rb"(\xef\xbb\xbf)?#[^\n]*gcomp-recording", source.data)) or (
        source.data.lstrip(b"\xef\xbb\xbf").startswith(b"#") and b"gcomp-recording/" in source.data[:4000]
    )


def read(source: Source, options: ReadingOptions) -> Recording:
    """Raises RecordingError with file and line for anything that is not as the contract says."""
    lines = source.text.splitlines()
    top = next((i for i, line in enumerate(lines) if not line.startswith("#")), len(lines))
    head = _head(source, lines[:top])
    kind = head["kind"]
    while top < len(lines) and not lines[top].strip():
        top += 1
    if top >= len(lines):
        raise RecordingError("there is no header row", "", Place(source.name, max(len(lines), 1)))
    place = Place(source.name, top + 1, lines[top])
    names = [cell.strip() for cell in _cells(lines[top], place)]
    _check_names(names, place)
    needed = _needed(head, names, place)
    columns, at, faults = _rows(source, lines, top, names, needed, kind, options.strict)
    recording = Recording(kind, head, columns, source.name, at, tuple(faults))
    _check(recording, place)
    return recording


def write(recording: Recording) -> str:
    """The text of a recording. Heads are written as one line a key."""
    out = io.StringIO()
    head = {"format": FORMAT, "kind": recording.kind} | recording.head
    for key, value in head.items():
        out.write(f"# {key} = {_toml(value)}\n")
    out.write(",".join(recording.columns) + "\n")
    formats = [_format(name) for name in recording.columns]
    for row in zip(*recording.columns.values(), strict=True):
        out.write(",".join(f(v) for f, v in zip(formats, row, strict=True)) + "\n")
    return out.getvalue()


def _format(name: str):
    if name in TEXTS:
        return str
    if name in ("run", "sense", "line", "part", "reading") or name.startswith("approach_"):
        return lambda v: f"{int(v)}" if float(v).is_integer() else f"{v:g}"
    digits = 6 if name.endswith(("_mm", "_deg")) else 4
    return lambda v: f"{v:.{digits}f}".rstrip("0").rstrip(".")


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    text = str(value).replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{text}"'


def _head(source: Source, lines: list[str]) -> dict[str, Any]:
    text = "\n".join(line[2:] if line.startswith("# ") else line[1:] for line in lines)
    try:
        head = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.search(r"line (\d+)", str(error))
        raise RecordingError(
            f"the head is not valid TOML: {error}", "", Place(source.name, int(found[1]) if found else 1)
        ) from None

    def fault(key: str, message: str, advice: str = "") -> RecordingError:
        line = next((i for i, x in enumerate(lines, 1) if re.match(rf"#\s*{key}\s*=", x)), 1)
        return RecordingError(message, advice, Place(source.name, line))

    if head.get("format") != FORMAT:
        raise fault("format", f"format is {head.get('format')!r}, not {FORMAT!r}")
    if head.get("kind") not in KINDS:
        raise fault("kind", f"kind is {head.get('kind')!r}", f"kinds: {', '.join(KINDS)}")
    if head["kind"] == "targets":
        head.setdefault("quantity", "displacement")
        if head["quantity"] not in QUANTITIES:
            raise fault("quantity", f"quantity is {head['quantity']!r}", f"quantities: {', '.join(QUANTITIES)}")
        vector = head.get("sensitive")
        if not isinstance(vector, dict) or not vector or not all(k in AXES and _finite(v) for k, v in vector.items()):
            raise fault("sensitive", f"sensitive = {vector!r} is no vector", "like sensitive = { X = 0.0, Z = 1.0 }")
        length = math.sqrt(sum(v * v for v in vector.values()))
        if abs(length - 1) > 1e-3:
            raise fault("sensitive", f"sensitive has the length {length:.4f}", "a unit vector is wanted")
    if "u_um" in head and not (_finite(head["u_um"]) and head["u_um"] > 0):
        raise fault("u_um", f"u_um = {head['u_um']!r} is not above zero")
    if head["kind"] == "trace" and head.get("sees", "scale") not in ("scale", "tool"):
        raise fault("sees", f"sees = {head['sees']!r}", "scale or tool")
    if head["kind"] == "ballbar":
        if not _finite(head.get("radius_mm")) or head["radius_mm"] <= 0:
            raise fault("radius_mm", f"radius_mm = {head.get('radius_mm')!r} is not above zero")
        centre = head.get("centre")
        if not isinstance(centre, dict) or not all(k in AXES and _finite(v) for k, v in centre.items()):
            raise fault("centre", f"centre = {centre!r}", "like centre = { X = 400.0, Y = 300.0 }")
    return head


def _check_names(names: list[str], place: Place) -> None:
    for name in names:
        if not name:
            raise RecordingError("a column has no name", "", place)
        if names.count(name) > 1:
            raise RecordingError(f"the column {name!r} stands twice", "", place)


def _needed(head: dict[str, Any], names: list[str], place: Place) -> set[str]:
    """The columns without which a row says nothing. Raises RecordingError for one that is missing."""
    kind = head["kind"]
    if kind == "features":
        needed = {"feature", "kind", "axis", "nominal_mm", "measured_mm"}
    else:
        suffix = "" if kind == "targets" else "_cmd"
        axes = [x for x in AXES if f"{x}{suffix}_{'mm' if x in 'XYZ' else 'deg'}" in names]
        if not axes:
            raise RecordingError(
                f"no column X{suffix}_mm, Y{suffix}_mm or Z{suffix}_mm", "the position is missing", place
            )
        needed = {f"{x}{suffix}_{'mm' if x in 'XYZ' else 'deg'}" for x in axes}
        if kind == "targets":
            needed |= {"reading_urad" if head["quantity"] == "angle" else "reading_um"}
            for x in axes:
                if f"approach_{x}" in names:
                    needed.add(f"approach_{x}")
        if kind == "ballbar":
            needed |= {"radial_um", "sense", "t_s"}
            wrong = [x for x in head["centre"] if x not in axes]
            if wrong:
                raise RecordingError(f"centre names {wrong[0]}, which is not recorded", "", place)
        if kind == "trace":
            needed |= {"t_s"} | {f"{x}_act_mm" for x in axes if x in "XYZ"}
    for name in sorted(needed):
        if name not in names:
            raise RecordingError(f"the column {name} is missing", f"columns here: {', '.join(names)}", place)
    return needed


def _rows(source, lines, top, names, needed, kind, strict):
    """Columns (N,), the lines they stand in, and the rows left out."""
    texts = TEXTS if kind == "features" else set()
    rows: list[list[Any]] = []
    at: list[int] = []
    faults: list[Fault] = []
    for number, line in enumerate(lines[top + 1 :], top + 2):
        if not line.strip() or line.startswith("#"):
            continue
        place = Place(source.name, number, line)
        cells = _cells(line, place)
        wrong: Fault | None = None
        if len(cells) != len(names):
            wrong = Fault(number, "", f"{len(cells)} values under {len(names)} columns")
            cells = (cells + [""] * len(names))[: len(names)]
        row: list[Any] = []
        for name, cell in zip(names, cells, strict=True):
            cell = cell.strip()
            if name in texts:
                row.append(cell)
                continue
            value = math.nan
            try:
                value = float(cell) if cell else math.nan
                told = f"{name} is {cell or 'empty'}"
            except ValueError:
                told = f"{name} = {cell!r} is not a number"
                wrong = wrong or (Fault(number, name, told) if name not in needed else None)
            if name in needed and not math.isfinite(value):
                wrong = wrong or Fault(number, name, told)
            row.append(value)
        if wrong is not None:
            if strict:
                raise RecordingError(wrong.message, "every row needs a number in every needed column", place)
            faults.append(wrong)
            continue
        rows.append(row)
        at.append(number)
    if not rows:
        raise RecordingError("there are no rows", "", Place(source.name, len(lines)))
    columns = {
        name: np.array([row[i] for row in rows], dtype=object if name in texts else np.float64)
        for i, name in enumerate(names)
    }
    return columns, np.array(at, np.int64), faults


def _check(recording: Recording, place: Place) -> None:
    """Signs are signs."""
    for name, column in recording.columns.items():
        if name.startswith("approach_") or name == "sense":
            wrong = np.flatnonzero(~np.isin(column, (-1, 0, 1)) if name != "sense" else ~np.isin(column, (-1, 1)))
            if len(wrong):
                raise RecordingError(
                    f"{name} = {column[wrong[0]]:g}", "+1 or -1", Place(recording.file, int(recording.lines[wrong[0]]))
                )


def _cells(line: str, place: Place) -> list[str]:
    try:
        return next(csv.reader([line]))
    except (csv.Error, StopIteration) as error:
        raise RecordingError(f"not a line of a CSV table: {error}", "", place) from None


def _finite(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
