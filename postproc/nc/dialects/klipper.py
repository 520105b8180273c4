"""Klipper: printers. Marlin's commands, one a line, and commands with names: its own, and the
printer's macros.

Commands: Klipper3d/klipper, klippy/gcode.py (a letter and a number, the last of its letter, or a
name with NAME=value behind it; case does not matter), klippy/extras/gcode_move.py (G0 G1 G20 G21
G90-G92 M82 M83 M114 M220 M221; E counts as incremental under G91 or M83; G92 without a word sets
all four to 0), homing.py (G28),
gcode_arcs.py (G2 G3 G17-G19: centres by the two words of the plane; R and G91 are refused),
firmware_retraction.py (G10 G11), documentation in docs/G-Codes.md. Every other code and name is a
macro of printer.cfg, if it is anything.
"""

from postproc.nc import codes
from postproc.nc.dialects import Dialect
from postproc.nc.dialects.marlin import (
    _M,
    _SHIFTS,
    BARE_WORDS,
    HEAD,
    MODES,
    NAMED,
    PRINTS,
    SETS,
    SLICED,
)
from postproc.nc.grammar import Grammar
from postproc.nc.rows import DISTANCE, DWELL, MOTION, PLANE, rows

_END = r"(?![A-Z0-9_])[^;\n]*"
# Commands of Klipper's own that move nothing and shift nothing.
_QUIET = (
    HEAD
    + (
        r"(?:EXCLUDE_OBJECT(?:_START|_END|_DEFINE)?|SET_PRESSURE_ADVANCE|(?:RE)?SET_VELOCITY_LIMIT|SET_FAN_SPEED|"
        r"SET_HEATER_TEMPERATURE|TEMPERATURE_WAIT|TURN_OFF_HEATERS|SET_PRINT_STATS_INFO|RESPOND|ECHO|STATUS|HELP|"
        r"SET_DISPLAY_TEXT|SET_DISPLAY_GROUP|SET_LED(?:_TEMPLATE)?|SET_PIN|SET_SERVO|SET_FILAMENT_SENSOR|QUERY_[A-Z_]+|"
        r"[SG]ET_RETRACTION|SET_INPUT_SHAPER|SET_TMC_(?:CURRENT|FIELD)|INIT_TMC|DUMP_TMC|SET_IDLE_TIMEOUT|SAVE_GCODE_STATE|"
        r"SET_GCODE_VARIABLE|SAVE_VARIABLE|BED_MESH_(?:PROFILE|CLEAR|OUTPUT|MAP)|SET_EXTRUDER_ROTATION_DISTANCE|"
        r"SYNC_EXTRUDER_MOTION|SET_TEMPERATURE_FAN_TARGET|SET_STEPPER_ENABLE|GET_POSITION|SDCARD_[A-Z_]+|"
        r"SET_SKEW[ \t]+CLEAR=1)"
    )
    + _END
)
_NO_OFFSET = (
    HEAD + r"SET_GCODE_OFFSET(?:[ \t]+[XYZE](?:_ADJUST)?[ \t]*=[ \t]*[+-]?0*\.?0*(?![\d.])|["
    r" \t]+MOVE(?:_SPEED)?=[\d.]+)+[ \t\r]*$"
)
# M codes of Marlin that it has.
_HAS = """
    18 20 21 23 24 25 26 27 73 82 83 84 104 105 106 107 109 110 112 114 115 117 118 119 140 141 190
    191 201 203 204 205 220 221 400 500 502 503 862 900
"""
_NO_INCH = "this control has no inches: let the slicer or CAM program write millimetres"

DIALECT = Dialect(
    name="klipper",
    last_holds="F",
    title="Klipper",
    codes=(
        *MOTION,
        *PLANE,
        *DISTANCE,
        *DWELL,
        *rows("shift", {"92": "set position"}, takes=True, does="set or all"),
        *rows("units", {"21": "millimetre"}),
        *rows("units", {"20": "inch"}, refuses=_NO_INCH),
        *rows("", {"10": "retract filament", "11": "recover filament"}, takes=True, does="words"),
        *rows("", {"28": "home"}, takes=True),
    ),
    m_codes={n: _M[n] for n in map(int, _HAS.split())},
    grammar=Grammar(
        checksums=True,
        ignores=(r"^[ \t]*@[^;\n]*", MODES, _QUIET, _NO_OFFSET),
        # 1 to 3: the sentences of `macro_refuses`; 0 passes, and no axis has a known place behind
        # it.
        macros=(
            (HEAD + "RESTORE_GCODE_STATE" + _END, 1),
            (HEAD + "(?:SET_GCODE_OFFSET|SET_KINEMATIC_POSITION)" + _END, 2),
            (HEAD + "(?:SET_SKEW|SKEW_PROFILE)" + _END, 3),
            # any other name, which is a macro of printer.cfg
            (HEAD + r"(?![GMTN][ \t]*-?\d)[A-Z_][A-Z_][^;\n]*", 0),
            (HEAD + r"M[ \t]*0*(?:0|1|125|600|601|602|603|701|702)(?![0-9.])[^;\n]*", 0),
            (HEAD + r"T[ \t]*-?\d[^;\n]*", 0),
            (BARE_WORDS, 0),
        ),
    ),
    macro_refuses=(
        codes.RESTORED,
        _SHIFTS,
        (
            "it leans the axes against each other: take the squareness of machine.toml or the skew"
            " of Klipper, not both"
        ),
    ),
    carried=("E",),
    carried_codes=(82, 83),
    # E is incremental under G91 whatever M82 says, unlike Marlin's, where the last of the two
    # holds.
    relative_with_distance=True,
    ends=(),
    modal_motion=False,
    one_command=True,
    m_takes=True,
    m_text=(23, 117, 118),
    bare_letters=True,
    homes=True,
    other_codes_are_macros=True,
    home_z_over="XY",
    skips_centre=True,
    signs=(*PRINTS, NAMED, r"^[ \t]*[A-Z]+_[A-Z_]+[ \t]+[A-Z_]+="),
    remarks=(*SLICED, r"\bKLIPPER\b", r"GCODE_FLAVOR[ \t]*=[ \t]*KLIPPER"),
    # it has none of these
    excludes=(SETS, r"M98[ \t]*P\"", r"M5(?:58|67|72|74)\b", r"M92\b|M300\b|M50[0-3]\b|M420\b"),
)
