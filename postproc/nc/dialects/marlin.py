"""Marlin 2: printers and laser cutters. A line is one command; E is the filament; M codes take
words of every letter.

Codes, one command a line, text behind M117 and its kin: MarlinFirmware/Marlin,
Marlin/src/gcode/gcode.h (list of codes), parser.cpp (parse), queue.cpp (N and * checksums). A
motion code is not modal unless GCODE_MOTION_MODES is built in; G90 and G91 hold for E too, until
M82 or M83 (gcode.h, set_relative_mode). M30 deletes a file; no M code ends the program. A line that
begins with two letters is no command, and passed over with a message, and so is a G code that it
has not (parser.cpp, parse; gcode.cpp, process_parsed_command); printers of other makers have more
of them (G280). Arcs take the two centre words of the plane (motion/G2_G3.cpp). G28 Z may go to the
bed's middle (calibrate/G28.cpp, home_z_safely). G80 levels the bed on Prusa's printers
(Prusa-Firmware, Marlin_main.cpp); Tx, Tc and T? load filament there. Of two F words in a line the
last one holds (parser.h, set).
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

_M = {
    0: "stop",
    1: "stop",
    3: "spindle or laser on",
    4: "spindle or laser on",
    5: "spindle or laser off",
    7: "mist coolant",
    8: "coolant or air",
    9: "coolant off",
    10: "vacuum on",
    11: "vacuum off",
    12: "closed loop",
    16: "printer check",
    17: "motors on",
    18: "motors off",
    20: "list files",
    21: "media in",
    22: "media out",
    23: "select a file",
    24: "start printing",
    25: "pause",
    26: "set the file's place",
    27: "report",
    28: "write a file",
    29: "end of writing",
    30: "delete a file",
    31: "print time",
    33: "long name",
    34: "sort files",
    42: "set a pin",
    43: "watch pins",
    73: "progress",
    **dict.fromkeys(range(75, 78), "timer"),
    78: "statistics",
    80: "power on",
    81: "power off",
    82: "E absolute",
    83: "E incremental",
    84: "motors off",
    85: "idle time",
    92: "steps per unit",
    100: "memory",
    104: "hotend temperature",
    105: "report temperatures",
    106: "fan on",
    107: "fan off",
    108: "stop waiting",
    109: "hotend temperature, wait",
    110: "line number",
    111: "debug",
    112: "emergency stop",
    113: "keepalive",
    114: "report the position",
    115: "report the firmware",
    117: "message",
    118: "message to the host",
    119: "report endstops",
    120: "endstops on",
    121: "endstops off",
    122: "drivers",
    123: "fan speeds",
    **dict.fromkeys(range(126, 130), "valve"),
    140: "bed temperature",
    141: "chamber temperature",
    143: "cooler temperature",
    145: "material",
    149: "temperature unit",
    150: "light",
    154: "report",
    155: "report",
    **dict.fromkeys(range(163, 167), "mix"),
    190: "bed temperature, wait",
    191: "chamber temperature, wait",
    192: "probe temperature, wait",
    193: "cooler temperature, wait",
    200: "filament diameter",
    201: "acceleration limits",
    202: "acceleration",
    203: "feed limits",
    204: "acceleration",
    205: "jerk",
    207: "retraction",
    208: "recovery",
    209: "retraction by itself",
    211: "software endstops",
    217: "filament swap",
    220: "feed percentage",
    221: "flow percentage",
    226: "wait for a pin",
    240: "photo",
    250: "contrast",
    255: "display sleeps",
    256: "brightness",
    260: "I2C",
    261: "I2C",
    **dict.fromkeys(range(280, 283), "servo"),
    300: "beep",
    301: "PID",
    302: "cold extrusion",
    303: "PID tuning",
    304: "bed PID",
    305: "thermistor",
    306: "model tuning",
    309: "chamber PID",
    350: "microsteps",
    351: "microsteps",
    355: "case light",
    380: "solenoid",
    381: "solenoid",
    400: "finish motions",
    401: "probe out",
    402: "probe in",
    403: "filament type",
    404: "filament width",
    405: "filament sensor",
    406: "filament sensor",
    407: "filament width",
    410: "quick stop",
    412: "runout",
    413: "power loss",
    414: "language",
    420: "levelling",
    421: "mesh point",
    422: "alignment",
    425: "backlash",
    430: "power",
    486: "objects",
    500: "store settings",
    501: "load settings",
    502: "factory settings",
    503: "report settings",
    504: "check settings",
    510: "lock",
    511: "unlock",
    512: "password",
    524: "abort",
    540: "abort at endstop",
    **dict.fromkeys(range(552, 555), "network"),
    569: "stealth",
    575: "baud rate",
    592: "extrusion",
    593: "input shaping",
    603: "filament change",
    672: "effector",
    851: "probe offset",
    862: "printer check",
    871: "probe temperature",
    876: "prompt",
    900: "pressure advance",
    **dict.fromkeys(range(906, 911), "motor current"),
    911: "drivers",
    912: "drivers",
    913: "threshold",
    914: "stall",
    919: "chopper",
    928: "log to a file",
    951: "parking extruder",
    993: "backup",
    994: "backup",
    995: "touch screen",
    997: "firmware",
    999: "go on",
}
HEAD = r"^([ \t]*N[ \t]*\d+)?[ \t]*"
# commands of the host (@pause), filament of Prusa's printers
NOTHING = r"^[ \t]*(?:@[^;\n]*|T[ \t]*[?xc][ \t\r]*$)"
# It parks, and goes back: sequences of its own (feature/pause.cpp, gcode/feature/pause).
FILAMENT = HEAD + r"M[ \t]*0*(?:125|600|701|702)(?![0-9.])[^;\n]*"
# A line that is no command, or a tool's parking place on Prusa's changers (P0 S1, of
# Prusa-Firmware-Buddy).
TEXT = HEAD + r"(?:(?![GMTN][ \t]*-?\d)[A-Z][ \t]*[A-Z_]|P[ \t]*\d)[^;\n]*"
# Words without a command: passed over, unless the firmware was built with GCODE_MOTION_MODES, which
# makes them a motion.
BARE_WORDS = HEAD + r"[XYZEF][ \t]*[-+.]?\d[^;\n]*"
# A remark behind //, where the firmware reads on and finds no word with a number: of G0 and G1 it
# takes no other.
REMARK = (
    r"^([ \t]*(?:N\d+[ \t]*)?G0*[01](?![\d.])[^\n;/(]*)//(?:(?![A-Z][ \t]*[-+.\d])[^\n;*])*(?=$|;)"
)
# What stands behind G90 and its kin means nothing to them: G90 E0.
MODES = (
    r"^[ \t]*(?:N[ \t]*\d+[ \t]*)?(G[ \t]*0*(?:1[789]|2[01]|9[01]))(?![0-9.]|[^;\n]*[GMT]["
    r" \t]*\d)[^;\n]*"
)
# G28 O: unless it has homed before
ONLY_IF = HEAD + r"G[ \t]*0*28(?![0-9.])[^;\n]*O(?![A-Z])[^;\n]*"
# What every printer's program shows, whatever its firmware, and what slicers remark.
PRINTS = (
    r"M10[4579]\b|M106\b",
    r"M1[149]0\b",
    r"M8[234]\b",
    r"M92\b|M20[1-9]\b|M22[01]\b",
    r"M11[0-9]\b",
    r"M300\b",
    r"M50[0-3]\b|M73[ \t]*[PR]",
    r"G92[ \t]*E",
    r"G[01]\b.*(?<![A-Z0-9.])E-?\.?\d",
    r"^[ \t]*G28[ \t]*([XYZW][ \t]*)*$",
    r"^[ \t]*G29[ \t]*$",
    r"^[ \t]*N\d+[^\n*]*\*\d{1,3}[ \t]*$",
)
SLICED = (
    r"\bLAYER[:_]", r"\bTYPE:(?=\S)", r"\bEXTRUDER\b",
    r"\b(CURA|SLIC3R|PRUSASLICER|SUPERSLICER|ORCASLICER|SIMPLIFY3D)\b",
)  # fmt: skip
# Commands with names are Klipper's, statements RepRapFirmware's.
NAMED = (
    r"^[ \t]*(?:EXCLUDE_OBJECT\w*|SET_PRESSURE_ADVANCE|SET_VELOCITY_LIMIT|(?:START|END)_PRINT|PRINT_(?:START|END)|"  # noqa: E501
    r"SET_GCODE_OFFSET|SET_FAN_SPEED|SAVE_GCODE_STATE|RESTORE_GCODE_STATE|BED_MESH_\w+|TIMELAPSE_TAKE_FRAME|"
    r"SET_FILAMENT_SENSOR|SET_PRINT_STATS_INFO|TEMPERATURE_WAIT|SET_HEATER_TEMPERATURE)\b"
)
SETS = r"^[ \t]*(?:VAR|GLOBAL|SET|ECHO)[ \t]+[A-Z\"]"
_SHIFTS = (
    "it shifts the coordinates by what the printer keeps: set it before the print, and take the"
    " line out"
)

DIALECT = Dialect(
    name="marlin",
    last_holds="F",
    title="Marlin 2",
    codes=(
        *shared.MOTION,
        *shared.PLANE,
        *shared.DISTANCE,
        *shared.UNITS,
        *shared.WORK,
        *shared.MORE_WORK,
        *shared.MACHINE_FRAME,
        *shared.DWELL,
        *shared.SET,
        *shared.SET_ZERO,
        *rows("shift", {"92.9": "set position, homing too"}, takes=True, does="set"),
        *rows(
            "",
            {
                "10": "retract filament",
                "11": "recover filament",
                "31": "dock the probe",
                "32": "undock the probe",
                "60": "store the position",
            },
            takes=True,
            does="words",
        ),
        *rows(
            "",
            {
                "28": "home",
                "12": "clean the nozzle",
                "26": "test print",
                "27": "park",
                "29": "level the bed",
                "30": "probe the bed",
                "33": "calibrate",
                "34": "align Z",
                "35": "bed corners",
                "42": "to a mesh point",
                "61": "back to a stored position",
                "76": "calibrate the probe",
                "80": "end of a motion mode, or level the bed",
                "425": "calibrate",
            },
            takes=True,
        ),
        *rows("motion", {"5": "Bezier curve"}, refuses=codes.SPLINE),
        *rows("motion", {"6": "motor steps"}, refuses=codes.TRANSFORM),
        *rows("motion", {f"38.{n}": "probe" for n in (2, 3, 4, 5)}, refuses=codes.PROBE),
    ),
    m_codes=_M,
    m_refuses={
        32: codes.INLINE,
        48: codes.PROBE,
        206: _SHIFTS,
        218: _SHIFTS,
        290: _SHIFTS,
        428: _SHIFTS,
        **dict.fromkeys(range(360, 365), codes.TRANSFORM),
        605: _SHIFTS,
        665: codes.TRANSFORM,
        666: codes.TRANSFORM,
        808: codes.INLINE,
        852: (
            "the firmware leans the axes against each other: take the squareness of "
            "machine.toml or M852, not both"
        ),
        **dict.fromkeys(range(810, 820), codes.INLINE),
    },
    grammar=Grammar(
        checksums=True,
        ignores=(NOTHING, MODES, REMARK),
        macros=((TEXT, 0), (BARE_WORDS, 0), (FILAMENT, 0), (ONLY_IF, 0)),
    ),
    dwell="PS",
    turns=True,
    first_turn=0,
    carried=("E",),
    carried_codes=(82, 83),
    carried_by_distance=True,
    ends=(),
    modal_motion=False,
    one_command=True,
    m_takes=True,
    m_text=(16, 20, 23, 28, 30, 32, 33, 117, 118, 928, *range(810, 820)),
    bare_letters=True,
    length_letter="T",
    change_returns="Z",
    homes=True,
    other_codes_are_macros=True,
    home_z_over="XY",
    # Levelling, parking and probing: what stands behind the code in its line is their own affair.
    g_takes=(12, 26, 27, 29, 33, 34, 35, 42, 76, 80, 425),
    skips_centre=True,
    signs=(*PRINTS, r"M420\b|M900[ \t]*K|M862\b", r"M205[ \t]*[XYZEBJ]|M204[ \t]*P[\d.]+[ \t]+R"),
    remarks=(*SLICED, r"FLAVOR:[ \t]*MARLIN", r"\bMARLIN2?\b"),
    excludes=(NAMED, SETS, r"M98[ \t]*P\"", r"M5(?:58|67|72|74)\b"),
)
