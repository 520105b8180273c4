"""FluidNC: GRBL's words with M6, outputs, variables and O-word flow control; `;` and `( )`
comments.

Codes: bdring/FluidNC, FluidNC/src/GCode.cpp (gc_execute_line), Flowcontrol.cpp, Expression.cpp.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.dialects.grbl import HOMING, ONE_AXIS, SENDER
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

DIALECT = Dialect(
    name="fluidnc",
    title="FluidNC",
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
        *rows(
            "", {f"38.{n}": "probe, this block alone" for n in (6, 7, 8, 9)}, refuses=codes.PROBE
        ),
    ),
    m_codes={
        0: "stop",
        1: "optional stop",
        2: "end of program",
        3: "spindle clockwise or laser",
        4: "spindle counter-clockwise or laser with the speed",
        5: "spindle stop",
        6: "tool change",
        7: "mist coolant",
        8: "coolant",
        9: "coolant off",
        30: "end of program, rewind",
        56: "parking motion",
        61: "set tool number",
        62: "output",
        63: "output",
        64: "output",
        65: "output",
        66: "wait for input",
        67: "analog output",
        68: "analog output",
    },
    m_refuses={},
    language="linuxcnc",
    expand_decimals=4,
    # reports and unlocking; $J moves
    grammar=Grammar(
        ignores=(r"^[ \t]*\$[$#GIX][ \t\r]*$", SENDER), homing=HOMING, macros=(ONE_AXIS,)
    ),
    plane=170,
    motion=0,
    homes=True,
    skips_centre=True,
    change_returns="Z",
    dwell="P",
    turns=True,
    arc_tolerance_mm=0.005,
    arc_tolerance_relative=0.001,
    arc_tolerance_most_mm=0.5,
    letters="E",
    signs=(
        r"^[ \t]*\$[HJXCIGNS#$/]",
        r"^[ \t]*\$(SD|LOCALFS|MACROS?)/",
        r"#\d+[ \t]*=",
        r"G38\.[6-9]\b",
    ),
    remarks=(r"\bFLUIDNC\b",),
)
