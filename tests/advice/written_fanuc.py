"""Sentences on what is written out: Fanuc's and Haas's cycles, frames and macros."""

from __future__ import annotations

from tests.advice.follow import NOWHERE, WRITE, Case
from tests.corpus.machines import offsets

A, M, H = "fanuc-lathe-a", "fanuc-mill", "haas"


def lathe(before: str, after: str, then: str = "", **options) -> Case:
    head = "G0 X100. Z2.|"
    return Case(A, head + before, head + after, then, how=WRITE, **options)


def mill(before: str, after: str, then: str = "", dialect: str = M, **options) -> Case:
    head = "G90 G0 X1. Y2. Z5.|F100|"
    return Case(dialect, head + before, head + after, then, how=WRITE, **options)


def macro(before: str, after: str, then: str = "", dialect: str = M, **options) -> Case:
    head = "O1|G90 G0 X1. Y2. Z5.|F100|"
    how = {**WRITE, **options.pop("how", {})}
    return Case(dialect, head + before, head + after, then, how=how, **options)


ROUGH = "G71 U2. R1.|G71 P10 Q20 F.2|"
NURBS = (
    "G90 G0 X0. Y0.|G6.2 P3 K0. X0. Y0. R1. F500.|K0. X5. Y0. R.70710678|K0. X5. Y5."
    " R1.|K1.|K1.|K1.|G1 X9."
)


def nurbs(old: str, new: str) -> Case:
    assert old in NURBS
    return Case(M, NURBS.replace(old, new, 1), NURBS, how=WRITE)


TURNING = [
    Case(
        "haas",
        "G90 G0 X1. Y2. Z5.|F100|G68 X0. Y0. R30|G1 X9.|G69",
        "G90 G0 X1. Y2. Z5.|F100|G68 X0. Y0. R30.|G1 X9. Y2.|G69",
        how=WRITE,
    ),
    mill(
        "G51 X0 Y0 Z0 I2. J3. K1.|G2 X5. Y2. I2. J0|G50",
        "G51 X0 Y0 Z0 I2. J3. K1.|G1 X3. Y4.|X5. Y2.|G50",
    ),
    lathe(
        ROUGH + "N10 G0 X40.|Z-5.|X30. Z-9.|N20 X100.",
        ROUGH + "N10 G0 X30.|G1 Z-5.|X40. Z-9.|N20 X100.",
    ),
    lathe("G74 Z-5. Q1000 K1. F.1", "G74 Z-5. Q1000 F.1"),
    lathe("G1 X90. I-1. F.1|Z-9.", "G1 X88. F.1|X90. Z-1.|Z-9."),
    lathe("G1 X90. K1. F.1|Z-9.", "G1 X88. F.1|X90. Z-1.|Z-9."),
    lathe("M3 S100|G83 Z-5. R-1. K2 L2 F.1", "M3 S100|G83 Z-5. R-1. K2 F.1|G80"),
    lathe("G90 X50. Z-5. R1. I1. F.1", "G90 X50. Z-5. R1. F.1"),
    lathe("G74 R1. Z-5. F.1", "G74 Z-5. F.1"),
    lathe(ROUGH + "N10 G0 X40. B8.|N20 G1 Z-5.", ROUGH + "N10 G0 X40.|N20 G1 Z-5."),
    lathe("G90 X50. U-5. Z-5. F.1", "G90 X50. Z-5. F.1"),
    lathe(ROUGH + "N10 G0 X40.|G4 X1.|N20 G1 Z-5.", ROUGH + "N10 G0 X40.|N20 G1 Z-5."),
    lathe("G42 G1 X90. F.1|G90 X80. Z-5.", "G42 G1 X90. F.1|G40 G1 X91.|G90 X80. Z-5."),
    lathe(
        "G42 G0 X99.|G70 P10 Q20|G40 G0 X98.|M30|N10 G0 G42 X40.|N20 G1 G40 Z-5. F.1",
        "G42 G0 X99.|G70 P10 Q20|G40 G0 X98.|M30|N10 G0 X40.|N20 G1 Z-5. F.1",
    ),
    Case(
        "haas-lathe",
        "G0 X100. Z2.|G42 G0 X99.|G70 P10 Q20|G40 G0 X98.|M30|N10 G0 X40.|N20 G1 Z-5. F.1",
        "G0 X100. Z2.|G70 P10 Q20|G0 X98.|M30|N10 G0 G42 X40.|G1 Z-5. F.1|N20 G0 G40 X99.",
        how=WRITE,
    ),
    lathe("G70|G0 Z9.", "G70 P10 Q20|G0 Z9.|M30|N10 G0 X40.|N20 G1 Z-5. F.1"),
    lathe(
        "G70 P10 Q20|N10 G0 G42 X40.|N20 G1 Z-5. F.1",
        "G70 P10 Q20|N10 G0 G42 X40.|G1 Z-5. F.1|N20 G40 G1 X60.",
    ),
    lathe("G71|G0 Z9.", ROUGH + "N10 G0 X40.|N20 G1 Z-5."),
    lathe(
        "G73 U2.|G73 P10 Q20|N10 G0 X40.|N20 G1 Z-5. F.1",
        "G73 U2. R2|G73 P10 Q20|N10 G0 X40.|N20 G1 Z-5. F.1",
    ),
    lathe(
        "G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5. F.1",
        "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5. F.1",
    ),
    lathe(ROUGH + "N10 G0 Z0.|N20 G1 Z-5.", ROUGH + "N10 G0 X40.|N20 G1 Z-5."),
    lathe(ROUGH + "N10 G0 X40.|G1 Z-5.|N20 G0 X100. Z2.", ROUGH + "N10 G0 X40.|N20 G1 Z-5."),
    lathe(ROUGH + "N10 G0 X40.|G1 Z-5.|N20 X30. Z-9.", ROUGH + "N10 G0 X30.|G1 Z-5.|N20 X40. Z-9."),
    lathe(ROUGH + "N10 G0 X40.|N20 G1 Z-5. ,R2.", ROUGH + "N10 G0 X40.|N20 G1 Z-5."),
    lathe(
        "G71 U2. R1.|G71 P11 Q20|N10 G0 X40.|N20 G1 Z-5. F.1", ROUGH + "N10 G0 X40.|N20 G1 Z-5. F.1"
    ),
    lathe(
        "G71 U2. R1.|G71 P10 Q30|N10 G0 X40.|N20 G1 Z-5. F.1", ROUGH + "N10 G0 X40.|N20 G1 Z-5. F.1"
    ),
    lathe("G75 F.1|G0 Z9.", "G75 X50. Z-5. P5000 Q5000 F.1|G0 Z9."),
    lathe("G75 X50. P1000 R.2 F.1", "G75 X50. Z-5. P5000 Q5000 R.2 F.1"),
    Case(
        "haas-lathe",
        "G0 X100. Z2.|G75 X50. Z-5. I1. K1. D.2 F.1",
        "G0 X100. Z2.|G75 X50. Z-5. I1. K1. F.1",
        how=WRITE,
    ),
    lathe(
        "G70 P10 Q20|M30|N10 G0 X40.|N20 G1 Z-5. F.1|N10 G0 X1.",
        "G70 P10 Q20|M30|N10 G0 X40.|N20 G1 Z-5. F.1|N11 G0 X1.",
    ),
    lathe(ROUGH + "N10 G0 X40.|N20 X40.", ROUGH + "N10 G0 X40.|N20 G1 Z-5."),
    lathe(ROUGH + "N10 G0 X40.|N20 G2 X50. Z-5.", ROUGH + "N10 G0 X40.|N20 G2 X50. Z-3. R5."),
    lathe(ROUGH + "N10 G0 X40.|N20 G2 X50. Z-30. R5.", ROUGH + "N10 G0 X40.|N20 G2 X50. Z-3. R5."),
    lathe(
        "G73 U2. R2|G73 P10 Q20 D1.5|N10 G0 X40.|N20 G1 Z-5. F.1",
        "G73 U2. R2|G73 P10 Q20|N10 G0 X40.|N20 G1 Z-5. F.1",
    ),
    lathe(
        "G71 U.0001 R1.|G71 P10 Q20 F.2|N10 G0 X40.|N20 G1 Z-5.", ROUGH + "N10 G0 X40.|N20 G1 Z-5."
    ),
    lathe("G74 R1.|G74 X50. Z-5. P1 Q1 F.1", "G74 R1.|G74 X50. Z-5. P5000 Q1000 F.1"),
    lathe("G74 R1.|G74 Z-50. Q1 F.1", "G74 R1.|G74 Z-50. Q1000 F.1"),
]
L0 = "G81 Z-5. R2. L0|"
BOLTS = [
    mill("G70 I20. J0. L4|G80", f"{L0}G70 I20. J0. L4|G80", dialect=H),
    mill(f"{L0}G70 J0. L4|G80", f"{L0}G70 I20. J0. L4|G80", dialect=H),
    mill(f"{L0}G70 I20. J0. L1.5|G80", f"{L0}G70 I20. J0. L4|G80", dialect=H),
    mill(f"{L0}G70 I20. J30 L4|G80", f"{L0}G70 I20. J30. L4|G80", dialect=H),
    mill(
        "G83 Z-5. R2. Q1. G70 I20. J0. L4|G80",
        "G83 Z-5. R2. Q1. L0|G70 I20. J0. L4|G80",
        dialect=H,
    ),
    mill(f"G18 {L0}G70 I20. J0. L4|G80", f"G17 {L0}G70 I20. J0. L4|G80", dialect=H),
    mill(
        f"{L0}X9. L0|G70 I20. J0. L4|G80",
        f"{L0}X9. L0|G70 X9. Y2. I20. J0. L4|G80",
        dialect=H,
    ),
    mill("G101 X5.|G0 X3.", "G101 X0|G0 X3.|G100 X0", dialect=H),
    mill("G101|G0 X3.", "G101 X0 Y0|G0 X3. Y4.|G100 X0 Y0", dialect=H),
    mill("G101 X0 Y0|G100|G0 X3.", "G101 X0 Y0|G100 X0 Y0|G0 X3. Y4.", dialect=H),
]
FIRST = "N10 G0 X40.|G1 Z-5. F.1|"
BEHIND = [
    macro(
        "#1=0|WHILE[#1 LT 2]DO1 #1=#1+1|G1 X#1|END1",
        "#1=0|WHILE[#1 LT 2]DO1|#1=#1+1|G1 X#1|END1",
    ),
]
DRAWN = [
    lathe(
        "G71 U-2. R1.|G71 P10 Q20 F.2|N10 G0 X40.|N20 G1 Z-5.", ROUGH + "N10 G0 X40.|N20 G1 Z-5."
    ),
    lathe(
        ROUGH + "N10 G0 X40.|G1 Z-5.|X30. Z-9.|N20 X100.",
        ROUGH + "N10 G0 X40. Z2.|G1 Z-5.|X30. Z-9.|N20 X100.",
    ),
    lathe(
        ROUGH + "N10 G0 X40. Z2.|G1 Z-5.|X120. Z-9.|X30.|N20 X100.",
        "G0 X130.|" + ROUGH + "N10 G0 X40. Z2.|G1 Z-5.|X120. Z-9.|X30.|N20 X100.",
    ),
    lathe(
        "G71 U2. R1.|G71 P10 Q20 U-.5 F.2|N10 G0 X40. Z2.|G1 Z-5.|X30. Z-9.|N20 X100.",
        "G71 U2. R1.|G71 P10 Q20 U.5 F.2|N10 G0 X40. Z2.|G1 Z-5.|X30. Z-9.|N20 X100.",
    ),
    lathe(
        ROUGH + "N10 G0 X40. Z2.|G1 Z-5.|G2 X60. Z-5.5 R10.|G1 X50.|N20 X100.",
        ROUGH + "N10 G0 X40. Z2.|G1 Z-5.|X60. Z-5.5|X50.|N20 X100.",
    ),
    lathe(
        "G71 U.0005 R1.|G71 P10 Q20 F.2|N10 G0 X40. Z2.|G1 Z-5.|X30. Z-9.|N20 X100.",
        ROUGH + "N10 G0 X40. Z2.|G1 Z-5.|X30. Z-9.|N20 X100.",
    ),
    lathe(ROUGH + FIRST + "#1=50.|N20 X100.", ROUGH + FIRST + "X50.|N20 X100."),
    lathe("G1 X90. F.1|A90.", "G1 X90. F.1|X95."),
    lathe("G1 X90. F.1|Z-9. A90.", "G1 X90. F.1|Z-9. X95."),
    lathe("G1 X90. F.1|X80. A180.", "G1 X90. F.1|X80. Z-9."),
    lathe("G1 X90. ,R5. C1. F.1|Z-9.", "G1 X90. C1. F.1|Z-9."),
    lathe(ROUGH + FIRST + "A90.|N20 A90.", ROUGH + FIRST + "N20 X100."),
    lathe(ROUGH + FIRST + "X60.|N20 A90.", ROUGH + FIRST + "X60.|N20 X100."),
    lathe(ROUGH + FIRST + "A90.|N20 X100.", ROUGH + FIRST + "X60.|N20 X100."),
    lathe(ROUGH + FIRST + "A90.|X60. Z-9. A90.|N20 X100.", ROUGH + FIRST + "X60.|Z-9.|N20 X100."),
    lathe(ROUGH + FIRST + "X60. ,C20.|Z-9.|N20 X100.", ROUGH + FIRST + "X60. ,C2.|Z-9.|N20 X100."),
    lathe(ROUGH + FIRST + "X60. ,C2.|N20 X100.", ROUGH + FIRST + "X60.|N20 X100."),
    lathe(
        ROUGH + FIRST + "X60. ,C2.|G2 X80. Z-15. R10.|N20 G1 X100.",
        ROUGH + FIRST + "X60.|G2 X80. Z-15. R10.|N20 G1 X100.",
    ),
    lathe("G1 X90. ,R5. F.1|W-9.", "G1 X90. ,R5. F.1|Z-9."),
]
DRILLING = [
    mill("M3 S9|G83 Z-9. R2. Q2. I1.", "M3 S9|G83 Z-9. R2. Q2.|G80", dialect=H),
    mill("M3 S9|G81 Z-9. R2.|L0", "M3 S9|G81 Z-9. R2.|G80|L0", "", dialect=M),
    mill("M3 S9|G87 X1. Z-5. R2. Q.1", "M3 S9|G0 Z2.|G1 Z-5.|G0 Z5."),
    mill("M3 S9|G81 R2.", "M3 S9|G81 Z-5. R2.|G80"),
    mill("M3 S9|G83 Z-5. R2.", "M3 S9|G83 Z-5. R2. Q1.|G80"),
    mill("M3 S9|G83 Z-5. R2. Q.005 K99", "M3 S9|G83 Z-5. R2. Q1. K9|G80"),
    mill("M3 S9|G81 Z-5. R2. G28", "M3 S9|G28|G81 Z-5. R2.|G80", "not known"),
    mill("M3 S9|G81 G83 Z-5. R2. Q1.", "M3 S9|G83 Z-5. R2. Q1.|G80"),
    mill("M3 S9|G41 D1 G1 X5.|G81 Z-5. R2.", "M3 S9|G41 D1 G1 X5.|G40 G1 X9.|G81 Z-5. R2.|G80"),
    mill("M3 S9|G4 P1 G81 Z-5. R2.", "M3 S9|G4 P1|G81 Z-5. R2.|G80"),
    mill("M3 S9|G91 G81 X1. Z-5. R-2. K2|R-3.", "M3 S9|G91 G81 X1. Z-5. R-2. K2|R-3. Z-5.|G80"),
    mill("M3 S9|G93 G81 X1. Z-5. R2. F1", "M3 S9|G94 G81 X1. Z-5. R2. F1|G80"),
    Case(
        M,
        "M3 S9|F9|G99 G81 X1. Y1. Z-1. R2.|G98 X2.",
        "M3 S9|F9|G0 Z9.|G99 G81 X1. Y1. Z-1. R2.|G98 X2.|G80",
        how={**WRITE, "start": {"X": 0.0, "Y": 0.0}},
    ),
    Case(
        M,
        "M3 S9|F9|G0 Z50|G43 H1|G81 X1. Y1. Z-1. R2.",
        "M3 S9|F9|G43 H1|G0 Z50|G81 X1. Y1. Z-1. R2.|G80",
        first={"offsets": {"G54": {}}},
        how=WRITE,
    ),
    Case(
        M,
        "M3 S9|F9|G81 X1. Y1. Z-1. R2.",
        "M3 S9|F9|G81 X1. Y1. Z-3. R-2.|G80",
        first={"start": NOWHERE},
        how=WRITE,
    ),
]
HAAS_LATHE = [
    Case(
        "fanuc-lathe",
        "G0 X10. Z5.|M3 S9|G91 G83 X0. Z-5. F.1|G80",
        "G0 X10. Z5.|M3 S9|G91 G83 X0. Z-5. R-1. F.1|G80",
        how=WRITE,
    ),
    Case(
        "haas-lathe",
        "G0 X100. Z2.|G73 P10 Q20 D2 I1.|N10 G0 G42 X40.|N20 G1 G40 Z-5. F.1",
        "G0 X100. Z2.|G73 P10 Q20 D2 I1.|N10 G0 X40.|N20 G1 Z-5. F.1",
        how=WRITE,
    ),
    Case(
        "haas-lathe",
        "G0 X20. Z5.|G81 Z-8. R2. F.1|G80|G0 W1.",
        "G0 X20. Z5.|G81 Z-8. R2. F.1|G80|G0 Z6.",
        how=WRITE,
    ),
]
FAGOR = [
    mill(before, after, dialect="fagor")
    for before, after in (
        ("G83 X1. Z2. I-3.|G80", "G83 X1. Z2. I-3. J2|G80"),
        ("G81 X1. Z2. I-3.|X2. Z3.", "G81 X1. Z2. I-3.|G81 X2. Z3. I-3.|G80"),
        ("G81 X1. Z2. I-3.|G0 X2.", "G81 X1. Z2. I-3.|G80|G0 X2."),
    )
]
OKUMA = [
    mill(before, after, dialect="okuma")
    for before, after in (
        ("G81 X1. Z-4. R2.", "G81 X1. Z-4. R2. M54|G0 Z5."),
        ("G81 X1. Z-4. R2. M53", "G71 Z5.|G81 X1. Z-4. R2. M53|G0 Z5."),
        ("G71|G0 X2.", "G71 Z5.|G0 X2."),
        ("G91 G71 Z5.|G90 G0 X2.", "G90 G71 Z5.|G90 G0 X2."),
    )
]
LAP = "NSH G81|G0 X40. Z5.|G1 Z-9. F.1|X100.|G80|"
OKUMA_LATHE = [
    Case("okuma-lathe", f"G0 X100. Z9.|{before}", f"G0 X100. Z9.|{after}", how=WRITE)
    for before, after in (
        (LAP + "G85 NSH D4. Q1", LAP + "G85 NSH D4. F.3"),
        (LAP + "G85 NSH F.3", LAP + "G85 NSH D4. F.3"),
        (LAP + "G86 NSH D0", LAP + "G86 NSH D4."),
        (LAP + "G87 NOTHER", LAP + "G87 NSH"),
        (LAP.replace("X100.|", "X100. B3.|") + "G87 NSH", LAP + "G87 NSH"),
        ("G1 F.1|G75 X90.|Z1.", "G1 F.1|G75 X90. L1.|Z1."),
        ("NSH G81|G1 X40. F.1|G80|G85 NSH D4.", LAP + "G85 NSH D4."),
        ("NSH G81|G0 X40. Z5.|G75 G1 Z-9. F.1|X90.|G80|G87 NSH", LAP + "G87 NSH"),
        ("NSH G81|G1 X100. Z5.|Z-9. F.1|G80|G86 NSH D4.", LAP + "G86 NSH D4."),
        ("G1 X90. F.1|G2 X80. Z0 L2.", "G1 X90. F.1|G2 X80. Z4. L9."),
        ("G91 G181 X50. Z-9. K1. F.1", "G90 G181 X50. Z-9. K1. F.1"),
        ("G181 X50. Z-9. F.1", "G181 X50. Z-9. K1. F.1"),
        ("G85", LAP + "G85 NSH D4."),
        ("G81|G1 X40. F.1|G80", LAP),
        ("NSH G81|G1 X40. F.1", LAP),
        ("G181 X50. K1. F.1", "G181 X50. Z-9. K1. F.1"),
        ("G1 F.1|G73 X90. Z1. D1.", "G1 F.1|G73 X90. Z1. K2. D1."),
        ("G1 F.1|G73 X100. Z1. K2. D1.", "G1 F.1|G73 X90. Z1. K2. D1."),
        ("G1 F.1|G73 X90. D.0001", "G1 F.1|G73 X90. D1."),
        ("G1 F.1|G42|G74 Z1. D1.|G40", "G1 F.1|G74 Z1. D1."),
    )
]
ASIDE = {**offsets(), "T0909": {"X": 1.0, "Z": 0.0}}
OKUMA_LATHE += [
    Case(
        "okuma-lathe", "T0101|G0 X90. Z9.|G74 Z1. D1. F.1 T0909",
        "T0101|G0 X90. Z9.|G1 F.1|G74 Z1. D1.", how={**WRITE, "offsets": ASIDE},
    ),
    *(
        Case("okuma-lathe", hole, hole.replace("Q3", "C0. Q3"), "no axis C", how=WRITE)
        for hole in ("G0 X90. Z9.|G181 X50. Z-9. K1. Q3 F.1",)
    ),
]  # fmt: skip
FIVE = {"machine": "example-five-axis", **WRITE, "offsets": {"G54": {}, "H1": {"Z": 100.0}}}


def turned(before: str, after: str, then: str = "", **options) -> Case:
    head = "G90 G0 X0. Y0. Z-300. A0. C0.|"
    how = {**FIVE, **options.pop("how", {})}
    return Case(M, head + before, head + after, then, how=how, **options)


D1 = {"offsets": {"G54": {}, "D1": {"R": 2.0}}}
POCKETS = [
    mill(before, after, dialect=H, first=D1, also=D1)
    for before, after in (
        ("G18 G12 I8. D1", "G17 G12 I8. D1"),
        ("G12 I8. D1 L2", "G91 G12 I8. D1 Z-1. L2"),
        ("G12 D1", "G12 I8. D1"),
        ("G12 I8. K9. D1", "G12 I8. K9. Q1. D1"),
        ("G12 I8. K9. Q0 D1", "G12 I8. K9. Q1. D1"),
        ("G12 I2. D1", "G12 I3. D1"),
        ("G12 I8.", "G12 I8. D0"),
        ("G12 I8. D9", "G12 I8. D1"),
    )
]
DIRECTIONS = [
    Case(
        M,
        "G43.5 H1|G1 X1. F9",
        "G43 H1|G1 X1. F9",
        how={**WRITE, "offsets": {"H1": {}}, "lathe": True},
    ),
    turned("G43.5 H1 Q2.|G1 X1. F9", "G43.5 H1|G1 X1. F9"),
    turned("G43.5 H1|G2 X5. I1. J1. F9", "G43.4 H1|G1 X5. A1. F9"),
    turned("G43.5 H1|G91 G1 X5. J1. K9. F9", "G43.5 H1|G90 G1 X5. J1. K9. F9"),
    turned("G43.5 H1|G1 X5. I0 J0 K0 F9", "G43.5 H1|G1 X5. I0 J0 K1. F9"),
    turned("G43.5 H1|G1 X5. K-1. F9", "G43.5 H1|G1 X5. K1. F9"),
    Case(
        M,
        "G43.5 H1|G1 X5. J1. K9. F9",
        "G0 A0. C0.|G43.5 H1|G1 X5. Y0. Z-300. J1. K9. F9",
        "",
        how={**FIVE, "start": NOWHERE},
    ),
]
FRAMES = [
    mill("G68 X0 Y0 Z1. R30.", "G68 X0 Y0 R30.|G69|G0 X1. Y1."),
    mill("G51.1 X0|G68 X0 Y0 R30.", "G51.1 X0|G50.1 X0|G0 X1. Y1.|G68 X0 Y0 R30.|G69|G0 X1. Y1."),
    mill("G68 X0 Y0 R30.|G54", "G68 X0 Y0 R30.|G69|G54|G0 X1. Y1."),
    mill("G68 X0 Y0 R30.|G28 X0", "G68 X0 Y0 R30.|G69|G28 X0|G0 X1. Y1."),
    mill(
        "G51 X0 Y0 Z0 P2.|G68 X0 Y0 R30.|G50",
        "G51 X0 Y0 Z0 P2.|G68 X0 Y0 R30.|G69|G50|G0 X1. Y1. Z5.",
    ),
    mill("G68 X0 Y0 R30.|G51 X0 Y0 P2.", "G51 X0 Y0 P2.|G68 X0 Y0 R30.|G69|G50|G0 X1. Y1. Z5."),
    mill("G51 X0 Y0|G0 X3.", "G51 X0 Y0 P2.|G0 X3. Y3. Z5.|G50|G0 X1. Y1. Z5.", dialect=H),
    mill("G51.1|G0 X3.", "G51.1 X0|G0 X3. Y1.|G50.1 X0|G0 X1. Y1."),
    mill(
        "G91 G68 X0 Y0 R30.|G68 X0 Y0 R30.",
        "G91 G68 X0 Y0 R30.|G69|G90 G68 X0 Y0 R30.|G69|G0 X1. Y1.",
    ),
    mill("G68 X0 R30.", "G68 X0 Y0 R30.|G69|G0 X1. Y1."),
    mill("G68 X0 Y0 Z0 I0 J0 K1 R30.", "G68 X0 Y0 R30.|G69|G0 X1. Y1."),
    mill("G68 X0 Y0", "G68 X0 Y0 R30.|G69|G0 X1. Y1."),
    mill("G51 X0 Y0 Z0 P2. I2.", "G51 X0 Y0 Z0 P2.|G50|G0 X1. Y1. Z5."),
    mill("G51 X0 Y0 Z0 P0.", "G51 X0 Y0 Z0 P2.|G50|G0 X1. Y1. Z5."),
    mill("G68 X0 Y0 R30.|G18", "G68 X0 Y0 R30.|G69|G18|G0 X1. Y1. Z1."),
    mill("M3 S9|G51 X0 Y0 Z0 P2.|G84 Z-5. R1.", "M3 S9|G84 Z-5. R1.|G80"),
    Case(
        M,
        "G68 R90.|G0 X1. Y1.|G69|G0 X1. Y1.",
        "G68 X0 Y0 R90.|G0 X1. Y1.|G69|G0 X1. Y1. Z5.",
        how={**WRITE, "start": NOWHERE},
    ),
    Case(
        M,
        "G68 R90.|G0 X1. Y1.|G69|G0 X1. Y1.",
        "G68 R90.|G0 X1. Y1.|G69|G0 X1. Y1.",
        first={"start": NOWHERE},
        how=WRITE,
    ),
    mill("G41 D1 G1 X5.|G51.1 X0", "G41 D1 G1 X5.|G40 G1 X9.|G51.1 X0|G50.1 X0|G0 X1. Y1."),
    mill("G51 X0 Y0 Z0 P2|G0 X3.", "G51 X0 Y0 Z0 P2.|G0 X3. Y3. Z5.|G50|G0 X1. Y1. Z5.", dialect=H),
    mill(
        "G68 X0 Y0 R30.|G1 X5. Y5.|G69|G91 X1.", "G68 X0 Y0 R30.|G1 X5. Y5.|G69|G90 X1. Y1.|G91 X1."
    ),
    mill("G16|X50.", "G16|G0 X50. Y30.|G15|G0 X1. Y1."),
    mill("G68 X0 Y0 R30.|G90.1 G2 X5. Y5. I1. J1.", "G68 X0 Y0 R30.|G0 X1. Y1.|G69|G0 X1. Y1."),
]
CURVES = [
    nurbs("G90 G0 X0. Y0.|", "G90 G0 X0. Y0.|G91 "),
    nurbs("P3", "P5"),
    nurbs("|K0. X5. Y0.", "|X5. Y0."),
    nurbs("X5. Y5.", "X5. Z5."),
    nurbs("R.70710678", "R-1."),
    nurbs("|K1.|K1.|K1.", "|K1.|K1|K1."),
    nurbs(" R.70710678", ""),
    nurbs("|K1.|K1.|K1.", "|K1.|K1."),
    nurbs("K0. X0. Y0.", "K0. X1. Y0."),
    nurbs("|K1.|K1.|K1.", "|K1.|K1.|K2."),
    nurbs("G90 G0 X0. Y0.|", "G90 G0 X0. Y0.|G41 D1 G1 X1. F9|"),
    nurbs("G90 G0 X0. Y0.|G6.2", "G90 G0 X0. Y0.|G93 G6.2"),
]
SUB = "|M30|O9|G1 X#1 F100|M99"
MACROS = [
    macro("X#", "X#100", how={}, also={}),
    macro("G91|#5221=1|G90", "G90|#5221=1|G91|G90|G0 X2. Y2. Z5."),
    macro("#5221=#0", "#5221=0|G0 X2. Y2. Z5."),
    macro("#5229=1", "G0 X3."),
    macro("#5201=1", "#5221=1|G0 X2. Y2. Z5.", dialect="haas"),
    Case(M, "O1|X#5041", "O1|G0 X#5041 Y1. Z1.", first={"start": NOWHERE}, how=WRITE),
    macro("#2001=1", "G0 X3."),
    macro("#0=1", "#1=1"),
    macro("#1=5 X1", "#1=5|X1."),
    macro("X1. G65P9A1." + SUB, "G65P9A1." + SUB),
    macro("X[#1", "X1."),
    macro("G65P9G1" + SUB, "G65P9A1." + SUB),
    macro("X[POW[10,9]]", "X[POW[10,1]]"),
    macro("#1=99|M#1", "M9"),
    macro("G65P9" + "I1." * 11 + SUB, "G65P9" + "I1." * 10 + "A1." + SUB),
    macro("N1 X1.|GOTO 1", "X1.|M30"),
    macro("#1=0|N1 #1=#1+1|GOTO 1", "G0 X1.", how={}),
    macro(
        "#1=0|WHILE[#1 LT 9999]DO1|#1=#1+1|END1",
        "#1=0|WHILE[#1 LT 9999]DO1|#1=#1+1|END1",
        also={"steps": 90_000},
    ),
    macro("M98P9|M30|O9|G0 X1.", "M98P9|M30|O9|G0 X1.|M99"),
    macro("X[LN[0]]", "X[LN[1]]"),
    macro("M98P9.5|M30|O9|M99", "M98P[FIX[9.5]]|M30|O9|M99"),
    macro("M98|M30|O9|M99", "M98P9|M30|O9|M99"),
    macro("X[ATAN[1]/[-1]]", "X[ATAN2[1]/[-1]]", dialect=H),
    macro("G[90.55]", "G[90]"),
    macro("G66.1P9A1.|X1." + SUB, "G65P9A1.|X1.|G65P9A1." + SUB),
    macro("#1=1.5|GOTO#1|N1 X1.", "#1=1|GOTO#1|N1 X1."),
    macro("/M99", "M30"),
    macro("IF[#101EQ#0]THEN#101=5|G1 X#101 F9|#101=#101+1|M99", "G1 X5. F9|M30"),
    macro("/M99|M30", "/M99|M30", also={"delete": True}),
    macro("GOTO 5|WHILE[1 EQ 0]DO1|N5X1.|END1", "GOTO 5|WHILE[1 EQ 0]DO1|X1.|END1|N5X1."),
    macro("WHILE[1 EQ 0]", "WHILE[1 EQ 0]DO1|END1"),
    macro("G66P9A1.|M98P9X1." + SUB, "G66P9A1.|X1.|M98P9|G67|M30|O9|G1 X5. F100|M99"),
    macro("IF[1 EQ 1]", "IF[1 EQ 1]THEN #2=5"),
    macro("IF[1 EQ 1]THEN", "IF[1 EQ 1]THEN #2=5"),
    macro("#2", "#2=5"),
    macro("X" + "[" * 60 + "1" + "]" * 60, "#1=1|X#1"),
    macro("M98P1", "M30"),
    macro("X[1/0]", "X[1/1]"),
    macro("M98P9L0|M30|O9|M99", "M98P9L1|M30|O9|M99"),
    macro("X[SIN", "X[SIN[30]]"),
    macro("X[FOO[1]]", "X[SIN[1]]"),
    macro("IF[#1EQ#0]THEN#3000=1(NO DEPTH)", "#1=5|IF[#1EQ#0]THEN#3000=1(NO DEPTH)"),
    macro("GOTO 9", "GOTO 9|N9 X1."),
    macro("M98P7|M30", "M98P7|M30|O7|X1.|M99"),
    macro("M98P7|M30", "M98P7|M30", also={"library": {"7": "O7|X1.|M99"}}),
    macro("X[#[0-1]]", "#100=1|X#100"),
    macro("M98P9M99|M30|O9|M99", "M98P9|M30|O9|M99"),
    macro("X[1 EQ 1 EQ 1]", "X[[1 EQ 1] AND [1 EQ 1]]"),
    macro("X1. X2.|X#5001", "X2.|X#5041"),
    macro("X#5061", "X1."),
    macro("X#500", "#500=5|X#500"),
    macro("X#1000", "X1."),
    macro("X[SIN[1,2]]", "X[SIN[1]]"),
    macro("X[1+2", "X[1+2]"),
    macro("N[10**9]", "N9"),
    macro("#1=1|GOTO 7|M98P9H7|M30|O9|N8 M99", "G0 X1."),
    macro("X1" + "0" * 400, "X1."),
    macro("T#1.5", "T1"),
    Case(H, "O1|M97P7|M30|N8 M99", "O1|M97P7|M30|N7 M99", how=WRITE),
    Case(M, "O1|M98P9Q7|M30|O9|N8 M99", "O1|M98P9|M30|O9|N8 M99", how=WRITE),
]
MORE = [
    macro("#1=5|X#1|#3003=1", "#1=5|X#1"),
    macro("#4120=5", "G0 X1."),
    macro("X#3011", "X1."),
    macro("X1. [", "X1."),
    macro("M98P99999999999", "M30"),
    macro("X1234567890.123456789012", "X1.2345"),
    macro("#1=" + "9" * 400, "#1=9"),
    macro("M98P9L1.5|M30|O9|M99", "M98P9L1|M30|O9|M99"),
    macro("G65A1.", "G65P9A1." + SUB),
    macro("GOTO", "GOTO 9|N9 X1."),
    macro("X", "X1."),
    macro("X SIN[30]", "X[SIN[30]]"),
    macro("M98PSIN[1]", "M30"),
    macro("M[1.5]", "M9"),
    macro("G65P9A" + SUB, "G65P9A1." + SUB),
    macro("G65PA1." + SUB, "G65P9A1." + SUB),
    macro("X[[1]", "X[1]"),
    macro("END2", "M30"),
    macro("M198", "M30"),
]
SHAPE = "G1 Y60.|X-60.|Y-60.|X60.|Y60.|X0."
POCKET_TOOL = {"offsets": {**offsets(), "D1": {"R": 5.0}}}


def pocket(
    old: str = "", new: str = "", then: str = "", before: str = "", turned: str = "", **options
) -> Case:
    """G150 with a fault: something else in its block, in its shape, or before it."""
    block = "G150 P7 X0. Y0. Z-2. Q3. R1. J8. K.2 G41 D1 F99."
    whole = "G90 G54 G0 X0. Y0. Z5.|{}{}|G40 G1 X0. Y0.|G0 Z5.|M30|O7|{}|M99|"
    good = whole.format("", block, SHAPE)
    assert old in good
    wrong = whole.format(before, block, turned or SHAPE).replace(old, new)
    return Case("haas", wrong, good, then, how={**WRITE, **POCKET_TOOL, **options})


HAAS_POCKETS = [
    pocket("|X-60.|", "|X#1|"),
    pocket("|X-60.|", "|X-60.|" + "Y59.|Y60.|" * 20),
    pocket("J8.", "J11."),
    pocket("Q3.", "Q0."),
    pocket(before="G91 "),
    pocket(before="G18 "),
    pocket("J8.", "I8. J8."),
    pocket(before="G1 G41 D1 X1. F99.|"),
    pocket("Q3.", ""),
    pocket("G41 D1", "D1"),
    pocket("P7", ""),
    pocket("|X-60.|", "|G3 X-60. I-20.|G1|"),
    pocket(turned="G1 X60. Y60.|X-60.|Y-60.|X60.|Y60."),
    pocket("|X0.|M99", "|X5.|M99"),
    pocket("|X0.|M99", "|X0.|G91|M99"),
    pocket("D1", ""),
    pocket("G41 D1", "G42 D1"),
    pocket("K.2", "K70."),
    pocket("D1", "D900"),
    pocket("P7", "P8"),
]
ALL = [
    *HAAS_POCKETS,
    *MORE,
    *TURNING,
    *DRAWN,
    *BEHIND,
    *BOLTS,
    *HAAS_LATHE,
    *FAGOR,
    *OKUMA,
    *OKUMA_LATHE,
    *DIRECTIONS,
    *POCKETS,
    *DRILLING,
    *FRAMES,
    *CURVES,
    *MACROS,
]
