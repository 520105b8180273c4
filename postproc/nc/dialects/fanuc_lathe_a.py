"""Fanuc lathes in G-code system A: U W H V are increments, without G90 G91; G98 G99 are feed per
minute and turn.

Words and groups: Fanuc Series 0i-TD user's manual B-64304EN-1, G code list, column A; G90 G92 G94
are the cycles that systems B and C call G77 G78 G79 and G20 G21 G24, G50 is their G92.
"""

from postproc.nc import codes
from postproc.nc.dialects import fanuc_lathe
from postproc.nc.dialects.fanuc_lathe import TURNING
from postproc.nc.rows import CUTTER, DRAWS, FANUC_LATHE, MACRO_SIGNS, UNITS, rows
from postproc.records import replace

# of this system on other lathes too
FEED_AND_SHIFT = [
    *rows("feed mode", {"98": "feed per minute"}, like="G94"),
    *rows("feed mode", {"99": "feed per turn"}, like="G95"),
    *rows("shift", {"50": "set coordinates, or speed limit"}, takes=True, does="set", like="G92"),
]
CYCLES = [
    *rows("motion", {"32": "thread"}, does="thread", like="G33"),
    *rows("motion", {"90": "turning cycle"}, refuses=codes.CYCLE, like="G77"),
    *rows("motion", {"92": "threading cycle"}, does="thread cycle", like="G78"),
    *rows("motion", {"94": "facing cycle"}, refuses=codes.CYCLE, like="G79"),
]

DIALECT = replace(
    fanuc_lathe.DIALECT,
    name="fanuc-lathe-a",
    title="Fanuc lathe, G-code system A",
    codes=(
        *FANUC_LATHE,
        *UNITS,
        *CUTTER,
        *FEED_AND_SHIFT,
        *rows("shift", {"50.3": "no position shift"}, takes=True, does="set zero", like="G92.1"),
        *CYCLES,
        *rows("motion", TURNING, refuses=codes.CYCLE),
        *rows("", {"76": "threading in many passes"}, takes=True, does="thread cycle"),
    ),
    # G32 here, which counts as the G33 of the other systems (`like`).
    threads_chained=(330,),
    # G50 as the speed limit, G90 G92 G94 as cycles and G99 as the feed per turn tell it from the
    # systems B and C.
    signs=(
        *MACRO_SIGNS,
        DRAWS,
        r"^[O:]\d{4}(\d{4})?\b(?![ \t]*[A-Z])",
        r"^(N\d+[ \t]*)?(G0?0[ \t]*)?T(?!0000)\d{4}\b",
        r"G50[ \t]*S\d",
        r"G7[1-3][ \t]*[UW]-?[\d.]+",
        r"G7[0-3][ \t]*P\d+[ \t]*Q\d+",
        r"G76[ \t]*P\d{6}",
        r"G9[024][ \t]*X-?[\d.]+[ \t]*Z",
        r"G99\b.*\bF0?\.\d|\bF0?\.\d.*\bG99\b",
    ),
    remarks=(r"\bFANUC\b",),
)
