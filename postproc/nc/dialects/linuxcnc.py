"""LinuxCNC (RS274/NGC): `;` and `( )` comments, incremental arc centres, P turns, G7 diameter, G8
radius.

Codes: LinuxCNC documentation, docs/src/gcode/g-code.adoc and m-code.adoc, quick reference tables.
Arc tolerances: rs274ngc's constants of these names, measured on the interpreter
(tests/linuxcnc/README.md).
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

# M61 to M68, which grblHAL and FluidNC have from here
OUTPUTS = {
    61: "set tool number",
    **dict.fromkeys((62, 63, 64, 65), "output"),
    66: "wait for input",
    67: "analog output",
    68: "analog output",
}

DIALECT = Dialect(
    name="linuxcnc",
    title="LinuxCNC 2.8 and newer, RS274/NGC",
    codes=(
        *shared.COMMON,
        *shared.UNITS,
        *shared.SPINDLE,
        *shared.CUTTER,
        *shared.DYNAMIC_CUTTER,
        *shared.FEED_MODE,
        *shared.NO_MOTION,
        *shared.ARC_CENTRE,
        *shared.DIAMETER,
        *shared.MORE_WORK,
        *shared.RETURN,
        *shared.DATA,
        *shared.LOCAL,
        *shared.SET,
        *shared.SET_ZERO,
        *shared.SET_OFF,
        *shared.STORE_REFERENCE,
        *shared.LENGTH_BY_TOOL,
        *shared.LENGTH_WORDS,
        *shared.LENGTH_MORE,
        *shared.PROBE,
        *shared.SPLINE,
        *shared.NURBS,
        *shared.PECKS,
        *shared.DRILL,
        *shared.BORE,
        *shared.BORE_BY_HAND,
        *shared.TAP,
        *shared.BACK_BORE,
        *shared.THREAD,
        *rows("motion", {"33.1": "rigid tapping"}, does="there and back"),
        *rows(
            "motion",
            {"76": "threading in many passes"},
            refuses=codes.CYCLE,
            does="thread by diameter",
        ),
        *rows("motion", {"70": "finishing cycle"}, refuses=codes.CYCLE),
        *rows(
            "motion",
            dict.fromkeys(("71", "71.1", "71.2", "72", "72.1", "72.2"), "roughing cycle"),
            refuses=codes.CYCLE,
        ),
        *rows(
            "plane",
            {"17.1": "UV plane", "18.1": "WU plane", "19.1": "VW plane"},
            refuses=codes.TRANSFORM,
        ),
        *rows("path", {"61": "exact path", "61.1": "exact stop", "64": "path within a tolerance"}),
    ),
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        50: "feed override",
        51: "speed override",
        52: "adaptive feed",
        53: "feed stop",
        **OUTPUTS,
        70: "save modal state",
        71: "forget modal state",
    },
    m_refuses={72: codes.BROUGHT_BACK, 73: codes.BROUGHT_BACK, 98: codes.CALL, 99: codes.CALL},
    grammar=Grammar(ignores=(r"\$[ \t]*-?[0-9]+",)),  # $0 names a spindle, $-1 all
    language="linuxcnc",
    returns_no_lower=True,
    expand_decimals=4,
    turns=True,
    arc_tolerance_mm=0.02 * 2**0.5,  # CENTER_ARC_RADIUS_TOLERANCE_MM
    arc_tolerance_relative=0.001,  # SPIRAL_RELATIVE_TOLERANCE
    arc_tolerance_most_mm=2 * 2**0.5,
    arc_tolerance_inch=2.54,  # CENTER_ARC_RADIUS_TOLERANCE_INCH, 2 * 0.001 * sqrt(2) inches
    radius_tolerance_mm=0.00127,  # RADIUS_TOLERANCE_MM
    # G99 holds before G98 or G99 is named (drilling_linuxcnc.py, measured on 2.9).
    returns=990,
    local_is_preset=True,
    change_returns="Z",
    exact_stops=(611,),
    feed_along_first=True,
    threads_chained=(330,),
    thread_words="K",
    letters="E",
    signs=(
        (
            r"^[ \t]*O[ \t]*(<[^>\n]+>|\d+)["
            r" \t]*((END)?(SUB|IF|WHILE|REPEAT)|ELSE(IF)?|DO|CALL|RETURN)\b"
        ),
        r"#<_?[A-Z]",
        r"#\d+[ \t]*=",
        r"G33\.1\b",
        r"G5\.[23]\b",
        r"G4[12]\.1[ \t]*D",
        r"G64[ \t]*P[\d.]",
        r"G10[ \t]*L1[01]?[ \t]*P\d+[ \t]*[XZR]",
        r"M6[67][ \t]*[EP]\d",
    ),
    remarks=(r"\bLINUXCNC\b", r"\bEMC2\b", r"\([ \t]*(DEBUG|PRINT|LOG|LOGOPEN)[ \t]*,"),
)
