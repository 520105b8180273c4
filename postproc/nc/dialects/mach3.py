"""Mach3 and Mach4 mills and routers: RS274/NGC with G70 and G71 as units; `( )` and `;` comments.

Codes: ArtSoft, Using Mach3Mill (the manual), "Mach 2.0 G- and M-code reference", tables of G and M
codes; Mach4 has the same and G44. G28.1 runs the axes to their switches, it stores nothing. G52 and
G92 share one mechanism and may not be used together. G59 P7 to P254 name further fixtures. Which
return holds before G98 or G99, and how far a peck backs off, are settings.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.rows import rows

DIALECT = Dialect(
    name="mach3",
    title="Mach3 and Mach4",
    codes=(
        # Its G59 takes a P for further fixtures, so it has a row of its own.
        *(code for code in shared.COMMON if code.word != "G59"),
        *shared.UNITS,
        *shared.FEED_MODE,
        *shared.SPINDLE,
        *shared.CUTTER,
        *shared.NO_LENGTH,
        *rows("tool length", {"43": "tool length"}, does="length or none"),
        *shared.LENGTH_MINUS,
        *shared.DATA,
        *shared.LOCAL,
        *shared.SET,
        *shared.SET_ZERO,
        *shared.SET_OFF,
        *shared.ARC_CENTRE,
        *shared.NO_MOTION,
        *shared.RETURN,
        *shared.PECKS,
        *shared.DRILL,
        *shared.BORE,
        *shared.BORE_BY_HAND,
        *shared.TAP,
        *shared.BACK_BORE,
        *rows("work offset", {"59": "work offset 6, or P"}, does="numbered"),
        *rows("units", {"70": "inch"}, like="G20"),
        *rows("units", {"71": "millimetre"}, like="G21"),
        *rows("path", {"61": "exact stop", "64": "constant velocity"}),
        *rows("", {"28.1": "reference the axes"}, takes=True),
        *rows("motion", {"31": "probe"}, refuses=codes.PROBE),
        *rows(
            "motion",
            {"12": "circular pocket, clockwise", "13": "circular pocket, counter-clockwise"},
            refuses=codes.WRITE_OUT,
        ),
        *rows("polar words", {"15": "no polar coordinates"}),
        *rows("polar words", {"16": "polar coordinates"}, refuses=codes.UNTURNED),
        *rows("scaling", {"50": "no scaling"}),
        *rows("scaling", {"51": "scaling"}, refuses=codes.UNTURNED),
        *rows("rotation", {"69": "no rotation"}),
        *rows("rotation", {"68": "rotation of the coordinates"}, refuses=codes.UNTURNED),
    ),
    m_codes={
        **{n: m for n, m in codes.SPINDLE_AND_COOLANT.items() if n != 60},
        10: "output on, with the motion",
        11: "output off, with the motion",
        62: "output on, with the motion",
        63: "output off, with the motion",
        64: "output on",
        65: "output off",
        66: "wait for input",
    },
    m_refuses={47: codes.INLINE, 98: codes.CALL, 99: codes.CALL},
    language="linuxcnc",
    returns_no_lower=True,
    expand_decimals=4,
    local_is_preset=True,
    change_returns="Z",
    exact_stops=(610,),
    letters="E",
    signs=(r"G59[ \t]*P\d", r"M1[01][ \t]*P\d", r"G7[01][ \t]*G9[01]\.1"),
    holes_written_out=False,
    remarks=(r"\bMACH[ \t]*[234](MILL)?\b",),
)
