"""What instruments and controls have recorded, whatever file it came in.

A format is a module here, found by its name: TITLE says what it is, recognises(source) whether
bytes look like it, read(source, options) reads them. A format whose files may hold several
recordings also has read_all(source, options). TAKES names the options that it heeds, EXTRA the ones
of its own and what they mean. Modules that begin with _ are what formats share. Readers get bytes
and open nothing. What a file leaves open (unit, direction, axis) is never assumed in silence: it is
an option that must be given, or a notice that says what was taken.
"""

from __future__ import annotations

import hashlib
import importlib
import pkgutil
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from postproc import intake
from postproc.errors import GcompError, Place, UsageError
from postproc.units import UM, URAD

KINDS = ("targets", "trace", "ballbar", "features", "points", "lengths", "sphere")
RESTING = ("targets", "points", "lengths", "sphere")  # a row is a place at rest
QUANTITIES = ("displacement", "straightness", "angle")
AXES = "XYZABC"
OPTION = {"columns": "column"}  # where the command line says it otherwise


class RecordingError(GcompError):
    """A recording can not be read, or is not one that can be trusted."""


@dataclass(frozen=True)
class Source:
    """The bytes of a file and its name."""

    name: str
    data: bytes

    @property
    def sha256(self) -> str:
        """Of the bytes, in hexadecimal digits."""
        return hashlib.sha256(self.data).hexdigest()

    @cached_property
    def text(self) -> str:
        """UTF-8. Raises RecordingError with the line that is not."""
        return intake.decoded(self.data, self.name, RecordingError)

    def fault(self, line: int, message: str, advice: str = "", text: str = "") -> RecordingError:
        """The error to raise at a line."""
        return RecordingError(message, advice, Place(self.name, line, text))

    def unusable(self, fault: Fault, strict: bool, row: str) -> Fault:
        """The fault of a row that is left out. Raises RecordingError where strict."""
        if strict:
            advice = "mend the row; --lenient leaves such rows out"
            raise self.fault(fault.line, fault.message, advice, row)
        return fault


@dataclass(frozen=True)
class Fault:
    """A row that was left out: its line, the column, and what is wrong with it."""

    line: int
    column: str
    message: str


@dataclass(frozen=True)
class Recording:
    """One recording. head: all keys of its head, as the contract names them; columns: name with
    unit to (N,) float64, of text columns (N,) str; lines (N,): where each row stands in `file`;
    faults: rows that were left out; notices: what was taken for granted."""

    kind: str
    head: dict[str, Any]
    columns: dict[str, np.ndarray]
    file: str = ""
    lines: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    faults: tuple[Fault, ...] = ()
    notices: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()))) if self.columns else 0

    @property
    def machine(self) -> str:
        return str(self.head.get("machine", ""))

    @property
    def instrument(self) -> str:
        return str(self.head.get("instrument", ""))

    @property
    def quantity(self) -> str:
        """displacement, straightness or angle; of other kinds than targets displacement."""
        return str(self.head.get("quantity", "displacement"))

    @property
    def sensitive(self) -> dict[str, float]:
        """Unit vector along which a reading is taken; of an angle the axis of rotation."""
        return dict(self.head.get("sensitive", {}))

    @property
    def u(self) -> float | None:
        """mm (rad for angles): standard uncertainty of one reading, k = 1; None where it is not
        stated."""
        value = self.head.get("u_um")
        return None if value is None else float(value) * self.unit

    @property
    def unit(self) -> float:
        """mm or rad of one unit of the reading."""
        return URAD if self.quantity == "angle" else UM

    @cached_property
    def axes(self) -> tuple[str, ...]:
        """Letters of the axes whose position is recorded."""
        return tuple(x for x in AXES if self._position_name(x) in self.columns)

    def _position_name(self, letter: str) -> str:
        unit = "mm" if letter in "XYZ" else "deg"
        return f"{letter}_{unit}" if self.kind in RESTING else f"{letter}_cmd_{unit}"

    def position(self, letter: str) -> np.ndarray:
        """(N,) commanded slide positions, mm, of rotary axes degrees."""
        return self.columns[self._position_name(letter)]

    def approach(self, letter: str) -> np.ndarray:
        """(N,) sign of the axis' last move, -1 or +1; 0 where it is not recorded."""
        return self.columns.get(f"approach_{letter}", np.zeros(len(self)))

    @cached_property
    def reading(self) -> np.ndarray:
        """(N,) mm or rad: actual - commanded of targets; of a ballbar radius - nominal."""
        name = {
            "targets": "reading_urad" if self.quantity == "angle" else "reading_um",
            "ballbar": "radial_um",
        }[self.kind]
        # from here on mm and rad; a recording's columns stay in the units of their names
        return self.columns[name] * self.unit

    def pick(self, which: np.ndarray) -> Recording:
        """The rows where `which` (N,) is true, or of these indices."""
        return replace(
            self, columns={n: c[which] for n, c in self.columns.items()}, lines=self.lines[which]
        )


@dataclass(frozen=True)
class ReadingOptions:
    """What a file may leave open. Empty or None: not said.

    axis: the axis that moves (Z); component: what was measured (EXZ, EBZ); unit: of the readings
    (um, mm, urad, mrad, mm/m, arcsec, deg); bidirectional: whether runs alternate their direction;
    first: +1 or -1, direction of the first run; layout: interleaved, blocks or long; sheet: of a
    workbook; columns: name in the recording to name or number in the file; others: mm (degrees of
    rotary axes), where the other axes stood; machine: its name; strict: whether a row that can not
    be used is an error, or left out and listed; extra: a format's own options, see its EXTRA; head:
    keys for the recording's head, as the contract names them.
    """

    axis: str = ""
    component: str = ""
    unit: str = ""
    bidirectional: bool | None = None
    first: int = 0
    layout: str = ""
    sheet: str = ""
    columns: dict[str, str] = field(default_factory=dict)
    others: dict[str, float] = field(default_factory=dict)
    machine: str = ""
    strict: bool = True
    extra: dict[str, str] = field(default_factory=dict)
    head: dict[str, Any] = field(default_factory=dict)

    def given(self) -> list[str]:
        """Names of those that say something, without the ones that every format takes."""
        said = {
            "axis": self.axis, "component": self.component, "unit": self.unit,
            "bidirectional": self.bidirectional is not None, "first": self.first,
            "layout": self.layout, "columns": self.columns, "others": self.others,
            "machine": self.machine, "head": self.head,
        }  # fmt: skip
        return [name for name, value in said.items() if value]


def names() -> list[str]:
    """The formats that there are, as a user writes them."""
    return sorted(
        m.name.replace("_", "-")
        for m in pkgutil.iter_modules(__path__)
        if not m.name.startswith("_")
    )


def load(name: str) -> ModuleType:
    """The reader of a format. Raises UsageError with those that there are."""
    if name not in names():
        raise UsageError(f"there is no recording format {name!r}", f"formats: {', '.join(names())}")
    return importlib.import_module(f"{__name__}.{name.replace('-', '_')}")


def opened(source: Source, options: ReadingOptions) -> Source:
    """The file, of a workbook its sheet as text. Raises RecordingError, and UsageError for a sheet
    that is not there."""
    from postproc.recordings import _xlsx

    if _xlsx.is_workbook(source.data):
        text = _xlsx.as_text(source.data, source.name, options.sheet, RecordingError)
        return Source(source.name, text.encode())
    if options.sheet:
        raise UsageError(
            f"{source.name} is no workbook, and --sheet {options.sheet} names a sheet of one",
            "leave --sheet out",
        )
    return source


def format_of(source: Source, options: ReadingOptions | None = None) -> str:
    """The format that the bytes look like; a table whose columns or layout the options name is read
    by these.

    Raises RecordingError where they look like none.
    """
    return _format_of(opened(source, options or ReadingOptions()), options)


def _recognised(source: Source, among: Iterable[str]) -> str:
    """The first of these formats that the file looks like; "": none."""
    return next((name for name in among if load(name).recognises(source)), "")


def _format_of(source: Source, options: ReadingOptions | None) -> str:
    if not source.data.strip():
        raise source.fault(1, "the file is empty")
    # gcomp's own first: its columns would fit other formats as well, and its head says what it is
    if load("contract").recognises(source):
        return "contract"
    options = options or ReadingOptions()
    # What a person says of the columns comes before what the file looks like: the same file may
    # hold headings that another format knows by other meanings.
    if options.columns:
        takers = [n for n in names() if "columns" in getattr(load(n), "TAKES", ())]
        return _recognised(source, takers) or "mapped-csv"
    if options.layout:
        return "iso-spreadsheet"
    if name := _recognised(source, names()):
        return name
    # by its name, as the formats: it rests on them, and they on this file
    unknown = importlib.import_module(f"{__name__}._unknown")
    raise unknown.fault(source, names())


def read(source: Source, format: str = "", options: ReadingOptions | None = None) -> Recording:
    """Read a recording of a stated format, or of the one that it looks like. Raises RecordingError
    or UsageError.

    Of a file that holds several, the one that options.component names.
    """
    options = options or ReadingOptions()
    source = opened(source, options)
    module = _module(source, format, options)
    recording: Recording = module.read(source, options)
    return _with_unused(recording, module, options)


def read_all(
    source: Source, format: str = "", options: ReadingOptions | None = None
) -> list[Recording]:
    """All recordings of a file, one at least. Raises RecordingError or UsageError."""
    options = options or ReadingOptions()
    source = opened(source, options)
    module = _module(source, format, options)
    every: list[Recording] = (
        module.read_all(source, options)
        if hasattr(module, "read_all")
        else [module.read(source, options)]
    )
    return [_with_unused(recording, module, options) for recording in every]


def _module(source: Source, format: str, options: ReadingOptions) -> ModuleType:
    if format:
        load(format)
    if not source.data.strip():
        raise source.fault(1, "the file is empty")
    name = format or _format_of(source, options)
    module = load(name)
    known = getattr(module, "EXTRA", {})
    for key in options.extra:
        if key not in known:
            raise UsageError(
                f"the format {name} has no setting {key!r}",
                (
                    "its settings: " + "; ".join(f"--set {k}=... ({v})" for k, v in known.items())
                    if known
                    else "it has none"
                ),
            )
    return module


def _with_unused(recording: Recording, module: ModuleType, options: ReadingOptions) -> Recording:
    """The recording with a notice for every option that its format did not heed."""
    idle = [
        f"--{OPTION.get(n, n)}" for n in options.given() if n not in getattr(module, "TAKES", ())
    ]
    # An option without effect would be taken for one that was obeyed.
    if not idle:
        return recording
    what = (
        f"{', '.join(idle)} {'was' if len(idle) == 1 else 'were'} not used: the format"
        f" {_name(module)} has no place for it"
    )
    return replace(recording, notices=(*recording.notices, what))


def _name(module: ModuleType) -> str:
    return module.__name__.rpartition(".")[2].replace("_", "-")
