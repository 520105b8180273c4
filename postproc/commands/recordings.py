"""`gcomp recordings FILE...` says what instruments' files hold, and writes them as gcomp recordings."""

from __future__ import annotations

import argparse
import io
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from postproc import ports
from postproc.commands import as_json, session, values
from postproc.errors import GcompError, UsageError
from postproc.recordings import (
    AXES,
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
LARGEST = 400_000_000  # bytes
SHOWN = 5  # rows left out that are listed one by one


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="*", metavar="FILE", help="recordings of any format")
    parser.add_argument(
        "--list", action="store_true", help="list the formats and their own settings"
    )
    parser.add_argument(
        "--session",
        metavar="FILE.toml",
        help="write a first session (measurement.toml) of these files",
    )
    as_json.argument(parser, FORMAT)
    parser.add_argument(
        "--as", dest="as_", metavar="FILE.csv", help="write it as a gcomp recording"
    )
    reading_arguments(parser)


def reading_arguments(parser: argparse.ArgumentParser) -> None:
    """The options that say what a recording's file leaves open: shared by all commands that read recordings."""
    group = parser.add_argument_group("what the files leave open")
    group.add_argument(
        "--format", metavar="NAME", default="", help="the format, where the file does not show it"
    )
    group.add_argument("--axis", default="", metavar="AXIS", help="the axis that moved")
    group.add_argument(
        "--component", default="", metavar="EXZ", help="what was measured: EZZ, EXZ, EBZ"
    )
    group.add_argument("--unit", default="", help=f"of the readings: {', '.join(units.UNITS)}")
    group.add_argument(
        "--bidirectional",
        choices=("yes", "no"),
        help="whether the runs go there and back by turns (default: they do)",
    )
    group.add_argument("--first", choices=("+", "-"), help="direction of the first run")
    group.add_argument(
        "--layout",
        choices=("interleaved", "blocks", "long"),
        default="",
        help="of a sheet's columns",
    )
    group.add_argument(
        "--sheet",
        default="",
        metavar="NAME",
        help="of an .xlsx workbook, where several hold numbers",
    )
    group.add_argument(
        "--column", metavar="NAME=HEADING", action="append", default=[],
        help="where a table has a column of a recording: Z_mm=Position, reading_um=3",
    )  # fmt: skip
    group.add_argument(
        "--others",
        metavar="X0,Y0",
        type=values.place,
        default={},
        help="where the other axes stood, mm",
    )
    group.add_argument(
        "--machine-name", metavar="NAME", default="", help="the machine's name for the recording"
    )
    group.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="a format's own setting (--list)",
    )
    group.add_argument(
        "--head", metavar="KEY=VALUE", action="append", default=[],
        help="a key of the recording's head, as TOML: u_um=0.2, 'instrument=\"level\"'",
    )  # fmt: skip
    group.add_argument(
        "--lenient", action="store_true", help="leave out rows that can not be used, and list them"
    )


def reading_options(options: argparse.Namespace) -> ReadingOptions:
    """What `reading_arguments` took. Raises UsageError for a pair without =, a name twice, or a letter that is no axis."""
    for letter in options.others:
        if letter not in AXES:
            raise UsageError(
                f"--others names {letter}, which is no axis of a recording",
                f"axes: {' '.join(AXES)}",
            )
    return ReadingOptions(
        options.axis, options.component, options.unit,
        None if options.bidirectional is None else options.bidirectional == "yes",
        {"+": 1, "-": -1, None: 0}[options.first], options.layout, options.sheet, _pairs("--column", options.column),
        dict(options.others), options.machine_name, not options.lenient, _pairs("--set", options.set),
        {k: _toml(k, v) for k, v in _pairs("--head", options.head).items()},
    )  # fmt: skip


def read_files(paths: list[str], format: str, options: ReadingOptions) -> list[Recording]:
    """All recordings of all files, of a session those that it names. Raises GcompError for the first that can not be read."""
    found: list[Recording] = []
    for path in paths:
        if session.is_session(path):
            for one in session.entries(path, options, format):
                source = Source(str(one.path), ports.read_whole(one.path, LARGEST))
                found += [one.completed(r) for r in read_all(source, one.format, one.options)]
        else:
            found += read_all(Source(path, ports.read_whole(Path(path), LARGEST)), format, options)
    return found


def files_of(paths: list[str]) -> list[str]:
    """The files of recordings, those that sessions name in the place of the sessions."""
    return [
        str(f) for p in paths
        for f in ([e.path for e in session.entries(p, ReadingOptions(), "")] if session.is_session(p) else [p])
    ]  # fmt: skip


def run(options: argparse.Namespace) -> int:
    if options.list:
        print(formats())
        return 0
    if not options.files:
        raise UsageError("which file?", "gcomp recordings FILE..., or --list for the formats")
    how = reading_options(options)
    if options.session:
        return _session(options, how)
    found: list[Recording] = []
    told: list[dict[str, Any]] = []
    status, out = 0, as_json.beside(options.json)
    for path in options.files:
        if session.is_session(path):
            for one in read_files([path], options.format, how):
                print(("\n" if found else "") + show(one, f"as {path} says"), file=out)
                found.append(one)
                told.append(facts(one, None))
            continue
        source = Source(path, ports.read_whole(Path(path), LARGEST))
        try:
            recordings = read_all(source, options.format, how)
        except GcompError as error:
            if len(options.files) == 1:
                raise
            print(f"gcomp: {error}", file=sys.stderr)
            told.append({"file": path, "fault": error.message, "advice": error.advice})
            status = 2
            continue
        name = options.format or format_of(source, how)
        for recording in recordings:
            print(("\n" if found else "") + show(recording, name), file=out)
            found.append(recording)
            told.append(facts(recording, name))
    if options.as_ and not status:
        print("\n" + _write(found, options.as_, options.files), file=out)
    as_json.put(options.json, {"format": FORMAT, "recordings": told})
    return status


def facts(recording: Recording, format: str | None) -> dict[str, Any]:
    """What a recording holds, for other programs. format: None where a session says how it is read."""
    units = (
        {"angle": "urad"}.get(recording.quantity, "um")
        if recording.kind in ("targets", "ballbar")
        else None
    )
    reading = recording.reading / recording.unit if units else np.zeros(0)
    moved = (
        {x: recording.position(x) for x in recording.axes} if recording.kind != "features" else {}
    )
    return {
        "file": recording.file, "read_as": format, "kind": recording.kind, "rows": len(recording), "machine": recording.head.get("machine") or None,
        "component": recording.head.get("component") or None, "unit": units,
        "readings": {"least": float(reading.min()), "largest": float(reading.max())} if len(reading) else None,
        "axes": {x: {"from": float(p.min()), "to": float(p.max()), "places": len(np.unique(p))} for x, p in moved.items() if len(p)},
        "runs": len(np.unique(recording.columns["run"])) if "run" in recording.columns else None,
        "left_out": [{"line": f.line, "column": f.column or None, "message": f.message} for f in recording.faults],
        "notices": list(recording.notices),
    }  # fmt: skip


def _session(options: argparse.Namespace, how: ReadingOptions) -> int:
    """A first measurement.toml; what can not be read yet stands in it with the reason."""
    path = Path(options.session)
    if not session.is_session(options.session) or path.exists():
        raise UsageError(f"--session {path}: {'it is there already' if path.exists() else 'its name ends in .toml'}", "another name")  # fmt: skip
    found: list[tuple[str, list[Recording], str]] = []
    for name in options.files:
        try:
            source = Source(name, ports.read_whole(Path(name), LARGEST))
            found.append((name, read_all(source, options.format, how), ""))
        except GcompError as error:
            found.append((name, [], f"{error.message}; {error.advice}"))
    text = session.first_one(found, path.parent)
    ports.replace_file(path, io.BytesIO(text.encode()), backup=False)
    open_ = sum(bool(fault) for *_, fault in found)
    print(
        f"written: {path}, {len(found)} files{f', {open_} of them can not be read yet: see there' if open_ else ''}"
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


def show(recording: Recording, format: str) -> str:
    """What a recording holds, for a person."""
    rows = [("kind", _kind(recording))]
    rows += [
        (key, str(recording.head[key]))
        for key in ("machine", "instrument", "date")
        if recording.head.get(key)
    ]
    if recording.kind == "targets":
        rows += _targets(recording)
    elif recording.kind != "features":
        rows.append(("samples", f"{len(recording)}, t = {_range(recording.columns['t_s'])} s"))
        rows += [
            (letter, f"{_range(recording.position(letter))} mm commanded")
            for letter in recording.axes
        ]
    else:
        what = sorted({str(f) for f in recording.columns["feature"]})
        rows.append(("features", f"{len(what)}: {', '.join(what)}; {len(recording)} readings"))
    if recording.kind == "ballbar":
        rows.append(("radial", _reading(recording)))
    places = {n: c for n, c in recording.columns.items() if n.startswith("T_") and n.endswith("_C")}
    for name, column in places.items():
        if np.any(np.isfinite(column)):
            rows.append((name[2:-2], f"{_range(column[np.isfinite(column)])} C"))
    if recording.faults:
        rows.append(("left out", f"{len(recording.faults)}"))
    lines = [f"{recording.file}: {format}", *(f"  {name:<12}{text}" for name, text in rows)]
    for fault in recording.faults[:SHOWN]:
        lines.append(
            f"    line {fault.line}: {fault.column + ': ' if fault.column else ''}{fault.message}"
        )
    if len(recording.faults) > SHOWN:
        lines.append(f"    and {len(recording.faults) - SHOWN} more")
    return "\n".join([*lines, *(f"  notice: {text}" for text in recording.notices)])


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
        rows.append(
            (
                letter,
                f"{len(np.unique(at))} targets, {_range(at)} {unit}"
                if letter in moving
                else f"stood at {at[0]:g} {unit}",
            )
        )
    if "run" in recording.columns:
        run = recording.columns["run"]
        ways = {
            sign: _runs(run[recording.approach(named or moving[0]) == sign]) for sign in (1, -1, 0)
        }
        text = "; ".join(
            f"{'+' if s > 0 else '-' if s < 0 else '?'} {r}" for s, r in ways.items() if r
        )
        rows.append(("runs", f"{len(np.unique(run))} ({text})"))
    rows.append(("readings", _reading(recording)))
    return rows


def _count(n: int, what: str) -> str:
    return f"{n} {what}{'' if n == 1 else 's'}"


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
    told = any(text.startswith("the readings range over") for text in recording.notices)
    remark = "plausible" if not odd else "NOT PLAUSIBLE" if told else f"NOT PLAUSIBLE: {odd}"
    return f"{len(value)}, {_range(value)} {base}{file}, {remark}"


def _range(column: np.ndarray) -> str:
    low, high = f"{column.min():.6g}", f"{column.max():.6g}"
    return low if low == high else f"{low} to {high}"


def _write(found: list[Recording], path: str, files: list[str]) -> str:
    if len(found) != 1:
        what = ", ".join(str(r.head.get("component", r.kind)) for r in found)
        raise UsageError(
            f"--as writes one recording, and here are {len(found)}: {what}",
            "--component, or one file at a time",
        )
    if any(Path(path).resolve() == Path(f).resolve() for f in files):
        raise UsageError(f"--as {path} is the file that is read", "another name")
    with ports.spool() as spool:
        spool.write(contract.write(found[0]).encode("utf-8"))
        backup = ports.replace_file(Path(path), spool, backup=Path(path).exists())
    kept = f"; what stood there is {backup}" if backup else ""
    return f"written: {path}, {len(found[0])} rows{kept}"


def _pairs(option: str, given: list[str]) -> dict[str, str]:
    result: dict[str, str] = {}
    for pair in given:
        key, equals, value = pair.partition("=")
        key, value = key.strip(), value.strip()
        if not equals or not key or not value:
            raise UsageError(f"{option} {pair} is no NAME=VALUE")
        if key in result:
            raise UsageError(f"{option} {key} is given twice: {result[key]} and {value}")
        result[key] = value
    return result


def _toml(key: str, value: str) -> Any:
    """A value of the head; a bare word is itself."""
    if key in ("format", "kind", "quantity", "sensitive", "component"):
        raise UsageError(
            f"--head {key} is not for you to say", "--component says what was measured"
        )
    try:
        return tomllib.loads(f"x = {value}")["x"]
    except tomllib.TOMLDecodeError:
        if any(c in value for c in "{}[]\"'="):
            raise UsageError(
                f"--head {key}={value} is not TOML",
                "like u_um=0.2 or 'centre={ X = 400.0, Y = 300.0 }'",
            ) from None
        return value
