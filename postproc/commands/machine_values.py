"""Values of an axis in options, read from text: travel, scale, lost motion, squareness."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

from postproc.calibrate import CalibrationError, first, square
from postproc.machine.chain import XYZ
from postproc.units import URAD


def parts(text: str, like: str, n: int) -> tuple[str, list[float]]:
    """Name and n numbers of "NAME=1,2"; like: an example, for the message. Raises
    ArgumentTypeError, as all functions here."""
    name, _, rest = text.strip().partition("=")
    try:
        numbers = [float(part) for part in rest.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != n or not all(abs(v) < 1e6 for v in numbers):
        raise argparse.ArgumentTypeError(f"{text!r} is not like {like}")
    return name.strip().upper(), numbers


def axis(name: str, text: str) -> str:
    """The letter, if it is one of a slide or a rotary axis."""
    if name not in (*XYZ, "A", "B", "C"):
        raise argparse.ArgumentTypeError(f"{text!r}: {name!r} is no axis")
    return name


def travel(text: str) -> tuple[str, tuple[float, float]]:
    """Axis, and mm from and to."""
    name, (low, high) = parts(text, "X=0,400", 2)
    if low >= high:
        raise argparse.ArgumentTypeError(f"{text!r}: the lower end comes first, X=0,400")
    return axis(name, text), (low, high)


def length_of(text: str) -> tuple[str, float]:
    """Axis, and mm of lost motion."""
    name, (size,) = parts(text, "X=0.05", 1)
    if not -1 <= size <= 2:
        raise argparse.ArgumentTypeError(
            f"{text!r} is {size:g} mm of lost motion: mm are wanted, X=0.05 is 50 um"
        )
    return axis(name, text), size


def scale(text: str) -> tuple[str, tuple[float, float]]:
    """Axis, and mm commanded and measured."""
    name, (commanded, measured) = parts(text, "X=300,300.2", 2)
    if commanded <= 0 or measured <= 0:
        raise argparse.ArgumentTypeError(f"{text!r}: both ways are above zero, X=300,300.2")
    return axis(name, text), (commanded, measured)


Known = Callable[[argparse.Namespace], float | None]  # rad, by what the options say of lengths


def angle(text: str) -> tuple[str, float, str, Known]:
    """Name of a squareness, rad, how it was found, and what tells its standard uncertainty."""
    name, (value,) = parts(text, "C0Y=120", 1)
    if name not in square.NAMES:
        raise argparse.ArgumentTypeError(
            f"{text!r}: {name!r} is not one of {', '.join(square.NAMES)}"
        )
    return name, value * URAD, "stated", lambda options: None


def drift(text: str) -> tuple[str, float, str, Known]:
    """As `angle`, of a drift along a square."""
    names, (size, way) = parts(text, "X/Y=0.05,300", 2)
    drifts, _, moving = names.partition("/")
    if drifts not in tuple(XYZ) or moving not in tuple(XYZ) or drifts == moving or not way:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not like X/Y=0.05,300: X drifts by +0.05 while Y goes +300"
        )
    name = first.name_of(moving, drifts)
    return (
        name,
        first.from_drift(name, size, way),
        f"along a square {drifts} drifts {size:+g} mm while {moving} goes {way:+g}",
        # a difference of two readings of the gauge, over the way: rad
        lambda options: options.u_gauge * math.sqrt(2) / abs(way) if options.u_gauge else None,
    )


def diagonals(text: str) -> tuple[str, float, str, Known]:
    """As `angle`, of the diagonals of a rectangle."""
    pair, (rising, falling, a, b) = parts(text, "XY=565.9,565.4,400,400", 4)
    if pair not in ("XY", "YZ", "XZ") or min(rising, falling, a, b) <= 0:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not like XY=565.9,565.4,400,400 (XY, YZ or XZ, mm)"
        )
    name = first.name_of(pair[1], pair[0])
    try:
        value = first.from_diagonals(name, rising, falling, (a, b))
    except CalibrationError as error:
        raise argparse.ArgumentTypeError(f"{text!r}: {error.message}; {error.advice}") from None
    how = f"diagonals {rising:g} and {falling:g} mm of a rectangle {a:g} by {b:g}"

    def known(options: argparse.Namespace) -> float | None:
        return (
            first.u_of_diagonals(rising, falling, (a, b), options.u_length)
            if options.u_length
            else None
        )

    return name, value, how, known
