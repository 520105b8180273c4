"""Heidenhain TNC in Klartext: L X+10 Y+20 R0 FMAX M3, TOOL CALL, CYCL DEF, LBL (.h files).

Statements become words in postproc/nc/klartext.py; labels, Q parameters and jumps run in
postproc/nc/expand/klartext.py, arcs and drilling cycles are written out as L by
postproc/nc/cycles/klartext_paths.py. Sources: HEIDENHAIN TNC 640, TNC 620 and iTNC 530 user's
manuals, Klartext programming; what Autodesk's heidenhain.cps and other posts write. A block in
machine coordinates (M91) is one by G53; where M140 MB MAX ends the machine knows alone. The preset
of cycle 247 is --offset "G247 P1=X..,Y..,Z..", the datum without it --offset G54=; T is the tool
with its length.
"""

from postproc.nc import klartext
from postproc.nc.dialects import Dialect
from postproc.nc.dialects.heidenhain_iso import DIALECT as ISO
from postproc.nc.grammar import KLARTEXT
from postproc.nc.rows import CUTTER, DISTANCE, LOCAL, MACHINE_FRAME, MOTION, PLANE, UNITS, rows

_ISO_ARC = "an arc is written C, CR or CP here: is it DIN/ISO? --dialect heidenhain-iso"
_REFUSED = {n: why for n, why in ISO.m_refuses.items() if n not in (91, 99)}

DIALECT = Dialect(
    name="heidenhain",
    title="Heidenhain TNC, Klartext",
    codes=(
        # Codes here are what klartext.py makes of statements: G0 G1 of L, G53 of M91, G247 of the
        # preset, G200 of a cycle that is defined, G268 of PLANE.
        *MOTION[:2],
        *rows("motion", {"2": "arc, clockwise", "3": "arc, counter-clockwise"}, refuses=_ISO_ARC),
        *PLANE,
        *DISTANCE,
        *UNITS,
        *CUTTER,
        *MACHINE_FRAME,
        *rows("", {"30": "to the limit of the travel (M140 MB MAX)"}, takes=True),
        *rows("work offset", {"54": "the datum in force, where it is stated"}),
        *rows("work offset", {"247": "preset (cycle 247)"}, does="extended", like="G54.1"),
        *LOCAL,
        *rows("defined cycle", {"200": "a cycle, defined", "207": "one that stays, defined"}),
        *rows("", {"4": "dwell (cycle 9, FUNCTION DWELL)"}),
        *rows("", {"268": "tilted plane (PLANE)"}, takes=True, does="spatial"),
        *rows("", {"79": "cycle call"}, takes=True, does="words"),
    ),
    m_codes=ISO.m_codes,
    m_refuses={**_REFUSED, 99: klartext.EXPAND_PATH},
    grammar=KLARTEXT,
    language="klartext",
    extended_name="G247 P",
    plane_frame="zero",
    tip_codes={128: True, 129: False},
    length_letter="T",
    change_takes="Z",
    dwell="F",
    letters="Q",  # DL of TOOL CALL
    macro_refuses=klartext.REASONS,
    signs=(
        r"^[ \t]*(?:\d+[ \t]+)?BEGIN[ \t]+PGM\b",
        r"^[ \t]*(?:\d+[ \t]+)?TOOL[ \t]+CALL\b",
        r"^[ \t]*(?:\d+[ \t]+)?L[ \t]+I?[XYZ][-+]?[.\d]",
        r"\bR0[ \t]+F[ \t]*MAX\b",
        r"\bCYCL[ \t]+(?:DEF|CALL)\b",
        r"^[ \t]*(?:\d+[ \t]+)?BLK[ \t]+FORM\b",
    ),
    # What DIN/ISO has and Klartext has not: G codes, N numbers, * at the end.
    excludes=(r"(?<![A-Z0-9_])G[ \t]*\d", r"^[ \t]*N[ \t]*\d", r"\*[ \t]*$"),
    remarks=(r"\bHEIDENHAIN\b", r"\bI?TNC ?\d{3}\b"),
)
