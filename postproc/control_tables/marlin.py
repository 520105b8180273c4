"""Marlin: M852, skew factors, and M425, lost motion.

M852 I (XY), J (XZ), K (YZ); the planner moves to x - y I - z (J - I K), y - z K. M425 F1 X Y Z: mm
of lost motion that is added in the new direction at every reversal; at power-on the last motion is
taken to have been in +. Both read lengths in the unit in force, so G21 stands before them. Source:
MarlinFirmware/Marlin, Marlin/src/module/planner.h (Planner::skew, Planner::unskew),
Marlin/src/gcode/calibrate/M852.cpp, M425.cpp, Marlin/src/feature/backlash.cpp
(Backlash::add_correction_steps, get_applied_steps), Marlin/src/inc/Conditionals_post.h
(_SKEW_FACTOR, limits of +-1).

Sign: Marlin subtracts factor times position, so a factor is the slope of the deviation: +e (xy =
-C0Y, xz = B0Z, yz = -A0Z). Lost motion is positive where the tool stays behind: the deviation of -
is larger than that of +.
"""

from __future__ import annotations

from postproc.control_tables import ErrorTable, Export, ExportOptions
from postproc.control_tables import _common as common
from postproc.control_tables import _skew as skews
from postproc.recordings import Source

TITLE = "Marlin skew factors (M852) and lost motion (M425)"
VERIFIED = True
UNVERIFIED = ""
SIGN = "skew factor = slope of the deviation; lost motion = deviation in - less that in +"
LETTERS = {"xy": "I", "xz": "J", "yz": "K"}
DECIMALS = 9  # of a factor: 1 um in a kilometre; Marlin keeps a float


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One file of commands for the start of every job, or for M500. Raises TableError."""
    found = skews.settings(tables, "Marlin", options.two_way, options.rest)
    factors = " ".join(f"{LETTERS[p]}{common.fixed(f, DECIMALS)}" for p, f in found.skew.items())
    lines = [f"; {options.program}: skew factors and lost motion", "G21", f"M852 {factors}"]
    if found.lost:
        lines.append(
            "M425 F1 "
            + " ".join(f"{x}{common.fixed(size, 6)}" for x, size in sorted(found.lost.items()))
        )
    notices = [
        (
            "the firmware must be built with SKEW_CORRECTION and SKEW_CORRECTION_GCODE, for Z with"
            " SKEW_CORRECTION_FOR_Z, and with BACKLASH_COMPENSATION and BACKLASH_GCODE; M500 keeps"
            " the values, M503 shows them"
        ),
        (
            "Marlin corrects no skew within 1 mm of the lower ends of X and Y, nor where the"
            " corrected place lies outside of travel"
        ),
        *found.notices,
    ]
    return Export({f"{options.program}.gcode": common.text_of(lines)}, tuple(notices), found.left)


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """Commands, or a report of M503, as tables. Raises TableError with file and line for any other
    command."""
    skew, lost, fraction = dict.fromkeys(skews.PLANES, 0.0), dict.fromkeys("XYZ", 0.0), 1.0
    seen = False
    for at, (code, *parts) in skews.lines_of(source):
        seen |= code in ("M852", "M425")
        if code == "M852":
            given = skews.words(at, parts, "SIJK")
            # S is another letter for I
            usual = skew | {"xy": given.get("S", skew["xy"])}
            skew = {p: skews.factor(at, given.get(x, usual[p])) for p, x in LETTERS.items()}
        elif code == "M425":
            given = skews.words(at, parts, "FSXYZ")
            # F 0 to 1: the part of the lost motion that is taken up
            fraction = min(1.0, max(0.0, given.get("F", fraction)))
            lost |= {x: given.get(x, size) for x, size in lost.items()}
        elif code == "G20":
            raise at.fault("G20: Marlin would take the factors as inches", "write G21")
        elif code not in ("G21", "M500"):
            raise at.fault(f"{code} is neither M852 nor M425", "keep only these lines")
    if not seen:
        raise common.fault(source, 1, "neither M852 nor M425 stands in this file")
    return skews.tables(skew, {x: size * fraction for x, size in lost.items()})
