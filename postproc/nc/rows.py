"""Rows of codes that several dialects share: one list per modal group, as NIST RS274/NGC and Fanuc
have them.

A list holds what all who use it mean alike; what one control means otherwise is a row in its own
file.
"""

from __future__ import annotations

from postproc.nc import codes
from postproc.nc.codes import Code


def rows(
    group: str,
    table: dict[str, str],
    *,
    takes: bool = False,
    refuses: str = "",
    does: str = "",
    like: str = "",
) -> list[Code]:
    """One row per entry of `table`, "54.1" to its meaning, or "TRANS" to its. `like`: what all of
    them are."""
    return [
        Code("G" + word if word[0].isdigit() else word, group, meaning, takes, refuses, does, like)
        for word, meaning in table.items()
    ]


MOTION = rows(
    "motion",
    {"0": "rapid", "1": "straight feed", "2": "arc, clockwise", "3": "arc, counter-clockwise"},
)
NO_MOTION = rows("motion", {"80": "no motion mode"})
PLANE = rows("plane", {"17": "XY plane", "18": "ZX plane", "19": "YZ plane"})
DISTANCE = rows("distance", {"90": "absolute words", "91": "incremental words"})
UNITS = rows("units", {"20": "inch", "21": "millimetre"})
PER_TIME = rows("feed mode", {"93": "feed as inverse time", "94": "feed per minute"})
FEED_MODE = [*PER_TIME, *rows("feed mode", {"95": "feed per turn"})]
WORK = rows("work offset", {str(n): f"work offset {n - 53}" for n in range(54, 60)})
MORE_WORK = rows("work offset", {f"59.{n}": f"work offset {6 + n}" for n in (1, 2, 3)})
SPINDLE = rows("spindle mode", {"96": "constant surface speed", "97": "constant spindle speed"})
NO_CUTTER = rows("cutter", {"40": "no cutter radius compensation"})
CUTTER = [
    *NO_CUTTER,
    *rows("cutter", {"41": "cutter radius left", "42": "cutter radius right"}, does="cutter"),
]
DYNAMIC_CUTTER = rows(
    "cutter",
    {"41.1": "cutter radius left, by D", "42.1": "cutter radius right, by D"},
    does="cutter",
)
NO_LENGTH = rows("tool length", {"49": "no tool length"}, does="no length")
LENGTH = [*NO_LENGTH, *rows("tool length", {"43": "tool length"}, does="length")]
# where G43 without H, and H0, take the length of the tool in the spindle
LENGTH_BY_TOOL = [
    *NO_LENGTH,
    *rows("tool length", {"43": "tool length"}, does="length by tool"),
]
LENGTH_MINUS = rows("tool length", {"44": "tool length, the other way"}, does="length minus")
LENGTH_WORDS = rows(
    "tool length", {"43.1": "tool length by its words"}, takes=True, does="length words"
)
LENGTH_MORE = rows("tool length", {"43.2": "a further tool length"}, does="length more")
DATA = rows("shift", {"10": "set offsets"}, takes=True, does="data")
LOCAL = rows("shift", {"52": "local coordinates"}, takes=True, does="local")
SET = rows("shift", {"92": "set position"}, takes=True, does="set")
SET_ZERO = rows("shift", {"92.1": "no position shift"}, does="set zero")
SET_OFF = [
    *rows("shift", {"92.2": "position shift off"}, does="set off"),
    *rows("shift", {"92.3": "position shift back"}, does="set back"),
]
SECOND_REFERENCE = "to the second reference point"
REFERENCE = rows("", {"28": "to the reference point", "30": SECOND_REFERENCE}, takes=True)
STORE_REFERENCE = rows(
    "",
    {"28.1": "store the reference point", "30.1": "store the second reference point"},
    does="store",
)
MACHINE_FRAME = rows("", {"53": "this block in machine coordinates"})
DWELL = rows("", {"4": "dwell"})
RETURN = rows("return", {"98": "cycles return to the initial level", "99": "cycles return to R"})
ARC_CENTRE = rows("arc centre", {"90.1": "arc centres absolute", "91.1": "arc centres incremental"})
CENTRE_BY_START = rows("arc centre", {"91.1": "arc centres incremental"})
DIAMETER = rows("diameter", {"7": "X is a diameter", "8": "X is a radius"})
PROBE = rows(
    "motion",
    {"38.2": "probe", "38.3": "probe", "38.4": "probe away", "38.5": "probe away"},
    refuses=codes.PROBE,
)
SPLINE = rows("motion", {"5": "cubic spline", "5.1": "quadratic spline"}, refuses=codes.SPLINE)
NURBS = rows("motion", {"5.2": "NURBS", "5.3": "NURBS end"}, refuses=codes.SPLINE)
PECKS = rows("motion", {"73": "drilling, chip breaking", "83": "peck drilling"}, does="drill")
DRILL = rows("motion", {"81": "drilling", "82": "drilling with dwell"}, does="drill")
BORE = rows(
    "motion",
    {"85": "boring", "86": "boring, spindle stop", "89": "boring with dwell"},
    does="drill",
)
FINE_BORE = rows("motion", {"76": "fine boring"}, does="drill")
BORE_BY_HAND = rows("motion", {"88": "boring, out by hand"}, does="drill")
TAP = rows("motion", {"74": "left-hand tapping", "84": "right-hand tapping"}, does="tap")
BACK_BORE = rows("motion", {"87": "back boring"}, refuses=codes.WRITE_OUT)
THREAD = rows("motion", {"33": "spindle-synchronised motion"}, does="thread")
SCALING = [
    *rows("scaling", {"50": "no scaling"}),
    *rows("scaling", {"51": "scaling"}, refuses=codes.FRAME),
]
ROTATION = [
    *rows("rotation", {"69": "no rotation"}),
    *rows("rotation", {"68": "rotation of the coordinates"}, refuses=codes.FRAME),
]
MACRO = [
    *rows("", {"65": "macro call"}, takes=True, refuses=codes.CALL),
    *rows("macro", {"67": "no modal macro call"}),
    *rows("macro", {"66": "macro call after every motion"}, refuses=codes.CALL),
]

# What every control for cutting has here; each adds its units, frames and cycles.
COMMON = [*MOTION, *PLANE, *DISTANCE, *WORK, *REFERENCE, *MACHINE_FRAME, *DWELL]

# -- Fanuc: what mills and lathes share, and what the lathes of all three G-code systems share -----

FANUC = [
    *rows("", {"9": "exact stop in this block", "11": "end of data input"}),
    *rows("", {"27": "reference point check"}, takes=True),
    *rows("motion", {"31": "skip"}, refuses=codes.PROBE),
    *rows("motion", {"34": "variable lead thread"}, does="thread"),
    *rows("path", {"61": "exact stop", "63": "tapping mode", "64": "cutting mode"}),
    *rows("stroke check", {"22": "stroke check on"}, takes=True, does="words"),
    *rows("stroke check", {"23": "stroke check off"}),
    *rows("speed check", {"25": "speed check off", "26": "speed check on"}),
    *rows("polygon", {"50.2": "no polygon turning"}),
    *rows("polygon", {"51.2": "polygon turning"}, refuses=codes.ITSELF),
    *rows("cylinder", {"7.1": "cylindrical interpolation"}, refuses=codes.TRANSFORM),
    *rows("cylinder", {"107": "cylindrical interpolation"}, refuses=codes.TRANSFORM, like="G7.1"),
    *MACRO,
]
# of mills, where they are named and refused: face.py follows them on lathes alone
NO_POLAR = [
    *rows("polar", {"12.1": "polar interpolation"}, refuses=codes.TRANSFORM),
    *rows("polar", {"112": "polar interpolation"}, refuses=codes.TRANSFORM, like="G12.1"),
    *rows("polar", {"13.1": "no polar interpolation"}),
    *rows("polar", {"113": "no polar interpolation"}, like="G13.1"),
]
POLAR = [
    *rows("polar", {"12.1": "polar interpolation"}, does="polar on"),
    *rows("polar", {"112": "polar interpolation"}, does="polar on", like="G12.1"),
    *rows("polar", {"13.1": "no polar interpolation"}, does="polar off"),
    *rows("polar", {"113": "no polar interpolation"}, does="polar off", like="G13.1"),
]
# Blanks that MANUAL GUIDE i draws (B-63874EN, "Blank form"): they move nothing.
BLANKS = r"G190[0-3](?:[ \t]*[A-Z][ \t]*[-+.\d]+)*"
# <SHAFT>, or :1 (B-64304EN, "Program number": the colon of the ISO code), for O1
NAMED_PROGRAM = r"^[ \t]*(?:<[^<>\n]{1,32}>|:[ \t]*\d{1,8})(?=[ \t;]*(?:\([^()\n]*\)[ \t;]*)*\r?$)"
# Lines for a printer (B-64304EN, "External output commands"): they move nothing.
PRINTS = r"(?:POPEN|PCLOS|[BD]PRNT[ \t]*\[[^();\n]*)"
# Blanks, tools and datums that Denford's simulation draws (as its QuickCAM posts write them)
DRAWS = r"^[ \t]*\[(?:BILLET|TOOLDEF|EDGEMOVE)\b[^;\n]*"
FANUC_LATHE = [
    *MOTION,
    *PLANE,
    *WORK,
    *SPINDLE,
    *REFERENCE,
    *MACHINE_FRAME,
    *DWELL,
    *DATA,
    *LOCAL,
    *FANUC,
    *POLAR,
    *NO_LENGTH,
    *rows("tool length", {"43": "tool length"}, refuses=codes.LENGTH),
    *rows("cycle", {"80": "end of drilling cycles"}),
    *rows(
        "motion",
        {"83": "face drilling", "85": "face boring", "87": "side drilling", "89": "side boring"},
        refuses=codes.CYCLE,
    ),
    *rows("cycle", {"84": "face tapping"}, does="tap Z"),
    *rows("cycle", {"88": "side tapping"}, does="tap X"),
    *rows(
        "motion",
        {"36": "tool offset of X, measured", "37": "tool offset of Z, measured"},
        refuses=codes.PROBE,
    ),
    *rows("mirror", {"69": "no mirror"}),
    *rows("mirror", {"68": "double turret mirror"}, refuses=codes.UNTURNED),
]

# What programs with Fanuc's macro language and subprograms show, and no others do.
MACRO_SIGNS = (
    r"M98[ \t]*P\d", r"#\d+[ \t]*=", r"G6[56][ \t]*P\d{4}", r"\][ \t]*(THEN\b|GOTO[ \t]*\d)",
    r"\bWHILE[ \t]*\[.*\][ \t]*DO[ \t]*\d",
)  # fmt: skip
