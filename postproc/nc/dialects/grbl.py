"""GRBL 1.1: RS274/NGC without cycles, cutter radius, tool table, variables; `;` and `( )` comments,
`$` lines are no program.

Codes and arc check: gnea/grbl, grbl/gcode.c (gc_execute_line: a program begins in G0, as the state
is cleared to; the words I J K of an arc are taken together, and those outside of the plane are not
looked at); wiki "Grbl v1.1 Commands" for `$` and realtime bytes.
"""

from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

HOMING = r"^[ \t]*\$H[ \t\r]*$"
# what CNCjs keeps to itself: %wait, and variables, %X0=posx (CNCjs wiki, "Macro Usage")
SENDER = r"^[ \t]*%[ \t]*(?:wait\b|[a-z_]\w*[ \t]*=)[^\n]*$"
# Homes one axis: it passes, and no axis has a known place behind it.
ONE_AXIS = (r"^[ \t]*\$H[A-Z][ \t\r]*$", 0)

DIALECT = Dialect(
    name="grbl",
    title="GRBL 1.1",
    codes=(
        *shared.COMMON,
        *shared.UNITS,
        *shared.PER_TIME,
        *shared.NO_CUTTER,
        *shared.NO_LENGTH,
        *shared.LENGTH_WORDS,
        *shared.DATA,
        *shared.SET,
        *shared.SET_ZERO,
        *shared.STORE_REFERENCE,
        *shared.CENTRE_BY_START,
        *shared.PROBE,
        *shared.NO_MOTION,
        *rows("path", {"61": "exact path"}),
    ),
    m_codes={
        0: "stop",
        1: "optional stop",
        2: "end of program",
        3: "spindle clockwise or laser",
        4: "spindle counter-clockwise or laser with the speed",
        5: "spindle stop",
        7: "mist coolant",
        8: "coolant",
        9: "coolant off",
        30: "end of program, rewind",
        56: "parking motion",
    },
    # reports, go on; $J moves
    grammar=Grammar(
        ignores=(r"^[ \t]*(?:\$[$#GIX]|[?~])[ \t\r]*$", SENDER), homing=HOMING, macros=(ONE_AXIS,)
    ),
    motion=0,
    homes=True,
    skips_centre=True,
    change_returns="Z",
    # gcode.c, step 20: start and end radius may differ by 0.005 mm, by more up to a thousandth of
    # the radius, by more than 0.5 mm never.
    arc_tolerance_mm=0.005,
    arc_tolerance_relative=0.001,
    arc_tolerance_most_mm=0.5,
    signs=(r"^[ \t]*\$[HJXCIGNS#$]", r"^[ \t]*\$\d+[ \t]*="),
    remarks=(r"(?<![A-Z])GRBL(?!HAL)\b",),
)
