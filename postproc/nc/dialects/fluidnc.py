"""FluidNC: GRBL's words with M6, outputs, variables and O-word flow control; `;` and `( )`
comments.

Codes: bdring/FluidNC, FluidNC/src/GCode.cpp (gc_execute_line), Flowcontrol.cpp, Expression.cpp.
"""

from postproc.nc import codes
from postproc.nc.dialects import grbl
from postproc.nc.dialects.linuxcnc import OUTPUTS
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows
from postproc.records import replace

# reports and unlocking; $J moves
GRAMMAR = Grammar(
    ignores=(r"^[ \t]*\$[$#GIX][ \t\r]*$", grbl.SENDER), homing=grbl.HOMING, macros=(grbl.ONE_AXIS,)
)

DIALECT = replace(
    grbl.DIALECT,
    name="fluidnc",
    title="FluidNC",
    codes=(
        *grbl.DIALECT.codes,
        *rows(
            "", {f"38.{n}": "probe, this block alone" for n in (6, 7, 8, 9)}, refuses=codes.PROBE
        ),
    ),
    m_codes={**grbl.DIALECT.m_codes, 6: "tool change", **OUTPUTS},
    language="linuxcnc",
    expand_decimals=4,
    grammar=GRAMMAR,
    turns=True,
    letters="E",
    signs=(
        r"^[ \t]*\$[HJXCIGNS#$/]",
        r"^[ \t]*\$(SD|LOCALFS|MACROS?)/",
        r"#\d+[ \t]*=",
        r"G38\.[6-9]\b",
    ),
    remarks=(r"\bFLUIDNC\b",),
)
