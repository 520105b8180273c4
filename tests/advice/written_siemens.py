"""Sentences on what is written out: Sinumerik's frames, corners, control structures and
expressions."""

from __future__ import annotations

from tests.advice.follow import NOWHERE, WRITE, Case


def frame(before: str, after: str, then: str = "", **options) -> Case:
    head = "G90 G0 X0 Y0 Z5|F100|"
    return Case("siemens", head + before, head + after, then, how=WRITE, **options)


def run(before: str, after: str, then: str = "", **options) -> Case:
    head = "G90 G0 X0 Y0 Z5|"
    how = {**WRITE, **options.pop("how", {})}
    return Case("siemens", head + before, head + after, then, how=how, **options)


FRAMES = [
    frame("ATRANS X5|G58 X2|G0 X5 Y5", "TRANS X5|ATRANS X2|G0 X5 Y5"),
    frame("ROT Z30 F1", "ROT Z30|G0 X1 Y1 Z1|ROT|G0 X1 Y1 Z1"),
    frame("ROT X30 Y30", "ROT X30|G0 X1 Y1 Z1|ROT|G0 X1 Y1 Z1"),
    frame("ROT Z30|G70", "G70|ROT Z30|G0 X1 Y1 Z1|ROT|G0 X1 Y1 Z1"),
    frame("SCALE X2 Y2|G1 X1 Y1 RND=3", "G1 X5 RND=3|Y5"),
    frame("G111 X1 RP=3", "G111 X1 Y0|G1 AP=30 RP=3"),
    frame("G1 AP=30|G0 X5", "G1 RP=3 AP=30|G0 X5"),
    frame("ROT Z30|X5", "ROT Z30|G0 X5 Y5|ROT|G0 X1 Y1"),
    frame("ROT RPL=30 Z5", "ROT RPL=30|G0 X5 Y5|ROT|G0 X1 Y1"),
    frame("TRANS RPL=30", "ROT RPL=30|G0 X5 Y5|ROT|G0 X1 Y1"),
    frame("G1 X3 RP=3 AP=4", "G1 RP=3 AP=4"),
    frame("SCALE X0 Y0|G1 X5 Y5", "SCALE X2 Y2|G1 X5 Y5|SCALE|G0 X1 Y1"),
    frame("ROT Z30|SCALE X2 Y1|AROT X30|SCALE X0.00000001", "ROT Z30|G0 X5 Y5|ROT|G0 X1 Y1"),
    frame("ROT Z30|X=IC(5)", "ROT Z30|G0 X5 Y5|X=IC(5)|ROT|G0 X1 Y1"),
    frame("ROT Z30|G0 X5 Y5|AP=IC(5) RP=3", "ROT Z30|G0 X5 Y5|ROT|G0 X1 Y1"),
    frame("ROT X30|G2 X5 Y5 CR=9", "G2 X5 Y5 CR=9"),
    frame("G41 D1 G1 X9|ROT Z30", "G1 X9|ROT Z30|G0 X5 Y5|ROT|G0 X1 Y1"),
    frame("SCALE X99999999 Y2", "SCALE X2 Y2|G1 X5 Y5|SCALE|G0 X1 Y1"),
]
CORNERS = [
    frame("G1 X50 RND=5 CHF=1|Y9", "G1 X50 RND=5|Y9"),
    frame("G1 X50 RND=5 FRC=50|Y9", "G1 X45|G3 X50 Y5 CR=5|G1 Y9"),
    frame("G1 X50 RND=5|G41 D1 Y9", "G41 D1 G1 X9|X50 RND=5|Y9"),
    frame("G1 X50 RND=5|X60 Z9", "G1 X50|X60 Z9"),
    frame("G1 X50 RND=5|Z9", "G1 X50|Z9"),
    frame("G1 X50 RND=5|X40", "G1 X50|X40"),
    frame("G1 X50 RND=60|Y40", "G1 X50 RND=6|Y40"),
    frame("G1 X50 RNDM=5|RNDM=0|Y50", "G1 X50 RNDM=5|Y50 RNDM=0"),
    frame("G1 X50 RND=5|X50 Y0|Y9", "G1 X50|Y9"),
    frame("DIAM90|G1 X50 RND=5|Y9", "DIAMOF|G1 X50 RND=5|Y9"),
    frame("G1 RND=3 RP=3 AP=4|Y9", "G1 RP=3 AP=4|Y9"),
]
ARCS = [
    frame("G1 X9 AR=90", "G2 X9 Y9 AR=90"),
    frame("DIAM90|G2 X9 Y9 AR=90", "DIAMOF|G2 X9 Y9 AR=90"),
    frame("G2 X9 Y9 AR=400", "G2 X9 Y9 AR=40"),
    frame("G2 X9 Y9 I5 AR=40", "G2 X9 Y9 AR=40"),
    frame("G2 AR=40", "G2 I5 J0 AR=40"),
    frame("G2 X0 Y0 AR=40", "G2 X9 Y0 AR=40"),
    frame("CIP X9 Y0 I1=5 J1=3 CR=9", "G2 X9 Y0 CR=9"),
    frame("CIP X9 Y0 I1=5 J1=3 Z4", "CIP X9 Y0 I1=5 J1=3"),
    frame("CIP X9 Y0 I1=5", "CIP X9 Y0 I1=5 J1=3"),
    frame("CIP X9 Y0 I1=5 J1=0", "G1 X9 Y0"),
    frame("DIAM90|G1 X9|CT X12 Y3", "DIAMOF|G1 X9|CT X12 Y3"),
    frame("CT X12 Y3", "G1 X9|CT X12 Y3"),
    frame("G1 X9|CT X12 Y0", "G1 X9|G1 X12 Y0"),
]
TAKES, VAR = (
    {"library": {"TAKES": "PROC TAKES(VAR REAL aa)|M17"}},
    {"library": {"GIVES": "PROC GIVES(REAL aa)|G0 X=aa|M17"}},
)
NONE = {
    "library": {
        "NONE1": "G0 X1|M17",
        "SELF": "G0 X1|SELF|M17",
        "SAVES": "PROC SAVES SAVE|G0 X1|M17",
    }
}
PARTS = [
    run("R1=1.5|M=R1", "R1=9|M=R1"),
    run("ID=1 DO M8", "M8"),
    run("$P_UIFR[1]=5", "G0 X1"),
    run("SAVES", "G0 X1", how=NONE),
    run("DEF REAL f_[2,3]|X=f_[1]", "DEF REAL f_[2,3]|f_[1,0]=2|X=f_[1,0]"),
    run("DEF REAL f_[2,3]|X=f_[2,0]", "DEF REAL f_[2,3]|f_[1,0]=2|X=f_[1,0]"),
    run("X=R7", "R7=1|X=R7"),
    run("DEF INT ii|ii=IC(5)", "DEF INT ii|ii=5"),
    run("DEF REAL X", "DEF REAL XX"),
    run("X=Y+1", "X=$AA_IW[Y]+1"),
    run("X=ACC[X]", "X1"),
    run("R1=SET(1,2)", "R1=1|R2=2"),
    run("X10 NONE1(5)", "X10|NONE1", how=NONE),
    run("X=QQ", "DEF REAL QQ=5|X=QQ"),
    run("TAKES(5)", "DEF REAL bb=5|TAKES(bb)", how=TAKES),
    run("X=LN(0)", "X=LN(1)"),
    run("X1 Y", "X1 Y2"),
    run("NONE1(5)", "NONE1", how=NONE),
    run("GIVES(1,2)", "GIVES(1)", how=VAR),
    run("X=$AA_IM[Q]", "X=$AA_IM[Y]"),
    Case(
        "siemens", "G0 X=$AA_IW[X]", "G0 X1 Y1 Z1|G0 X=$AA_IW[X]", how={**WRITE, "start": NOWHERE}
    ),
    run("X10 # 5", "X10"),
    run("X=ROUND(-2.5)", "X=-3"),
    run("DEF CHAR cc=300", "DEF REAL cc=300"),
    run("CALL 5", 'CALL "NONE1"', how=NONE),
    run("NONE1 P=-1", "NONE1 P=1", how=NONE),
    run("RET(1)", "RET"),
    run("X=TAN(90)", "X=TAN(9)"),
    run("X1 X2|R1=$AA_IW[X]", "X2|R1=$AA_IW[X]"),
    run('X="A"<<"B"', "X1"),
    run('X="A"+1', "X=1+1"),
    run("X=", "X=1"),
    run("X=AND", "X=1"),
    run("X=1+", "X=1+1"),
    run("X=R[-1]", "R1=1|X=R[1]"),
    run("DEF REAL f_[2,2,2,2]", "DEF REAL f_[2,2,2]"),
    run("DEF REAL f_[10000000]", "DEF REAL f_[10]"),
    run("IF TRUE X5", "IF TRUE|X5|ENDIF"),
    run("DEF FRAME f1", "TRANS X1|G0 X1"),
    run("X=FOO(1)", "X1"),
    run("X=" + "(" * 99 + "1" + ")" * 99, "X1"),
    run("SELF", "NONE1", how=NONE),
    run("DEF STRING[5] ss=5", 'DEF STRING[5] ss="5"'),
    run("DEF REAL f_[2]=SET(1,2,3)", "DEF REAL f_[3]=SET(1,2,3)"),
    run("X=1EX400", "X=1EX1"),
    run("X=$P_UIFR[1,X,TR]", "X1"),
    run("GOTOF NEXT", "GOTOF NEXT|NEXT: X1"),
    run("GOTO 5", "GOTO NEXT|NEXT: X1"),
    run("ENDIF X1", "IF TRUE|ENDIF|X1"),
    run("REPEATB NIX P=2", "NIX: X1|REPEATB NIX P=2"),
    run("NIX: X1|REPEAT NIX NUX P=2", "NIX: X1|NUX: X2|REPEAT NIX NUX P=2"),
    run("X=1/0", "X=1/2"),
    run("X=(1", "X=(1)"),
    run("FOR 5=1 TO 3|ENDFOR", "FOR R1=1 TO 3|ENDFOR"),
    run("PCALL", "NONE1", how=NONE),
    run("GOTOF", "GOTOF NEXT|NEXT: X1"),
    run("DEF REAL", "DEF REAL aa"),
    run("WHILE TRUE|X1", "WHILE FALSE|X1|ENDWHILE"),
    run("WHILE TRUE|X1|ENDWHILE", "WHILE FALSE|X1|ENDWHILE"),
    run("GOTOF (5)", "GOTOF NEXT|NEXT: X1"),
    run("DEF STRING[5] ss|ss=Y", 'DEF STRING[5] ss|ss="Y"'),
    run("REPEAT|X1", "REPEAT|X1|UNTIL TRUE"),
    run("IF TRUE|X1", "IF TRUE|X1|ENDIF"),
    run("GOTOB NEXT|NEXT: X1", "GOTOF NEXT|NEXT: X1"),
    run("GOTOF 1+1", "GOTOF NEXT|NEXT: X1"),
    run("X=AX[5]", "X1"),
    run("AX[5]=1", "AX[Y]=1"),
    run("X=AXSTRING(5)", "X1"),
    run("X=AXSTRING(Y)", "X1"),
    run("G70|X=$AA_IM[Y]", "G71|X=$AA_IM[Y]"),
    run('MSG("A"', 'MSG("A")'),
    run("GONE", "GONE", also={"library": {"GONE": "G0 X1|M17"}}),
    run("CASE 5 OF 5 GOTOF", "CASE 5 OF 5 GOTOF NEXT|NEXT: X1"),
    run("IF|ENDIF", "IF TRUE|ENDIF"),
    run("LOOP|X1", "NIX: X1"),
    run("X=IC(", "X=IC(1)"),
    run("R=5", "R1=5"),
    run("N10 REPEAT", "N10 REPEAT|UNTIL TRUE"),
    run("X=SIN()", "X=SIN(1)"),
    run("X=$AC_TIME", "X1"),
]
HOLE = "F100|CYCLE81(10,0,2,-5)"
MODAL = "F100|MCALL CYCLE81(10,0,2,-5)|"
DRILLING = [
    run("MCALL POCKET4(1)", HOLE),
    run("CYCLE81(10,0,2)", HOLE),
    run("CYCLE81(,0,2,-5)", HOLE),
    run("CYCLE81(1,0,2,-5)", HOLE),
    run("F100|CYCLE82(10,0,2,-5,,,1)", "F100|G0 Z2|G1 Z-5|G0 Z10"),
    run("F100|CYCLE83(10,0,2,-5,,,9)", "F100|CYCLE83(10,0,2,-5,,,2)"),
    run("CYCLE81(1,2,3,4,5,6,7,8,9,10)", HOLE),
    run('CYCLE81("A")', HOLE),
    run("CYCLE85(10,0,2,-5,,0,100,100)", "F100|CYCLE85(10,0,2,-5,,0,100,100)"),
    run("F100|CYCLE83(10,0,2,-5,,,0.0001)", "F100|CYCLE83(10,0,2,-5,,,1)"),
    run("G1 ANG=30 F100", "G1 X5 Y2 F100"),
    run("CYCLE84(10,0,2,-5,,,3,,1,0,500)", "S300 M3|CYCLE84(10,0,2,-5,,,3,,1,0,500)"),
    run("CYCLE84(10,0,2,-5,,,,,1,0,500)", "CYCLE84(10,0,2,-5,,,5,,1,0,500)"),
    run("CYCLE84(10,0,2,-5,,,5,,,0,500)", "CYCLE84(10,0,2,-5,,,5,,1,0,500)"),
    run("CYCLE84(10,0,2,-5,,,5,13,,0,500)", "CYCLE84(10,0,2,-5,,,5,,1,0,500)"),
    run("CYCLE84(10,0,2,-5,,,7,,1,0,500)", "CYCLE84(10,0,2,-5,,,5,,1,0,500)"),
    run(
        "S300 M3|CYCLE84(10,0,2,-5,,,5,,1,0,500,,,0,0,1,0.0001)",
        "S300 M3|CYCLE84(10,0,2,-5,,,5,,1,0,500,,,0,0,1,1)",
    ),
    run("F100|CYCLE83(10,0,2,-5,,,2,,,,2)", "F100|CYCLE83(10,0,2,-5,,,2,,,,1)"),
    run("F100|CYCLE83(10,0,2,-5,,,2,-0.5)", "F100|CYCLE83(10,0,2,-5,,,2,-0.5,,,,,,1)"),
    run("CYCLE93(10,0,2,-5)", "G0 Z2|G1 F100 Z-5|G0 Z10"),
    run(f"{MODAL}HOLES1(0,0,0,5,9)", f"{MODAL}HOLES1(0,0,0,5,9,2)"),
    run(f"{MODAL}HOLES1(0,0,0,5,9,2.5)", f"{MODAL}HOLES1(0,0,0,5,9,2)"),
    run(f"{MODAL}HOLES1(1,2,3,4,5,6,7,8,9,10,11,12)", f"{MODAL}HOLES1(0,0,0,5,9,2)"),
    run(f'{MODAL}HOLES2(0,0,"A",0,0,2)', f"{MODAL}X5 Y0|X-5"),
    run(f"{MODAL}HOLES2(0,0,-5,0,0,2)", f"{MODAL}HOLES2(0,0,5,0,0,2)"),
    run(f"{MODAL}HOLES2(0,0,5,0,0,2,10)", f"{MODAL}X5 Y0|X-5"),
    run(f"{MODAL}CYCLE801(0,0,0,1,1,500,500)", f"{MODAL}CYCLE801(0,0,0,1,1,5,5)"),
    run(f"{MODAL}CYCLE802(111111111,111111111,1)", f"{MODAL}CYCLE802(111111111,111111111,1,2)"),
    run(f"{MODAL}CYCLE802(111111111,111111111)", f"{MODAL}CYCLE802(111111111,111111111,1,2)"),
    run(f"DIAM90|{MODAL}HOLES1(0,0,0,5,9,2)", f"{MODAL}DIAMOF|HOLES1(0,0,0,5,9,2)"),
    run("F100|HOLES1(0,0,0,5,9,2)", f"{MODAL}HOLES1(0,0,0,5,9,2)"),
]
STEP = "AA: G1 X20 Z0|Z-10|BB: X30"


def removed(call: str, then: str, shape: str = STEP, mended: str = STEP) -> Case:
    head, tail = "G18 F1|G0 X60 Z5|", "|M30|"
    return run(f"{head}{call}{tail}{shape}", f"{head}{then}{tail}{mended}")


ROUGH, FINISH = 'CYCLE95("AA:BB",2,,,,0.2,,,1)', 'CYCLE95("AA:BB",,,,,,,0.1,5)'
REMOVALS = [
    removed('CYCLE95("AA:BB",2,,,,0.2)', ROUGH),
    removed('CYCLE95("AA:BB",,,,,0.2,,,1)', ROUGH),
    removed('CYCLE95("AA:BB",2,,,,0.2,,,9)', 'CYCLE95("AA:BB",2,,,,0.2,,0.1,9)'),
    removed("CYCLE95(,2,,,,0.2,,,1)", ROUGH),
    removed("G91|" + ROUGH, "G90|" + ROUGH),
    removed("G17|" + ROUGH, "G18|" + ROUGH),
    removed("G42 D1 G0 X61|" + ROUGH, "G42 D1 G0 X61|G40 X60|" + ROUGH),
    removed("G41 D1 G0 X61|" + FINISH, "G41 D1 G0 X61|G40 X60|" + FINISH),
    removed('CYCLE95("AA:BB",0.0001,,,,0.2,,,1)', ROUGH),
    removed(ROUGH, ROUGH, "AA: G1 X20|BB: X30"),
    removed(ROUGH, ROUGH, "AA: G1 X20 Z0|BB: X20"),
    removed(ROUGH, ROUGH, "AA: G1 X20 Z0|IF R1>0 GOTOF BB|BB: X30"),
    removed(ROUGH, ROUGH, "AA: G1 X20 Z0|G33 Z-5 K1|BB: X30 Z-9"),
    removed(ROUGH, "G1 X20 F0.2|Z-10|X18|Z-20", "AA: G1 X20 Z0|Z-9|X18|BB: Z-20"),
    removed('CYCLE95("AA:BB",2,,,,0.2,,,1,,5)', "G1 X20 F0.2|Z-10|X30"),
]
POCKET = "POCKET4(10,0,2,-4,12,5,7,2,.3,.2,400,150,0,1,6,,,3,2)"
TOOL = {"G54": {}, "D1": {"Z": 0.0, "R": 5.0}}


def pocket(old: str, new: str, then: str = POCKET, offsets=TOOL, **options) -> Case:
    return run(POCKET.replace(old, new), then, how={"offsets": offsets}, **options)


SMOOTH = "G1 X9 F100|Z-4|X-9|Z5"
POCKETS = [
    pocket("12,5", ",5"),
    pocket(",1,6", ",5,6", SMOOTH),
    pocket(",0,1,", ",7,1,"),
    pocket("400", "-1"),
    pocket("-4", "4"),
    pocket("POCKET", "G91|POCKET"),
    pocket("POCKET", "G41 X9|POCKET", "G41 X9|G40 X5|" + POCKET),
    pocket("", "", offsets={"G54": {}, "D1": {"Z": 0.0}}, also={"offsets": TOOL}),
    pocket("12,5", "4,5"),
    pocket(".3,.2,400,150,0,1", "0,0,400,150,0,2"),
    pocket("1,6,", "1,.0001,"),
    pocket("5,7,2", "5,7,.0001"),
    pocket(",1,6,,,3,2", ",21,6,,,0,2", POCKET.replace(",1,6", ",21,6")),
    pocket(",1,6,,,3", ",21,6,,,30", POCKET.replace(",1,6", ",21,6")),
]
FACE = "CYCLE71(10,0,2,-3,0,0,60,40,0,2,8,5,0,400,11,2)"
SPIGOT = "CYCLE77(10,0,2,-6,,20,40,30,3,0,0,400,150,0,1)"
MILLED = {"how": {"offsets": TOOL}}
MILLINGS = [
    run(FACE.replace(",8,5", ",18,5"), FACE, **MILLED),
    run(FACE.replace(",60,40", ",0,40"), FACE, **MILLED),
    run(FACE.replace(",11,2)", ",51,2)"), SMOOTH, **MILLED),
    run(SPIGOT.replace("400,150", "0,150"), SPIGOT, **MILLED),
    run(SPIGOT.replace(",-6,", ",,"), SPIGOT, **MILLED),
    run(SPIGOT.replace(",0,1)", ",0,1,25)"), SPIGOT.replace(",0,1)", ",0,1,50)"), **MILLED),
]
POLY = "POLY PO[X]=(9,2) PO[Y]=(5)"
POLYNOMIALS = [
    frame("G1 X50 RND=5|" + POLY, "G1 X50|" + POLY),
    frame("G1 " + POLY, POLY),
    frame("PO[X]=(9,2)", "POLY PO[X]=(9,2)"),
    frame('POLY|PO[X]=(9,2) MSG("A")', 'POLY|MSG("A")|PO[X]=(9,2)'),
    frame("POLY PO[X]=(9,1,1,1,1,1)", "POLY PO[X]=(9,1,1,1,1)"),
    frame("POLY PO[X]=(9,2) PO[]=(-2)", "G1 X9"),
    frame("G41 D1 G1 X9|" + POLY, "G41 D1 G1 X9|G40 X5|" + POLY),
    frame("G91 " + POLY, "G90 " + POLY),
    frame(POLY + " PL=0", POLY + " PL=1"),
    frame("DIAM90|" + POLY, "DIAMOF|" + POLY),
    frame(POLY + " PO[]=(2,1) Z9", POLY + " PO[]=(2,1) PO[Z]=(9)"),
    run("G1 X2 FB=200|X3", "G1 F50|X2 FB=200|X3"),
]
FIVE = {
    "machine": "example-five-axis",
    **WRITE,
    "offsets": {"G54": {}, "D1": {"Z": 100.0}},
}


def turned(before: str, after: str, then: str = "", **options) -> Case:
    head = "G90 G54 T1 D1 G0 X0 Y0 Z-300 A0 C0|TRAORI|"
    how = {**FIVE, **options.pop("how", {})}
    return Case("siemens", head + before, head + after, then, how=how, **options)


DIRECTIONS = [
    turned("TRAFOOF|G1 X5 C3=1 F9", "G1 X5 C3=1 F9"),
    turned("ORIMKS|G1 X5 C3=1 F9", "ORIWKS|G1 X5 C3=1 F9"),
    turned("ROT Z30|G0 X1 Y1 Z-9|G1 X5 Y1 Z-9 C3=1 F9", "G1 X5 Y1 Z-300 A1 F9"),
    turned("G1 X5 A5 C3=1 F9", "G1 X5 C3=1 F9"),
    turned("G1 X5 A2=1 F9", "G1 X5 A1 F9"),
    turned("G1 X5 LEAD=1 F9", "G1 X5 A1 F9"),
    turned("G1 X5 C3=1 F9", "G1 X5 C3=1 F9", first={"expand": False}),
]
ALL = [
    *DIRECTIONS,
    *MILLINGS,
    *DRILLING,
    *REMOVALS,
    *POCKETS,
    *FRAMES,
    *CORNERS,
    *ARCS,
    *PARTS,
    *POLYNOMIALS,
]
