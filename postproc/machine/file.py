"""machines/<name>/ to Machine: machine.toml and one CSV table per moving axis (format gcomp-machine/1).

Reads strictly: a machine file is trusted with somebody's part. Every complaint names file and line.
"""

from __future__ import annotations

import csv
import hashlib
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from postproc import effects
from postproc.errors import MachineError, Place
from postproc.machine import chain as chains
from postproc.machine.chain import XYZ
from postproc.machine.model import Axis, EffectTerm, Limits, Machine
from postproc.machine.tables import COMPONENTS, AxisTable
from postproc.units import UM, URAD

FORMAT = "gcomp-machine/1"
KEYS = {
    "": {"format", "name", "title", "control", "chain", "diameter", "source", "axes", "squareness", "tool", "offsets", "limits", "effect", "reversal"},
    "axes.": {"travel", "least_increment", "table", "measured_at", "max_velocity", "max_acceleration", "max_jerk"},
    "tool": set(XYZ),
    "limits": {"max_correction", "max_slope", "outside", "accept_slope"},
    "effect": {"name", "axis", "source"},
}  # fmt: skip
ROTARY = "ABC"
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf(inity)?)", re.IGNORECASE)
REVERSALS = ("mean", "step", "ramp", "off")


class _Toml:
    """A TOML document that knows in which line a key stands."""

    def __init__(self, path: Path):
        self.path, self.text = path, _text(path)
        try:
            self.data: dict[str, Any] = tomllib.loads(self.text)
        except tomllib.TOMLDecodeError as error:
            found = re.search(r"line (\d+)", str(error))
            raise MachineError(
                f"not valid TOML: {error}", place=Place(str(path), int(found[1]) if found else 1)
            ) from None

    def line(self, section: str, key: str, index: int = 0) -> int:
        """Line of `key` in `section` ("axes.Z"; in the index-th of several), as good as the layout lets us find it."""
        here, count, fallback = "", -1, 0
        for number, line in enumerate(self.text.splitlines(), 1):
            header = re.match(r"\s*\[+\s*([^\]]+?)\s*\]+", line)
            if header:
                here = header[1].replace('"', "")
                count += here == section
                if here == section and count == index:
                    fallback = number
                if f"{section}.{key}".lstrip(".") == here:
                    return number
            elif (
                re.match(rf'\s*"?{re.escape(key)}"?\s*=', line) and here == section and (count == index or not section)
            ):
                return number
        return fallback or 1

    def fault(self, section: str, key: str, message: str, advice: str = "", index: int = 0) -> MachineError:
        return MachineError(message, advice, Place(str(self.path), self.line(section, key, index)))

    def table(self, key: str) -> dict[str, Any]:
        """A section, empty where it is missing."""
        value = self.data.get(key, {})
        if not isinstance(value, dict):
            raise self.fault("", key, f"{key} = {value!r} must be a section [{key}]")
        return value

    def check_keys(self, section: str, data: dict, known: set[str], index: int = 0) -> None:
        for key in data:
            if key not in known:
                where = f"[{section or 'machine'}]"
                raise self.fault(
                    section, key, f"{key!r} is not a key of {where}", f"keys: {', '.join(sorted(known))}", index
                )

    def number(
        self, section: str, data: dict, key: str, default: float | None = None, at: str = "", index: int = 0
    ) -> float:
        """A finite number; `at`: the key whose line to name, where this one stands inside a table of its own."""
        value = data.get(key, default)
        if value is None:
            raise self.fault(section, at or key, f"{key} is missing in [{section}]", index=index)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise self.fault(section, at or key, f"{key} = {value!r} is not a number", index=index)
        return float(value)

    def string(self, section: str, data: dict, key: str, default: str | None = None, index: int = 0) -> str:
        value = data.get(key, default)
        if not isinstance(value, str):
            message = f"{key} = {value!r} is not a text" if key in data else f"{key} is missing"
            raise self.fault(section, key, message, index=index)
        return value


def _text(path: Path) -> str:
    """The text of a file; what is not UTF-8 is refused with its line."""
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise MachineError(
            f"byte {data[error.start]} is not UTF-8 text", "save the file as UTF-8", Place(str(path), line)
        ) from None


def read_machine(folder: Path) -> Machine:
    """Read a machine folder. Raises MachineError with file and line for anything that is not as the format says."""
    path = folder / "machine.toml"
    if not path.is_file():
        raise MachineError(
            f"{folder} has no machine.toml", "a machine is a folder with machine.toml and a CSV table per axis"
        )
    toml = _Toml(path)
    data = toml.data
    toml.check_keys("", data, KEYS[""])
    if toml.string("", data, "format") != FORMAT:
        raise toml.fault("", "format", f"format is {data['format']!r}, not {FORMAT!r}")
    try:
        chain = chains.parse(toml.string("", data, "chain"))
    except ValueError as error:
        raise toml.fault("", "chain", str(error)) from None
    sections = data.get("axes")
    if not isinstance(sections, dict) or not sections:
        raise toml.fault("axes", "", "no [axes.X] sections")
    digest = hashlib.sha256(toml.text.encode())
    limits = _limits(toml)
    axes = {
        x: _axis(toml, x, section, digest, limits)
        for x, section in sorted(sections.items(), key=lambda item: (XYZ + ROTARY).find(item[0]))
    }
    for x in chain.axes:
        if x not in axes:
            raise toml.fault("", "chain", f"the chain names {x}, and there is no [axes.{x}]")
    for x in axes:
        if x in XYZ and x not in chain.axes:
            raise toml.fault(f"axes.{x}", "travel", f"axis {x} is not in the chain {data['chain']}")
    diameter = data.get("diameter", [])
    if not isinstance(diameter, list) or not all(isinstance(d, str) and d in axes for d in diameter):
        raise toml.fault("", "diameter", f"diameter = {diameter!r} must list axes of the machine")
    reversal = toml.string("", data, "reversal", "step")
    if reversal not in REVERSALS:
        raise toml.fault("", "reversal", f"reversal = {reversal!r}", f"one of {', '.join(REVERSALS)}")
    tool = toml.table("tool")
    toml.check_keys("tool", tool, KEYS["tool"])
    return Machine(
        name=toml.string("", data, "name", folder.name), title=toml.string("", data, "title", ""),
        control=toml.string("", data, "control"), chain=chain, axes=axes, diameter=tuple(diameter),
        square=_squareness(toml, axes), tool=np.array([toml.number("tool", tool, x, 0.0) for x in XYZ]),
        offsets=_offsets(toml, axes), limits=limits, effects=_effects(toml, axes),
        source=toml.string("", data, "source", ""), digest=digest.hexdigest()[:8], reversal=reversal,
    )  # fmt: skip


def _limits(toml: _Toml) -> Limits:
    data = toml.table("limits")
    toml.check_keys("limits", data, KEYS["limits"])
    outside = toml.string("limits", data, "outside", "error")
    if outside not in ("error", "clamp"):
        raise toml.fault("limits", "outside", f"outside = {outside!r}", 'it is "error" or "clamp"')
    slope = toml.number("limits", data, "max_slope", Limits.max_slope)
    accept = data.get("accept_slope", False)
    if not isinstance(accept, bool):
        raise toml.fault("limits", "accept_slope", f"accept_slope = {accept!r} is neither true nor false")
    if accept:
        slope = math.inf
    return Limits(toml.number("limits", data, "max_correction", Limits.max_correction), slope, outside)


def _axis(toml: _Toml, letter: str, section: Any, digest, limits: Limits) -> Axis:
    name = f"axes.{letter}"
    if letter not in tuple(XYZ + ROTARY) or not isinstance(section, dict):
        raise toml.fault(name, "", f"[{name}]: an axis is one of X Y Z A B C")
    toml.check_keys(name, section, KEYS["axes."])
    travel = section.get("travel")
    if travel is None:
        raise toml.fault(name, "travel", f"travel is missing in [{name}]", "two ascending numbers, mm")
    good = isinstance(travel, list) and len(travel) == 2 and all(_finite(t) for t in travel)
    if not good or travel[0] >= travel[1]:
        raise toml.fault(name, "travel", f"travel = {travel!r} must be two ascending numbers, mm")
    for key in ("max_velocity", "max_acceleration", "max_jerk"):
        if toml.number(name, section, key, 1.0) <= 0:
            raise toml.fault(name, key, f"{key} = {section[key]!r} is not above zero")
    least = toml.number(name, section, "least_increment")
    if not 1e-6 <= least <= 0.1 or abs(math.log10(least) - round(math.log10(least))) > 1e-9:
        raise toml.fault(
            name, "least_increment", f"least_increment = {least!r}", "a power of ten from 0.000001 to 0.1, mm"
        )
    at = section.get("measured_at", {})
    if not isinstance(at, dict):
        raise toml.fault(name, "measured_at", f"measured_at = {at!r} must be like {{ X = 0.0 }}")
    for key in at:
        if key not in XYZ:
            raise toml.fault(name, "measured_at", f"measured_at names {key!r}, which is no linear axis")
    measured = np.array([toml.number(name, at, x, 0.0, at="measured_at") for x in XYZ])
    table = None
    if "table" in section:
        if letter in ROTARY:
            raise toml.fault(name, "table", f"tables of rotary axes ({letter}) are not used yet", "leave the table out")
        path = toml.path.parent / toml.string(name, section, "table")
        if not path.is_file():
            raise toml.fault(name, "table", f"there is no table {path}")
        digest.update(path.read_bytes())
        table = read_table(path, letter, limits.max_slope)
    return Axis(letter, (float(travel[0]), float(travel[1])), least, measured, table)


def read_table(path: Path, letter: str, max_slope: float) -> AxisTable:
    """Read `Z.csv`: first column `Z_mm`, then components with their unit, by direction where measured so.

    Raises MachineError with file and line for a wrong column or unit, a number that is none, nodes that do not ascend, or
    a slope over `max_slope` (mm/mm for translations).
    """
    header: list[str] = []
    rows: list[list[float]] = []
    lines: list[int] = []
    for number, line in enumerate(_text(path).splitlines(), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        place = Place(str(path), number, line)
        try:
            cells = [cell.strip() for cell in next(csv.reader([line]))]
        except csv.Error as error:
            raise MachineError(f"not a line of a CSV table: {error}", "numbers between commas", place) from None
        if not header:
            header = cells
            columns = _columns(header, letter, place)
            continue
        if len(cells) != len(header):
            raise MachineError(
                f"{len(cells)} values under {len(header)} columns", "a value is missing or one too many", place
            )
        for cell in cells:
            if not NUMBER.fullmatch(cell):
                raise MachineError(f"{cell!r} is not a number", "every node needs a value in every column", place)
        values = [float(cell) for cell in cells]
        if not all(map(math.isfinite, values)):
            raise MachineError(
                "a value is not finite (NaN or infinity)", "every node needs a value in every column", place
            )
        if rows and values[0] <= rows[-1][0]:
            raise MachineError(
                f"{letter}_mm = {values[0]:g} does not ascend after {rows[-1][0]:g}",
                "order the nodes, each once",
                place,
            )
        rows.append(values)
        lines.append(number)
    if len(rows) < 2:
        raise MachineError(f"{len(rows)} nodes: a table needs two at least", "", Place(str(path), 1))
    data = np.array(rows).T
    forward, reverse = np.zeros((6, len(rows))), np.zeros((6, len(rows)))
    for (component, direction), column in columns.items():
        scale = UM if component < 3 else URAD
        for wanted, into in (("rev", reverse), ("fwd", forward)):
            if direction in ("", wanted):
                into[component] = data[column] * scale
    table = AxisTable(letter, data[0], forward, reverse)
    steep = np.abs(table.slopes[:3]).max(axis=(0, 1)) if len(rows) > 1 else np.zeros(1)
    worst = int(np.argmax(steep))
    if steep[worst] > max_slope:
        raise MachineError(
            f"the deviation changes by {steep[worst] * 1000:.2f} um/mm between {letter} = {data[0][worst]:g} and {data[0][worst + 1]:g} "
            f"(limit {max_slope * 1000:g} um/mm)",
            "a slip in the data or a wrong unit is likely; if it is true, set max_slope or accept_slope = true in [limits]",
            Place(str(path), lines[worst + 1]),
        )
    return table


def _finite(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _columns(header: list[str], letter: str, place: Place) -> dict[tuple[int, str], int]:
    """(component, direction) to column; direction "" for a component measured one way."""
    if header[0] != f"{letter}_mm":
        raise MachineError(
            f"the first column is {header[0]!r}, not '{letter}_mm'", "positions are slide positions in mm", place
        )
    columns: dict[tuple[int, str], int] = {}
    allowed = [f"{c}{letter}_um" for c in COMPONENTS[:3]] + [f"{c}{letter}_urad" for c in COMPONENTS[3:]]
    for i, name in enumerate(header[1:], 1):
        base, direction = (name[:-4], name[-3:]) if name.endswith(("_fwd", "_rev")) else (name, "")
        if base not in allowed:
            raise MachineError(
                f"{name!r} is not a component of axis {letter}",
                f"columns: {', '.join(allowed)}, each also with _fwd and _rev",
                place,
            )
        key = (allowed.index(base), direction)
        if key in columns:
            raise MachineError(f"{name!r} stands twice", "", place)
        columns[key] = i
    for component in {c for c, _ in columns}:
        others = {d for c, d in columns if c == component}
        if others not in ({""}, {"fwd", "rev"}):
            raise MachineError(f"{allowed[component]}: give one column, or both _fwd and _rev", "", place)
    return columns


def _squareness(toml: _Toml, axes: dict[str, Axis]) -> dict[str, np.ndarray]:
    square: dict[str, np.ndarray] = {}
    data = toml.table("squareness")
    for name in data:
        if not re.fullmatch(r"[ABC]0[XYZ]", name) or name[2] not in axes or "ABC".index(name[0]) == XYZ.index(name[2]):
            raise toml.fault(
                "squareness",
                name,
                f"{name!r} is not a squareness of this machine",
                "rotation, 0, axis that leans: B0X, C0Y, A0Z",
            )
        value = toml.number("squareness", data, name)
        if value:
            square.setdefault(name[2], np.zeros(3))["ABC".index(name[0])] = value * URAD
    return square


def _offsets(toml: _Toml, axes: dict[str, Axis]) -> dict[str, dict[str, float]]:
    offsets = {}
    for name, values in toml.table("offsets").items():
        if not re.fullmatch(r"G5[4-9](\.[123])?|T\d{4}", name) or not isinstance(values, dict):
            raise toml.fault(
                "offsets", name, f"{name!r} is not a work or tool offset", "like G54 = { X = 0.0, Z = 0.0 }"
            )
        for x in values:
            if x not in axes:
                raise toml.fault("offsets", name, f"{name} names {x!r}, which is no axis of the machine")
        offsets[name] = {x: toml.number("offsets", values, x, at=name) for x in values}
    return offsets


def _effects(toml: _Toml, axes: dict[str, Axis]) -> tuple[EffectTerm, ...]:
    terms = []
    entries = toml.data.get("effect", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise toml.fault("", "effect", "effects are sections [[effect]], with two brackets")
    for i, entry in enumerate(entries):
        name = toml.string("effect", entry, "name", index=i)
        try:
            module = effects.load(name)
        except KeyError:
            known = f"effects: {', '.join(effects.names())}"
            raise toml.fault("effect", "name", f"there is no effect {name!r}", known, i) from None
        axis = toml.string("effect", entry, "axis", index=i)
        if axis not in axes or axis not in XYZ:
            raise toml.fault("effect", "axis", f"effect {name}: {axis!r} is no linear axis of the machine", index=i)
        toml.check_keys("effect", entry, KEYS["effect"] | set(module.PARAMETERS), i)
        parameters = {p: toml.number("effect", entry, p, index=i) for p in module.PARAMETERS}
        if module.USE == "compensate":
            terms.append(EffectTerm(name, axis, parameters, module))
    return tuple(terms)
