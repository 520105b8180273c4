"""Klipper: SET_SKEW, which takes the lengths of a measured parallelogram and makes skew factors of
them.

SET_SKEW XY=AC,BD,AD: both diagonals and the side along the first axis; side = sqrt(2 AC^2 + 2 BD^2
- 4 AD^2) / 2, factor = tan(pi/2 - acos((AC^2 - side^2 - AD^2) / (2 side AD))), the cotangent of the
angle at A. The tool is sent to x - y xy - z (xz - xy yz), y - z yz. Written are the lengths that
a square of 100 mm would have had on this machine. Source: Klipper3d/klipper,
klippy/extras/skew_correction.py (calc_skew_factor, PrinterSkew.calc_skew, cmd_SET_SKEW),
docs/Skew_Correction.md.

Sign: Klipper subtracts factor times position, so a factor is the slope of the deviation: +e (xy =
-C0Y, xz = B0Z, yz = -A0Z). Klipper takes up no lost motion. Its [axis_twist_compensation] is not
written: klippy/extras/axis_twist_compensation.py adds it to what the probe has read
(probe:update_results), not to where the tool goes.
"""

from __future__ import annotations

import math

from postproc.control_tables import ErrorTable, Export, ExportOptions
from postproc.control_tables import _common as common
from postproc.control_tables import _skew as skews
from postproc.recordings import Source

TITLE = "Klipper skew correction (SET_SKEW)"
VERIFIED = True
UNVERIFIED = ""
SIGN = "skew factor = slope of the deviation"
SIDE = 100.0  # mm
DECIMALS = 9  # of mm: a factor to 1e-11


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One file of commands for the start of every job. Raises TableError."""
    found = skews.settings(tables, "Klipper", False, options.rest)
    planes = []
    for plane, factor in found.skew.items():
        #       B________C        A = (0, 0), D = (side, 0), B = (factor side, side)
        #      /        /
        #     /        /          AC is the longer diagonal where the factor is positive
        #    A________D
        ac, bd = math.hypot(SIDE + SIDE * factor, SIDE), math.hypot(SIDE - SIDE * factor, SIDE)
        planes.append(
            f"{plane.upper()}={common.fixed(ac, DECIMALS)},{common.fixed(bd, DECIMALS)},{SIDE:g}"
        )
    lines = [
        f"; {options.program}: lengths of a square of {SIDE:g} mm",
        "SET_SKEW " + " ".join(planes),
    ]
    notices = [
        "printer.cfg needs [skew_correction]; run this in the start of a job, after homing, and"
        " SET_SKEW CLEAR=1 at its end, or keep it with SKEW_PROFILE SAVE=name and SAVE_CONFIG",
        *found.notices,
    ]
    if two_way := [t.name for t in tables if t.two_way]:
        notices.append(
            f"Klipper takes up no lost motion: {', '.join(two_way)} keep the difference of both"
            " directions"
        )
    return Export({f"{options.program}.gcode": common.text_of(lines)}, tuple(notices), found.left)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """Commands as tables. Raises TableError with file and line for lengths that are no
    parallelogram's."""
    skew = dict.fromkeys(skews.PLANES, 0.0)
    seen = False
    for at, parts in skews.lines_of(source):
        if parts[0] == "SKEW_PROFILE":
            continue
        if parts[0] != "SET_SKEW":
            raise at.fault(f"{parts[0]} is not SET_SKEW", "keep only these lines")
        seen = True
        for part in parts[1:]:
            plane, _, value = part.partition("=")
            if plane == "CLEAR":
                if value != "0":
                    skew = dict.fromkeys(skews.PLANES, 0.0)
            elif plane.lower() in skews.PLANES:
                skew[plane.lower()] = skews.factor(at, _factor(at, value))
            else:
                raise at.fault(f"{plane!r} is no plane", "XY=AC,BD,AD XZ=.. YZ=..")
    if not seen:
        raise common.fault(source, 1, "no SET_SKEW stands in this file")
    return skews.tables(skew, {})


def _factor(at: common.Line, value: str) -> float:
    """The cotangent of the angle at A of a parallelogram with these diagonals and this side."""
    words = value.split(",")
    if len(words) != 3:
        many = f"{len(words)} lengths, where AC,BD,AD must stand"
        raise at.fault(many, "no blanks between them")
    ac, bd, ad = (at.finite(w, "a length") for w in words)
    # the other side's: both diagonals' squares are twice both sides'
    square = (ac * ac + bd * bd) / 2 - ad * ad
    cosine = 1.0
    if min(ac, bd, ad) > 0 and square > 0:
        cosine = (ac * ac - bd * bd) / (4 * ad * math.sqrt(square))
    if abs(cosine) >= 1:
        raise at.fault(f"AC {ac:g}, BD {bd:g}, AD {ad:g} are no parallelogram's")
    return cosine / math.sqrt(1 - cosine * cosine)
