"""Okuma lathes (OSP): T with six digits, shapes between G81 and G80 (LAP), L as the radius of arcs,
`$` where a block goes on.

Source: Okuma OSP-P200L and P20L programming manual 5238-E, as its pages stand on the web: fixed
thread cutting cycles (P-97, P-114), LAP (P-175 to P-218), address characters of the live tools'
cycles (P-139), nose radius (P-76). There is no G54 here and no code for inches: zeros and units are
the control's. T is four digits, tool and offset, or six with the number of the nose radius before
them: the offset is called by the last four (T010101: T0101). G71 and G72 are threads, G75 and G76
corners. G137 begins polar interpolation, with G101 to G103, where
L is the radius (nc/face.py). Refused: the other turret, whose slides are others; X and C without
G137 (G101 to G103), G107 to G133; holes of the C axis but G181 (G184 stays). Jumps, variables and
calls: expand/okuma.py.
"""

from postproc.nc import codes
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import CUTTER, DISTANCE, DWELL, MOTION, PER_TIME, PLANE, SPINDLE, rows

_HEAD = r"^[ \t]*(?:/[ \t]*)?(?:N[ \t]*\w+[ \t]+)?(?:/[ \t]*)?"
_TURRET = (
    "it is the other turret, whose slides are others: correct its blocks as a program of their own,"
    " with a machine of their own"
)
_SHIFTS = "it moves the zero, from where is not certain: write it into the zero offset"
_UNITS = "units are a parameter of this control: take the code out"
_ON = f"the block before it goes on in this line: {codes.EXPAND}"
_RADIUS = f"its radius is L: {codes.EXPAND}"
_ANGLE = f"its end lies on a line at the angle A: {codes.EXPAND}"
_NAMED = f"its shape stands under a name: {codes.EXPAND}"
_VALUE = "its value may stand for a place: --expand writes its number"
_DATA = "it sets or reads data of the control: set them before the program, and take the block out"
_BY_C = "the control makes X and C of a line on the face: program in X and Y, under G137"
# Codes whose L and A are other words than an arc's radius and a line's angle: threads, grooves,
# corners, X and C on the face, holes.
_NO_L = r"(?![^\n]*G[ \t]*0*(?:3[1-5]|7[1-8]|10[23]|18[0-9]|190)(?![0-9]))"

DIALECT = Dialect(
    name="okuma-lathe",
    title="Okuma lathe",
    codes=(
        *MOTION,
        *PLANE,
        *DISTANCE,
        *DWELL,
        *CUTTER,
        *SPINDLE,
        *PER_TIME,
        *rows("feed mode", {"95": "feed per turn"}),
        *rows("path", {"64": "no droop control", "65": "droop control"}),
        *rows("turret", {"13": "turret A"}),
        *rows("turret", {"14": "turret B"}, refuses=_TURRET),
        *rows("", {"50": "speed limit"}),
        *rows("", {"24": "home", "25": "to the tool change"}, takes=True),
        *rows("", {"20": "home"}, takes=True, like="G24"),
        *rows("", {"21": "to the tool change"}, takes=True, like="G25"),
        # units are a parameter's: no program has these two, which the interpreter asks for
        *rows("units", {"998": "inch"}, refuses=_UNITS, like="G20"),
        *rows("units", {"999": "millimetre"}, like="G21"),
        *rows("limits", {"22": "barrier on", "23": "barrier off"}),
        *rows("priority", {"110": "speed by turret A", "111": "speed by turret B"}),
        *rows("spindle", {"140": "spindle", "141": "spindle", "142": "spindle", "143": "spindle"}),
        *rows("diameter", {"136": "no conversion, X a diameter"}, does="polar off", like="G7"),
        *rows("diameter", {"138": "Y axis on, X a radius"}, does="polar off", like="G8"),
        *rows("diameter", {"137": "X and Y on the face"}, takes=True, does="polar on"),
        *rows(
            "motion",
            {
                "101": "line by X and C",
                "102": "arc by X and C, clockwise",
                "103": "arc by X and C, counter-clockwise",
            },
            refuses=_BY_C,
        ),
        *rows(
            "motion", {"132": "arc on the side", "133": "arc on the side"}, refuses=codes.TRANSFORM
        ),
        *rows(
            "motion",
            {"31": "threading cycle", "32": "threading cycle", "33": "threading cycle"},
            does="thread cycle",
        ),
        *rows("motion", {"34": "thread, lead grows", "35": "thread, lead falls"}, does="thread"),
        *rows(
            "",
            {"71": "threading in many passes", "72": "face threading in many passes"},
            takes=True,
            does="thread cycle",
        ),
        *rows("", {"77": "tapping", "78": "left-hand tapping"}, takes=True, does="thread cycle"),
        *rows("", {"73": "grooving", "74": "face pecking"}, takes=True, refuses=codes.CYCLE),
        *rows("", {"75": "chamfer", "76": "corner radius"}, refuses=codes.CORNER),
        *rows("shape", {"81": "shape", "82": "shape across"}, takes=True, refuses=_NAMED),
        *rows("shape", {"80": "end of a shape"}, takes=True, refuses=_NAMED, like="G81"),
        *rows(
            "shape",
            {"84": "other depths", "85": "roughing", "86": "copying", "87": "finishing"},
            takes=True,
            refuses=_NAMED,
        ),
        *rows(
            "",
            {"83": "blank's shape", "88": "threads of a shape"},
            takes=True,
            refuses=codes.WRITE_OUT,
        ),
        *rows(
            "motion",
            {
                "107": "tapping in step",
                "108": "tapping in step",
                "112": "thread along an arc",
                "113": "thread along an arc",
                "178": "tapping in step",
                "179": "tapping in step",
                "185": "thread",
                "186": "thread",
                "187": "thread",
                "188": "thread",
            },
            refuses=codes.THREADING,
        ),
        *rows("motion", {"184": "tapping"}, does="thread cycle"),
        *rows("motion", {"180": "no cycle"}, like="G80"),
        *rows("motion", {"181": "drilling"}, refuses=codes.CYCLE),
        *rows(
            "motion",
            {
                "182": "boring",
                "183": "peck drilling",
                "189": "reaming",
                "190": "key way",
                "191": "key way",
            },
            refuses=codes.WRITE_OUT,
        ),
    ),
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        12: "live tool stop",
        13: "live tool",
        14: "live tool, reverse",
        15: "C axis one way",
        16: "C axis the other way",
        22: "no chamfer behind a thread",
        23: "chamfer behind a thread",
        24: "barrier off",
        25: "barrier on",
        26: "lead along Z",
        27: "lead along X",
        32: "infeed along a flank",
        33: "infeed by turns",
        34: "infeed along the other flank",
        **dict.fromkeys(range(40, 45), "gear"),
        55: "quill back",
        56: "quill",
        60: "wait for the speed",
        61: "no wait for the speed",
        73: "infeed pattern 1",
        74: "infeed pattern 2",
        75: "infeed pattern 3",
        83: "clamp",
        84: "unclamp",
        85: "no way back behind a roughing",
        88: "air off",
        89: "air",
        98: "quill, low force",
        99: "quill, high force",
        109: "no C axis",
        110: "C axis",
        146: "C axis unclamped",
        147: "C axis clamped",
    },
    grammar=Grammar(
        ignores=(
            r"^[ \t]*\$[-A-Z0-9._]*%[^\n]*",
            r"^[ \t]*O[A-Z0-9]*[A-Z][A-Z0-9]*[ \t]*\r?$",
            r"\b(?:SB|SA|HP)[ \t]*=[ \t]*[-+]?[0-9.]+",
            _HEAD + r"NOEX\b[^\n]*",
            _HEAD + r"(?:CLEAR|DRAW|DEF[ \t]+WORK|PS[ \t]+[A-Z]+[ \t]*,[^\n]*|END)[ \t]*\r?$",
            r"^[ \t]*(?:/[ \t]*)?N[A-Z][A-Z0-9]{0,3}(?=[ \t(\r]|$)",
        ),
        letters=(
            (
                r"^(?:[^\n(]|\([^)\n]*\))*?G[ \t]*10[23](?![0-9])[^\n(]*?(?<![A-Z])(L)"
                r"(?=[ \t]*[-+]?[0-9.])",
                "R",
            ),
        ),
        macros=(
            (r"^[ \t]*\$[^\n]*", 1),
            (_HEAD + r"(?:CALL|MODIN|MODOUT|GOTO|IF|RTS)\b[^\n]*", 2),
            (_HEAD + r"(?:GET|PUT|READ|WRITE|PSELECT)\b[^\n]*", 8),
            (_HEAD + r"V(?!C?[0-9])[A-Z]+[0-9]*[ \t]*(?:\[[^\]\n]*\][ \t]*)?=[^\n]*", 8),
            (r"^(?:[^\n(]|\([^)\n]*\))*?=[^\n]*", 3),
            (_HEAD + r"G[ \t]*50(?=[^\n(]*[XZ])[^\n]*", 4),
            (_HEAD + r"G[ \t]*8[5-8][ \t]*N[A-Z][^\n]*", 5),
            ("^" + _NO_L + r"(?:[^\n(]|\([^)\n]*\))*?(?<![A-Z])L[ \t]*[-+]?[0-9.][^\n]*", 6),
            ("^" + _NO_L + r"(?:[^\n(]|\([^)\n]*\))*?(?<![A-Z])A[ \t]*[-+]?[0-9.][^\n]*", 7),
        ),
    ),
    polar="Y",
    # G136 to G138 say in one whether X is a diameter and whether X and Y are the face.
    polar_group="diameter",
    contour=100,
    macro_refuses=(_ON, codes.CALL, _VALUE, _SHIFTS, _NAMED, _RADIUS, _ANGLE, _DATA),
    language="okuma",
    plane=180,
    dwell="F",
    motion=0,
    tool_offsets=True,
    drawn="A",
    nose_in_tool=True,
    repeats="",
    letters="ABDEHJLQUW",
    threads_chained=(340, 350),
    thread_words="FE",
    signs=(
        r"^\$[-\w.]+\.(?:MIN|SUB|SSB)%",
        r"^(?:N\w+[ \t]+)?(?:[^(\n]*[ \t])?T(?!0000)\d{6}\b",
        r"G8[567][ \t]*N[A-Z]",
        r"\bSB[ \t]*=[ \t]*\d",
        r"^N[A-Z]\w*[ \t]+G8[1-3]\b",
    ),
    remarks=(r"\bOKUMA\b", r"\bOSP\b"),
    # Okuma's mills, and lathes of Fanuc's kin.
    excludes=(r"G15[ \t]*H\d", r"G56[ \t]*H\d", r"G28[ \t]*[UW]"),
)
