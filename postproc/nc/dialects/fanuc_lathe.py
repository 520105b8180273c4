"""Fanuc lathes and grinders in G-code system B: X in diameter, U W increments beside G90 G91, G4 with X, U or P.

`;` is the end of block as Fanuc's manuals print it, so several blocks may stand in a line; comments are in ( ) alone.
Words and groups: Fanuc Series 0i-TD user's manual B-64304EN-1, G code list, column B.
"""

from postproc.nc import codes
from postproc.nc.codes import Code
from postproc.nc.dialects import Dialect
from postproc.nc.lexer import Grammar

_CYCLES = {
    "32": "thread cutting", "33": "thread cutting", "34": "variable lead thread", "70": "finishing cycle",
    "71": "roughing cycle", "72": "facing cycle", "73": "pattern repeating", "74": "end face pecking",
    "75": "grooving", "76": "threading cycle", "77": "turning cycle", "78": "threading cycle", "79": "facing cycle",
    "81": "drilling", "82": "drilling with dwell", "83": "face drilling", "84": "face tapping", "85": "face boring",
    "87": "side drilling", "88": "side tapping", "89": "side boring", "31": "skip",
}  # fmt: skip
_FRAMES = {"10": "data input", "52": "local coordinates", "92": "set coordinates or speed limit"}

DIALECT = Dialect(
    name="fanuc-lathe",
    title="Fanuc lathe or grinder, G-code system B",
    codes=(
        *codes.COMMON,
        Code("G94", "feed mode", "feed per minute"),
        Code("G95", "feed mode", "feed per turn"),
        Code("G93", "feed mode", "feed as inverse time"),
        Code("G80", "cycle", "end of drilling cycles"),
        *[Code("G" + n, "motion", meaning, refuses=codes.CYCLE) for n, meaning in _CYCLES.items()],
        *[Code("G" + n, "shift", meaning, takes=True, refuses=codes.FRAME) for n, meaning in _FRAMES.items()],
        *[Code(f"G{n}", "return", "return level of cycles") for n in ("98", "99")],
        Code("G7.1", "polar", "cylindrical interpolation", refuses=codes.FRAME),
        Code("G12.1", "polar", "polar interpolation", refuses=codes.FRAME),
        Code("G13.1", "polar", "no polar interpolation"),
        Code("G50", "scaling", "no scaling"),
        Code("G51", "scaling", "scaling", refuses=codes.FRAME),
        Code("G50.2", "polygon", "no polygon turning"),
        Code("G68", "mirror", "double turret mirror", refuses=codes.FRAME),
        Code("G69", "mirror", "no mirror"),
        *[Code(f"G{n}", "path", "path control") for n in ("61", "64")],
        Code("G63", "path", "tapping mode"),
        Code("G9", "", "exact stop in this block"),
        Code("G11", "", "end of data input"),
        Code("G65", "", "macro call", takes=True, refuses=codes.CALL),
        Code("G22", "stroke check", "stroke check on"),
        Code("G23", "stroke check", "stroke check off"),
        Code("G25", "speed check", "speed check off"),
        Code("G26", "speed check", "speed check on"),
    ),
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        10: "chuck or clamp",
        11: "chuck or clamp",
        23: "chamfering on",
        24: "chamfering off",
        40: "gear",
        41: "gear",
        42: "gear",
        43: "gear",
        44: "gear",
    },
    m_refuses={98: codes.CALL, 99: codes.CALL, 198: codes.CALL},
    grammar=Grammar(semicolon="end of block"),
    language="fanuc",
    plane=180,
    increments={"U": "X", "V": "Y", "W": "Z", "H": "C"},
    dwell="PXU",
    tool_offsets=True,
    integer_notice="coordinates without a decimal point are read as whole millimetres or inches (calculator input); on a "
    "control that reads them as least increments the program means something else",
    one_code_per_group=False,
)
