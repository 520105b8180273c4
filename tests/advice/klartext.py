"""Sentences of Heidenhain Klartext: labels, parameters, arcs, drilling."""

from __future__ import annotations

from tests.advice.follow import WRITE, Case


def klartext(before: str, after: str, then: str = "", first=None, **options) -> Case:
    head = "BEGIN PGM A MM|L X+0 Y+0 Z+5 R0 FMAX|"
    how = {**WRITE, **options}
    return Case("heidenhain", head + before, head + after, then, first or {}, how=how)


def cycle(data: str, number: int = 200, call: str = "L X+5 FMAX M99", feed: str = "F500") -> str:
    values = "".join(f" ~|{q}" for q in data.split())
    return f"L Z+5 {feed}|CYCL DEF {number} HOLE{values}|{call}|L X+9"


DRILL = "Q200=+2 Q201=-5 Q206=+90 Q202=+3 Q203=+0"
POLE = "CC X+5 Y+0|"
RIGHT = POLE + "C X+10 Y+0 DR+ F99"
ALONG = "L X+0 Y+0 F99|L X+1 Y+0|"
LINE, ON = "L X+5 F99|", "|L Y+5"
BORE = "Q200=+2 Q201=-5 Q206=+90 Q203=+0 "


def bored(data: str, then: str, missing: bool = False, spindle: str = "M3") -> Case:
    def text(data: str, tool: str, spindle: str) -> str:
        more = "".join(q for q in (" Q334=+2", " Q335=+20") if q[1:6] not in data)
        call = f"{tool}TOOL CALL 1 Z|L Z+9 R0 FMAX {spindle}|"
        return call + cycle(BORE + data + more, 208)

    tool = "TOOL DEF 1 L+0 R+4|"
    first = {"offsets": {"G54": {}, "T1": {"Z": 0.0}}} if missing else {}
    return klartext(
        text(data, "" if missing else tool, spindle), text(then, tool, "M3"), first=first
    )


STUD = (
    "Q218=+20 Q424=+26 Q219=+10 Q425=+16 Q220=+2 Q207=+500 Q351=+1 Q201=-9 Q202=+6 Q206=+150"
    " Q200=+2 Q203=+0 Q204=+9 Q437=+0 Q367=+0"
)


def studded(old: str, new: str, spindle: str = "M3") -> Case:
    def text(data: str, spindle: str) -> str:
        head = f"TOOL DEF 1 L+0 R+4|TOOL CALL 1 Z|L Z+9 R0 FMAX {spindle}|"
        return head + cycle(data, 256)

    return klartext(text(STUD.replace(old, new), spindle), text(STUD, "M3"))


ROUND = (
    "Q215=+1 Q223=+30 Q207=+500 Q351=+1 Q201=-5 Q202=+3 Q206=+150 Q200=+2 Q203=+0 Q204=+9"
    " Q370=+1 Q366=+0"
)


def pocketed(old: str, new: str, spindle: str = "M3", number: int = 252) -> Case:
    def text(data: str, spindle: str, number: int = 252) -> str:
        head = f"TOOL DEF 1 L+0 R+4|TOOL CALL 1 Z|L Z+9 R0 FMAX {spindle}|"
        return head + cycle(data, number)

    data = ROUND.replace(old, new) if old else new + ROUND
    return klartext(text(data, spindle, number), text(ROUND, "M3"))


FACE = (
    "Q389=+2 Q225=+1 Q226=+2 Q227=+0 Q386=-2 Q218=+50 Q219=+20 Q202=+2 Q370=+1 Q207=+500 Q253=+750"
    " Q200=+2 Q357=+3 Q204=+9"
)


def faced(old: str, new: str) -> Case:
    head = "TOOL DEF 1 L+0 R+4|TOOL CALL 1 Z|L Z+9 R0 FMAX M3|"
    return klartext(head + cycle(FACE.replace(old, new), 232), head + cycle(FACE, 232))


RING_OF = (
    "CYCL DEF 220 R ~|Q216=+5 ~|Q217=+5 ~|Q244=+9 ~|Q245=+0 ~|Q200=+2 ~|Q203=+0 ~|"
    "Q246=+90 ~|Q247=+30 ~|Q241=+3|L X+9"
)
PECK = "L Z+3 F99|CYCL DEF 1.0 P|CYCL DEF 1.1 2|CYCL DEF 1.2 -5|CYCL DEF 1.3 2|CYCL DEF 1."


def ring(data: str, count: str = "+3") -> str:
    own = RING_OF.replace("Q246=+90 ~|Q247=+30 ~|Q241=+3", data.replace(" ", " ~|"))
    return (
        cycle(DRILL, call="").removesuffix("||L X+9")
        + "|"
        + own.replace("Q200=", f"Q241={count} ~|Q200=")
    )


TURN = "CYCL DEF 10.0 R|CYCL DEF 10.1 ROT+30|"
BACK = "|CYCL DEF 10.0 R|CYCL DEF 10.1 ROT+0|"
PLACE = "L X+5 Y+1 F99"
ISO = "%9 G71 *|N1 G90 G00 X0 Y0 Z5*|N2 G200 Q200=2 Q201=-5 Q206=90 Q202=3 Q203=0*|"


def iso(before: str, after: str) -> Case:
    return Case("heidenhain-iso", ISO + before, ISO + after, how=WRITE)


ALL = [
    klartext("CC X+5 Y+0|RND R2|L X+5 F99", "CC X+5 Y+0|L X+5 F99"),
    iso("N3 G98 L1*|N4 G79*|N5 L1,2*", "N4 G79*"),
    iso("N3 G91*|N4 G79*", "N4 G79*"),
    iso("N3 I5 J0*|N4 G03 X10 Y0 F9*|N5 G79*", "N4 G00 X10*|N5 G79*"),
    Case(
        "heidenhain",
        "L X+0 Y+0 Z+5 FMAX|" + cycle(DRILL, call="CYCL CALL"),
        "L X+0 Y+0 Z+5 FMAX|" + cycle(DRILL, call="CYCL CALL"),
        also=WRITE,
    ),
    klartext("C X+10 Y+0 DR+ F99", RIGHT),
    klartext(POLE + "C X+12 Y+0 DR+ F99", RIGHT),
    klartext(POLE + "C X+10 Y+0 F99", RIGHT),
    klartext(POLE + "C X+10 Y+0 Z+1 DR+ F99", POLE + "CP IPA+180 Z+1 DR+ F99"),
    klartext(POLE + "CP IPA-90 DR+ F99", POLE + "CP IPA-90 DR- F99"),
    klartext(POLE + "CP PR+5 IPA+90 DR+ F99", POLE + "CP IPA+90 DR+ F99"),
    klartext("STOP|L X+1 F99|L Z+0 FMAX M91|CT X+10 Y+3", "L X+0 Y+0 F99|L X+1 Y+0|CT X+10 Y+3"),
    klartext(ALONG + "CT X+9", ALONG + "CT X+9 Y+3"),
    klartext(ALONG + "CT IX+0", ALONG + "CT X+9 Y+3"),
    klartext("CC X+5 Y+0 Z+0|C X+10 Y+0 DR+ F99", RIGHT),
    klartext(
        "CC X+0 Y+0|APPR PLT PR+9 LEN5 RL F99|L X+9 Y+9",
        "CC X+0 Y+0|APPR PLT PR+9 PA+3 LEN5 RL F99|L X+9 Y+9",
    ),
    studded("Q437=+0", "Q437=+1"),
    studded("Q351=+1", "Q351=+0"),
    studded("", "", "M4"),
    studded("Q424=+26", "Q424=+10"),
    studded("Q201=-9", "Q201=+9"),
    studded("Q367=+0", "Q367=+7"),
    klartext("RND R1", LINE + "RND R1" + ON),
    klartext(LINE + "RND R1 F20 M8" + ON, LINE + "RND R1" + ON),
    klartext(LINE + "/ RND R1" + ON, LINE + "RND R1" + ON),
    klartext(LINE + "CHF 0" + ON, LINE + "CHF 1" + ON),
    klartext(LINE + "RND R1|M9" + ON, LINE + "RND R1" + ON),
    klartext("L X+5 FMAX|RND R1" + ON, LINE + "RND R1" + ON),
    klartext("L X+5 Z+1 F99|RND R1" + ON, LINE + "RND R1" + ON),
    klartext(LINE + "RND R1|L X+5", LINE + "RND R1" + ON),
    klartext(LINE + "RND R1|L X+2", LINE + "RND R1" + ON),
    klartext(LINE + "CHF 9" + ON, LINE + "CHF 1" + ON),
    bored("Q351=+1", "Q351=+1", missing=True),
    bored("Q351=+0", "Q351=+1"),
    bored("Q351=+1 Q335=+8", "Q351=+1"),
    bored("Q351=+1 Q334=+0", "Q351=+1"),
    bored("Q351=+1", "Q351=+1", spindle="M4"),
    klartext(ring("Q247=+0 Q246=+90"), ring("Q247=+30 Q246=+90")),
    klartext(ring("Q247=+30 Q246=+90 Q365=+1"), ring("Q247=+30 Q246=+90 Q365=+0")),
    klartext(ring("Q247=+30 Q246=+90", "+0"), ring("Q247=+30 Q246=+90")),
    klartext(cycle(DRILL, call="CYCL DEF 220 R"), ring("Q247=+30 Q246=+90")),
    klartext(PECK + "5 F9|" + RING_OF, ring("Q247=+30 Q246=+90")),
    klartext(PECK + "4 1|L X+5 M99", PECK + "5 F9|L X+5 M99"),
    klartext((PECK + "5 F9|L X+5 M99").replace("1.3 2", "1.3 .0001"), PECK + "5 F9|L X+5 M99"),
    klartext(cycle(DRILL + " Q257=+0.00001", 205), cycle(DRILL, 205)),
    klartext(cycle(DRILL, 254), "L Z-5 F99|L Z+5 FMAX"),
    faced("Q389=+2", "Q389=+1"),
    faced("Q218=+50", "Q218=+0"),
    faced("Q386=-2", "Q386=+2"),
    faced("Q202=+2", "Q202=+0"),
    pocketed("Q351=+1", "Q351=+0"),
    pocketed("Q215=+1", "Q215=+7"),
    pocketed("Q366=+0", "Q366=+7"),
    pocketed("Q223=+30", "Q223=+7"),
    pocketed("Q201=-5", "Q201=+5"),
    pocketed("Q370=+1", "Q370=+0.001"),
    pocketed("Q202=+3", "Q202=+0.001"),
    pocketed("", "", "M4"),
    pocketed("", "Q218=+60 Q219=+30 Q367=+9 ", number=251),
    klartext(cycle(DRILL + " Q395=+1"), "L Z-5 F99|L Z+5 FMAX"),
    klartext(cycle(DRILL.replace("Q201=-5", "Q201=+5")), "L Z-5 F99|L Z+5 FMAX"),
    klartext(cycle(DRILL.replace("Q206=+90", "")), "L Z-5 F99|L Z+5 FMAX"),
    klartext(cycle(DRILL.replace("Q203=+0", "")), "L Z-5 F99|L Z+5 FMAX"),
    klartext(cycle(DRILL.replace("Q202=+3", "Q202=+0.0001")), cycle(DRILL)),
    klartext(cycle(DRILL, feed="FMAX"), cycle(DRILL)),
    klartext(TURN + "L X+5 F99", TURN + PLACE),
    klartext(TURN + PLACE + "|CYCL DEF 7.1 X+5", TURN + PLACE + BACK + "CYCL DEF 7.1 X+5"),
    klartext(TURN + "CYCL DEF 8.1 X|" + PLACE, TURN + PLACE + BACK + "CYCL DEF 8.1 X|" + PLACE),
    klartext("CYCL DEF 11.1 SCL 0|" + PLACE, "CYCL DEF 26.1 X0.9|" + PLACE),
    klartext(TURN + "CYCL DEF 26.1 X2|" + PLACE, TURN + PLACE + BACK + "CYCL DEF 26.1 X2|" + PLACE),
    klartext("CYCL DEF 26.1 Z2|" + cycle(DRILL, 207), cycle(DRILL, 207)),
    Case(
        "heidenhain",
        *["BEGIN PGM A MM|CYCL DEF 11.1 SCL 2|L X+0 Y+0 Z+5 R0 FMAX"] * 2,
        also={"scaling": "plane"},
        how=WRITE,
    ),
    klartext("CYCL DEF 8.1 Z|" + PLACE, "CYCL DEF 8.1 X|" + PLACE),
    klartext("CYCL DEF 10.1 X|" + PLACE, TURN + PLACE),
    klartext("/ CYCL DEF 10.1 ROT+30|" + PLACE, TURN + PLACE),
    klartext(
        "TOOL DEF 1 R+1|TOOL CALL 1 Z|" + PLACE + "|L X+9 RL|" + TURN + "L X+5 Y+9",
        "TOOL DEF 1 R+1|TOOL CALL 1 Z|" + PLACE + "|L X+9 R0|" + TURN + "L X+5 Y+9",
        offsets={"T1": {"Z": 0.0}, "G54": {}},
    ),
    klartext(
        TURN + PLACE + "|APPR LT X+9 Y+5 LEN2 RL F9|L X+20|L X+5 R0",
        TURN + PLACE + BACK + "L X+1 Y+1 R0 F9",
    ),
    klartext("CALL LBL 1", "LBL 1|L X+1 F9|CALL LBL 1 REP 2"),
    klartext("LBL 1|L X+1 F9|LBL 1", "LBL 1|L X+1 F9|LBL 2"),
    klartext("LBL 1|CALL LBL 1", "LBL 1|L X+1 F9"),
    klartext("L X+Q1 F9", "Q1 = 5|L X+Q1 F9"),
    klartext("FN 9: IF +Q1 EQU +1 GOTO LBL 1|LBL 1", "Q1 = 1|FN 9: IF +Q1 EQU +1 GOTO LBL 1|LBL 1"),
    klartext("CALL PGM C", "CALL PGM B", library={"B.H": "L X+5 F9"}),
]
