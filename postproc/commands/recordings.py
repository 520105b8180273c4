"""`gcomp recordings FILE...` says what instruments' files hold, and writes them as gcomp
recordings."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from postproc import colour, intake, marks, ports, standing
from postproc.commands import as_json, option_text, session
from postproc.commands.recording_files import read_files, reading_arguments, reading_options
from postproc.errors import GcompError, UsageError
from postproc.recordings import (
    RESTING,
    ReadingOptions,
    Recording,
    Source,
    contract,
    format_of,
    load,
    names,
    read_all,
)
from postproc.recordings import _units as units

HELP = "show what recordings of instruments hold, and convert them: gcomp recordings FILE..."
EXAMPLE = "gcomp recordings z.rtl --axis Z --as z.csv"
FORMAT = "gcomp-recordings/1"
SHOWN = 5  # rows left out that are listed one by one


OPTIONS = f"""
files* FILE  recordings of any format
--list  list the formats and their own settings
--session FILE.toml  write a first session (measurement.toml) of these files
--json FILE  all of it as JSON ({FORMAT}); - for standard output
--as FILE.csv  write it as a gcomp recording
--force  with --as: write over a recording
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(parser, OPTIONS, **{"as": {"dest": "as_"}})
    reading_arguments(parser)


def run(options: argparse.Namespace) -> int:
    if options.list:
        print(formats())
        return 0
    if not options.files:
        raise UsageError("which file?", "gcomp recordings FILE..., or --list for the formats")
    how = reading_options(options)
    return _session(options, how) if options.session else _show_all(options, how)


def _show_all(options: argparse.Namespace, how: ReadingOptions) -> int:
    """What the files hold, and with --as all of it as one file."""
    found: list[Recording] = []
    results: list[dict[str, Any]] = []
    status, out = 0, as_json.beside(options.json)
    for path in options.files:
        try:
            recordings, name = _read(path, options.format, how)
        except GcompError as error:
            if len(options.files) == 1 or session.is_session(path):
                raise
            # of several files one may be none: the others are shown all the same, and the exit
            # status says so
            colour.fault(str(error))
            results.append({"file": path, "fault": error.message, "advice": error.advice})
            status = 2
            continue
        for recording in recordings:
            text = show(recording, name or f"as {path} says")
            print(("\n" if found else "") + text, file=out)
            found.append(recording)
            results.append(facts(recording, name))
    if options.as_ and not status:
        print("\n" + _write(found, options.as_, options.files, options.force), file=out)
    as_json.put(options.json, {"format": FORMAT, "recordings": results})
    return status


def _read(path: str, format: str, how: ReadingOptions) -> tuple[list[Recording], str | None]:
    """What a file holds, and in which format; None of a session, which says it itself."""
    if session.is_session(path):
        return read_files([path], format, how), None
    source = Source(path, ports.read_whole(Path(path), intake.RECORDING))
    return read_all(source, format, how), format or format_of(source, how)


def facts(recording: Recording, format: str | None) -> dict[str, Any]:
    """What a recording holds, for other programs. format: None where a session says how it is
    read."""
    units = (
        {"angle": "urad"}.get(recording.quantity, "um")
        if recording.kind in ("targets", "ballbar")
        else None
    )
    reading = recording.reading / recording.unit if units else np.zeros(0)
    return {
        "file": recording.file,
        "read_as": format,
        "kind": recording.kind,
        "rows": len(recording),
        "machine": recording.head.get("machine") or None,
        "component": recording.head.get("component") or None,
        "unit": units,
        "readings": (
            {"least": float(reading.min()), "largest": float(reading.max())}
            if len(reading)
            else None
        ),
        "axes": _moved(recording),
        "runs": len(np.unique(recording.columns["run"])) if "run" in recording.columns else None,
        "left_out": [
            {"line": f.line, "column": f.column or None, "message": f.message}
            for f in recording.faults
        ],
        "notices": list(recording.notices),
    }


def _session(options: argparse.Namespace, how: ReadingOptions) -> int:
    """A first measurement.toml; what can not be read yet stands in it with the reason."""
    path = Path(options.session)
    if not session.is_session(options.session):
        raise UsageError(f"--session {path}: its name ends in .toml", "another name")
    standing.kept(path, False, "another name")
    found: list[tuple[str, list[Recording], str]] = []
    for name in options.files:
        try:
            source = Source(name, ports.read_whole(Path(name), intake.RECORDING))
            found.append((name, read_all(source, options.format, how), ""))
        except GcompError as error:
            found.append((name, [], f"{error.message}; {error.advice}"))
    text = session.first_one(found, path.parent)
    ports.write_whole(path, text.encode())
    open_ = sum(bool(fault) for *_, fault in found)
    print(
        f"written: {path}, {len(found)}"
        f" files{f', {open_} of them can not be read yet: see there' if open_ else ''}"
    )
    print(f"complete it, then: gcomp calibrate {path}")
    return 0


def formats() -> str:
    """The formats with their settings."""
    width = max(map(len, names()))
    lines = []
    for name in names():
        module = load(name)
        lines.append(f"{name:<{width}}  {module.TITLE}")
        lines += [
            f"{'':<{width}}    --set {k}=...  {v}" for k, v in getattr(module, "EXTRA", {}).items()
        ]
    return "\n".join(lines)


def _moved(recording: Recording) -> dict[str, dict[str, Any]]:
    """Where the axes were, mm or degrees, by letter."""
    if recording.kind == "features":
        return {}
    moved = {x: recording.position(x) for x in recording.axes}
    return {
        x: {"from": float(p.min()), "to": float(p.max()), "places": len(np.unique(p))}
        for x, p in moved.items()
        if len(p)
    }


def show(recording: Recording, format: str) -> str:
    """What a recording holds, for a person."""
    head = {key: recording.head.get(key) for key in ("machine", "instrument", "date")}
    rows = [("kind", _kind(recording))]
    rows += [(key, str(value)) for key, value in head.items() if value]
    rows += _contents(recording)
    if recording.kind == "ballbar":
        rows.append(("radial", _reading(recording)))
    rows += _temperatures(recording)
    if recording.faults:
        rows.append(("left out", f"{len(recording.faults)}"))
    lines = [f"{recording.file}: {format}", *(f"  {name:<12}{text}" for name, text in rows)]
    notices = [f"  notice: {text}" for text in recording.notices]
    return "\n".join([*lines, *_faults(recording), *notices])


def _temperatures(recording: Recording) -> list[tuple[str, str]]:
    """Sensors that say something, and their ranges."""
    return [
        (name[2:-2], f"{_range(column[np.isfinite(column)])} C")
        for name, column in recording.columns.items()
        if name.startswith("T_") and name.endswith("_C") and np.any(np.isfinite(column))
    ]


def _faults(recording: Recording) -> list[str]:
    """The first of the rows that are left out, and how many there are more."""
    lines = [
        f"    line {fault.line}: {fault.column + ': ' if fault.column else ''}{fault.message}"
        for fault in recording.faults[:SHOWN]
    ]
    more = len(recording.faults) - SHOWN
    return lines + [f"    and {more} more"] * (more > 0)


def _contents(recording: Recording) -> list[tuple[str, str]]:
    """Rows or samples of its kind, and the ranges of its axes."""
    if recording.kind == "targets":
        return _targets(recording)
    if recording.kind in RESTING:
        return [
            ("rows", f"{len(recording)}"),
            *(
                (x, f"{_range(recording.position(x))} {'mm' if x in 'XYZ' else 'deg'}")
                for x in recording.axes
            ),
        ]
    if recording.kind == "features":
        what = sorted({str(f) for f in recording.columns["feature"]})
        return [("features", f"{len(what)}: {', '.join(what)}; {len(recording)} readings")]
    return [
        ("samples", f"{len(recording)}, t = {_range(recording.columns['t_s'])} s"),
        *((x, f"{_range(recording.position(x))} mm commanded") for x in recording.axes),
    ]


def _kind(recording: Recording) -> str:
    if recording.kind != "targets":
        return recording.kind
    parts = {k: v for k, v in recording.sensitive.items() if v}
    vector = (
        next(iter(parts))
        if list(parts.values()) == [1.0]
        else ", ".join(f"{k} {v:.6g}" for k, v in parts.items())
    )
    name = recording.head.get("component", "")
    what = f"{name}, {recording.quantity}" if name else recording.quantity
    return f"targets: {what} {'about' if recording.quantity == 'angle' else 'along'} {vector}"


def _targets(recording: Recording) -> list[tuple[str, str]]:
    """Axes, targets, runs with their directions, and readings."""
    rows = []
    named = str(recording.head.get("component", ""))[-1:]
    moving = [x for x in recording.axes if np.ptp(recording.position(x)) > 0 or x == named] or list(
        recording.axes[:1]
    )
    for letter in recording.axes:
        at, unit = recording.position(letter), "mm" if letter in "XYZ" else "deg"
        targets = f"{len(np.unique(at))} targets, {_range(at)} {unit}"
        rows.append((letter, targets if letter in moving else f"stood at {at[0]:g} {unit}"))
    if "run" in recording.columns:
        rows.append(("runs", _ways(recording, named or moving[0])))
    rows.append(("readings", _reading(recording)))
    return rows


def _ways(recording: Recording, axis: str) -> str:
    """How many runs there are, and which of them in each direction."""
    run, way = recording.columns["run"], recording.approach(axis)
    runs = {sign: _runs(run[way == s]) for sign, s in (("+", 1), ("-", -1), ("?", 0))}
    text = "; ".join(f"{sign} {which}" for sign, which in runs.items() if which)
    return f"{len(np.unique(run))} ({text})"


def _runs(run: np.ndarray) -> str:
    numbers = [f"{r:g}" for r in np.unique(run)]
    return ", ".join(numbers if len(numbers) <= 12 else [*numbers[:5], "...", numbers[-1]])


def _reading(recording: Recording) -> str:
    """How many, from where to where, and whether a machine has that."""
    value = recording.reading / recording.unit
    base = "urad" if recording.quantity == "angle" else "um"
    odd = (
        units.outside(float(np.ptp(value)), "angle" if base == "urad" else "length")
        if len(value) > 1
        else None
    )
    said = recording.head.get("unit_in_file", "")
    file = f" (in {said} in the file)" if said and said != base else ""
    results = any(text.startswith("the readings range over") for text in recording.notices)
    remark = "plausible" if not odd else "NOT PLAUSIBLE" if results else f"NOT PLAUSIBLE: {odd}"
    return f"{len(value)}, {_range(value)} {base}{file}, {remark}"


def _range(column: np.ndarray) -> str:
    low, high = f"{column.min():.6g}", f"{column.max():.6g}"
    return low if low == high else f"{low} to {high}"


def _write(found: list[Recording], path: str, files: list[str], force: bool) -> str:
    if len(found) != 1:
        what = ", ".join(str(r.head.get("component", r.kind)) for r in found)
        raise UsageError(
            f"--as writes one recording, and here are {len(found)}: {what}",
            "--component, or one file at a time",
        )
    if any(Path(path).resolve() == Path(f).resolve() for f in files):
        raise UsageError(f"--as {path} is the file that is read", "another name")
    if not force:
        standing.result(path, marks.SIMULATED, "another name, or --force to write over it")
    ports.write_whole(path, contract.write(found[0]).encode("utf-8"))
    return f"written: {path}, {len(found[0])} rows"
