"""Fanuc machining centres, Series 0i and 30i: G54.1 P offsets, G43 H lengths, canned cycles with K
repeats.

`;` is the end of block as Fanuc's manuals print it, so several blocks may stand in a line; comments
are in ( ) alone.
Words and groups: B-64304EN-2 and B-64484EN-2, user's manuals for machining centre systems, G code
list. A coordinate without a decimal point: parameter 3401 bit 0 (DPI), B-64490EN. G43.4 G68.2 and
their kin: B-64484EN-2, five-axis functions.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

INTEGER_NOTICE = (
    "coordinates without a decimal point are read as whole millimetres or inches (calculator"
    " input); on a control that reads them as least increments the program means something else"
)
# O of five digits; a call within the program
HAAS_ALONE = (r"^O\d{5}\b(?![ \t]*[A-Z])", r"M97[ \t]*P\d")

DIALECT = Dialect(
    name="fanuc-mill",
    title="Fanuc machining centre",
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
        *shared.FANUC,
        *shared.NO_POLAR,
        *shared.NO_MOTION,
        *shared.RETURN,
        *shared.PECKS,
        *shared.DRILL,
        *shared.BORE,
        *shared.BORE_BY_HAND,
        *shared.TAP,
        *shared.BACK_BORE,
        *shared.THREAD,
        *shared.SCALING,
        # Without its G69, which here ends a tilted plane (G68.2) too and has a row of its own.
        *shared.ROTATION[1:],
        *rows(
            "shift",
            {"92.1": "work coordinates as if nothing had been set"},
            takes=True,
            does="set zero",
        ),
        *rows("work offset", {"54.1": "additional work offset P"}, does="extended"),
        *shared.FINE_BORE,
        *rows("motion", {"84.2": "rigid tapping", "84.3": "left-hand rigid tapping"}, does="tap"),
        *rows(
            "motion",
            dict.fromkeys(("75", "77", "78", "79"), "grinding cycle"),
            refuses=codes.WRITE_OUT,
        ),
        *rows(
            "motion",
            {"35": "circular thread, clockwise", "36": "circular thread, counter-clockwise"},
            refuses=codes.CURVE,
        ),
        # What --expand writes out is refused here all the same: the sentence names the option.
        *rows("motion", {"6.2": "NURBS"}, refuses=codes.SPLINE),
        *rows(
            "motion",
            {
                "2.2": "involute",
                "3.2": "involute",
                "2.3": "exponential",
                "3.3": "exponential",
                "2.4": "3D circle",
                "3.4": "3D circle",
            },
            refuses=codes.CURVE,
        ),
        *rows("motion", {"37": "tool length, measured"}, refuses=codes.PROBE),
        *rows("motion", {"81.1": "chopping"}, refuses=codes.ITSELF),
        *rows("mirror", {"50.1": "no mirror"}, takes=True),
        *rows("mirror", {"51.1": "mirror"}, refuses=codes.FRAME),
        *rows("polar words", {"15": "no polar coordinates"}),
        *rows("polar words", {"16": "polar coordinates"}, refuses=codes.FRAME),
        *rows("rotation", {"69": "no rotation, no tilted plane"}, does="plane off"),
        *rows("rotation", {"68.2": "tilted plane"}, takes=True, does="plane"),
        *rows("rotation", {"68.3": "tilted plane", "68.4": "tilted plane"}, refuses=codes.TILTED),
        *rows("", {"53.1": "tool axis into the tilted plane"}, does="plane align"),
        *rows("normal direction", {"40.1": "no normal direction control"}),
        *rows("normal direction", {"150": "no normal direction control"}, like="G40.1"),
        *rows(
            "normal direction",
            {"41.1": "normal direction, left", "42.1": "normal direction, right"},
            refuses=codes.ITSELF,
        ),
        *rows(
            "normal direction",
            {"151": "normal direction, left"},
            refuses=codes.ITSELF,
            like="G41.1",
        ),
        *rows(
            "normal direction",
            {"152": "normal direction, right"},
            refuses=codes.ITSELF,
            like="G42.1",
        ),
        *rows(
            "cutter",
            {f"{n}.{k}": "cutter radius in space" for n in (41, 42) for k in (2, 3, 4, 5, 6)},
            refuses=codes.CUTTER,
        ),
        *rows("tool length", {"43.4": "tool centre point"}, does="tip"),
        *rows(
            "tool length",
            {"43.1": "length along the tool axis", "43.3": "nutating head"},
            refuses=codes.TOOL_POINT,
        ),
        *rows(
            "tool length",
            {"43.5": "tool centre point, by the tool's direction"},
            refuses=codes.DIRECTION,
        ),
        *rows("tool length", {"49.1": "no tool centre point"}, does="no length"),
        *rows(
            "fixture offset",
            {"54.2": "offset that turns with the table", "54.4": "setting error of the workpiece"},
            refuses=codes.TILTED,
        ),
        *rows(
            "",
            dict.fromkeys(("45", "46", "47", "48"), "move changed by an offset"),
            refuses=codes.CUTTER,
        ),
        *rows("", {"39": "corner rounded by the cutter radius"}, takes=True, refuses=codes.CORNER),
        *rows(
            "",
            {"72.1": "copies, turned", "72.2": "copies, moved"},
            takes=True,
            refuses=codes.WRITE_OUT,
        ),
        *rows(
            "",
            {"29": "from the reference point", "30.1": "to the floating reference point"},
            takes=True,
        ),
        *rows(
            "",
            {
                "60": "positioning from one direction",
                "5": "high speed",
                "8": "look-ahead",
                "5.4": "high speed control",
            },
        ),
        *rows(
            "",
            {"5.1": "smoothing, high speed", "91.1": "check of the largest increment"},
            takes=True,
            does="words",
        ),
        *rows("path", {"61.1": "geometry compensation of Mazak", "62": "corner override"}),
        *rows(
            "macro",
            {"66.1": "macro call in every block"},
            refuses=(
                "the same text runs at several places: write G65 in the blocks that shall call it"
            ),
        ),
    ),
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        10: "clamp",
        11: "unclamp",
        13: "spindle clockwise and coolant",
        14: "spindle counter-clockwise and coolant",
        29: "rigid tapping",
        88: "coolant through the spindle",
        89: "coolant off",
    },
    restarts=(99,),
    home_named=True,
    motion=0,
    m_refuses={98: codes.CALL, 99: codes.CALL, 198: codes.CALL},
    grammar=Grammar(
        semicolon="end of block", ignores=(shared.PRINTS, shared.NAMED_PROGRAM, shared.DRAWS)
    ),
    language="fanuc",
    tip_frame="call",  # parameter 19696 bit 5 = 0 (docs/FIVE_AXES.md)
    change_takes="Z",
    length_left_open=True,
    length_lapses=(280, 300, 530),
    length_modal=True,
    dwell="PX",
    integer_notice=INTEGER_NOTICE,
    skips_centre=True,
    one_code_per_group=False,
    extended_by_p=True,
    digits=8,
    hole_from_start=True,
    repeats="KL",
    exact_stops=(90, 610),
    thread_words="F",
    signs=(
        *shared.MACRO_SIGNS,
        shared.DRAWS,
        r"^[O:]\d{4}(\d{4})?\b(?![ \t]*[A-Z])",
        r"G54\.1[ \t]*P\d",
        r"G5\.1[ \t]*Q[01]",
        r"G0?5[ \t]*P10000",
        r"G10[ \t]*L50\b",
        r"M29\b",
    ),
    remarks=(r"\bFANUC\b",),
    excludes=HAAS_ALONE,
)
