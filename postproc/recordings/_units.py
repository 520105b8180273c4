"""Units in which instruments write readings, by all their spellings, and the ranges that a
machine's readings have."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from postproc.errors import UsageError
from postproc.units import MM_PER_INCH

LENGTH, ANGLE = "length", "angle"


@dataclass(frozen=True)
class Unit:
    """A unit of readings. quantity: length or angle; factor: um or urad of one."""

    name: str
    quantity: str
    factor: float

    @property
    def base(self) -> str:
        """The unit in which a recording holds it."""
        return "um" if self.quantity == LENGTH else "urad"


ARCSEC = math.radians(1 / 3600) * 1e6  # urad
UNITS = {
    unit.name: unit
    for unit in (
        Unit("nm", LENGTH, 1e-3),
        Unit("um", LENGTH, 1.0),
        Unit("mm", LENGTH, 1e3),
        Unit("inch", LENGTH, MM_PER_INCH * 1e3),
        Unit("urad", ANGLE, 1.0),
        Unit("um/m", ANGLE, 1.0),
        Unit("mrad", ANGLE, 1e3),
        Unit("mm/m", ANGLE, 1e3),
        Unit("arcsec", ANGLE, ARCSEC),
        Unit("arcmin", ANGLE, ARCSEC * 60),
        Unit("deg", ANGLE, math.radians(1) * 1e6),
        Unit("rad", ANGLE, 1e6),
    )
}
# The bytes of a cp1252 micro sign and its m are one Chinese character in GBK.
SPELLINGS = {
    "µm": "um",
    "μm": "um",
    "祄": "um",
    "micron": "um",
    "microns": "um",
    "micrometer": "um",
    "micrometre": "um",
    "millimeter": "mm",
    "millimetre": "mm",
    "in": "inch",
    "inches": "inch",
    "µrad": "urad",
    "μrad": "urad",
    "µm/m": "um/m",
    "μm/m": "um/m",
    "arc-sec": "arcsec",
    "arc sec": "arcsec",
    "arcseconds": "arcsec",
    "arcsecond": "arcsec",
    '"': "arcsec",
    "''": "arcsec",
    "″": "arcsec",
    "sec": "arcsec",
    "arcsecs": "arcsec",
    "arc-sec.": "arcsec",
    "arc-min": "arcmin",
    "arcminutes": "arcmin",
    "degree": "deg",
    "degrees": "deg",
    "°": "deg",
    "nanometre": "nm",
}
# um, urad: range of the readings of any machine's axis
BAND = {LENGTH: (0.1, 5000.0), ANGLE: (0.1, 20_000.0)}
USUAL = {LENGTH: (0.5, 1000.0), ANGLE: (0.5, 3000.0)}  # um, urad: range of most
BAND_TEXT = {LENGTH: "0.1 um to 5 mm", ANGLE: "0.1 urad to 20 mrad"}

BRACKETS = re.compile(r"[(\[]\s*([^()\[\]]+?)\s*[)\]]")
# "dzz_mm", "Deviation in arcsec", "error / um", "Up 1 um"
TAIL = re.compile(r"(?:_|\bin\s+|/\s+|\s)([^\s_]+)\s*$")


def unit_of(text: str) -> Unit | None:
    """The unit that a text is, in any spelling; None where it is none."""
    plain = text.strip().strip(".").lower()
    return UNITS.get(SPELLINGS.get(plain, plain))


def named(text: str, option: str = "--unit") -> Unit:
    """The unit that an option names. Raises UsageError with those that there are."""
    unit = unit_of(text)
    if unit is None:
        raise UsageError(
            f"{option} {text}: this is no unit of readings", f"units: {', '.join(UNITS)}"
        )
    return unit


def in_heading(text: str) -> Unit | None:
    """The unit that a heading such as "Up 1 (µm)", "dzz_mm" or "Deviation in arcsec" ends with or
    has in brackets."""
    for found in BRACKETS.findall(text):
        if unit := unit_of(found):
            return unit
    tail = TAIL.search(text)
    # "in" is inches in brackets, and a word here
    return unit_of(tail[1]) if tail and tail[1].lower() != "in" else None


def amount(value: float, base: str) -> str:
    """A range for a person: 12.3 um, 4.56 mm."""
    if base == "um":
        name, factor = next(
            ((n, f) for n, f in (("m", 1e6), ("mm", 1e3)) if abs(value) >= f), ("um", 1.0)
        )
    else:
        name, factor = next(
            ((n, f) for n, f in (("rad", 1e6), ("mrad", 1e3)) if abs(value) >= f), ("urad", 1.0)
        )
    return f"{value / factor:.4g} {name}"


def outside(spread: float, quantity: str, taken: Unit | None = None) -> str | None:
    """What is odd about readings of this range (um or urad), or None.

    taken: the unit that they were read in; then the units are named in which they would be usual.
    """
    low, high = BAND[quantity]
    base = "um" if quantity == LENGTH else "urad"
    if spread == 0:
        return "all readings are the same"
    if low <= spread <= high:
        return None
    what = (
        f"the readings range over {amount(spread, base)}, and those of a machine's axis range over"
        f" {BAND_TEXT[quantity]}"
    )
    if taken is None:
        return f"{what}: is the unit right?"
    # urad and um/m, mrad and mm/m have one factor each: named once
    seen: set[float] = {taken.factor}
    slips = []
    for unit in UNITS.values():
        would = spread / taken.factor * unit.factor
        if (
            unit.quantity == quantity
            and unit.factor not in seen
            and USUAL[quantity][0] <= would <= USUAL[quantity][1]
        ):
            seen.add(unit.factor)
            slips.append(
                f"{unit.name} read as {taken.name}? Then they range over {amount(would, base)}"
            )
    return f"{what}: " + (
        "; ".join(slips) if slips else f"no unit would make them usual, {taken.name} neither"
    )
