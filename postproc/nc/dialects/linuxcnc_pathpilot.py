"""Tormach PathPilot: LinuxCNC's words, G50 in the first block of Autodesk's posts, no G52.

Tormach's documentation, "PathPilot Post Processor Guidelines" (it shares LinuxCNC's code; no G52,
G12, G13, G74, G87, G88). Autodesk's Tormach posts begin with G90 G54 G64 G50 G17 G40 G80 G94 G91.1
G49: there is no scaling that G50 could end, and G51 is refused.
"""

from postproc.nc.dialects import linuxcnc
from postproc.nc.rows import rows
from postproc.records import replace

ABSENT = ("G52", "G74", "G87", "G88")

DIALECT = replace(
    linuxcnc.DIALECT,
    name="linuxcnc-pathpilot",
    title="Tormach PathPilot",
    change_takes="Z",
    change_returns="",
    codes=(
        *(code for code in linuxcnc.DIALECT.codes if code.word not in ABSENT),
        *rows("scaling", {"50": "no scaling"}),
    ),
    signs=(r"\bG64[ \t]+G50[ \t]+G17\b",),
    remarks=(r"\bTORMACH\b", r"\bPATHPILOT\b"),
)
