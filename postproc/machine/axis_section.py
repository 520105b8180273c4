"""One section [axes.X] of machine.toml to an axis, with the CSV tables that it names."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from postproc import intake
from postproc.errors import MachineError
from postproc.machine import chain as chains
from postproc.machine.axis import Axis
from postproc.machine.axis_file import over_turns, read_grid, read_table, read_uncertainty
from postproc.machine.chain import LINEAR, OPTICS, ROTARY, SECOND, XYZ
from postproc.machine.heat_file import heat
from postproc.machine.model import Limits
from postproc.machine.tables import COMPONENTS, GridTable
from postproc.machine.toml_file import TomlFile

KEYS = {
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
}
UNCERTAINTY = "_uncertainty.csv"  # behind the axis' letter


def read_axis(
    toml: TomlFile, letter: str, section: Any, digest, limits: Limits, chain: chains.Chain
) -> Axis:
    """Its tables' bytes go into the digest of the map. Raises MachineError with the line of what is
    not as the format says."""
    name = f"axes.{letter}"
    if letter not in tuple(LINEAR + ROTARY) or not isinstance(section, dict):
        raise toml.fault(name, "", f"[{name}]: an axis is one of X Y Z A B C U V W")
    toml.check_keys(name, section, KEYS)
    travel = _travel(toml, name, section)
    for key in ("max_velocity", "max_acceleration", "max_jerk"):
        if toml.number(name, section, key, 1.0) <= 0:
            raise toml.fault(name, key, f"{key} = {section[key]!r} is not above zero")
    least = _least_increment(toml, name, section)
    measured = _measured_at(toml, name, letter, section, chain)
    table = None
    if "table" in section:
        path = _table_path(toml, name, section["table"], "table")
        digest.update(intake.whole(path, intake.TABLE, MachineError))
        table = read_table(path, letter, limits.max_slope)
        if letter in ROTARY:
            table = over_turns(table, *travel, path)
    uncertainty = None
    path = toml.own(name, "table", f"{letter}{UNCERTAINTY}")
    if path.is_file():
        digest.update(intake.whole(path, intake.TABLE, MachineError))
        uncertainty = read_uncertainty(path, letter, travel, table)
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
        travel,
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


def _travel(toml: TomlFile, name: str, section: dict) -> tuple[float, float]:
    travel = section.get("travel")
    if travel is None:
        raise toml.fault(
            name, "travel", f"travel is missing in [{name}]", "two ascending numbers, mm"
        )
    good = isinstance(travel, list) and len(travel) == 2 and all(map(intake.finite, travel))
    if not good or travel[0] >= travel[1]:
        raise toml.fault(name, "travel", f"travel = {travel!r} must be two ascending numbers, mm")
    return float(travel[0]), float(travel[1])


def _least_increment(toml: TomlFile, name: str, section: dict) -> float:
    """mm. Raises MachineError where it is no power of ten."""
    least = toml.number(name, section, "least_increment")
    if not 1e-6 <= least <= 0.1 or abs(math.log10(least) - round(math.log10(least))) > 1e-9:
        raise toml.fault(
            name,
            "least_increment",
            f"least_increment = {least!r}",
            "a power of ten from 0.000001 to 0.1, mm",
        )
    return least


def _measured_at(
    toml: TomlFile, name: str, letter: str, section: dict, chain: chains.Chain
) -> np.ndarray:
    """(3,) mm: where the other axes stood, by direction; of two slides of one direction, those that
    the axis carries."""
    at = section.get("measured_at", {})
    if not isinstance(at, dict):
        raise toml.fault(name, "measured_at", f"measured_at = {at!r} must be like {{ X = 0.0 }}")
    if strange := [key for key in at if key not in LINEAR]:
        raise toml.fault(
            name, "measured_at", f"measured_at names {strange[0]!r}, which is no linear axis"
        )
    carried = chain.axes[chain.axes.index(letter) + 1 :] if letter in chain.axes else ()
    stood = {x: toml.number(name, at, x, 0.0, at="measured_at") for x in LINEAR}

    def along(x: str) -> float:
        if SECOND[x] not in chain.axes:
            return stood[x]
        return sum(stood[y] for y in (x, SECOND[x]) if y in carried)

    return np.array(list(map(along, XYZ)))  # fmt: skip


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
    path = toml.own(name, key, value)
    if not path.is_file():
        raise toml.fault(name, key, f"there is no table {path}")
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
        digest.update(intake.whole(path, intake.TABLE, MachineError))
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
