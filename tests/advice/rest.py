"""Sentences that the other files do not provoke: poles, splines, shapes of LinuxCNC's lathes."""

from __future__ import annotations

from tests.advice.follow import WRITE, Case
from tests.advice.written_fanuc import nurbs


def pole(before: str, after: str, then: str = "") -> Case:
    head = "%9 G71 *|N1 G90 G0 X0 Y0 Z5*|"
    return Case("heidenhain-iso", head + before, head + after, then, how=WRITE)


def linuxcnc(before: str, after: str, then: str = "", **options) -> Case:
    head = "G21 G90 G0 X0 Y0 Z5|F100|"
    return Case("linuxcnc", head + before, head + after, then, how=WRITE, **options)


def shape(lines: str, cycle: str) -> str:
    return f"G18 G8|o100 sub|{lines}|o100 endsub|G0 X20 Z5|{cycle}"


SET = "N2 I+5 J+0*|"
POLE = [
    pole(SET + "N3 G91*|N4 G11 R9 H30 F99*", SET + "N4 G11 R9 H30 F99*"),
    pole("N4 G11 R9 H30 F99*", SET + "N4 G11 R9 H30 F99*"),
    pole(SET + "N4 G11 R9 X5 F99*", SET + "N4 G11 R9 H5 F99*"),
    pole(SET + "N4 G13 H90 X5 F99*", SET + "N4 G13 H90 F99*"),
    pole(SET + "N4 G91 G13 H-90 F99*", SET + "N4 G91 G12 H-90 F99*"),
    pole("N4 G2 X10 Y0 F99*", SET + "N4 G2 X10 Y0 F99*"),
    pole(SET + "N4 G2 X12 Y0 F99*", SET + "N4 G2 X10 Y0 F99*"),
    pole(SET + "N4 G2 X10 Y0 R2 F99*", SET + "N4 G2 X10 Y0 F99*"),
]
CORNER = "N3 G1 X20 F99*|N4 G25 R5*|N5 Y30*"
ISO_CORNERS = [
    pole(CORNER.replace("R5", "L9"), CORNER),
    pole(CORNER.replace("N3 G1", "N3 G0").replace("N5", "N5 G1 F99"), CORNER),
    pole("N2 G91*|" + CORNER, CORNER),
    pole(CORNER + "|N6 G98 L1*|N7 X9*|N8 L1,2*", CORNER),
    pole(CORNER.replace("R5", "R5 F9").replace(" F99", ""), CORNER),
    pole(CORNER.replace("R5", "R50"), CORNER),
    pole(CORNER.replace("N5 Y30", "N5 X0"), CORNER),
    pole("N2 G91*|N3 G54 X5*|N4 G90 G0 X5 Y5*", "N3 G54 X5*|N4 G90 G0 X5 Y5*"),
]
SPLINES = [
    nurbs("K0. X5. Y5. R1.", "K0. R1."),
    nurbs("|K1.|K1.|K1.", "|K1. P3|K1.|K1."),
    nurbs("K0. X5. Y0. R.70710678|", "K0. X5. Y0. R.70710678|K0. X5. Y1. R1.|K0. X5. Y2. R1.|"),
]
ROUND = "G0 X10|G1 Z-5|X15 Z-9|X20"
SHAPES = [
    linuxcnc(shape("G0 X10|G1 Z-5|Z-9", "G71 Q100 D1 I1 R.5"), shape(ROUND, "G71 Q100 D1 I1 R.5")),
    linuxcnc(
        shape("G0 X10|G1 Z-5|X15 Z-9 A20|X20", "G71 Q100 I1 R.5"), shape(ROUND, "G71 Q100 I1 R.5")
    ),
    linuxcnc(shape("G0 X10|G1 Z-5 A1 C1|X20", "G71 Q100 I1 R.5"), shape(ROUND, "G71 Q100 I1 R.5")),
    linuxcnc(shape("G0 X10|G1 Z-5|U20", "G71 Q100 I1 R.5"), shape(ROUND, "G71 Q100 I1 R.5")),
    linuxcnc(
        shape("G0 X10|G1 Z-5|X15 Z-3|X20 Z-9", "G71 Q100 I1 R.5"), shape(ROUND, "G71 Q100 I1 R.5")
    ),
    linuxcnc(shape("G0 X10|G1 Z-5|X15 Z-3|X9", "G70 Q100 P2"), shape(ROUND, "G70 Q100 P2")),
    linuxcnc(shape("G0 X10|G1 Z-5|Z-9", "G70 Q100 E1"), shape(ROUND, "G70 Q100 E1")),
    linuxcnc(shape(ROUND, "G72.2 Q100 I1 R.5"), shape(ROUND, "G72 Q100 I1 R.5")),
    linuxcnc(shape("G0 X20|X20", "G70 Q100"), shape(ROUND, "G70 Q100")),
]
HEAD = "G21 G90 G0 X0 Y0 Z5|F100|"
TURNED = "G90 G0 X0 Y0 Z5|F100|"
OTHERS = [
    Case(
        "haas", "G90 G54 G0 X5. Y0 Z5.|G101 X0|G47 P0 (A) X5. Y5. R1. Z-.1 F9. E9.|G100 X0",
        "G90 G54 G0 X5. Y0 Z5.|G47 P0 (A) X5. Y5. R1. Z-.1 F9. E9.", how=WRITE,
    ),
    Case("linuxcnc", HEAD + "G93 G1 X1 F#<_hal[a]>", HEAD + "G94 G1 X1 F#<_hal[a]>"),
    Case("grblhal", HEAD + "M70|G1 X5|M72|G1 X9", HEAD + "G1 X5|G1 X9", how=WRITE),
    Case(
        "siemens", TURNED + "ROT Z30|G0 X1 Y1|G2 X5 Y5 I=AC(5) J=AC(1)",
        TURNED + "G0 X1 Y1|G2 X5 Y5 I4 J0", how=WRITE,
    ),
    Case(
        "siemens", TURNED + "MIRROR RPL=30", TURNED + "ROT RPL=30|G0 X5 Y5|ROT|G0 X1 Y1", how=WRITE
    ),
    linuxcnc("G83 Z-900 R2 Q.00001", "G83 Z-9 R2 Q1|G80"),
]  # fmt: skip
ALL = [*ISO_CORNERS, *POLE, *SPLINES, *SHAPES, *OTHERS]
