"""Okuma mills (OSP): G15 H for the work offset, G56 H for the length, G71 and M53 for the way back,
VC and CALL for macros.

Source: what Autodesk's `okuma.cps` (OSP-P200, P300) writes and says of it, for mills: G15 H1 to
H200, G56 H, G53, G71 Z with M52 to M54, G10 and G11 rotation, G169 G170 tool point, G605 planes,
CALL O and RTS, PF and VZOF variables. To go as far as the travel reaches it writes X9999. Y9999.
Z9999. (400. in inches): such a block passes, and the axes are known again where the program names
them. The OSP programming manuals themselves were not found as text. Rotations, planes and the
tool point are refused. Jumps, variables and calls: expand/okuma.py.
"""

from postproc.nc import codes
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import CUTTER, DISTANCE, DWELL, MOTION, NO_MOTION, PLANE, SPINDLE, UNITS, rows

_HEAD = r"^[ \t]*(?:/[ \t]*)?(?:N[ \t]*\w+[ \t]+)?"
_ACROSS = (
    "the length of a tool that does not lie along Z is not followed: program with G56, and the tool"
    " along Z"
)
# X9999. (400. in inches) stands for as far as the travel reaches.
_FAR = r"(?:[XYZ][ \t]*(?:9999|400)\.?0*[ \t]*)+\r?$"

DIALECT = Dialect(
    name="okuma",
    title="Okuma mill",
    codes=(
        *MOTION,
        *PLANE,
        *DISTANCE,
        *UNITS,
        *DWELL,
        *CUTTER,
        *NO_MOTION,
        *SPINDLE,
        *rows("feed mode", {"94": "feed per minute", "95": "feed per turn"}),
        # G15 H5 counts as G54.1 P5 everywhere behind the text: `extended_name` gives it its own
        # name back.
        *rows("work offset", {"15": "work offset H"}, does="extended", like="G54.1"),
        *rows("tool length", {"56": "tool length"}, does="length"),
        *rows("tool length", {"53": "no tool length"}, does="no length"),
        *rows(
            "tool length",
            {"54": "tool length along X", "55": "tool length along Y"},
            refuses=_ACROSS,
        ),
        *rows("", {"9": "exact stop in this block"}),
        *rows("path", {"61": "exact stop", "64": "cutting mode"}),
        *rows(
            "",
            {"16": "this block in another work offset"},
            refuses=(
                "its block is in another work offset, for itself alone: write G15 H before and"
                " behind it"
            ),
        ),
        *rows("", {"30": "to a place that the machine keeps"}, takes=True),
        *rows("turned", {"10": "no rotation"}),
        *rows("turned", {"11": "rotation and shift"}, takes=True, refuses=codes.UNTURNED),
        *rows("scaling", {"50": "no scaling"}),
        *rows("scaling", {"51": "scaling"}, takes=True, refuses=codes.UNTURNED),
        *rows("mirror", {"62": "mirror"}, takes=True, refuses=codes.UNTURNED),
        *rows(
            "shift",
            {"92": "set coordinates"},
            takes=True,
            refuses=(
                "which offset it changes is in no text that was found: program in G15 H, with"
                " --offset"
            ),
        ),
        *rows("tool point", {"170": "no tool point"}),
        *rows("tool point", {"169": "tool point"}, refuses=codes.TOOL_POINT),
        *rows("tilted", {"604": "no tilted plane"}),
        *rows("tilted", {"605": "tilted plane"}, takes=True, refuses=codes.TILTED),
        *rows("", {"71": "return level"}, takes=True, does="words"),
        *rows("motion", {"31": "skip"}, refuses=codes.PROBE),
        *rows(
            "motion",
            {
                "73": "drilling, chip breaking",
                "81": "drilling",
                "82": "drilling with dwell",
                "83": "peck drilling",
                "85": "boring",
                "89": "boring with dwell",
            },
            refuses=codes.CYCLE,
        ),
        *rows(
            "motion",
            {
                "74": "left-hand tapping",
                "84": "tapping",
                "273": "left-hand tapping in pecks",
                "283": "tapping in pecks",
                "284": "rigid tapping",
            },
            refuses=codes.THREADING,
        ),
        *rows(
            "motion",
            {"76": "fine boring", "86": "boring, spindle stop", "87": "back boring"},
            refuses=codes.WRITE_OUT,
        ),
    ),
    change_takes="Z",
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        10: "clamp",
        11: "unclamp",
        12: "air",
        15: "table turns one way",
        16: "table turns the other way",
        20: "unclamp",
        21: "clamp",
        26: "unclamp",
        27: "clamp",
        50: "coolant through the tool",
        51: "air",
        52: "cycles return to the upper limit",
        53: "cycles return to the level of G71",
        54: "cycles return to R",
        59: "air",
        63: "no wait for M",
        120: "shower coolant",
        130: "feed with the spindle at rest",
        131: "no feed with the spindle at rest",
        339: "air through the tool",
        510: "no collision check",
        511: "collision check",
    },
    grammar=Grammar(
        ignores=(
            r"^[ \t]*O[A-Z0-9]*[A-Z][A-Z0-9]*[ \t]*\r?$",
            r"^[ \t]*\$[^\n]*",
            r"^[ \t]*(?:/[ \t]*)?N(?!(?:OEX|CYL)\b)[A-Z][A-Z0-9]*(?=[ \t(\r]|$)",
        ),
        macros=(
            (_HEAD + r"(?:RTI|DEF|NCYL|MSG|NOEX|GET|PUT|READ|WRITE|COPY|COPYE)\b[^\n]*", 1),
            (_HEAD + r"(?:CALL|MODIN|MODOUT|GOTO|IF|RTS)\b[^\n]*", 3),
            (_HEAD + r"V(?!C?[0-9])[A-Z]+[0-9]*[ \t]*(?:\[[^\]\n]*\][ \t]*)?=[^\n]*", 2),
            # an equals sign outside of comments: a value that may stand for a place
            (r"^(?:[^\n(]|\([^)\n]*\))*?=[^\n]*", 4),
            (r"^([ \t]*(?:N[ \t]*\w+[ \t]+)?)(?:G[ \t]*0*(?:0|90)[ \t]+)*" + _FAR, 0),
        ),
    ),
    macro_refuses=(
        codes.INLINE,
        "it sets data of the control, and may shift the zero: set them before the program, and take"
        " the block out",
        codes.CALL,
        "its value may stand for a place: --expand writes its number",
    ),
    language="okuma",
    length_left_open=True,
    dwell="F",
    extended_name="G15 H",
    repeats="",
    signs=(
        r"G15[ \t]*H\d",
        r"G56[ \t]*(?:Z[-\d.]+[ \t]*)?H\d|G56\b[^\n]*H\d",
        r"G71[ \t]*Z[-\d.]",
        r"CALL[ \t]*OO?\w+",
        r"\bV(?:C\d+|ZOF[XYZABC]\[)",
        r"G8[1-9]\b[^\n]*M5[234]\b",
        r"^O[A-Z0-9]*[A-Z][A-Z0-9]*[ \t]*$",
        r"\bRTS\b",
    ),
    remarks=(r"\bOKUMA\b", r"\bOSP\b"),
)
