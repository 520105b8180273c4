"""Renishaw laser record of a motion (.rtx): a header of `key: value` lines, `Data:`, then samples
up to `EOF::`.

The samples are little-endian float64, evenly spaced by `Actual sample rate` (Hz). The layout is
known from one public reader (rtx2csv, tested there on a file of CARTO Dynamic 4.13), not from the
maker: unverified against original files. The file holds measured positions only, in a unit that it
does not say, and no commands.
"""

from __future__ import annotations

import re

import numpy as np

from postproc.errors import Place, UsageError
from postproc.recordings import ReadingOptions, Recording, RecordingError, Source
from postproc.recordings import _components as components
from postproc.recordings import _units as units
from postproc.units import UM

TITLE = "Renishaw laser record of a motion (.rtx)"
TAKES = ("axis", "unit", "others", "machine", "head")
EXTRA = {"command": "still: the axis stood; line: it moved evenly, a straight line is laid through"}
#     HEADER:: ... Actual sample rate: 1000 ... Data:\n | float64 | float64 | ... | [\r\n] EOF::
BEGIN = re.compile(rb"(?:^|\n)Data:[ \t]*\r?\n")
END = b"EOF::"
HEADER_MOST = 1 << 16
FARTHEST = 1e5  # mm


def recognises(source: Source) -> bool:
    head = source.data[:HEADER_MOST]
    return (
        b"HEADER::" in head[:200]
        and BEGIN.search(head) is not None
        and b"TARGET DATA::" not in head
    )


def _keys(lines: list[str]) -> dict[str, tuple[str, int]]:
    """What the header says, and in which line."""
    return {
        k.strip().lower(): (v.strip(), i)
        for i, (k, c, v) in enumerate((x.partition(":") for x in lines), 1)
        if c
    }


def _samples(source: Source, begin: int, at: Place, notices: list[str]) -> np.ndarray:
    """(N,) the numbers of 8 bytes from byte `begin` to the end. Raises RecordingError."""
    # from the end: five bytes like these may stand in the numbers
    end = source.data.rfind(END)
    if end < begin:
        notices.append("there is no EOF:: at the end: the file may be cut off")
        end = len(source.data)
    block = source.data[begin:end]
    over = len(block) % 8
    # a line end before EOF:: is no part of the last number
    if over and end < len(source.data) and block[-over:] in (b"\r\n", b"\n"):
        block = block[:-over]
    elif over:
        raise RecordingError(
            f"the data are {len(block)} bytes, which is no whole number of samples of 8 bytes",
            "the file is cut off, or was copied as text: copy it as binary", at,
        )  # fmt: skip
    samples = np.frombuffer(block, "<f8").astype(np.float64)
    if len(samples) < 2:
        raise RecordingError(f"there are {len(samples)} samples", "two at least make a motion", at)
    return samples


def _axis(source: Source, keys: dict[str, tuple[str, int]], options: ReadingOptions) -> str:
    """X, Y or Z. Raises UsageError or RecordingError where that is not said."""
    axis = options.axis.strip().upper() or components.axis_in(keys.get("axis", ("", 0))[0])
    if axis in ("X", "Y", "Z"):
        return axis
    if options.axis:
        raise UsageError(
            f"--axis {options.axis} is no linear axis",
            "an .rtx file is read as positions: X, Y or Z",
        )
    raise source.fault(
        keys.get("axis", ("", 1))[1], "the file does not say which axis moved", "say --axis Z"
    )


def read(source: Source, options: ReadingOptions) -> Recording:
    """A trace, sees = "tool". Raises RecordingError for a broken file, and where axis, unit or
    command are not said."""
    begin = BEGIN.search(source.data[:HEADER_MOST])
    if begin is None:
        raise source.fault(1, "there is no line Data: in the header", "is this an .rtx file?")
    lines = (
        source.data[: begin.start()].decode("utf-8", "replace").replace("\r\n", "\n").split("\n")
    )
    keys = _keys(lines)
    at = Place(source.name, len(lines) + 1)
    notices: list[str] = []
    samples = _samples(source, begin.end(), at, notices)
    rate = _rate(source, keys)
    axis = _axis(source, keys, options)
    position = _position(samples, options, at)
    command = _command(position, options, at)
    stated = _whole(keys.get("sample no", ("", 0))[0])
    if stated and stated != len(samples):
        notices.append(f"Sample no is {stated}, and there are {len(samples)} samples")
    notices.append(
        f"the commands are not in the file: {axis}_cmd_mm is made up ({options.extra['command']})"
    )
    columns = {"run": np.ones(len(samples)), "t_s": np.arange(len(samples)) / rate}
    columns |= {f"{axis}_cmd_mm": command, f"{axis}_act_mm": position}
    said = {k: v for k, (v, _) in keys.items()}
    head = {
        "machine": options.machine or said.get("machine"),
        "instrument": "Renishaw laser interferometer, dynamic",
        "serial_number": said.get("serial no"),
        "date": said.get("date"),
    }
    kept = {k: v for k, v in head.items() if v}
    described = {"sees": "tool", "sample_rate_hz": rate, "unit_in_file": options.unit}
    # the commanded position has no line of its own in a binary file
    at_line = np.full(len(samples), at.line)
    for x in options.others.keys() - {axis}:
        columns |= {f"{x}_{c}_mm": np.full(len(samples), options.others[x]) for c in ("cmd", "act")}
    return Recording(
        "trace", kept | described | options.head, columns, source.name, at_line, (), tuple(notices)
    )


def _whole(value: str) -> int:
    found = re.fullmatch(r"([0-9]{1,12})(?:\.0*)?", value)
    return int(found[1]) if found else 0


def _rate(source: Source, keys: dict[str, tuple[str, int]]) -> float:
    """Samples a second. Raises RecordingError where the header does not say it."""
    for name in ("actual sample rate", "sample rate"):
        if name in keys:
            value, line = keys[name]
            if (
                not re.fullmatch(r"[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]{1,2})?", value)
                or not 0 < float(value) < 1e9
            ):
                raise source.fault(
                    line, f"{name} is {value!r}: that is not a number of samples a second"
                )
            return float(value)
    raise source.fault(1, "the header does not say the Actual sample rate")


def _position(samples: np.ndarray, options: ReadingOptions, at: Place) -> np.ndarray:
    """mm."""
    if not options.unit:
        low, high = samples.min(), samples.max()
        raise RecordingError(
            f"the file does not say in which unit its samples are ({low:g} to {high:g})",
            "say --unit mm, or another",
            at,
        )
    unit = units.named(options.unit)
    if unit.quantity != units.LENGTH:
        raise UsageError(
            f"--unit {options.unit} is no unit of lengths", "an .rtx file is read as positions"
        )
    wrong = np.flatnonzero(~(np.abs(samples) <= FARTHEST / (unit.factor * UM)))
    if len(wrong):
        raise RecordingError(
            f"sample {wrong[0] + 1} is {samples[wrong[0]]:g} {unit.name}: no axis is there",
            "the data are not float64, another --unit is meant, or the file was copied as text", at,
        )  # fmt: skip
    return samples * unit.factor * UM


def _command(position: np.ndarray, options: ReadingOptions, at: Place) -> np.ndarray:
    """mm: the commands that the user says the axis had."""
    how = options.extra.get("command", "")
    if how == "still":
        return np.full(len(position), float(np.median(position)))
    if how == "line":
        # what the line takes off is a lag and an error of the scale as well: neither can be told
        # here
        x = np.linspace(-1.0, 1.0, len(position))
        return np.polyval(np.polyfit(x, position, 1), x)
    if how:
        raise UsageError(f"--set command={how} is not known", "still, or line")
    raise RecordingError(
        "the file holds no commanded positions",
        f"say what the axis did: --set command=still or line ({EXTRA['command']})",
        at,
    )
