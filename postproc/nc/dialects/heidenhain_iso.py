"""Heidenhain TNC in DIN/ISO: `*` ends a block, % NAME G71 * begins and ends a program, I J set a
pole that stays.

G functions: HEIDENHAIN TNC 640, iTNC 530 and TNC 426 user's manuals, ISO programming, "G functions"
and "M functions". G17-G19 name the tool axis and so the plane, G70 G71 the unit, T the tool with
its length, G98 L a label; --offset G54= is the datum in force. G05 G06 G07 and polar G10-G16 take
their shape from what came before. Numbers without a point are whole units.
"""

from postproc.nc import codes
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.klartext import OWN_FEED
from postproc.nc.rows import CUTTER, DISTANCE, MOTION, PLANE, rows

_POLE = (
    "its centre is the pole, which I and J set for all blocks behind: --expand writes it out as"
    " straight lines"
)
_POLAR = "its end is an angle and a radius about the pole: let the CAM program write X Y Z"
_TO_POLE = "its end is an angle and a radius about the pole: --expand writes X and Y"
_ROUND = "its end is an angle about the pole: --expand writes it out as straight lines"
_CORNER = "the corner between two lines is the control's own: --expand writes it out"
_DATUM = (
    "it moves the datum, by the tables of the control or by its last one: program in one datum,"
    " with --offset G54="
)
# move as soon as they are defined: three patterns of points, and two measurements of the machine
_AT_ONCE = (220, 221, 224, 238, 239)
# cycles of older controls that wait for a call, or hold data alone
_OLD = (*range(56, 60), *range(74, 79), *range(83, 87), *range(120, 130), 135)
# the same: drilling and tapping, old slots and faces, engraving, face
# milling, pockets, studs and slots, threads, contours
_CALLED = (
    *(*range(200, 216), 225, *range(230, 234), 240, 241, *range(251, 255), *range(256, 259)),
    *(*range(262, 266), 267, *range(270, 278)),
)

DIALECT = Dialect(
    name="heidenhain-iso",
    title="Heidenhain TNC, DIN/ISO",
    codes=(
        *MOTION[:2],
        *PLANE,
        *DISTANCE,
        *CUTTER,
        *rows("motion", {"2": "arc, clockwise", "3": "arc, counter-clockwise"}, refuses=_POLE),
        *rows("units", {"70": "inch"}, like="G20"),
        *rows("units", {"71": "millimetre"}, like="G21"),
        *rows(
            "motion",
            {"5": "arc, either way", "6": "arc, tangential"},
            refuses=(
                "its circle follows from other places: let the CAM program write straight lines"
            ),
        ),
        *rows("motion", {"7": "along one axis"}, refuses=codes.WRITE_OUT),
        *rows("motion", {"10": "rapid, polar", "11": "straight feed, polar"}, refuses=_TO_POLE),
        *rows("motion", {"12": "arc, polar", "13": "arc, polar"}, refuses=_ROUND),
        *rows("motion", {"15": "arc, polar", "16": "arc, polar"}, refuses=_POLAR),
        *rows(
            "", {"26": "tangential approach", "27": "tangential departure"}, refuses=codes.CORNER
        ),
        *rows("", {"24": "chamfer", "25": "rounded corner"}, refuses=_CORNER),
        *rows(
            "paraxial",
            {"43": "longer by the radius", "44": "shorter by the radius"},
            refuses=codes.CUTTER,
        ),
        *rows("", {"4": "dwell"}),
        *rows(
            "",
            {
                "30": "blank, lower corner",
                "31": "blank, upper corner",
                "99": "tool definition",
                "51": "next tool",
                "98": "label",
                "29": "pole at the last place",
                "36": "spindle orientation",
                "38": "stop",
                "62": "tolerance",
                "50": "protection off",
                "37": "contours of the pocket",
                "39": "program to call",
            },
            takes=True,
            does="words",
        ),
        *rows("datum", {"53": "datum from a table", "247": "preset"}, takes=True, refuses=_DATUM),
        # G54 X+10 is a shift here, no table of offsets: --offset G54= is the datum beneath it.
        *rows("", {"54": "datum shift"}, takes=True, does="datum shift"),
        *rows("mirror", {"28": "mirror"}, refuses=codes.UNTURNED),
        *rows("rotation", {"73": "rotation of the coordinates"}, refuses=codes.UNTURNED),
        *rows("scaling", {"72": "scaling"}, refuses=codes.UNTURNED),
        *rows("rotation", {"80": "working plane"}, refuses=codes.TILTED, like="G68.2"),
        *rows("", {"55": "probe"}, takes=True, refuses=codes.PROBE),
        *rows("", {"79": "cycle call"}, refuses=codes.CYCLE),
        *rows("", {str(n): "cycle, defined" for n in (*_OLD, *_CALLED)}, takes=True, does="words"),
        *rows(
            "",
            {str(n): "cycle that moves where it is defined" for n in _AT_ONCE},
            takes=True,
            refuses=codes.WRITE_OUT,
        ),
    ),
    change_takes="Z",
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        13: "spindle clockwise and coolant",
        14: "spindle counter-clockwise and coolant",
        90: "constant speed",
        97: "small contour steps",
        98: "open contour corners",
        103: "plunge feed",
        107: "tool change",
        108: "tool change",
        109: "feed at the edge",
        110: "feed at the edge",
        111: "feed at the path",
        116: "feed of rotary axes",
        117: "feed of rotary axes",
        120: "look ahead",
        126: "shorter way",
        127: "longer way",
        128: "tool centre point",
        129: "no tool centre point",
        136: "feed per turn",
        137: "feed per minute",
        141: "probe monitoring",
        143: "no rotation",
        148: "lift off",
        149: "no lift off",
    },
    m_refuses={
        89: codes.WRITE_OUT,
        99: codes.CYCLE,
        91: (
            "its block is in machine coordinates, which are not told apart here: write it at the"
            " datum in force"
        ),
        92: _DATUM,
        94: codes.ITSELF,
        114: codes.TOOL_POINT,
        118: codes.ITSELF,
        124: codes.ITSELF,
        130: codes.TILTED,
        138: codes.TOOL_POINT,
        140: codes.WRITE_OUT,
        142: codes.RESTORED,
        144: codes.TOOL_POINT,
    },
    grammar=Grammar(
        ignores=(
            r"^[ \t]*(?:N[0-9]+[ \t]*)?%[^ \t*\n]*(?:[ \t]+(G7[01]))?",  # the name; its unit stays
            # by how much the radius of the tool (R2: of its corner) differs: of T, as in Klartext
            r"(?<![A-Z])DR2?[ \t]*[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?![0-9.])",
            OWN_FEED,
        )
    ),
    dwell="F",
    g_takes=(*_CALLED, *_AT_ONCE),  # Q200=2 and its kin are a cycle's own
    tip_codes={128: True, 129: False},
    arc_centre="pole",
    length_letter="T",
    block_end="*",
    # N99999999 %NAME is the last block of a program, D00 to D09 are its formulas.
    signs=(
        r"^[ \t]*%[ \t]*[\w$.+-]+[ \t]+G7[01][ \t]*\*",
        r"[\dA-Z][ \t]*\*[ \t]*$",
        r"G99[ \t]*T\d+",
        r"G79\b",
        r"G98[ \t]*L\d+",
        r"\bN9{8}\b",
        r"G30[ \t]*G17\b",
        r"\bD0\d[ \t]*Q\d",
        r"^[ \t]*(N\d+[ \t]+)?I[-+]?\d[\d.]*[ \t]*J[-+]?\d",
    ),
    remarks=(r"\bHEIDENHAIN\b", r"\bI?TNC ?\d{3}\b"),
)
