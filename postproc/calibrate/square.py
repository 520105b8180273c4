"""Squareness: its signs, and how it comes out of straightness readings or diagonals. The only place
of its conventions.

C0Y, A0Z, B0X: a small rotation c about the first letter (right-handed) that the axis of the last
letter has too much. A point at q of that axis deviates by c x q u. So for B0X > 0 the X axis leans
to -Z, for C0Y > 0 Y leans to -X, for A0Z > 0 Z leans to -Y (the angle is more than 90 degrees); for
B0Z, C0X and A0Y > 0 it is less.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from postproc.calibrate import CalibrationError
from postproc.machine.chain import ROTARY, XYZ

DEFAULT = {"XY": "C0Y", "YZ": "A0Z", "XZ": "B0Z"}
NAMES = ("C0X", "C0Y", "A0Y", "A0Z", "B0X", "B0Z")


@dataclass(frozen=True)
class Squareness:
    """value, u: rad (u None: not known); source: where it comes from."""

    name: str
    value: float
    u: float | None
    source: str
    remark: str = ""


def pair_of(name: str) -> str:
    """The two axes of a squareness, in the order X Y Z: "XZ" of B0X."""
    return "".join(x for x in XYZ if x != XYZ[ROTARY.index(name[0])])


def other_of(name: str) -> str:
    """The axis that does not lean: Z of B0X. Deviations lie along it."""
    return pair_of(name).replace(name[2], "")


def sign(name: str) -> int:
    """+1 or -1: the deviation along the other axis is sign * value * position of the axis that
    leans.

    It is the component of (unit vector of the rotation) x (unit vector of the leaning axis).
    """
    #      leaning Y  nominal Y       C0Y > 0: Y is turned by it about Z, from X towards Y, and so
    #             \   |               leans to -X. A point at q of Y lies C0Y q to the left of where
    #         C0Y  \__|  q            it should: sign("C0Y") is -1. By the cross product of unit
    #               \ |               vectors z x y = -x.
    #                \|______ X
    turn, leans, other = ROTARY.index(name[0]), XYZ.index(name[2]), XYZ.index(other_of(name))
    unit = np.eye(3)
    return int(np.cross(unit[turn], unit[leans])[other])


def name_for(pair: str, wanted: Mapping[str, object], axes: tuple[str, ...]) -> str:
    """What the squareness of a pair is called: as the user names it; else X leans on a machine of X
    and Z alone, where Z is the primary axis, and the later axis of the pair on others."""
    for name in wanted:
        if name in NAMES and pair_of(name) == pair:
            return name
    # the thesis' grinder and lathes: Z is the primary axis, X leans (contract of a machine)
    return "B0X" if pair == "XZ" and "Y" not in axes else DEFAULT[pair]


def from_slopes(name: str, slopes: Mapping[str, float]) -> float:
    """rad: from the slopes of both straightnesses of a pair against one reference square, {"EZX":
    .., "EXZ": ..} rad.

    A reference that is turned gives both slopes the same amount with opposite signs, so their sum
    is the machine's: with B0X, EZX has the slope -B0X. The square's own angle over 90 degrees goes
    into `from_square`.
    """
    #     against a square that lies turned by t        C0Y = sign * (EXY's slope + EYX's slope)
    #     EYX reads  e + t    (Y beside X's way)        t, which is nobody's error, drops out of
    #     EXY reads  f - t    (X beside Y's way)        the sum: e + f
    a, b = tuple(pair_of(name))
    return sign(name) * (slopes[f"E{a}{b}"] + slopes[f"E{b}{a}"])


def with_square(name: str, value: float, over: float) -> float:
    """rad: the squareness where the square's own angle is 90 degrees + `over` rad.

    Axes that follow the arms of such a square read as true and have its angle, which is C0Y, A0Z,
    B0X = +over.
    """
    return value - sign(name) * over


def from_diagonals(
    slopes: Sequence[float],
    directions: Sequence[Mapping[str, float]],
    u: Sequence[float],
    names: Sequence[str],
) -> tuple[dict[str, float], dict[str, float], float]:
    """Squareness and scale from the slopes of diagonals: rad by name, u by name, and the scale
    common to all axes.

    slopes: of reading over length, after everything else that is known was taken off; directions:
    axis to cosine. Along direction c a squareness adds sign * value * c_other * c_leaning, a scale
    error of all axes adds itself. ISO 230-6 measures them. Raises CalibrationError where there are
    too few diagonals.
    """
    terms = np.ones((len(slopes), len(names) + 1))
    for i, c in enumerate(directions):
        for j, name in enumerate(names):
            # At s along the diagonal the leaning axis stands at s c_leaning; the deviation lies
            # along the other and shows with its cosine: sign value c_leaning c_other per mm.
            terms[i, j] = sign(name) * c.get(other_of(name), 0.0) * c.get(name[2], 0.0)
    rank = np.linalg.matrix_rank(terms, tol=1e-6)
    if rank < terms.shape[1]:
        raise CalibrationError(
            f"{len(slopes)} diagonal{'s' if len(slopes) > 1 else ''} can not separate"
            f" {', '.join(names)} from a scale error of all axes",
            "measure both diagonals of each plane, or all four of the space",
        )
    solve = np.linalg.pinv(terms)
    found = solve @ np.array(slopes)
    spread = np.sqrt(solve**2 @ np.array(u) ** 2)
    return (
        dict(zip(names, found, strict=False)),
        dict(zip(names, spread, strict=False)),
        float(found[-1]),
    )
