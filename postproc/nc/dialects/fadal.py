"""Fadal CNC 88 and 32MP (format 1, and what format 2 shares with it): E1 to E48 for the fixture
offset, H for the length at once, L100 for subroutines, G8 G9, G84.1 G84.2 rigid tapping.

Sources: what Autodesk's `fadal.cps` (2023) writes and says of both formats: E0 and H0 for none, E1
to E24 with the motion, H without G43 in format 1, G28, G53 and G54 for E1 in format 2, `R0+.1` for
the level of a cycle (R0 without a sign behind it is that level), P of G4 in milliseconds, Q the
pitch and F the speed of G84.1; and programs that ran (sets of holes in L100 behind M17 and M30).
Fadal's own manuals were not found as text. Assumed: E0 is the zero of the machine coordinates,
unless --offset E0 says another; a program begins with it, and with no length; M6 takes Z up; D is
the radius alone; a coordinate without a decimal point counts least increments, which a notice says.
Not followed: M98 M99 of format 2, the control's own routines (L93 to L99), registers (R1+2, #), G51
to G68, repeated blocks.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

DIALECT = Dialect(
    name="fadal",
    title="Fadal, format 1",
    codes=(
        *shared.MOTION,
        *shared.PLANE,
        *shared.DISTANCE,
        *shared.REFERENCE,
        *shared.MACHINE_FRAME,
        *shared.DWELL,
        *shared.UNITS,
        *shared.PER_TIME,
        *shared.CUTTER,
        *shared.LENGTH,
        *shared.SET,
        *shared.NO_MOTION,
        *shared.PECKS,
        *shared.DRILL,
        *shared.BORE,
        *shared.FINE_BORE,
        *shared.TAP,
        *shared.RETURN,
        *rows("motion", {"74.1": "left-hand rigid tapping", "84.1": "rigid tapping"}, does="tap"),
        *rows("", {"74.2": "made ready for G74.1", "84.2": "made ready for G84.1"}),
        *rows("ramps", {"8": "no feed ramps", "9": "feed ramps"}),
        *rows(
            "rotation",
            {
                "51": "scaling, mirror or rotation",
                "51.1": "mirror",
                "51.2": "scaling",
                "51.3": "rotation",
                "68": "rotation",
            },
            refuses=codes.UNTURNED,
        ),
        *rows("rotation", {"50": "no scaling", "69": "no rotation"}),
        *rows("rotation", {"50.1": "no mirror"}, takes=True),
        *rows(
            "work offset",
            {str(n): f"work offset E{n - 53} of format 2" for n in range(54, 60)},
            does="fixture",
        ),
        *rows("motion", {"31": "skip"}, refuses=codes.PROBE),
    ),
    m_codes={**codes.SPINDLE_AND_COOLANT, 17: "end of subroutine"},
    m_refuses={98: codes.INLINE, 99: codes.INLINE},
    grammar=Grammar(
        # R0+.1 is R.1: the R0 before it says that it is the level of the cycle. O1 names the
        # program.
        ignores=(r"(?<=R)0(?=[+-][0-9.])", r"^[ \t]*(?:N[ \t]*\d+)?([ \t]*)O[ \t]*\d+"),
        # L with three digits calls a subroutine (L100), with fewer it repeats a cycle (L2).
        macros=((r"^[ \t]*(?:/[ \t]*)?(?:N[ \t]*\d+)?([ \t]*)L[ \t]*\d{3,}[^\n]*", 1),),
    ),
    macro_refuses=(codes.CALL,),
    language="fadal",
    change_takes="Z",
    length_left_open=True,
    integers="least increments",
    integer_notice=(
        "coordinates without a decimal point are read as least increments; if the control counts"
        " them in whole units, say --integers units"
    ),
    one_code_per_group=False,
    length_at_once=True,
    offset_letter="E",
    letters="EL",
    # The three heads of Autodesk's posts: offsets off, a fixture with the place, a length with its
    # Z.
    signs=(
        r"\bH0[ \t]+E0\b",
        r"^[ \t]*(?:N[ \t]*\d+[ \t]*)?E\d+(?:[ \t]+[XY]|[ \t]*$)",
        r"^[ \t]*(?:N[ \t]*\d+[ \t]*)?H\d+[ \t]+Z[-+.\d]",
    ),
    remarks=(r"\bFADAL\b",),
)
