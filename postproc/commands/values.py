"""How lengths, places and offsets are written on the command line."""

from __future__ import annotations

import argparse
import math
import re

LENGTHS = {"um": 1e-3, "mm": 1.0, "in": 25.4, "": 1.0}


def length(text: str) -> float:
    """mm from "0.5um", "0.001mm", "0.00004in"; a bare number is mm."""
    found = re.fullmatch(
        r"([0-9.]+(?:e-?\d+)?)\s*(um|mm|in|)", text.strip().replace("\u00b5m", "um").replace("\u03bcm", "um")
    )
    try:
        value = float(found[1]) * LENGTHS[found[2]] if found else math.nan
    except ValueError:
        value = math.nan
    if not 0 < value <= 10:
        raise argparse.ArgumentTypeError(f"{text!r} is not a length like 0.5um or 0.001mm")
    if value > 0.1 and found and not found[2]:
        raise argparse.ArgumentTypeError(f"{text!r} without a unit is mm; write {text}um or {text}mm")
    return value


def place(text: str) -> dict[str, float]:
    """Axis to mm, from "X1,Z-2.5"."""
    result: dict[str, float] = {}
    for part in text.upper().split(","):
        found = re.fullmatch(r"\s*([XYZABC])\s*=?\s*([-+]?(?:\d+\.?\d*|\.\d+))\s*", part)
        if not found or found[1] in result:
            raise argparse.ArgumentTypeError(f"{text!r} is not a place like X1,Z-2.5 (mm, radius)")
        result[found[1]] = float(found[2])
    return result


def offset(text: str) -> tuple[str, dict[str, float]]:
    """Name and place, from "G54=X1,Z2" or "T0101=X0,Z80"."""
    name, equals, rest = text.partition("=")
    name = name.strip().upper()
    if not equals or not re.fullmatch(r"G5[4-9](\.[123])?|T\d{4}", name):
        raise argparse.ArgumentTypeError(f"{text!r} is not an offset like G54=X1,Z2 or T0101=X0,Z80")
    return name, place(rest)
