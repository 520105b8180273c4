"""LinuxCNC (RS274/NGC): `;` and `( )` comments, incremental arc centres, P turns, G7 diameter, G8 radius.

Arc tolerances: rs274ngc's constants of these names, measured on the interpreter (tests/linuxcnc/README.md).
"""

from postproc.nc import codes
from postproc.nc.codes import Code
from postproc.nc.dialects import Dialect

_CYCLES = {
    "33": "spindle-synchronised motion", "33.1": "rigid tapping", "38.2": "probe", "38.3": "probe", "38.4": "probe",
    "38.5": "probe", "5": "cubic spline", "5.1": "quadratic spline", "5.2": "NURBS", "5.3": "NURBS end",
    "73": "drilling, chip breaking", "76": "threading", "81": "drilling", "82": "drilling with dwell",
    "83": "peck drilling", "84": "right-hand tapping", "74": "left-hand tapping", "85": "boring", "86": "boring",
    "87": "back boring", "88": "boring", "89": "boring with dwell",
}  # fmt: skip
_FRAMES = {"10": "set offsets or tools", "52": "local offset", "92": "set position"}

DIALECT = Dialect(
    name="linuxcnc",
    title="LinuxCNC 2.8 and newer, RS274/NGC",
    codes=(
        *codes.COMMON,
        *codes.FEED_MODE,
        Code("G80", "motion", "no motion mode"),
        *[Code("G" + n, "motion", meaning, refuses=codes.CYCLE) for n, meaning in _CYCLES.items()],
        *[Code(f"G{n}", "plane", "rotated plane", refuses=codes.FRAME) for n in ("17.1", "18.1", "19.1")],
        Code("G90.1", "arc centre", "arc centres absolute"),
        Code("G91.1", "arc centre", "arc centres incremental"),
        Code("G7", "diameter", "X is a diameter"),
        Code("G8", "diameter", "X is a radius"),
        *[Code(f"G59.{n}", "work offset", f"work offset {6 + n}") for n in (1, 2, 3)],
        *[Code(f"G{n}", "path", "path control") for n in ("61", "61.1", "64")],
        *[Code(f"G{n}", "return", "return level of cycles") for n in ("98", "99")],
        *[Code("G" + n, "shift", meaning, takes=True, refuses=codes.FRAME) for n, meaning in _FRAMES.items()],
        Code("G92.3", "shift", "position shift back", refuses=codes.FRAME),
        Code("G92.1", "shift", "no position shift"),
        Code("G92.2", "shift", "position shift off"),
        *[Code(f"G{n}", "", "store the reference point") for n in ("28.1", "30.1")],
        *[Code(f"G{n}", "tool length", "tool length", refuses=codes.LENGTH) for n in ("43.1", "43.2")],
        *[Code(f"G{n}", "cutter", "cutter radius", refuses=codes.CUTTER) for n in ("41.1", "42.1")],
        *[
            Code(f"G{n}", "motion", "turning cycle", refuses=codes.CYCLE)
            for n in ("70", "71", "71.1", "71.2", "72", "72.1", "72.2")
        ],
    ),
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        50: "feed override",
        51: "speed override",
        52: "adaptive feed",
        53: "feed stop",
        61: "set tool number",
        62: "output",
        63: "output",
        64: "output",
        65: "output",
        66: "wait for input",
        67: "analog output",
        68: "analog output",
        70: "save modal state",
        71: "forget modal state",
    },
    m_refuses={
        98: codes.CALL,
        99: codes.CALL,
        72: "modal state comes back from elsewhere: write the codes out",
        73: codes.CALL,
    },
    language="linuxcnc",
    expand_decimals=4,
    plane=170,
    dwell="P",
    turns=True,
    arc_tolerance_mm=0.02 * 2**0.5,  # CENTER_ARC_RADIUS_TOLERANCE_MM
    arc_tolerance_relative=0.001,  # SPIRAL_RELATIVE_TOLERANCE
    arc_tolerance_most_mm=2 * 2**0.5,
    radius_tolerance_mm=0.00127,  # RADIUS_TOLERANCE_MM
)
