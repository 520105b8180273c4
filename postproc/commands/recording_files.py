"""Recordings as all commands take them: the options that say what their files leave open, and the
files."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from postproc import intake, ports
from postproc.commands import option_text, session, values
from postproc.errors import UsageError
from postproc.recordings import AXES, ReadingOptions, Recording, Source, read_all
from postproc.recordings import _units as units

OPTIONS = f"""
[what the files leave open]
--format NAME  the format, where the file does not show it
--axis AXIS  the axis that moved
--component EXZ  what was measured: EZZ, EXZ, EBZ
--unit UNIT  of the readings: {", ".join(units.UNITS)}
--bidirectional (yes|no)  whether the runs go there and back by turns (default: they do)
--first (+|-)  direction of the first run
--layout (interleaved|blocks|long)  of a sheet's columns
--sheet NAME  of an .xlsx workbook, where several hold numbers
--column NAME=HEADING ...  where a table has a column of a recording: Z_mm=Position, reading_um=3
--others X0,Y0  where the other axes stood, mm
--machine-name NAME  the machine's name for the recording
--set KEY=VALUE ...  a format's own setting (--list)
--head KEY=VALUE ...  a key of the recording's head, as TOML: u_um=0.2, 'instrument="level"'
--lenient  leave out rows that can not be used, and list them
"""


def reading_arguments(parser: argparse.ArgumentParser) -> None:
    """The options that say what a recording's file leaves open: shared by all commands that read
    recordings."""
    option_text.add(
        parser, OPTIONS, format="", axis="", component="", unit="", layout="", sheet="",
        others=(values.place, {}), machine_name="",
    )  # fmt: skip


def reading_options(options: argparse.Namespace) -> ReadingOptions:
    """What `reading_arguments` took. Raises UsageError for a pair without =, a name twice, or a
    letter that is no axis."""
    for letter in options.others:
        if letter not in AXES:
            raise UsageError(
                f"--others names {letter}, which is no axis of a recording",
                f"axes: {' '.join(AXES)}",
            )
    return ReadingOptions(
        options.axis, options.component, options.unit,
        None if options.bidirectional is None else options.bidirectional == "yes",
        {"+": 1, "-": -1, None: 0}[options.first], options.layout, options.sheet,
        _pairs("--column", options.column), dict(options.others), options.machine_name,
        not options.lenient, _pairs("--set", options.set),
        {k: _toml(k, v) for k, v in _pairs("--head", options.head).items()},
    )  # fmt: skip


def read_files(paths: list[str], format: str, options: ReadingOptions) -> list[Recording]:
    """All recordings of all files, of a session those that it names. Raises GcompError for the
    first that can not be read."""
    found: list[Recording] = []
    for path in paths:
        if session.is_session(path):
            for one in session.entries(path, options, format):
                source = Source(str(one.path), ports.read_whole(one.path, intake.RECORDING))
                found += [one.completed(r) for r in read_all(source, one.format, one.options)]
        else:
            found += read_all(
                Source(path, ports.read_whole(Path(path), intake.RECORDING)), format, options
            )
    return found


def files_of(paths: list[str]) -> list[str]:
    """The files of recordings, those that sessions name in the place of the sessions."""
    return [
        str(f)
        for p in paths
        for f in (
            [e.path for e in session.entries(p, ReadingOptions(), "")]
            if session.is_session(p)
            else [p]
        )
    ]


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
        return intake.toml(f"x = {value}")["x"]
    except ValueError:
        if any(c in value for c in "{}[]\"'="):
            raise UsageError(
                f"--head {key}={value} is not TOML",
                "like u_um=0.2 or 'centre={ X = 400.0, Y = 300.0 }'",
            ) from None
        return value
