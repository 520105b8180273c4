"""machines/<name>/ to Machine: machine.toml and one CSV table per moving axis (format
gcomp-machine/1).

Reads strictly: a machine file is trusted with somebody's part. Every complaint names file and line.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np

from postproc import intake
from postproc.errors import MachineError, Place
from postproc.machine import chain as chains
from postproc.machine.angle_file import location, squareness, squareness_u
from postproc.machine.axis import Axis
from postproc.machine.axis_file import grid_over_turns
from postproc.machine.axis_section import UNCERTAINTY, read_axis
from postproc.machine.chain import LINEAR, ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.stated import ControlTable, EffectTerm, Limits
from postproc.machine.toml_file import Section, TomlFile
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
VERIFIED = "has a measurement after compensation shown them? unverified or verified"


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
    top = toml.top
    top.check_keys(KEYS[""])
    if top.string("format") != FORMAT:
        raise top.fault("format", f"format is {top['format']!r}, not {FORMAT!r}")
    try:
        chain = chains.parse(top.string("chain"))
    except ValueError as error:
        raise top.fault("chain", str(error)) from None
    # The digest is of all bytes that the map is made of: this text, each table that it names and
    # each file of a control table. Eight of its digits stand in every corrected program, and tell
    # with which map it was corrected.
    digest = hashlib.sha256(toml.text.encode())
    limits, axes = _axes(toml, chain, digest)
    _check_uncertainties(folder, axes)
    diameter = _diameter(top, axes)
    tool = toml.section("tool")
    tool.check_keys(KEYS["tool"])
    return Machine(
        name=top.string("name", folder.name), title=top.string("title", ""),
        control=top.string("control"), chain=chain, axes=axes, diameter=diameter,
        square=squareness(toml, axes), tool=np.array([tool.number(x, 0.0) for x in XYZ]),
        control_tables=_control_tables(toml, digest), offsets=_offsets(toml, axes), limits=limits,
        effects=_effects(toml, axes), source=top.string("source", ""),
        digest=digest.hexdigest()[:8],
        reversal=_one_of(top, "reversal", "step", REVERSALS, f"one of {', '.join(REVERSALS)}"),
        home=_home(top, axes), square_u=squareness_u(toml, axes),
        signs=_one_of(top, "signs", "", ("", *SIGNS), VERIFIED), tool_stated="tool" in top,
        tool_point=read_tool_point(toml),
        square_stated=tuple(name for name in toml.section("squareness").data if name != "u"),
    )  # fmt: skip


def _effects(toml: TomlFile, axes: dict[str, Axis]) -> tuple[EffectTerm, ...]:
    """The terms of [[effect]]: most machines have none, and need none of their modules."""
    if "effect" not in toml.data:
        return ()
    from postproc.machine.effect_file import read_effects

    return read_effects(toml, axes)


def _one_of(section: Section, key: str, default: str, known: Collection[str], advice: str) -> str:
    """A text that is one of those known. Raises MachineError."""
    said = section.string(key, default)
    if said not in known:
        raise section.fault(key, f"{key} = {said!r}", advice)
    return said


def _check_uncertainties(folder: Path, axes: dict[str, Axis]) -> None:
    """Raises MachineError for a table of uncertainty that belongs to no axis."""
    for path in sorted(folder.iterdir()):
        if path.name.endswith(UNCERTAINTY) and path.name.removesuffix(UNCERTAINTY) not in axes:
            raise MachineError(
                f"{path.name} is of no axis of the machine",
                f"axes: {' '.join(axes)}",
                Place(str(path), 1),
            )


def _diameter(top: Section, axes: dict[str, Axis]) -> tuple[str, ...]:
    """Axes whose words are diameters. Raises MachineError."""
    diameter = top.get("diameter", [])
    if not isinstance(diameter, list) or not all(
        isinstance(d, str) and d in axes for d in diameter
    ):
        raise top.fault("diameter", f"diameter = {diameter!r} must list axes of the machine")
    return tuple(diameter)


def _axes(
    toml: TomlFile, chain: chains.Chain, digest: hashlib._Hash
) -> tuple[Limits, dict[str, Axis]]:
    """[limits], which hold for every table, and the [axes.X] sections, all of the chain. Tables are
    added to digest."""
    sections = toml.data.get("axes")
    if not isinstance(sections, dict) or not sections:
        raise Section(toml, "axes", {}).fault("", "no [axes.X] sections")
    limits = _limits(toml)
    # The order of the file's sections means nothing: rows of all (A, N) arrays are X Y Z A B C U V
    # W. An unknown name comes first (find gives -1), and read_axis refuses it.
    order = sorted(sections, key=(XYZ + ROTARY + "UVW").find)
    axes = {x: read_axis(toml, x, sections[x], digest, limits, chain) for x in order}
    if absent := [x for x in chain.axes if x not in axes]:
        x = absent[0]
        raise toml.top.fault("chain", f"the chain names {x}, and there is no [axes.{x}]")
    _check_axes(toml, chain, axes)
    for x, axis in axes.items():
        by = Section(toml, f"axes.{x}", sections[x])
        turned = [grid_over_turns(g, axes, by.own("by", by["by"][g.other])) for g in axis.grids]
        axes[x] = replace(axis, grids=tuple(turned))
    return limits, location(toml, axes)


def _check_axes(toml: TomlFile, chain: chains.Chain, axes: dict[str, Axis]) -> None:
    """Raises MachineError for a slide, or a table, that is not in the chain, and for a grid by
    what is no axis."""
    for x, axis in axes.items():
        # A rotary axis beside the chain is allowed while it has no errors: a spindle's C, or an
        # indexer whose words pass through.
        if x not in chain.axes and (x in LINEAR or axis.table is not None or axis.grids):
            chained = toml.data["chain"]
            raise Section(toml, f"axes.{x}", {}).fault(
                "travel", f"axis {x} is not in the chain {chained}"
            )
        if strange := [grid.other for grid in axis.grids if grid.other not in axes]:
            raise Section(toml, f"axes.{x}", {}).fault(
                "by", f"by names {strange[0]}, which is no axis of the machine"
            )


def _home(top: Section, axes: dict[str, Axis]) -> dict[str, float]:
    """`home = { X = 0.0, Y = 0.0, Z = 0.0 }`: where the slides stand after homing, mm, radius."""
    home = top.get("home", {})
    if not isinstance(home, dict):
        raise top.fault("home", f"home = {home!r}", "like home = { X = 0.0, Y = 0.0, Z = 0.0 }")
    for x in home:
        if x not in axes:
            raise top.fault("home", f"home names {x!r}, which is no axis of the machine")
    return {x: top.number(x, at="home") for x in home}


def _limits(toml: TomlFile) -> Limits:
    section = toml.section("limits")
    section.check_keys(KEYS["limits"])
    outside = _one_of(section, "outside", "error", ("error", "clamp"), 'it is "error" or "clamp"')
    slope = section.number("max_slope", Limits.max_slope)
    hysteresis = section.number("hysteresis_um", Limits.hysteresis / UM) * UM
    if hysteresis < 0:
        raise section.fault(
            "hysteresis_um",
            f"hysteresis_um = {section['hysteresis_um']!r} is below zero",
            "by how much a slide turns back before its lost motion is taken up, um",
        )
    return Limits(
        section.number("max_correction", Limits.max_correction),
        # the slope limit finds slips of the pen: mm entered for um are a thousand times too steep
        math.inf if section.flag("accept_slope") else slope,
        outside,
        hysteresis,
    )


def _control_tables(toml: TomlFile, digest: hashlib._Hash) -> tuple[ControlTable, ...]:
    """[[control_table]]: tables of the control itself, and whether the map was measured with
    them."""
    entries = toml.sections("control_table", "control tables")
    return tuple(_control_table(entry, digest) for entry in entries)


def _control_table(entry: Section, digest: hashlib._Hash) -> ControlTable:
    """One of them. Its files are added to digest."""
    entry.check_keys(KEYS["control_table"])
    measured, active = entry.get("measured"), entry.get("active", True)
    if measured not in ("on", "off") or not isinstance(active, bool):
        raise entry.fault(
            "measured",
            f"measured = {measured!r}, active = {active!r}",
            'was the map measured with this table "on" or "off"? and is it active (true or'
            " false) at work?",
        )
    files = {k: _control_file(entry, k, digest) for k in ("file", "settings") if k in entry}
    # Measured with the table and at work with it, or neither: the map is right as it is, and what
    # the table does need not be known. Otherwise it has to be added to the map or taken out of it.
    if "file" not in files and (measured == "on") != active:
        message = "what this table does is not known"
        raise entry.fault("control", message, "file = the table's file")
    more = entry.get("set", {})
    if not isinstance(more, dict):
        raise entry.fault("set", f"set = {more!r}", 'like set = { type = "1" }')
    return ControlTable(
        entry.string("control"), files.get("file"), files.get("settings"), measured == "on", active,
        entry.string("axis", ""), {k: str(v) for k, v in more.items()},
    )  # fmt: skip


def _control_file(entry: Section, key: str, digest: hashlib._Hash) -> Path:
    path = entry.own(key, entry.string(key))
    if not path.is_file():
        raise entry.fault(key, f"there is no file {path}")
    digest.update(intake.whole(path, intake.CONTROL_TABLE, MachineError))
    return path


def _offsets(toml: TomlFile, axes: dict[str, Axis]) -> dict[str, dict[str, float]]:
    offsets, section = {}, toml.section("offsets")
    for name, values in section.data.items():
        if not re.fullmatch(r"G5[4-9](\.[123])?|T\d{4}", name) or not isinstance(values, dict):
            raise section.fault(
                name, f"{name!r} is not a work or tool offset", "like G54 = { X = 0.0, Z = 0.0 }"
            )
        for x in values:
            if x not in axes:
                raise section.fault(name, f"{name} names {x!r}, which is no axis of the machine")
        offsets[name] = {x: section.number(x, at=name) for x in values}
    return offsets
