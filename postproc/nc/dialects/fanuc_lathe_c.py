"""Fanuc lathes in G-code system C: G70 G71 are inch and millimetre, G20 G21 G24 the turning cycles,
G72-G78 the others.

Words and groups: Fanuc Series 0i-TD user's manual B-64304EN-1, G code list, column C.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import fanuc_lathe
from postproc.nc.rows import rows
from postproc.records import replace

DIALECT = replace(
    fanuc_lathe.DIALECT,
    name="fanuc-lathe-c",
    title="Fanuc lathe, G-code system C",
    codes=(
        *shared.FANUC_LATHE,
        *shared.CUTTER,
        *shared.DISTANCE,
        *shared.FEED_MODE,
        *shared.RETURN,
        *shared.SET,
        *shared.THREAD,
        # Each counts as its kin of system B everywhere behind the text: only its spelling differs.
        *rows("units", {"70": "inch"}, like="G20"),
        *rows("units", {"71": "millimetre"}, like="G21"),
        *rows("shift", {"92.1": "no position shift"}, takes=True, does="set zero"),
        *rows("motion", {"20": "turning cycle"}, refuses=codes.CYCLE, like="G77"),
        *rows("motion", {"21": "threading cycle"}, does="thread cycle", like="G78"),
        *rows("motion", {"24": "facing cycle"}, refuses=codes.CYCLE, like="G79"),
        *rows("motion", {"72": "finishing cycle"}, refuses=codes.CYCLE, like="G70"),
        *rows("motion", {"73": "roughing cycle"}, refuses=codes.CYCLE, like="G71"),
        *rows("motion", {"74": "facing cycle"}, refuses=codes.CYCLE, like="G72"),
        *rows("motion", {"75": "pattern repeating"}, refuses=codes.CYCLE, like="G73"),
        *rows("motion", {"76": "end face pecking"}, refuses=codes.CYCLE, like="G74"),
        *rows("motion", {"77": "grooving"}, refuses=codes.CYCLE, like="G75"),
        *rows("", {"78": "threading in many passes"}, takes=True, does="thread cycle", like="G76"),
    ),
    threads_chained=(330,),
    signs=(
        *shared.MACRO_SIGNS,
        r"^[O:]\d{4}(\d{4})?\b(?![ \t]*[A-Z])",
        r"^(N\d+[ \t]*)?T(?!0000)\d{4}\b",
        r"G92[ \t]*S\d",
        r"G7[2-5][ \t]*P\d+[ \t]*Q\d+",
        r"G24[ \t]*X",
        r"G2[01][ \t]*X-?[\d.]+[ \t]*Z",
        r"G7[01][ \t]*$",
    ),
    remarks=(r"\bFANUC\b",),
)
