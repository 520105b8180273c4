"""One section [axes.X] of machine.toml to an axis, with the CSV tables that it names."""

from __future__ import annotations

import hashlib
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
from postproc.machine.stated import Limits
from postproc.machine.tables import COMPONENTS, GridTable
from postproc.machine.toml_file import Section, TomlFile

KEYS = {
    "travel", "least_increment", "table", "measured_at", "max_velocity", "max_acceleration",
    "max_jerk", "centre", "optic", "by", "heat", "left_out",
}  # fmt: skip
UNCERTAINTY = "_uncertainty.csv"  # behind the axis' letter


def read_axis(
    toml: TomlFile,
    letter: str,
    data: Any,
    digest: hashlib._Hash,
    limits: Limits,
    chain: chains.Chain,
) -> Axis:
    """Its tables' bytes go into the digest of the map. Raises MachineError with the line of what is
    not as the format says."""
    section = Section(toml, f"axes.{letter}", data)
    if letter not in tuple(LINEAR + ROTARY):
        raise section.fault("", f"[{section.name}]: an axis is one of X Y Z A B C U V W")
    if not isinstance(data, dict):
        raise section.fault("", f"{section.name} = {data!r} must be a section [{section.name}]")
    section.check_keys(KEYS)
    travel = _travel(section)
    for key in ("max_velocity", "max_acceleration", "max_jerk"):
        if section.number(key, 1.0) <= 0:
            raise section.fault(key, f"{key} = {section[key]!r} is not above zero")
    least = _least_increment(section)
    measured = _measured_at(section, letter, chain)
    table = None
    if "table" in section:
        path = _table_path(section, section["table"], "table")
        # The bytes, not the numbers: a comment that is changed is another map as well, which is
        # never wrong and needs no rule about what counts.
        digest.update(intake.whole(path, intake.TABLE, MachineError))
        table = read_table(path, letter, limits.max_slope)
        if letter in ROTARY:
            table = over_turns(table, *travel, path)
    uncertainty = None
    path = section.own("table", f"{letter}{UNCERTAINTY}")
    if path.is_file():
        digest.update(intake.whole(path, intake.TABLE, MachineError))
        uncertainty = read_uncertainty(path, letter, travel, table)
    optic = section.string("optic", "")
    if optic not in ("", *OPTICS):
        raise section.fault(
            "optic", f"optic = {optic!r}", "what the measured point was fixed to: tool or workpiece"
        )
    return Axis(
        letter, travel, least, measured, table, optic, _centre(section, letter),
        grids=_grids(section, letter, digest, limits), expansion=heat(section),
        uncertainty=uncertainty, left_out=_left_out(section, letter),
        centre_stated=tuple(section.get("centre", {})),
        # mm/min in the file, mm/s inside
        velocity=section.number("max_velocity", 0.0) / 60.0,
    )  # fmt: skip


def _travel(section: Section) -> tuple[float, float]:
    if "travel" not in section:
        message = f"travel is missing in [{section.name}]"
        raise section.fault("travel", message, "two ascending numbers, mm")
    return section.span("travel", section["travel"])


def _least_increment(section: Section) -> float:
    """mm. Raises MachineError where it is no power of ten."""
    least = section.number("least_increment")
    # A word has so many decimals, and rounding to them is rounding to the increment; 0.0005 would
    # need a rounding of its own.
    if not 1e-6 <= least <= 0.1 or abs(math.log10(least) - round(math.log10(least))) > 1e-9:
        raise section.fault(
            "least_increment",
            f"least_increment = {least!r}",
            "a power of ten from 0.000001 to 0.1, mm",
        )
    return least


def _measured_at(section: Section, letter: str, chain: chains.Chain) -> np.ndarray:
    """(3,) mm: where the other axes stood, by direction; of two slides of one direction, those that
    the axis carries."""
    at = section.get("measured_at", {})
    if not isinstance(at, dict):
        raise section.fault("measured_at", f"measured_at = {at!r} must be like {{ X = 0.0 }}")
    if strange := [key for key in at if key not in LINEAR]:
        raise section.fault(
            "measured_at", f"measured_at names {strange[0]!r}, which is no linear axis"
        )
    carried = chain.axes[chain.axes.index(letter) + 1 :] if letter in chain.axes else ()
    stood = {x: section.number(x, 0.0, at="measured_at") for x in LINEAR}

    def along(x: str) -> float:
        if SECOND[x] not in chain.axes:
            return stood[x]
        # Quill W on head Z: an angle of X, which carries both, acts on the sum of both places; an
        # angle of Z on W alone, which is what Z carries.
        return sum(stood[y] for y in (x, SECOND[x]) if y in carried)

    return np.array(list(map(along, XYZ)))  # fmt: skip


def _left_out(section: Section, letter: str) -> tuple[str, ...]:
    """`left_out = ["EAX"]`: measured, and within the uncertainty of the measurement."""
    said = section.get("left_out", [])
    names = [f"{component}{letter}" for component in COMPONENTS]
    if not isinstance(said, list) or not all(one in names for one in said):
        raise section.fault(
            "left_out",
            f"left_out = {said!r}",
            f"components that were measured and not written: {', '.join(names)}",
        )
    return tuple(said)


def _table_path(section: Section, value: Any, key: str) -> Path:
    if not isinstance(value, str):
        raise section.fault(key, f"{key} = {value!r} is not a text")
    path = section.own(key, value)
    if not path.is_file():
        raise section.fault(key, f"there is no table {path}")
    return path


def _grids(
    section: Section, letter: str, digest: hashlib._Hash, limits: Limits
) -> tuple[GridTable, ...]:
    """`by = { X = "Z_by_X.csv" }`: what of Z depends on X too."""
    by = section.get("by", {})
    if not isinstance(by, dict):
        raise section.fault("by", f"by = {by!r}", 'like by = { X = "Z_by_X.csv" }')
    grids = []
    for other, value in by.items():
        if other not in tuple(LINEAR + ROTARY) or other == letter:
            raise section.fault("by", f"by names {other!r}, which is no other axis")
        path = _table_path(section, value, "by")
        digest.update(intake.whole(path, intake.TABLE, MachineError))
        grids.append(read_grid(path, letter, other, limits.max_slope))
    return tuple(grids)


def _centre(section: Section, letter: str) -> np.ndarray:
    """(3,) mm: a point on the line of a rotary axis."""
    centre = section.get("centre", {})
    if "centre" in section and letter not in ROTARY:
        raise section.fault("centre", f"{letter} is a linear axis and has no centre")
    if not isinstance(centre, dict) or not all(x in XYZ for x in centre):
        raise section.fault(
            "centre", f"centre = {centre!r}", "like centre = { X = 200.0, Y = 150.0, Z = 0.0 }"
        )
    return np.array([section.number(x, 0.0, at="centre") for x in XYZ])
