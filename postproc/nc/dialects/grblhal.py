"""grblHAL: GRBL's words and much of LinuxCNC's: cycles, splines, scaling, tool table, lathe modes,
P turns, variables.

Codes: grblHAL/core, README.md (supported G-codes), gcode.c (gc_execute_block), wiki "Additional G-
and M-codes".
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import fluidnc
from postproc.nc.dialects.linuxcnc import OUTPUTS
from postproc.nc.rows import rows
from postproc.records import replace

# The lines are read as FluidNC's are; the codes are its own.
DIALECT = replace(
    fluidnc.DIALECT,
    name="grblhal",
    title="grblHAL",
    codes=(
        *shared.COMMON,
        *shared.UNITS,
        *shared.FEED_MODE,
        *shared.SPINDLE,
        *shared.NO_CUTTER,
        *shared.LENGTH_BY_TOOL,
        *shared.LENGTH_WORDS,
        *shared.LENGTH_MORE,
        *shared.DATA,
        *shared.SET,
        *shared.SET_ZERO,
        *shared.STORE_REFERENCE,
        *shared.CENTRE_BY_START,
        *shared.DIAMETER,
        *shared.MORE_WORK,
        *shared.PROBE,
        *shared.SPLINE,
        *shared.NO_MOTION,
        *shared.PECKS,
        *shared.DRILL,
        *shared.BORE,
        *shared.RETURN,
        *shared.THREAD,
        *rows("scaling", {"50": "no scaling"}),
        *rows("scaling", {"51": "scaling"}, refuses=codes.UNTURNED),
        *rows("", {"65": "macro call"}, takes=True, refuses=codes.INLINE),
        *rows("macro", {"67": "no modal macro call"}),
        *rows("macro", {"66": "macro call after every motion"}, refuses=codes.INLINE),
        *rows("motion", {"76": "threading in many passes"}, refuses=codes.WRITE_OUT),
        *rows("path", {"61": "exact path", "61.1": "exact stop", "64": "path within a tolerance"}),
        *rows("", {"187": "acceleration"}),
    ),
    m_codes={
        **{n: m for n, m in codes.SPINDLE_AND_COOLANT.items() if n != 19},
        50: "feed override",
        51: "speed override",
        53: "feed stop",
        56: "parking motion",
        **OUTPUTS,
        70: "save modal state",
        71: "forget modal state",
    },
    m_refuses={72: codes.RESTORED, 73: codes.RESTORED, 98: codes.CALL, 99: codes.CALL},
    returns_no_lower=True,
    thread_words="K",
    signs=(r"^[ \t]*\$[HJXCIGNS#$]", r"#\d+[ \t]*=", r"G65[ \t]*P\d"),
    holes_written_out=False,
    remarks=(r"\bGRBLHAL\b",),
)
