"""Angles and places of axes to each other in machine.toml: squareness with its U, and where rotary
axes lie."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from postproc.machine.axis import Axis
from postproc.machine.chain import ROTARY, XYZ, along
from postproc.machine.toml_file import Section, TomlFile
from postproc.units import UM, URAD


def location(toml: TomlFile, axes: dict[str, Axis]) -> dict[str, Axis]:
    """[location]: how the line of a rotary axis lies beside the nominal one, `X0C_um = 12.0` (ISO
    230-7, ISO 10791-6)."""
    location = toml.section("location")
    known = {
        f"{d}0{x}_um" for x in axes if x in ROTARY for d in XYZ if XYZ.index(d) != ROTARY.index(x)
    }
    location.check_keys(known)
    result = dict(axes)
    for key in location.data:
        x = key[2]
        place = result[x].location.copy()
        place[XYZ.index(key[0])] = location.number(key) * UM
        result[x] = replace(result[x], location=place)
    return result


def squareness(toml: TomlFile, axes: dict[str, Axis]) -> dict[str, np.ndarray]:
    """[squareness]: axis that leans to (3,) rad."""
    square: dict[str, np.ndarray] = {}
    # "u" is the section [squareness.u], not an angle
    stated = {name: v for name, v in toml.section("squareness").data.items() if name != "u"}
    for name, value in _angles(toml.section("squareness", stated), axes).items():
        if value:
            square.setdefault(name[2], np.zeros(3))[ROTARY.index(name[0])] = value
    return square


def squareness_u(toml: TomlFile, axes: dict[str, Axis]) -> dict[str, float]:
    """[squareness.u]: name to U (95 %, k = 2), rad."""
    square = toml.section("squareness")
    data = square.get("u", {})
    if not isinstance(data, dict):
        raise square.fault("u", f"u = {data!r}", "a section [squareness.u] of the same names, urad")
    section = toml.section("squareness.u", data)
    found = _angles(section, axes)
    for name, value in found.items():
        if value < 0:
            message = f"{name} = {data[name]!r} is below zero"
            raise section.fault(name, message, "U is zero or more, urad")
    return found


def _angles(section: Section, axes: dict[str, Axis]) -> dict[str, float]:
    """Names of squareness to rad."""
    for name in section.data:
        # B0X: the turn about Y by which X leans. A turn about the axis' own direction (A0X, C0C)
        # changes nothing about where it points, and is refused.
        own = re.fullmatch(r"[ABC]0[XYZABCUVW]", name) and name[2] in axes
        if not own or ROTARY.index(name[0]) == (
            ROTARY.index(name[2]) if name[2] in ROTARY else along(name[2])
        ):
            raise section.fault(
                name,
                f"{name!r} is not a squareness of this machine",
                "rotation, 0, axis that leans: B0X, C0Y, A0Z",
            )
    return {name: section.number(name) * URAD for name in section.data}
