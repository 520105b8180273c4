"""What comes from outside, and how much of it is taken at most: the one place for these limits.

Files are made by people, other programs and strangers on the web. Each has a size beyond which it
is the wrong file, and is refused before it fills the memory; docs/SECURITY.md tells them in one
table, and tests/doors tries each. The figures are ten times, or more, what the largest file of its
kind needs that is known to us.
"""

from __future__ import annotations

import codecs
import math
import re
import tomllib
from pathlib import Path
from typing import Any

from postproc.errors import GcompError, Place, UsageError

# bytes
PROGRAM = 100_000_000  # read whole: --expand, simulate, batch; one that is not may have any length
LINE = 1_000_000  # of a program
RECORDING = 400_000_000
WORKBOOK = 1 << 27  # a sheet or the texts, unpacked: a sheet of a million readings has less
WORKBOOK_PART = 1 << 23  # any other part of a workbook, unpacked: names, styles
LOG = 200_000_000  # of thermometers: a year, a row each second, eight columns
MACHINE = 4_000_000  # machine.toml, measurement.toml
TABLE = 64_000_000  # of a machine: a million nodes, six columns
CONTROL_TABLE = 1 << 24
OFFSETS = 10_000_000
JOURNAL = 1 << 30  # of a job of ten million lines; ledger of a batch
MACRO = 1 << 20
RECEIVED = 1 << 26  # a program that a control sends

INTEGER = 2**63  # an integer of TOML has 64 bits (toml.io, v1.0.0, Integer)
NUMBER = 1e100  # more is no length, angle or temperature, and its square is no number that counts
# Keys below keys: the time that they cost grows with the square of their number.
PARTS = 32
LABEL = 60  # characters of a name: lines of some controls have 80
LINE_END = re.compile(r"\r\n|\n|\r")
DOTTED = re.compile(rf"(?:[\w-]+[ \t]*\.[ \t]*){{{PARTS}}}")


def whole(path: Path, most: int, error: type[GcompError] = UsageError) -> bytes:
    """All of a file. Raises `error` where it can not be read or has more than `most` bytes."""
    try:
        with open(path, "rb") as source:
            # one byte more than allowed tells that it is too long, however long it is
            data = source.read(most + 1)
    except IsADirectoryError:
        raise error(f"{path} is a folder, not a file") from None
    except OSError as fault:
        raise error(f"{path} can not be read: {fault.strerror}") from None
    if len(data) > most:
        raise error(f"{path} has more than {most:,} bytes", "is it the right file?")
    return data


def decoded(data: bytes, name: str, error: type[GcompError]) -> str:
    """The text of a UTF-8 file. Raises `error` with the line of the first byte that is none."""
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        return data.decode()
    except UnicodeDecodeError as fault:
        raise error(
            f"byte {data[fault.start]} is not UTF-8 text",
            "save the file as UTF-8",
            Place(name, data.count(b"\n", 0, fault.start) + 1),
        ) from None


def lines_of(text: str) -> list[str]:
    """The lines as an editor counts them: only line feed and carriage return end one. splitlines()
    would end one at a form feed, U+0085 and U+2028 too, which stand in remarks."""
    lines = LINE_END.split(text) if "\r" in text else text.split("\n")
    return lines[:-1] if text and not lines[-1] else lines


def inside(folder: Path, name: str) -> Path | None:
    """The file that a document in `folder` names; None where that leads out of the folder, by its
    path or by a link."""
    path = folder / name
    return path if path.resolve().is_relative_to(folder.resolve()) else None


def toml(text: str) -> dict[str, Any]:
    """A TOML document. Raises ValueError (tomllib.TOMLDecodeError is one), in words, with "line N"
    where that is known, for what is none, nests too deep, or holds an integer beyond 64 bits."""
    # before the parser, whose time it is that grows
    if deep := DOTTED.search(text):
        line = text.count("\n", 0, deep.start()) + 1
        raise ValueError(f"a key of more than {PARTS} parts (at line {line})")
    try:
        data = tomllib.loads(text)
        _sizes(data, text)
    except RecursionError:
        raise ValueError("it nests too deep") from None
    except tomllib.TOMLDecodeError:
        raise
    except ValueError as error:  # int() takes 4,300 digits at most
        raise ValueError(
            f"an integer has too many digits{_line(r'[0-9_]{4000}', text)}"
            if "digits" in str(error)
            else str(error)
        ) from None
    return data


def _sizes(value: Any, text: str) -> None:
    """Raises ValueError for an integer that TOML has no room for."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for one in value:
            _sizes(one, text)
    elif isinstance(value, int) and not -INTEGER <= value < INTEGER:
        found = _line(r"[0-9_]{19}|0[xob][0-9a-fA-F_]{16}", text)
        raise ValueError(f"an integer is beyond 64 bits{found}")


def _line(pattern: str, text: str) -> str:
    found = re.search(pattern, text)
    return f" (at line {text.count(chr(10), 0, found.start()) + 1})" if found else ""


def finite(value: Any) -> bool:
    """Whether it is a number that a place, an error or a temperature can have: neither inf nor nan,
    and not so large that its square is no float."""
    return (
        isinstance(value, (int, float))
        and not isinstance(value, bool)
        and abs(value) < NUMBER
        and not math.isnan(value)
    )


def label(name: str) -> str:
    """A name as a comment of a program, a script and the name of a file can hold it: whatever a
    machine is called, no word of it is a block, a command or a folder."""
    return re.sub(r"[^A-Za-z0-9 ._+-]", "_", name)[:LABEL].strip(" .") or "_"
