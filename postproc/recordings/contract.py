"""gcomp's own recordings (format gcomp-recording/1): a TOML head behind `# `, a header row, rows.
Read and written."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from postproc import intake
from postproc import toml_text as toml
from postproc.errors import GcompError, Place
from postproc.recordings import (
    AXES,
    KINDS,
    QUANTITIES,
    RESTING,
    ReadingOptions,
    Recording,
    RecordingError,
    Source,
)
from postproc.recordings._columns import cells_of, read_columns

TITLE = "gcomp recording (gcomp-recording/1)"
TAKES = ("head",)
FORMAT = "gcomp-recording/1"
# Columns that say which rows belong together: one that is there has a number in every row.
PARTED = {"run", "setup", "station", "sphere"}


def recognises(source: Source) -> bool:
    return bool(re.match(rb"(\xef\xbb\xbf)?#[^\n]*gcomp-recording", source.data)) or (
        source.data.lstrip(b"\xef\xbb\xbf").startswith(b"#")
        and b"gcomp-recording/" in source.data[:4000]
    )


def read(source: Source, options: ReadingOptions) -> Recording:
    """Raises RecordingError with file and line for anything that is not as the contract says."""
    lines = intake.lines_of(source.text)
    while lines and not lines[-1].strip():
        lines.pop()
    top = next((i for i, line in enumerate(lines) if not line.startswith("#")), len(lines))
    head, notices = _head(source, lines[:top], options.head)
    kind = head["kind"]
    while top < len(lines) and not lines[top].strip():
        top += 1
    if top >= len(lines):
        raise source.fault(max(len(lines), 1), "there is no header row")
    place = Place(source.name, top + 1, lines[top])
    names = [cell.strip() for cell in cells_of(lines[top], place)]
    _check_names(names, place)
    wanted = needed(head, names, place)
    columns, at, faults = read_columns(source, lines, top, names, wanted, kind, options.strict)
    recording = Recording(kind, head, columns, source.name, at, tuple(faults), notices)
    check(recording)
    return recording


def write(recording: Recording) -> str:
    """The text of a recording. Heads are written as one line a key."""
    out = io.StringIO()
    head = {"format": FORMAT, "kind": recording.kind} | recording.head
    for key, value in head.items():
        out.write(f"# {toml.key(key)} = {toml.text(value)}\n")
    table = csv.writer(out, lineterminator="\n")
    table.writerow(recording.columns)
    formats = [
        str if column.dtype == object else _format(name)
        for name, column in recording.columns.items()
    ]
    for row in zip(*recording.columns.values(), strict=True):
        table.writerow([f(v) for f, v in zip(formats, row, strict=True)])
    return out.getvalue()


def _format(name: str):
    if name in ("run", "sense", "line", "part", "reading") or name.startswith("approach_"):
        # Counts and signs as whole numbers, lengths to a nanometre, readings to 0.1 nm. NaN is an
        # empty cell, as it was read.
        return lambda v: "" if math.isnan(v) else f"{int(v)}" if float(v).is_integer() else f"{v:g}"
    digits = 6 if name.endswith(("_mm", "_deg", "_s")) else 4
    return lambda v: "" if math.isnan(v) else f"{v:.{digits}f}".rstrip("0").rstrip(".")


def _head(
    source: Source, lines: list[str], more: dict[str, Any]
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The head, with those keys of `more` that it does not say itself; a notice for each of the
    others whose value is another."""
    # Line n of the document is line n of the file, so that TOML's own messages name the right one.
    document = "\n".join(line[2:] if line.startswith("# ") else line[1:] for line in lines)
    try:
        head = intake.toml(document)
    except ValueError as error:
        found = re.search(r"line (\d+)", str(error))
        raise source.fault(
            min(int(found[1]), len(lines)) if found else max(len(lines), 1),
            f"the head is not valid TOML: {error}",
            'each line is # key = value, and words stand in quotes: # machine = "mill-7"',
        ) from None

    def fault(key: str, message: str, advice: str = "") -> RecordingError:
        line = next((i for i, x in enumerate(lines, 1) if re.match(rf"#\s*{key}\s*=", x)), 1)
        return RecordingError(message, advice, Place(source.name, line))

    if head.get("format") != FORMAT:
        raise fault("format", f"{_said(head, 'format')}, and not {FORMAT!r}")
    notices = tuple(
        f"--head {key}={value} was not used: the file's own head says {_said(head, key)}"
        for key, value in more.items()
        if head.setdefault(key, value) != value
    )
    check_head(head, fault)
    return head, notices


def _is_place(value: Any) -> bool:
    """Whether it is a table of axis letters and numbers, like { X = 0.0 }."""
    return isinstance(value, dict) and all(k in AXES and intake.finite(v) for k, v in value.items())


def _check_targets(head: dict[str, Any], fault: Callable[..., GcompError]) -> None:
    """Quantity and sensitive direction."""
    if head["quantity"] not in QUANTITIES:
        raise fault(
            "quantity",
            f"{_said(head, 'quantity')}, and there is no such quantity",
            f"quantities: {', '.join(QUANTITIES)}",
        )
    vector = head.get("sensitive")
    if not vector or not _is_place(vector):
        raise fault(
            "sensitive",
            f"{_said(head, 'sensitive')}: a vector is wanted",
            "like sensitive = { X = 0.0, Z = 1.0 }",
        )
    # 0.707 and 0.707 for 45 degrees are near enough
    length = math.sqrt(sum(v * v for v in vector.values()))
    if abs(length - 1) > 1e-3:
        raise fault(
            "sensitive", f"sensitive has the length {length:.4f}", "a unit vector is wanted"
        )


def _check_ballbar(head: dict[str, Any], fault: Callable[..., GcompError]) -> None:
    """Radius and centre."""
    if not intake.finite(head.get("radius_mm")) or head["radius_mm"] <= 0:
        raise fault("radius_mm", f"{_said(head, 'radius_mm')}: a length above zero is wanted")
    feed = head.get("feed_mm_min", 1.0)
    if not intake.finite(feed) or feed <= 0:
        raise fault("feed_mm_min", f"{_said(head, 'feed_mm_min')}: a number above zero is wanted")
    if not _is_place(head.get("centre")):
        raise fault(
            "centre",
            f"{_said(head, 'centre')}: a place is wanted",
            "like centre = { X = 400.0, Y = 300.0 }",
        )


def check_head(head: dict[str, Any], fault: Callable[..., GcompError]) -> None:
    """Raises what fault(key, message, advice) makes of the first key that is not as the contract
    says."""
    if head.get("kind") not in KINDS:
        raise fault(
            "kind",
            f"{_said(head, 'kind')}, and there is no such kind",
            f"kinds: {', '.join(KINDS)}",
        )
    if head["kind"] == "targets":
        head.setdefault("quantity", "displacement")
        _check_targets(head, fault)
    if "u_um" in head and not (intake.finite(head["u_um"]) and head["u_um"] > 0):
        raise fault("u_um", f"u_um = {head['u_um']!r} is not above zero")
    if head["kind"] == "trace" and head.get("sees", "scale") not in ("scale", "tool"):
        raise fault("sees", f"sees = {head['sees']!r}", "scale or tool")
    if head["kind"] == "ballbar":
        _check_ballbar(head, fault)


def _said(head: dict[str, Any], key: str) -> str:
    return f"{key} = {head[key]!r}" if key in head else f"the head does not say {key}"


def _check_names(names: list[str], place: Place) -> None:
    for name in names:
        if not name:
            raise RecordingError("a column has no name", "", place)
        if names.count(name) > 1:
            raise RecordingError(f"the column {name!r} stands twice", "", place)


def needed(head: dict[str, Any], names: list[str], place: Place) -> set[str]:
    """The columns without which a row says nothing. Raises RecordingError for one that is
    missing."""
    if head["kind"] == "features":
        wanted = {"feature", "kind", "axis", "nominal_mm", "measured_mm"}
    else:
        wanted = _needed_moving(head, names, place)
    for name in sorted(wanted):
        if name not in names:
            raise RecordingError(
                f"the column {name} is missing", f"columns here: {', '.join(names)}", place
            )
    # a row without a number there would belong to no set-up, and to all of them
    return wanted | (PARTED & set(names))


MEASURED = {
    "ballbar": {"radial_um", "sense", "t_s"},
    "points": {"mx_mm", "my_mm", "mz_mm"},
    "lengths": {"length_mm"},
}


def _needed_moving(head: dict[str, Any], names: list[str], place: Place) -> set[str]:
    """The columns that a recording of a machine's axes needs."""
    suffix = "" if head["kind"] in RESTING else "_cmd"
    position = {x: f"{x}{suffix}_{'mm' if x in 'XYZ' else 'deg'}" for x in AXES}
    axes = [x for x in AXES if position[x] in names]
    if not axes:
        # one name with semicolons in it: a spreadsheet of a country of decimal commas has saved it
        if other := next((d for d in ";\t" if len(names) == 1 and d in names[0]), ""):
            raise RecordingError(
                f"the columns are parted by {'tabs' if other == chr(9) else 'semicolons'}",
                "commas part them, and points stand in numbers: save the table as CSV that way",
                place,
            )
        raise RecordingError(
            f"no column X{suffix}_mm, Y{suffix}_mm or Z{suffix}_mm",
            f"the position is missing; columns here: {', '.join(names)}",
            place,
        )
    return {position[x] for x in axes} | _needed_measured(head, names, axes, place)


def _check_centre(head: dict[str, Any], axes: list[str], place: Place) -> None:
    if wrong := [x for x in head["centre"] if x not in axes]:
        raise RecordingError(f"centre names {wrong[0]}, which is not recorded", "", place)


def _needed_measured(
    head: dict[str, Any], names: list[str], axes: list[str], place: Place
) -> set[str]:
    """The columns of what was measured beside the positions of `axes`."""
    kind = head["kind"]
    if kind == "targets":
        reading = "reading_urad" if head["quantity"] == "angle" else "reading_um"
        return {reading, *{f"approach_{x}" for x in axes}.intersection(names)}
    if kind == "ballbar":
        _check_centre(head, axes, place)
    # places in the frame of an instrument, or how far the tool is off along the machine's axes
    if kind == "points" and "dx_um" in names:
        return {"dx_um", "dy_um", "dz_um"}
    if kind == "trace":
        return {"t_s"} | {f"{x}_act_mm" for x in axes if x in "XYZ"}
    return MEASURED.get(kind, set())


def check(recording: Recording) -> None:
    """Signs are signs. Raises RecordingError with the line of one that is not."""
    for name, column in recording.columns.items():
        if column.dtype != object and (name.startswith("approach_") or name == "sense"):
            wrong = np.flatnonzero(
                ~np.isin(column, (-1, 0, 1)) if name != "sense" else ~np.isin(column, (-1, 1))
            )
            if len(wrong):
                raise RecordingError(
                    f"{name} = {column[wrong[0]]:g}",
                    "+1 or -1",
                    Place(recording.file, int(recording.lines[wrong[0]])),
                )
