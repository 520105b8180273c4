"""machines/<name>/ to Machine: machine.toml and one CSV table per moving axis (format
gcomp-machine/1).

Reads strictly: a machine file is trusted with somebody's part. Every complaint names file and line.
"""

from __future__ import annotations

import hashlib
import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from postproc import intake
from postproc.errors import MachineError, Place
from postproc.machine import chain as chains
from postproc.machine.angle_file import location, squareness, squareness_u
from postproc.machine.axis_file import over_turns, read_grid, read_table, read_uncertainty
from postproc.machine.chain import LINEAR, OPTICS, ROTARY, SECOND, XYZ
from postproc.machine.effect_file import read_effects
from postproc.machine.heat_file import heat
from postproc.machine.model import Axis, ControlTable, Limits, Machine
from postproc.machine.tables import COMPONENTS, GridTable
from postproc.machine.toml_file import TomlFile
from postproc.machine.tool_point import read_tool_point
from postproc.units import UM

FORMAT = "gcomp-machine/1"
KEYS = {
    "": {
        "format",
        "name",
        "title",
        "control",
        "chain",
        "diameter",
        "source",
        "axes",
        "squareness",
        "tool",
        "offsets",
        "limits",
        "effect",
        "reversal",
        "location",
        "control_table",
        "signs",
        "tool_point",
        "home",
    },
    "axes.": {
        "travel",
        "least_increment",
        "table",
        "measured_at",
        "max_velocity",
        "max_acceleration",
        "max_jerk",
        "centre",
        "optic",
        "by",
        "heat",
        "left_out",
    },
    "control_table": {"control", "file", "settings", "measured", "active", "axis", "set"},
    "tool": set(XYZ),
    "limits": {"max_correction", "max_slope", "outside", "accept_slope", "hysteresis_um"},
}
UNCERTAINTY = "_uncertainty.csv"  # behind the axis' letter
REVERSALS = ("mean", "step", "ramp", "off")
SIGNS = ("unverified", "verified")


def read_machine(folder: Path) -> Machine:
    """Read a machine folder. Raises MachineError with file and line for anything that is not as the
    format says."""
    path = folder / "machine.toml"
    if not path.is_file():
        raise MachineError(
            f"{folder} has no machine.toml",
            "a machine is a folder with machine.toml and a CSV table per axis",
        )
    toml = TomlFile(path)
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
        x: _axis(toml, x, section, digest, limits, chain)
        for x, section in sorted(
            sections.items(), key=lambda item: (XYZ + ROTARY + "UVW").find(item[0])
        )
    }
    for x in chain.axes:
        if x not in axes:
            raise toml.fault("", "chain", f"the chain names {x}, and there is no [axes.{x}]")
    for x in axes:
        if x not in chain.axes and (x in LINEAR or axes[x].table is not None or axes[x].grids):
            raise toml.fault(f"axes.{x}", "travel", f"axis {x} is not in the chain {data['chain']}")
        for grid in axes[x].grids:
            if grid.other not in axes:
                raise toml.fault(
                    f"axes.{x}", "by", f"by names {grid.other}, which is no axis of the machine"
                )
    axes = location(toml, axes)
    for path in sorted(folder.glob(f"*{UNCERTAINTY}")):
        if path.name.removesuffix(UNCERTAINTY) not in axes:
            raise MachineError(
                f"{path.name} is of no axis of the machine",
                f"axes: {' '.join(axes)}",
                Place(str(path), 1),
            )
    diameter = data.get("diameter", [])
    if not isinstance(diameter, list) or not all(
        isinstance(d, str) and d in axes for d in diameter
    ):
        raise toml.fault("", "diameter", f"diameter = {diameter!r} must list axes of the machine")
    reversal = toml.string("", data, "reversal", "step")
    if reversal not in REVERSALS:
        raise toml.fault(
            "", "reversal", f"reversal = {reversal!r}", f"one of {', '.join(REVERSALS)}"
        )
    tool = toml.table("tool")
    toml.check_keys("tool", tool, KEYS["tool"])
    signs = toml.string("", data, "signs", "")
    if signs not in ("", *SIGNS):
        raise toml.fault(
            "",
            "signs",
            f"signs = {signs!r}",
            "has a measurement after compensation shown them? unverified or verified",
        )
    return Machine(
        name=toml.string("", data, "name", folder.name),
        title=toml.string("", data, "title", ""),
        control=toml.string("", data, "control"),
        chain=chain,
        axes=axes,
        diameter=tuple(diameter),
        square=squareness(toml, axes),
        tool=np.array([toml.number("tool", tool, x, 0.0) for x in XYZ]),
        control_tables=_control_tables(toml, digest),
        offsets=_offsets(toml, axes),
        limits=limits,
        effects=read_effects(toml, axes),
        source=toml.string("", data, "source", ""),
        digest=digest.hexdigest()[:8],
        reversal=reversal,
        home=_home(toml, axes),
        square_u=squareness_u(toml, axes),
        signs=signs,
        tool_stated="tool" in data,
        tool_point=read_tool_point(toml),
        square_stated=tuple(name for name in toml.table("squareness") if name != "u"),
    )


def _home(toml: TomlFile, axes: dict[str, Axis]) -> dict[str, float]:
    """`home = { X = 0.0, Y = 0.0, Z = 0.0 }`: where the slides stand after homing, mm, radius."""
    home = toml.data.get("home", {})
    if not isinstance(home, dict):
        raise toml.fault(
            "", "home", f"home = {home!r}", "like home = { X = 0.0, Y = 0.0, Z = 0.0 }"
        )
    for x in home:
        if x not in axes:
            raise toml.fault("", "home", f"home names {x!r}, which is no axis of the machine")
    return {x: toml.number("", home, x, at="home") for x in home}


def _limits(toml: TomlFile) -> Limits:
    data = toml.table("limits")
    toml.check_keys("limits", data, KEYS["limits"])
    outside = toml.string("limits", data, "outside", "error")
    if outside not in ("error", "clamp"):
        raise toml.fault("limits", "outside", f"outside = {outside!r}", 'it is "error" or "clamp"')
    slope = toml.number("limits", data, "max_slope", Limits.max_slope)
    accept = data.get("accept_slope", False)
    if not isinstance(accept, bool):
        raise toml.fault(
            "limits", "accept_slope", f"accept_slope = {accept!r} is neither true nor false"
        )
    if accept:
        slope = math.inf
    hysteresis = toml.number("limits", data, "hysteresis_um", Limits.hysteresis / UM) * UM
    if hysteresis < 0:
        raise toml.fault(
            "limits", "hysteresis_um", f"hysteresis_um = {data['hysteresis_um']!r} is below zero",
            "by how much a slide turns back before its lost motion is taken up, um",
        )  # fmt: skip
    return Limits(
        toml.number("limits", data, "max_correction", Limits.max_correction),
        slope,
        outside,
        hysteresis,
    )


def _axis(
    toml: TomlFile, letter: str, section: Any, digest, limits: Limits, chain: chains.Chain
) -> Axis:
    name = f"axes.{letter}"
    if letter not in tuple(LINEAR + ROTARY) or not isinstance(section, dict):
        raise toml.fault(name, "", f"[{name}]: an axis is one of X Y Z A B C U V W")
    toml.check_keys(name, section, KEYS["axes."])
    travel = section.get("travel")
    if travel is None:
        raise toml.fault(
            name, "travel", f"travel is missing in [{name}]", "two ascending numbers, mm"
        )
    good = isinstance(travel, list) and len(travel) == 2 and all(map(intake.finite, travel))
    if not good or travel[0] >= travel[1]:
        raise toml.fault(name, "travel", f"travel = {travel!r} must be two ascending numbers, mm")
    for key in ("max_velocity", "max_acceleration", "max_jerk"):
        if toml.number(name, section, key, 1.0) <= 0:
            raise toml.fault(name, key, f"{key} = {section[key]!r} is not above zero")
    least = toml.number(name, section, "least_increment")
    if not 1e-6 <= least <= 0.1 or abs(math.log10(least) - round(math.log10(least))) > 1e-9:
        raise toml.fault(
            name,
            "least_increment",
            f"least_increment = {least!r}",
            "a power of ten from 0.000001 to 0.1, mm",
        )
    measured = _measured_at(toml, name, letter, section, chain)
    table = None
    if "table" in section:
        path = _table_path(toml, name, section["table"], "table")
        _counted(path, intake.TABLE, digest)
        table = read_table(path, letter, limits.max_slope)
        if letter in ROTARY:
            table = over_turns(table, float(travel[0]), float(travel[1]), path)
    uncertainty = None
    path = _own(toml, name, "table", f"{letter}{UNCERTAINTY}")
    if path.is_file():
        _counted(path, intake.TABLE, digest)
        uncertainty = read_uncertainty(path, letter, (float(travel[0]), float(travel[1])), table)
    optic = toml.string(name, section, "optic", "")
    if optic not in ("", *OPTICS):
        raise toml.fault(
            name,
            "optic",
            f"optic = {optic!r}",
            "what the measured point was fixed to: tool or workpiece",
        )
    return Axis(
        letter,
        (float(travel[0]), float(travel[1])),
        least,
        measured,
        table,
        optic,
        _centre(toml, name, letter, section),
        grids=_grids(toml, name, letter, section, digest, limits),
        expansion=heat(toml, name, section),
        uncertainty=uncertainty,
        left_out=_left_out(toml, name, letter, section),
        centre_stated=tuple(section.get("centre", {})),
        velocity=toml.number(name, section, "max_velocity", 0.0) / 60.0,
    )


def _measured_at(
    toml: TomlFile, name: str, letter: str, section: dict, chain: chains.Chain
) -> np.ndarray:
    """(3,) mm: where the other axes stood, by direction; of two slides of one direction, those that
    the axis carries."""
    at = section.get("measured_at", {})
    if not isinstance(at, dict):
        raise toml.fault(name, "measured_at", f"measured_at = {at!r} must be like {{ X = 0.0 }}")
    for key in at:
        if key not in LINEAR:
            raise toml.fault(
                name, "measured_at", f"measured_at names {key!r}, which is no linear axis"
            )
    carried = chain.axes[chain.axes.index(letter) + 1 :] if letter in chain.axes else ()
    two = {x for x in XYZ if SECOND[x] in chain.axes}
    stood = {x: toml.number(name, at, x, 0.0, at="measured_at") for x in LINEAR}
    return np.array([
        sum(stood[y] for y in (x, SECOND[x]) if y in carried) if x in two else stood[x] for x in XYZ
    ])  # fmt: skip


def _left_out(toml: TomlFile, name: str, letter: str, section: dict) -> tuple[str, ...]:
    """`left_out = ["EAX"]`: measured, and within the uncertainty of the measurement."""
    said = section.get("left_out", [])
    names = [f"{component}{letter}" for component in COMPONENTS]
    if not isinstance(said, list) or not all(one in names for one in said):
        raise toml.fault(
            name,
            "left_out",
            f"left_out = {said!r}",
            f"components that were measured and not written: {', '.join(names)}",
        )
    return tuple(said)


def _table_path(toml: TomlFile, name: str, value: Any, key: str) -> Path:
    if not isinstance(value, str):
        raise toml.fault(name, key, f"{key} = {value!r} is not a text")
    path = _own(toml, name, key, value)
    if not path.is_file():
        raise toml.fault(name, key, f"there is no table {path}")
    return path


def _own(toml: TomlFile, section: str, key: str, name: str, index: int = 0) -> Path:
    """A file of the machine's folder. Raises MachineError for one that lies elsewhere: a machine
    comes from a stranger as well, and may name no other file of this computer."""
    path = intake.inside(toml.path.parent, name)
    if path is None:
        raise toml.fault(
            section,
            key,
            f"{key} = {name!r} leads out of the machine's folder",
            "copy the file into the folder, and name it without a path",
            index,
        )
    return path


def _counted(path: Path, most: int, digest: Any) -> Path:
    """The same path, its bytes in the digest of the map. Raises MachineError for too many."""
    digest.update(intake.whole(path, most, MachineError))
    return path


def _grids(
    toml: TomlFile, name: str, letter: str, section: dict, digest, limits: Limits
) -> tuple[GridTable, ...]:
    """`by = { X = "Z_by_X.csv" }`: what of Z depends on X too."""
    by = section.get("by", {})
    if not isinstance(by, dict):
        raise toml.fault(name, "by", f"by = {by!r}", 'like by = { X = "Z_by_X.csv" }')
    grids = []
    for other, value in by.items():
        if other not in tuple(LINEAR + ROTARY) or other == letter:
            raise toml.fault(name, "by", f"by names {other!r}, which is no other axis")
        path = _table_path(toml, name, value, "by")
        _counted(path, intake.TABLE, digest)
        grids.append(read_grid(path, letter, other, limits.max_slope))
    return tuple(grids)


def _centre(toml: TomlFile, name: str, letter: str, section: dict) -> np.ndarray:
    """(3,) mm: a point on the line of a rotary axis."""
    centre = section.get("centre", {})
    if "centre" in section and letter not in ROTARY:
        raise toml.fault(name, "centre", f"{letter} is a linear axis and has no centre")
    if not isinstance(centre, dict) or not all(x in XYZ for x in centre):
        raise toml.fault(
            name,
            "centre",
            f"centre = {centre!r}",
            "like centre = { X = 200.0, Y = 150.0, Z = 0.0 }",
        )
    return np.array([toml.number(name, centre, x, 0.0, at="centre") for x in XYZ])


def _control_tables(toml: TomlFile, digest) -> tuple[ControlTable, ...]:
    """[[control_table]]: tables of the control itself, and whether the map was measured with
    them."""
    entries = toml.data.get("control_table", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise toml.fault(
            "", "control_table", "control tables are sections [[control_table]], with two brackets"
        )
    result = []
    for i, entry in enumerate(entries):
        toml.check_keys("control_table", entry, KEYS["control_table"], i)
        measured, active = entry.get("measured"), entry.get("active", True)
        if measured not in ("on", "off") or not isinstance(active, bool):
            raise toml.fault(
                "control_table",
                "measured",
                f"measured = {measured!r}, active = {active!r}",
                'was the map measured with this table "on" or "off"? and is it active (true or'
                " false) at work?",
                i,
            )
        files = {}
        for key in ("file", "settings"):
            if key in entry:
                value = toml.string("control_table", entry, key, index=i)
                path = _own(toml, "control_table", key, value, i)
                if not path.is_file():
                    raise toml.fault("control_table", key, f"there is no file {path}", index=i)
                _counted(path, intake.CONTROL_TABLE, digest)
                files[key] = path
        if "file" not in files and (measured == "on") != active:
            raise toml.fault(
                "control_table",
                "control",
                "what this table does is not known",
                "file = the table's file",
                i,
            )
        more = entry.get("set", {})
        if not isinstance(more, dict):
            raise toml.fault(
                "control_table", "set", f"set = {more!r}", 'like set = { type = "1" }', i
            )
        control = toml.string("control_table", entry, "control", index=i)
        axis = toml.string("control_table", entry, "axis", "", i)
        result.append(
            ControlTable(
                control,
                files.get("file"),
                files.get("settings"),
                measured == "on",
                active,
                axis,
                {k: str(v) for k, v in more.items()},
            )
        )
    return tuple(result)


def _offsets(toml: TomlFile, axes: dict[str, Axis]) -> dict[str, dict[str, float]]:
    offsets = {}
    for name, values in toml.table("offsets").items():
        if not re.fullmatch(r"G5[4-9](\.[123])?|T\d{4}", name) or not isinstance(values, dict):
            raise toml.fault(
                "offsets",
                name,
                f"{name!r} is not a work or tool offset",
                "like G54 = { X = 0.0, Z = 0.0 }",
            )
        for x in values:
            if x not in axes:
                raise toml.fault(
                    "offsets", name, f"{name} names {x!r}, which is no axis of the machine"
                )
        offsets[name] = {x: toml.number("offsets", values, x, at=name) for x in values}
    return offsets
