"""halscope's log of a capture on LinuxCNC (File, Save log): how drives follow their commands.

First line `Sampling period is 1000000 ns`, then a line for each sample: the pin's name and its
value by turns (LinuxCNC, src/hal/utils/scope_files.c, write_log_file). Values are printed as the
desktop writes numbers, so a decimal comma may stand in them. A trace by the axes' own scales:
joint.N.pos-cmd and joint.N.pos-fb (or motor-pos-cmd and motor-pos-fb) of each joint, in machine
units.
"""

from __future__ import annotations

import re

import numpy as np

from postproc import intake
from postproc.errors import UsageError
from postproc.recordings import ReadingOptions, Recording, Source
from postproc.recordings import _text as text
from postproc.recordings import _units as units
from postproc.units import UM

TITLE = "LinuxCNC halscope log (Sampling period is ..., then pin and value by turns)"
TAKES = ("unit", "columns", "machine", "head")
EXTRA = {"joints": "letters of joints 0, 1, 2 ...: XYZ, or XZ on a lathe"}
#     Sampling period is 1000000 ns
#     joint.0.pos-cmd +1.250 joint.0.pos-fb +1.249        one line to each sample
HEAD = re.compile(r"Sampling period is\s+([0-9]+)\s*ns\s*")
VALUE = r"([^\s]+)\s+([-+]?[0-9]+(?:[.,][0-9]+)?)"
PAIR = re.compile(rf"\s*{VALUE}(?=\s|$)")
PAIRS = re.compile(rf"(?:{PAIR.pattern})+\s*")
PINS = (
    ("joint.{}.pos-cmd", "joint.{}.pos-fb"),
    ("joint.{}.motor-pos-cmd", "joint.{}.motor-pos-fb"),
)
COLUMN = re.compile(r"([XYZ])_(cmd|act)_mm|([A-Za-z]\w*)")


def recognises(source: Source) -> bool:
    first = source.data.lstrip(b"\xef\xbb\xbf \r\n").split(b"\n", 1)[0]
    return HEAD.fullmatch(first.decode("ascii", "replace").strip()) is not None


def read(source: Source, options: ReadingOptions) -> Recording:
    """A trace, sees = "scale". Raises RecordingError with the line, UsageError for pins that are
    not there."""
    content, _ = text.decoded(source)
    lines = [(n, line) for n, line in enumerate(intake.lines_of(content), 1) if line.strip()]
    head = HEAD.fullmatch(lines[0][1].strip()) if lines else None
    if head is None or int(head[1]) == 0:
        raise source.fault(
            1, "the first line is not the sampling period", "Sampling period is 1000000 ns"
        )
    names, values, at = _samples(source, lines[1:])
    unit, notices = _unit(options)
    wanted = _mapped(source, names, options)
    columns = {"run": np.ones(len(values)), "t_s": np.arange(len(values)) * int(head[1]) * 1e-9}
    for column, pin in wanted.items():
        factor = unit.factor * UM if column.endswith("_mm") else 1.0
        columns[column] = values[:, names.index(pin)] * factor
    described = {"sees": "scale", "sampling_period_ns": int(head[1]), "instrument": "halscope"}
    described |= {"machine": options.machine} if options.machine else {}
    return Recording(
        "trace", described | options.head, columns, source.name, at, (), tuple(notices)
    )


def _unit(options: ReadingOptions) -> tuple[units.Unit, list[str]]:
    """The unit of the positions, and a notice where it is taken for granted. Raises UsageError."""
    unit = units.named(options.unit or "mm")
    if unit.quantity != units.LENGTH:
        raise UsageError(f"--unit {unit.name} is no unit of lengths", "mm, or inch")
    if options.unit:
        return unit, []
    return unit, [
        "positions are taken as mm, LinuxCNC's machine unit (--unit inch where LINEAR_UNITS is"
        " inch)"
    ]


def _samples(
    source: Source, lines: list[tuple[int, str]]
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Names of the channels, (N, channels) values, and (N,) their lines."""
    names: list[str] = []
    values, at = [], []
    for number, line in lines:
        if not PAIRS.fullmatch(line):
            message = "this line is not pins and values by turns"
            raise source.fault(number, message, "joint.0.pos-cmd +1.250", line)
        pairs = PAIR.findall(line)
        mine = [name for name, _ in pairs]
        names = names or mine
        if (number, mine) == (lines[-1][0], names[: len(mine)]) and len(mine) < len(names):
            break  # the log's last sample may stop short
        if mine != names:
            many = f"{len(mine)} pins here, and {len(names)} before: {', '.join(names)}"
            raise source.fault(number, many, "", line)
        values.append([float(value.replace(",", ".")) for _, value in pairs])
        at.append(number)
    if len(values) < 2:
        raise source.fault(1, "there are fewer than two samples")
    return names, np.array(values), np.array(at, np.int64)


def _take_joints(found: dict[str, str], names: list[str], letters: str) -> None:
    """Into `found`, column to pin: the joints' own pins, the first of PINS that are recorded.
    letters: the axis of each joint."""
    for k, x in enumerate(letters):
        for command, actual in PINS:
            pins = command.format(k), actual.format(k)
            if x in "XYZ" and f"{x}_cmd_mm" not in found and all(p in names for p in pins):
                found.update({f"{x}_cmd_mm": pins[0], f"{x}_act_mm": pins[1]})


def _check_columns(source: Source, names: list[str], columns: dict[str, str]) -> None:
    """Raises UsageError for a column that no trace has, or a pin that the file has not."""
    for column, pin in columns.items():
        if not COLUMN.fullmatch(column):
            raise UsageError(f"--column {column}=... is no column of a trace", "X_cmd_mm, X_act_mm")
        if pin not in names:
            raise UsageError(f"{source.name} has no pin {pin}", f"its pins: {', '.join(names)}")


def _mapped(source: Source, names: list[str], options: ReadingOptions) -> dict[str, str]:
    """Column of the recording to pin: as the user says, else the joints' own pins."""
    _check_columns(source, names, options.columns)
    found = dict(options.columns)
    letters = options.extra.get("joints", "").upper()
    if letters and not re.fullmatch(r"[XYZABC]{1,6}", letters):
        raise UsageError(f"--set joints={letters} is not like XYZ", EXTRA["joints"])
    _take_joints(found, names, letters)
    moving = {m[1] for m in map(COLUMN.fullmatch, found) if m and m[1]}
    if not moving or not {f"{x}_{c}_mm" for x in moving for c in ("cmd", "act")} <= found.keys():
        raise UsageError(
            f"which pins of {source.name} are an axis' command and its scale is not said (pins:"
            f" {', '.join(names)})",
            "--set joints=XYZ for joints 0 1 2, or --column X_cmd_mm=PIN --column X_act_mm=PIN",
        )
    return found
