"""Haas lathes: Fanuc's system A with codes of their own; T words select the offset, U W are
increments.

Codes: Haas Lathe Operator's Manual (Next Generation Control, 96-8900), "G-codes" and "M-codes";
G390 and G391 are its absolute and incremental position commands, as G90 is a cycle. `;`
is the end of block as that manual prints it; comments are in ( ). A coordinate without a decimal
point is a number of least increments, unless setting 162 (Default To Float) is on, says the same
manual. The drilling cycles give R as a place, and have no return level.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.dialects.fanuc_lathe import TURNING
from postproc.nc.dialects.fanuc_lathe_a import CYCLES, FEED_AND_SHIFT
from postproc.nc.dialects.haas import INTEGER_NOTICE, M_CODES
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

_BY_LETTER = "whether X is a diameter then is in no text that was found: write U W H"

DIALECT = Dialect(
    name="haas-lathe",
    title="Haas lathe",
    codes=(
        *shared.MOTION,
        *shared.PLANE,
        *shared.UNITS,
        *shared.WORK,
        *shared.SPINDLE,
        *shared.CUTTER,
        *shared.REFERENCE,
        *shared.MACHINE_FRAME,
        *shared.DWELL,
        *shared.DATA,
        *shared.LOCAL,
        *shared.MACRO,
        *FEED_AND_SHIFT,
        *rows("shift", {"51": "no shift"}, does="set zero", like="G92.1"),
        *rows("work offset", {"154": "additional work offset P"}, does="extended", like="G54.1"),
        *rows(
            "work offset",
            # G112 and G113 are the polar interpolation here.
            {str(n): f"work offset {n - 103}" for n in range(110, 130) if n not in (112, 113)},
        ),
        *CYCLES,
        *rows("motion", TURNING | {"74": "end face grooving"}, refuses=codes.CYCLE),
        *rows("", {"76": "threading in many passes"}, takes=True, does="thread cycle"),
        *rows("distance", {"390": "absolute words"}, like="G90"),
        *rows("distance", {"391": "incremental words"}, like="G91", refuses=_BY_LETTER),
        *rows("motion", {"80": "end of drilling cycles"}),
        *rows(
            "motion",
            {
                "81": "drilling",
                "82": "spot drilling",
                "83": "peck drilling",
                "85": "boring",
                "86": "boring, spindle stop",
                "89": "boring with dwell",
                "241": "radial drilling",
                "242": "radial spot drilling",
                "243": "radial peck drilling",
                "245": "radial boring",
                "246": "radial boring, spindle stop",
                "249": "radial boring with dwell",
            },
            refuses=codes.CYCLE,
        ),
        *rows(
            "cycle",
            {
                "84": "tapping",
                "184": "left-hand tapping",
                "186": "left-hand tapping with the live tool",
            },
            does="tap Z",
        ),
        *rows("cycle", {"195": "radial tapping", "196": "radial left-hand tapping"}, does="tap X"),
        *rows("cycle", {"95": "tapping with the live tool"}, does="tap Z", like="G84"),
        *rows(
            "motion",
            {
                "87": "boring, out by hand",
                "88": "boring, out by hand",
                "247": "radial boring, out by hand",
                "248": "radial boring, out by hand",
                "156": "broaching",
                "5": "live tool and spindle together",
                "105": "bar feeder",
            },
            refuses=codes.WRITE_OUT,
        ),
        *rows(
            "motion",
            {"31": "skip", "211": "tool offset by hand", "212": "tool offset, measured"},
            refuses=codes.PROBE,
        ),
        *rows("mirror", {"100": "no mirror"}, takes=True),
        *rows("mirror", {"101": "mirror"}, refuses=codes.UNTURNED),
        *rows("cylinder", {"107": "cylindrical mapping"}, refuses=codes.TRANSFORM),
        *rows("polar", {"113": "no XY to XC"}, does="polar off"),
        *rows("polar", {"112": "XY to XC"}, does="polar on"),
        *rows("spindle", {"15": "main spindle"}),
        *rows("spindle", {"14": "second spindle, Z mirrored"}, refuses=codes.UNTURNED),
        *rows("", {"200": "index while moving"}, takes=True, refuses=codes.WRITE_OUT),
        *rows("path", {"61": "exact stop", "64": "no exact stop"}),
        *rows(
            "",
            {
                "9": "exact stop in this block",
                "103": "blocks looked ahead",
                "187": "smoothness",
                "198": "spindles apart",
                "199": "spindles together",
            },
        ),
        *rows("", {"29": "from the reference point"}, takes=True),
        *rows("", {"266": "rapid of the axes at a rate"}),
    ),
    m_codes={
        # What a lathe means otherwise (M21 to M24: tailstock and chamfer) stands behind these and
        # replaces them.
        **M_CODES,
        10: "chuck clamps",
        11: "chuck unclamps",
        12: "air jet on",
        13: "air jet off",
        14: "spindle clamps",
        15: "spindle unclamps",
        17: "turret turns forward",
        18: "turret turns back",
        20: "ask for the second spindle",
        21: "tailstock advances",
        22: "tailstock retracts",
        23: "chamfering on",
        24: "chamfering off",
        36: "parts catcher on",
        37: "parts catcher off",
        38: "speed variation on",
        39: "speed variation off",
        43: "turret unlocks",
        44: "turret locks",
        70: "bar feeder",
        76: "program display off",
        77: "program display on",
        85: "door opens",
        86: "door closes",
        88: "high pressure coolant",
        110: "second chuck clamps",
        111: "second chuck unclamps",
        119: "orient the second spindle",
        **dict.fromkeys(range(121, 129), "output"),
        133: "live tool forward",
        134: "live tool back",
        135: "live tool stops",
        143: "second spindle forward",
        144: "second spindle back",
        145: "second spindle stops",
        154: "C axis engages",
        155: "C axis disengages",
    },
    restarts=(99,),
    motion=0,
    m_refuses={96: codes.INLINE, 97: codes.CALL, 98: codes.CALL, 99: codes.CALL, 198: codes.CALL},
    grammar=Grammar(semicolon="end of block", ignores=(shared.PRINTS,), slash_within=True),
    language="fanuc",
    plane=180,
    polar="Y",
    increments={"U": "X", "V": "Y", "W": "Z", "H": "C"},
    drawn="CRAIK",
    tool_offsets=True,
    integers="least increments",
    integer_notice=INTEGER_NOTICE,
    one_code_per_group=False,
    extended_by_p=True,
    digits=8,
    counts=0.001,
    exact_stops=(90, 610),
    threads_chained=(330,),
    thread_words="FE",
    letters="E",
    signs=(
        r"^(N\d+[ \t]*)?T(?!0000)\d{3,4}\b",
        r"G154[ \t]*P\d",
        r"M15[45]\b",
        r"M13[345]\b",
        r"G24[1-9]\b",
        r"M97[ \t]*P\d",
        r"G50[ \t]*S\d",
        r"G7[1-2][ \t]*P\d+[ \t]*Q\d+.*\bD",
        r"G7[0-3][ \t]*P\d+[ \t]*Q\d+",
        r"G9[024][ \t]*X-?[\d.]+[ \t]*Z",
        r"G99\b.*\bF0?\.\d|\bF0?\.\d.*\bG99\b",
        *shared.MACRO_SIGNS,
        r"^O\d{5}\b(?![ \t]*[A-Z])",
    ),
    remarks=(r"\bHAAS\b", r"\b[SD]ST?-?\d{2}Y?\b", r"\bTL-?\d\b"),
    excludes=(r"G76[ \t]*P\d{6}",),  # the thread of two blocks
)
