"""RepRapFirmware (Duet): printers, lasers and small mills. E is the filament; M codes take words,
lists and text.

Codes: Duet3D/RepRapFirmware, src/GCodes/GCodes2.cpp (HandleGcode, HandleMcode); what a line holds:
GCodeBuffer/StringParser.cpp (DecodeCommand, FindParameters): a G or M outside of quotes begins a
further command, and a block without a code goes on with G0-G3 in CNC and laser mode (M452, M453)
alone. G90 and G91 leave E alone. M0 stops and ends a file; M30 deletes one. `if`, `while`, `var`, {
} are commands of its own (GCodeBuffer/StringParser.cpp, ProcessConditionalGCode). T runs macros
that may move the tool, and so does a G code that it has not (GCodes2.cpp, HandleTcode,
HandleGcode: G1009.g). Arcs take the two centre words of the plane (GCodes.cpp, DoArcMove).
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.dialects.marlin import _M, _SHIFTS, HEAD, NAMED, PRINTS, SETS, SLICED, TEXT
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

# Its own statements move nothing by themselves; what they decide about is indented (conditions).
META = r"^[ \t]*(?:echo|var|global|set|param|skip|abort|if|elif|else|while|break|continue)\b[^\n]*"

# G1 H1 ends at an endstop, H2 moves motors, H3 measures the axis (GCodes.cpp, DoStraightMove)
ENDSTOP = HEAD + r"G[ \t]*0*[01](?![0-9.])[^;\n]*(?<![A-Z])H[ \t]*[1-4](?![0-9.])[^;\n]*"
FILES = HEAD + r"M[ \t]*0*(?:98|125|226|600|701|702)(?![0-9.])[^;\n]*"  # each runs a macro file

DIALECT = Dialect(
    name="reprap",
    title="RepRapFirmware 3",
    codes=(
        *shared.MOTION,
        *shared.PLANE,
        *shared.DISTANCE,
        *shared.UNITS,
        *shared.WORK,
        *shared.MORE_WORK,
        *shared.MACHINE_FRAME,
        *shared.DWELL,
        *shared.PER_TIME,
        *shared.DATA,
        *shared.SET,
        *rows("rotation", {"69": "no rotation"}),
        *rows("rotation", {"68": "rotation of the coordinates"}, refuses=codes.UNTURNED),
        *rows(
            "",
            {"11": "recover filament", "31": "probe values", "60": "store the position"},
            takes=True,
            does="words",
        ),
        *rows(
            "",
            {"28": "home", "29": "level the bed", "30": "probe the bed", "32": "tilt of the bed"},
            takes=True,
        ),
        *rows("motion", {f"38.{n}": "probe" for n in (2, 3, 4, 5)}, refuses=codes.PROBE),
    ),
    m_codes={
        **{
            n: meaning
            for n, meaning in _M.items()
            # Marlin's that are not taken over; M121 and M226 are other things here (below).
            if n not in (10, 226, 11, 12, 16, 43, 100, 121, 413, 414, 430, 851, 862)
        },
        2: "end of program",
        36: "file information",
        37: "simulation",
        38: "hash of a file",
        39: "media",
        116: "wait for temperatures",
        120: "keep the modes",
        144: "bed standby",
        260: "I2C",
        291: "message",
        292: "message read",
        307: "heater model",
        308: "sensor",
        374: "store the height map",
        375: "load the height map",
        376: "taper of the map",
        408: "report",
        409: "report",
        450: "printer mode",
        451: "printer mode",
        452: "laser mode",
        453: "mill mode",
        470: "new folder",
        471: "rename a file",
        550: "name",
        551: "password",
        555: "flavour",
        557: "probe grid",
        558: "probe",
        559: "write config",
        560: "write a file",
        561: "no height map",
        562: "reset a fault",
        563: "tool",
        564: "limits",
        566: "jerk",
        567: "mix",
        568: "tool",
        570: "heater fault",
        571: "pin",
        572: "pressure advance",
        573: "heater report",
        574: "endstops",
        581: "trigger",
        582: "trigger",
        586: "protocols",
        **dict.fromkeys(range(587, 590), "network"),
        591: "filament sensor",
        593: "input shaping",
        669: "segments",
        905: "clock",
        911: "power loss",
        912: "temperature of the board",
        915: "stall",
        916: "resume",
        917: "standstill current",
        929: "log",
        950: "ports",
        952: "board",
        953: "board",
    },
    m_refuses={
        32: codes.INLINE,
        99: codes.INLINE,
        121: codes.RESTORED,
        206: _SHIFTS,
        218: _SHIFTS,
        290: _SHIFTS,
        556: (
            "it leans the axes against each other: take the squareness of machine.toml or M556, not"
            " both"
        ),
        579: codes.UNTURNED,
        584: codes.TRANSFORM,
        585: codes.PROBE,
        665: codes.TRANSFORM,
        666: codes.TRANSFORM,
        675: codes.PROBE,
    },
    grammar=Grammar(checksums=True, ignores=(META,), macros=((TEXT, 0), (FILES, 0), (ENDSTOP, 0))),
    conditions=True,
    dwell="PS",
    carried=("E",),
    carried_codes=(82, 83),
    ends=(0, 2),
    modal_motion=False,
    m_takes=True,
    m_text=(23, 28, 30, 32, 36, 38, 117),
    bare_letters=True,
    length_letter="T",
    tools_move=True,
    other_codes_are_macros=True,
    homes=True,
    home_z_over="XY",
    g_takes=(29, 32),
    skips_centre=True,
    signs=(
        *PRINTS,
        r"G10[ \t]*P\d+[ \t]*[SR]-?\d",
        r"M98[ \t]*P\"",
        r"M(116|45[0-3]|55[0-9]|56[1-9]|57[0-9]|58[1-9]|950)\b",
        SETS,
        r"\{(MOVE|STATE|HEAT|TOOLS|VAR|GLOBAL)\.",
    ),
    remarks=(
        *SLICED,
        r"FLAVOR:[ \t]*REPRAP",
        r"\bREPRAPFIRMWARE\b",
        r"\bDUET\b",
        r"GCODE_FLAVOR[ \t]*=[ \t]*REPRAP",
    ),
    excludes=(NAMED,),
)
