"""How lengths, places and offsets are written on the command line."""

from __future__ import annotations

import argparse
import math
import re

from postproc.expressions import expression
from postproc.units import LARGEST_WORD_MM

LENGTHS = {"um": 1e-3, "mm": 1.0, "in": 25.4, "": 1.0}
LENGTH = expression(r"([-+]?[0-9.]+(?:e-?[0-9]+)?)\s*(um|mm|in|)")
SHORTEST, COARSEST, LONGEST = 1e-9, 1.0, 10.0  # mm; an atom is 1e-7
WORD = expression(r"\s*([XYZABCUVWTRQ])\s*=?\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))\s*")
PLACE = "is not a place like X1,Z-2.5 (mm, radius)"
OFFSET = "is not an offset like G54=X1,Z2 (mm, radius)"


def _with_point(plain: str) -> str:
    """How a length with a decimal comma is written, as a hint; "": it is none."""
    pointed = plain.replace(",", ".")
    return f"; write {pointed}" if pointed != plain and LENGTH.fullmatch(pointed) else ""


def length(text: str) -> float:
    """mm from "0.5um", "0.001mm", "0.00004in"; a bare number is mm."""
    plain = text.strip().replace("\u00b5m", "um").replace("\u03bcm", "um")
    found = LENGTH.fullmatch(plain)
    try:
        value = float(found[1]) * LENGTHS[found[2]] if found else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or found is None:
        hint = _with_point(plain)
        raise argparse.ArgumentTypeError(f"{text!r} is not a length like 0.5um or 0.001mm{hint}")
    if value <= 0:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not above zero; a length is like 0.5um or 0.001mm"
        )
    # --tolerance 5 is meant as um by whoever writes it: 5 mm would correct nothing
    if value > 0.1 and not found[2]:
        raise argparse.ArgumentTypeError(
            f"{text!r} without a unit is mm; write {plain}um or {plain}mm"
        )
    if value > LONGEST:
        raise argparse.ArgumentTypeError(
            f"{text!r} is over {LONGEST:g} mm: is that meant in um? write {found[1]}um"
        )
    if value < SHORTEST:
        raise argparse.ArgumentTypeError(
            f"{text!r} is below {SHORTEST:g} mm; a length is like 0.5um or 0.001mm"
        )
    return value


def tolerance(text: str) -> float:
    """mm, as `length`; more than a millimetre is no tolerance but a slip of the unit."""
    value = length(text)
    if value > COARSEST:
        number = re.match(r"[-+0-9.e]+", text.strip())
        meant = f"; write {number[0]}um" if number else ""
        raise argparse.ArgumentTypeError(
            f"{text!r} is over {COARSEST:g} mm: is that meant in um?{meant}"
        )
    return value


def hole_tolerance(text: str) -> float:
    """mm, as `tolerance`; 0: no hole is straight enough."""
    return 0.0 if re.fullmatch(r"[+-]?0+(\.0*)?\s*(um|mm|in|)", text.strip()) else tolerance(text)


def place(text: str) -> dict[str, float]:
    """Axis to mm, from "X1,Z-2.5"; T to the number of a tool, from "T2"."""
    found = _words(text, text, "XYZABCUVWT", PLACE)
    tool = found.get("T", 0.0)
    if tool < 0 or tool != int(tool):
        raise argparse.ArgumentTypeError(f"{text!r} {PLACE}: T is the number of a tool, 0: none")
    return found


def offset(text: str) -> tuple[str, dict[str, float]]:
    """Name and place, from "G54=X1,Z2", "G54.1P3=X1", "T0101=X0,Z80", "H1=Z120" or "D1=R5" (R: the
    tool's radius; Q: the number of a lathe tool's orientation).

    The name comes back as offset files give it: "G54.1 P3".
    """
    from postproc.offsets import KNOWN_NAMES, canonical

    name, equals, rest = text.partition("=")
    known = canonical(name)
    if not equals or not rest.strip():
        raise argparse.ArgumentTypeError(f"{text!r} {OFFSET}: after the name comes =, then axes")
    if known is None:
        raise argparse.ArgumentTypeError(
            f"{text!r} {OFFSET}: there is no {name.strip()!r}, but {KNOWN_NAMES}"
        )
    letters = {"D": "XYZABCUVWR", "T": "XYZABCUVWRQ"}.get(known[0], "XYZABCUVW")
    return known, _words(text, rest, letters, OFFSET)


def temperatures(text: str) -> dict[str, float]:
    """Axis, or "work", to degrees Celsius, from "Z=24.1,work=21"."""
    result: dict[str, float] = {}
    for part in text.split(","):
        found = re.fullmatch(r"\s*([XYZ]|work)\s*=?\s*([-+]?[0-9]+\.?[0-9]*)\s*C?\s*", part)
        if not found or not -30 <= float(found[2]) <= 90:
            raise argparse.ArgumentTypeError(
                f"{text!r} is not like Z=24.1,work=21 (degrees Celsius): {part.strip()!r}"
            )
        result[found[1]] = float(found[2])
    return result


def number(word: str) -> float:
    """A finite number."""
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or abs(value) > 1e12:
        raise argparse.ArgumentTypeError(f"{word!r} is not a number")
    return value


def size(word: str) -> float:
    """A finite number that is not below zero."""
    value = number(word)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{word} is below zero")
    return value


def factor(word: str) -> float:
    """A finite number above zero, up to 100."""
    value = number(word)
    if not 0 < value <= 100:
        raise argparse.ArgumentTypeError(f"{word!r} is not a factor like 1.1")
    return value


def seed(word: str) -> int:
    """A whole number of 18 digits at most."""
    if not re.fullmatch(r"[0-9]{1,18}", word):
        raise argparse.ArgumentTypeError(f"{word!r} is not a whole number")
    return int(word)


def count(word: str) -> int:
    """A whole number of 1 to 9999."""
    if not re.fullmatch(r"[0-9]{1,4}", word) or int(word) < 1:
        raise argparse.ArgumentTypeError(f"{word!r} is not a number of 1 to 9999")
    return int(word)


def _words(whole: str, text: str, letters: str, wanted: str) -> dict[str, float]:
    """Letter to number of "X1,Z-2.5". `whole` and `wanted` are for the message."""
    result: dict[str, float] = {}
    for part in text.upper().split(","):
        found = WORD.fullmatch(part)
        if not found or found[1] not in letters:
            raise argparse.ArgumentTypeError(
                f"{whole!r} {wanted}: {part.strip()!r} is not one of {letters} and a number"
            )
        if found[1] in result:
            raise argparse.ArgumentTypeError(f"{whole!r} {wanted}: {found[1]} stands twice")
        if abs(float(found[2])) > LARGEST_WORD_MM:
            raise argparse.ArgumentTypeError(
                f"{whole[:60]!r} {wanted}: no machine reaches that far"
            )
        result[found[1]] = float(found[2])
    return result
