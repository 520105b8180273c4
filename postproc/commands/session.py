"""measurement.toml: which file is which component, where the other axes stood, units, signs,
temperatures.

    format = "gcomp-measurement/1"

    [options]                      # of gcomp calibrate, as on its command line without --
    like = "example-mill"
    squareness = ["C0Y=12.5,2"]

    [all]                          # what holds for every file that says nothing else
    others = { X = 250.0, Y = 200.0, Z = -150.0 }

    [[file]]
    name = "x.rtl"                 # beside measurement.toml
    component = "EXX"

Every command that reads recordings takes such a file in the place of the files that it names.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from postproc.errors import UsageError
from postproc.machine.toml_file import Section, TomlFile
from postproc.recordings import AXES, ReadingOptions, Recording

FORMAT = "gcomp-measurement/1"
TOP = {"format", "title", "date", "operator", "options", "all", "file"}
# texts, as the options of that name
WORDS = {"format", "axis", "component", "unit", "layout", "sheet", "machine"}
TABLES = {"column", "set", "head", "others", "temperature"}
KEYS = {*WORDS, *TABLES, "bidirectional", "first", "lenient", "sign"}


@dataclass(frozen=True)
class Entry:
    """One file. others: axis to mm (degrees), where it stood; sign: -1 where its readings have the
    other sign; temperature: place to degrees Celsius; line: of its name in the session."""

    path: Path
    format: str
    options: ReadingOptions
    others: dict[str, float]
    own: frozenset[str]
    sign: int
    temperature: dict[str, float]
    session: str

    def completed(self, recording: Recording) -> Recording:
        """The recording with what the session says of it. Raises UsageError where the file says
        otherwise."""
        columns, notices = dict(recording.columns), list(recording.notices)
        n = len(recording)
        if recording.kind == "targets":
            for x, at in self.others.items():
                self._check(recording, x, at)
                if x not in recording.axes:
                    columns[f"{x}_{'mm' if x in 'XYZ' else 'deg'}"] = np.full(n, at)
                    notices = [t for t in notices if not t.startswith("where the other axes stood")]
        for place, at in self.temperature.items():
            columns.setdefault(f"T_{place}_C", np.full(n, at))
        if self.sign < 0:
            name = self._readings_of(recording)
            columns[name] = -columns[name]
            notices.append("the readings' sign is turned, as the session says")
        return replace(recording, columns=columns, notices=tuple(notices))

    def _readings_of(self, recording: Recording) -> str:
        """The column whose sign is turned. Raises UsageError."""
        for name in recording.columns:
            if name.startswith(("reading_", "radial_")):
                return name
        raise UsageError(
            f"{self.session}: sign = -1 of {recording.file}, which has no readings", "take it out"
        )

    def _check(self, recording: Recording, x: str, at: float) -> None:
        """Raises UsageError where the file says that axis x, which this file's section names, stood
        elsewhere, or moved."""
        if x not in recording.axes or x not in self.own:
            return
        # The file knows it better than a line for all files: only a section of its own contradicts
        # it.
        position = recording.position(x)
        moved = np.ptp(position) > 0
        if moved or abs(position[0] - at) > 1e-6:
            raise UsageError(
                f"{self.session} says that {x} stood at {at:g} while {recording.file} was"
                " recorded, and the file says that it"
                f" {'moved' if moved else f'stood at {position[0]:g}'}",
                f"leave {x} out of others there",
            )


def is_session(path: str) -> bool:
    return path.lower().endswith(".toml")


def entries(path: str, base: ReadingOptions, format: str) -> list[Entry]:
    """The files of a session; base and format: what the command line says for all of them.

    Raises MachineError or UsageError with the line.
    """
    toml = _opened(path)
    everywhere = toml.section("all")
    everywhere.check_keys(KEYS - {"component", "axis", "sheet", "sign"})
    files = toml.sections("file", "files")
    if not files:
        advice = 'sections [[file]], each with name = "x.rtl"'
        raise toml.top.fault("file", "no files are named", advice)
    return [_entry(everywhere, one, base, format) for one in files]


def _opened(path: str) -> TomlFile:
    if not Path(path).is_file():
        raise UsageError(
            f"there is no file {path}",
            "gcomp recordings FILES --session FILE.toml writes a first one",
        )
    toml = TomlFile(Path(path))
    if toml.data.get("format") != FORMAT:
        raise toml.top.fault(
            "format",
            f"format = {toml.data.get('format')!r}: no session of a measurement",
            f'format = "{FORMAT}"',
        )
    toml.top.check_keys(TOP)
    return toml


def _check_kind(section: Section, key: str) -> None:
    """Raises MachineError where a word of a session is of another type than it must be."""
    value = section[key]
    kind = {"bidirectional": bool, "lenient": bool, "sign": int}.get(
        key, dict if key in TABLES else str
    )
    if not isinstance(value, kind) or isinstance(value, bool) != (kind is bool):
        words = {
            bool: "true or false",
            dict: "a table like { X = 1.0 }",
            str: "a text",
            int: "1 or -1",
        }
        raise section.fault(key, f"{key} = {value!r} is not {words[kind]}")


def _check_letters(everywhere: Section, one: Section, others: dict[str, float]) -> None:
    """Raises MachineError where `others` names what is no axis."""
    for x in others:
        if x not in AXES:
            section = one if x in one.get("others", {}) else everywhere
            raise section.fault("others", f"others names {x!r}, which is no axis")


def _entry(everywhere: Section, one: Section, base: ReadingOptions, format: str) -> Entry:
    one.check_keys(KEYS | {"name"})
    name = one.string("name")
    path = one.toml.path.parent / name
    if not path.is_file():
        raise one.fault("name", f"there is no file {path}", "names are beside the session")

    def said(key: str, default: Any) -> Any:
        #     command line (base)  <  [all]  <  [[file]]
        # The nearer to the file, the more it counts; tables are joined key by key (numbers).
        section = one if key in one else everywhere
        if key in section:
            _check_kind(section, key)
        return section.get(key, default)

    def numbers(key: str) -> dict[str, float]:
        said(key, {})  # it is a table
        both = {**everywhere.get(key, {}), **one.get(key, {})}
        return {x: one.number(x, at=key, of=both) for x in both}

    others = numbers("others")
    moved = said("component", base.component)[-1:] or said("axis", base.axis)
    _check_letters(everywhere, one, others)
    sign, first = said("sign", 1), said("first", "")
    for key, value, allowed in (("sign", sign, (1, -1)), ("first", first, ("", "+", "-"))):
        if value not in allowed:
            advice = 'sign = 1 or -1; first = "+" or "-"'
            raise one.fault(key, f"{key} = {one.get(key)!r}", advice)
    options = replace(
        base, axis=said("axis", base.axis), component=said("component", base.component),
        unit=said("unit", base.unit), bidirectional=said("bidirectional", base.bidirectional),
        first={"+": 1, "-": -1, "": base.first}[first], layout=said("layout", base.layout),
        sheet=said("sheet", base.sheet), machine=said("machine", base.machine),
        columns=base.columns | {k: str(v) for k, v in said("column", {}).items()},
        strict=base.strict and not said("lenient", False),
        extra=base.extra | {k: str(v) for k, v in said("set", {}).items()},
        head=base.head | everywhere.get("head", {}) | one.get("head", {}), others={},
    )  # fmt: skip
    stood = {x: v for x, v in (base.others | others).items() if x != moved.upper()}
    return Entry(
        path, said("format", format), options, stood, frozenset(one.get("others", {})), sign,
        numbers("temperature"), str(one.toml.path),
    )  # fmt: skip


class _Words(argparse.ArgumentParser):
    """Takes the words of [options]; what is wrong with them is told with the session's name."""

    session = ""

    def error(self, message: str) -> NoReturn:
        raise UsageError(
            f"{self.session}: [options]: {message}",
            "keys are the options of gcomp calibrate without --",
        )


def merged(
    options: argparse.Namespace, arguments: Callable[[argparse.ArgumentParser], None]
) -> argparse.Namespace:
    """The options of a command with those of the session that it names; what the command line says
    goes first.

    Raises UsageError where two sessions are named, or an option is none of the command's.
    """
    named = [p for p in options.recordings if is_session(p)]
    if not named:
        return options
    if len(named) > 1:
        raise UsageError(f"{len(named)} sessions: {', '.join(named)}", "one at a time")
    parser = _Words(add_help=False, allow_abbrev=False)
    parser.session = named[0]
    words = _words_of(_opened(named[0]))
    arguments(parser)
    defaults = parser.parse_args([*words, named[0]])
    result = argparse.Namespace(**vars(options))
    for key, value in vars(defaults).items():
        # argparse does not say whether an option was given: one that stands as by default was not.
        mine, usual = getattr(options, key), parser.get_default(key)
        if key == "recordings":
            continue
        if isinstance(value, list):
            setattr(result, key, [*value, *(mine or [])])
        elif mine == usual:
            setattr(result, key, value)
    return result


def _words_of(toml: TomlFile) -> list[str]:
    """[options] as on a command line."""
    words: list[str] = []
    section = toml.section("options")
    for key, value in section.data.items():
        option = f"--{key.replace('_', '-')}"
        for one in value if isinstance(value, list) else [value]:
            if one is False or isinstance(one, dict):
                raise section.fault(
                    key,
                    f"{key} = {one!r}",
                    "true for an option without a value, else its text as on the command line",
                )
            words.append(option if one is True else f"{option}={one}")
    return words


def first_one(found: list[tuple[str, list[Recording], str]], folder: Path) -> str:
    """A session for files: (name, its recordings, else why it can not be read yet), to be completed
    by a person."""
    lines = [
        f'format = "{FORMAT}"',
        "",
        (
            "[options]                          # of gcomp calibrate, as on its command line"
            " without --"
        ),
        (
            '# like = "example-mill"            # or: control, chain, least-increment, travel ='
            ' ["X=0,500", ...]'
        ),
        '# output = "machines/mine"',
        (
            '# squareness = ["C0Y=12.5,2"]      # urad and its u; square-at = "X200,Y150": where'
            " the square stood"
        ),
        "",
        "[all]                              # what holds for every file that says nothing else",
        (
            "# others = { X = 0.0, Y = 0.0 }    # mm, where the other axes stood: lever arms are"
            " counted from there"
        ),
        "# temperature = { machine = 20.0 } # degrees Celsius",
    ]
    for name, recordings, fault in found:
        lines += ["", "[[file]]", f"name = {json.dumps(_beside(name, folder), ensure_ascii=False)}"]
        if fault:
            lines += [
                f"# can not be read yet: {line.strip()}"
                for line in fault.splitlines()
                if line.strip()
            ]
            lines += ['# component = "EXX"', '# unit = "um"']
        elif len(recordings) > 1:
            lines.append(
                f"# holds {', '.join(str(r.head.get('component', r.kind)) for r in recordings)}"
            )
        else:
            lines += _of(recordings[0])
    return "\n".join(lines) + "\n"


def _of(recording: Recording) -> list[str]:
    if recording.kind != "targets":
        return [f"# {recording.kind}"]
    component = str(recording.head.get("component", ""))
    lines = [f'component = "{component}"'] if component else []
    moved = [x for x in recording.axes if np.ptp(recording.position(x)) > 0]
    lines.append(_readings(recording, moved))
    if recording.head.get("unit_in_file"):
        lines.append(f'unit = "{recording.head["unit_in_file"]}"')
    if len(moved) == len(recording.axes):
        lines.append(
            "# others = { ... }                 # mm, where the other axes stood, if not as in"
            " [all]"
        )
    return lines + [f"# {text}" for text in recording.notices if "other axes" not in text]


def _readings(recording: Recording, moved: list[str]) -> str:
    """What moves, and how large the readings are along what, as a comment."""
    vector = " ".join(x for x, v in recording.sensitive.items() if v)
    values = recording.reading / recording.unit
    along, unit = ("about", "urad") if recording.quantity == "angle" else ("along", "um")
    return (
        f"# {' '.join(moved) or 'no axis'} moves, {recording.quantity} {along} {vector}:"
        f" {len(values)} readings, {values.min():.6g} to {values.max():.6g} {unit}"
    )


def _beside(name: str, folder: Path) -> str:
    """The file as the session names it: relative to its folder where it lies below that."""
    path, home = Path(name).resolve(), folder.resolve()
    return path.relative_to(home).as_posix() if path.is_relative_to(home) else path.as_posix()
