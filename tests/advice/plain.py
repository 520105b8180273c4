"""Sentences on the text, its words, shifts, holes, and the map."""

from __future__ import annotations

from tests.advice.follow import NOWHERE, WRITE, Case

LATHE = "G90 G21 G18|G0 X20. Z10.|"
MILL = "G90 G17|G0 X10. Y10. Z10.|"
L, M, C, S = "fanuc-lathe", "fanuc-mill", "linuxcnc", "siemens"
LONG = {"G54": dict.fromkeys("XYZABC", 0.0), "H1": {"Z": 10.0}, "H2": {"Z": 20.0}}
TEN = {"G54": dict.fromkeys("XYZABC", 0.0)}


def lathe(before: str, after: str, then: str = "", **options) -> Case:
    return Case(L, LATHE + before, LATHE + after, then, **options)


def mill(dialect: str, before: str, after: str, then: str = "", **options) -> Case:
    head = MILL.replace(" ", "|", 1) if dialect == "marlin" else MILL
    return Case(dialect, head + before, head + after, then, **options)


TEXT = [
    Case("klipper", "G90|G1 X1 Y1 Z1|G1 X2 //abc", "G90|G1 X1 Y1 Z1|G1 X2 ;abc"),
    lathe("G1 X30. %", "G1 X30.|%"),
    mill("grbl", "%update|G1 X5 F9", "G1 X5 F9"),
    lathe("G1 Z30. )", "G1 Z30."),
    lathe("T2W202|G1 Z30.", "T0202|G1 Z30.", how={"offsets": {"T0002": {}, "T0202": {}}}),
    lathe("G1 Z30./F10", "/G1 Z30. F10"),
    mill(
        C,
        "o100 sub|G1 X1 F9|o100 endsub|o100 call|M2",
        "o100 sub|G1 X1 F9|o100 endsub|o100 call|M2",
        also=WRITE,
    ),
    mill(
        S,
        "GROOVE(7)|G0 X1 Y1 Z5",
        "GROOVE(7)|G0 X1 Y1 Z5",
        also={**WRITE, "library": {"GROOVE": "PROC GROOVE(REAL aa)|G1 X=aa F100|M17"}},
    ),
    mill("grbl", "o100 sub|G1 X1 F9|o100 endsub|o100 call", "G1 X1 F9"),
    lathe("G1 X30.\rG1 Z30. F10", "G1 X30.\r|G1 Z30. F10"),
    lathe("G1 Z3(c)0.", "G1 Z30. (c)"),
    lathe("G1 Z3\0", "G1 Z3"),
    lathe("G1 Z3\xe9", "G1 Z3 (\xe9)"),
    lathe("(GCOMP 0.1.0 STUDER-S36 MAP 78639B0E TOL 0.5 UM)|G1 X30.", "G1 X30."),
    lathe("(" + "a" * 1_000_001 + ")|G1 X30.", "(" + "a" * 999 + ")|G1 X30."),
    Case(L, "\xef\xbb\xbfG0 X20. Z10.", "G0 X20. Z10."),
    Case(L, "\xff\xfeG\x000\x00 \x00X\x002\x000\x00.\x00", "G0 X20."),
]
WORDS = [
    mill(M, "G43 G0 Z5.", "G43 H1 G0 Z5.", how={"offsets": LONG}),
    lathe("G1 W1. Z3.", "G1 Z3."),
    lathe("G1 Z30. I5.", "G1 Z30."),
    lathe("G1 X9999999.", "G1 X99.99999"),
    mill(M, "G38 X3.", "G0 X3."),
    lathe("M98 P2000|M30|O2000|G1 Z20. F9|M99", "M98 P2000|M30|O2000|G1 Z20. F9|M99", also=WRITE),
    mill(
        M,
        "G68 X0. Y0. R30.|G1 X30. Y5. F10|G69",
        "G68 X0. Y0. R30.|G1 X30. Y5. F10|G69|G0 X1. Y1.",
        also=WRITE,
    ),
    mill(C, "G4 X1.", "G4 P1."),
    lathe("G91 G53 X0", "G90 G53 X0"),
    lathe("G93 G1 X30. Z60.", "G93 G1 X30. Z60. F2"),
    lathe("G3 Z30. X20. K10. P2", "G3 Z30. X20. K10."),
    lathe("G3 X40. Z30. R5. F100", "G3 X40. Z30. R25. F100"),
    lathe("G3 X30. Z20. J3. K2.", "G3 X40. Z20. I0. K10."),
    lathe("G3 X20. Z10. R5.", "G3 X20. Z10. K5."),
    lathe("G17 G3 X30. I3.", "G18 G3 X40. Z20. I0. K10."),
    lathe("G3 X20. Z10. I0. K0.", "G3 X20. Z10. I0. K5."),
    lathe("G3 X40. Z20. I0. K10. R10.", "G3 X40. Z20. R10."),
    lathe("G3 X40. Z30. F100", "G3 X40. Z30. R25. F100"),
    Case(C, "X20. Y1. Z1.", "G0 X20. Y1. Z1."),
    lathe(
        "G3 X40. Z20. I10. K20. F100", "G3 X40. Z20. I10. K20. F100", also={"centre": "absolute"}
    ),
    lathe("G3 X40. Z30. I0. K10. F100", "G3 X40. Z20. I0. K10. F100"),
    mill(M, "G1 X5. E5. F9", "G1 X5. F9"),
    mill(C, "G1 X5. E5. F9", "G1 X5. F9"),
    mill(C, "G1 X5. U5. F9", "G1 X5. F9"),
    mill(C, "G2 X20. Y10. I5. P1.5", "G2 X20. Y10. I5. P2"),
    lathe("G1 X20. X30.", "G1 X30."),
    mill(C, "G0 G1 X20. F9", "G1 X20. F9"),
    mill(C, "G4 P1 G2 X20. I5. F9", "G4 P1|G2 X20. I5. F9"),
    mill(C, "G2 X20. I5. P2000000 F9", "G2 X20. I5. P20 F9"),
    Case(
        C,
        "G2 X20. Y10. I5. J0. F9",
        "G0 X10. Y10. Z0.|G2 X20. Y10. I5. J0. F9",
        how={"start": NOWHERE},
    ),
    Case(C, "G2 X20. Y0. I10. J0. F9", "G2 X20. Y0. I10. J0. F9", first={"start": NOWHERE}),
    lathe("G53 U1. Z5.", "G53 X1. Z5."),
    mill(S, "TRANS X5|G91 G1 X3 F9", "TRANS X5|G90 G1 X13 F9"),
    mill("reprap", "G1 X5|X7", "G1 X5|G1 X7"),
    mill("marlin", "G90 G1 X5", "G90|G1 X5"),
    mill(S, "G1 X5 X=IC(3) F9", "G1 X8 F9"),
    mill(S, "G2 X20 Y10 I5 I=AC(15) J0 F9", "G2 X20 Y10 I=AC(15) J0 F9"),
]
SHIFTS = [
    mill(C, "G0 G43.1 Z5.", "G43.1 Z5.|G0 Z10."),
    Case(L, "G92 X0 Z0|G1 Z30. F10", "G92 X0 Z0|G1 Z30. F10", first={"start": NOWHERE}),
    mill(C, "G10 L2 P1 R3.|G1 X30. Y5. F10", "G10 L2 P1 R3.|G1 X30. Y5. F10", also=WRITE),
    lathe("G10 P1 X1.|G1 Z30. F10", "G1 Z30. F10"),
    mill(C, "G43|G1 X20. F9", "G43 H1|G1 X20. F9"),
    mill(C, "G43|G1 X20. F9", "T1 M6|G43|G0 X1. Y1. Z9.|G1 X20. F9"),
    lathe("G55|G1 Z30. F10", "G55|G1 Z30. F10", first={"offsets": TEN}),
    mill(C, "G43 H1|G1 X30. F10", "G43 H1|G1 X30. F10", first={"offsets": TEN}),
    mill(S, "T1 D1|G1 X30 F10", "T1 D1|G1 X30 F10", first={"offsets": TEN}),
    mill(M, "G10 L3 P1 X1.|G1 X30. F10", "G1 X30. F10"),
    Case(
        C,
        "G10 L20 P1 X0.|G0 X30. Y1. Z1.",
        "G10 L20 P1 X0.|G0 X30. Y1. Z1.",
        first={"start": NOWHERE},
    ),
    mill(C, "G10 L2 P12 X0.|G1 X30. F9", "G10 L2 P2 X0.|G1 X30. F9"),
    lathe(
        "T2|G1 X30. F9",
        "T2|G1 X30. F9",
        first={"offsets": TEN},
        also={"offsets": {**TEN, "T0002": {}}},
    ),
    mill(M, "G54.1 P1.5|G1 X30. F9", "G54.1 P2|G1 X30. F9"),
    mill("mach3", "G59 P7|G1 X30. F9", "G59|G1 X30. F9"),
    mill(
        C, "G43 H1|G20|G43 H2|G1 X3. F9", "G43 H1|G49|G20|G43 H2|G1 X3. F9", how={"offsets": LONG}
    ),
    mill(
        M,
        "G43 H1 Z9.|G91 G28 Z0|G90|G1 X30. Z5. F9",
        "G43 H1 Z9.|G91 G28 Z0|G90|G43 H1 G1 X30. Z5. F9",
        how={"offsets": LONG},
    ),
    mill(S, "T7|D1|G1 X30 F10", "T7|D1|G1 X30 F10", first={"offsets": TEN}),
    mill(C, "G43.1 C5.|G53 G0 X1.", "G43.1 C5.|G49|G53 G0 X1."),
]
HOLE = "M3 S500|G0 Z10.|"
HOLES = [
    mill(M, "G98 G81 X5. Y5. Z-5. R12. F9|G80", "G99 G81 X5. Y5. Z-5. R12. F9|G80"),
    mill("haas", "G81 X5. Y5. Z-5. R5. K3 F9|G80", "G81 X5. Y5. Z-5. R5. F9|G80"),
    Case(
        C,
        "G18 G0 X1. Z9.|G81 X2. Z5. R2. F9",
        "G18 G0 X1. Z9.|G81 X2. Z5. R2. F9",
        "begins without Y",
        also=WRITE,
        how={"lathe": 1},
    ),
    mill(
        M,
        HOLE + "G81 X11. Z4. R6. F9|G18|X12.",
        HOLE + "G81 X11. Z4. R6. F9|G18|X12.|G80",
        also=WRITE,
    ),
    mill(C, HOLE + "G33.1 X11. Z-40. K1.", HOLE + "G0 X11.|G33.1 Z-40. K1."),
    mill(M, HOLE + "G81 X11. Z-140. R2. F9", HOLE + "G81 X11. Z-140. R2. F9|G80", also=WRITE),
    mill(
        M,
        HOLE + "G81 X11. Z-140. R2. F9",
        HOLE + "G81 X11. Z-140. R2. F9|G80",
        also={"hole_um": 50.0},
    ),
    mill(
        M,
        HOLE + "G81 X11. Z-4. R2. F9 L0|X12.",
        HOLE + "G81 X11. Z-4. R2. F9 L0|X12.|G80",
        also=WRITE,
    ),
    mill(
        M,
        HOLE + "G81 X11. Z-4. R2. F9 K0|X12.",
        HOLE + "G81 X11. Z-4. R2. F9 K0|X12.|G80",
        also=WRITE,
    ),
    mill(
        M,
        HOLE + "G81 Z-4. R2. F9 L0|X12.",
        HOLE + "G81 X11. Z-4. R2. F9|X12.|G80",
        also=WRITE,
    ),
    mill(M, HOLE + "G81 X11. R2. F9", HOLE + "G81 X11. Z-4. R2. F9|G80"),
    mill(C, HOLE + "G81 X11. Z-4. F9", HOLE + "G81 X11. Z-4. R2. F9|G80"),
    mill(
        M,
        HOLE + "G91 G81 X1. Z-4. R-2. F9 K3",
        HOLE + "G91 G81 X1. Z-4. R-2. F9 K3|G80",
        also=WRITE,
    ),
    mill(
        C,
        HOLE + "G91 G81 X1. Z-4. R-2. F9 L3",
        HOLE + "G91 G81 X1. Z-4. R-2. F9 L3|G80",
        also=WRITE,
    ),
    mill(
        M,
        HOLE + "G91 G99 G81 X1. Z-4. R-2. F9|X1.",
        HOLE + "G91 G99 G81 X1. Z-4. R-2. F9|X1.|G80",
        also=WRITE,
    ),
    mill(C, HOLE + "G81 X120. Y120. Z5. R5.001 F9", HOLE + "G81 X120. Y120. Z5. R6. F9|G80"),
    mill(M, HOLE + "G81 X11. Z4. R2. F9", HOLE + "G81 X11. Z4. R2. F9|G80", also=WRITE),
    *[
        mill(name, HOLE + before, HOLE + "G0 X11.|Z2.|G1 Z-4. F9|G0 Z10.")
        for name in ("grblhal", "mach3")
        for before in (
            "G91 G81 X1. Z-4. R-2. F9 L3",
            "G91 G99 G81 X1. Z-4. R-2. F9|X1.",
        )
    ],
    mill(
        "grblhal",
        HOLE + "G81 X11. Z-140. R2. F9",
        HOLE + "G81 X11. Z-140. R2. F9|G80",
        also={"hole_um": 50.0},
    ),
]
MAP = [
    Case(
        "siemens",
        "G0 X10 Y10 Z5|L140(2)",
        "G0 X10 Y10 Z5|L140(2)",
        "is neither a command",
        also=WRITE,
    ),
    mill(C, "G0 X3010.", "G0 X2990."),
    mill(C, "G0 X3010.", "G0 X3010.", also={"outside": "clamp"}),
    mill(C, "G0 X3200.", "G0 X2990.", how={"outside": "clamp"}),
    Case(L, "G1 X20. F100", "G1 X20. F100", first={"start": NOWHERE}),
    Case(L, "G1 X20. F100", "G0 X20. Z5.|G1 X30. F100", how={"start": NOWHERE}),
    Case(
        M,
        "G0 X10. Y10. Z0. A0. C0.|G2 X20. I5. C90. F9",
        "G0 X10. Y10. Z0. A0. C0.|G1 X15. Y15. C45. F9|X20. Y10. C90.",
        how={"machine": "example-five-axis"},
    ),
    Case(
        C,
        "G0 X100. Y100. Z0. A0.|G1 C90. F360",
        "G0 X100. Y100. Z0. A0. C0.|G1 C90. F360",
        how={"machine": "example-five-axis", "start": NOWHERE},
    ),
    Case(
        C,
        "G0 X100. Y100. Z0. A0. C0.|G1 C90. F#<_hal[feed]>",
        "G0 X100. Y100. Z0. A0. C0.|G1 C90. F360",
        how={"machine": "example-five-axis"},
    ),
    mill(
        C,
        "G0 X3095. Y0.|G3 X3095. Y30. J15. F9",
        "G0 X2990. Y0.|G3 X2990. Y30. J15. F9",
        how={"outside": "clamp"},
    ),
]
ALL = [*TEXT, *WORDS, *SHIFTS, *HOLES, *MAP]
