"""Fagor mills, CNC 8055 M and 8058 to 8070: G70 G71 as units, holes by Z (reference plane) and I
(bottom), lines of # and $.

Sources: Fagor CNC 8055 M & EN programming manual, pages 47 (coordinates), 58 (offsets and G92), 87
to 93 (arcs), 162 and 177 (G81, G85); CNC 8065 quick reference, pages 45 (blocks) and 50 (G06 to
G12); what Autodesk's `fagor.cps` writes for 8058, 8060, 8065 and 8070. ( ) is a comment on the 8065
and a statement of the high-level language on the 8055: what begins like a statement is taken for
one. What these controls mean differently (G53, G58, G59, G82, G93), and what no page was found of
(G86, G89), is refused by its name, or is no code here (G20, G53). Tool lengths hold with D, at
once, as on the 8065; where G43 calls them they do so too.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

_HEAD = r"^[ \t]*(?:/[ \t]*)?(?:N[ \t]*\d+[ \t]*)?"
# statements in ( ) of the 8025 to 8055, and the reason of each
# The number of each is that of its sentence in `macro_refuses`, from 1.
_STATEMENTS = {
    r"(?:P\d+[ \t]*=|V\.)": 7,
    r"(?:IF|GOTO)\b": 9,
    r"PROBE\b": 10,
    r"ORG": 11,
    r"(?:RPT|CALL|PCALL|MCALL|MEXEC|EXEC|SUB|RET|MDOFF)\b": 4,
}
_STATEMENT = rf"\([ \t]*(?:{'|'.join(_STATEMENTS)})"
_QUIET = (
    r"#[ \t]*(?:MSG|WARNING|ERROR|DGWZ|DGSPDL|FLUSH|HSC|ESBLK|DSBLK|KIN[ \t]+ID)\b[^;\n]*|#["
    r" \t]*(?:RTCP|CS|ACS|MCS)[ \t]+OFF\b"
)
# Blocks in which R and Q are other words: holes, threads, corners, a rotation, the spindle's angle.
_ELSE = (
    r"(?![^;\n]*(?<![A-Z0-9])G[ \t]*0*(?:33|34|36|37|38|39|51|63|69|73|8\d)(?!\d))(?![^;\n]*M["
    r" \t]*0*19(?!\d))"
)
# R or Q and no axis: a radius and an angle about the pole. With X Y Z beside it R is an arc's
# radius.
_POLAR = (
    r"(?=[^;(\n]*(?<![A-Z])[RQ][ \t]*[-+.\d])(?![^;(\n]*(?<![A-Z])[XYZ][ \t]*[-+.\d])"
    + _ELSE
    + r"[^;\n]*"
)
_CENTRE = (
    "its centre is given another way: let the CAM program write I J K from the start of the arc"
)
_ANOTHER_CIRCLE = (
    "its circle follows from other places: write the arc with its centre I J K or with R"
)
_DATUM = (
    "it moves the datum, in ways in which these controls differ: program in G54 to G57, with"
    " --offset G54="
)
_DIFFER = (
    "the 8055 and the 8065 mean different cycles by it: let the CAM program write the hole out as"
    " G0 and G1"
)
_UNSEEN = (
    "how it goes out is in no text that was found: let the CAM program write the hole out as G0"
    " and G1"
)
_POLE = (
    "it sets a pole on one control and the feed on another: let the CAM program write X Y and G94"
)
_SPINDLE = "it goes in step with the spindle: cut threads and taps in a program of their own"
_AXES = "it gives the words to other axes: name the plane by G17, G18 or G19"

DIALECT = Dialect(
    name="fagor",
    title="Fagor mill",
    codes=(
        *shared.MOTION,
        *shared.PLANE,
        *shared.DISTANCE,
        *shared.DWELL,
        # One block in machine coordinates counts as G53; #MCS ON holds, and is refused below.
        *rows("", {"#MCS": "this block in machine coordinates"}, like="G53"),
        *shared.CUTTER,
        *shared.NO_MOTION,
        *shared.RETURN,
        *shared.SPINDLE,
        *rows("units", {"70": "inch"}, like="G20"),
        *rows("units", {"71": "millimetre"}, like="G21"),
        *rows("feed mode", {"94": "feed per minute", "95": "feed per turn"}),
        *rows("work offset", {str(n): f"work offset {n - 53}" for n in range(54, 58)}),
        *rows(
            "path",
            {
                "5": "round corner",
                "7": "square corner",
                "50": "controlled corner",
                "60": "square corner",
                "61": "controlled corner",
            },
        ),
        *rows("", {"51": "look ahead", "501": "high speed cutting"}, takes=True, does="words"),
        *rows("tool length", {"43": "tool length"}),
        *rows(
            "tool length",
            {"44": "no tool length"},
            refuses=(
                "it takes the length out of Z: write it where no motion follows, or leave the"
                " lengths on"
            ),
        ),
        *rows("", {"6": "absolute centre in this block"}, refuses=_CENTRE),
        *rows(
            "motion", {"8": "tangential arc", "9": "arc through a point"}, refuses=_ANOTHER_CIRCLE
        ),
        *rows("mirror", {"10": "no mirror"}),
        *rows(
            "mirror",
            {
                "11": "mirror of the first axis",
                "12": "mirror of the second axis",
                "13": "mirror of Z",
                "14": "mirror",
            },
            refuses=codes.UNTURNED,
        ),
        *rows("turned", {"72": "scaling", "73": "rotation"}, refuses=codes.UNTURNED),
        *rows("", {"16": "plane by two axes"}, takes=True, refuses=_AXES),
        *rows(
            "",
            {
                "36": "rounded corner",
                "37": "tangential approach",
                "38": "tangential departure",
                "39": "chamfer",
            },
            refuses=codes.CORNER,
        ),
        *rows("motion", {"33": "thread", "63": "rigid tapping"}, refuses=_SPINDLE),
        *rows(
            "datum",
            {"58": "further offset", "59": "further offset", "159": "offset by its number"},
            refuses=_DATUM,
        ),
        *rows(
            "datum",
            {"92": "set coordinates", "158": "incremental offset"},
            takes=True,
            refuses=_DATUM,
        ),
        *rows("feed mode", {"93": "feed as a time, or a pole"}, refuses=_POLE),
        *rows("", {"30": "pole"}, takes=True, refuses=_POLE),
        *rows("", {"74": "home search"}, takes=True),
        *rows("motion", {"75": "probing", "76": "probing"}, refuses=codes.PROBE),
        *rows(
            "motion",
            {"81": "drilling", "83": "deep hole drilling", "85": "reaming"},
            refuses=codes.CYCLE,
        ),
        *rows("motion", {"82": "drilling with dwell, or with chip breaking"}, refuses=_DIFFER),
        *rows("motion", {"84": "tapping"}, refuses=_SPINDLE),
        *rows("motion", {"86": "boring", "89": "boring"}, refuses=_UNSEEN),
        *rows(
            "motion",
            {
                "69": "deep hole drilling, complex",
                "87": "rectangular pocket",
                "88": "circular pocket",
            },
            refuses=codes.WRITE_OUT,
        ),
        *rows("", {"79": "changes a cycle"}, takes=True, refuses=codes.WRITE_OUT),
    ),
    change_takes="Z",
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        10: "air on",
        11: "air through the tool on",
        17: "end of a subprogram",
        29: "end of a subprogram",
        **dict.fromkeys(range(41, 45), "gear"),
        45: "live tool",
    },
    # ( ) is no comment by itself here, or (P1=5) and (GOTO N10) of the 8055 would be passed over in
    # silence: what is no statement is ignored below.
    grammar=Grammar(
        parentheses=False,
        keywords=("#MCS",),
        # name of the program; comments; what only shows, waits or speeds up
        ignores=(r"^[ \t]*%[^\n]*", rf"(?!{_STATEMENT})\([^()\n]*\)", _QUIET),
        macros=(
            (_HEAD + r"#[ \t]*(?:RTCP|TLC|KIN)\b[^;\n]*", 1),
            (_HEAD + r"#[ \t]*(?:CS|ACS)\b[^;\n]*", 2),
            (_HEAD + r"#[ \t]*(?:CYL|FACE|TANGCTRL|ANGAX)\b[^;\n]*", 3),
            (_HEAD + r"#[ \t]*(?:CALL|PCALL|MCALL|MDOFF|EXEC|RPT|TCALL)\b[^;\n]*", 4),
            (_HEAD + r"(?:\$|%L|L[ \t]*\d)[^;\n]*", 4),
            (_HEAD + r"#[ \t]*MCS[ \t]+ON\b[^;\n]*", 5),
            # behind the statements that are known: any other one
            (_HEAD + r"#(?![ \t]*MCS\b)[^;\n]*", 6),
            *(
                (rf"^[^;\n]*\([ \t]*{statement}[^\n]*", reason)
                for statement, reason in _STATEMENTS.items()
            ),
            (_HEAD + r"(?:P[ \t]*\d+|V\.[\w.]+)[ \t]*=[^;\n]*", 7),
            (_HEAD + _POLAR, 8),
        ),
    ),
    macro_refuses=(
        codes.TOOL_POINT,
        codes.TILTED,
        codes.TRANSFORM,
        codes.INLINE,
        "all blocks behind it are in machine coordinates: write #MCS in each of them",
        "what it does is not known here: take it out, or write what it does as blocks",
        "its value may stand for a place: write the numbers",
        "its end is an angle and a radius about the pole: let the CAM program write X Y Z",
        "it decides where the program goes on: write the blocks as they run",
        codes.PROBE,
        _DATUM,
    ),
    length_left_open=True,
    dwell="K",
    length_letter="D",
    repeats="",
    letters="Q",
    g_takes=(51, 501),
    signs=(
        r"#(?:MCS|RTCP|HSC|CS|KIN[ \t]+ID|DGWZ|MSG)\b",
        r"^[ \t]*%[\w -]+,M",
        r"G51[ \t]*A\d+[ \t]*E[\d.]",
        r"G501[ \t]*A",
        r"G8[135]\b[^\n]*\bZ[^\n]*\bI-?[\d.]",
        r"G159\b",
        r"G0?5[ \t]*G|G0?7[ \t]*G",
    ),
    remarks=(r"\bFAGOR\b",),
)
