"""RepRapFirmware (Duet): M556, axis skew, and M425, lost motion.

M556 S X Y Z: tangents X/S (XY), Y/S (YZ) and Z/S (XZ), S at least 10; before any other transform
the tool is sent to x + XY y + XZ z, y + YZ z. P0: the XY angle is taken out of X (P1: out of Y).
M425 X Y Z: mm of lost motion, never negative. Source: Duet3D/RepRapFirmware, src/Movement/Move.cpp
(Move::AxisTransform, SetAxisCompensation, ConfigureBacklashCompensation), src/GCodes/GCodes2.cpp
(case 556).

Sign: the tangents are added, so they are the negative of the deviation's slope: -e. XZ is less by
the product of both other slopes, because Y is corrected beside it. Lost motion is positive where
the tool stays behind in -.
"""

from __future__ import annotations

from postproc.control_tables import ErrorTable, Export, ExportOptions
from postproc.control_tables import _common as common
from postproc.control_tables import _skew as skews
from postproc.recordings import Source

TITLE = "RepRapFirmware (Duet) axis skew (M556) and lost motion (M425)"
VERIFIED = True
UNVERIFIED = "which way M425 adds the lost motion"
SIGN = "tangent = -slope of the deviation; lost motion = deviation in - less that in +"
HEIGHT = 100.0  # mm, S
NOTICE = (
    "unverified: that M425 adds the lost motion in the new direction was not read in the firmware;"
    " test with an indicator"
)
LEAST_HEIGHT = 10.0  # below, the firmware ignores the block


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """One file of commands for config.g. Raises TableError."""
    found = skews.settings(tables, "RepRapFirmware", options.two_way, options.rest)
    xy, xz, yz = (found.skew[p] for p in skews.PLANES)
    # X says XY, Y says YZ, Z says XZ. The machine's own xy goes with the y that it is sent to, y -
    # yz z; the firmware takes y itself for XY, so what is missing, xy yz z, goes into XZ.
    values = (-xy * HEIGHT, -yz * HEIGHT, -(xz - xy * yz) * HEIGHT)
    skew = " ".join(f"{x}{common.fixed(v, 8)}" for x, v in zip("XYZ", values, strict=True))
    lines = [f"; {options.program}: axis skew and lost motion", f"M556 S{HEIGHT:g} {skew} P0"]
    notices = [
        "put the lines into config.g; M556 without words shows what is in force; M425 needs a"
        " firmware that has it"
    ]
    if found.lost:
        sizes = " ".join(f"{x}{common.fixed(size, 6)}" for x, size in sorted(found.lost.items()))
        lines += [f"; {NOTICE}", f"M425 {sizes}"]
        notices.insert(0, NOTICE)
    notices += found.notices
    return Export({f"{options.program}.g": common.text_of(lines)}, tuple(notices), found.left)


def _tangents(at: common.Line, given: dict[str, float]) -> dict[str, float]:
    """What M556 says of each axis. Raises TableError for what the firmware ignores."""
    height = given.get("S", 0.0)
    if height < LEAST_HEIGHT:
        raise at.fault(f"S is {height:g}: below {LEAST_HEIGHT:g} the firmware ignores the block")
    if given.get("P", 0.0) > 0:
        raise at.fault("P1 takes the XY angle out of Y: only P0 is read")
    return {x: skews.factor(at, v / height) for x, v in given.items() if x in "XYZ"}


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """Commands as tables. Raises TableError with file and line for any other command, or what the
    firmware ignores."""
    tangent, lost = dict.fromkeys("XYZ", 0.0), dict.fromkeys("XYZ", 0.0)
    rows = skews.lines_of(source)
    for at, (code, *parts) in rows:
        if code == "M556":
            tangent |= _tangents(at, skews.words(at, parts, "SXYZP"))
        elif code == "M425":
            given = skews.words(at, parts, "SXYZ")
            for x, size in given.items():
                if size < 0:
                    raise at.fault(f"{x} is {size:g}: lost motion is never negative")
            lost |= {x: size for x, size in given.items() if x in lost}
        else:
            raise at.fault(f"{code} is neither M556 nor M425", "keep only these lines")
    if not rows:
        raise common.fault(source, 1, "neither M556 nor M425 stands in this file")
    xy, yz = -tangent["X"], -tangent["Y"]
    return skews.tables({"xy": xy, "xz": -tangent["Z"] + xy * yz, "yz": yz}, lost)
