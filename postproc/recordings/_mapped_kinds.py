"""Traces, circles and features from a mapped table: columns take the contract's names, and must be
what it wants.

A circle may also be given by its angle: `angle_deg` (from the first axis of `centre` towards the
second) stands for the two commanded positions. What the head must say (centre, radius_mm) comes
from the options.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from postproc.errors import Place, UsageError
from postproc.recordings import ReadingOptions, Recording, RecordingError, Source, contract
from postproc.recordings import _text as text
from postproc.recordings import _units as units
from postproc.recordings._columns import TEXTS

SENSE = {"ccw": 1.0, "cw": -1.0}


def is_other(mapping: dict[str, str]) -> bool:
    """Whether a mapping's names are of another kind of recording than targets."""
    return any(
        n.startswith("radial") or n.endswith("_cmd_mm") or n == "measured_mm" for n in mapping
    )


def _kind(names: Iterable[str]) -> str:
    if "measured_mm" in names:
        return "features"
    return "ballbar" if any(n.startswith("radial") for n in names) else "trace"


def read(
    source: Source,
    options: ReadingOptions,
    table: text.Table,
    top: int,
    at: dict[str, int],
    notices: list[str],
) -> Recording:
    """Raises UsageError for what the mapping or the head lacks, RecordingError with the line for
    what is no number."""
    kind = _kind(at)
    head = ({"machine": options.machine} if options.machine else {}) | options.head

    def fault(key: str, message: str, advice: str = "") -> UsageError:
        return UsageError(
            message if key in head else f"a {kind} needs {key}, and nothing says it",
            f"--head '{key} = ...'; {advice}",
        )

    # as a file of its own would be, but for the advice: what a head lacks is said by --head here
    contract.check_head({**head, "kind": kind}, fault)
    words = TEXTS if kind == "features" else set()
    arrays, lines = _columns(source, table, top, at, words)
    if kind == "ballbar":
        arrays = _circle(head, _radial(options, arrays), len(lines), notices)
    if "run" not in arrays and kind != "features":
        # one recording is one run, where nothing says otherwise
        arrays["run"] = np.ones(len(lines))
    try:
        contract.needed(
            {**head, "kind": kind}, list(arrays), Place(source.name, table.rows[max(top - 1, 0)][0])
        )
    except RecordingError as error:
        raise UsageError(f"for a {kind} {error.message}", "name it with --column") from None
    recording = Recording(kind, head, arrays, source.name, lines, (), tuple(notices))
    contract.check(recording)
    return recording


def _number(name: str, cell: str, decimal: str, place: Place) -> float:
    """What a cell of a column is worth. Raises RecordingError for no number."""
    value = SENSE.get(cell.lower()) if name == "sense" else None
    value = text.number(cell, decimal) if value is None else value
    if value is None:
        what = f"{name} {cell!r} is not a number" if cell else f"{name} is empty"
        raise RecordingError(what, "", place)
    return value


def _columns(
    source: Source, table: text.Table, top: int, at: dict[str, int], words: set[str]
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Columns by name, and their lines; those of `words` are no numbers."""
    columns: dict[str, list] = {name: [] for name in at}
    for line, cells in table.rows[top:]:
        place = Place(source.name, line, table.delimiter.join(cells))
        for name, j in at.items():
            cell = cells[j] if j < len(cells) else ""
            number = cell if name in words else _number(name, cell, table.decimal, place)
            columns[name].append(number)
    lines = np.array([line for line, _ in table.rows[top:]], np.int64)
    if not len(lines):
        raise source.fault(table.rows[-1][0], "there are no rows")
    return {
        n: np.array(c, dtype=object if n in words else np.float64) for n, c in columns.items()
    }, lines


def _radial(options: ReadingOptions, arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """radial_um, from radial_mm or radial with --unit."""
    name = next(n for n in arrays if n.startswith("radial"))
    said = name.partition("_")[2] or options.unit
    if not said:
        raise UsageError(
            f"nothing says in which unit {name} is",
            "--column radial_um=..., radial_mm=..., or --unit",
        )
    unit = units.named(said)
    if unit.quantity != units.LENGTH:
        raise UsageError(f"{unit.name} is no unit of lengths", "--column radial_um=...")
    if options.unit and units.named(options.unit).factor != unit.factor:
        raise UsageError(
            f"the mapping says {unit.name}, and --unit says {options.unit}", "leave --unit out"
        )
    scaled = arrays | {name: arrays[name] * unit.factor}
    return {("radial_um" if n == name else n): column for n, column in scaled.items()}


def _circle(
    head: dict, arrays: dict[str, np.ndarray], n: int, notices: list[str]
) -> dict[str, np.ndarray]:
    """The commanded positions from the angle, and a time where there is none."""
    if "angle_deg" in arrays:
        letters = list(head["centre"])
        if len(letters) != 2:
            raise UsageError(
                f"centre names {len(letters)} axes",
                "a circle has two: --head 'centre = { X = 400.0, Y = 300.0 }'",
            )
        angle = np.radians(arrays.pop("angle_deg"))
        #      second |     * angle_deg, counter-clockwise from the first
        #             |   /
        #             | /________ first         letters as `centre` names them
        for letter, part in zip(letters, (np.cos(angle), np.sin(angle)), strict=True):
            arrays[f"{letter}_cmd_mm"] = head["centre"][letter] + head["radius_mm"] * part
    if "t_s" not in arrays:
        arrays["t_s"] = np.arange(n, dtype=np.float64)
        notices.append("the file has no times: t_s is made up, 1 s from row to row")
    return arrays
