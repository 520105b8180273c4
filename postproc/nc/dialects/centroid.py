"""Centroid mills (M-series, Acorn): Fanuc's words with `;` comments, M25 to retract the spindle,
M99 at the end.

Codes: what FreeCAD's centroid_post.py writes and says of them ("M25 is a centroid command to
retract spindle": the place of Z behind it is the machine's own), and the words that are Fanuc's
(Centroid M-series operator's manual, "CNC program codes" and "CNC macro M functions"). M99 ends the
program, or returns from a subprogram; what follows it is not read. M109/1/2 disables the overrides
of the feed (1) and the spindle (2) before a tap, and M108/1/2 enables them (unverified:
the manual was not at hand): the slashes are no block delete.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

OVERRIDES = r"M[ \t]*10[89][ \t]*(?:/[ \t]*[12][ \t]*){1,2}(?![0-9./])"

DIALECT = Dialect(
    name="centroid",
    title="Centroid mill",
    codes=(
        *shared.COMMON,
        *shared.UNITS,
        *shared.NO_MOTION,
        *shared.CUTTER,
        *shared.LENGTH,
        *shared.FEED_MODE,
        *shared.DATA,
        *shared.SET,
        *shared.LOCAL,
        *shared.PECKS,
        *shared.DRILL,
        *shared.BORE,
        *shared.TAP,
        *shared.RETURN,
        *rows("", {"9": "exact stop in this block"}),
        *rows("path", {"61": "exact stop", "64": "cutting mode"}),
        *rows("rotation", {"69": "no rotation"}),
        *rows("rotation", {"68": "rotation of the coordinates"}, refuses=codes.UNTURNED),
        *rows("scaling", {"50": "no scaling"}),
        *rows("scaling", {"51": "scaling"}, refuses=codes.UNTURNED),
        *rows("", {"65": "macro call"}, takes=True, refuses=codes.INLINE),
    ),
    # Where M6 and M25 leave Z is the machine's own: until the program names it, nothing counts from
    # there.
    change_takes="Z",
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        10: "clamp on",
        11: "clamp off",
        25: "retract the spindle",
        99: "end of program",
    },
    m_refuses={98: codes.INLINE},
    grammar=Grammar(
        ignores=(OVERRIDES,),
        # 0: M25 passes, and no axis has a known place behind it.
        macros=((r"^([ \t]*N[ \t]*\d+)?[ \t]*M[ \t]*0*25(?![0-9.])[^;\n]*", 0),),
    ),
    holes_written_out=False,
    length_left_open=True,
    length_modal=True,
    ends=(2, 30, 99),
    signs=(r"^[ \t]*M25[ \t\r]*$", r"^[ \t]*G49[ \t]*H0\b"),
    remarks=(r"\bCENTROID",),
)
