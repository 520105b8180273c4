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
from postproc.machine.axis import Axis
from postproc.machine.axis_section import UNCERTAINTY, read_axis
from postproc.machine.chain import LINEAR, ROTARY, XYZ
from postproc.machine.effect_file import read_effects
from postproc.machine.model import ControlTable, Limits, Machine
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
    "control_table": {"control", "file", "settings", "measured", "active", "axis", "set"},
    "tool": set(XYZ),
    "limits": {"max_correction", "max_slope", "outside", "accept_slope", "hysteresis_um"},
}
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
    digest = hashlib.sha256(toml.text.encode())
    limits, axes = _axes(toml, chain, digest)
    _check_uncertainties(folder, axes)
    diameter = _diameter(toml, axes)
    tool = toml.table("tool")
    toml.check_keys("tool", tool, KEYS["tool"])
    return Machine(
        name=toml.string("", data, "name", folder.name),
        title=toml.string("", data, "title", ""),
        control=toml.string("", data, "control"),
        chain=chain,
        axes=axes,
        diameter=diameter,
        square=squareness(toml, axes),
        tool=np.array([toml.number("tool", tool, x, 0.0) for x in XYZ]),
        control_tables=_control_tables(toml, digest),
        offsets=_offsets(toml, axes),
        limits=limits,
        effects=read_effects(toml, axes),
        source=toml.string("", data, "source", ""),
        digest=digest.hexdigest()[:8],
        reversal=_reversal(toml),
        home=_home(toml, axes),
        square_u=squareness_u(toml, axes),
        signs=_signs(toml),
        tool_stated="tool" in data,
        tool_point=read_tool_point(toml),
        square_stated=tuple(name for name in toml.table("squareness") if name != "u"),
    )


def _reversal(toml: TomlFile) -> str:
    reversal = toml.string("", toml.data, "reversal", "step")
    if reversal not in REVERSALS:
        known = f"one of {', '.join(REVERSALS)}"
        raise toml.fault("", "reversal", f"reversal = {reversal!r}", known)
    return reversal


def _signs(toml: TomlFile) -> str:
    signs = toml.string("", toml.data, "signs", "")
    if signs not in ("", *SIGNS):
        raise toml.fault(
            "",
            "signs",
            f"signs = {signs!r}",
            "has a measurement after compensation shown them? unverified or verified",
        )
    return signs


def _check_uncertainties(folder: Path, axes: dict[str, Axis]) -> None:
    """Raises MachineError for a table of uncertainty that belongs to no axis."""
    for path in sorted(folder.glob(f"*{UNCERTAINTY}")):
        if path.name.removesuffix(UNCERTAINTY) not in axes:
            raise MachineError(
                f"{path.name} is of no axis of the machine",
                f"axes: {' '.join(axes)}",
                Place(str(path), 1),
            )


def _diameter(toml: TomlFile, axes: dict[str, Axis]) -> tuple[str, ...]:
    """Axes whose words are diameters. Raises MachineError."""
    diameter = toml.data.get("diameter", [])
    if not isinstance(diameter, list) or not all(
        isinstance(d, str) and d in axes for d in diameter
    ):
        raise toml.fault("", "diameter", f"diameter = {diameter!r} must list axes of the machine")
    return tuple(diameter)


def _axes(toml: TomlFile, chain: chains.Chain, digest) -> tuple[Limits, dict[str, Axis]]:
    """[limits], which hold for every table, and the [axes.X] sections, all of the chain. Tables are
    added to digest."""
    sections = toml.data.get("axes")
    if not isinstance(sections, dict) or not sections:
        raise toml.fault("axes", "", "no [axes.X] sections")
    limits = _limits(toml)
    order = sorted(sections, key=(XYZ + ROTARY + "UVW").find)
    axes = {x: read_axis(toml, x, sections[x], digest, limits, chain) for x in order}
    if absent := [x for x in chain.axes if x not in axes]:
        x = absent[0]
        raise toml.fault("", "chain", f"the chain names {x}, and there is no [axes.{x}]")
    _check_axes(toml, chain, axes)
    return limits, location(toml, axes)


def _check_axes(toml: TomlFile, chain: chains.Chain, axes: dict[str, Axis]) -> None:
    """Raises MachineError for a slide, or a table, that is not in the chain, and for a grid by
    what is no axis."""
    for x, axis in axes.items():
        if x not in chain.axes and (x in LINEAR or axis.table is not None or axis.grids):
            chained = toml.data["chain"]
            raise toml.fault(f"axes.{x}", "travel", f"axis {x} is not in the chain {chained}")
        if strange := [grid.other for grid in axis.grids if grid.other not in axes]:
            raise toml.fault(
                f"axes.{x}", "by", f"by names {strange[0]}, which is no axis of the machine"
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


def _control_tables(toml: TomlFile, digest) -> tuple[ControlTable, ...]:
    """[[control_table]]: tables of the control itself, and whether the map was measured with
    them."""
    entries = toml.data.get("control_table", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise toml.fault(
            "", "control_table", "control tables are sections [[control_table]], with two brackets"
        )
    return tuple(_control_table(toml, entry, i, digest) for i, entry in enumerate(entries))


def _control_table(toml: TomlFile, entry: dict[str, Any], i: int, digest) -> ControlTable:
    """The i-th of them. Its files are added to digest."""
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
    files = {
        key: _control_file(toml, entry, key, i, digest)
        for key in ("file", "settings")
        if key in entry
    }
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
        raise toml.fault("control_table", "set", f"set = {more!r}", 'like set = { type = "1" }', i)
    control = toml.string("control_table", entry, "control", index=i)
    axis = toml.string("control_table", entry, "axis", "", i)
    return ControlTable(
        control,
        files.get("file"),
        files.get("settings"),
        measured == "on",
        active,
        axis,
        {k: str(v) for k, v in more.items()},
    )


def _control_file(toml: TomlFile, entry: dict[str, Any], key: str, i: int, digest) -> Path:
    path = toml.own("control_table", key, toml.string("control_table", entry, key, index=i), i)
    if not path.is_file():
        raise toml.fault("control_table", key, f"there is no file {path}", index=i)
    digest.update(intake.whole(path, intake.CONTROL_TABLE, MachineError))
    return path


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
