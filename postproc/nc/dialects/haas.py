"""Haas mills: Fanuc's words, G154 P and G110-G129 work offsets, G12 G13 G150 pockets, G70-G72 bolt
holes, M97 local calls.

Codes: Haas Mill Operator's Manual (Next Generation Control, 96-8210), "G-codes" and "M-codes". `;`
is the end of block as that manual prints it; comments are in ( ). A coordinate without a decimal
point is a number of least increments, unless setting 162 (Default To Float) is on, says the same
manual; G52 and G92 as with setting 33 (Coordinate System) FANUC. Behind a slash within a line what
follows is left out with block delete on (Haas Automation, Lathe Series Training Manual, "Program
format").
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

# what mills and lathes of Haas have alike
M_CODES = {
    **codes.SPINDLE_AND_COOLANT,
    **dict.fromkeys(range(21, 29), "output, wait for it"),
    **dict.fromkeys(range(51, 60), "output on"),
    **dict.fromkeys(range(61, 70), "output off"),
    31: "chips out",
    33: "chips stop",
    41: "gear",
    42: "gear",
    78: "alarm if skipped",
    79: "alarm if not skipped",
    89: "coolant off",
    90: "fixture clamp",
    91: "fixture clamp",
    95: "sleep",
    104: "probe arm",
    105: "probe arm",
    109: "ask the user",
}
INTEGER_NOTICE = (
    "coordinates without a decimal point count 0.001 mm or 0.0001 inch (setting 162 off); with"
    " setting 162 on the program means whole millimetres or inches"
)

DIALECT = Dialect(
    name="haas",
    title="Haas mill",
    codes=(
        *shared.COMMON,
        *shared.UNITS,
        *shared.FEED_MODE,
        *shared.SPINDLE,
        *shared.CUTTER,
        *shared.LENGTH,
        *shared.LENGTH_MINUS,
        *shared.DATA,
        *shared.LOCAL,
        *shared.SET,
        *shared.MACRO,
        *shared.NO_MOTION,
        *shared.RETURN,
        *shared.PECKS,
        *shared.DRILL,
        *shared.BORE,
        *shared.TAP,
        *shared.SCALING,
        *shared.ROTATION,
        *rows("work offset", {"154": "additional work offset P"}, does="extended", like="G54.1"),
        *rows("work offset", {str(n): f"work offset {n - 103}" for n in range(110, 130)}),
        *shared.FINE_BORE,
        *rows("motion", {"77": "back boring"}, refuses=codes.WRITE_OUT),
        *rows("motion", {"87": "boring, out by hand"}, refuses=codes.WRITE_OUT),
        *rows("motion", {"88": "boring, dwell, out by hand"}, does="drill"),
        *rows("motion", {"156": "broaching"}, refuses=codes.WRITE_OUT),
        *rows(
            "motion",
            {
                "153": "five-axis cycle",
                "155": "five-axis cycle",
                # G161 to G169, of which G167 changes a setting.
                **{str(n): "five-axis cycle" for n in range(161, 170) if n != 167},
            },
            refuses=codes.TOOL_POINT,
        ),
        *rows(
            "motion",
            {"174": "tapping across the spindle", "184": "tapping across the spindle"},
            refuses=codes.WRITE_OUT,
        ),
        *rows(
            "motion",
            {
                "31": "skip",
                "35": "tool diameter, measured",
                "36": "work offset, measured",
                "37": "tool length, measured",
                "136": "work centre, measured",
            },
            refuses=codes.PROBE,
        ),
        *rows(
            "",
            {"12": "circular pocket, clockwise", "13": "circular pocket, counter-clockwise"},
            takes=True,
            refuses=codes.CYCLE,
        ),
        *rows("", {"150": "pocket"}, takes=True, refuses=codes.CYCLE),
        *rows("", {"47": "engraving"}, does="engrave"),
        *rows(
            "", {"70": "bolt holes on a circle", "71": "bolt holes on an arc"}, refuses=codes.CYCLE
        ),
        *rows("", {"72": "bolt holes on a line"}, refuses=codes.WRITE_OUT),
        *rows("mirror", {"100": "no mirror"}, takes=True),
        *rows("mirror", {"101": "mirror"}, refuses=codes.FRAME),
        *rows("cylinder", {"107": "cylindrical mapping"}, refuses=codes.TRANSFORM),
        *rows("cutter", {"141": "cutter radius in space"}, refuses=codes.CUTTER),
        *rows("tool length", {"234": "tool centre point"}, does="tip"),
        *rows("tool length", {"143": "five-axis tool length"}, refuses=codes.TOOL_POINT),
        *rows("work mode", {"255": "no dynamic work offset"}),
        *rows("work mode", {"254": "dynamic work offset"}, refuses=codes.TILTED),
        *rows("feature", {"269": "no feature coordinates"}),
        *rows(
            "feature",
            {"268": "feature coordinates", "253": "spindle across the feature"},
            refuses=codes.TILTED,
        ),
        *rows("path", {"61": "exact stop", "64": "no exact stop"}),
        *rows(
            "",
            {
                "9": "exact stop in this block",
                "60": "positioning from one direction",
                "103": "blocks looked ahead",
                "167": "change a setting",
                "187": "smoothness",
            },
        ),
        *rows("", {"29": "from the reference point"}, takes=True),
        *rows("", {"266": "rapid of the axes at a rate"}),
    ),
    m_codes={
        **M_CODES,
        10: "fourth axis brake on",
        11: "fourth axis brake off",
        12: "fifth axis brake on",
        13: "fifth axis brake off",
        16: "tool change",
        17: "unclamp and open",
        18: "clamp and close",
        34: "coolant nozzle",
        35: "coolant nozzle",
        36: "pallet ready",
        39: "turn the turret",
        50: "pallet change",
        73: "air on",
        74: "air off",
        75: "reference for G35 G136",
        80: "door opens",
        81: "door closes",
        82: "tool unclamp",
        83: "air gun on",
        84: "air gun off",
        86: "tool clamp",
        88: "coolant through the spindle",
        116: "lubrication",
        117: "lubrication",
        130: "show a picture",
        131: "no picture",
        138: "speed variation on",
        139: "speed variation off",
        158: "mist collector on",
        159: "mist collector off",
    },
    restarts=(99,),
    motion=0,
    m_refuses={
        46: codes.INLINE,
        96: codes.INLINE,
        97: codes.CALL,
        98: codes.CALL,
        99: codes.CALL,
        198: codes.CALL,
    },
    grammar=Grammar(semicolon="end of block", ignores=(shared.PRINTS,), slash_within=True),
    language="fanuc",
    # Where the tables stand for its axes is in no text that was found: asked for where it matters.
    tip_frame="",
    change_takes="Z",
    length_left_open=True,
    length_lapses=(280,),
    length_modal=True,
    integers="least increments",
    integer_notice=INTEGER_NOTICE,
    one_code_per_group=False,
    extended_by_p=True,
    digits=8,
    counts=0.001,  # mm and degrees; in inches a tenth of it (setting 162 off)
    hole_from_start=True,
    exact_stops=(90, 610),
    letters="E",
    signs=(
        r"G154[ \t]*P\d",
        r"G187\b",
        r"G103[ \t]*P\d",
        r"M97[ \t]*P\d",
        r"G1[23][ \t]*[ID][\d.]",
        r"G150\b",
        r"G47[ \t]*P\d",
        r"G1(1\d|2\d)\b",
        r"G7[012][ \t]*I[\d.]",
        *shared.MACRO_SIGNS,
        r"^O\d{5}\b(?![ \t]*[A-Z])",
    ),
    remarks=(r"\bHAAS\b", r"\bVF-?\d\b"),
)
