"""Fanuc lathes and grinders in G-code system B: X in diameter, U W increments beside G90 G91, G4
with X, U or P.

`;` is the end of block as Fanuc's manuals print it, so several blocks may stand in a line; comments
are in ( ) alone.
Words and groups: Fanuc Series 0i-TD user's manual B-64304EN-1, G code list, column B. A coordinate
without a decimal point: parameter 3401 bit 0 (DPI), B-64310EN.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.dialects.fanuc_mill import HAAS_ALONE, INTEGER_NOTICE
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

TURNING = {
    "70": "finishing cycle",
    "71": "roughing cycle",
    "72": "facing cycle",
    "73": "pattern repeating",
    "74": "end face pecking",
    "75": "grooving",
}

DIALECT = Dialect(
    name="fanuc-lathe",
    title="Fanuc lathe or grinder, G-code system B",
    codes=(
        *shared.FANUC_LATHE,
        *shared.CUTTER,
        *shared.DISTANCE,
        *shared.UNITS,
        *shared.FEED_MODE,
        *shared.RETURN,
        *shared.SET,
        *rows("shift", {"92.1": "no position shift"}, takes=True, does="set zero"),
        *rows("motion", {"32": "thread", "33": "thread"}, does="thread"),
        *rows(
            "motion", {**TURNING, "77": "turning cycle", "79": "facing cycle"}, refuses=codes.CYCLE
        ),
        *rows("", {"76": "threading in many passes"}, takes=True, does="thread cycle"),
        *rows("motion", {"78": "threading cycle"}, does="thread cycle"),
        *rows("motion", {"81": "drilling", "82": "drilling with dwell"}, refuses=codes.WRITE_OUT),
        *rows("scaling", {"50": "no scaling"}),
        *rows("scaling", {"51": "scaling"}, refuses=codes.UNTURNED),
    ),
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        10: "chuck or clamp",
        11: "chuck or clamp",
        23: "chamfering on",
        24: "chamfering off",
        29: "rigid tapping",
        **dict.fromkeys(range(40, 45), "gear"),
    },
    restarts=(99,),
    home_named=True,
    motion=0,
    m_refuses={98: codes.CALL, 99: codes.CALL, 198: codes.CALL},
    grammar=Grammar(
        semicolon="end of block",
        ignores=(shared.BLANKS, shared.PRINTS, shared.NAMED_PROGRAM, shared.DRAWS),
    ),
    language="fanuc",
    plane=180,
    polar="C",
    # In system B beside G90 and G91: U is a distance in either.
    increments={"U": "X", "V": "Y", "W": "Z", "H": "C"},
    drawn="CRAIK",
    dwell="PXU",
    tool_offsets=True,
    extended_by_p=True,
    digits=8,
    level_from_start=True,
    repeats="KL",
    exact_stops=(90, 610),
    threads_chained=(320, 330),
    thread_words="FE",
    integer_notice=INTEGER_NOTICE,
    skips_centre=True,
    one_code_per_group=False,
    letters="E",
    signs=(
        *shared.MACRO_SIGNS,
        shared.DRAWS,
        r"^[O:]\d{4}(\d{4})?\b(?![ \t]*[A-Z])",
        r"^(N\d+[ \t]*)?T(?!0000)\d{4}\b",
        r"G92[ \t]*S\d",
        r"G7[1-6][ \t]*P\d+[ \t]*Q\d+",
        r"G7[78][ \t]*X",
    ),
    remarks=(r"\bFANUC\b", r"\bSTUDER\b"),
    excludes=HAAS_ALONE,
)
