"""A machine folder from what a dial gauge, a square, a caliper and a tape tell: squareness, lost
motion, scale.

No tables of recordings: what is not stated is no error here, and `gcomp machines show` lists it.
Conventions: chain.py and square.py; lengths mm, squareness rad, lost motion mm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from postproc.calibrate import CalibrationError, square
from postproc.machine.chain import XYZ
from postproc.machine.stated import Limits
from postproc.machine.write import axis_table, machine_toml
from postproc.units import UM, URAD

# share by which diagonals may miss Pythagoras: a tape reads 1 mm of a metre, a wrong side far more
ALIKE = 0.01
STEEPEST = 0.005  # a screw or belt off by more has wrong steps per mm, which the control is told
USUAL_LIMIT = Limits.max_correction
# mm: 10 mrad on 300 mm, which the eye sees; beyond, a slip is likelier than a machine
LARGEST_LIMIT = 3.0


@dataclass(frozen=True)
class Kind:
    """What machines of a kind share. title: in words; chain: who carries whom; control: the usual
    one."""

    title: str
    chain: str
    control: str
    diameter: tuple[str, ...] = ()


KINDS = {
    "router": Kind("gantry along Y, carriage along X, spindle along Z", "w-b-Y-X-Z-t", "grbl"),
    "mill": Kind("table along X on a saddle along Y, head along Z", "w-X-Y-b-Z-t", "linuxcnc"),
    "lathe": Kind("carriage along Z, cross slide along X", "w-b-Z-X-t", "fanuc-lathe", ("X",)),
    "printer": Kind("bed along Y, gantry along Z, head along X", "w-Y-b-Z-X-t", "marlin"),
    "corexy": Kind("bed along Z, gantry along Y, head along X", "w-Z-b-Y-X-t", "klipper"),
}


@dataclass(frozen=True)
class First:
    """What is known. travel, home: axis to mm; square: name (C0Y) to (rad, how it was found);
    backlash: axis to mm; scale: axis to (commanded mm, measured mm). square_u (rad, by name),
    backlash_u, scale_u (mm, by axis): standard uncertainties, of those that are known."""

    name: str
    title: str
    control: str
    chain: str
    travel: Mapping[str, tuple[float, float]]
    least: float = 0.001
    diameter: tuple[str, ...] = ()
    square: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    backlash: Mapping[str, float] = field(default_factory=dict)
    scale: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    home: Mapping[str, float] = field(default_factory=dict)
    square_u: Mapping[str, float] = field(default_factory=dict)
    backlash_u: Mapping[str, float] = field(default_factory=dict)
    scale_u: Mapping[str, float] = field(default_factory=dict)


def name_of(moving: str, drifts: str) -> str:
    """The squareness of an axis that leans towards another: C0Y of Y and X."""
    turn = next(x for x in XYZ if x not in (moving, drifts))
    return f"{'ABC'[XYZ.index(turn)]}0{moving}"


def from_drift(name: str, drift: float, way: float) -> float:
    """rad: the tool drifts along the other axis by `drift` beside a true square while the one that
    leans goes `way`, mm."""
    return square.sign(name) * drift / way


def from_diagonals(name: str, rising: float, falling: float, sides: tuple[float, float]) -> float:
    """rad: from the diagonals of a rectangle that the machine made, mm: rising, from low to high in
    both axes, and falling.

    With deviation s along the other axis per mm of the one that leans, rising^2 = (a + s b)^2 + b^2
    and falling^2 = (a - s b)^2 + b^2, so s = (rising^2 - falling^2) / (4 a b). Raises
    CalibrationError for what is no rectangle.
    """
    a, b = sides
    #         +-----------+      Of a parallelogram the squares of both diagonals add up to
    #        / rising .'  /      those of all four sides, whatever its angle: a check of the
    #       /     .' '.  / b     lengths in which the squareness has no part.
    #      +-----------+
    #            a
    both = rising**2 + falling**2
    if abs(both - 2 * (a * a + b * b)) > ALIKE * both:
        raise CalibrationError(
            f"a rectangle of {a:g} by {b:g} mm has diagonals of {math.hypot(a, b):.2f} mm, and not"
            f" {rising:g} and {falling:g}",
            "in the order: rising diagonal, falling one, side along the first axis, side along the"
            " second",
        )
    return square.sign(name) * (rising**2 - falling**2) / (4 * a * b)


def u_of_diagonals(rising: float, falling: float, sides: tuple[float, float], u: float) -> float:
    """rad: standard uncertainty of `from_diagonals` where every length has u, mm, of its own (JCGM
    100, 5.1.2)."""
    a, b = sides
    value = (rising**2 - falling**2) / (4 * a * b)
    # d value / d rising, falling, a, b: each length with an error of its own
    slopes = (rising / (2 * a * b), falling / (2 * a * b), value / a, value / b)
    return u * math.hypot(*slopes)


def _squareness(first: First) -> tuple[dict[str, Any], dict[str, str]]:
    """The section, and its comments."""
    data: dict[str, Any] = {
        name: round(value / URAD, 3) for name, (value, _) in first.square.items()
    }
    comments = {
        f"squareness.{name}": f"urad; {how}; {_leans(name)}"
        for name, (_, how) in first.square.items()
    }
    if first.square_u:
        data["u"] = {name: round(2 * u / URAD, 3) for name, u in first.square_u.items()}
        comments |= {f"squareness.u.{name}": "urad, U = 2 u, 95 %" for name in first.square_u}
    return data, comments


def _backlash(first: First, axis: str) -> dict[str, Any]:
    """The section of an axis' lost motion."""
    data = {
        "name": "backlash",
        "axis": axis,
        "size_um": round(first.backlash[axis] / UM, 3),
        "source": "stated by hand, or a ballbar: gcomp machines new",
    }
    if axis in first.backlash_u:
        data["u_size_um"] = round(2 * first.backlash_u[axis] / UM, 3)
    return data


def folder(first: First) -> dict[str, str]:
    """machine.toml and tables, by name. Raises CalibrationError for a scale that no map should
    mend."""
    files: dict[str, str] = {}
    axes: dict[str, dict[str, Any]] = {}
    comments = {
        "": HEAD,
        "chain": "who carries whom, from the workpiece through the bed to the tool",
    }
    for x in sorted(first.travel):
        axes[x] = {"travel": list(map(float, first.travel[x])), "least_increment": first.least}
        comments[f"axes.{x}.travel"] = "mm, places of the slide in machine coordinates"
        comments[f"axes.{x}.least_increment"] = (
            "mm, the smallest step of a word that the control obeys"
        )
        if x in first.scale:
            axes[x]["table"] = f"{x}.csv"
            comments[f"axes.{x}.table"] = "mm it goes too far (+) or too short (-): its scale"
            files[f"{x}.csv"] = _table(x, first)
            if x in first.scale_u:
                files[f"{x}_uncertainty.csv"] = _table(x, first, known=True)
    data: dict[str, Any] = {
        "format": "gcomp-machine/1", "name": first.name, "title": first.title,
        "control": first.control, "chain": first.chain,
        "source": "stated by hand: gcomp machines new", "signs": "unverified",
    }  # fmt: skip
    comments["signs"] = '"verified" once gcomp accept, or a part that was measured, has shown them'
    if first.diameter:
        data["diameter"] = list(first.diameter)
    if first.home:
        data["home"] = dict(first.home)
        comments["home"] = "mm, where the slides stand after homing"
    data["axes"] = axes
    if first.square:
        data["squareness"], said = _squareness(first)
        comments |= said
    most = _largest(first)
    if USUAL_LIMIT < most <= LARGEST_LIMIT:
        # a fifth more than asked for, in whole tenths: what a program meets beside the corners is
        # below it
        data["limits"] = {"max_correction": math.ceil(most * 1.2 * 10) / 10}
        comments["limits.max_correction"] = (
            f"mm; what is stated here asks for up to {most:.2f} mm at the corners"
        )
    if first.backlash:
        data["effect"] = [_backlash(first, x) for x in first.backlash]
    return {"machine.toml": machine_toml(data, comments)} | files


HEAD = """written by gcomp machines new; edit it freely, gcomp machines check NAME says what is doubtful
deviation = actual - commanded, tool against workpiece; axes as in ISO 841; X of a lathe as a radius
work offsets: state [offsets] G54 = { X = .., Y = .., Z = .. } here, or say --offset G54=X..,Y..,Z.."""  # noqa: E501


def _largest(first: First) -> float:
    """mm: the largest correction of an axis that what is stated asks for, all of one sign."""
    total = dict.fromkeys(first.travel, 0.0)
    for name, (value, _) in first.square.items():
        # a lean moves the other axis, by its angle times the place of the axis that leans
        total[square.other_of(name)] += abs(value) * max(map(abs, first.travel[name[2]]))
    for x, (commanded, measured) in first.scale.items():
        low, high = first.travel[x]
        way = max(abs(low), abs(high)) if low <= 0 <= high else high - low
        total[x] += abs(measured - commanded) / commanded * way
    for x, size in first.backlash.items():
        # half of a lost motion lies on each side of the command
        total[x] += abs(size) / 2
    return max(total.values())


def _leans(name: str) -> str:
    other = square.other_of(name)
    return f"above zero {name[2]} leans towards {'-' if square.sign(name) < 0 else '+'}{other}"


def _table(letter: str, first: First, known: bool = False) -> str:
    """E of a scale, zero at position 0, or at the low end; known: its U (95 %)."""
    commanded, measured = first.scale[letter]
    share = (measured - commanded) / commanded
    if abs(share) > STEEPEST:
        raise CalibrationError(
            f"{letter} goes {measured:g} mm for {commanded:g}: {100 * share:+.2f} %, more than"
            f" {100 * STEEPEST:g} %",
            f"set the control's steps per mm to {commanded / measured:.6f} of what they are,"
            " measure again, and state the rest",
        )
    low, high = first.travel[letter]
    # from where a tape or caliper was laid on nothing is known: the scale is zero at the machine's
    # zero
    zero = 0.0 if low <= 0.0 <= high else low
    nodes = np.array(sorted({low, zero, high}))
    if known:
        u = 2 * first.scale_u[letter] / commanded * np.abs(nodes - zero) / UM
        return axis_table(letter, nodes, {f"E{letter}{letter}_um": u}, ("U, 95 % (k = 2)",))
    value = share * (nodes - zero) / UM
    return axis_table(
        letter,
        nodes,
        {f"E{letter}{letter}_um": value},
        (f"{measured:g} mm measured for {commanded:g} mm commanded",),
    )
