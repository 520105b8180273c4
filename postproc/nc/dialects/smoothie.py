"""Smoothieware: printers, laser cutters and routers. Marlin's and GRBL's words together; motion
codes are modal.

Codes: Smoothieware/Smoothieware, src/modules/robot/Robot.cpp (on_gcode_received: G0-G3, G10,
G17-G21, G43, G49, G53-G59.3, G90-G92, where G92 without a word is G92.1; compute_arc: the two
centre words of the plane),
src/modules/communication/GcodeDispatch.cpp (several commands in a line, `;` and `(` begin comments,
modal G0-G3, first G0), src/modules/tools/endstops/Endstops.cpp (G28),
tools/drillingcycles/Drillingcycles.cpp (G81-G83, G98, G99), tools/zprobe/ZProbe.cpp (G29-G32, G38).
G92.4 with A and S: Carvera-Community/Carvera_Community_Firmware, src/modules/robot/Robot.cpp.
G90 and G91 hold for E too, until M82 or M83. T chooses an extruder with an offset of its own.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.dialects.marlin import _M, _SHIFTS, TEXT
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

DIALECT = Dialect(
    name="smoothie",
    title="Smoothieware",
    codes=(
        *shared.MOTION,
        *shared.NO_MOTION,
        *shared.PLANE,
        *shared.DISTANCE,
        *shared.UNITS,
        *shared.WORK,
        *shared.MORE_WORK,
        *shared.MACHINE_FRAME,
        *shared.DWELL,
        *shared.DATA,
        *rows("shift", {"92": "set position"}, takes=True, does="set or off"),
        *shared.SET_ZERO,
        *rows("shift", {"92.2": "no position shift"}, takes=True, does="set zero"),
        *shared.NO_LENGTH,
        *shared.LENGTH_WORDS,
        *shared.PROBE,
        *shared.DRILL,
        *shared.RETURN,
        *rows("motion", {"83": "peck drilling"}, does="drill"),
        *rows("", {"10.1": "retract filament", "11": "recover filament"}, takes=True, does="words"),
        *rows(
            "",
            {
                "28": "home, or to the reference point",
                "28.2": "home",
                "28.6": "home, by hand",
                "29": "level the bed",
                "30": "probe the bed",
                "31": "level the bed",
                "32": "calibrate",
                "92.4": "home, by hand; with A and S whole turns of A taken off",
            },
            takes=True,
        ),
        # Commands that no module knows are answered with ok, and do nothing (GcodeDispatch.cpp,
        # on_console_line_received).
        *rows("feed mode", {"94": "feed per minute, passed over"}),
        *rows("path", {"61": "passed over", "64": "passed over"}),
        *rows("cutter", {"40": "no cutter radius compensation, passed over"}),
        *rows("", {"91.1": "arc centres are distances, passed over"}),
        *rows("", {"28.1": "store the reference point"}, does="store"),
    ),
    m_codes={**_M, 2: "end of program", 6: "tool change", 30: "end of program"},
    m_refuses={
        32: codes.INLINE,
        206: _SHIFTS,
        600: codes.WRITE_OUT,
        665: codes.TRANSFORM,
        666: codes.TRANSFORM,
    },
    grammar=Grammar(
        checksums=True,
        homing=r"^[ \t]*\$H[ \t\r]*$",
        ignores=(r"^[ \t]*\$[$#GIXS][^\n]*", r"^[ \t]*@[^\n]*"),
        macros=((TEXT, 0),),
    ),
    motion=0,
    dwell="PS",
    carried=("E",),
    carried_codes=(82, 83),
    carried_by_distance=True,
    m_takes=True,
    m_text=(23, 28, 30, 32, 117, 118),
    bare_letters=True,
    length_letter="T",
    change_returns="Z",
    homes=True,
    holes_written_out=False,
    g_takes=(29, 31, 32),
    skips_centre=True,
    ends=(2,),
    signs=(r"\bG28\.[2-6]\b", r"^[ \t]*(?:CONFIG-SET|SUSPEND|PLAY|ABORT)[ \t\r]"),
    remarks=(r"\bSMOOTHIE",),
)
