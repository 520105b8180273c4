"""Sinumerik 840D sl, 828D and their kin in Siemens' own language: `;` comments, keywords, CR= for
radii, TRANS, cycles.

G groups and reset states: SINUMERIK NC Programming Manual, "G functions" (groups 1-62) and "Frame
instructions"; G58 G59 G74 G75 G110-G112, G331 G332, G4 F, DIAM90, G500, SUPA and the feed type of
G96 as described there. Arc check: MD21000 CIRCLE_ERROR_CONST, MD21010 CIRCLE_ERROR_FACTOR. TURN=
counts the circles beyond the arc itself. Tool lengths come with D, at once. R is a variable here
(R1=5), never a radius; ( ) are arguments, never comments.
"""

from postproc.nc import codes
from postproc.nc import rows as shared
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import Grammar
from postproc.nc.rows import rows

# How the control moves, looks ahead and reacts: no slide is led elsewhere by them.
_QUIET = (
    "NORM KONT KONTT KONTC CFC CFTCP CFIN BRISK SOFT DRIVE BRISKA SOFTA FFWON FFWOF COMPOF CDON"
    " CDOF CDOF2 STARTFIFO STOPFIFO FIFOCTRL WALIMON WALIMOF RMB RMI RME RMN ORIC ORID FNORM FLIN"
    " FCUB LFON LFOF LFTXT LFWP LFPOS CPRECON CPRECOF CUTCONON CUTCONOF DYNNORM DYNPOS DYNROUGH"
    " DYNSEMIFIN DYNFINISH DYNPREC FENDNORM DIAMCYCOF UPATH SPATH PDELAYON PDELAYOF SPOF SPON PON"
    " SPCON SPCOF RTLION RTLIOF"
    " CUT2D CUT2DF STOPRE DISPLOF DISPLON SBLOF SBLON COMPON COMPCURV COMPCAD COMPSURF COMPPATH"
    " BNAT BTAN BAUTO ENAT ETAN EAUTO ORIWKS ORIMKS ORIAXES ORIVECT ORIEULER ORIRPY ORIRPY2 OSOF"
    " ORISON ORISOF"
    " OSC OSS OSSE OSD OST NEWCONF"
)
_CYCLES = (
    "MCALL CYCLE60 CYCLE61 CYCLE62 CYCLE63 CYCLE64 CYCLE70 CYCLE71 CYCLE72 CYCLE76 CYCLE77"
    " CYCLE78 CYCLE79"
    " CYCLE81 CYCLE82 CYCLE83 CYCLE84 CYCLE840 CYCLE85 CYCLE86 CYCLE87 CYCLE88 CYCLE89 CYCLE90"
    " CYCLE92 CYCLE93 CYCLE94 CYCLE95 CYCLE96 CYCLE97 CYCLE98 CYCLE99 CYCLE801 CYCLE802 CYCLE899"
    " CYCLE930 CYCLE940 CYCLE951 CYCLE952 HOLES1 HOLES2 POCKET1 POCKET2 POCKET3 POCKET4 SLOT1 SLOT2"
    " LONGHOLE"
)
_DRILLED = (  # --expand writes these out
    *("MCALL", "CYCLE81", "CYCLE82", "CYCLE83", "CYCLE84", "CYCLE85"),
    *("CYCLE86", "CYCLE87", "CYCLE88", "CYCLE89"),
    *("HOLES1", "HOLES2", "CYCLE801", "CYCLE802", "CYCLE95", "POCKET3", "POCKET4"),
    *("CYCLE71", "CYCLE77"),
)
_THREADS = ("CYCLE97", "CYCLE98", "CYCLE99")
_FRAMES = "ROT AROT SCALE ASCALE MIRROR AMIRROR"
_SOLID = "ROTS AROTS"
_PARAMETERS = (
    # words that move no slide
    "ADIS ADISPOS CTOL OTOL ATOL SF LIMS SPOS DITS DITE OVR OVRRAP ISD DISC DL PW SD FP"
)
# Programming Manual, "Dynamic response" and "Feedrate": limits of an axis' speed, acceleration and
# jerk, and the radius at which F holds for a rotary axis: how fast, not where
_LIMITS = "ACC VELOLIM JERKLIM FL FA FGREF"
_OTHERS = (
    "SUPA DIAMON DIAMOF DIAM90 CIP CT INVCW INVCCW POLY ASPLINE BSPLINE CSPLINE REPOSL REPOSQ"
    " REPOSH TRAFOOF TRANSMIT TRACYL TRAANG TRAORI CYCLE800 CYCLE832 SETMS MEAS MEAW FGROUP"
)
_KEYWORDS = ("TRANS", "ATRANS", *f"{_FRAMES} {_SOLID} {_OTHERS} {_CYCLES} {_QUIET}".split())
# A keyword is read as a character and its number, in its own place: short ones need small numbers,
# and so come first.
for _word in sorted(_KEYWORDS, key=len):
    codes.code_number(_word)

DIALECT = Dialect(
    name="siemens",
    title="Sinumerik 840D sl and kin, Siemens' language",
    codes=(
        *shared.MOTION,
        *shared.PLANE,
        *shared.DISTANCE,
        *shared.FEED_MODE,
        *shared.CUTTER,
        *shared.MACHINE_FRAME,
        *shared.DWELL,
        *shared.THREAD,
        *rows(
            "motion",
            {"34": "thread of growing lead", "35": "thread of shrinking lead"},
            does="thread",
        ),
        *rows("motion", {"331": "rigid tapping, in", "332": "rigid tapping, out"}, does="thread"),
        *rows(
            "motion",
            {"335": "thread along an arc", "336": "thread along an arc"},
            refuses=codes.CURVE,
        ),
        *rows(
            "motion",
            {"CIP": "arc through a point", "CT": "tangential arc"},
            refuses=(
                "its circle follows from other places: --expand writes it with its centre I J K"
            ),
        ),
        *rows("motion", {"INVCW": "involute", "INVCCW": "involute"}, refuses=codes.CURVE),
        *rows(
            "motion",
            {"ASPLINE": "Akima spline", "CSPLINE": "cubic spline"},
            refuses=(
                "how it runs between its points, the control alone knows: let the CAM program write"
                " lines and arcs, or BSPLINE with PL"
            ),
        ),
        *rows("motion", {"BSPLINE": "B spline"}, does="spline"),
        *rows("motion", {"POLY": "polynomial"}, refuses=codes.SPLINE),
        *rows(
            "",
            {"63": "tapping with a compensating chuck"},
            refuses="it ends where the chuck lets it: write G331 and G332",
        ),
        *rows("", {"74": "to the reference point", "75": "to a fixed point"}, takes=True),
        *rows(
            "",
            {
                "REPOSL": "back to the contour",
                "REPOSQ": "back to the contour",
                "REPOSH": "back to the contour",
            },
            takes=True,
            refuses=codes.WRITE_OUT,
        ),
        *rows(
            "",
            {
                "147": "soft approach, straight",
                "148": "soft departure, straight",
                "247": "soft approach, quarter",
                "248": "soft departure, quarter",
                "347": "soft approach, half",
                "348": "soft departure, half",
            },
            refuses=codes.WRITE_OUT,
        ),
        *rows("units", {"70": "inch", "700": "inch, feeds too"}, like="G20"),
        *rows("units", {"71": "millimetre", "710": "millimetre, feeds too"}, like="G21"),
        *rows("work offset", {str(n): f"work offset {n - 53}" for n in range(54, 58)}),
        *rows("work offset", {str(n): f"work offset {n - 500}" for n in range(505, 600)}),
        *rows("work offset", {"500": "no work offset"}),
        *rows(
            "",
            {"153": "this block without base offsets", "SUPA": "this block without any offset"},
            like="G53",
        ),
        *rows("frame", {"TRANS": "shift"}, takes=True, does="trans"),
        *rows("", {"ATRANS": "further shift"}, takes=True, does="atrans"),
        *rows(
            "frame",
            dict.fromkeys(_FRAMES.split(), "turned, scaled or mirrored"),
            takes=True,
            does="frame",
            refuses=codes.FRAME,
        ),
        *rows(
            "frame",
            dict.fromkeys(_SOLID.split(), "turned by solid angles"),
            takes=True,
            does="frame",
            refuses="it turns the coordinates by two angles at once: program ROT and AROT, about"
            " one axis each",
        ),
        *rows("", {"58": "shift of single axes"}, takes=True, does="axis shift"),
        *rows("", {"59": "further shift of single axes"}, takes=True, does="further axis shift"),
        *rows("", {"25": "lower limits", "26": "upper limits"}, takes=True, does="words"),
        *rows(
            "",
            {"110": "pole from the last place", "111": "pole", "112": "pole from the last pole"},
            takes=True,
            does="words",
        ),
        *rows("diameter", {"DIAMON": "X is a diameter"}, like="G7"),
        *rows("diameter", {"DIAMOF": "X is a radius"}, like="G8"),
        *rows("diameter", {"DIAM90": "X is a diameter in G90, a radius in G91"}),
        *rows(
            "feed mode",
            {
                "96": "constant surface speed, feed per turn",
                "961": "constant surface speed, feed per minute",
                "962": "constant surface speed",
                "97": "constant spindle speed, feed per turn",
                "971": "constant spindle speed, feed per minute",
                "972": "constant spindle speed",
                "973": "constant spindle speed",
                "942": "feed per minute, speed frozen",
                "952": "feed per turn, speed frozen",
            },
        ),
        *rows(
            "feed mode",
            {"931": "feed as the time of the motion"},
            refuses="a block's feed is its time: write G93 or G94",
        ),
        *rows(
            "path",
            {
                "60": "exact stop",
                "64": "continuous path",
                "641": "rounded by ADIS",
                "642": "rounded within tolerances",
                "643": "rounded within the block",
                "644": "rounded by dynamics",
                "645": "rounded, tangential too",
            },
        ),
        *rows("stop", {"601": "stop fine", "602": "stop coarse", "603": "stop by setpoint"}),
        *rows("", {"9": "exact stop in this block"}),
        *rows("corner", {"450": "round outer corners", "451": "sharp outer corners"}),
        *rows(
            "approach",
            {
                "140": "approach side",
                "141": "approach left",
                "142": "approach right",
                "143": "approach by tangent",
                "340": "approach in space",
                "341": "approach in plane",
            },
        ),
        *rows(
            "collision",
            {"460": "approach check", "461": "approach by arc", "462": "approach by straight line"},
        ),
        *rows("override", {"62": "corner override", "621": "corner override everywhere"}),
        *rows("language", {"290": "Siemens' language"}),
        *rows(
            "language",
            {"291": "ISO language"},
            refuses=(
                "the words mean other things from here on: take the ISO part into a "
                "program of its own and choose its --dialect"
            ),
        ),
        *rows("transformation", {"TRAFOOF": "no transformation"}, does="tip off"),
        *rows(
            "transformation",
            {
                "TRANSMIT": "end face in X and Y",
                "TRACYL": "cylinder in X and Y",
                "TRAANG": "inclined axis",
            },
            refuses=codes.TRANSFORM,
        ),
        *rows("transformation", {"TRAORI": "tool centre point"}, does="tip on"),
        *rows("", {"CYCLE800": "tilted plane"}, does="swivel"),
        *rows("", dict.fromkeys(_DRILLED, "cycle"), refuses=codes.CYCLE),
        *rows(
            "",
            {
                name: "cycle"
                for name in _CYCLES.split()
                if name not in (*_DRILLED, *_THREADS, "CYCLE840")
            },
            refuses=codes.WRITE_OUT,
        ),
        *rows("", dict.fromkeys(_THREADS, "thread"), does="thread cycle"),
        *rows("", {"CYCLE840": "tapping with a compensating chuck"}, does="tapping cycle"),
        *rows("", {"MEAS": "measure", "MEAW": "measure"}, refuses=codes.PROBE),
        *rows(
            "",
            {"FGROUP": "the axes that F speaks of"},
            refuses=(
                "corrections of the others are without F: take it out, or name X, Y and Z there"
            ),
        ),
        *rows("", {"CYCLE832": "tolerance and dynamics", "SETMS": "master spindle"}),
        *rows("", dict.fromkeys(_QUIET.split(), "a way of moving, no place")),
    ),
    change_takes="Z",
    m_codes={
        **codes.SPINDLE_AND_COOLANT,
        17: "end of subprogram",
        **dict.fromkeys(range(40, 46), "gear"),
        70: "spindle as axis",
    },
    grammar=Grammar(
        parentheses=False,
        keywords=_KEYWORDS,
        # R is a variable, never a radius: what shapes an arc or a corner is handed on as R, ""
        # moves nothing.
        spellings=(
            ("CR", "R"),
            ("TURN", "P"),
            ("PL", "Q"),  # postproc/nc/splines.py
            # refused in a straight motion, and beside CR= in an arc
            ("RND", "R"),
            ("CHF", "R"),
            ("CHR", "R"),
            ("ANG", "R"),
            *((word + "1", word) for word in "TSM"),  # T1=5: the tool of spindle 1, the main one
            *((name, "") for name in _PARAMETERS.split()),
        ),
        ignores=(
            r"\bMSG[ \t]*\((?:\"[^\"\n]*\"|[^()\"\n])*\)",
            r"\b[SM](?!1[ \t]*=)[0-9]{1,2}[ \t]*=[ \t]*[0-9.]+",  # another spindle's
            (
                rf"\b(?:{'|'.join(_LIMITS.split())})[ \t]*\[[ \t]*[A-Z][A-Z0-9]*[ \t]*\]"
                r"[ \t]*=[ \t]*[0-9.]+"
            ),
            # back to all axes of the geometry, or these and more: no correction is without F
            (
                r"\bFGROUP[ \t]*\([ \t]*(?:\)|(?=[^()\n]*\bX\b)(?=[^()\n]*\bY\b)"
                r"(?=[^()\n]*\bZ\b)[A-Z0-9, \t]*\))"
            ),
            # The name stays, in the group, and counts as the code; its arguments move nothing by
            # themselves.
            r"\b(CYCLE832|SETMS|TRAORI|TRANSMIT|TRACYL|TRAANG)[ \t]*\([^()\n]*\)",
            r"\b("
            + "|".join(_CYCLES.split()[1:])
            + r"|CYCLE800)[ \t]*\((?:\"[^\"\n]*\"|[^()\"\n]|\([^()\n]*\))*\)",
            (
                r"\b(?:SETAL|SETM|CLEARM|WAITM|WAITMC|WORKPIECE|GROUP_BEGIN|GROUP_END|GROUP_ADDEND)["
                r" \t]*\((?:\"[^\"\n]*\"|[^()\"\n])*\)"
            ),
            r"^[ \t]*%_N_[^\n]*",
        ),
        # names of machine axes (G74 X1=0, G75 FP=1 Z1=0): the values say nothing
        macros=((r"^([ \t]*N[ \t]*\d+)?[ \t]*G[ \t]*0*7[45](?![0-9.])[^;=\n]*=[^;\n]*", 0),),
        assigns=True,
    ),
    language="siemens",
    plane_frame="zero",
    # G1 holds before a program names a motion, and TURN= counts the circles beyond the arc
    # (first_turn).
    motion=10,
    increments_travel_shifts=True,
    length_in_machine=True,  # G53 G153 SUPA and the tool's length: MD10760 $MN_G53_TOOLCORR
    expand_decimals=2,
    dwell="FS",
    turns=True,
    first_turn=0,
    arc_tolerance_relative=0.001,
    arc_tolerance_most_mm=1.0,
    length_letter="D",
    ends=(2, 17, 30),
    exact_stops=(90, 600),
    threads_chained=(330,),
    threads_under=(640, 6410, 6420, 6430, 6440, 6450),  # not named: by machine data, often G60
    thread_words="IJK",
    signs=(
        r"\b(CR|TURN|RPL|AR|CHR|CHF|RND|RNDM|ADIS|LIMS|SPOS|CTOL|OTOL|FRC)[ \t]*=",
        r"^[ \t]*%_N_\w+",
        r"\bA?TRANS\b",
        r"\b(A?ROT|A?MIRROR|A?SCALE)\b",
        r"\bM?CALL[ \t]+CYCLE\d+|\bCYCLE\d{2,3}\b",
        r"^[ \t]*(N\d+[ \t]+)?DEF[ \t]+(REAL|INT|BOOL|STRING|CHAR|AXIS|FRAME)\b",
        r"\bR\d+[ \t]*=[^=]",
        r"\bGOTO[FBCS]\b",
        r"\bMSG\b",
        r"G5(0[05-9]|[1-9]\d)\b",
        r"G6(0[123]|4[1-5])\b",
        r"\b(SUPA|DIAMON|DIAMOF|DIAM90|STOPRE|SETMS|SOFT|BRISK|FFWON|TRAORI|TRAFOOF|CIP|COMPCAD)\b",
        r"\b[XYZABCUVWEF]\d?[ \t]*=[ \t]*[-+\dA-Z(\[$]",
        r"=[ \t]*(IC|AC|DC|ACP|ACN)\b",
        (
            r"^[ \t]*(IF|WHILE|FOR|UNTIL|REPEAT|LOOP|ENDIF|ENDWHILE|ENDFOR|ENDLOOP|CASE|PROC)\b(?!["
            r" \t]*\[)"
        ),
        r"\b[ABC]SPLINE\b",
        r"\$(AA?|P|TC|MC|SC|MN|SN)_",
        r"\bT[ \t]*=[ \t]*\"",
        r"^[ \t]*(N\d+[ \t]+)?[A-Z_]{4,}\w*[ \t]*$",
        r"^[ \t]*[A-Z_]{2}\w*[ \t]*=[ \t]*[-+\w($\"]",
    ),
    remarks=(r"\bSINUMERIK\b", r"^[ \t]*;[ \t]*\$PATH=", r"\b840 ?D\b"),
)
